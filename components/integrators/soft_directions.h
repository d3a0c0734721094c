// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/integrators/shifted_matrix.h"
#include "framework/simulation/step.h"

namespace stroma {

/// Restores the part of Newton's direction that a shift s takes away along soft and unstable modes. With the tangent A, the diagonal D
/// of the shift and d = (A + s D)^-1 r, let y be eigenvectors of A y = l D y with y.D y = 1. Then
///
///   d = sum (r.y) / (l + s) y    becomes    sum (r.y) / max(|l|, least) y
///
/// for the l that are negative or small compared to s. A column near its buckling load has one mode a thousand times softer than the
/// shift, which would make only a thousandth of its way per iteration. Along an unstable mode the energy decreases on both sides, and d
/// goes to the side that r points to. The modes are Ritz vectors in the Krylov space of (A + s D)^-1 D that starts with d. It
/// contains the modes in r; each of its vectors costs one more solve with the same factors.
///
/// `d`: on entry the solution. It is unchanged if A is not symmetric or a solve fails.
void restoreSoftDirections(LinearSolver& solver, ShiftedMatrix& shifted, double shift, ConstRows r, Rows d, const SolveTerms& terms,
                           StepReport& report);

/// Whether a symmetric matrix has an unstable direction. Solvers for symmetric matrices report it in the first solve. For solvers of any
/// regular matrix it is a negative Ritz value of A^-1 D in a Krylov space, with D the mean absolute diagonal of each row. A negative Ritz
/// value proves an unstable direction, and modes close to zero are found first. All solves use the factors of the first one.
bool hasUnstableMode(LinearSolver& solver, SystemMatrix& matrix, const SolveTerms& terms, StepReport& report);

}  // namespace stroma
