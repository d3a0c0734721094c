// SPDX-License-Identifier: LGPL-2.1-or-later
// What the kernels of components/elasticity do for one element. tests/elasticity/test_operations.cpp counts it with a
// number that counts its operations, on elements as the benchmarks deform them.
#pragma once
#include <array>
#include <string_view>

namespace stroma::bench {

/// Operations of a tetrahedron, the sums at its four nodes included.
struct TetrahedronOperations {
  std::string_view method;
  double force, product;
};
constexpr std::array<TetrahedronOperations, 5> tetrahedron_operations{
    {{"small", 136, 134}, {"large", 277, 134}, {"polar", 656.715, 134}, {"svd", 656.715, 134}, {"nodal", 796, 1232}}};
/// More in a force where B, and then the volume too, follow the shape.
constexpr double updated_gradients = 42, updated_volume = 9;
/// Of the energy of a tetrahedron with the method polar.
constexpr double polar_energy = 600.715;

/// The variants of HexahedronFEMForceField that are measured.
enum class HexahedronVariant { polar_boxes, polar_b, green };

/// Operations of a hexahedron, the sums at its eight nodes included, and what it keeps that a force and a product read.
struct HexahedronOperations {
  double force, product;
  double force_bytes, product_bytes;
  bool product_reads_position;
};
/// By HexahedronVariant.
constexpr std::array<HexahedronOperations, 3> hexahedron_operations{
    {{916.92, 526, 144, 120, false}, {2343.92, 1383, 1512, 592, false}, {1447, 2704, 80, 80, true}}};

/// Operations of a tetrahedron of ten nodes with method polar and the warped tangent, likewise.
struct QuadraticOperations {
  double force, product;
  double force_bytes, product_bytes;
};
constexpr QuadraticOperations quadratic_operations{3023.665, 1027, 632, 344};

}  // namespace stroma::bench
