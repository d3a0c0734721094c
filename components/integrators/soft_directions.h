// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/integrators/shifted_matrix.h"
#include "framework/simulation/step.h"

namespace stroma {

/// What a shift takes from Newton's direction in soft and unstable directions. With A the tangent, D the diagonal of the shift s and
/// d = (A + s D)^-1 r, let y be eigenvectors of A y = l D y with y.D y = 1. Then
///
///   d = sum (r.y) / (l + s) y    becomes    sum (r.y) / max(|l|, least) y
///
/// for the l that are small beside s or negative: a column beside its buckling load has one mode that is a thousand times softer than
/// what a shift adds, and would go a thousandth of its way in each iteration. Along a mode below zero the energy falls to both sides,
/// and d goes to the one that r points to. The modes are Ritz vectors of the Krylov space of (A + s D)^-1 D that begins with d, which
/// holds those that r has a part in; each of its vectors is one more solve with the same factors.
///
/// `d`: on entry the solution. It stays as it is where A is not symmetric or a solve fails.
void restoreSoftDirections(LinearSolver& solver, ShiftedMatrix& shifted, double shift, ConstRows r, Rows d, const SolveTerms& terms,
                           StepReport& report);

/// Whether a symmetric matrix has an unstable direction. Solvers of symmetric matrices tell in the first solve. Of those that take any
/// regular one: a Ritz value below zero of A^-1 D, D the mean size of each row's diagonal, on a Krylov space. There is one then, and modes
/// beside zero are the first that are found. All but the first solve have its factors.
bool hasUnstableMode(LinearSolver& solver, SystemMatrix& matrix, const SolveTerms& terms, StepReport& report);

}  // namespace stroma
