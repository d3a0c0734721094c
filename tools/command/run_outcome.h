// SPDX-License-Identifier: LGPL-2.1-or-later
// How a run ended, as `stroma run` tells it.
#pragma once
#include <nlohmann/json.hpp>

#include "tools/command/run_request.h"

namespace stroma::command {

struct Outcome : RunReport {
  bool doubted = false;               ///< by a strict run
  int signal = 0;                     ///< that ended it
  std::vector<std::string> failures;  ///< a sentence for each output that could not be written
  std::vector<std::string> advice;      ///< what to leave out of the scene for a faster run
  std::vector<std::string> unexpected;  ///< a sentence for each expectation of the scene that was not met

  bool failed() const {
    return end == RunEnd::diverged || end == RunEnd::mesh_refused || end == RunEnd::not_converged ||
           end == RunEnd::not_replayed || end == RunEnd::program_failed;
  }
  const char* word() const;
  int exitCode() const;
};

/// Prints what happened to a run without a result, and how good its last state is. `place`: "is in FILE, FILE", or what
/// became of it.
void tellFailure(const Outcome& outcome, const Simulation& simulation, const std::string& place);
/// Prints what a run's end gives reason to warn of and appends it to `warnings`, but for what the load has warned of
/// already. Whether there are doubts.
bool tellWarnings(const RunStatistics& statistics, const std::vector<std::string>& doubts,
                  std::vector<std::string>& warnings);

/// Prints, unless `quiet`, what the scene's expectations have found; those that were not met are kept in `outcome`.
void tellExpectations(const Simulation& simulation, bool quiet, Outcome& outcome);

/// Prints, unless `quiet`, and returns what is said of cells that are too large for the shapes that they have got.
std::vector<std::string> tellMeshErrors(const Simulation& simulation, bool quiet);
/// The same of swings that the rule of an integrator damps.
std::vector<std::string> tellDampedSwings(const Simulation& simulation, bool quiet);

nlohmann::ordered_json summary(const RunRequest& request, const Simulation& simulation, const Outcome& outcome);
void printSummary(const RunRequest& request, const Simulation& simulation, const Outcome& outcome);
/// "-" is standard output. Throws OutputError.
void writeJson(const nlohmann::ordered_json& json, const std::string& file);

}  // namespace stroma::command
