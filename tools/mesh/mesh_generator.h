// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <string>
#include <vector>

#include "tools/mesh/label_image.h"
#include "tools/mesh/regions.h"

namespace stroma {

/// What a mesh must satisfy. Lengths are in the unit of what is meshed.
struct MeshCriteria {
  double cell_size = 0;              ///< largest circumradius of a tetrahedron
  std::map<int, double> label_size;  ///< the same for the cells of one label, instead of cell_size
  double facet_size = 0;             ///< largest circumradius of a boundary triangle; 0: the cell size of its regions
  double distance = 0;               ///< largest distance of the centre of a boundary triangle from the surface
  double facet_angle = 25;           ///< smallest angle of a boundary triangle [degrees], at most 30
  double dihedral_angle = 10;  ///< cells with a smaller dihedral angle [degrees] are worked on; 0.82 of it must do
  double feature_angle = 60;   ///< surfaces: edges bent by more [degrees] are kept as edges
  bool keep_volume = true;     ///< images: move boundaries so that each label has its voxels' volume

  double sizeOf(int label) const {
    const auto own = label_size.find(label);
    return own == label_size.end() ? cell_size : own->second;
  }
};

/// Fills a body with tetrahedra; in a library of its own because it is built on CGAL, which is slow to compile and
/// partly under the GPL. The same input gives the same mesh, bit for bit.
class MeshGenerator {
 public:
  static constexpr const char *role = "mesh generator", *library = "meshing",
                              *missing = "install libcgal-dev, configure again and build the target meshing";
  virtual ~MeshGenerator() = default;
  /// The body of an image; the boundary between two labels lies half way between their voxels. Throws ComponentError.
  /// `match` is what the match of volumes came to, where criteria.keep_volume asks for it.
  virtual LabelledMesh fromImage(const LabelImage& image, const MeshCriteria& criteria, VolumeMatch& match) const = 0;
  /// The inside of a closed surface, with label 1. Throws ComponentError when it is not closed or cuts itself.
  virtual LabelledMesh fromSurface(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles,
                                   const MeshCriteria& criteria) const = 0;
};

}  // namespace stroma
