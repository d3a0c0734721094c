// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/checks/cells_across.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "framework/mesh/cell_kind.h"
#include "framework/mesh/cell_tables.h"

namespace stroma {
namespace {

constexpr std::size_t most_cells = 100000, most_lines = 400;

struct CellFace {
  Index cell = 0;
  int face = 0;  ///< of CellKind::faces
};
struct Side {
  std::array<Index, 4> sorted;  ///< nodes; -1 for the fourth of a triangle
  CellFace at;
  CellFace across;  ///< the cell on the other side; -1: none
};

const CellKind& volumeKindOf(const Hexahedron&) { return cell_kinds::hexahedron; }
const CellKind& volumeKindOf(const Tetrahedron&) { return cell_kinds::tetrahedron; }

/// Sides in the order of cells and faces.
template <class Cell>
std::vector<Side> sidesOf(const std::vector<Cell>& cells, int faces) {
  std::vector<Side> sides;
  sides.reserve(cells.size() * std::size_t(faces));
  for (std::size_t c = 0; c < cells.size(); ++c)
    for (int f = 0; f < faces; ++f) {
      Side side{{-1, -1, -1, -1}, {Index(c), f}, {-1, -1}};
      const std::size_t corners = cells[c].size() == 4 ? 3 : 4;
      for (std::size_t i = 0; i < corners; ++i)
        side.sorted[i] = cells[c][std::size_t(volumeKindOf(cells[c]).faces[std::size_t(f)].nodes[i])];
      std::sort(side.sorted.begin(), side.sorted.end());
      sides.push_back(side);
    }
  std::vector<std::size_t> order(sides.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return sides[a].sorted < sides[b].sorted; });
  for (std::size_t i = 0; i + 1 < order.size(); ++i) {
    Side &a = sides[order[i]], &b = sides[order[i + 1]];
    if (a.sorted == b.sorted) {
      a.across = b.at;
      b.across = a.at;
      ++i;
    }
  }
  return sides;
}

/// A hexahedron along the body.
struct Along {
  double step = 0;                    ///< its length
  double lean = 0, lean_in_plan = 0;  ///< of its end faces, squared (Slenderness)
};
struct Line {
  double length, cells;
  Along first = {};  ///< of its first cell
};

Vec3 middle(const Side& side, const std::vector<Vec3>& position) {
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (const Index n : side.sorted)
    if (n >= 0) sum += position[n], ++count;
  return sum / count;
}

/// The side of the same hexahedron that has no node in common with this one.
const Side* oppositeOf(const Side& side, const std::vector<Side>& sides) {
  for (std::size_t f = 0; f < 6; ++f) {
    const Side& other = sides[std::size_t(side.at.cell) * 6 + f];
    if (std::none_of(other.sorted.begin(), other.sorted.end(), [&](Index n) {
          return std::find(side.sorted.begin(), side.sorted.end(), n) != side.sorted.end();
        }))
      return &other;
  }
  return nullptr;
}

/// How far cells go on from a side of one, out of it. A ring has no end.
double reachFrom(const Side& side, const std::vector<Side>& sides, const std::vector<Vec3>& position) {
  constexpr int most = 500;
  const Side* out = &side;
  for (int count = 0; count < most; ++count) {
    if (out->across.cell < 0) return (middle(*out, position) - middle(side, position)).norm();
    out = oppositeOf(sides[std::size_t(out->across.cell) * 6 + std::size_t(out->across.face)], sides);
    if (!out) return 0;
  }
  return std::numeric_limits<double>::infinity();
}

/// xi, eta or zeta (0, 1, 2) of corners of hexahedra: -1 or 1.
double signOf(int corner, int axis) { return cell_kinds::hexahedron.reference[std::size_t(corner)][std::size_t(axis)]; }
/// The axis that is the same at the four corners of a face.
int axisOf(int face) {
  const auto& nodes = cell_kinds::hexahedron.faces[std::size_t(face)].nodes;
  int axis = 0;
  while (signOf(nodes[0], axis) != signOf(nodes[1], axis) || signOf(nodes[0], axis) != signOf(nodes[2], axis)) ++axis;
  return axis;
}

/// sum_c s_c x_c of the corners, s their sign along an axis, or the product of those along two.
Vec3 sumOf(const Hexahedron& cell, const std::vector<Vec3>& position, int axis, int other = -1) {
  Vec3 sum = Vec3::Zero();
  for (int c = 0; c < 8; ++c) sum += signOf(c, axis) * (other < 0 ? 1 : signOf(c, other)) * position[cell[std::size_t(c)]];
  return sum;
}
/// t, where the end faces of a cell across the axis `along` lean apart upward by the tangent t each. `up` is across the axis.
double leanOf(const Hexahedron& cell, const std::vector<Vec3>& position, int along, const Vec3& up) {
  int across = (along + 1) % 3;
  if (const int third = 3 - along - across;
      std::abs(sumOf(cell, position, third).normalized().dot(up)) > std::abs(sumOf(cell, position, across).normalized().dot(up)))
    across = third;
  const Vec3 length = sumOf(cell, position, along), height = sumOf(cell, position, across);
  const double area = height.cross(length).norm(), t = sumOf(cell, position, along, across).dot(length) / area;
  return area > 0 ? std::copysign(t, t * height.dot(up)) : 0;
}

/// Of the cell of a side, along the one of its two other directions in which the body extends farther.
Along stepAlong(const Side& start, const std::vector<Hexahedron>& cells, const std::vector<Side>& sides,
                const std::vector<Vec3>& position) {
  const Side* back = oppositeOf(start, sides);
  double farthest = 0;
  Along out;
  int along = 0;
  for (std::size_t f = 0; back && f < 6; ++f) {
    const Side& side = sides[std::size_t(start.at.cell) * 6 + f];
    if (side.at.face == start.at.face || side.at.face == back->at.face) continue;
    const Side* other = oppositeOf(side, sides);
    if (!other) return {};
    const double own = (middle(side, position) - middle(*other, position)).norm();
    const double reach = own + reachFrom(side, sides, position) + reachFrom(*other, sides, position);
    if (reach > farthest) farthest = reach, out.step = own, along = axisOf(side.at.face);
  }
  if (!(out.step > 0)) return {};
  const Hexahedron& cell = cells[std::size_t(start.at.cell)];
  const int across = axisOf(start.at.face);
  const Vec3 up = sumOf(cell, position, across).normalized(), aside = sumOf(cell, position, 3 - along - across).normalized();
  double neighbours = 0;
  for (std::size_t f = 0; f < 6; ++f) {
    const Side& side = sides[std::size_t(start.at.cell) * 6 + f];
    if (axisOf(int(f)) != along || side.across.cell < 0) continue;
    const Hexahedron& next = cells[std::size_t(side.across.cell)];
    const auto square = [&](const Vec3& direction) {
      return std::pow((leanOf(cell, position, along, direction) - leanOf(next, position, axisOf(side.across.face), direction)) / 2, 2);
    };
    ++neighbours, out.lean += square(up), out.lean_in_plan += square(aside);
  }
  if (neighbours > 0) out.lean /= neighbours, out.lean_in_plan /= neighbours;
  return out;
}
Along stepAlong(const Side&, const std::vector<Tetrahedron>&, const std::vector<Side>&, const std::vector<Vec3>&) { return {}; }

/// Through opposite faces.
Line lineFrom(const Side& start, const std::vector<Hexahedron>& cells, const std::vector<Side>& sides,
              const std::vector<Vec3>& position) {
  const Side* side = &start;
  double count = 0;
  while (count < double(cells.size())) {
    ++count;
    const Side* opposite = oppositeOf(*side, sides);
    if (!opposite) return {0, 0};
    if (opposite->across.cell < 0) return {(middle(*opposite, position) - middle(start, position)).norm(), count};
    side = &sides[std::size_t(opposite->across.cell) * 6 + std::size_t(opposite->across.face)];
  }
  return {0, 0};
}

/// Along the normal; a cell counts with the cube root of six times its volume, the edge of the cube that six such fill.
Line lineFrom(const Side& start, const std::vector<Tetrahedron>& cells, const std::vector<Side>& sides,
              const std::vector<Vec3>& position) {
  const auto plane = [&](const Side& side) -> Vec3 {
    const Vec3 a = position[side.sorted[1]], b = position[side.sorted[2]], c = position[side.sorted[3]];
    return Vec3((b - a).cross(c - a)).normalized();
  };
  const auto centre = [&](Index cell) -> Vec3 {
    Vec3 sum = Vec3::Zero();
    for (const Index n : cells[std::size_t(cell)]) sum += position[n] / 4;
    return sum;
  };
  const auto triangleMiddle = [&](const Side& side) { return middle(side, position); };
  const Vec3 origin = triangleMiddle(start);
  Vec3 inward = plane(start);
  if (inward.dot(centre(start.at.cell) - origin) < 0) inward = -inward;
  CellFace at = start.at;
  double reached = 0, size = 0, count = 0;
  while (count < double(cells.size())) {
    const Tetrahedron& cell = cells[std::size_t(at.cell)];
    const Vec3 corner = position[cell[0]];
    size += std::cbrt(
        std::abs((position[cell[1]] - corner).cross(position[cell[2]] - corner).dot(position[cell[3]] - corner)));
    ++count;
    const Side* out = nullptr;
    double nearest = std::numeric_limits<double>::infinity();
    for (int f = 0; f < 4; ++f) {
      if (f == at.face) continue;
      const Side& side = sides[std::size_t(at.cell) * 4 + std::size_t(f)];
      Vec3 normal = plane(side);
      const Vec3 point = triangleMiddle(side);
      if (normal.dot(point - centre(at.cell)) < 0) normal = -normal;
      const double rate = normal.dot(inward);
      if (rate <= 1e-9) continue;
      const double along = normal.dot(point - origin) / rate;
      if (along < nearest) {
        nearest = along;
        out = &side;
      }
    }
    if (!out) return {0, 0};
    reached = std::max(reached, nearest);
    if (out->across.cell < 0) return {reached, reached / (size / count)};
    at = out->across;
  }
  return {0, 0};
}

double median(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto at = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Of short lines the one that a share of them does not exceed in cells. Counts of tetrahedra scatter around that of a
/// wall; those of hexahedra are exact, so that a quarter of the lines shows the walls of a hollow body.
Line thinnest(std::vector<Line>& lines, bool hexahedra) {
  if (lines.empty()) return {0, 0};
  const auto at = lines.begin() + std::ptrdiff_t(lines.size() / (hexahedra ? 4 : 2));
  std::nth_element(lines.begin(), at, lines.end(),
                   [](const Line& a, const Line& b) { return std::tie(a.cells, a.length) < std::tie(b.cells, b.length); });
  return *at;
}

/// Whether a side faces along an axis.
bool facesAlong(const Side& side, const std::vector<Vec3>& position, const Vec3& axis) {
  const Vec3 a = position[side.sorted[1]], b = position[side.sorted[2]], c = position[side.sorted[3]];
  const Vec3 normal = (b - a).cross(c - a);
  return std::abs(normal.dot(axis)) > 0.9 * normal.norm();
}

template <class Cell>
Slenderness measure(const std::vector<Cell>& cells, const std::vector<Vec3>& position, const Vec3& held) {
  Slenderness out;
  if (cells.empty() || cells.size() > most_cells) return out;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Cell& cell : cells)
    for (const Index n : cell) low = low.cwiseMin(position[n]), high = high.cwiseMax(position[n]);
  out.extent = (high - low).maxCoeff();
  const std::vector<Side> sides = sidesOf(cells, int(volumeKindOf(cells[0]).faces.size()));
  std::vector<const Side*> boundary;
  for (const Side& side : sides)
    if (side.across.cell < 0 && !facesAlong(side, position, held)) boundary.push_back(&side);
  if (boundary.empty()) return out;
  const std::size_t stride = std::max<std::size_t>(1, boundary.size() / most_lines);
  std::vector<double> lengths;
  std::vector<Line> short_lines;
  for (std::size_t i = 0; i < boundary.size(); i += stride) {
    Line line = lineFrom(*boundary[i], cells, sides, position);
    if (!(line.cells > 0)) continue;
    lengths.push_back(line.length);
    if (line.length >= 0.3 * out.extent) continue;
    line.first = stepAlong(*boundary[i], cells, sides, position);
    short_lines.push_back(line);
  }
  out.typical = median(lengths);
  const Line thin = thinnest(short_lines, std::tuple_size_v<Cell> == 8);
  out.thickness = thin.length, out.cells = thin.cells;
  std::vector<double> steps;  // of lines like the thin one
  for (const Line& line : short_lines)
    if (line.cells == thin.cells && line.length < 1.2 * thin.length) {
      steps.push_back(line.first.step / line.length);
      out.lean += line.first.lean, out.lean_in_plan += line.first.lean_in_plan;
    }
  const double count = double(std::max<std::size_t>(1, steps.size()));
  out.lean = std::sqrt(out.lean / count), out.lean_in_plan = std::sqrt(out.lean_in_plan / count);
  out.step = median(steps);
  return out;
}

}  // namespace

Slenderness slenderness(const std::vector<Hexahedron>& cells, const std::vector<Vec3>& position, const Vec3& held) {
  return measure(cells, position, held);
}
Slenderness slenderness(const std::vector<Tetrahedron>& cells, const std::vector<Vec3>& position, const Vec3& held) {
  return measure(cells, position, held);
}

}  // namespace stroma
