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
/// Those of the force fields, for a matrix that has no values yet: whether they are in it is not looked at.
VolumeTerms likelyVolumesOf(SystemMatrix& matrix, const Node& root);
/// Of so many solves with displacements and pressures (MixedSolve) and a matrix each, in the sense of SolverCosts. `loose`: Newton's
/// method asks for a digit.
double secondsWithPressures(SystemMatrix& matrix, const VolumeTerms& terms, int solves, bool loose);

}  // namespace stroma
