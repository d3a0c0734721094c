// SPDX-License-Identifier: LGPL-2.1-or-later
// Projective constraints of a system: which directions of which nodes may change, and what that means for masses.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cstring>

#include "framework/simulation/system.h"

namespace stroma {

namespace {

bool byRow(const NodeProjector& a, const NodeProjector& b) { return a.row < b.row; }

/// The projector onto the directions that both leave free: the null space of (I - P_a) + (I - P_b).
Mat3 intersection(const Mat3& a, const Mat3& b) {
  if (a.isZero(0) || b.isZero(0)) return Mat3::Zero();
  Eigen::SelfAdjointEigenSolver<Mat3> eigen;
  eigen.computeDirect(2 * Mat3::Identity() - a - b);
  Mat3 result = Mat3::Zero();
  for (int i = 0; i < 3; ++i)
    if (std::abs(eigen.eigenvalues()[i]) < 1e-7)
      result += eigen.eigenvectors().col(i) * eigen.eigenvectors().col(i).transpose();
  return result;
}

/// Sorts by row and leaves one projector a row.
void merge(std::vector<NodeProjector>& list) {
  std::sort(list.begin(), list.end(), byRow);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (kept > 0 && list[kept - 1].row == list[i].row) {
      list[kept - 1].projector = intersection(list[kept - 1].projector, list[i].projector);
    } else {
      list[kept++] = list[i];
    }
  }
  list.resize(kept);
}

bool same(const std::vector<NodeProjector>& a, const std::vector<NodeProjector>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const NodeProjector& p, const NodeProjector& q) {
    return p.row == q.row && p.projector == q.projector;
  });
}

void applyProjectors(const std::vector<NodeProjector>& projectors, Rows vector) {
  for (const NodeProjector& held : projectors) vector[held.row] = (held.projector * vector[held.row]).eval();
}

}  // namespace

// A constraint holds in a step that starts at or before its endTime (as in SOFA); its projectors are those of the
// step's end.
void System::gatherConstraints(double t_start, double t_end) {
  gathered_.clear();
  velocity_projectors_.clear();
  for (const ProjectiveConstraint* constraint : constraints_) {
    if (!constraint->activeAt(t_start)) continue;
    constraint->addProjectors(t_end, gathered_);
    if (constraint->projectsVelocity()) constraint->addProjectors(t_end, velocity_projectors_);
  }
  merge(gathered_);
  merge(velocity_projectors_);
  if (same(gathered_, projectors_)) return;
  for (const NodeProjector& held : projectors_) projector_of_row_[std::size_t(held.row)] = -1;
  projectors_.swap(gathered_);
  for (std::size_t i = 0; i < projectors_.size(); ++i) projector_of_row_[std::size_t(projectors_[i].row)] = Index(i);
  ++revision_;
}

void System::beginStep(const StepContext& context) {
  setTime(context.t_end);
  if (constraints_change_) gatherConstraints(context.t, context.t_end);
  applyProjectors(velocity_projectors_, v);
  for (const ProjectiveConstraint* constraint : constraints_)
    if (constraint->activeAt(context.t)) constraint->impose(context.t, context.dt, x, v);
  applyMappings();
}

void System::project(Rows vector) const { applyProjectors(projectors_, vector); }

// ---- masses and what is held ----

std::vector<char> System::rowsAlwaysHeld() const {
  std::vector<NodeProjector> always;
  for (const ProjectiveConstraint* constraint : constraints_)
    if (constraint->isConstant() && constraint->endTime() < 0) constraint->addProjectors(0, always);
  merge(always);
  std::vector<char> held(std::size_t(independent_rows_), 0);
  for (const NodeProjector& projector : always)
    if (projector.projector.isZero()) held[std::size_t(projector.row)] = 1;
  return held;
}

std::vector<double> System::lumpedMass() const {
  std::vector<double> sums(std::size_t(independent_rows_), 0.0);
  for (const Mass* mass : masses_) {
    const std::size_t first = std::size_t(mass->state().firstRow());
    if (first >= sums.size()) continue;
    const std::vector<double>& lumped = mass->lumped();
    for (std::size_t i = 0; i < lumped.size(); ++i) sums[first + i] += lumped[i];
  }
  return sums;
}

// A mass on a mapped state gives mass to the nodes it is mapped from; which ones, only the mapping knows, so a state
// with a mapped one below it is let through.
void System::requireMass() const {
  const std::vector<char> held = rowsAlwaysHeld();
  const std::vector<double> mass = lumpedMass();
  for (const State* state : states_) {
    if (state->firstRow() >= independent_rows_) continue;
    const bool feeds_mapping = std::any_of(mappings_.begin(), mappings_.end(),
                                           [state](const Mapping* mapping) { return &mapping->input() == state; });
    if (feeds_mapping) continue;
    const bool has_mass =
        std::any_of(masses_.begin(), masses_.end(), [state](const Mass* m) { return &m->state() == state; });
    for (Index i = 0; i < state->size(); ++i) {
      const std::size_t row = std::size_t(state->firstRow() + i);
      if (held[row] || mass[row] > 0) continue;
      if (!has_mass)
        throw ComponentError(fmt::format("{} has no mass, so its motion is not defined", state->path()),
                             "a mass in the state's node", "add <UniformMass totalMass=\"1\"/>");
      throw ComponentError(
          fmt::format("node {} of {} has a mass of {} kg, so its motion is not defined", i, state->path(), mass[row]),
          "a positive mass at every node that is not held");
    }
  }
}

std::vector<double> System::inverseLumpedMass() const {
  requireMass();
  const std::vector<char> held = rowsAlwaysHeld();
  std::vector<double> inverse = lumpedMass();
  for (std::size_t row = 0; row < inverse.size(); ++row) {
    if (!held[row] && !(inverse[row] > 0))
      throw ComponentError(
          "masses on mapped states (" + describeRow(Index(row)) + " has no other) have no lumped inverse",
          "an implicit integrator, or a mass on the state that is mapped from");
    inverse[row] = held[row] ? 0 : 1 / inverse[row];
  }
  return inverse;
}

}  // namespace stroma
