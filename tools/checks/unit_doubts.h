// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/scene/load.h"

namespace stroma {

/// At most one warning: when sizes, stiffness, densities and gravity of the bodies are those of no things in any
/// consistent system of units (m kg s, mm t s, cm g s ...). It is read in the system in which the fewest bodies
/// are off, names the first of them, and says what to write where that is plain. With a unit anywhere, SI is meant.
/// Silent on bodies whose moduli are unknown, and on bodies without dimensions: a density of 1, with another 1 or
/// without gravity, in a scene without units.
void warnOfUnits(const Scene& scene, Diagnostics& diagnostics);

}  // namespace stroma
