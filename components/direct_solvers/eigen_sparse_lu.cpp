// SPDX-License-Identifier: LGPL-2.1-or-later
// EigenSparseLU (SparseLUSolver by another of SOFA's names): a direct solver, P A Q = L U with partial pivoting as Eigen
// computes it: any regular matrix, symmetric or not.
//
// The pattern is ordered (COLAMD) and analysed once; numbers are factored again only when the matrix may have changed. The
// residual of each solve is measured, and one step of iterative refinement made when it is above 1e-10 |b|.
// SparseLDLSolver is many times as fast on meshes of more than a few hundred nodes.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <EigenSparseLU/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include "components/direct_solvers/interruptible_factor.h"
#include "components/direct_solvers/lu_factor.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class EigenSparseLU final : public DirectSolver {
 public:
  bool needsSymmetric() const override { return false; }

 private:
  std::unique_ptr<Factorisation> makeFactorisation(bool) const override {
    return std::make_unique<InterruptibleFactor<LUFactor>>(LUFactor::make);
  }
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(eigen_sparse_lu) {
  using stroma::EigenSparseLU;
  factory.add<EigenSparseLU>("EigenSparseLU", "direct solver: sparse L U with pivoting, any regular matrix");
  factory.add<EigenSparseLU>("SparseLUSolver", "EigenSparseLU by another of SOFA's names");
}
