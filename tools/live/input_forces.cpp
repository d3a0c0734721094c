// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/input_forces.h"

#include <algorithm>

#include "framework/mechanics/frames.h"

namespace stroma {
namespace {

void addToDiagonal(Index row, const Mat3& value, BlockMatrix& matrix) { matrix.add(matrix.diagonal()[row], value); }
void addToDiagonal(Index row, double value, BlockMatrix& matrix) {
  addToDiagonal(row, value * Mat3::Identity(), matrix);
}

void addToBlocks(Index row, double value, std::vector<double>& blocks) {
  for (std::size_t c = 0; c < 3; ++c) blocks[9 * std::size_t(row) + 4 * c] += value;
}
void addToBlocks(Index row, const Mat3& value, std::vector<double>& blocks) {
  for (Eigen::Index r = 0; r < 3; ++r)
    for (Eigen::Index c = 0; c < 3; ++c) blocks[9 * std::size_t(row) + std::size_t(3 * r + c)] += value(r, c);
}

Mat3 along(const Vec3& normal, double factor) { return factor * normal * normal.transpose(); }

/// From where row `row` is to a target, as an increment.
Vec3 wayTo(const Vec3& target, RowKind kind, ConstRows x, Index row) {
  if (kind != RowKind::turn) return target - x[row];
  return rotationVector(turnedBy(target) * orientationIn(x, row).conjugate());
}

/// Nearer to the centre the square of a distance loses its digits, and a place has no direction.
constexpr double no_distance = 1e-150;

}  // namespace

template <class Visit>
void InputForces::forInside(const Placed& placed, ConstRows x, Visit&& visit) {
  if (!placed.input.ball) return;
  const auto& [centre, radius] = *placed.input.ball;
  const State& state = *placed.state;
  for (Index i = 0; i < state.size(); ++i) {
    if (state.kindOf(i) != RowKind::place) continue;
    const Index row = state.firstRow() + i;
    const Vec3 from = x[row] - centre;
    const double distance = from.norm();
    if (!(distance < radius)) continue;
    visit(row, radius - distance, distance < no_distance ? Vec3(1, 0, 0) : Vec3(from / distance));
  }
}

InputForces::InputForces(State& state) {
  standBeside(state, "inputs");
  mstate_.set(&state);
  init();
}

bool InputForces::set(long number, const Input& input, const State& state) {
  const auto found = inputs_.find(number);
  if (found != inputs_.end() && found->second.input.hasDerivativesOf(input) && found->second.state == &state) {
    found->second.input = input;
    return false;
  }
  inputs_[number] = {input, &state};
  return true;
}

bool InputForces::remove(long number) { return inputs_.erase(number) > 0; }

bool InputForces::isDamped() const {
  return std::any_of(inputs_.begin(), inputs_.end(), [](const auto& entry) { return entry.second.input.damping > 0; });
}

bool InputForces::hasBall() const {
  return std::any_of(inputs_.begin(), inputs_.end(),
                     [](const auto& entry) { return entry.second.input.ball.has_value(); });
}

ForceTraits InputForces::traits() const {
  ForceTraits traits;
  traits.symmetric = traits.conservative = true;
  traits.linear = traits.constant_stiffness = traits.exact_tangent = !hasBall() && !turnsAny();
  traits.velocity_dependent = isDamped();
  return traits;
}

ForceField::Cost InputForces::cost() const {
  std::size_t nodes = 0;
  forNodes([&nodes](Index, const Input&, std::size_t) { ++nodes; });
  // the few nodes inside a ball come and go: what is chosen by costs is not to depend on them
  for (const auto& [number, placed] : inputs_) nodes += placed.input.ball ? 1 : 0;
  return {2.5 * double(nodes), 2.5 * double(nodes)};
}

bool InputForces::turnsAny() const {
  return std::any_of(inputs_.begin(), inputs_.end(), [](const auto& entry) {
    const std::vector<Index>& nodes = entry.second.input.nodes;
    return std::any_of(nodes.begin(), nodes.end(),
                       [&](Index node) { return entry.second.state->kindOf(node) == RowKind::turn; });
  });
}

double InputForces::energy(ConstRows x) const {
  double sum = 0;
  for (const auto& [number, placed] : inputs_) {
    const Input& input = placed.input;
    for (std::size_t i = 0; i < input.nodes.size(); ++i) {
      const Index row = placed.state->firstRow() + input.nodes[i];
      const RowKind kind = placed.state->kindOf(input.nodes[i]);
      if (kind != RowKind::turn) sum -= input.force.dot(x[row]);  // a torque in space has no energy
      if (!input.targets.empty()) sum += input.stiffness / 2 * wayTo(input.targets[i], kind, x, row).squaredNorm();
    }
    forInside(placed, x, [&, k = input.stiffness](Index, double depth, const Vec3&) { sum += k / 2 * depth * depth; });
  }
  return sum;
}

void InputForces::addForce(ConstRows x, ConstRows v, Rows f) {
  for (auto& [number, placed] : inputs_) {
    const Input& input = placed.input;
    for (std::size_t i = 0; i < input.nodes.size(); ++i) {
      const Index row = placed.state->firstRow() + input.nodes[i];
      f[row] += input.force - input.damping * v[row];
      if (!input.targets.empty())
        f[row] += input.stiffness * wayTo(input.targets[i], placed.state->kindOf(input.nodes[i]), x, row);
    }
  }
  for (auto& [number, placed] : inputs_) {
    placed.touches.clear();
    forInside(placed, x, [&, &touches = placed.touches, &input = placed.input](Index row, double depth, const Vec3& n) {
      f[row] += (input.stiffness * depth - input.damping * n.dot(v[row])) * n;
      touches.push_back({row, n});
    });
  }
}

void InputForces::addStiffnessProduct(ConstRows dx, double factor, Rows df) const {
  forNodes([&](Index row, const Input& input, std::size_t) { df[row] -= factor * input.stiffness * dx[row]; });
  forTouches(
      [&](Index row, const Input& input, const Vec3& n) { df[row] -= factor * input.stiffness * n.dot(dx[row]) * n; });
}
void InputForces::addStiffness(double factor, BlockMatrix& matrix) const {
  forNodes([&](Index row, const Input& input, std::size_t) { addToDiagonal(row, -factor * input.stiffness, matrix); });
  forTouches([&](Index row, const Input& input, const Vec3& n) {
    addToDiagonal(row, along(n, -factor * input.stiffness), matrix);
  });
}
void InputForces::addStiffnessDiagonal(double factor, std::vector<double>& blocks) const {
  forNodes([&](Index row, const Input& input, std::size_t) { addToBlocks(row, -factor * input.stiffness, blocks); });
  forTouches([&](Index row, const Input& input, const Vec3& n) {
    addToBlocks(row, along(n, -factor * input.stiffness), blocks);
  });
}
void InputForces::addDampingProduct(ConstRows dv, double factor, Rows df) const {
  forNodes([&](Index row, const Input& input, std::size_t) { df[row] -= factor * input.damping * dv[row]; });
  forTouches(
      [&](Index row, const Input& input, const Vec3& n) { df[row] -= factor * input.damping * n.dot(dv[row]) * n; });
}
void InputForces::addDamping(double factor, BlockMatrix& matrix) const {
  forNodes([&](Index row, const Input& input, std::size_t) { addToDiagonal(row, -factor * input.damping, matrix); });
  forTouches([&](Index row, const Input& input, const Vec3& n) {
    addToDiagonal(row, along(n, -factor * input.damping), matrix);
  });
}
void InputForces::addDampingDiagonal(double factor, std::vector<double>& blocks) const {
  forNodes([&](Index row, const Input& input, std::size_t) { addToBlocks(row, -factor * input.damping, blocks); });
  forTouches([&](Index row, const Input& input, const Vec3& n) {
    addToBlocks(row, along(n, -factor * input.damping), blocks);
  });
}

}  // namespace stroma
