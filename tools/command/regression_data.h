// SPDX-License-Identifier: LGPL-2.1-or-later
// What a case of a regression list compares besides states: energies over time, and any attribute of numbers.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"

namespace stroma::command {

/// "data=PATH.NAME:TOLERANCE", or a word such as kinetic_energy for PATH.NAME.
struct WatchedData {
  std::string name;
  double tolerance = 0;  ///< share of the largest number
  std::string fileName() const;
};

/// Throws UsageError. `tolerance`: where the word has none.
WatchedData readWatchedData(const std::string& word, double tolerance);

/// The numbers at each recorded time [s].
using DataOverTime = std::map<double, std::vector<double>>;

/// As it is now. Throws std::runtime_error for what the scene does not have.
std::vector<double> numbersNow(const Simulation& simulation, const std::string& name);

void writeData(const std::string& file, const DataOverTime& values);
/// Throws std::runtime_error for a file that is damaged.
DataOverTime readData(const std::string& file);
/// A sentence on the worst number, or empty; `error`: as a share of the largest number of the reference.
std::string compareData(const DataOverTime& reference, const DataOverTime& actual, double tolerance, double& error);

}  // namespace stroma::command
