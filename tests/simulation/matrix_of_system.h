// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "framework/simulation/simulation.h"

namespace stroma::test {

/// Products, the assembled matrix and the diagonal, from the fields and from the matrix, are of one matrix; `size`: of its entries.
/// Returns the diagonal, shape (independent rows, 9).
inline std::vector<double> expectOneMatrix(System& system, const MatrixFactors& factors, double size) {
  MechanicalMatrix& matrix = system.matrix();
  matrix.withFactors(factors);
  std::vector<double> by_fields, of_matrix;
  matrix.diagonalBlocks(by_fields);
  Vector p(system.independentRows()), product(p.count()), assembled(p.count());
  for (Index i = 0; i < p.count(); ++i) p[i] = Vec3(std::sin(i), std::cos(3 * i), std::sin(7 * i + 1));
  system.constraints().project(p);
  matrix.multiply(p, product);
  matrix.assemble().multiply(p, assembled);
  EXPECT_LT(distance(product, assembled), 1e-12 * norm(assembled));
  matrix.diagonalBlocks(of_matrix);
  EXPECT_EQ(by_fields.size(), of_matrix.size());
  if (by_fields.size() == of_matrix.size())
    for (std::size_t i = 0; i < of_matrix.size(); ++i) EXPECT_NEAR(by_fields[i], of_matrix[i], 1e-12 * size) << i;
  return of_matrix;
}

}  // namespace stroma::test
