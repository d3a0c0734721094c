// SPDX-License-Identifier: LGPL-2.1-or-later
// Kernels of fans of tetrahedra whose force is linear in edges once their gradients have turned. A tile of batches goes through
// gathering, then rotations, then forces: each part is short and its batches do not wait for each other, so a processor works at
// several of them at once; a kernel that does all of a batch in one chain of operations waits for that chain.
#pragma once
#include <cstdint>

#include "components/elasticity/tetrahedron_corotational.h"
#include "components/elasticity/turning.h"
#include "framework/fem/fan_model.h"

namespace stroma::tetrahedron {

/// Asks for the cache lines of array[at], which are read soon. Processors foresee an array in order, but not from one page to the
/// next, and the tangents of three batches fill one. `at` may lie behind the end: nothing is read there.
template <class T>
void prefetch(const T* array, std::size_t at) {
  const std::uintptr_t first = reinterpret_cast<std::uintptr_t>(array) + at * sizeof(T);
  for (std::size_t line = 0; line < sizeof(T); line += 64) __builtin_prefetch(reinterpret_cast<const void*>(first + line));
}

/// 1/2 G/mu of each tetrahedron of a fan (turning.h).
using FanTurning = Fanned<S3<Pack>>;

/// df += what force(batch, i, d, f) gives for the edges d of tetrahedron i of a batch, by the tangents of the storage. The edges of a
/// batch are gathered before the forces of the one before are added: the two touch no common number, so that a processor does both
/// at once.
template <class Storage, class Force>
[[gnu::noinline]] void addFanProduct(const Storage& storage, ConstRows dx, const Force& force, Rows df) {
  constexpr Index tile = 32;  // the first batch of a tile waits for its edges
  constexpr Index ahead = 4;  // batches: one takes some 70 ns, memory 100 and more
  const bool is_beyond_cache = storage.tangent.size() * sizeof(storage.tangent[0]) > std::size_t(1) << 20;  // the second one
  const auto& loop = storage.loop;
  loop.template forEachTile<tile>([&](Index first, Index count) __attribute__((flatten)) {
    const Force own = force;  // its numbers in registers
    FanEdges kept[2];
    kept[0].gather(loop, first, dx);
    for (Index k = 0; k < count; ++k) {
      const FanEdges& edges = kept[k % 2];
      if (is_beyond_cache) prefetch(storage.tangent.data(), std::size_t(first + k + ahead));
      if (k + 1 < count) kept[(k + 1) % 2].gather(loop, first + k + 1, dx);
      V3<Pack> f[fan_size][4], sum[fan_nodes];
#pragma GCC unroll 2
      for (int i = 0; i < fan_size; ++i) {
        const V3<Pack> d[3] = {edges[0], edges[1 + i], edges[2 + i]};
        own(first + k, i, d, f[i]);
      }
      sumOfBoth(f[0], f[1], sum);
      loop.scatter(first + k, sum, df);
    }
  });
}

/// `Single`: a model of tetrahedra with Tangent and
///   turns                 its gradients turn with x
///   keeps_differences     d_i below are not the edges, and kept
///   turn(rest, tangent, e, d)        sets the gradients of the tangent, and d_i where these are kept, from the edges e_i
///   strainFrom(rest, tangent, d)     (mu V_0)^1/2 eps
///   stress_turns          turning.h holds for it; d_i are then the edges
template <class Single>
class FanKernels final : public StoredKernels<StorageOf<FanOf<Single>>>, public TurnsStresses {
  using Model = FanOf<Single>;
  using Base = StoredKernels<StorageOf<Model>>;
  using Products = ProductLoops<Model>;
  using Base::storage_;

 public:
  using Base::Base;
  void addForce(ConstRows x, Rows f) override {
    add<false>(x, x, 0, f);
    has_turning_ = keeps_turning_;
  }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override {
    if (!turns()) return add<true>(x, dx, factor, f);
    addForce(x, f), addProduct(dx, factor, f);
  }
  double energy(ConstRows x) const override { return ForceLoops<Model>::energy(storage_, x); }
  void addProduct(ConstRows dx, double factor, Rows df) const override {
    const auto* tangents = storage_.tangent.data();
    const Pack scale(factor), turned(factor * part_);
    const auto warped = [=](Index batch, int i, const V3<Pack>(&d)[3], V3<Pack>(&f)[4]) {
      const Tangent<Pack>& t = tangents[batch].of[i];
      nodalForces(restoringStress(strainOf(d, t.g), scale * t.ratio, scale), t.g, f);
    };
    if (!turns()) return addFanProduct(storage_, dx, warped, df);
    const auto turning = [=, of_fans = turning_.data()](Index batch, int i, const V3<Pack>(&d)[3], V3<Pack>(&f)[4]) {
      turningProduct(tangents[batch].of[i], of_fans[batch].of[i] * turned, scale, d, f);
    };
    addFanProduct(storage_, dx, turning, df);
  }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    if (!turns()) return Products::assemble(storage_, {}, factor, slots, values);
    storage_.loop.assemble(factor, slots.data(), values, [&](Index b, auto& k) { turningMatrix(b, k); });
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    if (!turns()) return Products::assembleDiagonal(storage_, {}, factor, blocks);
    storage_.loop.assembleDiagonal(factor, blocks, [&](Index b, auto& k) { turningMatrix(b, k); });
  }
  bool keepTurning(bool on) override {
    if constexpr (!Single::stress_turns) return false;
    if (on && turning_.size() == 0) turning_.resize(storage_.loop.batches());
    keeps_turning_ = on, has_turning_ = has_turning_ && on;
    return true;
  }
  void addTurning(double part) override { part_ = part; }

 private:
  bool turns() const { return has_turning_ && part_ != 0; }
  [[gnu::noinline]] void turningMatrix(Index b, typename ElementLoop<fan_nodes, FanCoupling>::Matrix& k) const {
    Fanned<TurningTangent<Pack>> t;
    for (int i = 0; i < fan_size; ++i) {
      const Tangent<Pack>& own = storage_.tangent[b].of[i];
      t.of[i] = {own.g, own.ratio, turning_[b].of[i] * Pack(part_)};
    }
    const V3<Pack> none[fan_nodes];
    fanMatrix<TurningBlocks<Pack>>(storage_.rest[b], t, none, k);
  }
  /// At the forces of a tile, whose tangents have turned.
  template <class Work>
  [[gnu::noinline]] void keepTurningOf(Index first, Index count, const Work& work) {
    if constexpr (Single::stress_turns)
      for (Index j = 0; j < fan_size * count; ++j) {
        const Index batch = first + j / fan_size, i = j % fan_size;
        V3<Pack> e[3];
        edgesOf(work.edges[j / fan_size], int(i), e);
        const auto& rest = storage_.rest[batch].of[i];
        const Tangent<Pack>& t = storage_.tangent[batch].of[i];
        turning_[batch].of[i] = turningOf(Single::strainFrom(rest, t, e), rest.root, t.ratio);
      }
  }
  static constexpr Index tile = 4;
  struct Work {
    FanEdges edges[tile], change[tile];
    Pack differences[Single::keeps_differences ? tile * fan_size : 1][9];
  };

  /// f += the forces at x and, if there is a `change`, factor K dx.
  template <bool change>
  void add(ConstRows x, ConstRows dx, double factor, Rows f) {
    const Pack scale(factor);
    storage_.loop.template forEachTile<tile>([&](Index first, Index count) __attribute__((flatten)) {
      Work work;
      for (Index k = 0; k < count; ++k) {
        work.edges[k].gather(storage_.loop, first + k, x);
        if constexpr (change) work.change[k].gather(storage_.loop, first + k, dx);
      }
      if constexpr (Single::turns)
        for (Index j = 0; j < fan_size * count; ++j) turn(first, j, work);
      if (keeps_turning_) keepTurningOf(first, count, work);
      for (Index k = 0; k < count; ++k) {
        V3<Pack> own[fan_size][4], sum[fan_nodes];
#pragma GCC unroll 2
        for (int i = 0; i < fan_size; ++i) force<change>(first, k, i, scale, work, own[i]);
        sumOfBoth(own[0], own[1], sum);
        storage_.loop.scatter(first + k, sum, f);
      }
    });
  }
  static void edgesOf(const FanEdges& edges, int i, V3<Pack> (&e)[3]) {
    e[0] = edges[0], e[1] = edges[1 + i], e[2] = edges[2 + i];
  }
  /// Tetrahedron j % fan_size of batch first + j / fan_size.
  void turn(Index first, Index j, Work& work) {
    const Index batch = first + j / fan_size, i = j % fan_size;
    V3<Pack> e[3], d[3];
    edgesOf(work.edges[j / fan_size], int(i), e);
    Single::turn(storage_.rest[batch].of[i], storage_.tangent[batch].of[i], e, d);
    if constexpr (Single::keeps_differences)
      for (int n = 0; n < 3; ++n)
        work.differences[j][3 * n] = d[n].x, work.differences[j][3 * n + 1] = d[n].y, work.differences[j][3 * n + 2] = d[n].z;
  }
  template <bool change>
  void force(Index first, Index k, int i, Pack factor, const Work& work, V3<Pack> (&f)[4]) const {
    V3<Pack> d[3], de[3];
    if constexpr (Single::keeps_differences) {
      const Pack(&kept)[9] = work.differences[k * fan_size + i];
      for (int n = 0; n < 3; ++n) d[n] = {kept[3 * n], kept[3 * n + 1], kept[3 * n + 2]};
    } else {
      edgesOf(work.edges[k], i, d);
    }
    if constexpr (change) {
      edgesOf(work.change[k], i, de);
      for (int n = 0; n < 3; ++n) d[n] = fma(factor, de[n], d[n]);
    }
    const Tangent<Pack>& t = storage_.tangent[first + k].of[i];
    nodalForces(restoringStress(Single::strainFrom(storage_.rest[first + k].of[i], t, d), t.ratio, Pack(1.)), t.g, f);
  }

  Array<FanTurning> turning_;  ///< of the last force, while it is kept
  bool keeps_turning_ = false, has_turning_ = false;
  double part_ = 0;  ///< of it, in products
};

}  // namespace stroma::tetrahedron
