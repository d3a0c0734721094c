// SPDX-License-Identifier: LGPL-2.1-or-later
// A profile for people: a trace for Perfetto, and a table.
#pragma once
#include <string>

#include "tools/profile/profiler.h"

namespace stroma::profile {

/// Chrome's format of traces: complete events by thread, counters of iterations and allocations.
std::string traceOf(const Profile& profile);

/// The shares of the wall time, largest first, of the thread that steps; what the others did.
std::string tableOf(const Profile& profile, const std::string& file);

}  // namespace stroma::profile
