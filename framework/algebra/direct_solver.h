// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/per_matrix.h"

namespace stroma {

/// Implemented by components that use the factors of a direct solver of their node: that solver is then theirs and not
/// the integrator's.
class FactorUser {
 public:
  virtual ~FactorUser() = default;
  /// Asked when links are resolved, before init().
  virtual bool usesFactorOf(const Component& solver) const = 0;
};

/// The analysed pattern and the factors of one matrix, with the work space to apply them.
class Factorisation {
 public:
  virtual ~Factorisation() = default;
  /// Orders the pattern and lays out the factors. False when it was stopped: then there are none.
  virtual bool analyse(const BlockMatrix& matrix, StopToken stop) = 0;
  /// Takes the values of a matrix of the analysed pattern: the matrix is not read again.
  virtual void load(const BlockMatrix& matrix) = 0;
  /// Factors the loaded values. Returns the reason it could not (`row`: where, when that is known), else converged.
  virtual SolveStop factor(Index& row, StopToken stop) = 0;
  /// x = A^-1 b with the last factors, of shape (rows); no residual is computed.
  virtual void apply(ConstRows b, Rows x) = 0;
  /// The same for each b[i] and x[i]; a factor may be read once for many of them.
  virtual void applyAll(std::span<const ConstRows> b, std::span<const Rows> x);
  /// The same where about six right digits are enough: in a preconditioner.
  virtual void applyRoughly(ConstRows b, Rows x) { apply(b, x); }
  /// Seconds on one core, estimated from counts of operations and not from a clock, so that what is decided by them is
  /// the same in each run.
  struct Cost {
    double factor = 0, apply = 0;
    /// Of a Cholesky factor of so many numbers that so many operations make.
    static Cost of(double entries, double flops, bool in_single);
  };
  virtual Cost cost() const = 0;
};

/// A linear solver that factors the assembled matrix. Each matrix has a Factorisation of its own: analysed once for each
/// of its patterns, factored again when its values may have changed. The residual of each solve is computed; a solve is
/// refined when it is above 1e-10 |b|, and again while it is above 1e-8 |b| and halves. What stays above 1e-5 |b| is
/// reported as stagnated. Outputs that describe a factorisation are those of the last one, whatever matrix it was of.
class DirectSolver : public LinearSolver {
 public:
  void declare(DataTable& table) override;  ///< template, factorisations
  SolveReport solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms) final {
    return solveAll(matrix, {&b, 1}, {&x, 1}, terms);
  }
  SolveReport solveAll(SystemMatrix& matrix, std::span<const ConstRows> b, std::span<const Rows> x, const SolveTerms& terms) override;
  bool answersLookup() const override;

  /// The factors of the matrix as it is now. Null when it has none, or was stopped; the report then says why and where.
  /// They stay where they are, with their numbers, until the next call with this matrix.
  Factorisation* factor(SystemMatrix& matrix, SolveReport& report, StopToken stop);
  /// Gives the factors of `former`, which are not needed any more, to a matrix that has none so far: its pattern is analysed only where
  /// it is another one, and numbers go to the same memory.
  void handOver(SystemMatrix& former, SystemMatrix& matrix);

 protected:
  virtual std::unique_ptr<Factorisation> makeFactorisation(bool symmetric) const = 0;
  /// Told after each factorisation, for outputs.
  virtual void noteFactored(const Factorisation&) {}
  /// What factors without one right digit mean.
  virtual SolveStop uselessFactor() const { return SolveStop::breakdown; }
  /// True when what they give is wanted all the same, as the solution of least squares.
  virtual bool givesLeastSquares() const { return false; }

 private:
  struct Kept {
    std::unique_ptr<Factorisation> factors;
    bool symmetric = true, factored = false;
    MatrixKey analysed, key;  ///< whose pattern was analysed, whose values were factored
    Vector residual, correction;
  };
  bool update(SystemMatrix& matrix, Kept& kept, SolveReport& report, StopToken stop);
  SolveReport finish(const BlockMatrix& a, ConstRows b, Rows x, Kept& kept) const;
  double refine(const BlockMatrix& a, ConstRows b, double norm_b, Rows x, Kept& kept) const;

  std::string template_ = "CompressedRowSparseMatrixMat3x3";
  int factorisations_ = 0;
  PerMatrix<Kept> kept_;
};

}  // namespace stroma
