// SPDX-License-Identifier: LGPL-2.1-or-later
// Names that specify a method, not an element: they use the kind of cell in their mesh, or the one that
// template="Vec3,Tetrahedron", Hexahedron, Prism or Pyramid names if it has several: then add one for each.
//
// CorotationalFEMForceField: TetrahedronFEMForceField or HexahedronFEMForceField, whose pages have the formulas.
// LinearSmallStrainFEMForceField: the same with method small, pure linear elasticity without rotations.
//
// Prisms (6 nodes: a triangle, then the opposite one) and pyramids (5 nodes: the base, then the top) have isoparametric
// functions that fit to their neighbours', so that meshes of all four kinds pass the patch test. With F the deformation gradient
// at a point, R its rotation, w its volume, D Hooke's law and B the strain of the nodes' displacements there,
//   eps = sym(R^T F) - I,   f = -sum w B^T D eps,   df = -sum w B^T D B dx        (B in the axes that R has turned)
// over six points of a prism and four of a pyramid. method = svd, with the nearest rotation at each point, has a potential:
// forces and torques balance, and the exact tangent is symmetric; so do small and green. polar: the same with the least
// stretched axis flipped where a point is inverted; large: QR of F in the axes of the scene. polarOf = nodes: one rotation a
// cell, the polar factor of the sum of (x - c)(X - C)^T over its nodes, as in SOFA. reducedIntegration: two points of a prism,
// as in SOFA, for small and for polarOf = nodes; a twist of its ends against each other then has no stiffness. dilatation =
// mean, tangent and the cell fields are those of HexahedronFEMForceField. Source of the pyramid's functions: G. Bedrosian,
// "Shape functions and integration formulas for three-dimensional finite element analysis", Int. J. Numer. Methods Eng. 35,
// 1992. A prism has constant strain across its triangle: bent in that plane it is as stiff as tetrahedra, and locks near nu =
// 1/2 with a mean too. Bent out of it, like a layer, it is as good as a hexahedron.
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
  using Field = ElasticForceField;
  static const std::vector<ElasticKind> all{{"Tetrahedron", "tetrahedra", makeTetrahedra},
                                            {"Prism", "prisms", makePrisms, makeReducedPrisms},
                                            {"Pyramid", "pyramids", makePyramids},
                                            {"Hexahedron", "hexahedra", makeHexahedra},
                                            {"QuadraticTetrahedron", "quadratic tetrahedra", makeQuadraticTetrahedra}};
  factory.add<Field>("CorotationalFEMForceField", "corotational elements of the kind that the mesh holds",
                     [](Field& f) { f.kinds = all; });
  factory.add<Field>("LinearSmallStrainFEMForceField", "linear elements of the kind that the mesh holds, no rotations",
                     [](Field& f) { f.kinds = all, f.method_word = Field::Word::none, f.only_small = true; });
}
