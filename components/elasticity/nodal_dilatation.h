// SPDX-License-Identifier: LGPL-2.1-or-later
// Tetrahedra whose volume change is averaged at the nodes, so that a nearly incompressible mesh does not lock (Bonet
// and Burton 1998, there for hyperelastic laws; here for the strain eps of any method):
//   V_a = sum_e V_e/4,   theta_a = 1/V_a sum_e V_e/4 tr(eps_e),   K = lambda + 2/3 mu
//   U = sum_e V_e mu dev(eps):dev(eps) + sum_a 1/2 K V_a theta_a^2
//   f_i = -sum_e V_e (2 mu dev(eps) + p_e I) g_i,   p_e = K/4 sum_{a in e} theta_a
// sums over the elements around node a, or the nodes of element e. Volume changes jump where the material does:
// elements with another K have sums of their own, so that a node between two materials has two theta_a. A force or
// product passes twice over the elements: deviators and sums at the nodes, then pressures. The exact tangent adds how
// R and g_i change, in the strains and under the stresses: with b_a = sum_e V_e/4 g_i,
//   df = -sum_a K/V_a b_a (d_a . dx) - sum_e V_e p_e dg_i + deviators,   d_a = d(V_a theta_a)/dx = b_a where U exists
#pragma once
#include "components/elasticity/averaged_models.h"

namespace stroma::tetrahedron {

template <class Single>
class NodalDilatation final : public ElementKernels {
  using Cells = AveragedCells<Single>;
  using Model = typename Cells::Model;
  using Nodes = V3<Pack>[fan_nodes];
  using Matrix = typename ElementLoop<fan_nodes, FanCoupling>::Matrix;
  static constexpr bool exact = Model::reads_position;

 public:
  /// Puts other constants into the materials; false where they cannot be these.
  using Fill = std::function<bool(std::vector<Cells>&)>;
  NodalDilatation(std::vector<Cells>&& materials, Fill fill)
      : materials_(std::move(materials)), fill_(std::move(fill)) {}

  bool refill() override {
    gradients_ready_ = false;
    return fill_(materials_);
  }

  void addForce(ConstRows x, Rows f) override {
    if constexpr (exact) keep(x);
    for (Cells& m : materials_) {
      startSums(m, x.count);
      m.storage.loop.template run<1, 2>({x}, {f, sums_.rows()}, [&](Index b, const auto& in, auto& out) {
        auto& t = m.storage.tangent[b];
        Model::force(m.storage.rest[b], t, in[0], out[0]);
        spread(t.of[0].volume_change, t.of[1].volume_change, out[1]);
      });
      addPressures(m, 1, f);
      if constexpr (exact) keepPressures(m);
    }
    gradients_ready_ = false;
  }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override {
    if constexpr (exact) {
      addForce(x, f);
      addProduct(dx, factor, f);
    } else {
      addBoth(x, dx, factor, f);
    }
  }
  void addProduct(ConstRows dx, double factor, Rows df) const override {
    for (const Cells& m : materials_) {
      startSums(m, dx.count);
      if constexpr (exact)
        addExactProduct(m, dx, factor, df);
      else
        addWarpedProduct(m, dx, factor, df);
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
      m.storage.loop.assemble(factor, at, values, [&](Index b, Matrix& k) { matrix(m, x_, b, k); });
      at += m.storage.loop.slotCount();
      m.patches.assemble(factor, m.factor, at, values);
      at += m.patches.slotCount();
    }
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    updatePatches();
    for (const Cells& m : materials_) {
      m.storage.loop.assembleDiagonal(factor, blocks, [&](Index b, Matrix& k) { matrix(m, x_, b, k); });
      m.patches.assembleDiagonal(factor, m.factor, blocks);
    }
  }

 private:
  void keep(ConstRows x) {
    if (x_.count() != x.count) x_.resize(x.count);
    copy(x, x_);
  }
  void addBoth(ConstRows x, ConstRows dx, double factor, Rows f) {
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
  /// The part of the elements alone, and the changes of their volumes into sums_.
  void addWarpedProduct(const Cells& m, ConstRows dx, double factor, Rows df) const {
    const Pack scale(factor);
    m.storage.loop.template run<1, 2>({dx}, {df, sums_.rows()}, [&](Index b, const auto& in, auto& out) {
      const auto& t = m.storage.tangent[b];
      Model::product(m.storage.rest[b], t, scale, in[0], in[0], out[0]);
      spread(volumeChange(t.of[0], in[0], 0), volumeChange(t.of[1], in[0], 1), out[1]);
    });
  }
  void addExactProduct(const Cells& m, ConstRows dx, double factor, Rows df) const {
    const Pack scale(factor);
    m.storage.loop.template run<2, 2>({x_.rows(), dx}, {df, sums_.rows()}, [&](Index b, const auto& in, auto& out) {
      Pack change[fan_size];
      Model::gatherForces(out[0], [&](int i, V3<Pack>(&own)[4]) {
        const typename Model::template Corners<Pack> c(in[0], i), dc(in[1], i);
        change[i] =
            Single::productAndVolumeChange(m.storage.rest[b].of[i], m.storage.tangent[b].of[i], scale, c.x, dc.x, own);
      });
      spread(change[0], change[1], out[1]);
    });
  }
  /// Only rows of this material are read.
  void startSums(const Cells& m, Index rows) const {
    if (sums_.count() != rows) sums_.resize(rows);
    for (Index row : m.rows) sums_[row].setZero();
  }
  /// V_0 tr of the strain of dx.
  static Pack volumeChange(const auto& t, const Nodes& dx, int i) {
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
      const auto [first, second] = pressures(t, in[0]);
      const Gradients<Pack>&g = t.of[0].g, &h = t.of[1].g;
      const V3<Pack> f1 = g.g1 * first, f2 = g.g2 * first, f3 = g.g3 * first;
      const V3<Pack> h1 = h.g1 * second, h2 = h.g2 * second, h3 = h.g3 * second;
      out[0][0] = -(f1 + f2 + f3 + h1 + h2 + h3);
      out[0][1] = f1 + h1, out[0][2] = f2, out[0][3] = f3 + h2, out[0][4] = h3;
    });
  }
  /// -V_e p_e of both tetrahedra from sums_ after addPressures() has made pressures of them.
  static std::pair<Pack, Pack> pressures(const auto& t, const Nodes& sums) {
    const Pack common = sums[0].x + sums[1].x + sums[3].x;
    return {t.of[0].weight * (common + sums[2].x), t.of[1].weight * (common + sums[4].x)};
  }
  /// After addPressures() of a force.
  void keepPressures(Cells& m) const {
    m.storage.loop.forEachBatch([&](Index b) {
      Nodes sums;
      m.storage.loop.gather(b, sums_.rows(), sums);
      auto& t = m.storage.tangent[b];
      const auto [first, second] = pressures(t, sums);
      t.of[0].pressure = first, t.of[1].pressure = second;
    });
  }
  /// Long, so once for assembly and diagonal; noipa as in model_kernels.h.
  [[gnu::noipa, gnu::flatten]] static void matrix(const Cells& m, const Vector& position, Index b, Matrix& k) {
    Nodes x{};
    if constexpr (exact) m.storage.loop.gather(b, position.rows(), x);
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
      Derivatives derivatives;
      m.storage.loop.forEachLane([&](Index b, int l) {
        const Fan& fan = m.fans[m.storage.loop.elementOf(b, l)];
        if constexpr (exact)
          if (l == 0) differentiate(m, x_, b, derivatives);
        for (int i = 0; i < fan_size; ++i)
          if (const Index cell = fan.element[i]; cell >= 0) {
            const auto& t = m.storage.tangent[b].of[i];
            m.patches.add(std::size_t(cell), ofLane(m, t.g, t.weight, l, fan, i));
            if constexpr (exact)
              m.patches.addDerivative(std::size_t(cell), ofLane(m, derivatives[i], Pack(1.), l, fan, i));
          }
      });
    }
    gradients_ready_ = true;
  }
  /// d(V_0 tr(eps))/dx of the last three nodes of each tetrahedron of a fan.
  using Derivatives = Gradients<Pack>[fan_size];
  [[gnu::noipa, gnu::flatten]] static void differentiate(const Cells& m, const Vector& position, Index b,
                                                         Derivatives& out) {
    Nodes x;
    m.storage.loop.gather(b, position.rows(), x);
    for (int i = 0; i < fan_size; ++i) {
      const typename Model::template Corners<Pack> c(x, i);
      Pack change[9];
      for (int component = 0; component < 9; ++component) {
        V3<Pack> dx[4]{}, unused[4];
        V3<Pack>& moved = dx[1 + component / 3];
        (component % 3 == 0 ? moved.x : component % 3 == 1 ? moved.y : moved.z) = Pack(1.);
        change[component] =
            Single::productApart(m.storage.rest[b].of[i], m.storage.tangent[b].of[i], Pack(1.), c.x, dx, unused);
      }
      out[i] = {
          {change[0], change[1], change[2]}, {change[3], change[4], change[5]}, {change[6], change[7], change[8]}};
    }
  }
  /// A quarter of weight times `of` for the nodes of a cell, in the order of Cells::cells; the first one's is minus the
  /// sum of the others', because nothing changes where all move as one.
  static std::array<Vec3, 4> ofLane(const Cells& m, const Gradients<Pack>& of, const Pack& weight, int lane,
                                    const Fan& fan, int i) {
    const auto at = [&](const Pack& value) {
      alignas(64) double lanes[pack_lanes];
      value.store_aligned(lanes);
      return lanes[lane];
    };
    const double scale = at(weight) / 4;
    const auto vector = [&](const V3<Pack>& v) -> Vec3 { return scale * Vec3(at(v.x), at(v.y), at(v.z)); };
    const Vec3 g1 = vector(of.g1), g2 = vector(of.g2), g3 = vector(of.g3), g[4] = {-(g1 + g2 + g3), g1, g2, g3};
    const Tetrahedron& rows = m.cells[fan.element[i]];
    std::array<Vec3, 4> result;
    for (int a = 0; a < 4; ++a) {
      const Index row = fan.nodes[corner(i, a)];
      result[std::size_t(std::find(rows.begin(), rows.end(), row) - rows.begin())] = g[a];
    }
    return result;
  }

  mutable std::vector<Cells> materials_;  ///< mutable for the patches, which a scene without a matrix does not make
  Fill fill_;
  Vector x_;             ///< of the last force, for the exact tangent
  mutable Vector sums_;  ///< x: sum of V_e/4 tr(eps_e), then pressures, of one material at a time
  mutable bool gradients_ready_ = false;
};

}  // namespace stroma::tetrahedron
