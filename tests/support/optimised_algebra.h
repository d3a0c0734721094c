// SPDX-License-Identifier: LGPL-2.1-or-later
// What dense_algebra.h calculates with, on columns of numbers: no type of Eigen, of which its source has another one.
#pragma once

namespace stroma::test::optimised {

void solve(long size, const double* a, const double* b, double* x);
void leastSquares(long rows, long columns, const double* a, const double* b, double* x);
void orthonormal(long size, const double* columns, double* out);
/// `vectors` may be null.
void spectrum(long size, const double* a, double* values, double* vectors);
void kabschRotation(const double* a, double* rotation);

}  // namespace stroma::test::optimised
