// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/scene/archive.h"
#include "framework/simulation/step.h"

namespace stroma {

/// The times of a run's steps. Step n ends at base time + (n - base step) dt: the start, or where dt changed last. A
/// product rather than a sum, so that no time carries the round-off of n additions.
class RunClock {
 public:
  double time() const { return time_; }
  long steps() const { return steps_; }

  void start(double time) { time_ = time, steps_ = 0, countFromHere(); }
  /// Changes dt: later step times are counted from here.
  void countFromHere() { base_time_ = time_, base_step_ = steps_; }
  /// The next step.
  StepContext next(double dt) const {
    const long index = steps_ + 1;
    return {index, time_, dt, base_time_ + double(index - base_step_) * dt, {}};
  }
  /// The last step.
  StepContext last(double dt) const {
    const double from = steps_ > base_step_ ? base_time_ + double(steps_ - 1 - base_step_) * dt : time_ - dt;
    return {steps_, from, dt, time_, {}};
  }
  void stepMade(const StepContext& context) { steps_ = context.index, time_ = context.t_end; }

  void serialize(Archive& archive) {
    archive.value("time", time_);
    archive.value("steps", steps_);
    archive.value("base_time", base_time_);
    archive.value("base_step", base_step_);
  }

 private:
  double time_ = 0, base_time_ = 0;
  long steps_ = 0, base_step_ = 0;
};

}  // namespace stroma
