// SPDX-License-Identifier: LGPL-2.1-or-later
// Many scenes of SOFA at once: what runs and what does not, and how far results are from those that SOFA stored.
#pragma once
#include <string>

#include "framework/simulation/simulation.h"
#include "tools/command/options.h"

namespace stroma::command {

extern const Subcommand migrate_command;

/// Nothing observes but what may refuse a step or expects a result: no file is left behind.
void dropWriters(Simulation& simulation);

/// `stroma check --sofa FOLDER|LIST`: a line for each scene and a summary. Returns the exit code.
int surveySofaScenes(const std::string& where, const Values& values);
/// `stroma regress LIST.regression-tests|FOLDER`. Returns the exit code.
int regressSofaLists(const std::string& where, const Values& values);

}  // namespace stroma::command
