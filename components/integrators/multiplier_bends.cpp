// SPDX-License-Identifier: LGPL-2.1-or-later
// Of the forces of constraint: how their gradients turn within a step, and bodies whose nodes answer one by one (multipliers.h).
#include <algorithm>

#include "components/integrators/multipliers.h"
#include "components/integrators/uncoupled_constraint_correction.h"
#include "components/integrators/whole_matrix.h"
#include "framework/scene/node.h"
#include "framework/simulation/integrator.h"

namespace stroma {

/// By how much more than A the turning of a gradient resists: with the compliance that the row itself has.
double Multipliers::shareOf(const LagrangianRows::Bend& bend) const {
  double sum = 0;
  for (const auto& entry : rows_.entriesOf(bend)) sum += entry.gradient.squaredNorm();
  const double size = solve_.sizes[bend.row];
  return size > 0 ? solve_.l[Eigen::Index(bend.row)] * bend.size * own_[bend.row] * sum / (size * size) : 0;
}

/// B and S, with the forces that rows had last. Each costs a solve: those of rows that do not push are left out where iterates come
/// to rest without them.
void Multipliers::takeBends() {
  constexpr double little = 0.2;
  bend_count_ = 0;
  if (!knows_forces_ || solve_.l.size() != Eigen::Index(rows_.rows().size())) return;
  for (const LagrangianRows::Bend& bend : rows_.bends()) {
    if (rows_.rows()[bend.row].kind != LagrangianRows::Kind::push && !(shareOf(bend) > little)) continue;
    const double size = rule_.weight * rule_.displacement * solve_.l[Eigen::Index(bend.row)] * bend.size;
    if (!(size > 0)) continue;
    if (bends_.size() == bend_count_) bends_.emplace_back();
    Bend& taken = bends_[bend_count_++];
    taken.size = size;
    if (taken.b.count() != system_->independentRows()) taken.b.resize(system_->independentRows());
    pullBack(rows_.entriesOf(bend), taken.b);
  }
}

/// Y, and the factors of S^-1 + B^T Y.
bool Multipliers::respondToBends(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report) {
  const auto count = Eigen::Index(bend_count_);
  if (count == 0) return true;
  Eigen::MatrixXd& small = bend_matrix_;
  small.resize(count, count);
  asked_.clear(), answers_.clear();
  for (std::size_t i = 0; i < bend_count_; ++i) ask(bends_[i].b, bends_[i].y);
  if (!answerAsked(solver, matrix, stop, report)) return false;
  for (Eigen::Index i = 0; i < count; ++i) {
    Bend& bend = bends_[std::size_t(i)];
    for (Eigen::Index j = 0; j < count; ++j) small(j, i) = dot(bends_[std::size_t(j)].b, bend.y);
    small(i, i) += 1 / bend.size;
  }
  bent_.compute(small);
  return true;
}

/// What A^-1 has answered becomes what A + B S B^T answers.
void Multipliers::takeBendsFrom(Rows response) {
  if (bend_count_ == 0) return;
  along_bends_.resize(Eigen::Index(bend_count_));
  for (std::size_t i = 0; i < bend_count_; ++i) along_bends_[Eigen::Index(i)] = dot(bends_[i].b, response);
  bend_shares_.noalias() = bent_.solve(along_bends_);
  for (std::size_t i = 0; i < bend_count_; ++i) axpy(-bend_shares_[Eigen::Index(i)], bends_[i].y, response);
}

std::vector<UncoupledConstraintCorrection*> Multipliers::findUncoupled() const {
  std::vector<UncoupledConstraintCorrection*> found;
  system_->integrator().node().root().collect(found);
  const std::vector<State*>& states = system_->states();
  std::erase_if(found, [&](const UncoupledConstraintCorrection* each) {
    return std::find(states.begin(), states.end(), &each->state()) == states.end() ||
           each->state().firstRow() >= system_->independentRows();
  });
  return found;
}

/// Nodes that answer by themselves are left out of the right sides, and each side may then be nothing.
SolveReport Multipliers::solveInTurn(LinearSolver& solver, SystemMatrix& matrix, StopToken stop) {
  SolveReport all{.stop = SolveStop::zero_right_side};
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    copy(asked_[i], pushes_);
    if (asked_[i].data != right_side_.rows().data) copy(pushes_, right_side_);
    for (const UncoupledConstraintCorrection* each : uncoupled_) clear(each->state().segment(Rows(right_side_)));
    if (largest(right_side_) > 0 && !all.add(solveWhole(solver, matrix, right_side_, answers_[i], {.stop = stop}))) break;
    for (const UncoupledConstraintCorrection* each : uncoupled_) each->respond(pushes_, answers_[i]);
  }
  return all;
}

}  // namespace stroma
