// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/scene/load.h"

namespace stroma {

/// An error for each density that is written with a unit of another dimension than the cells that carry the mass have: of volumes,
/// areas or lines. It says the right value where a membrane's thickness or a beam's radius is known.
void refuseDensitiesOfOtherCells(const Scene& scene, Diagnostics& diagnostics);

}  // namespace stroma
