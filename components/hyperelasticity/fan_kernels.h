// SPDX-License-Identifier: LGPL-2.1-or-later
// Kernels of fans of tetrahedra whose products read the position: the nodes of a tile of batches are gathered to memory first.
#pragma once
#include "framework/fem/fan_model.h"

namespace stroma::hyperelastic {

/// The ElementKernels of Model, a FanOf<Single>. Single has a forceAndProduct().
template <class Model, class Single>
class FanKernels final : public StoredKernels<StorageOf<Model>> {
  using Base = StoredKernels<StorageOf<Model>>;
  using Products = ProductLoops<Model>;
  using Base::storage_;
  static constexpr int fan_size = tetrahedron::fan_size;

 public:
  using Base::Base;
  void addForce(ConstRows x, Rows f) override {
    keep(x);
    ForceLoops<Model>::addForce(storage_, x, f);
  }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override {
    keep(x);
    addOfBoth(x, dx, f, [this, scale = Pack(factor)](Index b, int i, const auto& e, const auto& de, auto& out) {
      Single::forceAndProduct(storage_.rest[b].of[i], storage_.tangent[b].of[i], scale, e, de, out);
    });
  }
  double energy(ConstRows x) const override { return ForceLoops<Model>::energy(storage_, x); }
  void addProduct(ConstRows dx, double factor, Rows df) const override {
    addOfBoth(x_.rows(), dx, df, [this, scale = Pack(factor)](Index b, int i, const auto& e, const auto& de, auto& out) {
      Single::product(storage_.rest[b].of[i], storage_.tangent[b].of[i], scale, e, de, out);
    });
  }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    Products::assemble(storage_, x_, factor, slots, values);
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    Products::assembleDiagonal(storage_, x_, factor, blocks);
  }

 private:
  static constexpr Index tile = 4;
  using Corners = V3<Pack>[4];

  /// Remembers x, which products read.
  void keep(ConstRows x) {
    if (x_.count() != x.count) x_.resize(x.count);
    copy(x, x_);
  }
  /// f += what kernel(batch, i, x, dx, out) gives the nodes of tetrahedron i; its x and dx are seen from its node 0.
  template <class Kernel>
  void addOfBoth(ConstRows x, ConstRows dx, Rows f, Kernel&& kernel) const {
    const auto& loop = storage_.loop;
    loop.template forEachTile<tile>([&](Index first, Index count) __attribute__((flatten)) {
      tetrahedron::FanEdges edges[tile], change[tile];
      for (Index k = 0; k < count; ++k) edges[k].gather(loop, first + k, x), change[k].gather(loop, first + k, dx);
      for (Index k = 0; k < count; ++k) {
        V3<Pack> own[fan_size][4], sum[tetrahedron::fan_nodes];
#pragma GCC unroll 2
        for (int i = 0; i < fan_size; ++i) {
          const Corners e = {{}, edges[k][0], edges[k][1 + i], edges[k][2 + i]};
          const Corners de = {{}, change[k][0], change[k][1 + i], change[k][2 + i]};
          kernel(first + k, i, e, de, own[i]);
        }
        tetrahedron::sumOfBoth(own[0], own[1], sum);
        loop.scatter(first + k, sum, f);
      }
    });
  }

  Vector x_;  ///< of the last force
};

}  // namespace stroma::hyperelastic
