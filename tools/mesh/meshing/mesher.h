// SPDX-License-Identifier: LGPL-2.1-or-later
// The two kinds of domain that CGAL's Mesh_3 meshes here: a closed surface, and the regions of an image.
#pragma once
#include <algorithm>

#include "tools/mesh/mesh_generator.h"
#include "tools/mesh/meshing/label_field.h"

namespace stroma::meshing {

/// The smallest dihedral angle that is good enough, as a share of the one that is aimed at.
constexpr double least_share = 0.82;

/// Sizes by region for cells, by pair of regions for boundary triangles.
struct RegionSizes {
  std::vector<double> of_region;  ///< of_region[0] is that of the outside: infinite
  double facet = 0;               ///< for all boundary triangles; 0: the smaller size of the two regions

  double between(int low, int high) const {
    return facet > 0 ? facet : std::min(of_region[std::size_t(low)], of_region[std::size_t(high)]);
  }
  /// Between first points on the boundary of each region.
  std::vector<double> spacing() const {
    std::vector<double> spacing;
    for (const double size : of_region) spacing.push_back(2 * (facet > 0 ? facet : size));
    return spacing;
  }
};

LabelledMesh meshImage(const LabelImage& image, const MeshCriteria& criteria);
LabelledMesh meshSurface(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles,
                         const MeshCriteria& criteria);
/// With the field's numbers of regions as labels; points of boundaries to within `accuracy`, a length.
LabelledMesh meshField(const LabelField& field, double accuracy, const RegionSizes& sizes, const MeshCriteria& criteria);

}  // namespace stroma::meshing
