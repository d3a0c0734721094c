// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/per_matrix.h"

namespace stroma {

/// Implemented by components that use the factors of a direct solver in their node. That solver then belongs to them and
/// not to the integrator.
class FactorUser {
 public:
  virtual ~FactorUser() = default;
  /// Called when links are resolved, before init().
  virtual bool usesFactorOf(const Component& solver) const = 0;
};

/// The analysed pattern and the factors of one matrix, with the work space to apply them.
class Factorisation {
 public:
  virtual ~Factorisation() = default;
  /// Orders the pattern and lays out the factors. Returns false if it was stopped: then there are none.
  virtual bool analyse(const BlockMatrix& matrix, StopToken stop) = 0;
  /// Copies the values of a matrix with the analysed pattern; the matrix is not read again.
  virtual void load(const BlockMatrix& matrix) = 0;
  /// Factors the loaded values. Returns the reason for a failure (`row`: where, if known), otherwise converged.
  virtual SolveStop factor(Index& row, StopToken stop) = 0;
  /// x = A^-1 b with the last factors, of shape (rows); no residual is computed.
  virtual void apply(ConstRows b, Rows x) = 0;
  /// The same for each b[i] and x[i]; the factor may be read once for many of them.
  virtual void applyAll(std::span<const ConstRows> b, std::span<const Rows> x);
  /// The same to about six correct digits, for a preconditioner.
  virtual void applyRoughly(ConstRows b, Rows x) { apply(b, x); }
  /// Seconds on one core, estimated from operation counts and not measured, so that decisions based on them are the same
  /// in every run.
  struct Cost {
    double factor = 0, apply = 0;
    /// From the number of entries and operations of a Cholesky factor.
    static Cost of(double entries, double flops, bool in_single);
  };
  virtual Cost cost() const = 0;
};

/// A linear solver that factors the assembled matrix. Each matrix has its own Factorisation: analysed once per pattern,
/// factored again when its values may have changed. Every solve computes its residual. It is refined if the residual
/// exceeds 1e-10 |b|, and again while it exceeds 1e-8 |b| and at least halves. A residual above 1e-5 |b| is reported as
/// stagnated. Outputs that describe a factorisation belong to the last one, of whatever matrix.
class DirectSolver : public LinearSolver {
 public:
  void declare(DataTable& table) override;  ///< template, factorisations
  SolveReport solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms) final {
    return solveAll(matrix, {&b, 1}, {&x, 1}, terms);
  }
  SolveReport solveAll(SystemMatrix& matrix, std::span<const ConstRows> b, std::span<const Rows> x, const SolveTerms& terms) override;
  bool answersLookup() const override;

  /// The factors of the current matrix. Null if it has none or was stopped; the report then says why and where. They stay
  /// valid and unchanged until the next call with this matrix.
  Factorisation* factor(SystemMatrix& matrix, SolveReport& report, StopToken stop);
  /// Gives the factors of `former`, which are not needed any more, to a matrix that has none so far: its pattern is analysed only where
  /// it is another one, and numbers go to the same memory.
  void handOver(SystemMatrix& former, SystemMatrix& matrix);

 protected:
  virtual std::unique_ptr<Factorisation> makeFactorisation(bool symmetric) const = 0;
  /// Called after each factorisation, for outputs.
  virtual void noteFactored(const Factorisation&) {}
  /// The reason to report if factors have no correct digit.
  virtual SolveStop uselessFactor() const { return SolveStop::breakdown; }
  /// True if their result is wanted all the same, like a least-squares solution.
  virtual bool givesLeastSquares() const { return false; }

 private:
  struct Kept {
    std::unique_ptr<Factorisation> factors;
    bool symmetric = true, factored = false;
    MatrixKey analysed, key;  ///< of the analysed pattern, of the factored values
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
