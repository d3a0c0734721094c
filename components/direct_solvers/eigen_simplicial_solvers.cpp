// SPDX-License-Identifier: LGPL-2.1-or-later
// EigenSimplicialLLT and EigenSimplicialLDLT (SparseCholeskySolver is the former by another of SOFA's names): direct
// solvers, A x = b by the factorisation in the name, as Eigen computes it.
//
//   EigenSimplicialLLT    P A P^T = L L^T, column by column; A symmetric and positive definite, else it says so
//   EigenSimplicialLDLT   P A P^T = L D L^T without pivoting: also for many indefinite symmetric matrices, but a small
//                         pivot can spoil all digits; the residual shows it, and the report then says breakdown
//
// The pattern is ordered (AMD) and analysed once; numbers are factored again only when the matrix may have changed. The
// residual of each solve is measured, and one step of iterative refinement made when it is above 1e-10 |b|.
// SparseLDLSolver is many times as fast on meshes of more than a few hundred nodes.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <EigenSimplicialLDLT/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include <Eigen/SparseCholesky>

#include "components/direct_solvers/eigen_factor.h"
#include "components/direct_solvers/factor_solver.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

using LLT = FactorSolver<EigenFactor<Eigen::SimplicialLLT<SparseCopy::Matrix>, SolveStop::not_definite>, true>;
using LDLT = FactorSolver<EigenFactor<Eigen::SimplicialLDLT<SparseCopy::Matrix>, SolveStop::breakdown>, true>;

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(eigen_simplicial_solvers) {
  using namespace stroma;
  factory.add<LLT>("EigenSimplicialLLT", "direct solver: sparse L L^T, positive definite matrices");
  factory.add<LLT>("SparseCholeskySolver", "EigenSimplicialLLT by another of SOFA's names");
  factory.add<LDLT>("EigenSimplicialLDLT", "direct solver: sparse L D L^T, symmetric matrices");
}
