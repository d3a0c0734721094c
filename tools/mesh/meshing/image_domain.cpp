// SPDX-License-Identifier: LGPL-2.1-or-later
// A segmented image as a domain of CGAL's Mesh_3: every region meshed by Delaunay refinement (Oudot, Rineau and Yvinec
// 2005; Boltcheva, Yvinec and Boissonnat 2009 for several regions), neighbours sharing the triangles between them.
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "framework/scene/diagnostics.h"
#include "tools/mesh/meshing/mesher.h"

namespace stroma::meshing {
namespace {

RegionSizes sizesOf(const LabelImage& image, const MeshCriteria& criteria) {
  RegionSizes sizes;
  sizes.of_region.push_back(std::numeric_limits<double>::infinity());
  for (const int label : image.values) sizes.of_region.push_back(criteria.sizeOf(label));
  sizes.facet = criteria.facet_size;
  return sizes;
}

void requireAllLabels(const LabelledMesh& mesh, const LabelImage& image) {
  const std::vector<long> voxels = image.voxels();
  for (std::size_t i = 0; i < image.values.size(); ++i)
    if (std::find(mesh.labels.begin(), mesh.labels.end(), image.values[i]) == mesh.labels.end())
      throw ComponentError(fmt::format("no cell of the mesh has label {} ({} voxels): it is too thin or too small for "
                                       "the cells",
                                       image.values[i], voxels[i]),
                           "a smaller cell size for it, or an image without it");
}

}  // namespace

LabelledMesh meshImage(const LabelImage& image, const MeshCriteria& criteria) {
  const LabelField field(image);
  LabelledMesh mesh = meshField(field, 1e-3 * image.smallestSpacing(), sizesOf(image, criteria), criteria);
  for (int& label : mesh.labels) label = image.values[std::size_t(label) - 1];
  requireAllLabels(mesh, image);
  return mesh;
}

}  // namespace stroma::meshing
