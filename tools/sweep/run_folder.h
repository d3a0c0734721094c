// SPDX-License-Identifier: LGPL-2.1-or-later
// What a sweep keeps of a configuration: a folder with, for each run K of it,
//   K.outcome.json   how the process ended and under which circumstances; written last, so a run that has it is whole
//   K.json           what `stroma run --json` says
//   K.log            standard error
//   end.values       the end of the last run
// A run that was killed leaves no outcome and is made again.
#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/sweep/scheduler.h"

namespace stroma::sweep {

/// One run.
struct Repetition {
  int exit_code = 0;
  double seconds = 0;          ///< from the first step to the last [s]
  double step_ms = 0;          ///< median over the steps
  double load_seconds = 0;     ///< until the first step [s]
  double process_seconds = 0;  ///< all of the process [s]
  double cpu_seconds = 0;      ///< of that with a core, of all its threads together [s]
  double others_seconds = 0;   ///< of its cores, with other programs [s]
  bool timed = true;
  std::vector<int> cores;
  int beside = 0;
  double load = 0;  ///< of the machine at the start
  std::string host, machine;
  nlohmann::json summary;

  /// Somebody else had its cores for more than a tenth of the time. Threads wait for one another too, and one for nobody.
  bool wasDisturbed() const {
    const double share = 0.1 * process_seconds;
    return timed && (cores.size() > 1 ? others_seconds > share * double(cores.size()) : process_seconds - cpu_seconds > share);
  }
};

/// All runs of a configuration.
struct Runs {
  std::vector<Repetition> repetitions;
  std::string failure;  ///< a sentence when there is no result
  std::string outcome = "not run";

  bool isGood() const { return outcome == "done"; }
  /// No further run can change it.
  bool areComplete(int wanted) const {
    return failure.empty() ? int(repetitions.size()) >= wanted : !repetitions.empty();
  }
  /// Runs that were made without times: they tell none.
  int untimed() const;
  bool hasTimes() const;
  /// Over the timed runs; 0 when there is none.
  double medianOf(double Repetition::*value) const;
  /// Largest less smallest of the same runs.
  double spreadOf(double Repetition::*value) const;
  bool wereDisturbed() const;
};

std::string outcomeFile(const std::string& folder, int repetition);
std::string endFile(const std::string& folder);
/// Notes that a run has ended; not for one that was killed. Throws OutputError.
void writeOutcome(const std::string& folder, const Job& job, const ProcessEnd& end, const Circumstances& circumstances);
/// What the folder has.
Runs readRuns(const std::string& folder);
/// The sentence of a log that says why a run was refused or ended.
std::string sentenceIn(const std::string& log_file);

}  // namespace stroma::sweep
