// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/step_limits.h"

#include <algorithm>

#include "framework/scene/spans.h"
#include "framework/simulation/integrator.h"

namespace stroma {

void StepLimits::compile(System& system) {
  system_ = &system;
  limiters_.clear();
  for (ForceField* field : system.forceFields())
    if (auto* limiter = dynamic_cast<StepLimiter*>(field)) limiters_.push_back(limiter);
  if (!empty()) scaled_.resize(system.independentRows()), still_.resize(system.independentRows());
  if (!bends()) return;
  for (Vector* vector : {&start_, &middle_, &end_}) vector->resize(system.allRows());
  const Index all = system.allRows(), independent = system.independentRows();
  bend_.assign(std::size_t(all + independent), 0);  // and then, of independent rows, not zero where mappings that bend follow them
  for (const Mapping* mapping : system.actors().mappings)
    for (const State* state : mapping->inputs())
      if (const bool is_mapped = state->firstRow() >= independent; !mapping->isLinear())
        std::fill_n(bend_.begin() + all + (is_mapped ? 0 : state->firstRow()), is_mapped ? independent : state->size(), 1.);
}

double StepLimits::ask(ConstRows x, const StepPath& way) const {
  double step = 1;
  for (StepLimiter* limiter : limiters_) step = std::min(step, limiter->longestStep(x, way));
  return step;
}

double StepLimits::longest(ConstRows dx, double factor, bool is_carried, bool goes_along) {
  if (empty()) return 1;
  const Rows x = system_->independent(system_->x);
  if (bends()) copy(x, scaled_);
  const auto goTo = [&](double s) { copy(scaled_, x), system_->motion().advance(s * factor, dx, x); };
  return longest(dx, factor, is_carried, goes_along, std::cref(goTo));
}

double StepLimits::largestTurn(ConstRows dx) const {
  double turn = 0;
  for (const Index row : system_->motion().turningRows())
    if (row < dx.count) turn = std::max(turn, dx[row].norm());
  return turn;
}

/// A point that turns by an angle q at a distance r from the axis is at most r q^2/8 away from where it would be on its
/// chord; in the middle it is r (1 - cos(q/2)), which for q up to 1.5 is no less than 0.95 of that.
double StepLimits::longest(ConstRows dx, double factor, bool is_carried, bool goes_along, const std::function<void(double)>& goTo) {
  constexpr double most_turn = 1.5, margin = 1.1, trials = 60;
  const bool is_straight = !bends() || std::ranges::none_of(system_->states(), [&](const State* s) {
    const Index row = s->firstRow(), all = system_->allRows();
    return row < system_->independentRows() && bend_[std::size_t(all + row)] != 0 && norm(s->segment(dx)) != 0;
  });
  if (is_straight) {
    copy(dx, scaled_), scale(factor, scaled_);
    const ConstRows x = system_->mappingChain().positions(system_->x), way = system_->mappingChain().direction(scaled_);
    return ask(x, {way, nullptr, is_carried, goes_along ? 1. : 0.});
  }
  const auto placeAt = [&](double s, Vector& out) {
    goTo(s), copy(system_->independent(system_->x), system_->independent(out));
    for (const Mapping* mapping : system_->actors().mappings) heard("map", mapping)->apply(out);
  };
  const double turn = factor * largestTurn(dx);
  double step = turn > most_turn ? most_turn / turn : 1;
  for (int trial = 0; step > 0; ++trial) {
    placeAt(0.5 * step, middle_), placeAt(step, end_), placeAt(0, start_);  // after which mappings are where they were
    axpy(-1, start_, end_);
    for (Index row = system_->independentRows(); row < start_.count(); ++row)  // others go straight, or are no places
      bend_[std::size_t(row)] = margin * (Vec3(middle_[row]) - Vec3(start_[row]) - 0.5 * Vec3(end_[row])).norm();
    const double free = ask(start_, {end_, bend_.data(), is_carried, goes_along ? step : 0});
    if (free == 1) break;
    step = trial == trials ? 0 : step * (free > 0 ? std::min(free, 0.9) : 0.5);
  }
  return step;
}

bool StepLimits::moveOn() {
  const bool again = solvesAgain();
  advanceRemainingMotion();
  return again;
}

void StepLimits::advanceRemainingMotion() {
  if (hasRemainingMotion()) advanceRemainingMotion(longest(still_, 1, true, true));
}

void StepLimits::push(Rows out) const {
  clear(out);
  for (const StepLimiter* limiter : limiters_)
    if (limiter->hasRemainingMotion()) limiter->addPush(out);
  system_->mappingChain().pullBack(out);
}

bool StepLimits::solvesAgain() {
  if (empty()) return false;
  bool again = false;
  const ConstRows x = system_->mappingChain().positions(system_->x);
  for (StepLimiter* limiter : limiters_) again = limiter->updatesLagged(x) || again;
  return again;
}

void tellStepBegins(const System& system, ConstRows x, double t, double t_end) {
  for (ForceField* field : system.forceFields())
    if (auto* listener = dynamic_cast<StepListener*>(field)) listener->stepBegins(system.mappingChain().positions(x), t, t_end);
  for (LagrangianConstraint* constraint : system.actors().lagrangian_constraints)
    constraint->constrainedStepBegins(system.mappingChain().positions(x), t_end);
}

std::string overlapIn(System& system) {
  std::string found;
  for (ForceField* field : system.forceFields())
    if (auto* limiter = dynamic_cast<StepLimiter*>(field); limiter && found.empty())
      found = limiter->overlap(system.mappingChain().positions(system.x));
  return found;
}

void placeStart(System& system) {
  const auto place = [&system](auto* actor) {
    if (auto* places = dynamic_cast<CorrectsStart*>(actor)) {
      places->placeStart(system.x, system.independentRows(), [&](Rows ways) { system.constraints().project(ways); });
      system.mappingChain().positions(system.x);
    }
  };
  std::ranges::for_each(system.forceFields(), place);
  std::ranges::for_each(system.actors().lagrangian_constraints, place);
}

}  // namespace stroma
