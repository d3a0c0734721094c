// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/step_limits.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/simulation/integrator.h"

namespace stroma {

void StepLimits::compile(System& system) {
  system_ = &system;
  limiters_.clear();
  for (ForceField* field : system.forceFields())
    if (auto* limiter = dynamic_cast<StepLimiter*>(field)) limiters_.push_back(limiter);
  if (!empty()) scaled_.resize(system.independentRows());
}

double StepLimits::longest(ConstRows dx, double factor) {
  double step = 1;
  if (empty()) return step;
  copy(dx, scaled_);
  scale(factor, scaled_);
  const MappingChain& chain = system_->mappingChain();
  const ConstRows x = chain.positions(system_->x), all = chain.direction(scaled_);
  for (StepLimiter* limiter : limiters_) step = std::min(step, limiter->longestStep(x, all));
  return step;
}

bool StepLimits::moveOn() {
  if (empty()) return false;
  bool again = false;
  const ConstRows x = system_->mappingChain().positions(system_->x);
  for (StepLimiter* limiter : limiters_) again = limiter->movesOn(x) || again;
  return again;
}

void beginLimitedStep(const System& system, ConstRows x, double t, double t_end) {
  for (ForceField* field : system.forceFields())
    if (auto* limiter = dynamic_cast<StepLimiter*>(field))
      limiter->stepBegins(system.mappingChain().positions(x), t, t_end);
}

std::string overlapIn(System& system) {
  std::string found;
  for (ForceField* field : system.forceFields())
    if (auto* limiter = dynamic_cast<StepLimiter*>(field); limiter && found.empty())
      found = limiter->overlap(system.mappingChain().positions(system.x));
  return found;
}

void checkStepLimits(const System& system) {
  const auto& fields = system.forceFields();
  const auto limiter = std::find_if(fields.begin(), fields.end(),
                                    [](ForceField* f) { return dynamic_cast<StepLimiter*>(f) != nullptr; });
  if (limiter == fields.end()) return;
  const std::string path = (*limiter)->path();
  const auto* heeds = dynamic_cast<const HeedsStepLimits*>(&system.integrator());
  if (!heeds || !heeds->heedsStepLimits())
    throw ComponentError(
        fmt::format("{} moves bodies without asking {} how far they may move before they pass through each other",
                    system.integrator().type(), path),
        "an implicit integrator or statics with Newton's method", heeds ? heeds->howToHeedStepLimits() : "");
  if (!system.actors().position_constraints.empty())
    throw ComponentError(
        fmt::format("{} moves positions after the step, where {} no longer sees to it that nothing passes "
                    "through anything",
                    system.actors().position_constraints.front()->path(), path),
        "contact or position constraints, not both");
  if (!system.mappingChain().isLinear())
    throw ComponentError(
        fmt::format("{} needs to know the way that points make in a step, and a mapping here is not linear", path),
        "mappings that are linear");
}

}  // namespace stroma
