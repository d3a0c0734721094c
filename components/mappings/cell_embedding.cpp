// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/mappings/cell_embedding.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "framework/collision/box_tree.h"
#include "framework/mesh/cell_lists.h"
#include "framework/mesh/place_in_cell.h"

namespace stroma {
namespace {

PlaceInCell placeInTetrahedron(const Vec3* corner, const Vec3& p) {
  Mat3 edges;
  edges << corner[1] - corner[0], corner[2] - corner[0], corner[3] - corner[0];
  const Vec3 u = edges.inverse() * (p - corner[0]);
  PlaceInCell place{.weights = {1 - u.sum(), u[0], u[1], u[2]}};
  std::array<double, 4> inside{};
  double sum = 0;
  for (std::size_t a = 0; a < 4; ++a) sum += inside[a] = std::max(0.0, place.weights[a]);
  Vec3 nearest = Vec3::Zero();
  for (std::size_t a = 0; a < 4; ++a) nearest += inside[a] / sum * corner[a];
  place.distance = (p - nearest).norm();
  if (*std::min_element(place.weights.begin(), place.weights.begin() + 4) >= 0) place.distance = 0;
  return place;
}

/// The foot of the point on an edge, a triangle or a quad, by the method of Gauss and Newton; it may lie beyond their borders.
PlaceInCell placeOn(std::size_t nodes, const Vec3* corner, const Vec3& p) {
  double u = 0, v = 0;
  const auto weights = [nodes](double a, double b) {
    PlaceInCell place;
    if (nodes == 2) place.weights = {1 - a, a};
    if (nodes == 3) place.weights = {1 - a - b, a, b};
    if (nodes == 4) place.weights = {(1 - a) * (1 - b), a * (1 - b), a * b, (1 - a) * b};
    return place;
  };
  const auto at = [&](const PlaceInCell& place) {
    Vec3 x = Vec3::Zero();
    for (std::size_t a = 0; a < nodes; ++a) x += place.weights[a] * corner[a];
    return x;
  };
  for (int iteration = 0; iteration < (nodes == 4 ? 30 : 1); ++iteration) {
    const Vec3 miss = p - at(weights(u, v));
    Vec3 along = corner[1] - corner[0];
    if (nodes == 4) along = (1 - v) * along + v * (corner[2] - corner[3]);
    if (nodes == 2) {
      u += along.dot(miss) / along.squaredNorm();
      continue;
    }
    Vec3 across = corner[nodes - 1] - corner[0];
    if (nodes == 4) across = (1 - u) * across + u * (corner[2] - corner[1]);
    const double uu = along.squaredNorm(), uv = along.dot(across), vv = across.squaredNorm(), size = uu * vv - uv * uv;
    const double du = (vv * along.dot(miss) - uv * across.dot(miss)) / size;
    const double dv = (uu * across.dot(miss) - uv * along.dot(miss)) / size;
    u += du, v += dv;
    if (std::abs(du) + std::abs(dv) < 1e-14) break;
  }
  double a = std::clamp(u, 0., 1.), b = std::clamp(v, 0., 1.);
  if (nodes == 3 && a + b > 1) {
    a /= a + b;
    b = 1 - a;
  }
  PlaceInCell place = weights(u, v);
  place.distance = (p - at(weights(a, b))).norm();
  return place;
}

PlaceInCell placeIn(const CellKind& kind, const Vec3* corner, const Vec3& p) {
  if (kind.dimension < 3) return placeOn(std::size_t(kind.nodes), corner, p);
  return kind.affine ? placeInTetrahedron(corner, p) : placeInCell(kind, corner, p);
}

/// The boxes of the cells; `around` is widened to hold all of them.
template <class Cell>
BoxTree treeOf(const std::vector<Cell>& cells, const std::vector<Vec3>& body, Box& around) {
  std::vector<Box> boxes(cells.size());
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const auto corners = cornersOf(cells[c], body);
    for (const Vec3& p : corners) boxes[c].add(p);
    if constexpr (std::tuple_size_v<Cell> == 10)  // the Bezier points of curved edges bound the cell, its nodes do not
      for (std::size_t e = 0; e < cell_tables::tetrahedron_middles.size(); ++e) {
        const auto [a, b] = cell_tables::tetrahedron_middles[e];
        boxes[c].add(2 * corners[4 + e] - (corners[std::size_t(a)] + corners[std::size_t(b)]) / 2);
      }
    around.add(boxes[c]);
  }
  BoxTree tree;
  tree.build(std::move(boxes));
  return tree;
}

/// In the nearest cell, whose number goes to `cell`: by ascending distance of their boxes, as no cell whose box is
/// farther than the best one can be better.
template <class Cell>
PlaceInCell nearestPlace(const CellKind& kind, const std::vector<Cell>& cells, const std::vector<Vec3>& body,
                   const BoxTree& tree, const Vec3& point, std::size_t& cell) {
  PlaceInCell best;
  best.distance = std::numeric_limits<double>::infinity();
  tree.forEachByDistance(point, [&](Index number, double distance) {
    if (distance >= best.distance) return false;
    const PlaceInCell place = placeIn(kind, cornersOf(cells[std::size_t(number)], body).data(), point);
    if (place.distance < best.distance) {
      best = place;
      cell = std::size_t(number);
    }
    return best.distance != 0;
  });
  return best;
}

/// The gradients of N_a in space; none in a cell without a volume.
std::vector<Vec3> slopesAt(const CellKind& kind, const Vec3* corner, const LocalPoint& xi) {
  std::array<LocalPoint, most_cell_nodes> slope{};
  kind.gradients(xi, slope.data());
  const auto slopeOf = [&slope](std::size_t a) { return Vec3(slope[a][0], slope[a][1], slope[a][2]); };
  Mat3 jacobian = Mat3::Zero();
  for (std::size_t a = 0; a < std::size_t(kind.nodes); ++a) jacobian += corner[a] * slopeOf(a).transpose();
  if (kind.dimension < 3 || jacobian.determinant() == 0) return {};
  const Mat3 to_space = jacobian.inverse().transpose();
  std::vector<Vec3> slopes;
  for (std::size_t a = 0; a < std::size_t(kind.nodes); ++a) slopes.push_back(to_space * slopeOf(a));
  return slopes;
}

/// Gives every point its cell, where it has none that is nearer.
template <class Cell>
void embed(const CellKind& kind, const std::vector<Cell>& cells, const std::vector<Vec3>& body,
           const std::vector<Vec3>& points, Box& around, std::vector<EmbeddedPoint>& found) {
  const BoxTree tree = treeOf(cells, body, around);
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::size_t at = 0;
    const PlaceInCell best = nearestPlace(kind, cells, body, tree, points[i], at);
    if (!(best.distance < found[i].distance)) continue;
    const Cell& cell = cells[at];
    found[i] = {best.distance,
                {cell.begin(), cell.end()},
                {best.weights.begin(), best.weights.begin() + long(cell.size())},
                {}};
    found[i].slopes = slopesAt(kind, cornersOf(cell, body).data(), best.xi);
  }
}

}  // namespace

std::vector<EmbeddedPoint> embedPoints(const Topology& topology, const std::vector<Vec3>& body,
                                       const std::vector<Vec3>& points, double& size) {
  const int dimension = highestDimension(topology.mesh());
  if (dimension < 1)
    throw ComponentError(fmt::format("{} has no cells", topology.path()),
                         "a mesh of a volume, of a surface or of lines");
  std::vector<EmbeddedPoint> found(points.size());
  Box around;
  // in cells of one kind: others may fill the body again; on surfaces, and beside prisms and pyramids, in those of all
  const bool of_all = dimension < 3 || !topology.mesh().prisms.empty() || !topology.mesh().pyramids.empty();
  bool embedded = false;
  forEachCellList(
      [&](const CellKind& kind, const auto& cells) {
        const bool is_curved_surface = dimension < 3 && kind.nodes > 4;
        if (kind.dimension != dimension || cells.empty() || (embedded && !of_all) || is_curved_surface) return;
        embed(kind, cells, body, points, around, found);
        embedded = true;
      },
      topology.mesh());
  if (!embedded)
    throw ComponentError(fmt::format("{} has only cells of curved edges", topology.path()),
                         "triangles, quads or edges");
  size = (around.high - around.low).norm();
  return found;
}

}  // namespace stroma
