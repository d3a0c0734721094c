// SPDX-License-Identifier: LGPL-2.1-or-later
// The result of a sweep on a terminal.
#pragma once
#include <string>

#include "tools/sweep/table.h"

namespace stroma::sweep {

/// A line for each configuration: its values, the quantity that is compared, the error and the time to the end, or what
/// became of it. Of many configurations those on the front, and how many more there are.
std::string resultsText(const Findings& findings);

}  // namespace stroma::sweep
