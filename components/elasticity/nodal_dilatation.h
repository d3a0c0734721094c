// SPDX-License-Identifier: LGPL-2.1-or-later
// Tetrahedra whose volume change is averaged at the nodes, so that a nearly incompressible mesh does not lock (Bonet
// and Burton 1998, there for hyperelastic laws; here for the strain eps of any method):
//   V_a = sum_e V_e/4,   theta_a = 1/V_a sum_e V_e/4 tr(eps_e),   K = lambda + 2/3 mu
//   U = sum_e V_e mu dev(eps):dev(eps) + sum_a 1/2 K V_a theta_a^2
//   f_i = -sum_e V_e (2 mu dev(eps) + p_e I) g_i,   p_e = K/4 sum_{a in e} theta_a
// sums over the elements around node a, or the nodes of element e. Volume changes jump where the material does:
// elements with another K have sums of their own, so that a node between two materials has two theta_a. A force or
// product passes twice over the elements: deviators and sums at the nodes, then pressures.
#pragma once
#include <algorithm>

#include "components/elasticity/nodal_patches.h"
#include "components/elasticity/tetrahedron_models.h"
#include "framework/fem/fan_model.h"

namespace stroma::tetrahedron {

/// What a product reads: as Tangent, with -2/3 for the ratio lambda/mu; `weight` = V_0 / (mu V_0)^1/2, which makes V_0
/// tr(eps) of the trace of a strain times (mu V_0)^1/2; and that V_0 tr(eps) [m^3] at the last force.
template <class T>
struct AveragedTangent {
  Gradients<T> g;
  T ratio, weight, volume_change;
};
inline void setTangent(AveragedTangent<double>& t, const Gradients<double>& g, Lame lame, double volume) {
  Tangent<double> own;
  setTangent(own, g, lame, volume);
  t = {own.g, -2. / 3, lame.mu > 0 ? std::sqrt(volume / lame.mu) : 0, 0};
}

/// A model (Linear, Corotational) without its volume change.
template <class Single>
struct Deviatoric : Single {
  template <class T>
  using Rest = typename Single::template Rest<T>;
  template <class T>
  using Tangent = AveragedTangent<T>;
  template <class T>
  static void force(const Rest<T>& rest, AveragedTangent<T>& t, const V3<T> (&x)[4], V3<T> (&f)[4]) {
    V3<T> none[4];
    forceAndProduct(rest, t, T(0.), x, none, f);
  }
  /// volume_change is then that of the strain at x and of factor dx.
  template <class T>
  static void forceAndProduct(const Rest<T>& rest, AveragedTangent<T>& t, T factor, const V3<T> (&x)[4],
                              const V3<T> (&dx)[4], V3<T> (&f)[4]) {
    const S3<T> own = Single::strain(rest, t, x), both = own + strainOf(Edges(dx).e, t.g) * factor;
    t.volume_change = t.weight * (both.xx + both.yy + both.zz);
    nodalForces(restoringStress(both, t.ratio, T(1.)), t.g, f);
  }
};

/// The cells of one material: everything that the averages do not share with other materials.
template <class Single>
struct AveragedCells {
  using Model = FanOf<Deviatoric<Single>>;
  StorageOf<Model> storage;
  std::vector<Fan> fans;           ///< in the order of the storage's elements; Fan::element indexes `cells`
  std::vector<Tetrahedron> cells;  ///< rows of their nodes
  std::vector<Index> rows;         ///< rows of the nodes of all cells, ascending
  std::vector<double> factor;      ///< c_a = K/V_a [Pa/m^3], shape of rows
  NodalPatches patches;            ///< over `rows`, made when a matrix is asked for

  /// `volume`: V_e [m^3] of each cell.
  void average(double bulk, const std::vector<double>& volume) {
    for (const Tetrahedron& cell : cells) rows.insert(rows.end(), cell.begin(), cell.end());
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    std::vector<double> share(rows.size(), 0.);
    for (std::size_t e = 0; e < cells.size(); ++e)
      for (Index row : cells[e])
        share[std::size_t(std::lower_bound(rows.begin(), rows.end(), row) - rows.begin())] += volume[e] / 4;
    for (double v : share) factor.push_back(v > 0 ? bulk / v : 0);
  }
};

template <class Single>
class NodalDilatation final : public ElementKernels {
  using Cells = AveragedCells<Single>;
  using Model = typename Cells::Model;
  using Nodes = V3<Pack>[fan_nodes];
  using Matrix = typename ElementLoop<fan_nodes, FanCoupling>::Matrix;

 public:
  explicit NodalDilatation(std::vector<Cells>&& materials) : materials_(std::move(materials)) {}

  void addForce(ConstRows x, Rows f) override {
    for (Cells& m : materials_) {
      startSums(m, x.count);
      m.storage.loop.template run<1, 2>({x}, {f, sums_.rows()}, [&](Index b, const auto& in, auto& out) {
        auto& t = m.storage.tangent[b];
        Model::force(m.storage.rest[b], t, in[0], out[0]);
        spread(t.of[0].volume_change, t.of[1].volume_change, out[1]);
      });
      addPressures(m, 1, f);
    }
    gradients_ready_ = false;
  }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override {
    const Pack scale(factor);
    for (Cells& m : materials_) {
      startSums(m, x.count);
      m.storage.loop.template run<2, 2>({x, dx}, {f, sums_.rows()}, [&](Index b, const auto& in, auto& out) {
        auto& t = m.storage.tangent[b];
        Model::forceAndProduct(m.storage.rest[b], t, scale, in[0], in[1], out[0]);
        spread(t.of[0].volume_change, t.of[1].volume_change, out[1]);
      });
      addPressures(m, 1, f);
    }
    gradients_ready_ = false;
  }
  void addProduct(ConstRows dx, double factor, Rows df) const override {
    const Pack scale(factor);
    for (const Cells& m : materials_) {
      startSums(m, dx.count);
      m.storage.loop.template run<1, 2>({dx}, {df, sums_.rows()}, [&](Index b, const auto& in, auto& out) {
        const auto& t = m.storage.tangent[b];
        Model::product(m.storage.rest[b], t, scale, in[0], in[0], out[0]);
        spread(volumeChange(t.of[0], in[0], 0), volumeChange(t.of[1], in[0], 1), out[1]);
      });
      addPressures(m, factor, df);
    }
  }
  double energy(ConstRows x) const override {
    double sum = 0;
    for (const Cells& m : materials_) {
      sum += m.storage.loop.sum(
          x, [&](Index b, const Nodes& in) { return Model::energy(m.storage.rest[b], m.storage.tangent[b], in); });
      startSums(m, x.count);
      m.storage.loop.template run<1, 1>({x}, {sums_.rows()}, [&](Index b, const auto& in, auto& out) {
        auto t = m.storage.tangent[b];
        Nodes forces;
        Model::force(m.storage.rest[b], t, in[0], forces);
        spread(t.of[0].volume_change, t.of[1].volume_change, out[0]);
      });
      for (std::size_t a = 0; a < m.rows.size(); ++a) {
        const double volume_change = sums_[m.rows[a]].x();
        sum += 0.5 * m.factor[a] * volume_change * volume_change;
      }
    }
    return sum;
  }

  void addPattern(BlockPattern& pattern) const override {
    preparePatches();
    for (const Cells& m : materials_) m.storage.loop.addPattern(pattern), m.patches.addPattern(pattern);
  }
  /// For each material those of its elements, then those of its patches.
  std::vector<Index> slots(const BlockMatrix& matrix) const override {
    preparePatches();
    std::vector<Index> all;
    for (const Cells& m : materials_)
      for (const std::vector<Index>& part : {m.storage.loop.slots(matrix), m.patches.slots(matrix)})
        all.insert(all.end(), part.begin(), part.end());
    return all;
  }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    updatePatches();
    const Index* at = slots.data();
    for (const Cells& m : materials_) {
      m.storage.loop.assemble(factor, at, values, [&](Index b, Matrix& k) { matrix(m, b, k); });
      at += m.storage.loop.slotCount();
      m.patches.assemble(factor, m.factor, at, values);
      at += m.patches.slotCount();
    }
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    updatePatches();
    for (const Cells& m : materials_) {
      m.storage.loop.assembleDiagonal(factor, blocks, [&](Index b, Matrix& k) { matrix(m, b, k); });
      m.patches.assembleDiagonal(factor, m.factor, blocks);
    }
  }

 private:
  /// Only rows of this material are read.
  void startSums(const Cells& m, Index rows) const {
    if (sums_.count() != rows) sums_.resize(rows);
    for (Index row : m.rows) sums_[row].setZero();
  }
  /// V_0 tr of the strain of dx.
  static Pack volumeChange(const AveragedTangent<Pack>& t, const Nodes& dx, int i) {
    const V3<Pack> origin = dx[0];
    const V3<Pack> d[3] = {dx[corner(i, 1)] - origin, dx[corner(i, 2)] - origin, dx[corner(i, 3)] - origin};
    return t.weight * (dot(d[0], t.g.g1) + (dot(d[1], t.g.g2) + dot(d[2], t.g.g3)));
  }
  /// A quarter of each tetrahedron's volume change to each of its nodes.
  static void spread(Pack first, Pack second, Nodes& out) {
    const Pack quarter(0.25), none(0.), a = first * quarter, b = second * quarter, both = a + b;
    out[0] = {both, none, none}, out[1] = {both, none, none}, out[2] = {a, none, none};
    out[3] = {both, none, none}, out[4] = {b, none, none};
  }
  /// f -= V_e p_e g_i, p_e the mean of c_a times the sums at the nodes.
  void addPressures(const Cells& m, double factor, Rows f) const {
    for (std::size_t a = 0; a < m.rows.size(); ++a) sums_[m.rows[a]].x() *= -0.25 * factor * m.factor[a];
    m.storage.loop.template run<1, 1>({sums_.rows()}, {f}, [&](Index b, const auto& in, auto& out) {
      const auto& t = m.storage.tangent[b];
      const Pack common = in[0][0].x + in[0][1].x + in[0][3].x;
      const Pack first = t.of[0].weight * (common + in[0][2].x), second = t.of[1].weight * (common + in[0][4].x);
      const Gradients<Pack>&g = t.of[0].g, &h = t.of[1].g;
      const V3<Pack> f1 = g.g1 * first, f2 = g.g2 * first, f3 = g.g3 * first;
      const V3<Pack> h1 = h.g1 * second, h2 = h.g2 * second, h3 = h.g3 * second;
      out[0][0] = -(f1 + f2 + f3 + h1 + h2 + h3);
      out[0][1] = f1 + h1, out[0][2] = f2, out[0][3] = f3 + h2, out[0][4] = h3;
    });
  }
  /// Long, so once for assembly and diagonal; noipa as in model_kernels.h.
  [[gnu::noipa, gnu::flatten]] static void matrix(const Cells& m, Index b, Matrix& k) {
    const Nodes x{};
    Model::matrix(m.storage.rest[b], m.storage.tangent[b], x, k);
  }

  // ---- the matrix of the volume changes ----

  void preparePatches() const {
    for (Cells& m : materials_)
      if (m.patches.empty()) m.patches = NodalPatches(m.cells, m.rows);
  }
  /// With the gradients of the last force.
  void updatePatches() const {
    preparePatches();
    if (gradients_ready_) return;
    for (Cells& m : materials_) {
      m.patches.clear();
      m.storage.loop.forEachLane([&](Index b, int l) {
        const Fan& fan = m.fans[m.storage.loop.elementOf(b, l)];
        for (int i = 0; i < fan_size; ++i)
          if (const Index cell = fan.element[i]; cell >= 0)
            m.patches.add(std::size_t(cell), volumeGradients(m, m.storage.tangent[b].of[i], l, fan, i));
      });
    }
    gradients_ready_ = true;
  }
  /// V_0/4 g of the nodes of a cell, in the order of Cells::cells.
  static std::array<Vec3, 4> volumeGradients(const Cells& m, const AveragedTangent<Pack>& t, int lane, const Fan& fan,
                                             int i) {
    const auto at = [&](const Pack& value) {
      alignas(64) double lanes[pack_lanes];
      value.store_aligned(lanes);
      return lanes[lane];
    };
    const double scale = at(t.weight) / 4;
    const auto vector = [&](const V3<Pack>& v) -> Vec3 { return scale * Vec3(at(v.x), at(v.y), at(v.z)); };
    const Vec3 g1 = vector(t.g.g1), g2 = vector(t.g.g2), g3 = vector(t.g.g3), g[4] = {-(g1 + g2 + g3), g1, g2, g3};
    const Tetrahedron& rows = m.cells[fan.element[i]];
    std::array<Vec3, 4> result;
    for (int a = 0; a < 4; ++a) {
      const Index row = fan.nodes[corner(i, a)];
      result[std::size_t(std::find(rows.begin(), rows.end(), row) - rows.begin())] = g[a];
    }
    return result;
  }

  mutable std::vector<Cells> materials_;  ///< mutable for the patches, which a scene without a matrix does not make
  mutable Vector sums_;                   ///< x: sum of V_e/4 tr(eps_e), then pressures, of one material at a time
  mutable bool gradients_ready_ = false;
};

}  // namespace stroma::tetrahedron
