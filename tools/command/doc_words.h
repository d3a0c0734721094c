// SPDX-License-Identifier: LGPL-2.1-or-later
// What `stroma doc` says of a word that is no component.
#pragma once
#include "framework/scene/modules.h"

namespace stroma::command {

/// Prints the scene's file format, a topic, what became of a component of SOFA, or the help of a subcommand, and returns
/// the exit code. Throws UsageError with the nearest word where there is nothing to say.
int explainWord(const std::string& word, const Modules& modules);

}  // namespace stroma::command
