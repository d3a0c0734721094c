// SPDX-License-Identifier: LGPL-2.1-or-later
// What is said of an attribute: on its manual page and in editors.
#pragma once
#include <string>

#include "framework/scene/data.h"

namespace stroma::command {

/// "real [Pa], default 5000, in > 0, may change in a run".
std::string traitsOf(const Data& data);
/// The line of help, and its traits on the next one.
std::string helpOf(const Data& data);

}  // namespace stroma::command
