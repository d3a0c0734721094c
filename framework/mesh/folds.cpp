// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mesh/folds.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "framework/mesh/cell_faces.h"

namespace stroma {
namespace {

using Positions = std::vector<Vec3>;

constexpr std::array<std::array<int, 3>, 4> tetrahedron_corner_edges{{{1, 2, 3}, {2, 0, 3}, {0, 1, 3}, {0, 2, 1}}};

template <class Cell>
const auto& cornerEdges() {
  if constexpr (std::tuple_size_v<Cell> == 4)
    return tetrahedron_corner_edges;
  else
    return hexahedron_corner_edges;
}

/// The three edges that leave a corner of a cell.
template <class Cell>
std::array<Vec3, 3> edgesAt(const Cell& cell, std::size_t corner, const Positions& p) {
  std::array<Vec3, 3> out;
  for (std::size_t k = 0; k < 3; ++k) out[k] = p[cell[(cornerEdges<Cell>()[corner][k])]] - p[cell[corner]];
  return out;
}

double orientation(const std::array<Vec3, 3>& edge) { return edge[0].dot(edge[1].cross(edge[2])); }

/// Of the cone of three directions [sr], between -2 pi and 2 pi (van Oosterom and Strackee 1983).
double solidAngle(std::array<Vec3, 3> edge) {
  for (Vec3& e : edge) e.normalize();
  return 2 * std::atan2(orientation(edge), 1 + edge[0].dot(edge[1]) + edge[1].dot(edge[2]) + edge[2].dot(edge[0]));
}

template <class Cell>
bool isInsideOut(const Cell& cell, const Positions& rest, const Positions& now) {
  for (std::size_t corner = 0; corner < cell.size(); ++corner)
    if (orientation(edgesAt(cell, corner, rest)) > 0 && !(orientation(edgesAt(cell, corner, now)) > 0)) return true;
  return false;
}

template <class Cell>
std::string insideOut(const std::vector<Cell>& cells, const char* name, const Positions& rest, const Positions& now) {
  std::size_t count = 0, first = 0;
  for (std::size_t c = 0; c < cells.size(); ++c)
    if (isInsideOut(cells[c], rest, now) && count++ == 0) first = c;
  if (count == 0) return {};
  return fmt::format("{} of {} {}a are inside out{}; the first is {}on {} (nodes {})", count, cells.size(), name,
                     cells[0].size() == 8 ? " at a corner" : "", name, first, fmt::join(cells[first], " "));
}

template <class Cell>
void addSolidAngles(const std::vector<Cell>& cells, const Positions& now, std::vector<double>& sum) {
  for (const Cell& cell : cells)
    for (std::size_t corner = 0; corner < cell.size(); ++corner)
      sum[cell[corner]] += solidAngle(edgesAt(cell, corner, now));
}

/// Of upright cells: more than the whole sphere is seen from a node.
std::string overlapping(const Mesh& mesh, const Positions& now) {
  std::vector<double> sum(now.size(), 0);
  addSolidAngles(mesh.tetrahedra, now, sum);
  addSolidAngles(mesh.hexahedra, now, sum);
  std::size_t count = 0, first = 0;
  for (std::size_t n = 0; n < sum.size(); ++n)
    if (sum[n] > 1.01 * 4 * std::numbers::pi * mesh.overlap && count++ == 0) first = n;
  if (count == 0) return {};
  return fmt::format("the cells around {} of {} nodes fill the space more than once; the first is node {}", count,
                     sum.size(), first);
}

}  // namespace

std::string foldsOf(const Mesh& mesh, const Positions& rest, const Positions& now) {
  if (std::string text = insideOut(mesh.tetrahedra, "tetrahedr", rest, now); !text.empty()) return text;
  if (std::string text = insideOut(mesh.hexahedra, "hexahedr", rest, now); !text.empty()) return text;
  return overlapping(mesh, now);
}

}  // namespace stroma
