// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <string>
#include <vector>

#include "tools/sweep/assessment.h"
#include "tools/sweep/progress.h"

namespace stroma::sweep {

/// Makes the runs of configurations that are not there yet, on this machine.
class RunMaker {
 public:
  RunMaker(const SweepRequest& request, const std::vector<Axis>& axes, const ErrorMeasure& measure);
  /// Brings every entry to its number of runs: all first runs, then all second ones, in an order that the seed gives, so
  /// that what slows the machine for a while slows no single configuration. Returns the signal that stopped it, or 0.
  int make(const std::vector<Entry*>& entries);
  /// Whether its folder lacks runs; reads the folder.
  bool isOpen(Entry& entry) const;
  /// Runs made by this object.
  int made() const { return made_; }

 private:
  int wanted(const Entry& entry) const { return isTimed(entry) ? request_.repeat + entry.runs.untimed() : 1; }
  bool isTimed(const Entry& entry) const { return request_.timed && !entry.configuration.isExtraReference(); }
  Job jobFor(std::size_t number, const Entry& entry, int repetition) const;
  void take(Entry& entry, const Job& job, const ProcessEnd& end, const Circumstances& circumstances);

  const SweepRequest& request_;
  const ErrorMeasure& measure_;
  Scheduler scheduler_;
  SweepProgress progress_;
  std::map<std::string, int> killed_;  ///< how often, by keys
  int made_ = 0;
};

}  // namespace stroma::sweep
