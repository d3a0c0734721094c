// SPDX-License-Identifier: LGPL-2.1-or-later
// The methods of a corotational tetrahedral mesh behind one interface: chosen once, called once a mesh. A method adds
// forces and products with its own element mathematics; storage and loop are shared.
#pragma once
#include <memory>

#include "framework/fem/corotational_tetrahedron.h"
#include "framework/fem/element_loop.h"
#include "framework/fem/nodal_warping.h"

namespace stroma::tetrahedron {

/// Arrays of one batch: what a product reads. 88 bytes an element, 104 with the node numbers.
struct alignas(64) TangentBatch {
  double g[9][pack_lanes];                    ///< gradients g_1, g_2, g_3 [1/m]
  double lambda[pack_lanes], mu[pack_lanes];  ///< Lame's constants times V_0 [J]
};
/// What a force reads besides: the rest shape.
struct alignas(64) RestBatch {
  double inverse[6][pack_lanes], edges[6][pack_lanes], inverse_six_volume[pack_lanes];
};

inline Gradients<Pack> loadGradients(const TangentBatch& t) {
  const auto vector = [&](int i) {
    return V3<Pack>{Pack::load_aligned(t.g[i]), Pack::load_aligned(t.g[i + 1]), Pack::load_aligned(t.g[i + 2])};
  };
  return {vector(0), vector(3), vector(6)};
}
inline void storeGradients(const Gradients<Pack>& g, TangentBatch& t) {
  const auto store = [&](const V3<Pack>& v, int i) {
    v.x.store_aligned(t.g[i]), v.y.store_aligned(t.g[i + 1]), v.z.store_aligned(t.g[i + 2]);
  };
  store(g.g1, 0), store(g.g2, 3), store(g.g3, 6);
}
inline Rest<Pack> loadRest(const RestBatch& r) {
  Rest<Pack> rest;
  for (int i = 0; i < 6; ++i) rest.inverse[i] = Pack::load_aligned(r.inverse[i]);
  for (int i = 0; i < 6; ++i) rest.edges[i] = Pack::load_aligned(r.edges[i]);
  rest.inverse_six_volume = Pack::load_aligned(r.inverse_six_volume);
  return rest;
}

/// The mesh of a method: loop and arrays, shape (batches).
struct Storage {
  ElementLoop<4> loop;
  Array<TangentBatch> tangent;  ///< gradients at the last force evaluation; world rest gradients before the first
  Array<RestBatch> rest;
};

class Method {
 public:
  explicit Method(Storage& storage) : storage_(storage) {}
  virtual ~Method() = default;
  virtual void addForce(ConstRows x, Rows f) = 0;
  virtual void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f, Rows df) = 0;
  virtual double energy(ConstRows x) const = 0;
  /// The product of one batch; the tangent of the last addForce.
  virtual void addProduct(ConstRows dx, double factor, Rows df) const = 0;
  virtual void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const = 0;
  virtual void assembleDiagonal(double factor, std::vector<double>& blocks) const = 0;

 protected:
  Storage& storage_;
};

/// Products with the stored gradients: what all methods with a warped or a constant tangent share.
class StoredTangent : public Method {
 public:
  using Method::Method;
  void addProduct(ConstRows dx, double factor, Rows df) const override {
    const Pack scale(factor);
    storage_.loop.run<1, 1>({dx}, {df},
                            [&](Index b, const auto& in, auto& out) { batchProduct(b, scale, in[0], out[0]); });
  }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    storage_.loop.assemble(factor, slots, values,
                           [&](Index b, const auto& dx, auto& df) { batchProduct(b, Pack(1.), dx, df); });
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    storage_.loop.assembleDiagonal(factor, blocks,
                                   [&](Index b, const auto& dx, auto& df) { batchProduct(b, Pack(1.), dx, df); });
  }

 protected:
  void batchProduct(Index b, Pack factor, const V3<Pack> (&dx)[4], V3<Pack> (&df)[4]) const {
    const TangentBatch& t = storage_.tangent[std::size_t(b)];
    stiffnessProduct(loadGradients(t), factor * Pack::load_aligned(t.lambda), factor * Pack::load_aligned(t.mu), dx,
                     df);
  }
};

/// method = small: the strain of sum e_i (x) g_i - I with the rest gradients.
class Linear final : public StoredTangent {
 public:
  using StoredTangent::StoredTangent;
  void addForce(ConstRows x, Rows f) override {
    storage_.loop.run<1, 1>({x}, {f}, [&](Index b, const auto& in, auto& out) { force(b, in[0], out[0]); });
  }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f, Rows df) override {
    const Pack scale(factor);
    storage_.loop.runBoth(
        x, f, dx, df, [&](Index b, const auto& in, auto& out) { force(b, in, out); },
        [&](Index b, const auto& in, auto& out) { batchProduct(b, scale, in, out); });
  }
  double energy(ConstRows x) const override {
    return storage_.loop.sum(x, [&](Index b, const auto& in) {
      const TangentBatch& t = storage_.tangent[std::size_t(b)];
      return storedEnergy(strain(in, loadGradients(t)), Pack::load_aligned(t.lambda), Pack::load_aligned(t.mu));
    });
  }

 private:
  static S3<Pack> strain(const V3<Pack> (&x)[4], const Gradients<Pack>& g) {
    const V3<Pack> e[3] = {x[1] - x[0], x[2] - x[0], x[3] - x[0]};
    return minusIdentity(strainOf(e, g));
  }
  void force(Index b, const V3<Pack> (&x)[4], V3<Pack> (&f)[4]) const {
    const TangentBatch& t = storage_.tangent[std::size_t(b)];
    const Gradients<Pack> g = loadGradients(t);
    nodalForces(restoringStress(strain(x, g), Pack::load_aligned(t.lambda), Pack::load_aligned(t.mu)), g, f);
  }
};

/// Element by element: a rotation of its own and, if asked, B from the current shape.
template <class Rotation, Update update>
class Corotational : public StoredTangent {
 public:
  using StoredTangent::StoredTangent;
  void addForce(ConstRows x, Rows f) override {
    storage_.loop.run<1, 1>({x}, {f}, [&](Index b, const auto& in, auto& out) { force(b, in[0], out[0]); });
  }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f, Rows df) override {
    const Pack scale(factor);
    storage_.loop.runBoth(
        x, f, dx, df, [&](Index b, const auto& in, auto& out) { force(b, in, out); },
        [&](Index b, const auto& in, auto& out) { batchProduct(b, scale, in, out); });
  }
  double energy(ConstRows x) const override {
    return storage_.loop.sum(x, [&](Index b, const auto& in) {
      const TangentBatch& t = storage_.tangent[std::size_t(b)];
      const auto k = kinematics<Rotation, update>(loadRest(storage_.rest[std::size_t(b)]), in);
      return storedEnergy(k.strain, Pack::load_aligned(t.lambda), Pack::load_aligned(t.mu));
    });
  }

 protected:
  void force(Index b, const V3<Pack> (&x)[4], V3<Pack> (&f)[4]) {
    TangentBatch& t = storage_.tangent[std::size_t(b)];
    const auto k = kinematics<Rotation, update>(loadRest(storage_.rest[std::size_t(b)]), x);
    storeGradients(k.g, t);
    nodalForces(restoringStress(k.strain, Pack::load_aligned(t.lambda), Pack::load_aligned(t.mu)), k.g, f);
  }
};

/// The same with the exact tangent: dR and dg are differentiated at the x of the last force, which is kept.
template <class Rotation, Update update>
class ExactCorotational final : public Corotational<Rotation, update> {
  using Base = Corotational<Rotation, update>;
  using Base::storage_;

 public:
  using Base::Base;
  void addForce(ConstRows x, Rows f) override {
    keep(x);
    Base::addForce(x, f);
  }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f, Rows df) override {
    addForce(x, f);
    addProduct(dx, factor, df);
  }
  void addProduct(ConstRows dx, double factor, Rows df) const override {
    const Pack scale(factor);
    storage_.loop.template run<2, 1>(
        {x_.rows(), dx}, {df}, [&](Index b, const auto& in, auto& out) { product(b, scale, in[0], in[1], out[0]); });
  }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    storage_.loop.assemble(factor, slots, values, [&](Index b, const auto& dx, auto& df) { productAtKept(b, dx, df); });
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    storage_.loop.assembleDiagonal(factor, blocks,
                                   [&](Index b, const auto& dx, auto& df) { productAtKept(b, dx, df); });
  }

 private:
  void keep(ConstRows x) {
    if (x_.count() != x.count) x_.resize(x.count);
    copy(x, x_);
  }
  void product(Index b, Pack factor, const V3<Pack> (&x)[4], const V3<Pack> (&dx)[4], V3<Pack> (&df)[4]) const {
    const TangentBatch& t = storage_.tangent[std::size_t(b)];
    exactProduct<Rotation, update>(loadRest(storage_.rest[std::size_t(b)]), factor * Pack::load_aligned(t.lambda),
                                   factor * Pack::load_aligned(t.mu), x, dx, df);
  }
  void productAtKept(Index b, const V3<Pack> (&dx)[4], V3<Pack> (&df)[4]) const {
    V3<Pack> x[4];
    storage_.loop.gather(b, x_.rows(), x);
    product(b, Pack(1.), x, dx, df);
  }
  Vector x_;
};

/// method = nodal.
class NodalWarping final : public Method {
 public:
  using Method::Method;
  void addForce(ConstRows x, Rows f) override {
    updateNodeRotations(x);
    storage_.loop.run<4, 1>({x, r0_.rows(), r1_.rows(), r2_.rows()}, {f}, [&](Index b, const auto& in, auto& out) {
      const TangentBatch& t = storage_.tangent[std::size_t(b)];
      const M3<Pack> r[4] = {nodeRotation(in, 0), nodeRotation(in, 1), nodeRotation(in, 2), nodeRotation(in, 3)};
      nodalWarpingForce(loadGradients(t), Pack::load_aligned(t.lambda), Pack::load_aligned(t.mu), in[0], r, out[0]);
    });
  }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f, Rows df) override {
    addForce(x, f);
    addProduct(dx, factor, df);
  }
  /// The energy of each element in the frame of its mean nodal rotation: for monitoring, not the potential of the
  /// force.
  double energy(ConstRows x) const override {
    return storage_.loop.sum(x, [&](Index b, const auto& in) {
      const TangentBatch& t = storage_.tangent[std::size_t(b)];
      const V3<Pack> e[3] = {in[1] - in[0], in[2] - in[0], in[3] - in[0]};
      const M3<Pack> f = outerSum(e, loadGradients(t));
      const S3<Pack> strain = minusIdentity(strainOfProduct(f, rotation::Svd::of(f)));
      return storedEnergy(strain, Pack::load_aligned(t.lambda), Pack::load_aligned(t.mu));
    });
  }
  void addProduct(ConstRows dx, double factor, Rows df) const override {
    const Pack scale(factor);
    storage_.loop.run<4, 1>({dx, r0_.rows(), r1_.rows(), r2_.rows()}, {df}, [&](Index b, const auto& in, auto& out) {
      const M3<Pack> r[4] = {nodeRotation(in, 0), nodeRotation(in, 1), nodeRotation(in, 2), nodeRotation(in, 3)};
      product(b, scale, in[0], r, out[0]);
    });
  }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    storage_.loop.assemble(factor, slots, values, [&](Index b, const auto& dx, auto& df) { productAtKept(b, dx, df); });
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    storage_.loop.assembleDiagonal(factor, blocks,
                                   [&](Index b, const auto& dx, auto& df) { productAtKept(b, dx, df); });
  }

 private:
  template <class In>
  static M3<Pack> nodeRotation(const In& in, int a) {
    return {in[1][a], in[2][a], in[3][a]};
  }
  void product(Index b, Pack factor, const V3<Pack> (&dx)[4], const M3<Pack> (&r)[4], V3<Pack> (&df)[4]) const {
    const TangentBatch& t = storage_.tangent[std::size_t(b)];
    nodalWarpingProduct(loadGradients(t), factor * Pack::load_aligned(t.lambda), factor * Pack::load_aligned(t.mu), dx,
                        r, df);
  }
  void productAtKept(Index b, const V3<Pack> (&dx)[4], V3<Pack> (&df)[4]) const {
    V3<Pack> c0[4], c1[4], c2[4];
    storage_.loop.gather(b, r0_.rows(), c0), storage_.loop.gather(b, r1_.rows(), c1),
        storage_.loop.gather(b, r2_.rows(), c2);
    const M3<Pack> r[4] = {{c0[0], c1[0], c2[0]}, {c0[1], c1[1], c2[1]}, {c0[2], c1[2], c2[2]}, {c0[3], c1[3], c2[3]}};
    product(b, Pack(1.), dx, r, df);
  }
  /// R_i: the nearest rotation of the mean of F over the elements around node i, weighted by volume.
  void updateNodeRotations(ConstRows x) {
    for (Vector* column : {&r0_, &r1_, &r2_}) {
      if (column->count() != x.count) column->resize(x.count);
      clear(*column);
    }
    storage_.loop.run<1, 3>({x}, {r0_.rows(), r1_.rows(), r2_.rows()}, [&](Index b, const auto& in, auto& out) {
      const TangentBatch& t = storage_.tangent[std::size_t(b)];
      const V3<Pack> e[3] = {in[0][1] - in[0][0], in[0][2] - in[0][0], in[0][3] - in[0][0]};
      const Pack weight = abs(Pack(1.) / Pack::load_aligned(storage_.rest[std::size_t(b)].inverse_six_volume));
      // a padding lane repeats an element and has no stiffness: it must not count twice
      const auto padding = Pack::load_aligned(t.mu) == Pack(0.);
      const M3<Pack> f = outerSum(e, loadGradients(t)) * select(padding, Pack(0.), weight);
      for (int a = 0; a < 4; ++a) out[0][a] = f.c0, out[1][a] = f.c1, out[2][a] = f.c2;
    });
    for (Index row = 0; row < x.count; ++row) {
      const auto column = [&](Vector& v) { return V3<double>{v[row].x(), v[row].y(), v[row].z()}; };
      const M3<double> f{column(r0_), column(r1_), column(r2_)};
      const double size = squaredNorm(f);
      if (size == 0) continue;  // a node of no element
      const M3<double> r = rotation::Svd::of(f * (1 / std::sqrt(size)));
      r0_[row] = Vec3(r.c0.x, r.c0.y, r.c0.z), r1_[row] = Vec3(r.c1.x, r.c1.y, r.c1.z),
      r2_[row] = Vec3(r.c2.x, r.c2.y, r.c2.z);
    }
  }
  Vector r0_, r1_, r2_;  ///< columns of the nodes' rotations
};

}  // namespace stroma::tetrahedron
