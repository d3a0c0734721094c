// SPDX-License-Identifier: LGPL-2.1-or-later
// What the two domains share: from a domain, criteria and first points to a mesh whose slivers have been worked on. Each
// stage of Mesh_3 takes a compiler 10 to 20 s for a domain, so each is instantiated in a source of its own.
#pragma once
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Random.h>

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

/// Delaunay refinement from the first points that the complex has until all cells and triangles meet the criteria; see
/// mesh_stages.h.
template <class Complex, class Domain, class Criteria>
void refine(Complex& complex, const Domain& domain, const Criteria& criteria);
/// Moves vertices until no dihedral angle is below `bound` [degrees] or nothing helps any more.
template <class Complex, class Domain>
void perturb(Complex& complex, const Domain& domain, double bound);
/// The same by the weights of the vertices. It must come last.
template <class Complex>
void exude(Complex& complex, double bound);

/// Perturbs, then exudes, until no dihedral angle is below `aim` [degrees] or nothing helps any more. Both aim higher when
/// angles are left that are poor, at most twice; the best mesh is the result.
template <class Complex, class Domain, class LabelOf>
LabelledMesh withoutSlivers(Complex& complex, const Domain& domain, double aim, LabelOf&& label_of) {
  const double poor = least_share * aim;
  LabelledMesh best;
  double best_angle = -1;
  for (int attempt = 0; attempt < 3 && best_angle < poor; ++attempt) {
    const double bound = aim + 2 * attempt;
    perturb(complex, domain, bound);
    Complex weighted = complex;
    exude(weighted, bound);
    LabelledMesh mesh = toLabelledMesh(weighted, label_of);
    if (mesh.tetrahedra.empty()) return mesh;
    if (const double angle = qualityOf(mesh).smallest_angle; angle > best_angle)
      best = std::move(mesh), best_angle = angle;
  }
  return best;
}

}  // namespace stroma::meshing
