// SPDX-License-Identifier: LGPL-2.1-or-later
// Tetrahedra whose volume change is averaged at the nodes, so that a nearly incompressible mesh does not lock (Bonet
// and Burton 1998, there for hyperelastic laws; here for the strain eps of any method):
//   V_a = sum_e V_e/4,   theta_a = 1/V_a sum_e V_e/4 tr(eps_e),   c_a = K_a/V_a,   K_a = 1/V_a sum_e V_e/4 K_e
//   U = sum_e V_e mu dev(eps):dev(eps) + sum_a 1/2 K_a V_a theta_a^2,   K = lambda + 2/3 mu
//   f_i = -sum_e V_e (2 mu dev(eps) + p_e I) g_i,   p_e = 1/4 sum_{a in e} K_a theta_a
// sums over the elements around node a, or the nodes of element e. A force or product passes twice over the elements:
// deviators and sums at the nodes, then pressures.
#pragma once
#include "framework/fem/fan_model.h"
#include "framework/fem/nodal_patches.h"
#include "framework/fem/tetrahedron_models.h"

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

template <class Single>
class NodalDilatation final : public StoredMethod<StorageOf<FanOf<Deviatoric<Single>>>> {
  using Model = FanOf<Deviatoric<Single>>;
  using Base = StoredMethod<StorageOf<Model>>;
  using Base::storage_;
  using Nodes = V3<Pack>[fan_nodes];
  using Matrix = typename ElementLoop<fan_nodes, FanCoupling>::Matrix;

 public:
  /// `fans`: of the storage, in the order of its elements. `bulk`, `volume`: K_e [Pa] and V_e [m^3] of each cell of
  /// `cells`.
  NodalDilatation(StorageOf<Model>&& storage, const std::vector<Fan>& fans, const std::vector<Tetrahedron>& cells,
                  const std::vector<double>& bulk, const std::vector<double>& volume, Index nodes, Index first_row)
      : Base(std::move(storage)), fans_(fans), cells_(cells), first_row_(first_row), factor_(std::size_t(nodes)) {
    std::vector<double> share(std::size_t(nodes), 0.);
    for (std::size_t e = 0; e < cells.size(); ++e)
      for (Index a : cells[e]) {
        share[std::size_t(a)] += volume[e] / 4;
        factor_[std::size_t(a)] += volume[e] / 4 * bulk[e];
      }
    for (std::size_t a = 0; a < share.size(); ++a)
      if (share[a] > 0) factor_[a] /= share[a] * share[a];
  }

  void addForce(ConstRows x, Rows f) override {
    startSums(x.count);
    storage_.loop.template run<1, 2>({x}, {f, sums_.rows()}, [&](Index b, const auto& in, auto& out) {
      auto& t = storage_.tangent[std::size_t(b)];
      Model::force(storage_.rest[std::size_t(b)], t, in[0], out[0]);
      spread(t.of[0].volume_change, t.of[1].volume_change, out[1]);
    });
    addPressures(1, f);
    gradients_ready_ = false;
  }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override {
    startSums(x.count);
    const Pack scale(factor);
    storage_.loop.template run<2, 2>({x, dx}, {f, sums_.rows()}, [&](Index b, const auto& in, auto& out) {
      auto& t = storage_.tangent[std::size_t(b)];
      Model::forceAndProduct(storage_.rest[std::size_t(b)], t, scale, in[0], in[1], out[0]);
      spread(t.of[0].volume_change, t.of[1].volume_change, out[1]);
    });
    addPressures(1, f);
    gradients_ready_ = false;
  }
  void addProduct(ConstRows dx, double factor, Rows df) const override {
    startSums(dx.count);
    const Pack scale(factor);
    storage_.loop.template run<1, 2>({dx}, {df, sums_.rows()}, [&](Index b, const auto& in, auto& out) {
      const auto& t = storage_.tangent[std::size_t(b)];
      Model::product(storage_.rest[std::size_t(b)], t, scale, in[0], in[0], out[0]);
      spread(volumeChange(t.of[0], in[0], 0), volumeChange(t.of[1], in[0], 1), out[1]);
    });
    addPressures(factor, df);
  }
  double energy(ConstRows x) const override {
    startSums(x.count);
    const double deviatoric = storage_.loop.sum(x, [&](Index b, const Nodes& in) {
      return Model::energy(storage_.rest[std::size_t(b)], storage_.tangent[std::size_t(b)], in);
    });
    storage_.loop.template run<1, 1>({x}, {sums_.rows()}, [&](Index b, const auto& in, auto& out) {
      auto t = storage_.tangent[std::size_t(b)];
      Nodes forces;
      Model::force(storage_.rest[std::size_t(b)], t, in[0], forces);
      spread(t.of[0].volume_change, t.of[1].volume_change, out[0]);
    });
    double volumetric = 0;
    for (std::size_t a = 0; a < factor_.size(); ++a) {
      const double sum = sums_[Index(a) + first_row_].x();
      volumetric += 0.5 * factor_[a] * sum * sum;
    }
    return deviatoric + volumetric;
  }

  void addPattern(BlockPattern& pattern) const override {
    Base::addPattern(pattern);
    patches().addPattern(pattern);
  }
  /// Those of the elements, then those of the patches.
  std::vector<Index> slots(const BlockMatrix& matrix) const override {
    std::vector<Index> all = Base::slots(matrix);
    element_slots_ = all.size();
    const std::vector<Index> more = patches().slots(matrix);
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    storage_.loop.assemble(factor, slots, values, [&](Index b, Matrix& k) { matrix(b, k); });
    currentPatches().assemble(factor, factor_, slots.data() + element_slots_, values);
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    storage_.loop.assembleDiagonal(factor, blocks, [&](Index b, Matrix& k) { matrix(b, k); });
    currentPatches().assembleDiagonal(factor, factor_, blocks);
  }

 private:
  void startSums(Index rows) const {
    if (sums_.count() != rows) sums_.resize(rows);
    clear(sums_);
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
  void addPressures(double factor, Rows f) const {
    for (std::size_t a = 0; a < factor_.size(); ++a) {
      double& sum = sums_.rows().data[(a + std::size_t(first_row_)) * row_doubles];
      sum *= -0.25 * factor * factor_[a];
    }
    storage_.loop.template run<1, 1>({sums_.rows()}, {f}, [&](Index b, const auto& in, auto& out) {
      const auto& t = storage_.tangent[std::size_t(b)];
      const Pack common = in[0][0].x + in[0][1].x + in[0][3].x;
      const Pack first = t.of[0].weight * (common + in[0][2].x), second = t.of[1].weight * (common + in[0][4].x);
      const Gradients<Pack>&g = t.of[0].g, &h = t.of[1].g;
      const V3<Pack> f1 = g.g1 * first, f2 = g.g2 * first, f3 = g.g3 * first;
      const V3<Pack> h1 = h.g1 * second, h2 = h.g2 * second, h3 = h.g3 * second;
      out[0][0] = -(f1 + f2 + f3 + h1 + h2 + h3);
      out[0][1] = f1 + h1, out[0][2] = f2, out[0][3] = f3 + h2, out[0][4] = h3;
    });
  }
  void matrix(Index b, Matrix& k) const {
    const Nodes x{};
    Model::matrix(storage_.rest[std::size_t(b)], storage_.tangent[std::size_t(b)], x, k);
  }

  // ---- the matrix of the volume changes ----

  NodalPatches& patches() const {
    if (!patches_) patches_ = std::make_unique<NodalPatches>(cells_, Index(factor_.size()), first_row_);
    return *patches_;
  }
  /// With the gradients of the last force.
  const NodalPatches& currentPatches() const {
    NodalPatches& p = patches();
    if (gradients_ready_) return p;
    p.clear();
    storage_.loop.forEachLane([&](Index b, int l) {
      const Fan& fan = fans_[std::size_t(storage_.loop.elementOf(b, l))];
      for (int i = 0; i < fan_size; ++i) {
        const Index cell = fan.element[std::size_t(i)];
        if (cell >= 0) p.add(std::size_t(cell), volumeGradients(storage_.tangent[std::size_t(b)].of[i], l, fan, i));
      }
    });
    gradients_ready_ = true;
    return p;
  }
  /// V_0/4 g of the nodes of a cell, in the order of `cells_`.
  std::array<Vec3, 4> volumeGradients(const AveragedTangent<Pack>& t, int lane, const Fan& fan, int i) const {
    const auto at = [&](const Pack& value) {
      alignas(64) double lanes[pack_lanes];
      value.store_aligned(lanes);
      return lanes[lane];
    };
    const double scale = at(t.weight) / 4;
    const auto vector = [&](const V3<Pack>& v) -> Vec3 { return scale * Vec3(at(v.x), at(v.y), at(v.z)); };
    const Vec3 g1 = vector(t.g.g1), g2 = vector(t.g.g2), g3 = vector(t.g.g3), g[4] = {-(g1 + g2 + g3), g1, g2, g3};
    const Tetrahedron& nodes = cells_[std::size_t(fan.element[std::size_t(i)])];
    std::array<Vec3, 4> result;
    for (int a = 0; a < 4; ++a) {
      const Index node = fan.nodes[std::size_t(corner(i, a))];
      result[std::size_t(std::find(nodes.begin(), nodes.end(), node) - nodes.begin())] = g[a];
    }
    return result;
  }

  std::vector<Fan> fans_;
  std::vector<Tetrahedron> cells_;
  Index first_row_;
  std::vector<double> factor_;  ///< c_a [Pa/m^3], shape (nodes)
  mutable Vector sums_;         ///< x: sum of V_e/4 tr(eps_e), then pressures
  mutable std::unique_ptr<NodalPatches> patches_;
  mutable bool gradients_ready_ = false;
  mutable std::size_t element_slots_ = 0;
};

}  // namespace stroma::tetrahedron
