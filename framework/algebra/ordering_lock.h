// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <mutex>

namespace stroma {

/// Hold it while METIS orders a graph. METIS seeds the process-wide random numbers of the C library and draws from them:
/// its order is reproducible only if nothing else draws in between.
std::mutex& orderingLock();

}  // namespace stroma
