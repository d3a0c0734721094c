// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/scene/load.h"

namespace stroma {

/// At most one warning: when size, stiffness, density and gravity of a body are those of no thing in any consistent
/// system of units (m kg s, mm t s, cm g s and the like), which of them is off in the nearest, and what to write.
/// Silent where one of the four is unknown, and in scenes without dimensions (a density of 1).
void warnOfUnits(Scene& scene);

}  // namespace stroma
