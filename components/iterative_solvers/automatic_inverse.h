// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "components/iterative_solvers/multigrid.h"
#include "components/iterative_solvers/solver_costs.h"
#include "components/iterative_solvers/sweeps.h"

namespace stroma {

/// Block Jacobi until its iterations say that multigrid costs less, and back when that proves wrong. What iterations cost is
/// counted in those of block Jacobi (MultigridCosts): the dearer a product of the elements is, the less is one with multigrid.
/// No clock is read: each run does the same.
class AutomaticInverse final : public ApproximateInverse {
 public:
  /// `may_change`: false for a scene that caps iterations or wants no matrix.
  explicit AutomaticInverse(bool may_change) : may_change_(may_change) {}

  bool follow(SystemMatrix& matrix, SolveReport& report, StopToken stop) override;
  void apply(ConstRows r, Rows z) override { now_.has_multigrid ? multigrid_.apply(r, z) : blocks_.apply(r, z); }
  void solved(const SolveReport& report) override;
  void reset() override;
  void serialize(SystemMatrix& matrix, Archive& archive) override;
  void keep(const SystemMatrix& matrix) override { kept_ = now_, multigrid_.keep(matrix); }
  void takeBack(const SystemMatrix& matrix) override { now_ = kept_, multigrid_.takeBack(matrix); }

  /// Nanoseconds of a product in the solves that follow, 0: not known.
  void setProductCost(double nanoseconds) { product_ = nanoseconds; }
  /// What preconditions now, and why.
  std::string choice() const;
  int changes() const { return now_.changes; }
  /// Iterations of a usual solve.
  int expectedIterations() const { return now_.has_multigrid ? 15 : 100; }

 private:
  /// What later solves depend on.
  struct Memory {
    bool has_multigrid = false;
    int changes = 0;
    double lost = 0;            ///< iterations of block Jacobi more than the other choice would have cost
    double rate = 0;            ///< iterations for a decade of the residual in the last solves by block Jacobi, a moving mean
    double multigrid_rate = 0;  ///< the same in the last solve by multigrid
  };
  void change();

  bool may_change_;
  double product_ = 0;
  MultigridCosts costs_;  ///< of the matrix that was followed last
  BlockJacobiInverse blocks_;
  Multigrid multigrid_;
  Memory now_, kept_;
};

}  // namespace stroma
