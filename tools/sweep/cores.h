// SPDX-License-Identifier: LGPL-2.1-or-later
// The machine: which processors there are, and how busy they are.
#pragma once
#include <string>
#include <vector>

#include "tools/session/processors.h"

namespace stroma::sweep {

/// Mean number of busy processors over the last minute.
double loadOfMachine();

/// How long these have been busy since the machine started, each added to the others [s].
double busySeconds(const std::vector<int>& cores);
/// The same, of the text of /proc/stat.
double busySecondsIn(const std::string& text, const std::vector<int>& cores, double ticks_a_second);

/// "host: processor, 8 cores"
std::string machineText();
std::string hostName();

}  // namespace stroma::sweep
