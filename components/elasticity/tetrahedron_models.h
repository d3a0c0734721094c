// SPDX-License-Identifier: LGPL-2.1-or-later
// The methods of a tetrahedral mesh: models for ModelKernels (model_kernels.h), and warping by node, which is none
// because its rotations belong to nodes.
#pragma once
#include "components/elasticity/fan_blocks.h"
#include "components/elasticity/nodal_warping.h"
#include "components/elasticity/tetrahedron_corotational.h"
#include "framework/fem/model_kernels.h"

namespace stroma::tetrahedron {

/// What most models share: the tangent holds world gradients, those of the rest shape until a force sets others.
struct Model {
  static constexpr int nodes = 4;
  static constexpr bool reads_position = false;
  template <class T>
  using Rest = RestGradients<T>;
  template <class T>
  using Tangent = tetrahedron::Tangent<T>;

  template <class T>
  static void product(const auto&, const auto& t, T factor, const V3<T> (&)[4], const V3<T> (&dx)[4], V3<T> (&df)[4]) {
    stiffnessProduct(t, factor, dx, df);
  }
};

/// Forces and energy of Own::strain(rest, t, x), (mu V_0)^1/2 eps. It may bring the gradients of t to those at x.
template <class Own>
struct ByStrain : Model {
  static void ofFan(const auto& rest, const auto& t, const V3<Pack> (&x)[fan_nodes], auto& k) {
    fanMatrix<WarpedBlocks<Pack>>(rest, t, x, k);
  }
  template <class T>
  static void force(const auto& rest, tetrahedron::Tangent<T>& t, const V3<T> (&x)[4], V3<T> (&f)[4]) {
    nodalForces(restoringStress(Own::strain(rest, t, x), t.ratio, T(1.)), t.g, f);
  }
  template <class T>
  static T energy(const auto& rest, auto t, const V3<T> (&x)[4]) {
    return storedEnergy(Own::strain(rest, t, x), t.ratio, T(1.));
  }
};

/// method = small: the strain of sum e_i (x) g_i - I with the rest gradients.
struct Linear : ByStrain<Linear> {
  template <class T>
  using Rest = RestRoot<T>;
  template <class T>
  static S3<T> strain(const Rest<T>& rest, const auto& t, const V3<T> (&x)[4]) {
    return strainFrom(rest, t, Edges(x).e);
  }
  // ---- for FanKernels ----
  static constexpr bool turns = false, keeps_differences = false, stress_turns = false;
  template <class T>
  static S3<T> strainFrom(const Rest<T>& rest, const auto& t, const V3<T> (&edges)[3]) {
    return strainOfKinematics<Update::none>(edges, t.g, rest.root);
  }
};

/// method = large, polar, svd with the warped tangent.
template <class Rotation, Update update>
struct Corotational : ByStrain<Corotational<Rotation, update>> {
  static constexpr bool long_force = true;
  template <class T>
  using Rest = RestOf<update, T>;
  template <class T>
  using Tangent = tetrahedron::Tangent<T>;
  template <class T>
  static S3<T> strain(const Rest<T>& rest, auto& t, const V3<T> (&x)[4]) {
    V3<T> d[3];
    turn(rest, t, Edges(x).e, d);
    return strainFrom(rest, t, d);
  }
  // ---- for FanKernels ----
  static constexpr bool turns = true, keeps_differences = update != Update::none;
  static constexpr bool stress_turns = std::is_same_v<Rotation, rotation::Svd> && update == Update::none;
  template <class T>
  static void turn(const Rest<T>& rest, auto& t, const V3<T> (&edges)[3], V3<T> (&d)[3]) {
    const auto k = kinematics<Rotation, update>(rest, edges);
    t.g = {k.g.g1 * rest.root, k.g.g2 * rest.root, k.g.g3 * rest.root};
    for (int i = 0; i < 3; ++i) d[i] = k.d[i];
  }
  template <class T>
  static S3<T> strainFrom(const Rest<T>& rest, const auto& t, const V3<T> (&d)[3]) {
    return strainOfKinematics<update>(d, t.g, rest.root);
  }
};

/// The same with the exact tangent: dR and dg are differentiated at the x of the last force.
template <class Rotation, Update update>
struct ExactCorotational : Model {
  static constexpr bool reads_position = true;
  template <class T>
  using Rest = RestOf<update, T>;
  template <class T>
  using Tangent = Constants<T>;
  template <class T>
  static void force(const Rest<T>& rest, const Constants<T>& t, const V3<T> (&x)[4], V3<T> (&f)[4]) {
    const auto k = kinematics<Rotation, update>(rest, x);
    nodalForces(restoringStress(strainOfKinematics<update>(k.d, k.g, T(1.)), t.lambda, t.mu), k.g, f);
  }
  template <class T>
  static T energy(const Rest<T>& rest, const Constants<T>& t, const V3<T> (&x)[4]) {
    const auto k = kinematics<Rotation, update>(rest, x);
    return storedEnergy(strainOfKinematics<update>(k.d, k.g, T(1.)), t.lambda, t.mu);
  }
  template <class T>
  static void product(const Rest<T>& rest, const Constants<T>& t, T factor, const V3<T> (&x)[4], const V3<T> (&dx)[4],
                      V3<T> (&df)[4]) {
    exactProduct<Rotation, update>(rest, factor * t.lambda, factor * t.mu, x, dx, df);
  }
};

/// method = green: St. Venant-Kirchhoff, F = sum e_i (x) G_i with the rest gradients, f_i = -V_0 F S G_i.
struct Green : Model {
  static constexpr bool reads_position = true;
  template <class T>
  using Tangent = Constants<T>;
  static void ofFan(const auto& rest, const auto& t, const V3<Pack> (&x)[fan_nodes], auto& k) {
    fanMatrix<GreenBlocks<Pack>>(rest, t, x, k);
  }
  template <class T>
  static void force(const Rest<T>& rest, const Constants<T>& t, const V3<T> (&x)[4], V3<T> (&f)[4]) {
    columnForces(greenStress(outerSum(Edges(x).e, rest.g), T(1.), t.lambda, t.mu), rest.g, f);
  }
  template <class T>
  static T energy(const Rest<T>& rest, const Constants<T>& t, const V3<T> (&x)[4]) {
    return storedEnergy(greenStrain(outerSum(Edges(x).e, rest.g), T(1.)), t.lambda, t.mu);
  }
  template <class T>
  static void product(const Rest<T>& rest, const Constants<T>& t, T factor, const V3<T> (&x)[4], const V3<T> (&dx)[4],
                      V3<T> (&df)[4]) {
    const M3<T> f = outerSum(Edges(x).e, rest.g), dgradient = outerSum(Edges(dx).e, rest.g);
    columnForces(greenStressDifferential(f, dgradient, T(1.), factor * t.lambda, factor * t.mu), rest.g, df);
  }

 private:
  /// f_i = p g_i, f_a = -sum
  template <class T>
  static void columnForces(const M3<T>& p, const Gradients<T>& g, V3<T> (&f)[4]) {
    f[1] = p * g.g1, f[2] = p * g.g2, f[3] = p * g.g3;
    f[0] = -(f[1] + f[2] + f[3]);
  }
};

/// method = nodal.
/// The tangent holds the rest gradients in world axes, and no force changes it: what turns belongs to the nodes.
struct NodalModel : Model {
  template <class T>
  using Rest = RestVolume<T>;
  template <class T>
  using Tangent = WorldGradients<T>;
};
/// Warping by node (nodal_warping.h). Kept here: the rotations of the nodes at the last force, as three vectors of
/// columns over the rows of the system.
class NodalWarping final : public StoredKernels<StorageOf<NodalModel>> {
 public:
  using StoredKernels::StoredKernels;
  void addForce(ConstRows x, Rows f) override {
    updateNodeRotations(x);
    storage_.loop.run<4, 1>({x, r0_.rows(), r1_.rows(), r2_.rows()}, {f}, [&](Index b, const auto& in, auto& out) {
      const WorldGradients<Pack>& t = storage_.tangent[b];
      const M3<Pack> r[4] = {nodeRotation(in, 0), nodeRotation(in, 1), nodeRotation(in, 2), nodeRotation(in, 3)};
      nodalWarpingForce(t.g, t.lambda, t.mu, in[0], r, out[0]);
    });
  }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override {
    addForce(x, f);
    addProduct(dx, factor, f);
  }
  /// The energy of each element in the frame of its mean nodal rotation: for monitoring, not the potential of the
  /// force.
  double energy(ConstRows x) const override {
    return storage_.loop.sum(x, [&](Index b, const auto& in) {
      const WorldGradients<Pack>& t = storage_.tangent[b];
      const V3<Pack> e[3] = {in[1] - in[0], in[2] - in[0], in[3] - in[0]};
      const M3<Pack> f = outerSum(e, t.g);
      const S3<Pack> strain = minusIdentity(strainOfProduct(f, rotation::Svd::of(f)));
      return storedEnergy(strain, t.lambda, t.mu);
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
    storage_.loop.assemble(factor, slots.data(), values, [&](Index b, auto& k) { matrix(b, k); });
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    storage_.loop.assembleDiagonal(factor, blocks, [&](Index b, auto& k) { matrix(b, k); });
  }

 private:
  /// Rotation of node a from the three gathered columns (inputs 1 to 3 of the loop).
  template <class In>
  static M3<Pack> nodeRotation(const In& in, int a) {
    return {in[1][a], in[2][a], in[3][a]};
  }
  void product(Index b, Pack factor, const V3<Pack> (&dx)[4], const M3<Pack> (&r)[4], V3<Pack> (&df)[4]) const {
    const WorldGradients<Pack>& t = storage_.tangent[b];
    nodalWarpingProduct(t.g, factor * t.lambda, factor * t.mu, dx, r, df);
  }
  /// K of a batch by products with unit vectors, at the node rotations of the last force.
  void matrix(Index b, ElementLoop<4>::Matrix& k) const {
    V3<Pack> c0[4], c1[4], c2[4];
    storage_.loop.gather(b, r0_.rows(), c0), storage_.loop.gather(b, r1_.rows(), c1),
        storage_.loop.gather(b, r2_.rows(), c2);
    const M3<Pack> r[4] = {{c0[0], c1[0], c2[0]}, {c0[1], c1[1], c2[1]}, {c0[2], c1[2], c2[2]}, {c0[3], c1[3], c2[3]}};
    ElementLoop<4>::matrixFromProducts(
        [&](const V3<Pack>(&dx)[4], V3<Pack>(&df)[4]) { product(b, Pack(1.), dx, r, df); }, k);
  }
  /// R_i: the nearest rotation of the mean of F over the elements around node i, weighted by volume.
  void updateNodeRotations(ConstRows x) {
    for (Vector* column : {&r0_, &r1_, &r2_}) {
      if (column->count() != x.count) column->resize(x.count);
      clear(*column);
    }
    storage_.loop.run<1, 3>({x}, {r0_.rows(), r1_.rows(), r2_.rows()}, [&](Index b, const auto& in, auto& out) {
      const WorldGradients<Pack>& t = storage_.tangent[b];
      const V3<Pack> e[3] = {in[0][1] - in[0][0], in[0][2] - in[0][0], in[0][3] - in[0][0]};
      const Pack weight = abs(Pack(1.) / storage_.rest[b].inverse_six_volume);
      // a padding lane repeats an element and has no stiffness: it must not count twice
      const auto padding = t.mu == Pack(0.);
      const M3<Pack> f = outerSum(e, t.g) * select(padding, Pack(0.), weight);
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
