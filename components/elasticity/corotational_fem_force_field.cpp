// SPDX-License-Identifier: LGPL-2.1-or-later
// The names that stand for a method, not for an element: they take the kind of cell that their mesh holds, or the one
// that template="Vec3,Tetrahedron" or template="Vec3,Hexahedron" names where it holds several.
//
// CorotationalFEMForceField: TetrahedronFEMForceField or HexahedronFEMForceField, whose pages say what is computed.
// LinearSmallStrainFEMForceField: the same with method small, pure linear elasticity without rotations.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-8"/>
//   <RegularGridTopology name="grid" n="3 3 9" min="0 0 0" max="0.02 0.02 0.1"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="0.04"/>
//   <CorotationalFEMForceField template="Vec3,Hexahedron" youngModulus="1e5" poissonRatio="0.4"/>
//   <BoxROI name="held" box="-1 -1 -0.001 1 1 0.001"/>
//   <FixedProjectiveConstraint indices="@held.indices"/>
// </Node>
#include "components/elasticity/elastic_force_field.h"
#include "framework/scene/factory.h"

using namespace stroma;

STROMA_COMPONENT(corotational_fem_force_field) {
  offerElasticKind({"Tetrahedron", "tetrahedra", makeTetrahedra});
  using Field = ElasticForceField;
  factory.add<Field>("CorotationalFEMForceField", "corotational elements of the kind that the mesh holds");
  factory.add<Field>("LinearSmallStrainFEMForceField", "linear elements of the kind that the mesh holds, no rotations",
                     [](Field& f) { f.method_word = Field::Word::none, f.only_small = true; });
}
