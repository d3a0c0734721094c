// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cassert>

#include "components/direct_solvers/sparse_copy.h"
#include "framework/algebra/direct_solver.h"

namespace stroma {

/// Factors of the whole matrix with its zeros: for small systems.
class DenseFactor : public Factorisation {
 public:
  /// More unknowns than this need more memory than a desk has.
  static constexpr Index most_rows = 4000;

  bool analyse(const BlockMatrix& matrix, StopToken) override {
    assert(matrix.rows() <= most_rows);  // LinearSolver::mostRows() of its solvers
    dense_.setZero(3 * matrix.rows(), 3 * matrix.rows());
    return true;
  }
  void load(const BlockMatrix& matrix) override {
    dense_.setZero();  // a decomposition may leave its own numbers there
    for (Index i = 0; i < matrix.rows(); ++i)
      for (Index s = matrix.rowStart()[i]; s < matrix.rowStart()[i + 1]; ++s)
        dense_.block<3, 3>(3 * i, 3 * matrix.columns()[s]) =
            Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix.values().data() + 9 * std::size_t(s));
  }
  Cost cost() const override {
    const double n = double(dense_.rows());
    return {1e-10 * n * n * n, 1e-9 * n * n};
  }

 protected:
  Eigen::MatrixXd dense_;
};

}  // namespace stroma
