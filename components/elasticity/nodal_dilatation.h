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
#include "components/elasticity/nodal_averages.h"

namespace stroma::tetrahedron {

/// `Single`: a model of averaged_models.h.
template <class Single>
class NodalDilatation final : public NodalAverages<StorageOf<FanOf<Single>>> {
  using Base = NodalAverages<StorageOf<FanOf<Single>>>;
  using Base::exact, Base::keep, Base::startSums, Base::addWarpedProduct, Base::addPressures, Base::keepPressures,
      Base::withEnergyOfSums, Base::spread, Base::materials_, Base::x_, Base::sums_, Base::gradients_ready_;
  using typename Base::Cells, typename Base::Nodes, typename Base::Matrix, typename Base::Derivatives;
  using Model = FanOf<Single>;

 public:
  using Base::Base;
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
      sum = withEnergyOfSums(sum, m);
    }
    return sum;
  }

 private:
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
  /// Long, so once for assembly and diagonal; noipa as in model_kernels.h.
  [[gnu::noipa, gnu::flatten]] void matrix(const Cells& m, Index b, Matrix& k) const override {
    if constexpr (exact) {
      Nodes x;
      m.storage.loop.gather(b, x_.rows(), x);
      Model::matrix(m.storage.rest[b], m.storage.tangent[b], x, k);
    } else {
      Base::matrix(m, b, k);
    }
  }
  [[gnu::noipa, gnu::flatten]] void differentiate(const Cells& m, Index b, Derivatives& out) const override {
    if constexpr (exact) {
      Nodes x;
      m.storage.loop.gather(b, x_.rows(), x);
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
  }
};

template <class Single>
std::unique_ptr<ElementKernels> averagedKernelsOf(const Elements& elements) {
  return std::make_unique<NodalDilatation<Single>>(elements);
}

}  // namespace stroma::tetrahedron
