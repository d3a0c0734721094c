// SPDX-License-Identifier: LGPL-2.1-or-later
// WarpPreconditioner: the factors of a former matrix A_0, turned with the body (Courtecuisse, Allard, Duriez, Cotin
// 2010), for PCGLinearSolver:
//
//   B = R A_0^-1 R^T,   R = diag(R_1, R_2, ...)
//
// R_i is how much the surroundings of node i have turned since A_0 was factored: the rotation nearest to
// sum_j (x_j - x_i)(X_j - X_i)^T over the nodes j that the matrix couples with i. No force field needs to know
// rotations for that, and X is where A_0 was factored, not the rest shape: for a corotational material A = R A_0 R^T is
// exact for a body that turns as a whole.
//
// The factors come from a direct solver of the same node (`linearSolver` chooses between several). They are renewed
// when a solve has cost more than the solves since the last factorisation on average, with that factorisation.
// `refresh` says where the costs come from: estimate (counts of operations and iterations: each run does the same),
// clock (the time that solves took: runs may differ within the tolerance of the solver), or never.
// PrecomputedWarpPreconditioner is the same with never.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <PCGLinearSolver iterations="100" tolerance="1e-9" preconditioner="@warp"/>
//   <WarpPreconditioner name="warp" linearSolver="@factors"/>
//   <SparseLDLSolver name="factors"/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include "components/iterative_solvers/warped_factor.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class WarpPreconditioner final : public Preconditioner, public FactorUser {
 public:
  void declare(DataTable& table) override {
    table.addLink("linearSolver", solver_).help("the direct solver that factors; without it, the one of the same node");
    table.addChoice("refresh", renewal_, {"estimate", "clock", "never"})
        .help("when to factor again: by estimated costs, by the clock, or never");
    table.addVisualOnly("useRotationFinder");
  }
  void init() override { source_ = &factorSource(*this, solver_); }
  std::unique_ptr<ApproximateInverse> makeInverse() const override {
    return std::make_unique<WarpedFactor>(*source_, renewal_);
  }
  Index mostRows() const override { return source_->mostRows(); }
  bool usesFactorOf(const Component& solver) const override {
    return solver_.path.empty() || solver_.target() == &solver;
  }
  WarpedFactor::Renewal renewal_ = WarpedFactor::Renewal::estimate;

 private:
  Link<DirectSolver> solver_{"direct solver"};
  DirectSolver* source_ = nullptr;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(warp_preconditioner) {
  using stroma::WarpPreconditioner;
  factory.add<WarpPreconditioner>("WarpPreconditioner", "former factors of a direct solver, turned with the body");
  factory.add<WarpPreconditioner>("PrecomputedWarpPreconditioner", "WarpPreconditioner that factors once",
                                  [](WarpPreconditioner& p) { p.renewal_ = stroma::WarpedFactor::Renewal::never; });
}
