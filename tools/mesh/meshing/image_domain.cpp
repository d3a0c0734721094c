// SPDX-License-Identifier: LGPL-2.1-or-later
// A segmented image as a domain of CGAL's Mesh_3: every region meshed by Delaunay refinement (Oudot, Rineau and Yvinec
// 2005; Boltcheva, Yvinec and Boissonnat 2009 for several regions), neighbours sharing the triangles between them.
#include <CGAL/Labeled_mesh_domain_3.h>
#include <fmt/format.h>

#include "framework/scene/diagnostics.h"
#include "tools/mesh/meshing/cgal_mesh.h"
#include "tools/mesh/meshing/label_field.h"

namespace stroma::meshing {
namespace {

using ImageDomain = CGAL::Labeled_mesh_domain_3<Kernel>;
using ImageTriangulation = CGAL::Mesh_triangulation_3<ImageDomain, CGAL::Default, CGAL::Sequential_tag>::type;
using ImageComplex = CGAL::Mesh_complex_3_in_triangulation_3<ImageTriangulation>;
using ImageCriteria = CGAL::Mesh_criteria_3<ImageTriangulation>;

/// Sizes by region for cells, by pair of regions for boundary triangles.
struct Size {
  using FT = double;
  using Index = ImageDomain::Index;
  std::vector<double> of_region;  ///< of_region[0] is that of the outside: infinite
  double facet = 0;               ///< for all boundary triangles; 0: the smaller size of the two regions

  double operator()(const Point&, int dimension, const Index& index) const {
    if (dimension == 3) return of_region[boost::get<int>(index)];
    const auto [low, high] = boost::get<std::pair<int, int>>(index);
    return facet > 0 ? facet : std::min(of_region[low], of_region[high]);
  }
};

Size sizesOf(const LabelImage& image, const MeshCriteria& criteria) {
  Size size;
  size.of_region.push_back(std::numeric_limits<double>::infinity());
  for (const int label : image.values) size.of_region.push_back(criteria.sizeOf(label));
  size.facet = criteria.facet_size;
  return size;
}

/// First points on every part of every region: refinement finds by itself only what a point already touches.
void insertFirstPoints(ImageComplex& complex, const ImageDomain& domain, const LabelField& field, const Size& size) {
  std::vector<double> spacing;
  for (const double s : size.of_region) spacing.push_back(2 * (size.facet > 0 ? size.facet : s));
  for (const LabelField::BoundaryPoint& point : field.boundaryPoints(spacing)) {
    const Vec3& p = point.position;
    const auto vertex = complex.triangulation().insert(ImageTriangulation::Weighted_point(Point(p.x(), p.y(), p.z())));
    if (vertex == ImageComplex::Vertex_handle()) continue;
    complex.set_dimension(vertex, 2);
    complex.set_index(vertex, domain.index_from_surface_patch_index({point.low, point.high}));
  }
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
  namespace par = CGAL::parameters;
  CGAL::get_default_random() = CGAL::Random(0);  // the same mesh each time
  const LabelField field(image);
  const auto [low, high] = field.box();
  const CGAL::Bbox_3 box(low.x(), low.y(), low.z(), high.x(), high.y(), high.z());
  const double accuracy = 1e-3 * image.smallestSpacing() / ((high - low).norm() / 2);
  const auto label = [&field](const Point& p) { return field.at(Vec3(p.x(), p.y(), p.z())); };
  const ImageDomain domain(label, box, par::relative_error_bound = accuracy);
  const Size size = sizesOf(image, criteria);
  const ImageCriteria rules(par::facet_angle = criteria.facet_angle, par::facet_size = size,
                            par::facet_distance = criteria.distance, par::cell_radius_edge_ratio = 2.,
                            par::cell_size = size);
  ImageComplex complex;
  insertFirstPoints(complex, domain, field, size);
  refine(complex, domain, rules);
  LabelledMesh mesh = withoutSlivers(complex, domain, criteria.dihedral_angle,
                                     [&image](int region) { return image.values[region - 1]; });
  requireAllLabels(mesh, image);
  return mesh;
}

}  // namespace stroma::meshing
