// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/cell_finder.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "framework/mesh/cell_lists.h"

namespace stroma::sweep {
namespace {

/// x(xi) of a cell, and what goes with it.
struct CellMap {
  const CellKind& kind;
  const Vec3* corner;
  std::array<double, most_cell_nodes> value{};
  std::array<LocalPoint, most_cell_nodes> slope{};
  Mat3 jacobian = Mat3::Zero();

  Vec3 slopeOf(int a) const { return Vec3(slope[std::size_t(a)].data()); }
  Vec3 at(const LocalPoint& xi) {
    kind.shapes(xi, value.data());
    kind.gradients(xi, slope.data());
    Vec3 x = Vec3::Zero();
    jacobian.setZero();
    for (int a = 0; a < kind.nodes; ++a)
      x += value[std::size_t(a)] * corner[a], jacobian += corner[a] * slopeOf(a).transpose();
    return x;
  }
};

/// Newton's method held in the cell: inside it ends at the point, outside at the side that the point lies beyond.
Place placeIn(const CellKind& kind, const Vec3* corner, const Vec3& p) {
  CellMap map{kind, corner};
  LocalPoint xi{};
  for (int a = 0; a < kind.nodes; ++a)
    for (std::size_t i = 0; i < 3; ++i) xi[i] += kind.reference[std::size_t(a)][i] / kind.nodes;
  constexpr int most_iterations = 30;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const Vec3 before(xi.data()), miss = p - map.at(xi), next = before + map.jacobian.inverse() * miss;
    xi = {next[0], next[1], next[2]};
    kind.hold(xi);
    if (!((Vec3(xi.data()) - before).norm() > 1e-14)) break;
  }
  const Vec3 miss = p - map.at(xi), beyond = map.jacobian.inverse() * miss;
  Place place;
  place.corners = kind.nodes;
  for (int a = 0; a < kind.nodes; ++a)
    place.weights[std::size_t(a)] = map.value[std::size_t(a)] + map.slopeOf(a).dot(beyond);
  place.distance = beyond.norm() < 1e-9 ? 0 : miss.norm();
  return place;
}

}  // namespace

Vec3 Place::of(const std::vector<Vec3>& values) const {
  Vec3 sum = Vec3::Zero();
  for (std::size_t a = 0; a < std::size_t(corners); ++a) sum += weights[a] * values[std::size_t(nodes[a])];
  return sum;
}

CellFinder::CellFinder(const Body& body) : body_(&body) {
  std::vector<Box> boxes;
  const auto add = [&](const auto& cells) {
    for (const auto& cell : cells) {
      Box& box = boxes.emplace_back();
      for (const Vec3& p : cornersOf(cell, body.rest)) box.add(p);
    }
  };
  add(body.tetrahedra), add(body.hexahedra);
  tree_.build(std::move(boxes));
}

Place CellFinder::find(const Vec3& point) const {
  Place best;
  best.distance = std::numeric_limits<double>::infinity();
  const auto look = [&](const CellKind& kind, const auto& cell) {
    Place place = placeIn(kind, cornersOf(cell, body_->rest).data(), point);
    if (!(place.distance < best.distance)) return;
    for (std::size_t a = 0; a < cell.size(); ++a) place.nodes[a] = cell[a];
    best = place;
  };
  const std::size_t tetrahedra = body_->tetrahedra.size();
  tree_.forEachByDistance(point, [&](Index number, double distance) {
    if (distance >= best.distance) return false;
    const auto cell = std::size_t(number);
    if (cell < tetrahedra)
      look(cell_kinds::tetrahedron, body_->tetrahedra[cell]);
    else
      look(cell_kinds::hexahedron, body_->hexahedra[cell - tetrahedra]);
    return best.distance > 0;
  });
  if (!std::isfinite(best.distance)) throw std::runtime_error("no cell can hold a point: all are flat at rest");
  return best;
}

}  // namespace stroma::sweep
