// SPDX-License-Identifier: LGPL-2.1-or-later
// The bodies of refine(), perturb() and exude(), included only where they are instantiated.
#pragma once
#include <CGAL/Mesh_3/Mesher_3.h>
#include <CGAL/exude_mesh_3.h>
#include <CGAL/perturb_mesh_3.h>

#include "tools/mesh/meshing/cgal_mesh.h"

namespace stroma::meshing {

/// CGAL's refine_mesh_3() without its optimisers: they are instantiated there even where none is asked for. Mesher_3 is
/// not documented; this is what refine_mesh_3() of CGAL 5.5 does with it.
template <class Complex, class Domain, class Criteria>
void refine(Complex& complex, const Domain& domain, const Criteria& criteria) {
  CGAL::Mesh_3::Mesher_3<Complex, Criteria, Domain>(complex, domain, criteria).refine_mesh();
  complex.clear_manifold_info();
}

template <class Complex, class Domain>
void perturb(Complex& complex, const Domain& domain, double bound) {
  CGAL::perturb_mesh_3(complex, domain, CGAL::parameters::sliver_bound = bound, CGAL::parameters::time_limit = 0);
}

template <class Complex>
void exude(Complex& complex, double bound) {
  CGAL::exude_mesh_3(complex, CGAL::parameters::sliver_bound = bound, CGAL::parameters::time_limit = 0);
}

}  // namespace stroma::meshing
