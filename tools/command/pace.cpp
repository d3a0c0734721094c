// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/pace.h"

#include <algorithm>
#include <cmath>

namespace stroma::command {

void Pace::look(double now, long steps) {
  now_ = now;
  if (steps == last_steps_) return;
  const double seconds = now - last_change_;
  const double memory = std::max({1.0, now / 3, isKnown() ? 8 * seconds_ / steps_ : 0.0});
  const double fade = std::exp(-seconds / memory);
  seconds_ = fade * seconds_ + seconds;
  steps_ = fade * steps_ + double(steps - last_steps_);
  last_change_ = now;
  last_steps_ = steps;
}

double Pace::secondsPerStep() const {
  if (!isKnown()) return 0;
  const double usual = seconds_ / steps_;
  return age() > usual ? (seconds_ + age()) / (steps_ + 1) : usual;
}

double Pace::secondsToGo(long remaining) const {
  const double each = secondsPerStep();
  return std::max(0.0, double(remaining) * each - std::min(age(), each));
}

}  // namespace stroma::command
