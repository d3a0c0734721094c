// SPDX-License-Identifier: LGPL-2.1-or-later
// EigenSparseQR: a direct solver, A Q = Q_h R by Householder reflections as Eigen computes it: a rank below full is found
// and reported; slow and large.
//
// The pattern is ordered (COLAMD) and analysed once; numbers are factored again only when the matrix may have changed. The
// residual of each solve is measured, and one step of iterative refinement made when it is above 1e-10 |b|.
// SparseLDLSolver is many times as fast on meshes of more than a few hundred nodes.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <EigenSparseQR/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include <Eigen/SparseQR>

#include "components/direct_solvers/eigen_factor.h"
#include "components/direct_solvers/factor_solver.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

using QR = Eigen::SparseQR<SparseCopy::Matrix, Eigen::COLAMDOrdering<int>>;

class QRFactor final : public EigenFactor<QR, SolveStop::breakdown> {
 public:
  SolveStop factor(Index& row, StopToken stop) override {
    const SolveStop end = EigenFactor::factor(row, stop);
    return end == SolveStop::converged && solver_.rank() < copy_.matrix.cols() ? SolveStop::breakdown : end;
  }
};

using EigenSparseQR = FactorSolver<QRFactor, false>;

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(eigen_sparse_qr) {
  factory.add<stroma::EigenSparseQR>("EigenSparseQR", "direct solver: sparse Q R, finds a rank below full");
}
