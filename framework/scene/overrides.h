// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/scene/load.h"

namespace stroma {

/// Writes each override into the description; one with an unknown path is an error that suggests the nearest path.
void applyOverrides(const std::vector<Override>& overrides, NodeDescription& root, Diagnostics& diagnostics);

/// Whether an attribute was given by an override rather than by a file.
bool isOverride(const SourceLocation& where);

}  // namespace stroma
