// SPDX-License-Identifier: LGPL-2.1-or-later
// Linear tetrahedra with a rotation taken out of each element: small strains, large displacements.
//
// With R the rotation of an element, B its strain-displacement matrix and D Hooke's law,
//   f = R B^T D B (R^T x - X) V_0,      df = R B^T D B R^T dx V_0      (f is the restoring force with a minus sign)
// Source: M. Nesme, M. Marchal, E. Promayon, M. Chabanas, Y. Payan, F. Faure, "Physically realistic interactive
// simulation for biological soft tissues", Recent Research Developments in Biomechanics 2, 2005 (sections 2 to 3, 5.1,
// appendix A).
//
// method = small: R = I, pure linear elasticity; large: QR frame (first edge, plane of the first two), depends on the
// order of the vertices, so that elements of one strain differ by its square: it fails the patch test by that; polar:
// nearest orthogonal matrix, the least stretched axis flipped in an inverted element; svd: the smallest inversion
// (Irving et al. 2004); nodal: one rotation per node (Mueller et al. 2002), which leaves ghost forces and is here for
// comparison only. With polarOf = nodes R is the polar factor of the sum of (x - c)(X - C)^T over the nodes. Other
// components' words qr, none, polar2, triangle, stable_polar and identity are taken as large, small, polar, large, svd
// and small.
//
// method = green is the nonlinear geometric reference without rotations: St. Venant-Kirchhoff,
//   E = (F^T F - I)/2,   S = lambda tr(E) I + 2 mu E,   f_i = -V_0 F S G_i,   W = V_0 (lambda/2 tr(E)^2 + mu E : E)
// It has a potential and an exact, symmetric tangent. It softens under strong compression: that is the law.
//
// updateStiffnessMatrix rebuilds B from the current shape: forces then exert no torque on a body (Euler's law), which a
// constant B ensures only where stress and stretch share their axes (svd, and polar until an element inverts). Under large
// a constant B turns a free body, with torques of about the square of the strain.
// updateVolume also updates the factor 1/6V of B and the volume. Both have a meaning for large, polar and svd. tangent
// = exact adds the derivatives of R and B: Newton's method converges quadratically. It is symmetric where the force has
// a potential: small, and svd without updates. polar has one until an element inverts; large and the updated variants
// have none. An unsymmetric tangent needs SparseLDLSolver.
//
// dilatation = auto, the default, is mean where nu is above 0.45, and local below or where there is no mean (green, nodal,
// more than 100 bulk moduli). dilatation = mean takes the volume change as one number per node, the mean over the
// tetrahedra around it (Bonet and Burton 1998):
//   V_a = sum V_e/4,   theta_a = 1/V_a sum V_e/4 tr(eps_e),   p_e = 1/4 sum_a K theta_a,   sigma_e = p_e I + 2 mu
//   dev(eps_e)
// Near nu = 1/2 the mesh does not lock, and a compressed body does not buckle element by element under the pressures of
// locking. For small, large, polar and svd. A product passes twice over the elements; a matrix couples the nodes of all
// elements around each node. With updateVolume an element counts with (V V_0)^1/2. Near nu = 1/2 take tangent = exact
// with it: the pressures act on how the gradients turn, which a warped tangent leaves out, and Newton's method stalls.
//
// Cell fields for exporters: vonMises [Pa], J, strain (6 per cell: xx yy zz xy yz zx, sym(R^T F) - I for every variant,
// E for green, in the axes of the rest shape), stress (Cauchy's [Pa], six numbers too, in the axes of the world; its pressure
// is p_e where dilatation is mean), principalStress and principalStrain (three of a cell, the largest first).
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <RegularGridTopology name="grid" n="3 3 9" min="0 0 0" max="0.02 0.02 0.1"/>
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-8"/>
//   <Node name="beam">
//     <TetrahedronSetTopologyContainer name="tets"/>
//     <Hexa2TetraTopologicalMapping input="@../grid" output="@tets" swapping="true"/>
//     <MechanicalObject/>
//     <DiagonalMass massDensity="1000"/>
//     <TetrahedronFEMForceField method="polar" youngModulus="1e5" poissonRatio="0.4"/>
//     <BoxROI name="held" box="-1 -1 -0.001 1 1 0.001"/>
//     <FixedProjectiveConstraint indices="@held.indices"/>
//   </Node>
// </Node>
#include "components/elasticity/elastic_force_field.h"
#include "framework/scene/factory.h"

using namespace stroma;

STROMA_COMPONENT(tetrahedron_fem_force_field) {
  using Field = ElasticForceField;
  const std::string help = "linear tetrahedra: corotational (large, polar, svd, nodal), small strains, Green-Lagrange";
  const auto here = [](Field& f) { f.kinds = {{"Tetrahedron", "tetrahedra", makeTetrahedra}}; };
  factory.add<Field>("TetrahedronFEMForceField", help, here);
  factory.add<Field>("TetrahedralCorotationalFEMForceField", help, here);
  factory.add<Field>("FastTetrahedralCorotationalForceField", help,
                     [here](Field& f) { here(f), f.method_word = Field::Word::qr; });
}
