// SPDX-License-Identifier: LGPL-2.1-or-later
// The result of a sweep for people.
#pragma once
#include <string>
#include <vector>

#include "tools/sweep/chart.h"
#include "tools/sweep/table.h"

namespace stroma::sweep {

/// Error against time to the end and, where they differ, per step; error against each size that varies.
std::vector<Chart> chartsOf(const Findings& findings);

/// One HTML file without anything from elsewhere.
std::string pageOf(const Findings& findings, const std::vector<Chart>& charts);

/// Writes table.csv, table.json, report.html and each chart as .svg and, where rsvg-convert is installed, as .png.
/// Returns their names, and notes on what could not be written. Throws OutputError.
struct Written {
  std::vector<std::string> files, notes;
};
Written writeReport(const Findings& findings);

}  // namespace stroma::sweep
