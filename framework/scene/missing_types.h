// SPDX-License-Identifier: LGPL-2.1-or-later
// Types that scenes of other programs use and no module has. The front end knows them, the engine does not.
#pragma once
#include <functional>
#include <string>

namespace stroma {

/// What takes the place of a type, as a sentence, or an empty text.
using MissingTypeAdvice = std::function<std::string(const std::string& type)>;

/// Adds these answers to the message "there is no component". Global, as setThreads(): call it before the first scene is
/// loaded.
void adviseOnMissingTypes(MissingTypeAdvice advice);
std::string adviceOnMissingType(const std::string& type);

}  // namespace stroma
