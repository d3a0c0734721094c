// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/fem/model_kernels.h"
#include "framework/fem/tetrahedron.h"
#include "framework/fem/tetrahedron_fans.h"

namespace stroma::tetrahedron {

/// Two nodes of the ring share a tetrahedron when they follow each other.
struct FanCoupling {
  static constexpr bool coupled(int i, int j) { return i < 2 || j < 2 || (i - j <= 1 && j - i <= 1); }
};
/// What each tetrahedron of a fan keeps.
template <class Data>
struct Fanned {
  Data of[fan_size];
};

/// f = the sum of the forces [N] `a` and `b` of both tetrahedra of a fan on its nodes.
template <class T>
void sumOfBoth(const V3<T> (&a)[4], const V3<T> (&b)[4], V3<T> (&f)[fan_nodes]) {
  static_assert(fan_size == 2);
  f[0] = a[0] + b[0], f[1] = a[1] + b[1], f[2] = a[2], f[3] = a[3] + b[2], f[4] = b[3];
}
/// Edges from node 0 of the fans of a batch to the four others, x y z each; those of tetrahedron i are 0, 1 + i and 2 + i. In memory:
/// loops over tiles (ElementLoop::forEachTile) go through all of a tile's batches part by part, so that none waits for itself.
struct FanEdges {
  Pack of[12];
  template <class Loop>
  void gather(const Loop& loop, Index batch, ConstRows x) {
    V3<Pack> at[fan_nodes];
    loop.gather(batch, x, at);
#pragma GCC unroll 4
    for (int a = 1; a < fan_nodes; ++a) {
      const V3<Pack> e = at[a] - at[0];
      of[3 * a - 3] = e.x, of[3 * a - 2] = e.y, of[3 * a - 1] = e.z;
    }
  }
  V3<Pack> operator[](int edge) const { return {of[3 * edge], of[3 * edge + 1], of[3 * edge + 2]}; }
};

/// A model of ModelKernels for fans, from one for tetrahedra, which may have `long_force`: its force is not short, and ofFan(): as
/// matrix() below, in which blocks of nodes that share no tetrahedron need not be.
template <class Single>
struct FanOf {
  static constexpr int nodes = fan_nodes;
  static constexpr bool reads_position = Single::reads_position;
  using Coupling = FanCoupling;
  static constexpr bool long_force = reads_position || requires { Single::long_force; };
  template <class T>
  using Rest = Fanned<typename Single::template Rest<T>>;
  template <class T>
  using Tangent = Fanned<typename Single::template Tangent<T>>;

  /// f = the forces [N] of all tetrahedra of the fan on its nodes; each keeps its own tangent.
  template <class T>
  static void force(const Rest<T>& rest, Tangent<T>& t, const V3<T> (&x)[nodes], V3<T> (&f)[nodes]) {
    gatherForces<long_force>(f, [&](int i, V3<T>(&out)[4]) {
      const Corners<T> c(x, i);
      Single::force(rest.of[i], t.of[i], c.x, out);
    });
  }
  template <class T>
  static void forceAndProduct(const Rest<T>& rest, Tangent<T>& t, T factor, const V3<T> (&x)[nodes], const V3<T> (&dx)[nodes],
                              V3<T> (&f)[nodes]) requires requires(V3<T> (&own)[4]) {
    Single::forceAndProduct(rest.of[0], t.of[0], factor, own, own, own);
  }
  {
    gatherForces<long_force>(f, [&](int i, V3<T>(&out)[4]) {
      const Corners<T> c(x, i), dc(dx, i);
      Single::forceAndProduct(rest.of[i], t.of[i], factor, c.x, dc.x, out);
    });
  }
  /// Sum of the energies of the tetrahedra [J].
  template <class T>
  static T energy(const Rest<T>& rest, const Tangent<T>& t, const V3<T> (&x)[nodes]) {
    T sum(0.);
    for (int i = 0; i < fan_size; ++i) sum = sum + Single::energy(rest.of[i], t.of[i], Corners<T>(x, i).x);
    return sum;
  }
  /// df = factor K dx, tetrahedron by tetrahedron.
  template <class T>
  static void product(const Rest<T>& rest, const Tangent<T>& t, T factor, const V3<T> (&x)[nodes], const V3<T> (&dx)[nodes],
                      V3<T> (&df)[nodes]) {
    gatherForces(df, [&](int i, V3<T>(&out)[4]) {
      const Corners<T> c(x, i), dc(dx, i);
      Single::product(rest.of[i], t.of[i], factor, c.x, dc.x, out);
    });
  }
  /// K of the fan, [i][j][row][column], zero for nodes that share no tetrahedron; each one's by products with unit vectors of its
  /// nodes but the first, as no translation has a force.
  static void matrix(const Rest<Pack>& rest, const Tangent<Pack>& t, const V3<Pack> (&x)[nodes], Pack (&k)[nodes * nodes * 9]) {
    if constexpr (requires { Single::ofFan(rest, t, x, k); }) return Single::ofFan(rest, t, x, k);
    for (Pack& value : k) value = Pack(0.);
    for (int i = 0; i < fan_size; ++i) {
      const Corners<Pack> c(x, i);
      Pack own[4 * 4 * 9];
      ElementLoop<4>::matrixFromProducts(
          [&](const V3<Pack>(&dx)[4], V3<Pack>(&df)[4]) { Single::product(rest.of[i], t.of[i], Pack(1.), c.x, dx, df); }, own, 1);
      for (int a = 0; a < 4; ++a)
        for (int e = a * 36; e < a * 36 + 9; ++e) own[e] = -(own[e + 9] + own[e + 18] + own[e + 27]);
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b)
          for (int e = 0; e < 9; ++e) k[(corner(i, a) * nodes + corner(i, b)) * 9 + e] += own[(a * 4 + b) * 9 + e];
    }
  }

  // ---- for loops that want more of each tetrahedron ----
  /// The nodes of tetrahedron i of a fan: the two of the common edge, and the neighbours i and i + 1 in the ring.
  template <class T>
  struct Corners {
    V3<T> x[4];
    Corners(const V3<T> (&of)[nodes], int i) : x{of[0], of[1], of[2 + i], of[3 + i]} {}
  };
  /// f = the sum over the fan of what force(i, out) gives the four nodes of tetrahedron i. The last node of each
  /// tetrahedron is new to the fan, so that its force is stored and not added. Long mathematics are compiled once, in a
  /// loop; short ones are written out, so that packs stay in registers.
  template <bool is_long = Single::reads_position, class T, class Force>
  static void gatherForces(V3<T> (&f)[nodes], Force&& force) {
    V3<T> own[fan_size][4];
    if constexpr (is_long) {
      int count = fan_size;
      asm("" : "+r"(count));  // unknown to the compiler, which would write the loop out
      for (int i = 0; i < count; ++i) force(i, own[i]);
    } else {
      force(0, own[0]), force(1, own[1]);
    }
    sumOfBoth(own[0], own[1], f);
  }
};

}  // namespace stroma::tetrahedron
