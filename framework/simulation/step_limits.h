// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "framework/mechanics/step_limiter.h"
#include "framework/simulation/system.h"

namespace stroma {

/// Those of a system's force fields that limit its steps. Without any, nothing is done.
class StepLimits {
 public:
  void compile(System& system);
  bool empty() const { return limiters_.empty(); }
  /// The largest s <= 1 up to which the system's positions may move by s * factor * dx; dx has the independent rows. See Way.
  double longest(ConstRows dx, double factor = 1, bool is_carried = false, bool goes_along = false);
  /// Points may move on curves: mappings are not linear.
  bool bends() const { return !empty() && !system_->mappingChain().isLinear(); }
  /// The same on a way that goTo(s) puts the system's positions on; it ends with goTo(0).
  double longest(ConstRows dx, double factor, bool is_carried, bool goes_along, const std::function<void(double)>& goTo);
  /// A lagged quantity was updated after the last solve, which has to be repeated. Obstacles have advanced as far as the bodies
  /// let them.
  bool moveOn();
  /// The same while obstacles are waiting for goAlong().
  bool solvesAgain();
  /// See StepLimiter.
  bool hasWay() const {
    return std::any_of(limiters_.begin(), limiters_.end(), [](const StepLimiter* limiter) { return limiter->hasWay(); });
  }
  /// out = what the way of obstacles adds to forces; shape (allRows()), of which only the independent rows are used.
  void push(Rows out) const;
  /// Obstacles advance as far as the bodies let them.
  void goAlong();
  void goAlong(double s) {
    for (StepLimiter* limiter : limiters_) limiter->goAlong(s);
  }
  /// See StepLimiter.
  bool isOnTheWay() const {
    return std::any_of(limiters_.begin(), limiters_.end(), [](const StepLimiter* limiter) { return limiter->isOnTheWay(); });
  }
  /// See StepLimiter.
  void wantStartForces(bool wanted, double of_end = 1) {
    for (StepLimiter* limiter : limiters_) limiter->wantStartForces(wanted, of_end);
  }

 private:
  double ask(ConstRows x, const Way& way) const;
  double largestTurn(ConstRows dx) const;

  System* system_ = nullptr;
  std::vector<StepLimiter*> limiters_;
  Vector scaled_, still_;       ///< shape (independentRows()), only with limiters; still_: zero
  Vector start_, middle_, end_;  ///< shape (allRows()), only where ways bend
  std::vector<double> bend_;
};

// ---- called by the system and the simulation ----
void tellStepBegins(const System& system, ConstRows x, double t, double t_end);
/// A sentence on what intersects after a step, or empty.
std::string overlapIn(System& system);
/// Moves bodies out of an invalid start (mechanics/step_limiter.h).
void placeStart(System& system);
/// Throws ComponentError if an integrator does not ask how far it may step, or something else moves positions too.
void checkStepLimits(const System& system);

}  // namespace stroma
