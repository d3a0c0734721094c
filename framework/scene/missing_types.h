// SPDX-License-Identifier: LGPL-2.1-or-later
// Types of other programs that no module has. The engine knows none of them; a front end provides the list.
#pragma once
#include <functional>
#include <string>

namespace stroma {

/// A sentence about the replacement of a type, or empty.
using MissingTypeAdvice = std::function<std::string(const std::string& type)>;

/// Adds these sentences to the message "there is no component". Process-wide, like setThreads(): call it before the first
/// scene is loaded.
void adviseOnMissingTypes(MissingTypeAdvice advice);
std::string adviceOnMissingType(const std::string& type);

}  // namespace stroma
