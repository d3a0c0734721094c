// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <mutex>

namespace stroma {

/// To be held while METIS orders a graph. It seeds the random numbers of the C library, which the process has once, and
/// draws from them: the order is the same in each run only when nobody draws in between.
std::mutex& orderingLock();

}  // namespace stroma
