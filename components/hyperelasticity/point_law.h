// SPDX-License-Identifier: LGPL-2.1-or-later
// Cells of a hyperelastic law with several integration points, compiled once for all laws: the law's part of a point is behind
// functions (point_functions.h). At each point F = sum_i J_i (x) g_i over the derivatives J_i of the position along the cell's
// axes, and -w P g_i is the force on J_i, w the point's volume. Gradients are in the axes of an anisotropic material.
#pragma once
#include <Eigen/LU>

#include "components/hyperelasticity/cell_volume.h"
#include "components/hyperelasticity/point_functions.h"
#include "framework/fem/eigen_matrix.h"
#include "framework/fem/model_kernels.h"

namespace stroma::hyperelastic {

/// `Cell`: of cell_volume.h. The law's parameters and tangents lie in arrays of their own: their size is the law's.
template <class Cell>
class PointLaw final : public ElementKernels {
 public:
  PointLaw(const PointFunctions& law, const Cells& cells) : law_(law), cells_(cells) {
    loop_.build(Cell::listOf(*cells.mesh), *cells.rest, cells.first_row);
    const std::size_t batches = std::size_t(loop_.batches());
    rest_.resize(batches);
    parameters_.resize(batches * law_.parameters);
    tangent_.assign(batches * Cell::points * law_.tangent, Pack(0.));
    for (Index b = 0; b < loop_.batches(); ++b)
      for (int l = 0; l < pack_lanes; ++l) setLane(rest_[b], l, restOf(cells, cellOf(b, l), loop_.elementOf(b, l) < 0));
    takeParameters();
  }
  bool refill() override {
    takeParameters();
    return true;
  }

  void addForce(ConstRows x, Rows f) override {
    if (x_.count() != x.count) x_.resize(x.count);
    copy(x, x_);
    loop_.template run<1, 1>({x}, {f}, [&](Index b, const auto& in, auto& out) { force(b, in[0], out[0]); });
  }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override {
    addForce(x, f);
    addProduct(dx, factor, f);
  }
  double energy(ConstRows x) const override {
    return loop_.sum(x, [&](Index b, const auto& in) {
      const Values j = Cell::at(in);
      Pack sum(0.), density;
      for (int p = 0; p < Cell::points; ++p) {
        law_.energy(parameters(b), deformation(j, b, p), density);
        sum -= rest_[b].weight[p] * density;
      }
      return sum;
    });
  }
  void addProduct(ConstRows dx, double factor, Rows df) const override {
    const Pack scale(factor);
    loop_.template run<2, 1>({x_.rows(), dx}, {df},
                             [&](Index b, const auto& in, auto& out) { product(b, scale, in[0], in[1], out[0]); });
  }
  void addPattern(BlockPattern& pattern) const override { loop_.addPattern(pattern); }
  std::vector<Index> slots(const BlockMatrix& matrix) const override { return loop_.slots(matrix); }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    loop_.assemble(factor, slots.data(), values, [&](Index b, Matrix& k) { matrix(b, k); });
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    loop_.assembleDiagonal(factor, blocks, [&](Index b, Matrix& k) { matrix(b, k); });
  }

 private:
  using Loop = ElementLoop<Cell::nodes>;
  using Nodes = typename Loop::Nodes;
  using Matrix = typename Loop::Matrix;
  using Values = typename Cell::template Values<Pack>;
  template <class T>
  struct Rest {
    elastic::Gradients<T> g[Cell::points];  ///< [1/m]
    T weight[Cell::points];                 ///< minus the point's volume [m^3]
  };

  Rest<double> restOf(const Cells& cells, std::size_t cell, bool padding) const {
    V3<double> x[Cell::nodes];
    for (std::size_t a = 0; a < std::size(x); ++a) x[a] = vectorOf((*cells.rest)[Cell::listOf(*cells.mesh)[cell][a]]);
    const auto j = Cell::at(x);
    const Mat3 axes = law_.anisotropic ? cells.axes(cell) : Mat3(Mat3::Identity());
    Rest<double> rest;
    for (int p = 0; p < Cell::points; ++p) {
      const Mat3 edges = toEigen(Cell::matrix(j, p));
      const M3<double> g = fromEigen(axes.transpose() * edges.inverse().transpose());
      rest.g[p] = {g.c0, g.c1, g.c2};
      rest.weight[p] = padding ? 0 : -std::abs(edges.determinant()) / (Cell::scale * cells.mesh->overlap);
    }
    return rest;
  }
  /// Padding repeats the first.
  std::size_t cellOf(Index b, int l) const {
    const Index e = loop_.elementOf(b, l);
    return std::size_t(e >= 0 ? e : loop_.elementOf(b, 0));
  }
  void takeParameters() {
    std::vector<double> values(law_.parameters);
    for (Index b = 0; b < loop_.batches(); ++b)
      for (int l = 0; l < pack_lanes; ++l) {
        law_.read(cells_.parameters(cellOf(b, l)), values.data());
        for (std::size_t i = 0; i < values.size(); ++i)
          setLane(parameters_[std::size_t(b) * law_.parameters + i], l, values[i]);
      }
  }
  const Pack* parameters(Index b) const { return parameters_.data() + std::size_t(b) * law_.parameters; }
  std::size_t tangentOf(Index b, int p) const {
    return (std::size_t(b) * Cell::points + std::size_t(p)) * law_.tangent;
  }

  M3<Pack> deformation(const Values& j, Index b, int p) const {
    const M3<Pack> m = Cell::matrix(j, p);
    const V3<Pack> columns[3] = {m.c0, m.c1, m.c2};
    return elastic::outerSum(columns, rest_[b].g[p]);
  }
  void differential(Index b, int p, const M3<Pack>& f, const M3<Pack>& df, M3<Pack>& dp) const {
    law_.differential(parameters(b), rest_[b].weight[p], tangent_.data() + tangentOf(b, p), f, df, dp);
  }
  void add(const M3<Pack>& stress, Index b, int p, Values& forces) const {
    const elastic::Gradients<Pack>& g = rest_[b].g[p];
    Cell::add(M3<Pack>{stress * g.g1, stress * g.g2, stress * g.g3}, p, forces);
  }
  void force(Index b, const Nodes& x, Nodes& f) {
    const Values j = Cell::at(x);
    Values forces;
    for (int p = 0; p < Cell::points; ++p) {
      M3<Pack> stress;
      law_.stress(parameters(b), rest_[b].weight[p], deformation(j, b, p), tangent_.data() + tangentOf(b, p), stress);
      add(stress, b, p, forces);
    }
    Cell::toNodes(forces, f);
  }
  void product(Index b, Pack factor, const Nodes& x, const Nodes& dx, Nodes& df) const {
    const Values j = Cell::at(x), dj = Cell::at(dx);
    Values forces;
    for (int p = 0; p < Cell::points; ++p) {
      M3<Pack> change;
      differential(b, p, deformation(j, b, p), deformation(dj, b, p) * factor, change);
      add(change, b, p, forces);
    }
    Cell::toNodes(forces, df);
  }

  /// By products, or where a cell has gradients of its nodes K_ab = sum_p n_a . dP/dF . n_b. noipa: as in model_kernels.h.
  [[gnu::noipa, gnu::flatten]] void matrix(Index b, Matrix& k) const {
    Nodes x;
    loop_.gather(b, x_.rows(), x);
    if constexpr (requires { Cell::nodeGradient(rest_[b].g[0], 0, 0); })
      matrixFromPoints(b, x, k);
    else
      Loop::matrixFromProducts([&](const Nodes& dx, Nodes& df) { product(b, Pack(1.), x, dx, df); }, k);
  }
  /// With the nine columns of dP/dF at each point.
  void matrixFromPoints(Index b, const Nodes& x, Matrix& k) const {
    constexpr int count = Cell::nodes;
    for (Pack& entry : k) entry = Pack(0.);
    const Values j = Cell::at(x);
    for (int p = 0; p < Cell::points; ++p) {
      const M3<Pack> f = deformation(j, b, p);
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
      for (int a = 0; a < count; ++a) n[a] = Cell::nodeGradient(rest_[b].g[p], a, p);
      for (int node = 0; node < count; ++node)
        for (int c = 0; c < 3; ++c) {
          Pack dp[9];  // for a node that moves along c: dF = e_c (x) n
          for (int i = 0; i < 9; ++i)
            dp[i] = fma(column[c][i], n[node].x, fma(column[3 + c][i], n[node].y, column[6 + c][i] * n[node].z));
          for (int a = 0; a < count; ++a)
            for (int r = 0; r < 3; ++r) {
              Pack& entry = k[(a * count + node) * 9 + 3 * r + c];
              entry = fma(dp[r], n[a].x, fma(dp[3 + r], n[a].y, fma(dp[6 + r], n[a].z, entry)));
            }
        }
    }
  }

  const PointFunctions& law_;
  const Cells cells_;
  Loop loop_;
  Array<Rest<Pack>> rest_;  ///< shape (batches)
  Array<Pack> parameters_;  ///< shape (batches, parameters of the law)
  Array<Pack> tangent_;     ///< of the last force, shape (batches, points, tangent of the law)
  Vector x_;                ///< of the last force
};

/// Of `point_kernels.h`: in the forms mjed and projected.
template <class Cell>
std::unique_ptr<ElementKernels> pointLawOf(const HyperelasticLaw& law, const Cells& cells) {
  const PointFunctions* functions = cells.form == Form::standard ? nullptr : law.at_point(cells.form);
  return functions ? std::make_unique<PointLaw<Cell>>(*functions, cells) : nullptr;
}

}  // namespace stroma::hyperelastic
