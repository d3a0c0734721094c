// SPDX-License-Identifier: LGPL-2.1-or-later
// ConstraintSweeps: forces of Lagrangian constraints by sweeps over them, which end at a tolerance, as in SOFA.
//
//   g + (W + s) l = 0,   W_bb dl_b = -(g + (W + s) l)_b,   l_b += dl_b   for each block b in turn
//
// with the conditions g of the motion without forces and W of multipliers.h, s = regularizationTerm on the diagonal. A block is the
// three rows of a pair of points or of a fixed one, and else a row. A sweep is the last where sum |W_bb dl_b| < tolerance, times the
// number of rows with scaleTolerance; or with allVerified where no row moved by more than the tolerance; or the maxIterations-th.
// The run then ends there, as with any condition that does not hold. With keepsUnsettled it goes on and tells of it. With
// `sor`, below 2, forces go that share of a sweep. Those of points begin where they ended in the step before, and others at zero,
// as those of pairs of frames. How frames are turned to each other has a tolerance of its own: its movement counts as much as tolerance /
// turnTolerance of others'.
// resolutionMethod = UnbuiltGaussSeidel: all begin at zero. NonsmoothNonlinearConjugateGradient: a sweep is a step of steepest
// descent, and directions are those of Fletcher and Reeves, begun again where changes grow.
//
// A contact is a block of its push l_n and its friction l_t:
//
//   l_n = max(0, l_n - (g + W l)_n / W_nn),   l_t -= 2 (g + W l)_t / (W_tt + W_ss), cut to mu l_n;   no friction where l_n = 0
//
// It begins at zero, or with keepsContactForces where it ended in the step before. Blocks are visited node by node, a node before its
// children, contacts last (those of CollisionResponse with sofaLists). resolutionMethod = NonlinearComplementarity is SOFA's
// LCPConstraintSolver: the error of a contact is |W_bb dl_b|, and the tolerance is times the contacts and one; without friction it is not
// scaled.
//
// Without this component conditions hold to round-off, which is right. With the usual tolerance a chain of tied bodies is off by some
// thousandths of its movement. It has an effect where an integrator has oneRound and all conditions are equal ones, as those of
// BilateralLagrangianConstraint and FixedLagrangianConstraint, and of UniformLagrangianConstraint on numbers, or contacts of a
// CollisionResponse with sofaLists. A step with other conditions makes no sweeps: all hold to round-off, and the integrator warns. A scene
// has one.
//
// Source: SOFA's GenericConstraintSolver. Silcowitz, Niebe, Erleben: A nonsmooth nonlinear conjugate gradient method for interactive
// contact force problems (2010).
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver newtonIterations="1" oneRound="true"/>
//   <SparseLDLSolver/>
//   <ConstraintSweeps tolerance="1e-6"/>
//   <MechanicalObject position="0 0 0  1 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="4"/>
//   <SpringForceField springsIndices1="0 2" springsIndices2="1 3" lengths="1 1" stiffness="200"/>
//   <FixedLagrangianConstraint indices="0"/>
//   <BilateralLagrangianConstraint first_point="1" second_point="2"/>
// </Node>
#include "components/integrators/constraint_sweeps.h"

#include "framework/scene/factory.h"

STROMA_COMPONENT(constraint_sweeps) {
  factory.add<stroma::ConstraintSweeps>("ConstraintSweeps", "forces of constraint that are found up to a tolerance, as in SOFA");
}
