// SPDX-License-Identifier: LGPL-2.1-or-later
// St. Venant-Kirchhoff: W = lambda/2 tr(E)^2 + mu tr(E^2), E = (C - Id)/2, which has no J:
//   tr E = (I1 - 3)/2,   tr E^2 = (I1^2 - 2 I2 - 2 I1 + 3)/4
// In invariants for other cells and forms. Linear tetrahedra have kernels of their own, without invariants:
//   S = lambda tr(E) Id + 2 mu E,  P = F S,  dP = dF S + F dS,  dE = sym(F^T dF)
#include "components/hyperelasticity/fan_kernels.h"
#include "components/hyperelasticity/hyperelastic_kernels.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

struct StVenantKirchhoff : InLameConstants<FirstAndSecond> {
  static auto energy(const auto&, const auto& I1, const auto& I2, const auto& p) {
    const auto trace = I1 - 3.;
    return 0.125 * p.lambda * (trace * trace) + 0.25 * p.mu * ((I1 * I1 - 2. * I2) - 2. * I1 + 3.);
  }
};

/// A model of FanKernels. Lame's constants are times minus the volume, so that P g_i are forces; no force changes them.
struct GreenTetrahedron {
  static constexpr int nodes = 4;
  static constexpr bool reads_position = true;
  using Frame = TriangularFrame;
  template <class T>
  using Rest = Frame::Gradients<T>;
  template <class T>
  struct Tangent {
    T lambda, mu;
  };

  template <class T>
  static void force(const Rest<T>& g, const Tangent<T>& t, const V3<T> (&x)[4], V3<T> (&f)[4]) {
    const M3<T> deformation = Frame::deformation(tetrahedron::Edges(x).e, g);
    Frame::forces(timesSymmetric(deformation, stress(t.lambda, t.mu, deformation)), g, f);
  }
  template <class T>
  static T energy(const Rest<T>& g, const Tangent<T>& t, const V3<T> (&x)[4]) {
    S3<T> e = metric(Frame::deformation(tetrahedron::Edges(x).e, g)) * T(0.5);
    e.xx -= T(0.5), e.yy -= T(0.5), e.zz -= T(0.5);
    const T trace = e.xx + e.yy + e.zz;
    return -fma(T(0.5) * t.lambda * trace, trace, t.mu * dot(e, e));
  }
  template <class T>
  static void product(const Rest<T>& g, const Tangent<T>& t, T factor, const V3<T> (&x)[4], const V3<T> (&dx)[4],
                      V3<T> (&df)[4]) {
    const M3<T> f = Frame::deformation(tetrahedron::Edges(x).e, g);
    const M3<T> change = Frame::deformation(tetrahedron::Edges(dx).e, g);
    const T lambda = factor * t.lambda, mu = factor * t.mu;
    Frame::forces(sum(change, stress(lambda, mu, f), f, stressChange(lambda, mu, f, change)), g, df);
  }
  /// (F + factor dF) S + factor F dS.
  template <class T>
  static void forceAndProduct(const Rest<T>& g, const Tangent<T>& t, T factor, const V3<T> (&x)[4], const V3<T> (&dx)[4],
                              V3<T> (&both)[4]) {
    const M3<T> f = Frame::deformation(tetrahedron::Edges(x).e, g);
    const M3<T> change = Frame::deformation(tetrahedron::Edges(dx).e, g) * factor;
    Frame::forces(sum(f + change, stress(t.lambda, t.mu, f), f, stressChange(t.lambda, t.mu, f, change)), g, both);
  }
  /// K_ab = lambda m_a (x) m_b + mu m_b (x) m_a + mu (g_a . g_b) F F^T + (g_a . S g_b) Id, m_a = F g_a: block(a, b, K_ab), a <= b.
  template <class T>
  static void pairs(const Rest<T>& rest, const Tangent<T>& t, const V3<T> (&x)[4], auto&& block) {
    const M3<T> f = Frame::deformation(tetrahedron::Edges(x).e, rest);
    const S3<T> s = stress(t.lambda, t.mu, f), left = metric(transpose(f)) * t.mu;
    V3<T> g[4], m[4], sg[4];
    Frame::forces(identity<T>(), rest, g), Frame::forces(f, rest, m);
    Frame::forces(M3<T>{{s.xx, s.xy, s.zx}, {s.xy, s.yy, s.yz}, {s.zx, s.yz, s.zz}}, rest, sg);
    for (int a = 0; a < 4; ++a)
      for (int b = a; b < 4; ++b) {
        const T both = stroma::dot(g[a], g[b]), held = stroma::dot(g[a], sg[b]);
        const V3<T> p = m[a] * t.lambda, q = m[a] * t.mu, &n = m[b];
        const T xy = both * left.xy, yz = both * left.yz, zx = both * left.zx;
        const T k[9] = {fma(p.x + q.x, n.x, fma(both, left.xx, held)), fma(p.x, n.y, fma(q.y, n.x, xy)),
                        fma(p.x, n.z, fma(q.z, n.x, zx)),              fma(p.y, n.x, fma(q.x, n.y, xy)),
                        fma(p.y + q.y, n.y, fma(both, left.yy, held)), fma(p.y, n.z, fma(q.z, n.y, yz)),
                        fma(p.z, n.x, fma(q.x, n.z, zx)),              fma(p.z, n.y, fma(q.y, n.z, yz)),
                        fma(p.z + q.z, n.z, fma(both, left.zz, held))};
        block(a, b, k);
      }
  }

 private:
  /// S = lambda/2 (tr C - 3) Id + mu (C - Id)
  template <class T>
  static S3<T> stress(T lambda, T mu, const M3<T>& f) {
    S3<T> c = metric(f);
    c.xx -= T(1.), c.yy -= T(1.), c.zz -= T(1.);
    const T on_unit = T(0.5) * lambda * (c.xx + c.yy + c.zz);
    return {fma(mu, c.xx, on_unit), fma(mu, c.yy, on_unit), fma(mu, c.zz, on_unit), mu * c.xy, mu * c.yz, mu * c.zx};
  }
  /// dS = lambda tr(dE) Id + 2 mu dE
  template <class T>
  static S3<T> stressChange(T lambda, T mu, const M3<T>& f, const M3<T>& df) {
    using stroma::dot;
    const auto both = [](const V3<T>& a, const V3<T>& da, const V3<T>& b, const V3<T>& db) {
      return fma(a.x, db.x, fma(a.y, db.y, fma(a.z, db.z, dot(da, b))));
    };
    const T xx = dot(f.c0, df.c0), yy = dot(f.c1, df.c1), zz = dot(f.c2, df.c2);
    const T on_unit = lambda * (xx + yy + zz), two_mu = mu + mu;
    return {fma(two_mu, xx, on_unit), fma(two_mu, yy, on_unit), fma(two_mu, zz, on_unit), mu * both(f.c0, df.c0, f.c1, df.c1),
            mu * both(f.c1, df.c1, f.c2, df.c2), mu * both(f.c2, df.c2, f.c0, df.c0)};
  }
  /// A S + B T
  template <class T>
  static M3<T> sum(const M3<T>& a, const S3<T>& s, const M3<T>& b, const S3<T>& t) {
    const auto column = [&](T s0, T s1, T s2, T t0, T t1, T t2) {
      return fma(s0, a.c0, fma(s1, a.c1, fma(s2, a.c2, fma(t0, b.c0, fma(t1, b.c1, b.c2 * t2)))));
    };
    return {column(s.xx, s.xy, s.zx, t.xx, t.xy, t.zx), column(s.xy, s.yy, s.yz, t.xy, t.yy, t.yz),
            column(s.zx, s.yz, s.zz, t.zx, t.yz, t.zz)};
  }
};

/// Fans of them.
struct GreenFan : tetrahedron::FanOf<GreenTetrahedron> {
  static void matrix(const Rest<Pack>& rest, const Tangent<Pack>& t, const V3<Pack> (&x)[nodes], Pack (&k)[nodes * nodes * 9]) {
    using tetrahedron::corner;
    for (Pack& value : k) value = Pack(0.);
    for (int i = 0; i < tetrahedron::fan_size; ++i)
      GreenTetrahedron::pairs(rest.of[i], t.of[i], Corners<Pack>(x, i).x, [&](int a, int b, const Pack(&own)[9]) {
        Pack *upper = k + (corner(i, a) * nodes + corner(i, b)) * 9, *lower = k + (corner(i, b) * nodes + corner(i, a)) * 9;
        for (int e = 0; e < 9; ++e) {
          upper[e] += own[e];
          if (a != b) lower[e % 3 * 3 + e / 3] += own[e];
        }
      });
  }
};

}  // namespace

/// In place of those from the energy: form mjed, as the law refuses the regularised one.
template <>
std::unique_ptr<ElementKernels> stroma::hyperelastic::tetrahedraOf<StVenantKirchhoff>(const Cells& cells) {
  using namespace tetrahedron;
  using Model = GreenFan;
  using Storage = StorageOf<Model>;
  const std::vector<tetrahedron::Fan> fans = gatherFans(cells.mesh->tetrahedra, cells.rest->size());
  const auto fill = [cells, fans](Storage& stored) {
    const auto nodes = nodesOf(fans);
    stored.fill([&](std::size_t f, bool padding, auto& rest, auto& tangent) {
      for (int i = 0; i < fan_size; ++i) {
        const Index e = fans[f].element[i];
        const std::size_t cell = std::size_t(e >= 0 ? e : fans[f].element[0]);
        stroma::Tetrahedron order;
        for (int a = 0; a < 4; ++a) order[a] = nodes[f][corner(i, a)];
        double weight = 0;
        setTetrahedron<TriangularFrame>(cells, cell, order, false, padding || e < 0, rest.of[i], weight);
        const auto constants = parametersOf<StVenantKirchhoff>(cells.parameters(cell));
        tangent.of[i] = {weight * constants.lambda, weight * constants.mu};
      }
    });
  };
  Storage storage;
  storage.arrange(nodesOf(fans), *cells.rest, cells.first_row);
  fill(storage);
  return std::make_unique<FanKernels<Model, GreenTetrahedron>>(std::move(storage), fill);
}

STROMA_COMPONENT(st_venant_kirchhoff) {
  offerHyperelasticLaw(inLameConstants(lawOf<StVenantKirchhoff>("StVenantKirchhoff", "lambda/2 tr(E)^2 + mu tr(E^2)")));
}
