// SPDX-License-Identifier: LGPL-2.1-or-later
// Hyperelastic tetrahedra of ten nodes: the laws, attributes and forms of TetrahedronHyperelasticityFEMForceField, whose
// page says what is computed, at each of four points
//   F = sum_i dx/dxi_i (x) grad xi_i,   f_a = -sum_p w_p P_p grad N_a
// The displacement converges with the third power of the cell size. Nodes are in the order of VTK, edges may be curved:
// see QuadraticTetrahedronFEMForceField, where meshes and masses are described.
//
// dilatation = mean gives the part k U(J) of the energy one volume change per cell, v/V of the volumes now and at rest,
// both by the four points, as for HexahedronHyperelasticityFEMForceField: near nu = 1/2 four are too many, and the
// cell locks. auto, the default, is mean where nu at small strains is 0.45 or more and the law has such a part.
// The forms are mjed and projectedTangent; there is no viscosity for these cells.
//
// Source: S. Marchesseau et al., MICCAI 2010 (the laws' derivatives); P. C. Hammer, A. H. Stroud 1956 (the points).
//
// Example:
// <Node name="root" dt="0.02" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="200" tolerance="1e-8"/>
//   <RegularGridTopology name="grid" n="2 2 5" min="0 0 0" max="0.02 0.02 0.1"/>
//   <Node name="beam">
//     <Hexa2TetraTopologicalMapping name="tets" input="@../grid" swapping="true"/>
//     <Linear2QuadraticTopologicalMapping name="mesh" input="@tets"/>
//     <MechanicalObject src="@mesh"/>
//     <DiagonalMass massDensity="1000" topology="@mesh"/>
//     <QuadraticTetrahedronHyperelasticityFEMForceField materialName="StableNeoHookean" youngModulus="2e4"
//                                                       poissonRatio="0.45" topology="@mesh"/>
//     <BoxROI name="held" box="-1 -1 -0.001 1 1 0.001"/>
//     <FixedProjectiveConstraint indices="@held.indices"/>
//   </Node>
// </Node>
#include "components/hyperelasticity/hyperelastic_force_field.h"
#include "components/hyperelasticity/point_kernels.h"
#include "components/hyperelasticity/point_law.h"
#include "framework/scene/factory.h"

using namespace stroma;
using namespace stroma::hyperelastic;

STROMA_COMPONENT(quadratic_tetrahedron_hyperelasticity_fem_force_field) {
  if (!pointKernels().quadratic_tetrahedra) pointKernels().quadratic_tetrahedra = pointLawOf<QuadraticPoints>;
  factory.add<HyperelasticForceField>(
      "QuadraticTetrahedronHyperelasticityFEMForceField",
      "hyperelastic tetrahedra of ten nodes: laws of large strains (StVenantKirchhoff, NeoHookean, ...) at four points",
      [](HyperelasticForceField& f) { f.kind = &cell_kinds::quadratic_tetrahedron; });
}
