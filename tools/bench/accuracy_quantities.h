// SPDX-License-Identifier: LGPL-2.1-or-later
// The quantities of the standing set's problems, at the end of their solutions.
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"

namespace stroma::bench {

double beamEnd(const Simulation& simulation);     ///< deflection of the end [m]
double cookCorner(const Simulation& simulation);  ///< way of the upper corner [mm]
double cubeBulge(const Simulation& simulation);   ///< of the middle of a side [mm]
double barTorque(const Simulation& simulation);   ///< of the forces that hold the lower end, about the axis [mN mm]
double blockTop(const Simulation& simulation);    ///< way of the top [mm]
double chamberGrowth(const Simulation& simulation);  ///< of the inner radius [mm]
double ventricleApex(const Simulation& simulation);  ///< way of its inner side down [mm]
double muscleEnd(const Simulation& simulation);      ///< way of the end of scenes/benchmarks/muscle_bar.xml up [mm]
double middleOverEnd(const Simulation& simulation);  ///< deflections of scenes/benchmarks/memory_beam.xml
/// Degree of consolidation of scenes/benchmarks/column.xml: of the way of the top from undrained to drained.
double columnDegree(const Simulation& simulation);
double legDent(const Simulation& simulation);   ///< mean way of the strap along y [m]
double organTip(const Simulation& simulation);  ///< mean way of the pulled end along y [m]

/// A bead of the truth cube, from the middle of the cube at rest: at rest, and under 18.25 % [mm].
struct Bead {
  Vec3 rest, pressed;
};
/// Of a file of Kerdok et al. 2003. Throws std::runtime_error when it is none.
std::vector<Bead> readBeads(const std::string& file);
/// Mean distance of the computed places of beads from the measured ones [mm], in a cube of a grid from 0 to 80 mm: each moves with
/// its cell, trilinearly.
double beadDistance(const Simulation& simulation, const std::vector<Bead>& beads);

}  // namespace stroma::bench
