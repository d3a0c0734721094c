// SPDX-License-Identifier: LGPL-2.1-or-later
// GMRES of a matrix whose rows may turn: of S A x = S b with the scales S of the rows.
#pragma once
#include "components/iterative_solvers/gmres.h"
#include "components/iterative_solvers/light_rows.h"
#include "components/iterative_solvers/row_scales.h"

namespace stroma {

struct ScaledGmres {
  gmres::Space space;
  RowScales scales;
  Vector unscaled, right_side;  ///< where there are scales

  /// From the x given to |b - A x| <= relative |b|. `norm_b` becomes the |b| that record(residual) and the report refer to.
  template <class Product, class Precondition, class Record>
  SolveReport solve(const SystemMatrix& matrix, Product&& product, Precondition&& precondition, Record&& record, LightRows& light,
                    cg::Limits limits, double relative, ConstRows b, Rows x, double& norm_b) {
    scales.take(matrix);
    const bool is_scaled = !scales.empty();
    for (Vector* vector : {&unscaled, &right_side})
      if (is_scaled && vector->count() != b.count) vector->resize(b.count);
    const auto multiply = [&](ConstRows p, Rows out) {
      product(p, out);
      scales.multiply(out);
    };
    const auto divide = [&](ConstRows r, Rows z) {
      if (!is_scaled) return precondition(r, z);
      copy(r, unscaled);
      scales.divide(unscaled);
      precondition(unscaled.rows(), z);
    };
    ConstRows given = b;
    if (is_scaled) {
      copy(b, right_side);
      scales.multiply(right_side);
      given = right_side;
      norm_b = norm(given);
    }
    limits.residual = relative * norm_b;
    space.resize(b.count);
    const auto solve = [&](auto now) { return gmres::solve(multiply, divide, record, now, given, space, x); };
    const auto left = [&] { return scales.divide(space.basis[0]); };
    return light.solveAll(matrix, limits, relative, solve, left, x);
  }
};

}  // namespace stroma
