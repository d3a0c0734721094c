// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/prescribed_motion.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/mechanics/start_velocity.h"

namespace stroma {

PrescribedMotion::PrescribedMotion(const Actors& actors, const NodeGroups& groups) : actors_(actors), groups_(groups) {}

void PrescribedMotion::reserve(std::size_t count) {
  for (std::vector<NodeProjector>* list : {&moving_, &placed_}) list->reserve(count);
  shared_.reserve(count);
  for (Vector* vector : {&target_x_, &target_v_}) vector->resize(actors_.all_rows);
}

void PrescribedMotion::clear() {
  moving_.clear();
  shared_.clear();
}

void PrescribedMotion::add(std::size_t constraint, double t_end) {
  const std::size_t first = moving_.size();
  actors_.constraints[constraint]->addProjectors(t_end, moving_);
  shared_.add(int(constraint), moving_.data() + first, moving_.data() + moving_.size());
}

void PrescribedMotion::finish() {
  shared_.keepShared();
  mergeByRow(moving_);
  placed_.assign(moving_.begin(), moving_.end());
  groups_.share(moving_);
}

void PrescribedMotion::place(const StepContext& context, double t, Rows x, Rows v) const {
  if (moving_.empty()) return;
  // a constraint may follow a node that another one, later in the list, places: a chain of n needs n passes
  const auto moving = std::count_if(actors_.constraints.begin(), actors_.constraints.end(),
                                    [](const ProjectiveConstraint* c) { return c->prescribesMotion(); });
  // turns that several place meet to second order in each pass
  const std::ptrdiff_t least = shared_.empty() ? 2 : 4;
  for (std::ptrdiff_t pass = 0; pass < std::max(least, moving); ++pass) placeOnce(context, t, x, v);
  placeGroups(x, v);
}

void PrescribedMotion::placeOnce(const StepContext& context, double t, Rows x, Rows v) const {
  for (std::size_t i = 0; i < actors_.constraints.size(); ++i) {
    const ProjectiveConstraint& constraint = *actors_.constraints[i];
    if (!constraint.prescribesMotion() || !constraint.activeIn(context.t, context.t_end)) continue;
    constraint.prescribe(t, x, v);
    if (!shared_.empty()) shared_.note(int(i), x, v);
  }
  if (!shared_.empty()) misplaced_ = describeConflict(shared_.meet(actors_.motion, x, v));
}

// A group goes where its placed member is.
void PrescribedMotion::placeGroups(Rows x, Rows v) const {
  for (const NodeProjector& placed : placed_) {
    const Index group = groups_.of(placed.row);
    if (group < 0) continue;
    const Mat3 held = Mat3::Identity() - placed.projector;
    for (const Index* row = groups_.begin(group); row != groups_.end(group); ++row) {
      actors_.motion.advanceRow(held * actors_.motion.increment(x, x, *row, placed.row), x, *row);
      v[*row] += held * (v[placed.row] - v[*row]);
    }
  }
}

std::string PrescribedMotion::describeConflict(const SharedPlacements::Conflict& conflict) const {
  if (conflict.row < 0) return {};
  return fmt::format("{} cannot be where both {} and {} put it: the compromise is {:.3g} {} from the position of the first",
                     actors_.describeRow(conflict.row), actors_.constraints[std::size_t(conflict.a)]->path(),
                     actors_.constraints[std::size_t(conflict.b)]->path(), conflict.distance,
                     actors_.motion.kindOf(conflict.row) == RowKind::turn ? "rad" : "m");
}

// What never moves can be judged before the first step.
void PrescribedMotion::check(double start, ConstRows x, ConstRows v) {
  if (shared_.empty()) return;
  const auto isStill = [](const ProjectiveConstraint* c) { return !c->prescribesMotion() || (c->isConstant() && c->endTime() < 0); };
  if (!std::all_of(actors_.constraints.begin(), actors_.constraints.end(), isStill)) return;
  for (ProjectiveConstraint* constraint : actors_.constraints)
    if (constraint->prescribesMotion()) constraint->beginMotion(start, x);
  StepContext context;
  context.t = context.t_end = start;
  copy(x, target_x_);
  copy(v, target_v_);
  place(context, start, target_x_, target_v_);
  if (!misplaced_.empty()) throw ComponentError(misplaced_, "constraints whose points, lines and planes have a point in common");
}

void PrescribedMotion::aim(const StepContext& context, ConstRows x, Rows v) {
  if (moving_.empty()) return;
  for (ProjectiveConstraint* constraint : actors_.constraints)
    if (constraint->prescribesMotion() && constraint->activeIn(context.t, context.t_end)) constraint->beginMotion(context.t, x);
  copy(x, target_x_);
  copy(v, target_v_);
  std::vector<std::pair<Index, Vec3>> kept;  // of a few constraints, as SOFA's: see StartVelocity
  for (const ProjectiveConstraint* constraint : actors_.constraints) {
    const auto* keeper = constraint->prescribesMotion() ? dynamic_cast<const StartVelocity*>(constraint) : nullptr;
    if (!keeper || !keeper->keepsStartVelocity() || !constraint->activeIn(context.t, context.t_end)) continue;
    std::vector<NodeProjector> own;
    constraint->addProjectors(context.t_end, own);
    constraint->prescribe(context.t, target_x_, target_v_);
    for (const NodeProjector& moved : own) kept.emplace_back(moved.row, target_v_[moved.row]);
    copy(x, target_x_);
    copy(v, target_v_);
  }
  actors_.motion.advance(context.dt, v, target_x_);
  place(context, context.t_end, target_x_, target_v_);
  for (const NodeProjector& moved : moving_) {
    const Vec3 speed = actors_.motion.increment(x, target_x_, moved.row) / context.dt;
    v[moved.row] += (Mat3::Identity() - moved.projector) * (speed - v[moved.row]);
  }
  for (const auto& [row, velocity] : kept) v[row] = velocity;
}

}  // namespace stroma
