// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/explicit_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "components/integrators/exact_tangent.h"
#include "components/integrators/stable_step.h"
#include "framework/scene/archive.h"

namespace stroma {

static constexpr int most_parts = 2000;  // of a step, those that were taken back included

void ExplicitParts::compile(System& system, Acceleration& acceleration, const std::string& method,
                            double largest_angle) {
  constexpr double accurate = 0.35;  // errors of energy go with the square of it
  system_ = &system, acceleration_ = &acceleration, method_ = method;
  angle_ = std::min(accurate, largest_angle / 4);
  limits_.compile(system);
  limits_.wantStartForces(true);
  fields_.clear();
  for (ForceField* field : system.forceFields())
    if (dynamic_cast<StepLimiter*>(field)) fields_.push_back(field);
  if (!areNeeded()) return;
  for (Vector* vector : {&x0_, &v0_, &end_, &way_, &p_, &a_}) vector->resize(system.independentRows());
  force_.resize(system.allRows());
}

void ExplicitParts::serialize(Archive& archive) {
  if (areNeeded()) archive.value("last_part", last_step_);
  last_ = last_step_;
}

std::string ExplicitParts::describe() const {
  return areNeeded() ? ", in parts where " + fields_.front()->path() + " is stiff" : std::string();
}

/// Of the fields at the x of the system, by power iteration on M^-1 K. After one product only what they touch is left.
double ExplicitParts::angularFrequency(const StepContext& context) {
  constexpr int iterations = 8;
  const MappingChain& chain = system_->mappingChain();
  clear(force_);
  bool acts = false;
  for (ForceField* field : fields_) {
    field->addForce(chain.positions(system_->x), system_->v, force_);
    acts = acts || field->acts();
  }
  if (!acts) return 0;
  StepReport report;
  fillAtRandom(p_);
  system_->constraints().project(p_);
  double square = 0;
  for (int i = 0; i < iterations; ++i) {
    clear(force_);
    const ConstRows direction = chain.direction(p_);
    for (const ForceField* field : fields_) field->addStiffnessProduct(direction, -1, force_);
    chain.pullBack(force_);
    const double energy = dot(p_, system_->independent(force_));
    if (!(energy > 0) || !acceleration_->solveForMomenta(system_->x, system_->independent(force_), a_, context.stop, report)) break;
    square = std::max(square, dot(a_, system_->independent(force_)) / energy);
    const double size = norm(a_);
    if (!(size > 0)) break;
    copy(a_, p_);
    scale(1 / size, p_);
  }
  return std::sqrt(square);
}

/// What is left of a step in equal parts.
double ExplicitParts::lengthOf(double left, double wanted) const {
  return wanted >= left ? left : left / std::ceil(left / wanted);
}

void ExplicitParts::takeBack() {
  copy(x0_, system_->independent(system_->x));
  copy(v0_, system_->independent(system_->v));
}

bool ExplicitParts::isFree(ConstRows x) {
  copy(x0_, way_);
  system_->motion().difference(x, way_);
  if (!std::isfinite(norm(way_))) return true;  // others say so
  free_ = limits_.longest(way_);
  return free_ == 1;
}

/// The part that has been made stands, else `wanted_` is a length that may.
bool ExplicitParts::fits(const StepContext& part) {
  constexpr double most = 2, margin = 0.9, least = 0.1;
  const Rows x = system_->independent(system_->x);
  if (free_ == 1) {
    copy(x, end_);
    copy(x0_, x);
    isFree(end_);
    copy(end_, x);
  }
  if (free_ < 1) {
    wanted_ = part.dt * std::clamp(margin * free_, least, margin);
    return false;
  }
  limits_.moveOn();
  const double w = angularFrequency(part), length = w > 0 ? angle_ / w : part.dt * most;
  if (part.dt > most * length) {
    wanted_ = std::max(length, least * part.dt);
    return false;
  }
  wanted_ = std::min(length, most * part.dt);
  return true;
}

std::string ExplicitParts::tooManyParts(const StepContext& context, double t, double h) const {
  constexpr double hopeless = 1e-6;  // of a step: gaps close on and on
  const std::string smaller =
      h > hopeless * context.dt ? fmt::format("dt=\"{:.2g}\" or less, ", context.dt / 10) : std::string();
  return fmt::format(
      "{} has made {:.2g} of a step of {:g} s in {} parts, the last of {:.2g} s, as {} needs them; give {}a larger "
      "stiffness of the "
      "contact, or an implicit integrator",
      method_, (t - context.t) / context.dt, context.dt, most_parts, h, fields_.front()->path(), smaller);
}

StepReport ExplicitParts::run(const StepContext& context, const std::function<StepReport(const StepContext&)>& make) {
  System& s = *system_;
  StepReport report;
  last_ = last_step_;
  const double w = angularFrequency(context);
  wanted_ = w > 0 ? angle_ / w : context.dt;
  if (last_ > 0) wanted_ = std::min(wanted_, 2 * last_);
  double t = context.t;
  for (int tries = 0; t < context.t_end; ++tries) {
    StepContext part = context;
    const double left = context.t_end - t;
    part.t = t, part.dt = lengthOf(left, wanted_);
    part.t_end = part.dt == left ? context.t_end : t + part.dt;
    if (tries == most_parts || !(part.t_end > t)) {
      report.diverged = true;
      report.reason = tooManyParts(context, t, part.dt);
      return report;
    }
    tellStepBegins(s, s.x, part.t, part.t_end);
    copy(s.independent(s.x), x0_), copy(s.independent(s.v), v0_);
    free_ = 1;
    const StepReport before = report;
    report = make(part);
    addCounts(before, report);
    if (report.failed()) return report;
    if (fits(part))
      t = part.t_end, last_ = part.dt;
    else
      takeBack();
    if (!std::isfinite(norm(s.independent(s.x)))) return report;
  }
  return report;
}

}  // namespace stroma
