// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/lu_factor.h"

#include <Eigen/SparseLU>

#include "components/direct_solvers/sparse_copy.h"

namespace stroma {
namespace {

class EigenLUFactor final : public LUFactor {
 public:
  void analyse(const BlockMatrix& matrix) override {
    copy_.layOut(matrix);
    lu_.analyzePattern(copy_.matrix);
  }
  SolveStop factor(const BlockMatrix& matrix, Index&) override {
    copy_.fill(matrix);
    lu_.factorize(copy_.matrix);
    return lu_.info() == Eigen::Success ? SolveStop::converged : SolveStop::breakdown;
  }
  void apply(ConstRows b, Rows x) override {
    gather(b, right_);
    solution_ = lu_.solve(right_);
    scatter(solution_, x);
  }
  Cost cost() const override { return {5e-8 * entries(), 1e-9 * entries()}; }
  double entries() const override { return double(lu_.nnzL() + lu_.nnzU()); }

 private:
  SparseCopy copy_;
  Eigen::SparseLU<SparseCopy::Matrix> lu_;
  Eigen::VectorXd right_, solution_;
};

}  // namespace

std::unique_ptr<LUFactor> LUFactor::make() { return std::make_unique<EigenLUFactor>(); }

}  // namespace stroma
