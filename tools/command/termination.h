// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>

namespace stroma::command {

/// From now on a thread of its own waits for SIGTERM, which interrupts no other one: METIS takes that signal for an error of
/// its own while it orders a matrix, and the process would go on. To be called before there are other threads.
void hearTermination();
/// What SIGTERM does from now on, in that thread; empty: it ends the process, as it does at first. Waits until what it has
/// begun is done.
void onTermination(std::function<void()> act);
/// What the signal does without a handler.
void endBy(int number);

}  // namespace stroma::command
