// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/input_forces.h"

#include <algorithm>

namespace stroma {
namespace {

void addToDiagonal(Index row, double value, BlockMatrix& matrix) {
  matrix.add(matrix.diagonal()[row], value * Mat3::Identity());
}

void addToBlocks(Index row, double value, std::vector<double>& blocks) {
  for (std::size_t c = 0; c < 3; ++c) blocks[9 * std::size_t(row) + 4 * c] += value;
}

}  // namespace

InputForces::InputForces(State& state) {
  standBeside(state, "inputs");
  mstate_.set(&state);
  init();
}

bool InputForces::set(long number, const Input& input, Index first_row) {
  const auto found = inputs_.find(number);
  const bool same =
      found != inputs_.end() && found->second.input.hasDerivativesOf(input) && found->second.first_row == first_row;
  inputs_[number] = {input, first_row};
  return !same;
}

bool InputForces::remove(long number) { return inputs_.erase(number) > 0; }

bool InputForces::isDamped() const {
  return std::any_of(inputs_.begin(), inputs_.end(), [](const auto& entry) { return entry.second.input.damping > 0; });
}

ForceTraits InputForces::traits() const {
  ForceTraits traits;
  traits.linear = traits.constant_stiffness = traits.symmetric = traits.conservative = traits.exact_tangent = true;
  traits.velocity_dependent = isDamped();
  return traits;
}

ForceField::Cost InputForces::cost() const {
  std::size_t nodes = 0;
  forNodes([&nodes](Index, const Input&, std::size_t) { ++nodes; });
  return {2.5 * double(nodes), 2.5 * double(nodes)};
}

double InputForces::energy(ConstRows x) const {
  double sum = 0;
  forNodes([&](Index row, const Input& input, std::size_t i) {
    sum -= input.force.dot(x[row]);
    if (!input.targets.empty()) sum += input.stiffness / 2 * (x[row] - input.targets[i]).squaredNorm();
  });
  return sum;
}

void InputForces::addForce(ConstRows x, ConstRows v, Rows f) {
  forNodes([&](Index row, const Input& input, std::size_t i) {
    f[row] += input.force - input.damping * v[row];
    if (!input.targets.empty()) f[row] += input.stiffness * (input.targets[i] - x[row]);
  });
}

void InputForces::addStiffnessProduct(ConstRows dx, double factor, Rows df) const {
  forNodes([&](Index row, const Input& input, std::size_t) { df[row] -= factor * input.stiffness * dx[row]; });
}
void InputForces::addStiffness(double factor, BlockMatrix& matrix) const {
  forNodes([&](Index row, const Input& input, std::size_t) { addToDiagonal(row, -factor * input.stiffness, matrix); });
}
void InputForces::addStiffnessDiagonal(double factor, std::vector<double>& blocks) const {
  forNodes([&](Index row, const Input& input, std::size_t) { addToBlocks(row, -factor * input.stiffness, blocks); });
}
void InputForces::addDampingProduct(ConstRows dv, double factor, Rows df) const {
  forNodes([&](Index row, const Input& input, std::size_t) { df[row] -= factor * input.damping * dv[row]; });
}
void InputForces::addDamping(double factor, BlockMatrix& matrix) const {
  forNodes([&](Index row, const Input& input, std::size_t) { addToDiagonal(row, -factor * input.damping, matrix); });
}
void InputForces::addDampingDiagonal(double factor, std::vector<double>& blocks) const {
  forNodes([&](Index row, const Input& input, std::size_t) { addToBlocks(row, -factor * input.damping, blocks); });
}

}  // namespace stroma
