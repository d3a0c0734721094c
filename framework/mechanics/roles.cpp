// SPDX-License-Identifier: LGPL-2.1-or-later
// What force fields, masses and projective constraints share: the common attributes and the search for their state.
#include <stdexcept>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/mass.h"
#include "framework/mechanics/position_constraint.h"
#include "framework/mechanics/projective_constraint.h"
#include "framework/scene/usual_component.h"

namespace stroma {

namespace {

void declareState(DataTable& table, Link<State>& link) {
  table.addLink("mstate", link).help("mechanical state to act on; the one of this node or the nearest above by default");
}

void declareRayleigh(DataTable& table, const char* name, double& factor, const std::string& help, const char* unit) {
  table.add(name, factor).recompiled().help(help + ", added to the integrator's").unit(unit).min(0);
}

/// The state that `link` names, else the one of the component's node, else the nearest above.
State* findState(const Component& component, const Link<State>& link) {
  if (State* linked = link.get()) return linked;
  if (State* found = component.find<State>(true)) return found;
  throw ComponentError("this " + component.roleText() + " has no mechanical state to act on",
                       "a " + usualComponent(Part::state) + " in the same node or above, or mstate=\"@path\"");
}

/// Throws where the state has other rows than points and the component knows only these.
void refuseOtherRows(const Component& component, const State& state, bool takes_all) {
  if (takes_all || state.hasPointsOnly()) return;
  throw ComponentError(
      "this " + component.roleText() + " acts on points, and " + state.path() + " has " + (state.hasFrames() ? "rigid frames" : "numbers"),
      "a state of points (template=\"Vec3\")", state.hasFrames() ? "points that follow the frames by a mapping" : "");
}

}  // namespace

void ForceField::declare(DataTable& table) {
  declareState(table, mstate_);
  declareRayleigh(table, "rayleighStiffness", rayleigh_stiffness, "stiffness-proportional damping of this force field", "s");
}

void ForceField::init() {
  state_ = findState(*this, mstate_);
  refuseOtherRows(*this, *state_, takesAllRows());
}

// Reached only by a field whose traits promise a derivative that it does not override.
void ForceField::addDampingProduct(ConstRows, double, Rows) const {
  throw std::logic_error(type() + " depends on velocity and gives no derivative with respect to it");
}
void ForceField::addDamping(double, BlockMatrix&) const { addDampingProduct({}, 0, {}); }
void ForceField::addDampingDiagonal(double, std::vector<double>&) const { addDampingProduct({}, 0, {}); }

void ProjectiveConstraint::declare(DataTable& table) {
  declareState(table, mstate_);
  table.add("endTime", end_time_).help("the constraint is active in steps that start before this time; negative: always").unit("s");
  for (const char* name : {"showObject", "drawSize"}) table.addVisualOnly(name);
}

void ProjectiveConstraint::init() {
  state_ = findState(*this, mstate_);
  refuseOtherRows(*this, *state_, takesAllRows());
  if (end_time_ >= 0 && end_time_ <= node().root().root_time)
    warn("no step starts before endTime: the constraint is never active", "endTime=\"-1\" for always");
}

void PositionConstraint::declare(DataTable& table) { declareState(table, mstate_); }
void PositionConstraint::init() { state_ = findState(*this, mstate_); }

void Mass::declare(DataTable& table) {
  declareState(table, mstate_);
  declareRayleigh(table, "rayleighMass", rayleigh_mass, "mass-proportional damping of this mass", "1/s");
  table.add("movedAlone", moved_alone_)
      .help("the inertia of nodes moved by a constraint does not act on their neighbours, as in SOFA; otherwise that is an error");
  table.add("separateGravity", separate_gravity_)
      .help("accepted for SOFA scenes; gravity is always a constant force that is computed once");
  for (const char* name : {"showGravityCenter", "showAxisSizeFactor", "showInitialCenterOfGravity", "showX0"}) table.addVisualOnly(name);
}

void Mass::init() {
  state_ = findState(*this, mstate_);
  refuseOtherRows(*this, *state_, takesAllRows());
  if (separate_gravity_) inform("separateGravity has no effect: gravity is a constant force that is computed once");
}

}  // namespace stroma
