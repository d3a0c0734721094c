// SPDX-License-Identifier: LGPL-2.1-or-later
// A closed surface of triangles as a domain of CGAL's Mesh_3. A point is inside when a ray from it crosses the surface
// an odd number of times, so a closed surface inside of another one is a hollow.
#include <CGAL/Polyhedral_mesh_domain_with_features_3.h>
#include <CGAL/make_mesh_3.h>

#include "framework/scene/diagnostics.h"
#include "tools/mesh/meshing/cgal_mesh.h"
#include "tools/mesh/meshing/surface_mesh.h"

namespace stroma::meshing {
namespace {

using SurfaceDomain = CGAL::Polyhedral_mesh_domain_with_features_3<Kernel>;
using SurfaceTriangulation = CGAL::Mesh_triangulation_3<SurfaceDomain, CGAL::Default, CGAL::Sequential_tag>::type;
using SurfaceComplex = CGAL::Mesh_complex_3_in_triangulation_3<SurfaceTriangulation, SurfaceDomain::Corner_index,
                                                               SurfaceDomain::Curve_index>;
using SurfaceCriteria = CGAL::Mesh_criteria_3<SurfaceTriangulation>;

/// The first points of the complex: along the sharp edges of the surface, so that refinement keeps them, and on it. What
/// make_mesh_3() of CGAL 5.5 does before it refines, with an initializer that is not documented.
void protectFeatures(SurfaceComplex& complex, const SurfaceDomain& domain, const SurfaceCriteria& criteria) {
  CGAL::Mesh_3::internal::C3t3_initializer<SurfaceComplex, SurfaceDomain, SurfaceCriteria, true>()(complex, domain,
                                                                                                   criteria, true);
}

}  // namespace

LabelledMesh meshSurface(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles,
                         const MeshCriteria& criteria) {
  namespace par = CGAL::parameters;
  CGAL::get_default_random() = CGAL::Random(0);  // the same mesh each time
  const Surface surface = checkedSurface(position, triangles);
  SurfaceDomain domain(surface);
  domain.detect_features(criteria.feature_angle);
  const double cell = criteria.sizeOf(1), facet = criteria.facet_size > 0 ? criteria.facet_size : cell;
  const SurfaceCriteria rules(par::edge_size = facet, par::facet_angle = criteria.facet_angle, par::facet_size = facet,
                              par::facet_distance = criteria.distance, par::cell_radius_edge_ratio = 2.,
                              par::cell_size = cell);
  SurfaceComplex complex;
  protectFeatures(complex, domain, rules);
  refine(complex, domain, rules);
  LabelledMesh mesh = withoutSlivers(complex, domain, criteria.dihedral_angle, [](const auto&) { return 1; });
  if (mesh.tetrahedra.empty()) throw ComponentError("no cell fits into the surface", "a smaller cell size or distance");
  return mesh;
}

}  // namespace stroma::meshing
