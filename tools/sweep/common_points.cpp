// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/common_points.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "framework/mesh/cell_lists.h"
#include "tools/sweep/digest.h"

namespace stroma::sweep {
namespace {

constexpr int squares = 2;  ///< of linear functions are integrated exactly

template <class Cell>
void addGaussPoints(const CellKind& kind, const std::vector<Cell>& cells, const std::vector<Vec3>& rest,
                    std::vector<Vec3>& places, std::vector<double>& weights) {
  std::array<double, most_cell_nodes> shape{};
  std::array<LocalPoint, most_cell_nodes> slope{};
  for (const Cell& cell : cells) {
    const auto corners = cornersOf(cell, rest);
    for (const QuadraturePoint& point : kind.rule(squares).points) {
      kind.shapes(point.xi, shape.data());
      kind.gradients(point.xi, slope.data());
      Vec3 x = Vec3::Zero();
      Mat3 jacobian = Mat3::Zero();
      for (std::size_t a = 0; a < cell.size(); ++a)
        x += shape[a] * corners[a], jacobian += corners[a] * Vec3(slope[a].data()).transpose();
      places.push_back(x);
      weights.push_back(std::abs(jacobian.determinant()) * point.weight);
    }
  }
}

template <class T>
std::string bytesOf(const std::vector<T>& list) {
  return {reinterpret_cast<const char*>(list.data()), list.size() * sizeof(T)};
}

std::string keyOf(const EndState& end) {
  std::string key;
  for (const Body& body : end.bodies)
    key += body.path + digestOf(bytesOf(body.rest)) + digestOf(bytesOf(body.tetrahedra)) +
           digestOf(bytesOf(body.hexahedra));
  return key;
}

double sizeOf(const std::vector<Vec3>& points) {
  Vec3 low = points.front(), high = low;
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).norm();
}

}  // namespace

CommonPoints::CommonPoints(const EndState& end) {
  const bool any_cells = end.cells() > 0;
  for (const Body& body : end.bodies) {
    if (body.rest.empty() || (any_cells && body.cells() == 0)) continue;  // a surface that follows a body adds nothing
    Group group{body.path, places_.size(), 0, body.cells() == 0};
    addGaussPoints(cell_kinds::tetrahedron, body.tetrahedra, body.rest, places_, weights_);
    addGaussPoints(cell_kinds::hexahedron, body.hexahedra, body.rest, places_, weights_);
    if (group.are_nodes) {
      places_.insert(places_.end(), body.rest.begin(), body.rest.end());
      weights_.resize(places_.size(), 1.0);
    }
    group.count = places_.size() - group.first;
    groups_.push_back(group);
  }
  if (places_.empty()) throw std::runtime_error("the scene has no node that moves: there is nothing to compare");
}

CommonPoints::CommonPoints(std::vector<Vec3> places) : places_(std::move(places)), weights_(places_.size(), 1.0) {
  groups_.push_back({"", 0, places_.size(), false});
}

void CommonPoints::place(const EndState& end, const Group& group, Placing& placing) const {
  std::vector<CellFinder> finders;
  std::vector<int> numbers;
  const Body* named = nullptr;
  for (std::size_t b = 0; b < end.bodies.size(); ++b) {
    const Body& body = end.bodies[b];
    if (!group.body.empty() && body.path != group.body) continue;
    named = &body;
    if (body.cells() > 0) {
      finders.emplace_back(body);
      numbers.push_back(int(b));
    }
  }
  if (!named) throw std::runtime_error(fmt::format("the run has no state {}, which the reference has", group.body));
  if (finders.empty() || group.are_nodes) {
    const bool same = named->rest.size() == group.count;
    for (std::size_t i = 0; i < group.count; ++i)
      if (!same || (named->rest[i] - places_[group.first + i]).norm() > 1e-9 * (sizeOf(named->rest) + 1e-300))
        throw std::runtime_error(fmt::format(
            "{} has no volume cells: it can be compared with a run that has the same nodes only", named->path));
    for (std::size_t i = 0; i < group.count; ++i) {
      Place& node = placing.places[group.first + i];
      node.nodes[0] = Index(i);
      node.weights[0] = 1;
      node.corners = 1;
      placing.bodies[group.first + i] = int(named - end.bodies.data());
    }
    return;
  }
  for (std::size_t i = group.first; i < group.first + group.count; ++i) {
    Place best = finders.front().find(places_[i]);
    placing.bodies[i] = numbers.front();
    for (std::size_t f = 1; f < finders.size() && best.distance > 0; ++f) {
      const Place other = finders[f].find(places_[i]);
      if (other.distance < best.distance) {
        best = other;
        placing.bodies[i] = numbers[f];
      }
    }
    placing.places[i] = best;
    placing.outside += best.distance > 0;
    placing.farthest = std::max(placing.farthest, best.distance);
  }
}

const CommonPoints::Placing& CommonPoints::placingIn(const EndState& end) const {
  const std::string key = keyOf(end);
  const auto known = placings_.find(key);
  if (known != placings_.end()) return known->second;
  Placing placing;
  placing.places.resize(places_.size());
  placing.bodies.resize(places_.size(), -1);
  for (const Group& group : groups_) place(end, group, placing);
  return placings_[key] = std::move(placing);
}

std::vector<Vec3> CommonPoints::displacements(const EndState& end) const {
  const Placing& placing = placingIn(end);
  std::vector<std::vector<Vec3>> moved;
  for (const Body& body : end.bodies) {
    std::vector<Vec3>& u = moved.emplace_back(body.x);
    for (std::size_t i = 0; i < u.size(); ++i) u[i] -= body.rest[i];
  }
  std::vector<Vec3> values(places_.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = placing.places[i].of(moved[std::size_t(placing.bodies[i])]);
  outside_ = placing.outside, farthest_ = placing.farthest;
  return values;
}

}  // namespace stroma::sweep
