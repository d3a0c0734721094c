// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/simulation/simulation.h"

namespace stroma {

/// A note for each BeamFEMForceField whose nodes all have the same mass (UniformMass) and whose chains have free ends: an end then
/// has twice its share. Not in SOFA's dialect, where the numbers are SOFA's, and not in statics.
void noteEqualMassesOfBeams(const Simulation& simulation, Diagnostics& diagnostics);

}  // namespace stroma
