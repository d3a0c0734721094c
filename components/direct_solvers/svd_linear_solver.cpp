// SPDX-License-Identifier: LGPL-2.1-or-later
// SVDLinearSolver: a direct solver by the singular values of the dense matrix, for small systems of any rank. Singular
// values below minSingularValue times the largest are left out, which gives the shortest least-squares solution of a
// singular system.
//
// The numbers are factored again only when the matrix may have changed. The residual of each solve is measured, and one
// step of iterative refinement made when it is above 1e-10 |b|.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <SVDLinearSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include <Eigen/SVD>

#include "components/direct_solvers/dense_factor.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class SingularValues final : public DenseFactor {
 public:
  explicit SingularValues(double smallest) : smallest_(smallest) {}
  SolveStop factor(const BlockMatrix& matrix, Index&) override {
    fill(matrix);
    svd_.setThreshold(smallest_);
    svd_.compute(dense_, Eigen::ComputeThinU | Eigen::ComputeThinV);
    return svd_.info() == Eigen::Success ? SolveStop::converged : SolveStop::breakdown;
  }
  void apply(ConstRows b, Rows x) override {
    gather(b, right_);
    solution_ = svd_.solve(right_);
    scatter(solution_, x);
  }
  double condition() const {
    const auto& values = svd_.singularValues();
    return values[0] / values[values.size() - 1];
  }

 private:
  double smallest_;
  Eigen::BDCSVD<Eigen::MatrixXd> svd_;
  Eigen::VectorXd right_, solution_;
};

class SVDLinearSolver final : public DirectSolver {
 public:
  bool needsSymmetric() const override { return false; }
  Index mostRows() const override { return SingularValues::most_rows; }
  void declare(DataTable& table) override {
    DirectSolver::declare(table);
    table.add("minSingularValue", smallest_)
        .help("singular values below this times the largest count as zero")
        .unit("-")
        .min(0)
        .max(1);
    table.add("conditionNumber", condition_)
        .help("the largest over the smallest singular value of the matrix that was factored last")
        .unit("-")
        .output();
    table.addVisualOnly("verbose");
  }

 private:
  std::unique_ptr<Factorisation> makeFactorisation(bool) const override {
    return std::make_unique<SingularValues>(smallest_);
  }
  void noteFactored(const Factorisation& factors) override {
    condition_ = static_cast<const SingularValues&>(factors).condition();
  }
  /// That is what the name promises: the residual may be as large as b.
  bool givesLeastSquares() const override { return true; }

  double smallest_ = 1e-12, condition_ = 0;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(svd_linear_solver) {
  factory.add<stroma::SVDLinearSolver>("SVDLinearSolver",
                                       "direct solver: dense singular values, small systems of any rank");
}
