// SPDX-License-Identifier: LGPL-2.1-or-later
// Hyperelastic hexahedra with 2x2x2 Gauss points: the laws, attributes and forms of
// TetrahedronHyperelasticityFEMForceField, whose page says what is computed, at each of eight points
//   F = sum_i dx/dxi_i (x) grad xi_i,   f_a = -sum_p w_p P_p grad N_a
// Trilinear cells lock when nearly incompressible. dilatation = auto, the default, is mean where nu at small strains is 0.4 or
// more and the law supports it; a warning is printed if it does not and nu is above 0.45. dilatation = mean does not lock: the
// part k U(J) of the energy (k0 or lambda, see the table of laws) takes one volume change per cell, v/V of its volumes now and
// at rest,
//   E = sum_p w_p W_0(F_p) + k V U(v/V),   W_0 = W with k = 0
// (Nagtegaal, Parks and Rice 1974; Simo, Taylor and Pister 1985). Shear and fibres are evaluated at the points. For a law with
// J^-2/3 I1 that is Hooke's law with a mean dilatation at small strains; for NeoHookean, StableNeoHookean and
// TransverselyIsotropic, whose mu also resists a change of volume, lambda is on the mean and 2 mu eps at the points. A
// homogeneous strain has the energy of the law itself. Laws that are infinite at J = 0 still are, at each point. The energy of
// StVenantKirchhoff has no J: it and tetrahedra reject the attribute. So does viscosity, except for viscousPart = deviatoric:
// the points relax, and the cell's volume is elastic.
//
// Example:
// <Node name="root" dt="0.02" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-8"/>
//   <RegularGridTopology name="grid" n="3 3 9" min="0 0 0" max="0.02 0.02 0.1"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="0.04"/>
//   <HexahedronHyperelasticityFEMForceField materialName="StableNeoHookean" youngModulus="2e4" poissonRatio="0.45"/>
//   <BoxROI name="held" box="-1 -1 -0.001 1 1 0.001"/>
//   <FixedProjectiveConstraint indices="@held.indices"/>
// </Node>
#include "components/hyperelasticity/hyperelastic_force_field.h"
#include "components/hyperelasticity/point_kernels.h"
#include "components/hyperelasticity/point_law.h"
#include "framework/scene/factory.h"

using namespace stroma;
using namespace stroma::hyperelastic;

STROMA_COMPONENT(hexahedron_hyperelasticity_fem_force_field) {
  if (!pointKernels().hexahedra) pointKernels().hexahedra = pointLawOf<HexahedronPoints>;
  factory.add<HyperelasticForceField>(
      "HexahedronHyperelasticityFEMForceField",
      "hyperelastic hexahedra: laws of large strains (StVenantKirchhoff, NeoHookean, ...) at 2x2x2 points",
      [](HyperelasticForceField& f) { f.kind = &cell_kinds::hexahedron; });
}
