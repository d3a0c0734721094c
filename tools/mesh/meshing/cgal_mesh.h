// SPDX-License-Identifier: LGPL-2.1-or-later
// What the two domains share: from a domain, criteria and first points to a mesh whose slivers have been worked on.
#pragma once
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_3/Mesher_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Random.h>
#include <CGAL/exude_mesh_3.h>
#include <CGAL/perturb_mesh_3.h>

#include "tools/mesh/mesh_generator.h"
#include "tools/mesh/meshing/domains.h"

namespace stroma::meshing {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

/// The tetrahedra of the complex, nodes in the order in which the cells need them; `label_of` turns CGAL's index of a
/// region into a label.
template <class Complex, class LabelOf>
LabelledMesh toLabelledMesh(const Complex& complex, LabelOf&& label_of) {
  LabelledMesh mesh;
  std::map<typename Complex::Vertex_handle, Index> number;
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
    Tetrahedron nodes;
    for (int i = 0; i < 4; ++i) {
      const auto [entry, is_new] = number.emplace(cell->vertex(i), Index(mesh.position.size()));
      if (is_new) {
        const auto& p = cell->vertex(i)->point();
        mesh.position.emplace_back(CGAL::to_double(p.x()), CGAL::to_double(p.y()), CGAL::to_double(p.z()));
      }
      nodes[i] = entry->second;
    }
    mesh.tetrahedra.push_back(nodes);
    mesh.labels.push_back(label_of(complex.subdomain_index(cell)));
  }
  return mesh;
}

/// Delaunay refinement from the first points that the complex has until all cells and triangles meet the criteria: CGAL's
/// refine_mesh_3() without its optimisers, which are instantiated there even where none is asked for. Mesher_3 is not
/// documented; this is what refine_mesh_3() of CGAL 5.5 does with it.
template <class Complex, class Domain, class Criteria>
void refine(Complex& complex, const Domain& domain, const Criteria& criteria) {
  CGAL::Mesh_3::Mesher_3<Complex, Criteria, Domain>(complex, domain, criteria).refine_mesh();
  complex.clear_manifold_info();
}

/// Perturbs, then exudes, until no dihedral angle is below `aim` [degrees] or nothing helps any more. Both aim higher when
/// angles are left that are poor, at most twice; the best mesh is the result.
template <class Complex, class Domain, class LabelOf>
LabelledMesh withoutSlivers(Complex& complex, const Domain& domain, double aim, LabelOf&& label_of) {
  namespace par = CGAL::parameters;
  const double poor = least_share * aim;
  LabelledMesh best;
  double best_angle = -1;
  for (int attempt = 0; attempt < 3 && best_angle < poor; ++attempt) {
    const double bound = aim + 2 * attempt;
    CGAL::perturb_mesh_3(complex, domain, par::sliver_bound = bound, par::time_limit = 0);
    Complex weighted = complex;
    CGAL::exude_mesh_3(weighted, par::sliver_bound = bound, par::time_limit = 0);  // weighs the vertices: it must come last
    LabelledMesh mesh = toLabelledMesh(weighted, label_of);
    if (mesh.tetrahedra.empty()) return mesh;
    if (const double angle = qualityOf(mesh).smallest_angle; angle > best_angle)
      best = std::move(mesh), best_angle = angle;
  }
  return best;
}

}  // namespace stroma::meshing
