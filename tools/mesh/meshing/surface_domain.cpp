// SPDX-License-Identifier: LGPL-2.1-or-later
// A closed surface of triangles as a domain of CGAL's Mesh_3. A point is inside when a ray from it crosses the surface
// an odd number of times, so a closed surface inside of another one is a hollow.
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polyhedral_mesh_domain_with_features_3.h>
#include <CGAL/boost/graph/helpers.h>
#include <CGAL/make_mesh_3.h>
#include <fmt/format.h>

#include "framework/scene/diagnostics.h"
#include "tools/mesh/meshing/cgal_mesh.h"
#include "tools/mesh/meshing/domains.h"

namespace stroma::meshing {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;

using Surface = CGAL::Mesh_polyhedron_3<Kernel>::type;
using Domain = CGAL::Polyhedral_mesh_domain_with_features_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain, CGAL::Default, CGAL::Sequential_tag>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation, Domain::Corner_index, Domain::Curve_index>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

struct Soup {
  std::vector<Point> points;
  std::vector<std::vector<std::size_t>> triangles;
};

/// Nodes in one place become one, because files repeat them along seams; triangles that lose an edge by it are left
/// out.
Soup mergedSoup(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles) {
  Soup soup;
  std::map<std::array<double, 3>, std::size_t> number;
  std::vector<std::size_t> merged;
  for (const Vec3& p : position) {
    const auto [entry, is_new] = number.try_emplace({p.x(), p.y(), p.z()}, soup.points.size());
    if (is_new) soup.points.emplace_back(p.x(), p.y(), p.z());
    merged.push_back(entry->second);
  }
  for (const Triangle& t : triangles) {
    const std::vector<std::size_t> n{merged[t[0]], merged[t[1]], merged[t[2]]};
    if (n[0] != n[1] && n[1] != n[2] && n[2] != n[0]) soup.triangles.push_back(n);
  }
  return soup;
}

Surface checkedSurface(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles) {
  Soup soup = mergedSoup(position, triangles);
  if (!pmp::orient_polygon_soup(soup.points, soup.triangles))
    throw ComponentError(
        "the surface branches: more than two triangles meet at an edge, or it cannot be turned outward",
        "a closed surface with two triangles at each edge");
  Surface surface;
  pmp::polygon_soup_to_polygon_mesh(soup.points, soup.triangles, surface);
  std::size_t open = 0;
  for (const auto h : CGAL::halfedges(surface)) open += CGAL::is_border(h, surface);
  if (open > 0)
    throw ComponentError(fmt::format("the surface is open: {} of its edges have one triangle only", open),
                         "a closed surface");
  std::vector<std::pair<Surface::Facet_handle, Surface::Facet_handle>> crossing;
  pmp::self_intersections(surface, std::back_inserter(crossing));
  if (!crossing.empty()) {
    const Point p = crossing[0].first->halfedge()->vertex()->point();
    throw ComponentError(
        fmt::format("the surface cuts itself: {} pairs of triangles, the first near {:.6g} {:.6g} {:.6g}",
                    crossing.size(), p.x(), p.y(), p.z()),
        "a surface without intersections, or --voxels SIZE, which fills voxels first");
  }
  return surface;
}

}  // namespace

LabelledMesh meshSurface(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles,
                         const MeshCriteria& criteria) {
  namespace par = CGAL::parameters;
  CGAL::get_default_random() = CGAL::Random(0);  // the same mesh each time
  const Surface surface = checkedSurface(position, triangles);
  Domain domain(surface);
  domain.detect_features(criteria.feature_angle);
  const double cell = criteria.sizeOf(1), facet = criteria.facet_size > 0 ? criteria.facet_size : cell;
  const Criteria rules(par::edge_size = facet, par::facet_angle = criteria.facet_angle, par::facet_size = facet,
                       par::facet_distance = criteria.distance, par::cell_radius_edge_ratio = 2.,
                       par::cell_size = cell);
  Complex complex = CGAL::make_mesh_3<Complex>(domain, rules, par::no_perturb(), par::no_exude());
  LabelledMesh mesh = withoutSlivers(complex, domain, criteria.dihedral_angle, [](const auto&) { return 1; });
  if (mesh.tetrahedra.empty()) throw ComponentError("no cell fits into the surface", "a smaller cell size or distance");
  return mesh;
}

}  // namespace stroma::meshing
