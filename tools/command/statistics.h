// SPDX-License-Identifier: LGPL-2.1-or-later
// Figures of a run as JSON.
#pragma once
#include <nlohmann/json.hpp>

#include "tools/session/statistics.h"

namespace stroma::command {

/// Wall time of a step [ms].
nlohmann::ordered_json timing(const RunStatistics& run);
nlohmann::ordered_json solvers(const RunStatistics& run);
/// Seconds in each phase, summed over systems; `other` is what is left of the steps.
nlohmann::ordered_json phaseSeconds(const Simulation& simulation);
/// The largest amount of memory this process has held [bytes].
long peakMemory();

}  // namespace stroma::command
