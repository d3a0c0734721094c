// SPDX-License-Identifier: LGPL-2.1-or-later
// Attributes that were set in a run, as values of a checkpoint.
#pragma once
#include <vector>

#include "framework/scene/archive.h"
#include "framework/scene/load.h"

namespace stroma {

/// Writes them to the present owner of the archive, or reads them.
void visitEdits(Archive& archive, std::vector<Override>& edits);

}  // namespace stroma
