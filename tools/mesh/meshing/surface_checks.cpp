// SPDX-License-Identifier: LGPL-2.1-or-later
// A soup of triangles made into a closed surface, or refused with what is wrong with it.
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/boost/graph/helpers.h>
#include <fmt/format.h>

#include "framework/scene/diagnostics.h"
#include "tools/mesh/meshing/surface_mesh.h"

namespace stroma::meshing {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;

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

}  // namespace

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

}  // namespace stroma::meshing
