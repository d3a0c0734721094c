// SPDX-License-Identifier: LGPL-2.1-or-later
// A closed surface of triangles as a domain of CGAL's Mesh_3. A point is inside when a ray from it crosses the surface
// an odd number of times, so a closed surface inside of another one is a hollow.
#include "framework/scene/diagnostics.h"
#include "tools/mesh/meshing/domains.h"
#include "tools/mesh/meshing/surface_mesh.h"

namespace stroma::meshing {

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
