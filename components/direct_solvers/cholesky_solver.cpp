// SPDX-License-Identifier: LGPL-2.1-or-later
// CholeskySolver: a direct solver, A = L L^T of the dense matrix, symmetric and positive definite; for small systems.
//
// The numbers are factored again only when the matrix may have changed. The residual of each solve is measured, and the
// solve refined where it is above 1e-10 |b|.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CholeskySolver/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include <Eigen/Cholesky>

#include "components/direct_solvers/dense_factor.h"
#include "components/direct_solvers/factor_solver.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class DenseCholesky final : public DenseFactor {
 public:
  SolveStop factor(Index&, StopToken) override {
    llt_.compute(dense_);
    return llt_.info() == Eigen::Success ? SolveStop::converged : SolveStop::not_definite;
  }
  void apply(ConstRows b, Rows x) override {
    gather(b, solution_);
    llt_.solveInPlace(solution_);
    scatter(solution_, x);
  }

 private:
  Eigen::LLT<Eigen::MatrixXd> llt_;
  Eigen::VectorXd solution_;
};

using CholeskySolver = FactorSolver<DenseCholesky, true>;

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(cholesky_solver) {
  factory.add<stroma::CholeskySolver>("CholeskySolver", "direct solver: dense L L^T, small positive definite systems");
}
