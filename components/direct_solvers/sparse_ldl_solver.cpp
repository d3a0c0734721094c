// SPDX-License-Identifier: LGPL-2.1-or-later
// SparseLDLSolver: a direct solver, A x = b by a factorisation of the assembled matrix.
//
// A symmetric positive definite matrix is factored as P A P^T = L L^T by CHOLMOD's supernodal method (Chen, Davis,
// Hager, Rajamanickam 2008) on 3x3 blocks. The pattern is ordered and analysed once (nested dissection by METIS and
// minimum degree by AMD; the one with fewer flops is kept); the numbers are factored again only when the matrix may
// have changed, so a scene of constant stiffness, mass and time step is factored once. The residual of each solve is
// measured, and the solve refined where it is above 1e-10 |b|. What refinement leaves above 1e-5 |b| is told.
//
// SOFA's solver of this name computes L D L^T without pivoting and gives some x for an indefinite matrix too. Here a
// matrix that is not positive definite is reported with the node at which it shows, and the integrator decides what to
// do. When some force field has an unsymmetric stiffness, as tangent="exact" of hexahedra, its symmetric part is factored
// and GMRES (Saad, Schultz 1986) does the rest in some ten products: the part that is not symmetric is small where
// strains are. Where the symmetric part is not positive definite, or GMRES gets no further, the matrix is factored as
// L U (Eigen, COLAMD ordering), which takes many times as long.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include "components/direct_solvers/cholesky_factor.h"
#include "components/direct_solvers/symmetric_part_factor.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class SparseLDLSolver final : public DirectSolver {
 public:
  void declare(DataTable& table) override;
  bool needsSymmetric() const override { return false; }

 protected:
  std::unique_ptr<Factorisation> makeFactorisation(bool symmetric) const override {
    if (symmetric) return CholeskyFactor::make();
    return std::make_unique<SymmetricPartFactor>();
  }
  void noteFactored(const Factorisation& factors) override;
  SolveStop uselessFactor() const override { return SolveStop::not_definite; }

 private:
  bool precompute_ = true, parallel_inverse_ = false;
  std::string ordering_;
  double flops_ = 0, entries_ = 0;
};

void SparseLDLSolver::declare(DataTable& table) {
  DirectSolver::declare(table);
  table.add("precomputeSymbolicDecomposition", precompute_)
      .help("SOFA's; without effect: the analysis is always made once for each pattern");
  table.add("parallelInverseProduct", parallel_inverse_).help("SOFA's; without effect");
  table.add("ordering", ordering_).help("METIS or AMD, or COLAMD of an L U factorisation; of the last one").output();
  table.add("factorFlops", flops_).help("operations of the last factorisation; 0 of L U").unit("-").output();
  table.add("factorEntries", entries_).help("numbers in the factors made last").unit("-").output();
}

void SparseLDLSolver::noteFactored(const Factorisation& factors) {
  if (const auto* cholesky = dynamic_cast<const CholeskyFactor*>(&factors)) {
    ordering_ = cholesky->ordering();
    flops_ = cholesky->flops(), entries_ = cholesky->entries();
  } else {
    const auto& unsymmetric = static_cast<const SymmetricPartFactor&>(factors);
    ordering_ = unsymmetric.ordering();
    flops_ = unsymmetric.flops(), entries_ = unsymmetric.entries();
  }
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(sparse_ldl_solver) {
  factory.add<stroma::SparseLDLSolver>("SparseLDLSolver",
                                       "direct solver: sparse Cholesky, factored only when values changed");
}
