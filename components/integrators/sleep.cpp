// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/sleep.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "framework/mechanics/history.h"
#include "framework/mechanics/step_limiter.h"
#include "framework/scene/archive.h"

namespace stroma {
namespace {

constexpr double same_place = 1e-6;   ///< a share of sleepDistance: what a constant motion over time leaves by round-off
constexpr double same_force = 1e-12;  ///< a share of the largest force: the same of a constant load

/// The largest distance of a row from where it was.
double largestWay(ConstRows x, ConstRows start) {
  double most = 0;
  for (Index i = 0; i < x.count; ++i) most = std::max(most, (x[i] - start[i]).squaredNorm());
  return std::sqrt(most);
}

/// A number for the directions that are held now, where that can change in time; FNV-1a. 1: nothing changes. 0: it cannot be told.
std::uint64_t heldDirections(const ConstraintSet& constraints) {
  if (!constraints.change()) return 1;
  if (!constraints.groups().empty() || !constraints.relations().empty()) return 0;
  std::uint64_t hash = 14695981039346656037ull;
  const auto mix = [&hash](std::uint64_t bits) { hash = (hash ^ bits) * 1099511628211ull; };
  for (const NodeProjector& held : constraints.projectors()) {
    mix(std::uint64_t(held.row));
    for (const double number : held.projector.reshaped()) mix(std::bit_cast<std::uint64_t>(number));
  }
  return hash | 2;
}

}  // namespace

void Sleep::declare(DataTable& table) {
  table.add("sleepDistance", distance_)
      .help("a body whose nodes stay within half of this distance for sleepTime is not computed until something changes; it ends at "
            "most this far from its true rest position; 0: never")
      .unit("m")
      .min(0);
  table.add("sleepTime", time_)
      .help("how long it must lie still, longer than its slowest swing or creep")
      .unit("s")
      .min(0, false);
  table.add("stepsAsleep", steps_asleep_)
      .help("how many steps so far were not computed, because the body slept")
      .unit("-")
      .output();
}

void Sleep::compile(System& system) {
  system_ = &system;
  wake();
  if (!isOn()) return;
  const auto refuse = [](const std::string& what) {
    throw ComponentError("sleepDistance is only for bodies moved by forces, and here are " + what, "sleepDistance=\"0\"");
  };
  if (!system.actors().lagrangian_constraints.empty()) refuse("Lagrangian constraints");
  if (!system.actors().position_constraints.empty()) refuse("position constraints");
  if (system.motion().turns()) refuse("frames, whose turning has no distance");
  looks_ = false;
  for (const ForceField* field : system.forceFields()) {
    // what is moved goes on its way in steps, and what friction holds creeps
    if (dynamic_cast<const StepListener*>(field)) refuse("surfaces that meet, of " + field->path());
    const ForceTraits traits = field->traits();
    const bool promises = traits.conservative || traits.forces_balance;  // that x alone decides, where there is no speed
    looks_ = looks_ || !promises || traits.time_dependent || traits.lagged || traits.decided_outside;
    looks_ = looks_ || dynamic_cast<const History*>(field);
    for (const State* state : field->states()) looks_ = looks_ || std::ranges::count(system.states(), state) == 0;
  }
  for (Vector* vector : {&start_, &place_, &force_, &zero_, &work_}) vector->resize(system.allRows());
}

bool Sleep::isUndisturbed(const StepContext& context) {
  System& system = *system_;
  const ConstraintSet& constraints = system.constraints();
  const double little = same_place * distance_;
  if (!(largestWay(system.x, place_) <= little) || (is_still_ && !(largest(system.v) * context.dt <= little))) return false;
  if (held_ == 0 || held_ != heldDirections(constraints)) return false;
  if (constraints.hasPrescribed()) {
    copy(system.x, work_);
    constraints.placePrescribed(context, work_, zero_);
    clear(zero_);
    if (!(largestWay(system.independent(work_), system.independent(place_)) <= little)) return false;
  }
  if (!looks_ && !had_inputs_ && !system.inputs()) return true;
  system.computeForce(place_, zero_, work_);
  return largestWay(work_, force_) <= same_force * largest(force_);
}

bool Sleep::passesOver(const StepContext& context) {
  passed_ = is_asleep_ && isUndisturbed(context);
  if (passed_) clear(system_->v);
  return passed_;
}

/// At the end of a step: what has not changed by the end of the next one goes on sleeping.
void Sleep::fallAsleep() {
  System& system = *system_;
  is_asleep_ = true, is_still_ = false;
  had_inputs_ = system.inputs() != nullptr;
  held_ = heldDirections(system.constraints());
  copy(system.x, place_);
  system.computeForce(system.x, zero_, force_);
}

/// A linear solve that ends at its limit, as is often meant, has moved what can move.
StepReport Sleep::judged(StepReport report) {
  is_solved_ = !report.unsolved && report.newton_converged && report.constraints_converged &&
               (report.linear_converged || report.linear_at_limit);
  return report;
}

bool Sleep::stepTaken(double dt) {
  if (!isOn()) return false;
  if (passed_) {
    ++steps_asleep_;
    is_still_ = true;
    return true;
  }
  if (is_asleep_ || !is_solved_) wake();
  if (!is_solved_) return false;
  elapsed_ += dt;
  if (!has_start_ || !(largestWay(system_->x, start_) <= distance_ / 2)) {
    copy(system_->x, start_);
    has_start_ = true, elapsed_ = 0;
  } else if (elapsed_ >= time_) {
    fallAsleep();
  }
  return false;
}

void Sleep::serialize(Archive& archive) {
  if (!isOn()) return;
  archive.value("asleep", is_asleep_);
  archive.value("still", is_still_);
  archive.value("slept_with_inputs", had_inputs_);
  archive.value("has_start", has_start_);
  archive.value("lain", elapsed_);
  archive.value("steps_asleep", steps_asleep_);
  archive.value("slept_held", held_);
  archive.rows("start", start_);
  archive.rows("place", place_);
  archive.rows("force", force_);
}

std::string Sleep::describe() const {
  if (!isOn()) return {};
  return fmt::format("; not computed once all nodes have lain within {:g} m for {:g} s, until {} changes{}", distance_ / 2, time_,
                     looks_ ? "a force or the scene" : "the scene",
                     steps_asleep_ > 0 ? fmt::format(": {} steps so far", steps_asleep_) : "");
}

}  // namespace stroma
