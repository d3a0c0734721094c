// SPDX-License-Identifier: LGPL-2.1-or-later
// Hyperelastic tetrahedra: a large-strain law with exact forces and tangents, without removing rotations.
//
// A law is an energy density W(J, I1, I2, ...) of J = det F and invariants of C = F^T F, a sum of terms f(J) g(I) and
// of exponentials of such sums. The forces are its derivatives by the nodal positions,
//   f_i = -V_0 P G_i,   P = dW/dJ cof F + F S,   S = 2 sum_a dW/dI_a dI_a/dC
// with G_i the gradients of the shape functions: no inverse of C, no fourth-order tensor. Source: S. Marchesseau, T. Heimann,
// S. Chatelin, R. Willinger, H. Delingette, "Multiplicative Jacobian energy decomposition method for fast porous
// visco-hyperelastic soft tissue model", MICCAI 2010, section 2. discretization = standard computes the same forces and
// tangents by the textbook formulas, for comparison (the default of StandardTetrahedralFEMForceField).
//
// materialName and the order of ParameterSet; L = ln J, I1' = J^-2/3 I1, I2' = J^-4/3 I2, E = (C - Id)/2:
//   StVenantKirchhoff                 mu lambda
//                          lambda/2 tr(E)^2 + mu tr(E^2)
//   NeoHookean                        mu lambda
//                          mu/2 (I1 - 3) - mu L + lambda/2 L^2
//   StableNeoHookean                  mu lambda
//                          mu/2 (I1 - 3) + (lambda + mu)/2 ((J - a)^2 - (1 - a)^2), a = 1 + mu/(lambda + mu)
//   MooneyRivlin                      c1 c2 k0
//                          c1 (I1' - 3) + c2 (I2' - 3) + k0/2 L^2
//   VerondaWestman                    c1 c2 k0
//                          c1 (exp(c2 (I1' - 3)) - 1) - c1 c2/2 (I2' - 3) + k0/2 L^2
//   ArrudaBoyce                       mu k0
//                          mu sum C_n (I1'^n - 3^n) + k0/2 L^2, n = 1..5, eight-chain series of N = 8
//   Ogden                             mu1 alpha1 k0, or mu1 alpha1 mu2 alpha2 k0, or any number of such pairs and k0
//                          sum mu_k/alpha_k^2 (sum_i (J^-1/3 lambda_i)^alpha_k - 3) + k0/2 L^2; by name up to mu6
//   Costa                             a k0 bff bfs bss bfn bsn bnn
//                          a/2 (exp(J^-4/3 Q) - 1) + k0 (J L - J + 1), Q = sum b_ij E_ij^2
//   TransverselyIsotropic             mu lambda k1 k2
//                          NeoHookean + k1/(2 k2) (exp(k2 max(0, J^-2/3 I4 - 1)^2) - 1), I4 = a C a
//   TransverselyIsotropicMooneyRivlin c1 c2 c3 c4 c5 lam_max k0
//                          MooneyRivlin + F(l), l = J^-1/3 sqrt(I4), l F'(l) = c3 (exp(c4 (l - 1)) - 1) for
//                          1 < l < lam_max, c5 l + c6 without a jump above, 0 below: fibres that straighten
//   Yeoh                              c1 k0, or c1 c2 k0, or up to c1 c2 c3 c4 c5 c6 k0
//                          sum c_k (I1' - 3)^k + k0/2 L^2
//   Hencky                            mu lambda
//                          mu tr(H^2) + lambda/2 L^2, H = (ln C)/2
//   OgdenUnconstrained                c1 m1 cp, or c1 m1 c2 m2 cp, or any number of such pairs and cp
//                          sum c_k/m_k^2 (sum_i lambda_i^m_k - 3 - m_k L) + cp/2 (J - 1)^2; by name up to c6
//   FungOrthotropic                   E1 E2 E3 G12 G23 G31 v12 v23 v31 c k0
//                          c/2 (exp(Q) - 1) + k0/2 L^2, c Q = E' A E' of E' = (J^-2/3 C - Id)/2 and Hooke's
//                          orthotropic stiffness A: Young's moduli, shear moduli, v12/E1 = v21/E2 and so on
// The last five have the names and the order of FEBio's manual (trans iso Mooney-Rivlin, Yeoh, natural neo-Hookean, Ogden
// unconstrained, Fung orthotropic). Its k is k0 here, and Hencky is given by Lame's constants. AnisotropyDirections are the
// fibres a of TransverselyIsotropic and TransverselyIsotropicMooneyRivlin, or fibre and sheet (and normal) of Costa and
// FungOrthotropic, whose axes 1, 2, 3 they are: for all cells, or for each cell one after the other, or for each node; they
// are made orthogonal and of length 1. From nodes a cell gets the axis closest to those of its corners, whatever their signs.
// They can come from another component: an array of a file (AnisotropyDirections="@loader.tetrahedraDirections" or
// "@loader.nodeDirections" of MeshVTKLoader or MeshGmshLoader with directionArray) or a table by label (ValuesFromLabels with
// width="3"). If there are as many cells as nodes, they are those of the cells. Instead of ParameterSet, parameters can be
// given by name, each one value or one per cell; youngModulus and poissonRatio define those not given, so that small strains
// follow Hooke's law: parameters that contradict them by more than a thousandth are rejected. For TransverselyIsotropic they
// are the moduli of the matrix; the fibres add stiffness in their direction.
//
// Laws with ln J are infinite at J = 0: a step that inverts an element ends with a report of that element. StVenantKirchhoff
// and StableNeoHookean are finite there, and the run continues. That does not guarantee recovery: StVenantKirchhoff softens
// under strong compression, does not distinguish a shape from its mirror image (E = 0 in both), and has no force out of the
// plane of a flat cell; an inverted cell of StableNeoHookean is driven back, but folds of many cells can lock each other. A
// bar of it compressed to a fraction s of its length with free sides has J = a - mu/((lambda + mu) s): below s = mu/(lambda +
// 2 mu), half with Poisson's ratio 0 and 0.29 with 0.3, the law has no solution for the width, and bodies fold somewhat before
// that. matrixRegularization = true replaces, where J < 1, the part d2W/dJ2 dJ_i dJ_j of the tangent by d2W/dJ2 ((1 - b) dJ_i
// dJ_j + b (dJ_i . dJ_j) Id), b = 1 - J, at most 1 (section 2.3): Newton's method then needs more iterations but is more
// robust. d2W/dJ2 is the whole second derivative, of exponentials too. The energy of StVenantKirchhoff has no J: with it the
// attribute is rejected. projectedTangent = true removes the negative eigenvalues from each element's tangent. Neither changes
// the equilibrium.
//
// viscous = true relaxes the second Piola-Kirchhoff stress S_h of any of these laws by a Prony series (section 3.1):
//   S_v = S_h - sum_i gamma_i,   tau_i dgamma_i/dt + gamma_i = alpha_i S_h,   gamma_i = 0 at the start
// ParameterAlpha are fractions of the instantaneous modulus, so that G(t) = G_0 (1 - sum alpha_i (1 - exp(-t/tau_i))); FEBio's
// moduli, in contrast, are those after all relaxation. viscousUpdate = backward is the published recursion gamma^n = (h alpha
// S^n + tau gamma^{n-1})/(h + tau), of first order in the step h; exponential is exact for stresses that change linearly in a
// step: second order, with an integrator of second order and without its rayleighStiffness, which damps by the tangent of the
// step. viscousPart = deviatoric relaxes only the deviatoric stress, as FEBio's uncoupled viscoelastic materials do, and the
// bulk modulus is constant: S_h is then that of the energy without its last term, for a law with isochoric invariants, and the
// last term is added unchanged. With dilatation = mean (of hexahedra) it is the only choice. The tangent follows the force
// exactly. The history is updated at the end of a step; its energy is the potential of the force with the history fixed: the
// elastic energy of EnergyMonitor is not the stored energy of a viscous body, and can be negative. projectedTangent and
// matrixRegularization replace the law's part of the tangent; that of the history is added unchanged, and may have either
// sign.
//
// Cell fields for exporters: vonMises of Cauchy's stress [Pa], J, strain (E: xx yy zz xy yz zx).
//
// Example:
// <Node name="root" dt="0.02" gravity="0 0 -9.81">
//   <RegularGridTopology name="grid" n="3 3 9" min="0 0 0" max="0.02 0.02 0.1"/>
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-8"/>
//   <Node name="beam">
//     <TetrahedronSetTopologyContainer name="tets"/>
//     <Hexa2TetraTopologicalMapping input="@../grid" output="@tets" swapping="true"/>
//     <MechanicalObject/>
//     <DiagonalMass massDensity="1000"/>
//     <TetrahedronHyperelasticityFEMForceField materialName="NeoHookean" youngModulus="2e4" poissonRatio="0.45"/>
//     <BoxROI name="held" box="-1 -1 -0.001 1 1 0.001"/>
//     <FixedProjectiveConstraint indices="@held.indices"/>
//   </Node>
// </Node>
#include "components/hyperelasticity/hyperelastic_force_field.h"
#include "framework/scene/factory.h"

using namespace stroma;

STROMA_COMPONENT(tetrahedron_hyperelasticity_fem_force_field) {
  using Field = HyperelasticForceField;
  const std::string help = "hyperelastic tetrahedra: laws of large strains (StVenantKirchhoff, NeoHookean, ...)";
  factory.add<Field>("TetrahedronHyperelasticityFEMForceField", help);
  factory.add<Field>("MJEDTetrahedralForceField", help);
  factory.add<Field>("StandardTetrahedralFEMForceField", help + ", in the textbook's discretisation",
                     [](Field& f) { f.discretization = Field::Discretization::standard; });
}
