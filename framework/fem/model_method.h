// SPDX-License-Identifier: LGPL-2.1-or-later
// From an element's mathematics (a model) to an ElementMethod: storage, loop and assembly are written once here, for
// every element and every method.
#pragma once
#include <cstring>
#include <memory>

#include "framework/fem/elastic_variant.h"
#include "framework/fem/element_loop.h"
#include "framework/fem/element_method.h"
#include "framework/fem/rotation.h"

namespace stroma {

/// Sets lane `lane` of a struct of packs from the same struct of doubles.
template <class Packs, class Doubles>
void setLane(Packs& batch, int lane, const Doubles& value) {
  constexpr std::size_t count = sizeof(Doubles) / sizeof(double);
  static_assert(sizeof(Packs) == count * sizeof(Pack));
  double numbers[count];
  std::memcpy(numbers, &value, sizeof numbers);
  for (std::size_t i = 0; i < count; ++i)
    std::memcpy(reinterpret_cast<char*>(&batch) + i * sizeof(Pack) + std::size_t(lane) * sizeof(double), &numbers[i],
                sizeof(double));
}

/// Loop and arrays of a mesh of elements of N nodes, shape (batches). The rest shape and the tangent, which products
/// read, are structs of numbers: of packs and, for one element, of doubles. By these types alone, so that models with
/// the same data share the code that fills it.
template <int N, class RestPacks, class RestDoubles, class TangentPacks, class TangentDoubles, class Coupling>
struct ElementStorage {
  ElementLoop<N, Coupling> loop;
  Array<RestPacks> rest;
  Array<TangentPacks> tangent;

  /// set(element, is_padding, rest, tangent) gives the numbers of each element; a padding lane must have no stiffness.
  template <class Set>
  void build(const std::vector<std::array<Index, N>>& cells, const std::vector<Vec3>& position, Index first_row,
             Set&& set) {
    loop.build(cells, position, first_row);
    rest.resize(std::size_t(loop.batches()));
    tangent.resize(std::size_t(loop.batches()));
    for (Index b = 0; b < loop.batches(); ++b)
      for (int l = 0; l < pack_lanes; ++l) {
        RestDoubles one_rest{};
        TangentDoubles one_tangent{};
        const Index e = loop.elementOf(b, l);
        set(std::size_t(e >= 0 ? e : loop.elementOf(b, 0)), e < 0, one_rest, one_tangent);
        setLane(rest[std::size_t(b)], l, one_rest);
        setLane(tangent[std::size_t(b)], l, one_tangent);
      }
  }
};

/// The part that does not depend on what an element computes.
template <class StorageType>
class StoredMethod : public ElementMethod {
 public:
  explicit StoredMethod(StorageType&& storage) : storage_(std::move(storage)) {}
  void addPattern(BlockPattern& pattern) const override { storage_.loop.addPattern(pattern); }
  std::vector<Index> slots(const BlockMatrix& matrix) const override { return storage_.loop.slots(matrix); }

 protected:
  /// Owned; the tangent part changes with every force, the rest of it never.
  StorageType storage_;
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
///   Coupling                     pairs of nodes without a block in the matrix (element_loop.h)
template <class Model>
struct CouplingOf {
  using type = EveryPair;
};
template <class Model>
requires requires { typename Model::Coupling; }
struct CouplingOf<Model> {
  using type = typename Model::Coupling;
};
template <class Model>
using StorageOf = ElementStorage<Model::nodes, typename Model::template Rest<Pack>,
                                 typename Model::template Rest<double>, typename Model::template Tangent<Pack>,
                                 typename Model::template Tangent<double>, typename CouplingOf<Model>::type>;

/// The ElementMethod of a model. `x` handed to a model is that of the last force, and only valid when it reads it.
template <class Model>
class ModelMethod final : public StoredMethod<StorageOf<Model>> {
  using Base = StoredMethod<StorageOf<Model>>;
  using Base::storage_;
  static constexpr int N = Model::nodes;
  using Nodes = V3<Pack>[N];
  using Matrix = typename ElementLoop<N>::Matrix;
  /// The model has a form of its own for force and product together.
  static constexpr bool fuses = requires(typename Model::template Rest<Pack> & rest,
                                         typename Model::template Tangent<Pack>& tangent, Nodes& nodes) {
    Model::forceAndProduct(rest, tangent, Pack(1.), nodes, nodes, nodes);
  };

 public:
  using Base::Base;
  void addForce(ConstRows x, Rows f) override {
    keep(x);
    storage_.loop.template run<1, 1>({x}, {f}, [&](Index b, const auto& in, auto& out) { force(b, in[0], out[0]); });
  }
  /// In one loop where that shares work or the gathers weigh. Models that read the position do more in each half.
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override {
    if constexpr (Model::reads_position && !fuses) {
      addForce(x, f);
      addProduct(dx, factor, f);
    } else {
      const Pack scale(factor);
      keep(x);
      storage_.loop.template run<2, 1>(
          {x, dx}, {f}, [&](Index b, const auto& in, auto& out) { forceAndProduct(b, scale, in[0], in[1], out[0]); });
    }
  }
  double energy(ConstRows x) const override {
    return storage_.loop.sum(x, [&](Index b, const auto& in) {
      return Model::energy(storage_.rest[std::size_t(b)], storage_.tangent[std::size_t(b)], in);
    });
  }
  void addProduct(ConstRows dx, double factor, Rows df) const override {
    const Pack scale(factor);
    if constexpr (Model::reads_position)
      storage_.loop.template run<2, 1>(
          {x_.rows(), dx}, {df}, [&](Index b, const auto& in, auto& out) { product(b, scale, in[0], in[1], out[0]); });
    else
      storage_.loop.template run<1, 1>(
          {dx}, {df}, [&](Index b, const auto& in, auto& out) { product(b, scale, in[0], in[0], out[0]); });
  }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    storage_.loop.assemble(factor, slots, values, [&](Index b, Matrix& k) { matrix(b, k); });
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    storage_.loop.assembleDiagonal(factor, blocks, [&](Index b, Matrix& k) { matrix(b, k); });
  }

 private:
  /// Remembers x where products need it: 32 bytes a node instead of a tangent of its own in each element.
  void keep(ConstRows x) {
    if constexpr (Model::reads_position) {
      if (x_.count() != x.count) x_.resize(x.count);
      copy(x, x_);
    }
  }
  void force(Index b, const Nodes& x, Nodes& f) {
    Model::force(storage_.rest[std::size_t(b)], storage_.tangent[std::size_t(b)], x, f);
  }
  /// The model's own fused form, else force and product one after the other.
  void forceAndProduct(Index b, Pack factor, const Nodes& x, const Nodes& dx, Nodes& f) {
    auto& rest = storage_.rest[std::size_t(b)];
    auto& tangent = storage_.tangent[std::size_t(b)];
    if constexpr (fuses) {
      Model::forceAndProduct(rest, tangent, factor, x, dx, f);
    } else {
      Nodes df;
      Model::force(rest, tangent, x, f);
      Model::product(rest, tangent, factor, x, dx, df);
      for (int a = 0; a < N; ++a) f[a] = f[a] + df[a];
    }
  }
  void product(Index b, Pack factor, const Nodes& x, const Nodes& dx, Nodes& df) const {
    Model::product(storage_.rest[std::size_t(b)], storage_.tangent[std::size_t(b)], factor, x, dx, df);
  }
  /// The model's own matrix, else products with the 3 N unit vectors. Long, so once for assembly and diagonal; noipa:
  /// with noinline GCC 12 takes its output for unchanged.
  [[gnu::noipa, gnu::flatten]] void matrix(Index b, Matrix& k) const {
    Nodes x;
    if constexpr (Model::reads_position) storage_.loop.gather(b, x_.rows(), x);
    if constexpr (requires { Model::matrix(storage_.rest[0], storage_.tangent[0], x, k); })
      Model::matrix(storage_.rest[std::size_t(b)], storage_.tangent[std::size_t(b)], x, k);
    else
      ElementLoop<N>::matrixFromProducts([&](const Nodes& dx, Nodes& df) { product(b, Pack(1.), x, dx, df); }, k);
  }
  Vector x_;  ///< of the last force
};

/// make.operator()<Rotation, update>() for the rotation and the update of a variant: chosen once, outside all loops.
template <class Make>
std::unique_ptr<ElementMethod> makeRotated(const ElasticVariant& variant, Make&& make) {
  using elastic::Update;
  const auto updated = [&]<class Rotation>() {
    switch (variant.update) {
      case Update::none:
        return make.template operator()<Rotation, Update::none>();
      case Update::strain_displacement:
        return make.template operator()<Rotation, Update::strain_displacement>();
      default:
        return make.template operator()<Rotation, Update::strain_displacement_and_volume>();
    }
  };
  if (variant.method == ElasticMethod::large) return updated.template operator()<rotation::Qr>();
  if (variant.method == ElasticMethod::polar) return updated.template operator()<rotation::Polar>();
  return updated.template operator()<rotation::Svd>();
}

/// A method whose products go through its own assembled matrix, refreshed with every force unless K is constant.
/// Pays where a solve takes many products of one K: 76 bytes a block instead of an element's work.
class KeptMatrix final : public ElementMethod {
 public:
  KeptMatrix(std::unique_ptr<ElementMethod> method, bool constant) : method_(std::move(method)), constant_(constant) {}
  void addForce(ConstRows x, Rows f) override {
    method_->addForce(x, f);
    refresh(x.count);
  }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override {
    addForce(x, f);
    addProduct(dx, factor, f);
  }
  double energy(ConstRows x) const override { return method_->energy(x); }
  void addProduct(ConstRows dx, double factor, Rows df) const override { matrix_.multiplyAdd(factor, dx, df); }
  void addPattern(BlockPattern& pattern) const override { method_->addPattern(pattern); }
  std::vector<Index> slots(const BlockMatrix& matrix) const override { return method_->slots(matrix); }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    method_->assemble(factor, slots, values);
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    method_->assembleDiagonal(factor, blocks);
  }

 private:
  /// Lays the matrix out at the first force and fills it; later only where K can have changed.
  void refresh(Index rows) {
    const bool first = matrix_.rows() != rows;
    if (first) {
      BlockPattern pattern(rows);
      method_->addPattern(pattern);
      matrix_ = BlockMatrix(std::move(pattern));
      slots_ = method_->slots(matrix_);
    }
    if (!first && constant_) return;
    matrix_.clear();
    method_->assemble(1, slots_, matrix_.values());
  }
  /// The method whose K is kept; computes forces and energies.
  std::unique_ptr<ElementMethod> method_;
  bool constant_;
  /// K at the x of the last force, over all rows of the system.
  BlockMatrix matrix_;
  std::vector<Index> slots_;
};

/// `method` itself, or wrapped where the scene asked for assembling; K is constant only for small strains.
inline std::unique_ptr<ElementMethod> withOwnMatrix(const ElasticVariant& variant,
                                                    std::unique_ptr<ElementMethod> method) {
  if (!variant.own_matrix) return method;
  return std::make_unique<KeptMatrix>(std::move(method), variant.method == ElasticMethod::small);
}

}  // namespace stroma
