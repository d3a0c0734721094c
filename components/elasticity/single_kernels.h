// SPDX-License-Identifier: LGPL-2.1-or-later
// The ElementKernels of a model with products in single precision beside those in double: of half the bytes, on twice the lanes.
// Forces, energies and matrices are those of ModelKernels. What products read of an element, its tangent, is rounded once, with
// each force; it then lies in places, of two successive batches of a block each. The forces of an element are summed in double
// precision, and one of its nodes has minus the sum of the others: they add to zero there, so that linear momentum is kept to the
// round-off of double precision. Their torques add to zero to that of single precision only.
#pragma once
#include "components/elasticity/single_rows.h"
#include "framework/fem/model_kernels.h"

namespace stroma {

#if defined(STROMA_HAS_SINGLE_PACKS)

/// A model of ModelKernels whose products do not read the position. `constant_tangent`: its force() leaves it.
template <class Model, bool constant_tangent>
class SingleKernels final : public StoredKernels<StorageOf<Model>> {
  using Base = StoredKernels<StorageOf<Model>>;
  using Base::storage_;
  using Forces = ForceLoops<Model>;
  using Products = ProductLoops<Model>;
  using Tangent = typename Model::template Tangent<Pack>;
  using SingleTangent = typename Model::template Tangent<SinglePack>;
  static constexpr int N = Model::nodes;
  static constexpr std::size_t tangent_numbers = sizeof(Tangent) / sizeof(Pack) * std::size_t(single::lanes);
  static_assert(!Model::reads_position);

 public:
  using Base::Base;
  bool refill() override {
    if (!Base::refill()) return false;
    if (!half_.empty()) round();
    return true;
  }
  void addForce(ConstRows x, Rows f) override {
    const bool keeps = keepsTangents();
    storage_.loop.template run<1, 1>({x}, {f}, [&](Index b, const auto& in, auto& out) {
      Model::force(storage_.rest[b], storage_.tangent[b], in[0], out[0]);
      if (keeps) roundTangent(b);
    });
  }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override {
    const Pack scale(factor);
    const bool keeps = keepsTangents();
    storage_.loop.template run<2, 1>({x, dx}, {f}, [&](Index b, const auto& in, auto& out) {
      Model::forceAndProduct(storage_.rest[b], storage_.tangent[b], scale, in[0], in[1], out[0]);
      if (keeps) roundTangent(b);
    });
  }
  double energy(ConstRows x) const override { return Forces::energy(storage_, x); }
  void addProduct(ConstRows dx, double factor, Rows df) const override {
    Products::addProduct(storage_, {}, dx, factor, df);
  }
  bool hasSingleProduct() const override { return true; }
  void addSingleProduct(ConstRows dx, double factor, Rows df) const override {
    if (half_.empty()) begin();
    dx_.take(dx);
    singleProduct(dx_.data(), factor / dx_.scale(), df.data);
  }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    Products::assemble(storage_, {}, factor, slots, values);
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    Products::assembleDiagonal(storage_, {}, factor, blocks);
  }

 private:
  static Index placeOf(Index block, Index first_batch) { return (first_batch + block) / 2; }
  /// body(place, lower batch, upper batch) of a block; an odd batch at its end is its own upper one.
  template <class Body>
  void forPlaces(Index block, Body&& body) const {
    const std::vector<Index>& start = storage_.loop.blockStart();
    const Index first = start[block], count = start[block + 1] - first, half = (count + 1) / 2, place = placeOf(block, first);
    for (Index i = 0; i < half; ++i) body(place + i, first + 2 * i, first + std::min(2 * i + 1, count - 1));
  }
  /// At the first product in single precision.
  void begin() const {
    const auto& loop = storage_.loop;
    const Index blocks = Index(loop.blockStart().size()) - 1;
    half_.resize(std::size_t(loop.batches()));
    for (Index block = 0; block < blocks; ++block)
      forPlaces(block, [&](Index place, Index lower, Index upper) {
        half_[lower] = 2 * place;
        if (upper != lower) half_[upper] = 2 * place + 1;
      });
    Index first = std::numeric_limits<Index>::max(), last = 0;
    for (Index b = 0; b < loop.batches(); ++b)
      for (int a = 0; a < N * pack_lanes; ++a) {
        const Index row = loop.offset(b, 0)[a] / row_doubles;
        first = std::min(first, row), last = std::max(last, row + 1);
      }
    if (loop.batches() == 0) first = 0;
    dx_.resize(first, last);
    tangent_.assign(std::size_t(placeOf(blocks, loop.batches())) * tangent_numbers, 0.f);
    round();
  }
  void round() const {
    for (Index b = 0; b < storage_.loop.batches(); ++b) roundTangent(b);
  }
  void roundTangent(Index b) const {
    single::convert(storage_.tangent[b], half_[b] % 2, tangent_.data() + std::size_t(half_[b] / 2) * tangent_numbers);
  }
  bool keepsTangents() const { return !constant_tangent && !half_.empty(); }
  /// df += factor * out of one half, the forces of a batch.
  template <int half>
  [[gnu::always_inline]] static void addHalf(const V3<SinglePack> (&out)[N], Pack factor, const Index* offset, double* df) {
    V3<Pack> sum = single::widened<half>(out[1]) * factor;
    addToRows(sum, offset + pack_lanes, df);
#pragma GCC unroll 8
    for (int a = 2; a < N; ++a) {
      const V3<Pack> own = single::widened<half>(out[a]) * factor;
      sum = sum + own;
      addToRows(own, offset + a * pack_lanes, df);
    }
    addToRows(-sum, offset, df);
  }
  /// df += factor K dx. The upper lanes of an odd batch have no stiffness.
  [[gnu::noinline]] void singleProduct(const float* dx, double factor, double* df) const {
    constexpr std::size_t second_level = 1 << 18;  // numbers that it holds beside vectors
    const bool is_far = tangent_.size() > second_level;
    const auto& loop = storage_.loop;
    const typename Model::template Rest<SinglePack> none{};  // is not read
    const auto* tangent = reinterpret_cast<const SingleTangent*>(tangent_.data());
    loop.forEachBlock([&](Index block) __attribute__((flatten)) {
      const single::FlushToZero flush;
      forPlaces(block, [&](Index place, Index lower, Index upper) __attribute__((always_inline)) {
        if (is_far)
          for (std::size_t i = 0; i < tangent_numbers; i += 16)
            _mm_prefetch(tangent_.data() + (std::size_t(place) + 1) * tangent_numbers + i, _MM_HINT_T0);
        V3<SinglePack> in[N], out[N];
        const Index *low = loop.offset(lower, 0), *up = loop.offset(upper, 0);
#pragma GCC unroll 8
        for (int a = 0; a < N; ++a) in[a] = single::gatherRows(dx, {low + a * pack_lanes, up + a * pack_lanes});
        Model::product(none, tangent[place], SinglePack(1.f), in, in, out);
        addHalf<0>(out, Pack(factor), low, df);
        if (upper != lower) addHalf<1>(out, Pack(factor), up, df);
      });
    });
  }

  mutable std::vector<Index> half_;  ///< of each batch: twice its place, and one more in the upper lanes; empty before begin()
  mutable Array<float> tangent_;     ///< shape (places, numbers, lanes)
  mutable single::Rows dx_;
};

#else
template <class Model, bool constant_tangent>
using SingleKernels = ModelKernels<Model>;
#endif

}  // namespace stroma
