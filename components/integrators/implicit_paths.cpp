// SPDX-License-Identifier: LGPL-2.1-or-later
// Part of an implicit step: how far it may go with possible contact, prescribed motion meanwhile, and the rotation of stresses
// in its tangent.
#include <limits>
#include <utility>

#include "components/integrators/implicit_step.h"

namespace stroma {

/// With contact: what is free goes on as it did, as far as nothing is in its way. A body that is drawn along, pressed or folded
/// then has a part of the iterations to make, as where it starts all of its motion is missing. What moves by round-off rests.
bool ImplicitStep::guess(Rows d) {
  if (!std::exchange(is_to_guess_, false)) return false;
  copy(v0_, d);
  axpy(-1, v(), d);
  system_->constraints().project(d);
  return scheme_.displacement * largest(d) > std::numeric_limits<double>::epsilon() * largest(x());
}

double ImplicitStep::longestStep(ConstRows d) {
  if (!limits_.bends()) return limits_.longest(d, scheme_.displacement);
  copy(v(), work_);
  return limits_.longest(d, scheme_.displacement, false, false, [&](double s) {
    copy(work_, v());
    addTo(v(), s, d);
    unknownsChanged();
  });
}

bool ImplicitStep::updatesLagged() {
  turns_ = true;  // what is solved again is nearer to its end
  return carries() || limits_.solvesAgain();
}

/// That of what is held is -A du, with the tangent A before what is held is taken out of it.
bool ImplicitStep::addPush(Rows residual) {
  System& s = *system_;
  const Rows push = s.independent(right_side_);
  if (limits_.hasRemainingMotion())
    limits_.push(right_side_), scale(scheme_.weight, push);
  else
    clear(push);
  if (carries()) {
    const MatrixFactors factors = tangentFactors();
    copy(carried_, work_);
    scale(-lack_ / scheme_.displacement, work_);
    s.addMassProduct(work_, factors.mass, push);
    s.addStiffnessProduct(work_, factors, push);
  }
  s.constraints().project(push);
  axpy(1, push, residual);
  return largest(push) > 0;
}

bool ImplicitStep::advanceRemainingMotion(Rows d, bool wholly) {
  if (lack_ > 0) axpy(lack_ / scheme_.displacement, carried_, d);
  copy(v(), work_);
  const auto goTo = [&](double s, RowRange rows) {
    copy(rows.of(ConstRows(work_)), rows.of(v()));
    addTo(v(), s, d, rows);
    place(rows);
  };
  const double h = scheme_.displacement;
  const auto longest = [&] {
    const RowRange rows = rowsMovedBy(d);  // where nothing gives way yet, few
    return limits_.longest(d, h, true, true, [&](double s) { goTo(s, rows); });
  };
  const double part = limits_.bends() ? longest() : limits_.longest(d, h, true, true);
  if (wholly && part < 1) return false;
  goTo(part, {0, d.count});
  limits_.advanceRemainingMotion(part);
  carries_ += lack_ > 0;
  lack_ = part == 1 ? 0 : lack_ * (1 - part);
  return true;
}

// ---- damping by a stiffness without unstable directions ----

/// A damping force -rK K u drives the motion along directions in which K is unstable, as in crushed elements, and the faster it is the
/// more: equations of a step may then have no solution nearby. If Newton's method suspects that (Newton::mayBeDriven()), fields with a
/// definite stiffness are damped by it for the rest of the step, and it is their tangent. It costs several times as much.
void ImplicitStep::findDamped() {
  damped_.clear();
  for (ForceField* field : system_->forceFields()) {
    const double own = own_in_matrix ? 0 : field->rayleigh_stiffness, factor = (field->traits().undamped ? 0 : rayleigh_stiffness) + own;
    auto* const open = dynamic_cast<OpenChoices*>(field);
    if (iterates() && factor != 0 && open && open->useDefiniteTangent(false)) damped_.push_back(field);
  }
}

bool ImplicitStep::useDefiniteDamping() {
  if (damped_.empty() || has_definite_damping_) return false;
  has_definite_damping_ = true;
  for (ForceField* field : damped_) dynamic_cast<OpenChoices&>(*field).useDefiniteTangent(true);
  return true;
}

bool ImplicitStep::useDefiniteTangent(bool definite) {
  const bool changed = useDefiniteTangents(*system_, definite);
  if (std::exchange(has_definite_damping_, false)) useDefiniteDamping();
  return changed;
}

/// True: derivatives are still those of the last force.
bool ImplicitStep::endDefiniteDamping() {
  return std::exchange(has_definite_damping_, false) && useDefiniteTangents(*system_, false);
}

// ---- stresses that turn ----

/// With rK the exact tangents of fields are not for the taking, as K is a force then. What turning adds makes the warped tangent of a
/// field exact, and is left out of rK K u.
void ImplicitStep::chooseTurning() {
  turning_.clear();
  const bool is_wanted = iterates() && has_rayleigh_stiffness_ && multipliers_.empty();
  for (ForceField* field : system_->forceFields())
    if (auto* turning = dynamic_cast<TurnsStresses*>(field); turning && turning->keepTurning(is_wanted) && is_wanted)
      turning->addTurning(0), turning_.emplace_back(turning, field);
}

/// Many steps need one iteration, which has the warped tangent: it costs less. Forces prepare turning for those that come.
void ImplicitStep::keepTurning(bool on) {
  for (const auto& [turning, field] : turning_) turning->keepTurning(on);
}

/// The way of the step turns stresses, and not its damping.
void ImplicitStep::addTurning(bool on) {
  for (const auto& [turning, field] : turning_)
    turning->addTurning(on ? -scheme_.weight * scheme_.displacement / tangentFactors().of(*field) : 0);
}

/// Pressure that turns may make the tangent indefinite, far from equilibrium more than needed.
void ImplicitStep::excludeUnstableDirections() {
  turns_ = false;
  addTurning(false);
  system_->matrix().valuesChanged();
}

}  // namespace stroma
