// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "framework/mechanics/step_limiter.h"
#include "framework/simulation/system.h"

namespace stroma {

/// The force fields of a system that limit its steps. Without any, nothing is done.
class StepLimits {
 public:
  void compile(System& system);
  bool empty() const { return limiters_.empty(); }
  /// The largest s <= 1 for which the system's positions may move by s * factor * dx; dx has the independent rows. See StepPath.
  double longest(ConstRows dx, double factor = 1, bool is_carried = false, bool goes_along = false);
  /// Points may move on curves, because of nonlinear mappings.
  bool bends() const { return !empty() && !system_->mappingChain().isLinear(); }
  /// The same along a path whose positions goTo(s) sets; it ends with goTo(0).
  double longest(ConstRows dx, double factor, bool is_carried, bool goes_along, const std::function<void(double)>& goTo);
  /// True if something that was fixed during the solve has changed, so the solve must be repeated. Obstacles have advanced as
  /// far as the present positions of bodies allow.
  bool moveOn();
  /// The same while obstacles are waiting for advanceRemainingMotion().
  bool solvesAgain();
  /// See StepLimiter.
  bool hasRemainingMotion() const {
    return std::any_of(limiters_.begin(), limiters_.end(), [](const StepLimiter* limiter) { return limiter->hasRemainingMotion(); });
  }
  /// out = the contribution of moving obstacles to forces; shape (allRows()), of which only independent rows are used.
  void push(Rows out) const;
  /// Advances obstacles as far as the present positions of bodies allow.
  void advanceRemainingMotion();
  void advanceRemainingMotion(double s) {
    for (StepLimiter* limiter : limiters_) limiter->advanceRemainingMotion(s);
  }
  /// See StepLimiter.
  bool isIntermediate() const {
    return std::any_of(limiters_.begin(), limiters_.end(), [](const StepLimiter* limiter) { return limiter->isIntermediate(); });
  }
  /// See StepLimiter.
  void wantStartForces(bool wanted, double of_end = 1) {
    for (StepLimiter* limiter : limiters_) limiter->wantStartForces(wanted, of_end);
  }

 private:
  double ask(ConstRows x, const StepPath& way) const;
  double largestTurn(ConstRows dx) const;

  System* system_ = nullptr;
  std::vector<StepLimiter*> limiters_;
  Vector scaled_, still_;       ///< shape (independentRows()), only with limiters; still_: zero
  Vector start_, middle_, end_;  ///< shape (allRows()), only for curved paths
  std::vector<double> bend_;
};

// ---- called by the system and the simulation ----
void tellStepBegins(const System& system, ConstRows x, double t, double t_end);
/// A description of intersections after a step, or empty.
std::string overlapIn(System& system);
/// Separates bodies that overlap at the start (mechanics/step_limiter.h).
void placeStart(System& system);
/// Throws ComponentError if an integrator does not respect step limits, or if something else also moves positions.
void checkStepLimits(const System& system);

}  // namespace stroma
