// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mesh/place_in_cell.h"

#include <Eigen/LU>

namespace stroma {
namespace {

/// x(xi) of a cell and its derivatives.
struct CellMap {
  const CellKind& kind;
  const Vec3* corners;
  std::array<double, most_cell_nodes> value{};
  std::array<LocalPoint, most_cell_nodes> slope{};
  Mat3 jacobian = Mat3::Zero();

  Vec3 slopeOf(std::size_t a) const { return Vec3(slope[a].data()); }
  Vec3 at(const LocalPoint& xi) {
    kind.shapes(xi, value.data());
    kind.gradients(xi, slope.data());
    Vec3 x = Vec3::Zero();
    jacobian.setZero();
    for (std::size_t a = 0; a < std::size_t(kind.nodes); ++a) x += value[a] * corners[a], jacobian += corners[a] * slopeOf(a).transpose();
    return x;
  }
};

}  // namespace

PlaceInCell placeInCell(const CellKind& kind, const Vec3* corners, const Vec3& p) {
  constexpr int most_iterations = 30;
  constexpr double settled = 1e-14, inside = 1e-9;  // of the reference cell
  CellMap map{kind, corners};
  PlaceInCell place;
  LocalPoint& xi = place.xi;
  for (int a = 0; a < kind.nodes; ++a)
    for (std::size_t i = 0; i < 3; ++i) xi[i] += kind.reference[std::size_t(a)][i] / kind.nodes;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const Vec3 before(xi.data()), miss = p - map.at(xi), next = before + map.jacobian.inverse() * miss;
    xi = {next[0], next[1], next[2]};
    kind.hold(xi);
    if (!((Vec3(xi.data()) - before).norm() > settled)) break;
  }
  const Vec3 miss = p - map.at(xi), beyond = map.jacobian.inverse() * miss;
  for (std::size_t a = 0; a < std::size_t(kind.nodes); ++a) place.weights[a] = map.value[a] + map.slopeOf(a).dot(beyond);
  place.distance = beyond.norm() < inside ? 0 : miss.norm();
  return place;
}

}  // namespace stroma
