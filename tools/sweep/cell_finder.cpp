// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/cell_finder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "framework/mesh/cell_lists.h"
#include "framework/mesh/place_in_cell.h"

namespace stroma::sweep {

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
    const PlaceInCell place = placeInCell(kind, cornersOf(cell, body_->rest).data(), point);
    if (!(place.distance < best.distance)) return;
    best.weights = place.weights, best.corners = kind.nodes, best.distance = place.distance;
    std::ranges::copy(cell, best.nodes.begin());
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
