// SPDX-License-Identifier: LGPL-2.1-or-later
// How much of a result are SOFA's ways: the scene is run with all of them, and once without each.
#pragma once
#include "tools/command/options.h"

namespace stroma::command {

/// `stroma explain SCENE --quirks`. Returns the exit code.
int explainQuirks(const std::string& scene, const Values& values);

}  // namespace stroma::command
