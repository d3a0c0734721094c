// SPDX-License-Identifier: LGPL-2.1-or-later
// UncoupledConstraintCorrection: forces of Lagrangian constraints move the nodes of a body as if they were not coupled.
//
//   dv_i = c_i p_i,   p_i the impulse on node i
//
// with c_i the compliance of the node [1/kg], its entry in `compliance` or defaultCompliance. A frame without a compliance has
// that of its mass and inertia at the start of the step, including those mapped to it. With one of 7 numbers it has c for the
// centre, and xx xy xz yy yz zz of the inverse inertia.
// With only defaultCompliance that is c for the centre, and 1/(kg m^2) for rotations about all axes, as in SOFA. The matrix of
// the step, with the stiffness of the body, is left out: the constraint acts on the other nodes only in the next step. Without
// this component the matrix is used, which is correct. It only has an effect if an integrator makes one linear solve per step.
//
// Source: SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver newtonIterations="1"/>
//   <SparseLDLSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="3"/>
//   <SpringForceField springsIndices1="0 1" springsIndices2="1 2" lengths="1" stiffness="200"/>
//   <UncoupledConstraintCorrection defaultCompliance="0.001"/>
//   <FixedLagrangianConstraint indices="0"/>
// </Node>
#include "components/integrators/uncoupled_constraint_correction.h"

#include "framework/scene/factory.h"

STROMA_COMPONENT(uncoupled_constraint_correction) {
  factory.add<stroma::UncoupledConstraintCorrection>("UncoupledConstraintCorrection",
                                                     "forces of constraint that move nodes one by one, as in SOFA");
}
