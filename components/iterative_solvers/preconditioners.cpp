// SPDX-License-Identifier: LGPL-2.1-or-later
// JacobiPreconditioner, BlockJacobiPreconditioner, SSORPreconditioner, IncompleteCholeskyPreconditioner: B ~ A^-1 for
// PCGLinearSolver, which names one by a link (or by a word, without a component).
//
//   Jacobi              B = diag(A)^-1
//   BlockJacobi         B = D^-1, D the 3x3 diagonal blocks of the nodes
//   SSOR                B^-1 = 1 / (omega (2 - omega)) (D + omega L) D^-1 (D + omega L^T),   A = L + D + L^T in blocks;
//                       scalar="true": in numbers, with L and L^T exchanged
//   IncompleteCholesky  B^-1 = L L^T with the pattern of the lower triangle of A in blocks (Meijerink and van der Vorst
//                       1977); where a pivot is not positive definite, A + shift D is factored instead, shift growing
//                       from 0.001 by factors of 4 (Manteuffel 1980): the attribute `shift` says with which it worked
//
// The last two read the assembled matrix and run on one thread. All are made again only when the matrix may have
// changed. A matrix whose diagonal blocks are not positive definite is refused, with the node.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <PCGLinearSolver iterations="100" tolerance="1e-9" preconditioner="@precond"/>
//   <SSORPreconditioner name="precond" omega="1.2"/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include "components/iterative_solvers/incomplete_cholesky.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

template <class Inverse>
class SweepPreconditioner final : public Preconditioner {
 public:
  void declare(DataTable&) override {}
  std::unique_ptr<ApproximateInverse> makeInverse() const override { return std::make_unique<Inverse>(); }
};

class SSORPreconditioner final : public Preconditioner {
 public:
  void declare(DataTable& table) override {
    table.add("omega", omega_).help("relaxation factor").unit("-").min(0, false).max(2, false);
    table.add("scalar", scalar_).help("sweeps over single numbers, the upper triangle first, as SOFA's are");
  }
  std::unique_ptr<ApproximateInverse> makeInverse() const override {
    if (scalar_) return std::make_unique<ScalarSsor>(omega_);
    return std::make_unique<Ssor>(omega_);
  }

 private:
  double omega_ = 1;
  bool scalar_ = false;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(preconditioners) {
  using namespace stroma;
  factory.add<SweepPreconditioner<Jacobi>>("JacobiPreconditioner", "divides by the diagonal");
  factory.add<SweepPreconditioner<BlockJacobiInverse>>("BlockJacobiPreconditioner",
                                                       "divides by the blocks of the nodes");
  factory.add<SSORPreconditioner>("SSORPreconditioner", "a forward and a backward sweep of over-relaxation");
  factory.add<SweepPreconditioner<IncompleteCholesky>>("IncompleteCholeskyPreconditioner",
                                                       "incomplete Cholesky factors without fill, by blocks");
}
