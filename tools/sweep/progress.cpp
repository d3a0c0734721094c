// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace stroma::sweep {

SweepProgress::SweepProgress(const std::vector<Axis>& axes, bool quiet) : axes_(axes), quiet_(quiet) {}

void SweepProgress::expect(const Configuration& configuration) {
  expected_.push_back(&configuration);
  ++all_;
}

/// Mean over the runs that are known; those that share more values count four times as much for each.
double SweepProgress::guess(const Configuration& configuration) const {
  double sum = 0, weights = 0;
  for (const auto& [known, seconds] : known_) {
    double shared = 0;
    for (std::size_t a = 0; a < std::min(known->choice.size(), configuration.choice.size()); ++a)
      shared += known->choice[a] == configuration.choice[a];
    const double weight = std::pow(4.0, shared);
    sum += weight * seconds, weights += weight;
  }
  return weights > 0 ? sum / weights : 0;
}

std::string SweepProgress::timeToGo(double seconds) const {
  return known_.empty() ? "" : fmt::format(", {} to go", durationText(seconds));
}

void SweepProgress::finished(const Configuration& configuration, const std::string& outcome, double seconds) {
  ++made_;
  const auto expected = std::ranges::find(expected_, &configuration);
  if (expected != expected_.end()) expected_.erase(expected);
  known_.emplace_back(&configuration, seconds);
  if (quiet_ || line_.isOnTerminal()) return;
  double left = 0;
  for (const Configuration* one : expected_) left += guess(*one);
  line_.tell(fmt::format("run {}/{}  {}: {} after {:.3g} s{}", made_, all_, nameOf(axes_, configuration), outcome,
                         seconds, timeToGo(left)));
}

void SweepProgress::draw(const Scheduler& scheduler) {
  if (quiet_ || !line_.isOnTerminal()) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - last_drawn_ < std::chrono::milliseconds(200)) return;
  last_drawn_ = now;
  double left = 0;
  for (const Configuration* configuration : expected_) left += guess(*configuration);
  const auto running = std::max<std::size_t>(1, scheduler.running());
  line_.tell(fmt::format("{} of {} runs, {} running{}", made_, all_, scheduler.running(), timeToGo(left / double(running))));
}

}  // namespace stroma::sweep
