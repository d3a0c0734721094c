// SPDX-License-Identifier: LGPL-2.1-or-later
// ConstraintSweeps: forces of Lagrangian constraints by sweeps over the constraints, up to a tolerance, as in SOFA.
//
//   g + (W + s) l = 0,   W_bb dl_b = -(g + (W + s) l)_b,   l_b += dl_b   for each block b in turn
//
// with the conditions g of the motion without forces and W of multipliers.h, s = regularizationTerm on the diagonal. A block
// is the three rows of a pair of points or of a fixed one, otherwise a single row. Sweeps end when sum |W_bb dl_b| <
// tolerance, times the number of rows with scaleTolerance; or with allVerified when no row changed by more than the tolerance;
// or after maxIterations. The latter ends the run, as with any violated condition. With keepsUnsettled it continues with a
// warning. `sor`, below 2, is the relaxation factor. Forces of points start from those of the previous step, and others, such
// as those of pairs of frames, from zero. Relative rotations of frames have a separate tolerance: they are weighted by
// tolerance / turnTolerance. resolutionMethod = UnbuiltGaussSeidel: all start from zero. NonsmoothNonlinearConjugateGradient:
// a sweep is a step of steepest descent, with the directions of Fletcher and Reeves, restarted when changes grow.
//
// A contact is a block of its normal force l_n and its friction l_t:
//
//   l_n = max(0, l_n - (g + W l)_n / W_nn),   l_t -= 2 (g + W l)_t / (W_tt + W_ss), cut to mu l_n;   no friction if l_n = 0
//
// It starts at zero, or with keepsContactForces from the previous step. Blocks are visited node by node, a node before its children,
// contacts last (those of CollisionResponse with sofaLists). resolutionMethod = NonlinearComplementarity is SOFA's LCPConstraintSolver:
// the error of a contact is |W_bb dl_b|, and the tolerance is multiplied by the number of contacts plus one; without friction it is
// not scaled.
//
// Without this component conditions hold to round-off, which is correct. With the usual tolerance the error of a chain of tied
// bodies is some thousandths of its movement. It is used if an integrator has oneRound and all conditions are equalities, such
// as those of BilateralLagrangianConstraint and FixedLagrangianConstraint, and of UniformLagrangianConstraint on numbers, or
// contacts of a CollisionResponse with sofaLists. A step with other conditions makes no sweeps: all hold to round-off, and the
// integrator prints a warning. A scene has at most one.
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
