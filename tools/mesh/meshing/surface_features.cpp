// SPDX-License-Identifier: LGPL-2.1-or-later
#include <CGAL/make_mesh_3.h>

#include "tools/mesh/meshing/surface_mesh.h"

namespace stroma::meshing {

// What make_mesh_3() of CGAL 5.5 does before it refines, with an initializer that is not documented.
void protectFeatures(SurfaceComplex& complex, const SurfaceDomain& domain, const SurfaceCriteria& criteria) {
  CGAL::Mesh_3::internal::C3t3_initializer<SurfaceComplex, SurfaceDomain, SurfaceCriteria, true>()(complex, domain,
                                                                                                   criteria, true);
}

}  // namespace stroma::meshing
