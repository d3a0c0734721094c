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

void NewtonPace::look(double now, long step, int iterations, double residual, double goal) {
  now_ = now;
  goal_ = goal;
  if (step == step_ && iterations == iterations_) return;
  if (step != step_ || iterations < iterations_) last_.clear();  // another solve
  step_ = step, iterations_ = iterations;
  if (!(residual > 0)) return last_.clear();
  last_.push_back({now, std::log(residual)});
  if (constexpr std::size_t few = 6; last_.size() > few) last_.erase(last_.begin());
}

double NewtonPace::secondsToGo() const {
  if (last_.size() < 2 || !(goal_ > 0)) return -1;
  const Iterate &first = last_.front(), &last = last_.back();
  const double fallen = first.logarithm - last.logarithm, took = last.when - first.when;
  if (!(fallen > 0.01 * double(last_.size()) && took > 0)) return -1;
  const double left = std::max(0.0, last.logarithm - std::log(goal_));
  return std::max(0.0, left * took / fallen - (now_ - last.when));
}

}  // namespace stroma::command
