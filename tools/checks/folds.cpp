// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/checks/folds.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "framework/mesh/cell_lists.h"

namespace stroma {
namespace {

using Positions = std::vector<Vec3>;

/// The three edges that leave a corner of a cell.
template <class Cell>
std::array<Vec3, 3> edgesAt(const CellKind& kind, const Cell& cell, std::size_t corner, const Positions& p) {
  std::array<Vec3, 3> out;
  for (std::size_t k = 0; k < 3; ++k) out[k] = p[cell[kind.corner_edges[corner][k]]] - p[cell[corner]];
  return out;
}

double orientation(const std::array<Vec3, 3>& edge) { return edge[0].dot(edge[1].cross(edge[2])); }

/// Of the cone of three directions [sr], between -2 pi and 2 pi (van Oosterom and Strackee 1983).
double solidAngle(std::array<Vec3, 3> edge) {
  for (Vec3& e : edge) e.normalize();
  return 2 * std::atan2(orientation(edge), 1 + edge[0].dot(edge[1]) + edge[1].dot(edge[2]) + edge[2].dot(edge[0]));
}

/// det dx/dxi of a cell.
template <class Cell>
double determinantAt(const CellKind& kind, const Cell& cell, const LocalPoint& xi, const Positions& p) {
  std::array<LocalPoint, std::tuple_size_v<Cell>> slopes;
  kind.gradients(xi, slopes.data());
  Mat3 map = Mat3::Zero();
  for (std::size_t a = 0; a < cell.size(); ++a)
    for (int k = 0; k < 3; ++k) map.col(k) += slopes[a][std::size_t(k)] * p[cell[a]];
  return map.determinant();
}

/// Quadratic cells can be turned inside out between corners that are upright, by points of theirs that turn apart.
template <class Cell>
bool isInsideOutInside(const CellKind& kind, const Cell& cell, const Positions& rest, const Positions& now) {
  const auto isTurned = [&](const LocalPoint& xi) {
    return determinantAt(kind, cell, xi, rest) > 0 && !(determinantAt(kind, cell, xi, now) > 0);
  };
  const auto corners = std::ptrdiff_t(kind.corner_edges.size());
  return isTurned(LocalPoint{0.25, 0.25, 0.25}) || std::any_of(kind.reference.begin() + corners, kind.reference.end(), isTurned);
}

template <class Cell>
bool isInsideOut(const CellKind& kind, const Cell& cell, const Positions& rest, const Positions& now) {
  for (std::size_t corner = 0; corner < kind.corner_edges.size(); ++corner)
    if (orientation(edgesAt(kind, cell, corner, rest)) > 0 && !(orientation(edgesAt(kind, cell, corner, now)) > 0))
      return true;
  return kind.type == CellType::quadratic_tetrahedron && isInsideOutInside(kind, cell, rest, now);
}

template <class Cell>
std::string insideOut(const CellKind& kind, const std::vector<Cell>& cells, const Positions& rest,
                      const Positions& now) {
  std::size_t count = 0, first = 0;
  for (std::size_t c = 0; c < cells.size(); ++c)
    if (isInsideOut(kind, cells[c], rest, now) && count++ == 0) first = c;
  if (count == 0) return {};
  return fmt::format("{} of {} {} are inverted{}; the first is {} {} (nodes {})", count, cells.size(), kind.plural,
                     kind.affine       ? ""
                     : kind.order == 2 ? " at a node or the centre"
                                       : " at a corner",
                     kind.singular, first, fmt::join(cells[first], " "));
}

/// Faces that have been crushed to a line or a point: no fold of cloth does that to them.
template <class Cell>
std::string crushed(const CellKind& kind, const std::vector<Cell>& cells, const Positions& rest, const Positions& now) {
  constexpr double least = 0.02;
  std::size_t count = 0, first = 0;
  for (std::size_t c = 0; c < cells.size(); ++c)
    if (kind.size(cornersOf(cells[c], now).data()) < least * kind.size(cornersOf(cells[c], rest).data()) && count++ == 0) first = c;
  if (count == 0) return {};
  return fmt::format("{} of {} {} are crushed to less than {:g} % of their area at rest; the first is {} {} (nodes {})", count,
                     cells.size(), kind.plural, 100 * least, kind.singular, first, fmt::join(cells[first], " "));
}

template <class Cell>
void addSolidAngles(const CellKind& kind, const std::vector<Cell>& cells, const Positions& now,
                    std::vector<double>& sum) {
  for (const Cell& cell : cells)
    for (std::size_t corner = 0; corner < kind.corner_edges.size(); ++corner)
      sum[cell[corner]] += solidAngle(edgesAt(kind, cell, corner, now));
}

/// Of upright cells: more than the whole sphere is seen from a node.
std::string overlapping(const Mesh& mesh, const Positions& now) {
  std::vector<double> sum(now.size(), 0);
  forEachCellList(
      [&](const CellKind& kind, const auto& cells) {
        if (kind.dimension == 3) addSolidAngles(kind, cells, now, sum);
      },
      mesh);
  std::size_t count = 0, first = 0;
  for (std::size_t n = 0; n < sum.size(); ++n)
    if (sum[n] > 1.01 * 4 * std::numbers::pi * mesh.overlap && count++ == 0) first = n;
  if (count == 0) return {};
  return fmt::format("the cells around {} of {} nodes fill the space more than once; the first is node {}", count,
                     sum.size(), first);
}

}  // namespace

std::string foldsOf(const Mesh& mesh, const Positions& rest, const Positions& now) {
  std::string text;
  forEachCellList(
      [&](const CellKind& kind, const auto& cells) {
        if (kind.dimension == 3 && text.empty()) text = insideOut(kind, cells, rest, now);
      },
      mesh);
  if (text.empty() && highestDimension(mesh) == 2)
    forEachCellList(
        [&](const CellKind& kind, const auto& cells) {
          if (kind.dimension == 2 && text.empty()) text = crushed(kind, cells, rest, now);
        },
        mesh);
  return text.empty() ? overlapping(mesh, now) : text;
}

std::pair<std::size_t, std::size_t> insideOutCells(const Mesh& mesh, const Positions& rest, const Positions& now) {
  std::size_t inverted = 0, all = 0;
  forEachCellList(
      [&](const CellKind& kind, const auto& cells) {
        if (kind.dimension < 3) return;
        all += cells.size();
        for (const auto& cell : cells) inverted += isInsideOut(kind, cell, rest, now);
      },
      mesh);
  return {inverted, all};
}

}  // namespace stroma
