// SPDX-License-Identifier: LGPL-2.1-or-later
// Types that scenes of other programs have and no module has. The engine knows none of them: a front end does.
#pragma once
#include <functional>
#include <string>

namespace stroma {

/// What takes the place of a type, as a sentence, or an empty text.
using MissingTypeAdvice = std::function<std::string(const std::string& type)>;

/// Answers stand beside "there is no component" from now on. Of the process, as setThreads(): call it before the first scene
/// is loaded.
void adviseOnMissingTypes(MissingTypeAdvice advice);
std::string adviceOnMissingType(const std::string& type);

}  // namespace stroma
