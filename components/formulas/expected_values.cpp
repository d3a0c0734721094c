// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/formulas/expected_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "framework/mechanics/frames.h"

namespace stroma::expect {
namespace {

constexpr int all_axes = 0, norm_axis = 4;

void appendNumbers(const State& state, ConstRows rows, Index node, bool of_way, const Chosen& chosen, std::vector<Value>& out) {
  const Index first = node * state.rows_per_node;
  const auto rest = [&](Index k) { return state.rest_position[std::size_t(first + k)][0]; };
  Vec3 place = Vec3::Zero();
  for (Index k = 0; k < std::min<Index>(state.rows_per_node, 3); ++k) place[k] = rest(k);
  const std::string name = fmt::format("{} node {}", chosen.of, node);
  double squares = 0;
  for (Index k = 0; k < state.rows_per_node; ++k) {
    const double number = rows[first + k][0] - (of_way ? rest(k) : 0);
    squares += number * number;
    if (chosen.axis == all_axes || (k < 3 && chosen.axis == int(k) + 1))
      out.push_back({number, fmt::format("{} number {}", name, k), place});
  }
  if (chosen.axis == norm_axis) out.push_back({std::sqrt(squares), name + " norm", place});
}

}  // namespace

void appendVector(const Vec3& v, int axis, const std::string& name, const Vec3& place, std::vector<Value>& out) {
  for (int c = 0; c < 3; ++c)
    if (axis == all_axes || axis == c + 1) out.push_back({v[c], name + " " + "xyz"[c], place});
  if (axis == norm_axis) out.push_back({v.norm(), name + " norm", place});
}

std::vector<Value> nodeValues(const State& state, const std::string& name, const Chosen& chosen) {
  std::vector<Value> all;
  const bool of_way = name == "displacement";
  const ConstRows rows = name == "velocity" ? state.v() : state.x();
  const auto add = [&](Index node) {
    const Index row = node * state.rows_per_node;
    if (state.kindOf(row) == RowKind::value) return appendNumbers(state, rows, node, of_way, chosen, all);
    const Vec3& rest = state.rest_position[std::size_t(row)];
    Vec3 value = of_way ? Vec3(rows[row] - rest) : Vec3(rows[row]);
    if (name == "orientation") value = rotationVector(orientationIn(rows, row + 1));
    if (name == "angularVelocity") value = state.v()[row + 1];
    appendVector(value, chosen.axis, fmt::format("{} node {}", chosen.of, node), rest, all);
  };
  for (const int node : chosen.nodes) add(node);
  for (Index node = 0; chosen.nodes.empty() && node < state.nodes(); ++node) add(node);
  return all;
}

std::vector<Value> momentumOf(const std::vector<std::unique_ptr<System>>& systems, bool angular, const Chosen& chosen) {
  Vec3 sum = Vec3::Zero();
  for (const auto& system : systems) {
    Vector p(system->allRows());
    for (Mass* mass : system->masses()) {
      const State& state = mass->state();
      clear(p);
      mass->update(system->x);
      mass->addProduct(system->v, 1, p);
      for (Index row = state.firstRow(); row < state.firstRow() + state.size(); ++row) {
        const bool turns = state.kindOf(row - state.firstRow()) == RowKind::turn;
        const Vec3 own = p[row];
        if (angular)
          sum += turns ? own : Vec3(Vec3(system->x[row]).cross(own));
        else if (!turns)
          sum += own;
      }
    }
  }
  std::vector<Value> all;
  appendVector(sum, chosen.axis, chosen.of, Vec3::Zero(), all);
  return all;
}

void checkMomentum(const std::vector<std::unique_ptr<System>>& systems) {
  for (const auto& system : systems)
    for (const Mass* mass : system->masses())
      if (mass->state().kindOf(0) == RowKind::value)
        throw ComponentError(fmt::format("{} is a mass on numbers, whose momentum has no direction in space", mass->path()),
                             "masses on points and frames");
}

}  // namespace stroma::expect
