// SPDX-License-Identifier: LGPL-2.1-or-later
// MultigridPreconditioner: B ~ A^-1 for PCGLinearSolver, one V-cycle of a smoothed aggregation (Vanek, Mandel, Brezina
// 1996). Iterations hardly grow with the number of nodes, also for slender bodies and for stiff parts in soft ones.
//
// Nodes that hold each other strongly, |A_ij|^2 > 0.08^2 |A_ii| |A_jj| (halved from level to level), make a group, first
// around nodes with no fewer such neighbours than the mean. A group is a node of the next level with the six motions of a
// rigid body, taken from where the nodes are. With Q an orthonormal basis of those motions in each group and D the diagonal
// blocks of A:
//
//   P = (I - w D^-1 A) Q,   w = 4 / (3 lambda),   A_coarse = P^T A P,   lambda the largest eigenvalue of D^-1 A
//
// Each level is smoothed by two steps of Chebyshev's polynomial in D^-1 A over [lambda / 12, lambda] before and after
// the correction from the next one. The last is factored: the first level whose factor takes less than a fifth of the time of
// the hierarchy, of 100 nodes or a few hundred. The next steps would be the worst of a slender body with stiff parts, because
// groups of nodes that move like rigid bodies hardly bend (60 iterations instead of 34 for bone in a limb 20:1). Galerkin's
// product and that factor are made in double precision and the levels are kept in single, 110 bytes for each block of A of a
// mesh of tetrahedra altogether. Products of the conjugate gradients outside remain those of the force fields. Threads share
// the rows of a level: no bit depends on their number.
//
// Where products of the force fields cost less than reading the blocks (corotational hexahedra), the first level has three
// steps by products of the matrix as it is now, with its present diagonal blocks; the other levels stay those of the hierarchy.
//
// Near incompressibility a node that moves alone changes volumes; motions that do not need several nodes, and the diagonal
// blocks hardly see them. Where the least eigenvalue of D^-1 A in the neighbourhood of a node is usually below 0.03 (0.3 to
// 0.5 in an ordinary body; with mean dilatation 0.009 at 0.499, 0.0009 at 0.4999), patches take the place of D in the
// smoother, as in Schoeberl 1999:
//
//   M^-1 = sum_p R_p^T (R_p A R_p^T)^-1 R_p,   R_p a node with its neighbours, no two of these nodes neighbours
//
// An iteration then takes 1.4 times as long in cache and up to three times outside, with twice the memory; a quarter to a
// seventh of the iterations are left. They still grow with K/mu and with the body: motions of whole groups, too, change
// volumes, so that the coarser levels are too stiff.
//
// The hierarchy is kept while the matrix changes, over Newton iterations and steps, until the iterations that this has
// cost exceed what a new one costs. It is turned with the body as WarpPreconditioner turns factors, B = R B_0 R^T, where
// rows are nodes that nothing ties to others and no direction of a node is held. A held direction is in no motion. A
// matrix that shows itself to be indefinite, by a diagonal block or the inverse of the last level, is refused; the conjugate
// gradients see the rest.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <StaticSolver/>
//   <PCGLinearSolver preconditioner="@precond"/>
//   <MultigridPreconditioner name="precond"/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/>
//   <UniformMass totalMass="1"/>
//   <TetrahedronFEMForceField youngModulus="5000" poissonRatio="0.3" method="small"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include "components/iterative_solvers/multigrid.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class MultigridPreconditioner final : public Preconditioner {
 public:
  void declare(DataTable&) override {}
  std::unique_ptr<ApproximateInverse> makeInverse() const override { return std::make_unique<Multigrid>(); }
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(multigrid_preconditioner) {
  factory.add<stroma::MultigridPreconditioner>("MultigridPreconditioner",
                                               "smoothed aggregation: few iterations for a body of any size");
}
