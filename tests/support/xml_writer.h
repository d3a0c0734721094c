// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/scene/load.h"

namespace stroma {

/// A description back as XML: what was read, written and read again is the same.
std::string writeXml(const NodeDescription& root);

}  // namespace stroma
