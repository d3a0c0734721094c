// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/scene/diagnostics.h"

namespace stroma {

/// Receives problems that are raised while no scene is being loaded, such as in a step, from the thread that runs the scene.
/// The default prints them to the standard error stream (tools/platform). A program may replace it before it loads scenes.
extern void (*problem_listener)(const Problem&);

}  // namespace stroma
