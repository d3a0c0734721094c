// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/pace.h"

#include <algorithm>
#include <cmath>

namespace stroma::command {

void Pace::look(double now, long steps) {
  now_ = now;
  if (steps == last_steps_) return;
  const double seconds = now - last_change_, made = double(steps - last_steps_);
  last_change_ = now;
  last_steps_ = steps;
  if (!isKnown()) {
    first_ = seconds / made;
    began_ = now;
    return;
  }
  const double memory = std::max({1.0, (now - began_) / 3, steps_ > 0 ? 8 * seconds_ / steps_ : 0.0});
  const double fade = std::exp(-seconds / memory);
  seconds_ = fade * seconds_ + seconds;
  steps_ = fade * steps_ + made;
}

double Pace::secondsPerStep() const {
  if (!isKnown()) return 0;
  const double usual = steps_ > 0 ? seconds_ / steps_ : first_;
  return age() > usual ? (seconds_ + age()) / (steps_ + 1) : usual;
}

double Pace::secondsToGo(long remaining) const {
  const double each = secondsPerStep();
  return std::max(0.0, double(remaining) * each - std::min(age(), each));
}

}  // namespace stroma::command
