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
  bends_.clear();
  if (!knows_forces_ || solve_.l.size() != Eigen::Index(rows_.rows().size())) return;
  for (const LagrangianRows::Bend& bend : rows_.bends()) {
    if (rows_.rows()[bend.row].kind != LagrangianRows::Kind::push && !(shareOf(bend) > little)) continue;
    const double size = rule_.weight * rule_.displacement * solve_.l[Eigen::Index(bend.row)] * bend.size;
    if (!(size > 0)) continue;
    pullBack(rows_.entriesOf(bend), bends_.add(size, system_->independentRows()));
  }
}

/// Y, and the factors of S^-1 + B^T Y.
bool Multipliers::respondToBends(LinearSolver& solver, SystemMatrix& matrix, StopToken stop, StepReport& report) {
  if (bends_.empty()) return true;
  requested_.clear(), solutions_.clear();
  for (GradientBends::Bend& bend : bends_.all()) request(bend.b, bend.y);
  if (!solveRequested(solver, matrix, stop, report)) return false;
  bends_.factor();
  return true;
}

Vector& GradientBends::add(double size, Index rows) {
  if (bends_.size() == count_) bends_.emplace_back();
  Bend& bend = bends_[count_++];
  bend.size = size;
  if (bend.b.count() != rows) bend.b.resize(rows);
  return bend.b;
}

void GradientBends::factor() {
  const auto count = Eigen::Index(count_);
  matrix_.resize(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    Bend& bend = bends_[std::size_t(i)];
    for (Eigen::Index j = 0; j < count; ++j) matrix_(j, i) = dot(bends_[std::size_t(j)].b, bend.y);
    matrix_(i, i) += 1 / bend.size;
  }
  factors_.compute(matrix_);
}

void GradientBends::takeFrom(Rows response) {
  if (count_ == 0) return;
  along_.resize(Eigen::Index(count_));
  for (std::size_t i = 0; i < count_; ++i) along_[Eigen::Index(i)] = dot(bends_[i].b, response);
  shares_.noalias() = factors_.solve(along_);
  for (std::size_t i = 0; i < count_; ++i) axpy(-shares_[Eigen::Index(i)], bends_[i].y, response);
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
  for (std::size_t i = 0; i < requested_.size(); ++i) {
    copy(requested_[i], pushes_);
    if (requested_[i].data != right_side_.rows().data) copy(pushes_, right_side_);
    for (const UncoupledConstraintCorrection* each : uncoupled_) clear(each->state().segment(Rows(right_side_)));
    if (largest(right_side_) > 0 && !all.add(solveWhole(solver, matrix, right_side_, solutions_[i], {.stop = stop}))) break;
    for (const UncoupledConstraintCorrection* each : uncoupled_) each->respond(pushes_, solutions_[i]);
  }
  return all;
}

}  // namespace stroma
