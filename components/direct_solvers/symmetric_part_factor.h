// SPDX-License-Identifier: LGPL-2.1-or-later
// An unsymmetric matrix A through the factors of its symmetric part S = (A + A^T)/2: A x = b is solved by GMRES (Saad,
// Schultz 1986) on A S^-1. With N = A - S the eigenvalues of A S^-1 lie on 1 + i r with |r| <= |S^-1/2 N S^-1/2|, and m
// iterations reduce the residual by about (r / (1 + sqrt(1 + r^2)))^m (Concus and Golub 1976; Widlund 1978). The tangent of a
// corotational method has an N of the size of the strains.
#pragma once
#include "components/direct_solvers/cholesky_factor.h"
#include "components/direct_solvers/interruptible_factor.h"
#include "components/direct_solvers/lu_factor.h"

namespace stroma {

class SymmetricPartFactor final : public Factorisation {
 public:
  bool analyse(const BlockMatrix& matrix, StopToken stop) override;
  void load(const BlockMatrix& matrix) override;
  SolveStop factor(Index& row, StopToken stop) override;
  /// To a residual of 1e-12 |b|, or as far as it goes; goes on with L U for these values where that is not enough. x is zero
  /// when the stop that factor() was given ends that, or there are no factors.
  void apply(ConstRows b, Rows x) override;
  void applyAll(std::span<const ConstRows> b, std::span<const Rows> x) override {
    lu_ ? lu_->applyAll(b, x) : Factorisation::applyAll(b, x);
  }
  Cost cost() const override;

  std::string ordering() const { return lu_ ? "COLAMD" : symmetric_->ordering(); }
  double flops() const { return lu_ ? 0 : symmetric_->flops(); }
  double entries() const { return lu_ ? lu_->inner().entries() : symmetric_->entries(); }

 private:
  bool solveByProducts(ConstRows b, Rows x, StopToken stop);
  SolveStop factorUnsymmetric(Index& row, StopToken stop);

  BlockMatrix matrix_;             ///< A
  BlockMatrix part_;               ///< S
  std::vector<Index> transposed_;  ///< shape (blocks): the slot of the block across the diagonal
  std::unique_ptr<CholeskyFactor> symmetric_;
  std::unique_ptr<InterruptibleFactor<LUFactor>> lu_;  ///< null: not needed for these values
  std::vector<Vector> basis_;                          ///< of the Krylov space, orthonormal; grows as needed
  Vector work_;
  StopToken stop_;  ///< of the last factor(), until the first apply() after it
  bool is_given_up_ = false;  ///< there is no solution with these values, or nobody waits for it
};

}  // namespace stroma
