// SPDX-License-Identifier: LGPL-2.1-or-later
// TetrahedronPorousForceField: the fluid in a sponge-like tissue. Added to any elastic tetrahedra of a node.
//
// A fraction f_w of the tissue is mobile fluid; the rest is incompressible. The effective volume ratio is J* = (f_w + J -
// 1)/f_w, and the tissue resists with Hencky's Cauchy stress and the fluid's pressure P:
//
//   sigma = (sigma_H - alpha P) Id,   sigma_H = K_0 f_w ln J*,   f_i = -V_0 (sigma_H - alpha P) cof F G_i
//
// sigma_H is infinite at J = 1 - f_w: below J_0 = 1 - f_w + K_0/K_lim it is replaced by its tangent, of slope f_w K_lim (and
// so is ln J, so that inverted elements have finite values). P is linear on the tetrahedra and follows Darcy's law on the rest
// shape, the fluid's storage being 1/M:
//
//   P'/M = kappa lap P - alpha J'/J,     P = 0 at drainedIndices, no flow through the rest of the boundary
//   (W/M + h kappa L) P^n = W P^{n-1}/M - (theta^n - theta^{n-1}),   theta_a = sum_e alpha V_e/4 ln J_e
//
// with the lumped volumes W of the nodes and L the gradients' products. The sum of W P/M + theta over an undrained body is
// constant: fluid is conserved.
//
// alpha (biotCoefficient) is Biot's coefficient: the fraction of the pressure that acts on the tissue, and the fluid displaced
// by a change of volume. Incompressible grains have alpha = 1, as published, and M = K_lim. Grains of bulk modulus K_s under a
// tissue of drained modulus K have alpha = 1 - K/K_s. M is biotModulus, or by grainModulus K_s and fluidModulus K_f
//
//   1/M = (alpha - f_w)/K_s + f_w/K_f
//
// A column between walls, of drained modulus K + 4G/3, thus has the undrained modulus K_u + 4G/3 = K + 4G/3 + alpha^2 M. A
// load p raises the pressure immediately to p alpha M/(K_u + 4G/3), and the column settles with the coefficient of
// consolidation c = kappa M (K + 4G/3)/(K_u + 4G/3). K and G are those of all laws of the tissue, K_0 included.
//
// bulkModulus and limitModulus have no default, because no values fit all tissues: those of the paper, 400 and 2200 Pa, are
// for a soft liver, and a fluid of 2200 Pa in cartilage of 0.5 MPa carries no load. A biphasic material (FEBio's), whose fluid
// is incompressible, is limitModulus of 1000 times the tissue's modulus or more, bulkModulus of a thousandth of it or less
// (the elastic law has the drained modulus), coupling="implicit", and fluidFraction one less the solid's share.
//
// coupling = semi_implicit, as published: forces use the pressure from before the step, and the pressure then follows the
// step's change of volume. Time steps must be small if the fluid is stiff compared with the tissue, and the integrator of
// first order, because a pressure lagging by one step excites oscillations. Statics have no stabilising mass: if alpha^2 M is
// above the modulus of the drained tissue, the pressure oscillates from step to step forever. Such a run ends with an error
// and no result. In dynamics light tissues do the same, with a warning; without flow, mass stabilises them as long as (h k)^2
// (alpha^2 M - K - 4G/3) is below 4 rho for the waves k of the mesh.
//
// With either coupling cells use the mean pressure of their nodes. Until the fluid has left the first cells below a drained
// surface, for a time of about d^2/(4 kappa (K + 4G/3)) with cells d thick, nodal pressures oscillate there, and a warning is
// printed: shapes and cell means are right. A first step of that length avoids this.
//
// implicit: forces use the pressure for the shape at the end of the step, for any step size.
//
// tangent (of implicit coupling) = coupled eliminates the pressure, by the Schur complement of Darcy's matrix:
//
//   K = K_tissue - U^T (W/M + h kappa L)^-1 U,   U = dtheta/dx with w^1/2 for w = d ln J/dJ
//
// exact where all elements have one J (else w is on one side of it; halves on both keep K symmetric): a few Newton iterations
// per step, whatever M. A product solves with Darcy's matrix, factored once for all steps of one size. As a matrix K couples
// all nodes: bodies of more than 500 nodes assemble the undrained one instead. Integrators then solve with K by conjugate
// gradients on products, which the scene's solver preconditions: the result does not depend on it, and CGLinearSolver, which
// only uses products, may be faster. undrained: no flow between elements; cheap, stable with one linear solve per step, but
// hundreds of Newton iterations if M is large.
//
// Source: S. Marchesseau, T. Heimann, S. Chatelin, R. Willinger, H. Delingette, "Multiplicative Jacobian energy
// decomposition method for fast porous visco-hyperelastic soft tissue model", MICCAI 2010, section 3.2; the splits
// after D. Kim, H. A. Tchelepi, R. Juanes, "Stability, accuracy and efficiency of sequential methods for
// coupled flow and geomechanics", SPE J. 16 (2011) 249-262; Biot's coefficient and modulus after E. Detournay,
// A. H.-D. Cheng, "Fundamentals of poroelasticity", Comprehensive Rock Engineering 2 (1993) 113-171.
//
// Cell field for exporters: pressure (mean of a cell) [Pa]. The attribute pressure has it node by node.
//
// Example:
// <Node name="root" dt="0.02" gravity="0 0 -9.81">
//   <RegularGridTopology name="grid" n="3 3 5" min="0 0 0" max="0.02 0.02 0.05"/>
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-8"/>
//   <Node name="sponge">
//     <TetrahedronSetTopologyContainer name="tets"/>
//     <Hexa2TetraTopologicalMapping input="@../grid" output="@tets"/>
//     <MechanicalObject/>
//     <DiagonalMass massDensity="1000"/>
//     <TetrahedronHyperelasticityFEMForceField materialName="NeoHookean" youngModulus="2e3" poissonRatio="0.3"/>
//     <TetrahedronPorousForceField fluidFraction="0.5" bulkModulus="400" limitModulus="2200" permeability="1e-6"
//                                  drainedIndices="@top.indices"/>
//     <BoxROI name="held" box="-1 -1 -0.001 1 1 0.001"/>
//     <BoxROI name="top" box="-1 -1 0.0499 1 1 1"/>
//     <FixedProjectiveConstraint indices="@held.indices"/>
//   </Node>
// </Node>
#include <Eigen/LU>
#include <cmath>

#include "components/hyperelasticity/porous_force_field.h"
#include "components/hyperelasticity/porous_loops.h"
#include "framework/fem/fan_model.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

using porous::PorousCells;

struct PorousTetrahedron {
  static constexpr int nodes = 4;
  static constexpr bool reads_position = true;
  template <class T>
  struct Rest {
    T sixth;               ///< 1/6 over the mesh's overlap, with the sign of the order of the vertices; 0 for padding
    T inverse_six_volume;  ///< with the same sign [1/m^3]
    T inverse_volume;      ///< 1/V_0, V_0 over the overlap [1/m^3]
    T quarter_volume;      ///< V_0/4; 0 for padding [m^3]
  };
  template <class T>
  using Tangent = porous::Tangent<T>;

  /// Areas a_i = V_0 cof F G_i of vertices 1..3 and J.
  template <class T>
  struct Shape {
    V3<T> a[3];
    T j;
    Shape(const V3<T> (&e)[3], const Rest<T>& rest)
        : a{cross(e[1], e[2]) * rest.sixth, cross(e[2], e[0]) * rest.sixth, cross(e[0], e[1]) * rest.sixth},
          j(dot(e[0], cross(e[1], e[2])) * rest.inverse_six_volume) {}
    Shape(const Rest<T>& rest, const V3<T> (&x)[4]) : Shape(tetrahedron::Edges<T>(x).e, rest) {}
  };
  template <class T>
  static void forces(const Shape<T>& shape, T factor, V3<T> (&f)[4]) {
    f[1] = shape.a[0] * factor, f[2] = shape.a[1] * factor, f[3] = shape.a[2] * factor;
    f[0] = -(f[1] + f[2] + f[3]);
  }
  template <class T>
  static T change(const Shape<T>& shape, const V3<T> (&dx)[4]) {
    const tetrahedron::Edges<T> d(dx);
    return dot(shape.a[0], d.e[0]) + dot(shape.a[1], d.e[1]) + dot(shape.a[2], d.e[2]);
  }
  template <class T>
  static T mean(const Rest<T>&, const V3<T> (&of)[4]) {
    return T(0.25) * (of[0].x + of[1].x + of[2].x + of[3].x);
  }
  template <class T>
  static void share(const Rest<T>& rest, T density, V3<T> (&own)[4]) {
    for (auto& node : own) node.x = density * rest.quarter_volume;
  }
  template <class T>
  static void split(const Rest<T>&, T whole, V3<T> (&own)[4]) {
    for (auto& node : own) node.x = T(0.25) * whole;
  }

  template <class T>
  static void product(const Rest<T>& rest, const Tangent<T>& t, T factor, const V3<T> (&x)[4], const V3<T> (&dx)[4],
                      V3<T> (&df)[4]) {
    const tetrahedron::Edges<T> edges(x), changes(dx);
    const V3<T>(&e)[3] = edges.e, (&d)[3] = changes.e;
    const Shape<T> shape(e, rest);
    const T normal = -factor * t.stiffness * change(shape, dx), held = -factor * t.stress * rest.sixth;
    df[1] = shape.a[0] * normal + (cross(d[1], e[2]) + cross(e[1], d[2])) * held;
    df[2] = shape.a[1] * normal + (cross(d[2], e[0]) + cross(e[2], d[0])) * held;
    df[3] = shape.a[2] * normal + (cross(d[0], e[1]) + cross(e[0], d[1])) * held;
    df[0] = -(df[1] + df[2] + df[3]);
  }
  /// at(p, q) += -stiffness a_p (x) a_q - stress/6 times the crossed edges that face p and q.
  template <class Block>
  static void addMatrix(const Rest<Pack>& rest, const Tangent<Pack>& t, const V3<Pack> (&x)[4], Block&& at) {
    const tetrahedron::Edges<Pack> edges(x);
    const V3<Pack>(&e)[3] = edges.e;
    const Shape<Pack> shape(e, rest);
    const V3<Pack> a[4] = {-(shape.a[0] + shape.a[1] + shape.a[2]), shape.a[0], shape.a[1], shape.a[2]};
    const Pack held = t.stress * rest.sixth;
    const V3<Pack> c[3] = {e[0] * held, e[1] * held, e[2] * held};
    const V3<Pack> w[4][4] = {{{}, c[2] - c[1], c[0] - c[2], c[1] - c[0]},
                              {c[1] - c[2], {}, c[2], -c[1]},
                              {c[2] - c[0], -c[2], {}, c[0]},
                              {c[0] - c[1], c[1], -c[0], {}}};
    for (int p = 0; p < 4; ++p)
      for (int q = 0; q < 4; ++q) {
        Pack* out = at(p, q);
        const V3<Pack> n = a[p] * (-t.assembled), &m = a[q], &v = w[p][q];
        out[0] += n.x * m.x, out[1] += n.x * m.y - v.z, out[2] += n.x * m.z + v.y;
        out[3] += n.y * m.x + v.z, out[4] += n.y * m.y, out[5] += n.y * m.z - v.x;
        out[6] += n.z * m.x - v.y, out[7] += n.z * m.y + v.x, out[8] += n.z * m.z;
      }
  }
};

struct PorousFan : tetrahedron::FanOf<PorousTetrahedron> {
  using Element = PorousTetrahedron;
  static constexpr int parts = tetrahedron::fan_size;
  static constexpr int corner(int i, int a) { return tetrahedron::corner(i, a); }
  static void matrix(const Rest<Pack>& rest, const Tangent<Pack>& t, const V3<Pack> (&x)[nodes],
                     Pack (&k)[nodes * nodes * 9]) {
    for (Pack& value : k) value = Pack(0.);
    for (int i = 0; i < parts; ++i)
      Element::addMatrix(rest.of[i], t.of[i], Corners<Pack>(x, i).x,
                         [&](int p, int q) { return k + (corner(i, p) * nodes + corner(i, q)) * 9; });
  }
};

class TetrahedronPorousForceField final : public PorousForceField {
  const CellKind& kind() const override { return cell_kinds::tetrahedron; }
  std::unique_ptr<porous::PorousElements> makeElements(const PorousCells& cells, const porous::Sponge& sponge,
                                                       Index first_row) const override;
};

std::unique_ptr<porous::PorousElements> TetrahedronPorousForceField::makeElements(const PorousCells& cells,
                                                                                  const porous::Sponge& sponge,
                                                                                  Index first_row) const {
  const Mesh& mesh = cells.mesh();
  const std::vector<Vec3>& rest = cells.rest();
  const auto fans = tetrahedron::gatherFans(mesh.tetrahedra, rest.size());
  const auto nodes = tetrahedron::nodesOf(fans);
  StorageOf<PorousFan> storage;
  storage.build(nodes, rest, first_row, [&](std::size_t f, bool padding, auto& data, auto&) {
    for (int i = 0; i < PorousFan::parts; ++i) {
      const auto at = [&](int a) -> const Vec3& { return rest[nodes[f][(PorousFan::corner(i, a))]]; };
      Mat3 edges;
      edges << at(1) - at(0), at(2) - at(0), at(3) - at(0);
      const double six_volumes = edges.determinant(), volume = std::abs(six_volumes) / (6 * mesh.overlap);
      const bool empty = padding || fans[f].element[i] < 0;
      data.of[i] = {empty ? 0 : std::copysign(1 / (6 * mesh.overlap), six_volumes), 1 / six_volumes, 1 / volume,
                    empty ? 0 : volume / 4};
    }
  });
  return std::make_unique<porous::PorousLoops<PorousFan>>(std::move(storage), sponge,
                                                          porous::PorousElements::Cost{8, 100});
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(tetrahedron_porous_force_field) {
  factory.add<stroma::TetrahedronPorousForceField>("TetrahedronPorousForceField",
                                                   "fluid in a tissue: effective volume, Darcy's law, pressure");
}
