// SPDX-License-Identifier: LGPL-2.1-or-later
// The types of Mesh_3 for a closed surface of triangles.
#pragma once
#include <CGAL/Polyhedral_mesh_domain_with_features_3.h>

#include "tools/mesh/meshing/cgal_mesh.h"

namespace stroma::meshing {

using Surface = CGAL::Mesh_polyhedron_3<Kernel>::type;
using SurfaceDomain = CGAL::Polyhedral_mesh_domain_with_features_3<Kernel>;
using SurfaceTriangulation = CGAL::Mesh_triangulation_3<SurfaceDomain, CGAL::Default, CGAL::Sequential_tag>::type;
using SurfaceComplex = CGAL::Mesh_complex_3_in_triangulation_3<SurfaceTriangulation, SurfaceDomain::Corner_index,
                                                               SurfaceDomain::Curve_index>;
using SurfaceCriteria = CGAL::Mesh_criteria_3<SurfaceTriangulation>;

/// Two triangles at each edge, turned outward, and none that cuts another; throws ComponentError.
Surface checkedSurface(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles);

/// The first points of the complex: along the sharp edges of the surface, so that refinement keeps them, and on it.
void protectFeatures(SurfaceComplex& complex, const SurfaceDomain& domain, const SurfaceCriteria& criteria);

extern template void refine(SurfaceComplex&, const SurfaceDomain&, const SurfaceCriteria&);
extern template void perturb(SurfaceComplex&, const SurfaceDomain&, double);
extern template void exude(SurfaceComplex&, double);

}  // namespace stroma::meshing
