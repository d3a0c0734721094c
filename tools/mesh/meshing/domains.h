// SPDX-License-Identifier: LGPL-2.1-or-later
// The two kinds of domain, each in a translation unit of its own.
#pragma once
#include "tools/mesh/mesh_generator.h"

namespace stroma::meshing {

/// The smallest dihedral angle that is good enough, as a share of the one that is aimed at.
constexpr double least_share = 0.82;

LabelledMesh meshImage(const LabelImage& image, const MeshCriteria& criteria);
LabelledMesh meshSurface(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles,
                         const MeshCriteria& criteria);

}  // namespace stroma::meshing
