// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

namespace stroma::command {

/// How fast steps are, from looks at how many have been made. Recent steps count most: the weight of a look fades over
/// the last third of the run so far, and over no fewer than about eight steps. The first step often prepares what all
/// others use (a factor, a library): once there are others it does not count.
class Pace {
 public:
  /// At `now` [s], not before the last look, `steps` have been made.
  void look(double now, long steps);
  bool isKnown() const { return first_ >= 0; }
  /// Whether enough steps after the first are known to tell when the last one will be made.
  bool isSteady() const { return steps_ >= 3 || (steps_ > 0 && seconds_ >= 2); }
  /// Of a step [s]. A step that takes longer than those before it counts while it is under way.
  double secondsPerStep() const;
  /// For `remaining` steps, of which one is under way [s].
  double secondsToGo(long remaining) const;
  /// How long the step under way has taken [s]; as exact as the looks are frequent.
  double age() const { return now_ - last_change_; }

 private:
  double now_ = 0, last_change_ = 0;
  long last_steps_ = 0;
  double first_ = -1;               ///< a step up to the first look that saw one [s]; negative: none has
  double began_ = 0;                ///< when those that count did [s]
  double seconds_ = 0, steps_ = 0;  ///< faded sums of those after it
};

/// How long Newton's method will take to its goal, from how fast the logarithm of the residual has fallen over the last few
/// iterations. It falls ever faster near the solution, so that this is more than it takes; while it does not fall nothing
/// is told.
class NewtonPace {
 public:
  /// At `now` [s], not before the last look, the iterate of `iterations` iterations of step `step` has this residual.
  void look(double now, long step, int iterations, double residual, double goal);
  double secondsToGo() const;  ///< negative: unknown

 private:
  struct Iterate {
    double when = 0, logarithm = 0;
  };
  std::vector<Iterate> last_;  ///< a few, the oldest first
  long step_ = -1;
  int iterations_ = -1;
  double now_ = 0, goal_ = 0;
};

}  // namespace stroma::command
