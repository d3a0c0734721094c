// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/linear_solver.h"
#include "framework/algebra/volume_terms.h"

namespace stroma {

class Node;
/// The volumes that a matrix resists, with the directions that are held taken out: those it has itself, or those of the force fields
/// below `root`. None unless most of them have a bulk modulus far above the shear modulus (Poisson's ratio 0.495), and where the
/// matrix is not that of the fields: of a step in time, of mapped states, with rows that are tied to others.
VolumeTerms stiffVolumesOf(SystemMatrix& matrix, const Node& root);

}  // namespace stroma
