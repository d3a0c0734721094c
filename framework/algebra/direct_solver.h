// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/linear_solver.h"

namespace stroma {

/// Implemented by components that use the factors of a direct solver of their node: that solver is then theirs and not
/// the integrator's.
class FactorUser {
 public:
  virtual ~FactorUser() = default;
  /// Asked when links are resolved, before init().
  virtual bool usesFactorOf(const Component& solver) const = 0;
};

/// A linear solver that factors the assembled matrix. The pattern is analysed once; numbers are factored again when the
/// matrix may have changed. The residual of each solve is computed, and refined once when it is above 1e-10 |b|.
class DirectSolver : public LinearSolver {
 public:
  void declare(DataTable& table) override;  ///< template, factorisations
  SolveReport solve(SystemMatrix& matrix, ConstRows b, Rows x) override;
  bool answersLookup() const override;

  /// Factors the matrix now. False when that is not possible; the report then says why and where.
  bool factor(SystemMatrix& matrix, SolveReport& report);
  /// x = A^-1 b with the last factors, of shape (rows); no residual is computed.
  virtual void applyFactors(ConstRows b, Rows x) = 0;
  /// The same where about six right digits are enough: in a preconditioner.
  virtual void applyFactorsRoughly(ConstRows b, Rows x) { applyFactors(b, x); }
  /// Seconds on one core, estimated from counts of operations and not from a clock, so that what is decided by them is
  /// the same in each run; known after factor().
  struct Cost {
    double factor = 0, apply = 0;
  };
  virtual Cost cost() const = 0;

 protected:
  virtual void analyse(const BlockMatrix& matrix, bool symmetric) = 0;
  /// Factors the values of the analysed pattern. Returns the reason it could not (report.row: where), else converged.
  virtual SolveStop factorValues(const BlockMatrix& matrix, Index& row) = 0;
  /// What a factor without one right digit means.
  virtual SolveStop uselessFactor() const { return SolveStop::breakdown; }
  /// residual_ = b - A x; returns its norm.
  double residual(const BlockMatrix& matrix, ConstRows b, ConstRows x);
  bool isCurrent(const SystemMatrix& matrix) const { return factored_ && key_ == matrix.key(); }
  void forgetFactors() { factored_ = false; }

 private:
  bool analyseIfNew(const BlockMatrix& matrix, bool symmetric);

  std::string template_ = "CompressedRowSparseMatrixMat3x3";
  int factorisations_ = 0;
  bool symmetric_ = true, factored_ = false;
  std::vector<Index> row_start_, columns_;  ///< the pattern that was analysed
  MatrixKey key_;                           ///< of the factors
  Vector residual_, correction_;
};

}  // namespace stroma
