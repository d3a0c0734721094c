// SPDX-License-Identifier: LGPL-2.1-or-later
// The points of the grid that a sweep covers.
#pragma once
#include <string>
#include <vector>

#include "tools/sweep/axis.h"
#include "tools/sweep/sweeper.h"

namespace stroma::sweep {

struct Configuration {
  std::vector<std::size_t> choice;    ///< the value of each axis; empty for the run of --reference-set
  std::vector<std::string> settings;  ///< "PATH.ATTR=VALUE", those of all runs first
  int threads = 1;
  std::string key;     ///< digest of all that its result depends on
  std::string folder;  ///< of its runs

  bool isExtraReference() const { return choice.empty(); }
};

/// Every combination, the last axis fastest. Without keys.
std::vector<Configuration> allConfigurations(const SweepRequest& request, const std::vector<Axis>& axes);
/// The one with these values.
Configuration configurationOf(const SweepRequest& request, const std::vector<Axis>& axes,
                              const std::vector<std::size_t>& choice);
/// The finest of the grid with the settings of --reference-set on top.
Configuration extraReference(const SweepRequest& request, const std::vector<Axis>& axes);

/// Position in allConfigurations().
std::size_t indexOf(const std::vector<Axis>& axes, const std::vector<std::size_t>& choice);
/// "grid.n=41 5 5, fem.method=polar"
std::string nameOf(const std::vector<Axis>& axes, const Configuration& configuration);

/// Arguments of the run, program not included: run SCENE, its length, its settings.
std::vector<std::string> runArguments(const SweepRequest& request, const Configuration& configuration);
/// The same as a line for a shell, for a user.
std::string commandLine(const SweepRequest& request, const Configuration& configuration);
/// The command line of the sweep itself, for a user.
std::string commandLine(const SweepRequest& request);
/// In single quotes where a shell needs them.
std::string quoted(const std::string& word);

}  // namespace stroma::sweep
