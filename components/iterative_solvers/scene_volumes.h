// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/linear_solver.h"
#include "framework/algebra/volume_terms.h"

namespace stroma {

class Node;
/// The volumes that the force fields below `root` resist, or the matrix itself says that it resists (HasVolumeTerms). None unless most of
/// them have a bulk modulus far above the shear modulus (Poisson's ratio 0.495), and none of mapped states. Whether they are in the values
/// of the matrix is not looked at.
VolumeTerms volumesOfFields(SystemMatrix& matrix, const Node& root);
/// The same with the directions that are held taken out.
VolumeTerms stiffVolumesOf(SystemMatrix& matrix, const Node& root);
/// Whether the values of the matrix have them: not those of a step in time, or with rows that are tied to others.
bool hasStiffVolumes(SystemMatrix& matrix, const Node& root);

}  // namespace stroma
