// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes in Python. The command knows no Python: it gives its place to an interpreter, which runs the same subcommand with the
// same words from a module (tools/python/sofa_compat) and plays the scene in it.
#pragma once
#include "tools/command/command.h"

namespace stroma::command {

/// Whether a word is a scene in Python, or a list with one.
bool needsPython(const Arguments& arguments);
/// Goes on as the interpreter. Returns with an exit code, and a sentence on standard error, when there is none.
int goOnInPython(const Arguments& arguments);

}  // namespace stroma::command
