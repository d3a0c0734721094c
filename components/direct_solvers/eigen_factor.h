// SPDX-License-Identifier: LGPL-2.1-or-later
// Sparse factorisations of Eigen in the form that a direct solver keeps for a matrix.
#pragma once
#include "components/direct_solvers/sparse_copy.h"
#include "framework/algebra/direct_solver.h"

namespace stroma {

/// `Solver` is one of Eigen's sparse direct solvers; `failure` is what a matrix that it cannot factor is called.
template <class Solver, SolveStop failure, class Base = Factorisation>
class EigenFactor : public Base {
 public:
  bool analyse(const BlockMatrix& matrix, StopToken) override {
    copy_.layOut(matrix);
    solver_.analyzePattern(copy_.matrix);
    return true;
  }
  void load(const BlockMatrix& matrix) override { copy_.fill(matrix); }
  SolveStop factor(Index&, StopToken) override {
    solver_.factorize(copy_.matrix);
    return solver_.info() == Eigen::Success ? SolveStop::converged : failure;
  }
  void apply(ConstRows b, Rows x) override {
    gather(b, right_);
    solution_ = solver_.solve(right_);
    scatter(solution_, x);
  }
  void applyAll(std::span<const ConstRows> b, std::span<const Rows> x) override {
    constexpr std::size_t most = 16;
    for (std::size_t first = 0; first < b.size(); first += most) {
      const std::size_t count = std::min(most, b.size() - first);
      rights_.resize(copy_.matrix.rows(), Eigen::Index(count));
      for (std::size_t k = 0; k < count; ++k) gather(b[first + k], right_), rights_.col(Eigen::Index(k)) = right_;
      solutions_ = solver_.solve(rights_);
      for (std::size_t k = 0; k < count; ++k) solution_ = solutions_.col(Eigen::Index(k)), scatter(solution_, x[first + k]);
    }
  }
  /// At a nanosecond for each multiply-add; the factor's entries are counted as ten times those of the matrix.
  Factorisation::Cost cost() const override {
    const double entries = 10. * double(copy_.matrix.nonZeros()), rows = double(copy_.matrix.rows());
    return {1e-9 * entries * entries / rows, 2e-9 * entries};
  }

 protected:
  SparseCopy copy_;
  Solver solver_;

 private:
  Eigen::VectorXd right_, solution_;
  Eigen::MatrixXd rights_, solutions_;
};

}  // namespace stroma
