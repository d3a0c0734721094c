// SPDX-License-Identifier: LGPL-2.1-or-later
// Quadratic tetrahedra, ten nodes each, with four integration points: small strains with a rotation taken out at each
// point.
//
// With F the deformation gradient at a point, R its rotation, w the point's volume, D Hooke's law and B the strain of
// the nodes' displacements there,
//   eps = sym(R^T F) - I,   f = -sum w B^T D eps,   df = -sum w B^T D B dx        (B in the axes that R has turned)
// Quadratic displacements bend: a slender cantilever is within 0.1 % with one cell over its height, linear tetrahedra
// within 0.4 % with twenty-four. The displacement converges with the third power of the cell size. Sources: R. D.
// Cook, D. S. Malkus, M. E. Plesha, R. J. Witt, Concepts and Applications of Finite Element Analysis, chapter 7 (the
// element); P. C. Hammer, A. H. Stroud 1956 (the points); M. Nesme et al. 2005 (the rotation taken out, here at each
// point instead of each element, so that an element may bend by any angle).
//
// Nodes are in the order of VTK: the corners, then those of the edges 01, 12, 20, 03, 13, 23. Edges may be curved. They
// come from a Gmsh or VTK file of second order, from `stroma mesh --order 2`, or from Linear2QuadraticTopologicalMapping, which
// raises the order of a linear mesh in the scene.
//
// method = small: R = I; svd (default): the nearest rotation, for inverted points with the smallest inversion; polar:
// the same with the least stretched axis flipped where a point is inverted; large: QR of F in the axes of the scene;
// green: no rotation, St. Venant-Kirchhoff at each point. small, svd and green have a potential, so that forces and
// torques balance and the exact tangent is symmetric. tangent = exact adds the derivatives of R.
//
// dilatation = mean takes the volume change as one number per element, its mean (Nagtegaal, Parks and Rice 1974):
//   theta = 1/V sum w tr(eps),   sigma = K theta I + 2 mu dev(eps)
// Near nu = 1/2 four volume changes per element are too many: a mean does not lock, and is one order less accurate.
// Far from it a mean is too soft, because it leaves the volume change of bending without energy. auto, the default, is
// local below nu = 0.45 and mean from there on. Then take tangent = exact with it: the pressure acts on how the
// gradients turn, which a warped tangent leaves out.
//
// Masses: MeshMatrixMass is the consistent one; DiagonalMass gives each node the share of the cell's mass that its
// diagonal entry has (Hinton, Rock and Zienkiewicz 1976), because row sums are negative at the corners.
//
// Cell fields for exporters: vonMises [Pa], J (the smallest of the four points), strain (6 per cell: xx yy zz xy yz zx,
// the mean of sym(R^T F) - I, of E for green, in the axes of the rest shape), stress (Cauchy's [Pa], six numbers too, in the
// axes of the world), principalStress and principalStrain (three of a cell, the largest first).
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="400" tolerance="1e-8"/>
//   <RegularGridTopology name="grid" n="2 2 5" min="0 0 0" max="0.02 0.02 0.1"/>
//   <Node name="beam">
//     <Hexa2TetraTopologicalMapping name="tets" input="@../grid" swapping="true"/>
//     <Linear2QuadraticTopologicalMapping name="mesh" input="@tets"/>
//     <MechanicalObject src="@mesh"/>
//     <DiagonalMass massDensity="1000" topology="@mesh"/>
//     <QuadraticTetrahedronFEMForceField youngModulus="1e5" poissonRatio="0.4" topology="@mesh"/>
//     <BoxROI name="held" box="-1 -1 -0.001 1 1 0.001"/>
//     <FixedProjectiveConstraint indices="@held.indices"/>
//   </Node>
// </Node>
#include "components/elasticity/elastic_force_field.h"
#include "components/elasticity/quadratic_tetrahedron_models.h"
#include "framework/scene/factory.h"

using namespace stroma;

std::unique_ptr<ElasticElements> stroma::makeQuadraticTetrahedra() {
  return std::make_unique<PointCells<quadratic_tetrahedron::Shape>>();
}

STROMA_COMPONENT(quadratic_tetrahedron_fem_force_field) {
  factory.add<ElasticForceField>(
      "QuadraticTetrahedronFEMForceField",
      "tetrahedra of ten nodes: corotational at each point (svd, polar, large), small strains, Green-Lagrange",
      [](ElasticForceField& f) {
        f.kinds = {{"QuadraticTetrahedron", "quadratic tetrahedra", makeQuadraticTetrahedra}};
        f.method_word = ElasticForceField::Word::svd;
      });
}
