// SPDX-License-Identifier: LGPL-2.1-or-later
// The result of a sweep as files that other programs read.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/sweep/assessment.h"

namespace stroma::sweep {

/// Errors against a size of an axis, all else the same.
struct Series {
  std::size_t axis = 0;
  std::string name;                   ///< the values of the other axes
  std::vector<const Entry*> entries;  ///< from coarse to fine; those with a result
  std::optional<double> order;        ///< slope of log(error); mesh and time step only
};

/// What a sweep has found.
struct Findings {
  const SweepRequest& request;
  const std::vector<Axis>& axes;
  const std::vector<Entry>& entries;
  const Assessment& assessment;
  std::string build, scene_digest;
  std::size_t not_run = 0;          ///< of the grid: --goal did not need them
  std::string goal;                 ///< what became of it, a sentence
  const Entry* cheapest = nullptr;  ///< that reaches the goal
};

/// Every line of the grid along an ordered axis that has two results or more.
std::vector<Series> seriesOf(const Findings& findings);

/// A row for each configuration, failed ones included.
std::string csvOf(const Findings& findings);
nlohmann::ordered_json jsonOf(const Findings& findings);

}  // namespace stroma::sweep
