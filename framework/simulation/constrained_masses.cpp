// SPDX-License-Identifier: LGPL-2.1-or-later
// Masses under the constraints of a system: which nodes need one, and the inverse that explicit steps use.
#include <algorithm>

#include "framework/simulation/constraint_set.h"
#include "framework/simulation/refusals.h"

namespace stroma {

namespace {

/// Row sums of all masses on independent rows [kg].
std::vector<double> lumpedMass(const Actors& actors) {
  std::vector<double> sums(std::size_t(actors.independent_rows), 0.0);
  for (const Mass* mass : actors.masses) {
    const std::size_t first = std::size_t(mass->state().firstRow());
    if (first >= sums.size()) continue;
    const std::vector<double>& lumped = mass->lumped();
    for (std::size_t i = 0; i < lumped.size(); ++i) sums[first + i] += lumped[i];
  }
  return sums;
}

/// 1 for rows that are held in all directions at all times, 0 for the others.
std::vector<char> rowsAlwaysHeld(const Actors& actors) {
  std::vector<NodeProjector> always;
  for (const ProjectiveConstraint* constraint : actors.constraints)
    if (constraint->isConstant() && constraint->endTime() < 0) constraint->addProjectors(0, always);
  mergeByRow(always);
  std::vector<char> held(std::size_t(actors.independent_rows), 0);
  for (const NodeProjector& projector : always)
    if (projector.projector.isZero()) held[std::size_t(projector.row)] = 1;
  return held;
}

}  // namespace

// A mass on a mapped state gives mass to the nodes it is mapped from; which ones, only the mapping knows, so a state
// with a mapped one below it is let through.
void ConstraintSet::requireMass() const {
  checkMassesUnderMotion(actors_);
  const std::vector<char> held = rowsAlwaysHeld(actors_);
  const std::vector<double> mass = lumpedMass(actors_);
  for (const State* state : actors_.states) {
    if (state->firstRow() >= actors_.independent_rows) continue;
    const bool feeds_mapping = std::any_of(actors_.mappings.begin(), actors_.mappings.end(), [state](const Mapping* mapping) {
      const std::vector<State*> inputs = mapping->inputs();
      return std::find(inputs.begin(), inputs.end(), state) != inputs.end();
    });
    if (!feeds_mapping) checkMassOf(*state, actors_, held, mass);
  }
}

const std::vector<double>& ConstraintSet::inverseLumpedMass() {
  requireMass();
  wants_inverse_mass_ = true;
  updateInverseMass();
  return inverse_mass_;
}

// The rows of a group get one over the mean of their masses: the mean that project() takes of their accelerations is
// then the sum of the forces over the sum of the masses.
void ConstraintSet::updateInverseMass() {
  if (!wants_inverse_mass_) return;
  const std::vector<char> held = rowsAlwaysHeld(actors_);
  inverse_mass_ = lumpedMass(actors_);
  groups_.average(inverse_mass_);
  for (std::size_t row = 0; row < inverse_mass_.size(); ++row) {
    if (!held[row] && !(inverse_mass_[row] > 0))
      throw ComponentError("masses on mapped states (" + actors_.describeRow(Index(row)) + " has no other) have no lumped inverse",
                           "an implicit integrator, or a mass on the state that is mapped from");
    inverse_mass_[row] = held[row] ? 0 : 1 / inverse_mass_[row];
  }
}

// 1/m of each row, zero without a mass: what a constraint's force does to the nodes of a relation.
std::vector<double> ConstraintSet::relationWeights() const {
  std::vector<double> weights = lumpedMass(actors_);
  groups_.average(weights);
  for (double& weight : weights) weight = weight > 0 ? 1 / weight : 0;
  return weights;
}

// The nodes of a group start together: where one of them is held, in the directions that hold it, else at their centre of mass.
void ConstraintSet::meetGroups(double start, Rows x, Rows v) const {
  if (groups_.empty()) return;
  const std::vector<double> mass = lumpedMass(actors_);
  std::vector<NodeProjector> own;
  for (const ProjectiveConstraint* constraint : all()) constraint->addProjectors(start, own);
  mergeByRow(own);
  std::vector<const NodeProjector*> holds(std::size_t(actors_.independent_rows), nullptr);
  for (const NodeProjector& each : own) holds[std::size_t(each.row)] = &each;
  const auto isHeld = [&](Index row) { return holds[std::size_t(row)] && holds[std::size_t(row)]->projector.isZero(0); };
  for (Index g = 0; g < groups_.count(); ++g) {
    const Index *begin = groups_.begin(g), *end = groups_.end(g);
    const Index* held = std::find_if(begin, end, isHeld);
    double whole = 0;
    for (const Index* row = begin; row != end; ++row) whole += mass[std::size_t(*row)];
    const auto share = [&](Index row) { return whole > 0 ? mass[std::size_t(row)] / whole : 1 / double(groups_.size(g)); };
    for (Rows vector : {x, v}) {
      if (vector.data == x.data && actors_.motion.kindOf(*begin) == RowKind::turn) continue;
      Vec3 meeting = Vec3::Zero();
      for (const Index* row = begin; row != end; ++row) meeting += share(*row) * vector[*row];
      for (const Index* row = begin; row != end; ++row)
        if (const NodeProjector* at = holds[*row]) meeting += (Mat3::Identity() - at->projector) * (vector[*row] - meeting);
      if (held != end) meeting = vector[*held];
      for (const Index* row = begin; row != end; ++row) vector[*row] = meeting;
    }
    if (actors_.motion.kindOf(*begin) != RowKind::turn) continue;
    // the mean turn, seen from one of them
    const Index first = held != end ? *held : *begin;
    Vec3 turn = Vec3::Zero();
    for (const Index* row = begin; held == end && row != end; ++row) turn += share(*row) * actors_.motion.increment(x, x, first, *row);
    actors_.motion.advanceRow(turn, x, first);
    for (const Index* row = begin; row != end; ++row)
      if (*row != first) std::copy_n(x.data + std::size_t(first) * row_doubles, row_doubles, x.data + std::size_t(*row) * row_doubles);
  }
}

}  // namespace stroma
