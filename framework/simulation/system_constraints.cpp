// SPDX-License-Identifier: LGPL-2.1-or-later
// Projective constraints of a system: which directions of which nodes may change, and what that means for masses.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "framework/simulation/system.h"

namespace stroma {

namespace {

bool byRow(const NodeProjector& a, const NodeProjector& b) { return a.row < b.row; }

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

// Room for all constraints at once, so that one that begins later allocates nothing.
void System::reserveConstraints() {
  std::vector<NodeProjector> all;
  bool prescribed = false;
  for (const ProjectiveConstraint* constraint : constraints_) {
    constraint->addProjectors(node_.root().root_time, all);
    constraint->addTies(gathered_ties_);
    prescribed = prescribed || constraint->prescribesMotion();
  }
  for (std::vector<NodeProjector>* list :
       {&gathered_, &projectors_, &velocity_projectors_, &moving_projectors_, &placed_})
    list->reserve(all.size() + 2 * gathered_ties_.size());
  shared_places_.reserve(all.size());
  if (prescribed) target_x_.resize(all_rows_), target_v_.resize(all_rows_);
}

// A constraint holds in a step that starts at or before its endTime (as in SOFA); its projectors are those of the
// step's end.
void System::gatherConstraints(double t_start, double t_end) {
  gathered_.clear();
  velocity_projectors_.clear();
  moving_projectors_.clear();
  gathered_ties_.clear();
  shared_places_.clear();
  for (std::size_t i = 0; i < constraints_.size(); ++i) {
    const ProjectiveConstraint* constraint = constraints_[i];
    if (!constraint->activeIn(t_start, t_end)) continue;
    constraint->addProjectors(t_end, gathered_);
    constraint->addTies(gathered_ties_);
    if (constraint->projectsVelocity()) constraint->addProjectors(t_end, velocity_projectors_);
    if (!constraint->prescribesMotion()) continue;
    const std::size_t first = moving_projectors_.size();
    constraint->addProjectors(t_end, moving_projectors_);
    shared_places_.add(int(i), moving_projectors_.data() + first,
                       moving_projectors_.data() + moving_projectors_.size());
  }
  shared_places_.keepShared();
  const bool regrouped = groups_.set(gathered_ties_, independent_rows_);
  if (regrouped) updateInverseMass();
  for (std::vector<NodeProjector>* list : {&gathered_, &velocity_projectors_, &moving_projectors_}) merge(*list);
  placed_.assign(moving_projectors_.begin(), moving_projectors_.end());
  for (std::vector<NodeProjector>* list : {&gathered_, &velocity_projectors_, &moving_projectors_})
    groups_.share(*list);
  if (same(gathered_, projectors_)) {
    revision_ += regrouped;
    return;
  }
  for (const NodeProjector& held : projectors_) projector_of_row_[held.row] = -1;
  projectors_.swap(gathered_);
  for (std::size_t i = 0; i < projectors_.size(); ++i) projector_of_row_[projectors_[i].row] = Index(i);
  ++revision_;
}

void System::beginStep(const StepContext& context) {
  setTime(context.t_end);
  misplaced_.clear();
  if (constraints_change_) gatherConstraints(context.t, context.t_end);
  applyProjectors(velocity_projectors_, v);
  if (!moving_projectors_.empty()) aimAtPrescribed(context);
  applyActingMappings();
}

void System::placePrescribed(const StepContext& context, Rows x_now, Rows v_now) const {
  if (moving_projectors_.empty()) return;
  // a constraint may follow a node that another one, later in the list, places: a chain of n needs n passes
  const auto moving = std::count_if(constraints_.begin(), constraints_.end(),
                                    [](const ProjectiveConstraint* c) { return c->prescribesMotion(); });
  SharedPlacements::Conflict conflict;
  for (std::ptrdiff_t pass = 0; pass < std::max<std::ptrdiff_t>(2, moving); ++pass) {
    for (std::size_t i = 0; i < constraints_.size(); ++i) {
      if (!constraints_[i]->prescribesMotion() || !constraints_[i]->activeIn(context.t, context.t_end)) continue;
      constraints_[i]->prescribe(context.t_end, x_now, v_now);
      if (!shared_places_.empty()) shared_places_.note(int(i), x_now, v_now);
    }
    if (!shared_places_.empty()) conflict = shared_places_.meet(x_now, v_now);
  }
  if (!shared_places_.empty()) misplaced_ = describeConflict(conflict);
  // a group goes where its placed member is
  for (const NodeProjector& placed : placed_) {
    const Index group = groups_.of(placed.row);
    if (group < 0) continue;
    const Mat3 held = Mat3::Identity() - placed.projector;
    for (const Index* row = groups_.begin(group); row != groups_.end(group); ++row) {
      x_now[*row] += held * (x_now[placed.row] - x_now[*row]);
      v_now[*row] += held * (v_now[placed.row] - v_now[*row]);
    }
  }
}

std::string System::describeConflict(const SharedPlacements::Conflict& conflict) const {
  if (conflict.row < 0) return {};
  return fmt::format(
      "{} cannot be where {} and {} put it: at the place between it is {:.3g} m from where the first does",
      describeRow(conflict.row), constraints_[conflict.a]->path(), constraints_[conflict.b]->path(), conflict.distance);
}

// What never moves can be judged before the first step.
void System::checkSharedPlaces(double start) {
  if (shared_places_.empty()) return;
  const auto isStill = [](const ProjectiveConstraint* c) {
    return !c->prescribesMotion() || (c->isConstant() && c->endTime() < 0);
  };
  if (!std::all_of(constraints_.begin(), constraints_.end(), isStill)) return;
  for (ProjectiveConstraint* constraint : constraints_)
    if (constraint->prescribesMotion()) constraint->beginMotion(start, x);
  StepContext context;
  context.t = context.t_end = start;
  copy(x, target_x_);
  copy(v, target_v_);
  placePrescribed(context, target_x_, target_v_);
  if (!misplaced_.empty())
    throw ComponentError(misplaced_, "constraints whose points, lines and planes have a point in common");
}

// The held directions get the constant velocity that reaches the end of the step where prescribe() wants them. What
// follows other nodes is aimed at where their present velocity takes them.
void System::aimAtPrescribed(const StepContext& context) {
  for (ProjectiveConstraint* constraint : constraints_)
    if (constraint->prescribesMotion() && constraint->activeIn(context.t, context.t_end))
      constraint->beginMotion(context.t, x);
  copy(x, target_x_);
  copy(v, target_v_);
  axpy(context.dt, v, target_x_);
  placePrescribed(context, target_x_, target_v_);
  for (const NodeProjector& moved : moving_projectors_) {
    const Vec3 speed = (target_x_[moved.row] - x[moved.row]) / context.dt;
    v[moved.row] += (Mat3::Identity() - moved.projector) * (speed - v[moved.row]);
  }
}

void System::endStep(const StepContext& context) {
  if (moving_projectors_.empty() && groups_.empty()) return;
  // what a direct solve leaves between tied rows is round-off; it must not add up
  groups_.average(x);
  groups_.average(v);
  placePrescribed(context, x, v);
  applyMappings();
}

void System::project(Rows vector) const {
  applyProjectors(projectors_, vector);
  groups_.average(vector);
}

// The nodes of a group start together: where one of them is held, else at their centre of mass and with its velocity.
void System::gatherGroups() {
  if (groups_.empty()) return;
  const std::vector<double> mass = lumpedMass();
  std::vector<NodeProjector> own;
  for (const ProjectiveConstraint* constraint : constraints_) constraint->addProjectors(node_.root().root_time, own);
  std::vector<char> is_held(std::size_t(independent_rows_), 0);
  for (const NodeProjector& held : own) is_held[held.row] |= held.projector.isZero(0);
  for (Index g = 0; g < groups_.count(); ++g) {
    const Index* held = std::find_if(groups_.begin(g), groups_.end(g), [&](Index row) { return is_held[row]; });
    double whole = 0;
    for (const Index* row = groups_.begin(g); row != groups_.end(g); ++row) whole += mass[std::size_t(*row)];
    for (Vector* vector : {&x, &v}) {
      Vec3 meeting = Vec3::Zero();
      for (const Index* row = groups_.begin(g); row != groups_.end(g); ++row)
        meeting += (whole > 0 ? mass[std::size_t(*row)] / whole : 1 / double(groups_.size(g))) * (*vector)[*row];
      if (held != groups_.end(g)) meeting = (*vector)[*held];
      for (const Index* row = groups_.begin(g); row != groups_.end(g); ++row) (*vector)[*row] = meeting;
    }
  }
}

// ---- masses and what is held ----

std::vector<char> System::rowsAlwaysHeld() const {
  std::vector<NodeProjector> always;
  for (const ProjectiveConstraint* constraint : constraints_)
    if (constraint->isConstant() && constraint->endTime() < 0) constraint->addProjectors(0, always);
  merge(always);
  std::vector<char> held(std::size_t(independent_rows_), 0);
  for (const NodeProjector& projector : always)
    if (projector.projector.isZero()) held[projector.row] = 1;
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
  const auto moving = std::find_if(constraints_.begin(), constraints_.end(),
                                   [](const ProjectiveConstraint* c) { return c->prescribesMotion(); });
  if (moving != constraints_.end() && !massIsDiagonal())
    throw ComponentError(
        fmt::format("{} moves nodes, and their inertia would not reach their neighbours through a mass "
                    "that is not diagonal",
                    (*moving)->path()),
        "a diagonal mass", "use DiagonalMass, or lumping=\"true\"");
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

const std::vector<double>& System::inverseLumpedMass() {
  requireMass();
  wants_inverse_mass_ = true;
  updateInverseMass();
  return inverse_mass_;
}

// The rows of a group get one over the mean of their masses: the mean that project() takes of their accelerations is
// then the sum of the forces over the sum of the masses.
void System::updateInverseMass() {
  if (!wants_inverse_mass_) return;
  const std::vector<char> held = rowsAlwaysHeld();
  inverse_mass_ = lumpedMass();
  groups_.average(inverse_mass_);
  for (std::size_t row = 0; row < inverse_mass_.size(); ++row) {
    if (!held[row] && !(inverse_mass_[row] > 0))
      throw ComponentError(
          "masses on mapped states (" + describeRow(Index(row)) + " has no other) have no lumped inverse",
          "an implicit integrator, or a mass on the state that is mapped from");
    inverse_mass_[row] = held[row] ? 0 : 1 / inverse_mass_[row];
  }
}

}  // namespace stroma
