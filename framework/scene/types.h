// SPDX-License-Identifier: LGPL-2.1-or-later
// The vocabulary of sizes: 32-bit indices, double precision, 3-vectors and 3x3 matrices.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace stroma {

static_assert(alignof(Eigen::Vector4d) == 16, "Eigen must be built as the framework was: link stroma::stroma");

using Index = std::int32_t;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// Cells by the indices of their nodes, in the order that Mesh gives: faces counter-clockwise from outside.
using Edge = std::array<Index, 2>;
using Triangle = std::array<Index, 3>;
using Quad = std::array<Index, 4>;
using Tetrahedron = std::array<Index, 4>;
using Hexahedron = std::array<Index, 8>;
using Prism = std::array<Index, 6>;
using Pyramid = std::array<Index, 5>;
/// Corners, then a node on each edge, in VTK's order.
using QuadraticTriangle = std::array<Index, 6>;
using QuadraticTetrahedron = std::array<Index, 10>;

}  // namespace stroma
