// SPDX-License-Identifier: LGPL-2.1-or-later
// From an element's mathematics (a model) to an ElementKernels: storage, loop and assembly are written once here, for
// every element and every method.
#pragma once
#include <cstring>
#include <functional>
#include <memory>
#include <type_traits>

#include "framework/fem/element_kernels.h"
#include "framework/fem/element_loop.h"

namespace stroma {

/// Sets lane `lane` of a struct of packs from the same struct of doubles.
template <class Packs, class Doubles>
void setLane(Packs& batch, int lane, const Doubles& value) {
  constexpr std::size_t count = sizeof(Doubles) / sizeof(double);
  static_assert(sizeof(Packs) == count * sizeof(Pack));
  double numbers[count];
  std::memcpy(numbers, &value, sizeof numbers);
  for (std::size_t i = 0; i < count; ++i)
    std::memcpy(reinterpret_cast<char*>(&batch) + i * sizeof(Pack) + std::size_t(lane) * sizeof(double), &numbers[i], sizeof(double));
}

/// Loop and arrays of a mesh of elements of N nodes, shape (batches). The rest shape and the tangent, which products
/// read, are structs of numbers: of packs and, for one element, of doubles. By these types alone, so that models with
/// the same data share the code that fills it.
template <int N, class RestPacks, class RestDoubles, class TangentPacks, class TangentDoubles, class Coupling>
struct ElementStorage {
  ElementLoop<N, Coupling> loop;
  Array<RestPacks> rest;
  Array<TangentPacks> tangent;

  template <class Set>
  void build(const std::vector<std::array<Index, N>>& cells, const std::vector<Vec3>& position, Index first_row, Set&& set) {
    arrange(cells, position, first_row);
    fill(set);
  }
  void arrange(const std::vector<std::array<Index, N>>& cells, const std::vector<Vec3>& position, Index first_row) {
    loop.build(cells, position, first_row);
    rest.resize(loop.batches());
    tangent.resize(loop.batches());
  }
  /// set(element, is_padding, rest, tangent) gives the numbers of each element; a padding lane must have no stiffness.
  template <class Set>
  void fill(Set&& set) {
    for (Index b = 0; b < loop.batches(); ++b)
      for (int l = 0; l < pack_lanes; ++l) {
        RestDoubles one_rest{};
        TangentDoubles one_tangent{};
        const Index e = loop.elementOf(b, l);
        set(std::size_t(e >= 0 ? e : loop.elementOf(b, 0)), e < 0, one_rest, one_tangent);
        setLane(rest[b], l, one_rest);
        setLane(tangent[b], l, one_tangent);
      }
  }
};

/// The part that does not depend on the model.
template <class StorageType>
class StoredKernels : public ElementKernels {
 public:
  /// Fills rest and tangent of the storage, arranged as it is.
  using Fill = std::function<void(StorageType&)>;
  explicit StoredKernels(StorageType&& storage, Fill fill = {}) : storage_(std::move(storage)), fill_(std::move(fill)) {}
  bool refill() override {
    if (fill_) fill_(storage_);
    return bool(fill_);
  }
  void addPattern(BlockPattern& pattern) const override { storage_.loop.addPattern(pattern); }
  std::vector<Index> slots(const BlockMatrix& matrix) const override { return storage_.loop.slots(matrix); }

 protected:
  /// Owned; the tangent part changes with every force, the rest of it never.
  StorageType storage_;

 private:
  Fill fill_;  ///< empty: refill() is not offered
};

/// A model has
///   nodes, Rest<T>, Tangent<T>   as in ElementStorage
///   reads_position               its products need x itself (of the last force), which is then kept
///   force(rest, tangent, x, f)   f = the nodal forces, and the tangent at x
///   energy(rest, tangent, x)
///   product(rest, tangent, factor, x, dx, df)   df = factor * K dx; x only when reads_position
/// and may have
///   forceAndProduct(rest, tangent, factor, x, dx, f)   f = the forces and factor * K dx, sharing work
///   matrix(rest, tangent, x, k)  which is otherwise made of products
///   diagonal(tangent, k)         its diagonal blocks, where these cost less than the whole
///   Coupling                     pairs of nodes without a block in the matrix (element_loop.h)
///   Forces, Products             models with the same data whose force and energy, or product and matrix, it has:
///                                their loops are then compiled once for all models that name them
template <class Model>
constexpr auto couplingOf() {
  if constexpr (requires { typename Model::Coupling; }) return std::type_identity<typename Model::Coupling>();
  else return std::type_identity<EveryPair>();
}
template <class Model>
constexpr auto forcesOf() {
  if constexpr (requires { typename Model::Forces; }) return std::type_identity<typename Model::Forces>();
  else return std::type_identity<Model>();
}
template <class Model>
constexpr auto productsOf() {
  if constexpr (requires { typename Model::Products; }) return std::type_identity<typename Model::Products>();
  else return std::type_identity<Model>();
}
template <class Model>
using StorageOf = ElementStorage<Model::nodes, typename Model::template Rest<Pack>, typename Model::template Rest<double>,
                                 typename Model::template Tangent<Pack>, typename Model::template Tangent<double>,
                                 typename decltype(couplingOf<Model>())::type>;

/// Force and energy loops of a model. Never inlined: models with the same forces then call one copy, also from a source
/// that declares it extern.
template <class Model>
struct ForceLoops {
  using Storage = StorageOf<Model>;
  [[gnu::noinline]] static void addForce(Storage& storage, ConstRows x, Rows f) {
    storage.loop.template run<1, 1>({x}, {f}, [&](Index b, const auto& in, auto& out) {
      Model::force(storage.rest[b], storage.tangent[b], in[0], out[0]);
    });
  }
  [[gnu::noinline]] static double energy(const Storage& storage, ConstRows x) {
    return storage.loop.sum(x, [&](Index b, const auto& in) { return Model::energy(storage.rest[b], storage.tangent[b], in); });
  }
};

/// Product and assembly loops of a model. `x`: of the last force, empty when the model does not read it.
template <class Model>
struct ProductLoops {
  using Storage = StorageOf<Model>;
  static constexpr int N = Model::nodes;
  using Nodes = V3<Pack>[N];
  using Matrix = typename ElementLoop<N>::Matrix;

  static void addProduct(const Storage& storage, const Vector& x, ConstRows dx, double factor, Rows df) {
    const Pack scale(factor);
    if constexpr (Model::reads_position)
      storage.loop.template run<2, 1>({x.rows(), dx}, {df}, [&](Index b, const auto& in, auto& out) {
        if constexpr (has_matrix)
          Model::product(storage.rest[b], storage.tangent[b], scale, in[0], in[1], out[0]);
        else
          product(storage.rest[b], storage.tangent[b], scale, in[0], in[1], out[0]);
      });
    else
      storage.loop.template run<1, 1>({dx}, {df}, [&](Index b, const auto& in, auto& out) {
        Model::product(storage.rest[b], storage.tangent[b], scale, in[0], in[0], out[0]);
      });
  }
  static void assemble(const Storage& storage, const Vector& x, double factor, const std::vector<Index>& slots,
                       std::vector<double>& values) {
    storage.loop.assemble(factor, slots.data(), values, [&](Index b, Matrix& k) { matrix(storage, x, b, k); });
  }
  static void assembleDiagonal(const Storage& storage, const Vector& x, double factor, std::vector<double>& blocks) {
    if constexpr (has_diagonal)
      storage.loop.addDiagonal(factor, blocks, [&](Index b, auto& k) { Model::diagonal(storage.tangent[b], k); });
    else
      storage.loop.assembleDiagonal(factor, blocks, [&](Index b, Matrix& k) { matrix(storage, x, b, k); });
  }

 private:
  using Rest = typename Model::template Rest<Pack>;
  using Tangent = typename Model::template Tangent<Pack>;
  static constexpr bool has_matrix = requires(const Rest& rest, const Tangent& tangent, const Nodes& x, Matrix& k) {
    Model::matrix(rest, tangent, x, k);
  };
  static constexpr bool has_diagonal = requires(const Tangent& tangent, Pack (&k)[9 * N]) { Model::diagonal(tangent, k); };
  /// Of a model that reads the position and whose matrix is made of products: such products are long, so once for both.
  [[gnu::noipa, gnu::flatten]] static void product(const Rest& rest, const Tangent& tangent, const Pack& factor,
                                                   const Nodes& x, const Nodes& dx, Nodes& df) {
    Model::product(rest, tangent, factor, x, dx, df);
  }
  /// The model's own matrix, else products with the 3 N unit vectors. Long, so once for assembly and diagonal; noipa:
  /// with noinline GCC 12 takes its output for unchanged.
  [[gnu::noipa, gnu::flatten]] static void matrix(const Storage& storage, const Vector& position, Index b, Matrix& k) {
    Nodes x;
    if constexpr (Model::reads_position) storage.loop.gather(b, position.rows(), x);
    const auto& rest = storage.rest[b];
    const auto& tangent = storage.tangent[b];
    if constexpr (has_matrix)
      Model::matrix(rest, tangent, x, k);
    else if constexpr (Model::reads_position)
      ElementLoop<N>::matrixFromProducts([&](const Nodes& dx, Nodes& df) { product(rest, tangent, Pack(1.), x, dx, df); }, k);
    else
      ElementLoop<N>::matrixFromProducts([&](const Nodes& dx, Nodes& df) { Model::product(rest, tangent, Pack(1.), x, dx, df); }, k);
  }
};
/// The ElementKernels of a model. `x` handed to a model is that of the last force, and only valid when it reads it.
template <class Model>
class ModelKernels final : public StoredKernels<StorageOf<Model>> {
  using Base = StoredKernels<StorageOf<Model>>;
  using Base::storage_;
  using Forces = ForceLoops<typename decltype(forcesOf<Model>())::type>;
  using Products = ProductLoops<typename decltype(productsOf<Model>())::type>;
  static constexpr int N = Model::nodes;
  using Nodes = V3<Pack>[N];
  /// The model has a form of its own for force and product together.
  static constexpr bool fuses = requires(typename Model::template Rest<Pack> & rest,
                                         typename Model::template Tangent<Pack>& tangent, Nodes& nodes) {
    Model::forceAndProduct(rest, tangent, Pack(1.), nodes, nodes, nodes);
  };

 public:
  using Base::Base;
  void addForce(ConstRows x, Rows f) override {
    keep(x);
    Forces::addForce(storage_, x, f);
  }
  /// In one loop where that shares work or the gathers weigh. Models that read the position do more in each half.
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override {
    if constexpr (Model::reads_position && !fuses) {
      addForce(x, f);
      addProduct(dx, factor, f);
    } else {
      const Pack scale(factor);
      keep(x);
      storage_.loop.template run<2, 1>({x, dx}, {f},
                                       [&](Index b, const auto& in, auto& out) { forceAndProduct(b, scale, in[0], in[1], out[0]); });
    }
  }
  double energy(ConstRows x) const override { return Forces::energy(storage_, x); }
  void addProduct(ConstRows dx, double factor, Rows df) const override { Products::addProduct(storage_, x_, dx, factor, df); }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    Products::assemble(storage_, x_, factor, slots, values);
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    Products::assembleDiagonal(storage_, x_, factor, blocks);
  }

 private:
  /// Remembers x where products need it: 32 bytes per node instead of a tangent of its own in each element.
  void keep(ConstRows x) {
    if constexpr (Model::reads_position) {
      if (x_.count() != x.count) x_.resize(x.count);
      copy(x, x_);
    }
  }
  /// The model's own fused form, else force and product one after the other.
  void forceAndProduct(Index b, Pack factor, const Nodes& x, const Nodes& dx, Nodes& f) {
    auto& rest = storage_.rest[b];
    auto& tangent = storage_.tangent[b];
    if constexpr (fuses) {
      Model::forceAndProduct(rest, tangent, factor, x, dx, f);
    } else {
      Nodes df;
      Model::force(rest, tangent, x, f);
      Model::product(rest, tangent, factor, x, dx, df);
      for (int a = 0; a < N; ++a) f[a] = f[a] + df[a];
    }
  }
  Vector x_;  ///< of the last force
};

}  // namespace stroma
