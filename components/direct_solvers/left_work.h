// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>

#include "framework/algebra/stop.h"

namespace stroma {

/// For a call of a library that cannot be interrupted: makes it in a thread of its own and waits for its end, or for a
/// stop. Then false: the call goes on until it ends by itself, and nobody hears of it any more. All that `work` touches
/// must therefore be its own (shared pointers in the lambda). `code` is an address in the library that `work` belongs to,
/// which then stays in memory. What `work` throws is thrown here.
bool runOrLeave(std::function<void()> work, const void* code, StopToken stop);

}  // namespace stroma
