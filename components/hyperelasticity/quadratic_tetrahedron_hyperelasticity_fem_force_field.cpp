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
#include "components/hyperelasticity/point_functions.h"
#include "components/hyperelasticity/quadratic_kernels.h"
#include "framework/fem/eigen_matrix.h"
#include "framework/fem/model_kernels.h"
#include "framework/fem/quadratic_tetrahedron.h"
#include "framework/scene/factory.h"

#include <Eigen/LU>

using namespace stroma;
using namespace stroma::hyperelastic;
using namespace stroma::quadratic_tetrahedron;

namespace {

/// The law's parameters and tangents lie in arrays of their own: their size is the law's.
class QuadraticLaw final : public ElementKernels {
 public:
  QuadraticLaw(const HyperelasticLaw& law, const Cells& cells) : law_(*law.at_point(cells.form)) {
    const std::vector<QuadraticTetrahedron>& all = cells.mesh->quadratic_tetrahedra;
    loop_.build(all, *cells.rest, cells.first_row);
    const std::size_t batches = std::size_t(loop_.batches());
    rest_.resize(batches);
    parameters_.resize(batches * law_.parameters);
    tangent_.resize(batches * points * law_.tangent);
    std::vector<double> values(law_.parameters);
    for (Index b = 0; b < loop_.batches(); ++b)
      for (int l = 0; l < pack_lanes; ++l) {
        const Index e = loop_.elementOf(b, l);
        const std::size_t cell = std::size_t(e >= 0 ? e : loop_.elementOf(b, 0));
        setLane(rest_[b], l, restOf(cells, cell, e < 0));
        law_.read(cells.parameters(cell), values.data());
        for (std::size_t i = 0; i < values.size(); ++i)
          std::memcpy(reinterpret_cast<char*>(&parameters_[std::size_t(b) * law_.parameters + i]) +
                          std::size_t(l) * sizeof(double),
                      &values[i], sizeof(double));
      }
  }

  void addForce(ConstRows x, Rows f) override {
    if (x_.count() != x.count) x_.resize(x.count);
    copy(x, x_);
    loop_.run<1, 1>({x}, {f}, [&](Index b, const auto& in, auto& out) { force(b, in[0], out[0]); });
  }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override {
    addForce(x, f);
    addProduct(dx, factor, f);
  }
  double energy(ConstRows x) const override {
    return loop_.sum(x, [&](Index b, const auto& in) {
      const PointValues<Pack> d = atPoints(in);
      Pack sum(0.), density;
      for (int p = 0; p < points; ++p) {
        law_.energy(parameters(b), outerSum(d.d[p], rest_[b].g[p]), density);
        sum -= rest_[b].weight[p] * density;
      }
      return sum;
    });
  }
  void addProduct(ConstRows dx, double factor, Rows df) const override {
    const Pack scale(factor);
    loop_.run<2, 1>({x_.rows(), dx}, {df},
                    [&](Index b, const auto& in, auto& out) { product(b, scale, in[0], in[1], out[0]); });
  }
  void addPattern(BlockPattern& pattern) const override { loop_.addPattern(pattern); }
  std::vector<Index> slots(const BlockMatrix& matrix) const override { return loop_.slots(matrix); }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    loop_.assemble(factor, slots, values, [&](Index b, Loop::Matrix& k) { matrix(b, k); });
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    loop_.assembleDiagonal(factor, blocks, [&](Index b, Loop::Matrix& k) { matrix(b, k); });
  }

 private:
  using Loop = ElementLoop<quadratic_tetrahedron::nodes>;
  using Nodes = Loop::Nodes;
  template <class T>
  struct Rest {
    elastic::Gradients<T> g[points];  ///< [1/m], of an anisotropic law in the material's axes
    T weight[points];                 ///< minus the point's volume [m^3]
  };

  Rest<double> restOf(const Cells& cells, std::size_t cell, bool padding) const {
    V3<double> x[quadratic_tetrahedron::nodes];
    for (std::size_t a = 0; a < std::size(x); ++a)
      x[a] = vectorOf((*cells.rest)[cells.mesh->quadratic_tetrahedra[cell][a]]);
    const PointValues<double> j = atPoints(x);
    const Mat3 axes = law_.anisotropic ? cells.axes(cell) : Mat3(Mat3::Identity());
    Rest<double> rest;
    for (int p = 0; p < points; ++p) {
      const Mat3 edges = toEigen(j.matrix(p));
      const M3<double> g = fromEigen(axes.transpose() * edges.inverse().transpose());
      rest.g[p] = {g.c0, g.c1, g.c2};
      rest.weight[p] = padding ? 0 : -std::abs(edges.determinant()) / (24 * cells.mesh->overlap);
    }
    return rest;
  }
  const Pack* parameters(Index b) const { return parameters_.data() + std::size_t(b) * law_.parameters; }
  std::size_t tangentOf(Index b, int p) const { return (std::size_t(b) * points + std::size_t(p)) * law_.tangent; }

  void force(Index b, const Nodes& x, Nodes& f) {
    const PointValues<Pack> d = atPoints(x);
    PointValues<Pack> forces;
    for (int p = 0; p < points; ++p) {
      M3<Pack> stress;
      law_.stress(parameters(b), rest_[b].weight[p], outerSum(d.d[p], rest_[b].g[p]), tangent_.data() + tangentOf(b, p),
                  stress);
      set(stress, rest_[b].g[p], forces.d[p]);
    }
    nodesOf(forces, f);
  }
  void product(Index b, Pack factor, const Nodes& x, const Nodes& dx, Nodes& df) const {
    const PointValues<Pack> d = atPoints(x), dd = atPoints(dx);
    PointValues<Pack> forces;
    for (int p = 0; p < points; ++p) {
      M3<Pack> change;
      differential(b, p, outerSum(d.d[p], rest_[b].g[p]), outerSum(dd.d[p], rest_[b].g[p]) * factor, change);
      set(change, rest_[b].g[p], forces.d[p]);
    }
    nodesOf(forces, df);
  }
  void differential(Index b, int p, const M3<Pack>& f, const M3<Pack>& df, M3<Pack>& dp) const {
    law_.differential(parameters(b), rest_[b].weight[p], tangent_.data() + tangentOf(b, p), f, df, dp);
  }
  static void set(const M3<Pack>& stress, const elastic::Gradients<Pack>& g, V3<Pack> (&d)[3]) {
    d[0] = stress * g.g1, d[1] = stress * g.g2, d[2] = stress * g.g3;
  }

  /// K_ab = sum_p n_a . dP/dF . n_b, with the nine columns of dP/dF at each point.
  [[gnu::noipa]] void matrix(Index b, Loop::Matrix& k) const {
    constexpr int count = quadratic_tetrahedron::nodes;
    for (Pack& entry : k) entry = Pack(0.);
    Nodes x;
    loop_.gather(b, x_.rows(), x);
    const PointValues<Pack> d = atPoints(x);
    for (int p = 0; p < points; ++p) {
      const M3<Pack> f = outerSum(d.d[p], rest_[b].g[p]);
      Pack column[9][9];  // of dF = e_c (x) e_l at 3 l + c: dP, by columns
      for (int i = 0; i < 9; ++i)
        columnOf(
            i,
            [&](const M3<Pack>& df) {
              M3<Pack> dp;
              differential(b, p, f, df, dp);
              return dp;
            },
            column[i]);
      V3<Pack> n[count];
      for (int a = 0; a < count; ++a) n[a] = nodeGradient(rest_[b].g[p], a, p);
      for (int j = 0; j < count; ++j)
        for (int c = 0; c < 3; ++c) {
          Pack dp[9];  // for node j moving along c: dF = e_c (x) n_j
          for (int i = 0; i < 9; ++i)
            dp[i] = fma(column[c][i], n[j].x, fma(column[3 + c][i], n[j].y, column[6 + c][i] * n[j].z));
          for (int a = 0; a < count; ++a)
            for (int r = 0; r < 3; ++r) {
              Pack& entry = k[(a * count + j) * 9 + 3 * r + c];
              entry = fma(dp[r], n[a].x, fma(dp[3 + r], n[a].y, fma(dp[6 + r], n[a].z, entry)));
            }
        }
    }
  }

  const PointFunctions& law_;
  Loop loop_;
  Array<Rest<Pack>> rest_;  ///< shape (batches)
  Array<Pack> parameters_;  ///< shape (batches, parameters of the law)
  Array<Pack> tangent_;     ///< of the last force, shape (batches, points, tangent of the law)
  Vector x_;                ///< of the last force
};

}  // namespace

STROMA_COMPONENT(quadratic_tetrahedron_hyperelasticity_fem_force_field) {
  if (!quadraticKernels().make)
    quadraticKernels().make = [](const HyperelasticLaw& law, const Cells& cells) -> std::unique_ptr<ElementKernels> {
      return std::make_unique<QuadraticLaw>(law, cells);
    };
  factory.add<HyperelasticForceField>(
      "QuadraticTetrahedronHyperelasticityFEMForceField",
      "hyperelastic tetrahedra of ten nodes: laws of large strains (StVenantKirchhoff, NeoHookean, ...) at four points",
      [](HyperelasticForceField& f) { f.kind = &cell_kinds::quadratic_tetrahedron; });
}
