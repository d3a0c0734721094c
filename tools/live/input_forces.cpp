// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/input_forces.h"

#include <algorithm>
#include <utility>

#include "framework/mechanics/frames.h"
#include "framework/scene/usual_component.h"

namespace stroma {
namespace {

void addToDiagonal(Index row, double value, BlockMatrix& matrix) {
  matrix.add(matrix.diagonal()[row], value * Mat3::Identity());
}

void addToBlocks(Index row, double value, std::vector<double>& blocks) {
  for (std::size_t c = 0; c < 3; ++c) blocks[9 * std::size_t(row) + 4 * c] += value;
}
/// From where row `row` is to a target, as an increment.
Vec3 wayTo(const Vec3& target, RowKind kind, ConstRows x, Index row) {
  if (kind != RowKind::turn) return target - x[row];
  return rotationVector(turnedBy(target) * orientationIn(x, row).conjugate());
}

std::unique_ptr<BallForce> makeBall() {
  std::unique_ptr<Component> made = makeUsual(Part::ball);
  auto& ball = dynamic_cast<BallForce&>(*made);
  made.release();
  return std::unique_ptr<BallForce>(&ball);
}

}  // namespace

InputForces::InputForces(State& state) {
  standBeside(state, "inputs");
  mstate_.set(&state);
  init();
}

bool InputForces::set(long number, const Input& input, State& state) {
  const auto known = inputs_.find(number);
  const bool is_known = known != inputs_.end();
  const bool same = is_known && known->second.input.hasDerivativesOf(input) && known->second.state == &state;
  std::unique_ptr<BallForce> ball = is_known ? std::move(known->second.ball) : nullptr;
  if (input.ball) {
    if (!ball) ball = makeBall();
    ball->actAs(input, state);
  }
  inputs_[number] = {input, &state, input.ball ? std::move(ball) : nullptr};
  return !same;
}

bool InputForces::remove(long number) { return inputs_.erase(number) > 0; }

bool InputForces::isDamped() const {
  return std::any_of(inputs_.begin(), inputs_.end(), [](const auto& entry) { return entry.second.input.damping > 0; });
}

ForceTraits InputForces::traits() const {
  ForceTraits traits;
  traits.symmetric = traits.conservative = true;
  traits.linear = traits.constant_stiffness = traits.exact_tangent = !turnsAny();
  traits.velocity_dependent = isDamped();
  forBalls([&traits](const BallForce&) { traits.linear = traits.constant_stiffness = traits.exact_tangent = false; });
  return traits;
}

ForceField::Cost InputForces::cost() const {
  std::size_t nodes = 0;
  forNodes([&nodes](Index, const Input&, std::size_t) { ++nodes; });
  // the few nodes inside a ball come and go: what is chosen by costs is not to depend on them
  forBalls([&nodes](const BallForce&) { ++nodes; });
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
    if (placed.ball) sum += placed.ball->energy(x);
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
  forBalls([&](BallForce& ball) { ball.addForce(x, v, f); });
}

void InputForces::addStiffnessProduct(ConstRows dx, double factor, Rows df) const {
  forNodes([&](Index row, const Input& input, std::size_t) { df[row] -= factor * input.stiffness * dx[row]; });
  forBalls([&](const BallForce& ball) { ball.addStiffnessProduct(dx, factor, df); });
}
void InputForces::addStiffness(double factor, BlockMatrix& matrix) const {
  forNodes([&](Index row, const Input& input, std::size_t) { addToDiagonal(row, -factor * input.stiffness, matrix); });
  forBalls([&](const BallForce& ball) { ball.addStiffness(factor, matrix); });
}
void InputForces::addStiffnessDiagonal(double factor, std::vector<double>& blocks) const {
  forNodes([&](Index row, const Input& input, std::size_t) { addToBlocks(row, -factor * input.stiffness, blocks); });
  forBalls([&](const BallForce& ball) { ball.addStiffnessDiagonal(factor, blocks); });
}
void InputForces::addDampingProduct(ConstRows dv, double factor, Rows df) const {
  forNodes([&](Index row, const Input& input, std::size_t) { df[row] -= factor * input.damping * dv[row]; });
  forBalls([&](const BallForce& ball) { ball.addDampingProduct(dv, factor, df); });
}
void InputForces::addDamping(double factor, BlockMatrix& matrix) const {
  forNodes([&](Index row, const Input& input, std::size_t) { addToDiagonal(row, -factor * input.damping, matrix); });
  forBalls([&](const BallForce& ball) { ball.addDamping(factor, matrix); });
}
void InputForces::addDampingDiagonal(double factor, std::vector<double>& blocks) const {
  forNodes([&](Index row, const Input& input, std::size_t) { addToBlocks(row, -factor * input.damping, blocks); });
  forBalls([&](const BallForce& ball) { ball.addDampingDiagonal(factor, blocks); });
}

}  // namespace stroma
