// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <string>
#include <vector>

#include "tools/session/told_line.h"
#include "tools/sweep/configuration.h"
#include "tools/sweep/scheduler.h"

namespace stroma::sweep {

/// How far a sweep is, on standard error, with the time to go: on a terminal one line that is redrawn, in a pipe a line
/// for each run.
class SweepProgress {
 public:
  SweepProgress(const std::vector<Axis>& axes, bool quiet);
  /// A run that is to be made.
  void expect(const Configuration& configuration);
  void finished(const Configuration& configuration, const std::string& outcome, double seconds);
  void draw(const Scheduler& scheduler);
  void leaveLine() { line_.clear(); }

 private:
  double guess(const Configuration& configuration) const;
  std::string timeToGo(double seconds) const;

  const std::vector<Axis>& axes_;
  bool quiet_;
  ToldLine line_;
  std::vector<const Configuration*> expected_;
  std::vector<std::pair<const Configuration*, double>> known_;  ///< and the seconds that they took
  std::size_t made_ = 0, all_ = 0;
  std::chrono::steady_clock::time_point last_drawn_{};
};

}  // namespace stroma::sweep
