// SPDX-License-Identifier: LGPL-2.1-or-later
// The kernels of TetrahedronPorousForceField, whose page has the formulas: a sponge with fluid in its pores.
#pragma once
#include "components/hyperelasticity/hyperelastic_invariants.h"
#include "framework/fem/fan_model.h"

namespace stroma::porous {

using std::log;

/// sigma_H(J), its slope and its integral, and ln J with its slope, all with the tangent below J_0.
struct Sponge {
  double fluid = 0.5, bulk = 400, limit = 2200;  ///< f_w, K_0 [Pa], K_lim [Pa]

  double bound() const { return 1 - fluid + bulk / limit; }  ///< J_0
  template <class T>
  T stress(T j) const {
    const T at = maximum(j, T(bound()));
    return T(bulk * fluid) * log((at + T(fluid - 1)) * T(1 / fluid)) + T(fluid * limit) * (j - at);
  }
  template <class T>
  T slope(T j) const {
    return T(bulk * fluid) / (maximum(j, T(bound())) + T(fluid - 1));
  }
  template <class T>
  T energy(T j) const {
    const T at = maximum(j, T(bound())), u = at + T(fluid - 1), below = j - at;
    const T whole = T(bulk * fluid) * (u * log(u * T(1 / fluid)) - u + T(fluid));
    return whole + below * (stress(at) + T(0.5 * fluid * limit) * below);
  }
  template <class T>
  T logarithm(T j) const {
    const T at = maximum(j, T(bound()));
    return log(at) + (j - at) / at;
  }
  template <class T>
  T logarithmSlope(T j) const {
    return T(1.) / maximum(j, T(bound()));
  }
};

/// Areas a_i = V_0 cof F G_i of a tetrahedron's vertices 1..3 and J.
template <class T>
struct Shape {
  V3<T> a[3];
  T j;
  Shape(const V3<T> (&e)[3], T sixth, T inverse_six_volume)
      : a{cross(e[1], e[2]) * sixth, cross(e[2], e[0]) * sixth, cross(e[0], e[1]) * sixth},
        j(dot(e[0], cross(e[1], e[2])) * inverse_six_volume) {}
};

/// A model of fans (fan_model.h): sigma of each tetrahedron stands in its tangent.
struct Porous {
  static constexpr int nodes = 4;
  static constexpr bool reads_position = true;
  template <class T>
  struct Rest {
    T sixth;               ///< 1/6 over the mesh's overlap, with the sign of the order of the vertices; 0 for padding
    T inverse_six_volume;  ///< with the same sign [1/m^3]
    T inverse_volume;      ///< 1/V_0, V_0 over the overlap [1/m^3]
    T quarter_volume;      ///< V_0/4; 0 for padding [m^3]
  };
  template <class T>
  struct Tangent {
    T stress;     ///< sigma_H - P [Pa]
    T stiffness;  ///< dsigma/dJ / V_0 [Pa/m^3], of the element alone, for products
    T assembled;  ///< the same for matrices
    T root;       ///< (d ln J/dJ)^1/2
  };
  template <class T>
  static void forces(const V3<T> (&a)[3], T factor, V3<T> (&f)[4]) {
    f[1] = a[0] * factor, f[2] = a[1] * factor, f[3] = a[2] * factor;
    f[0] = -(f[1] + f[2] + f[3]);
  }
  template <class T>
  static void product(const Rest<T>& rest, const Tangent<T>& t, T factor, const V3<T> (&x)[4], const V3<T> (&dx)[4],
                      V3<T> (&df)[4]) {
    const tetrahedron::Edges<T> edges(x), changes(dx);
    const V3<T>(&e)[3] = edges.e, (&d)[3] = changes.e;
    const Shape<T> shape(e, rest.sixth, rest.inverse_six_volume);
    const T volume_change = dot(shape.a[0], d[0]) + dot(shape.a[1], d[1]) + dot(shape.a[2], d[2]);
    const T normal = -factor * t.stiffness * volume_change, held = -factor * t.stress * rest.sixth;
    df[1] = shape.a[0] * normal + (cross(d[1], e[2]) + cross(e[1], d[2])) * held;
    df[2] = shape.a[1] * normal + (cross(d[2], e[0]) + cross(e[2], d[0])) * held;
    df[3] = shape.a[2] * normal + (cross(d[0], e[1]) + cross(e[0], d[1])) * held;
    df[0] = -(df[1] + df[2] + df[3]);
  }
};
using PorousFan = tetrahedron::FanOf<Porous>;
using tetrahedron::corner;
using tetrahedron::fan_size;

/// Where the tangent is that of fluid which stays in each element.
struct OwnFluid {
  bool products = false, matrices = false;
};

/// Element loops. What belongs to nodes (pressures, shares of a volume) is the x of a row.
class PorousElements {
  using Loop = decltype(StorageOf<PorousFan>::loop);
  using Nodes = Loop::Nodes;
  using Matrix = Loop::Matrix;

 public:
  PorousElements(StorageOf<PorousFan>&& storage, const Sponge& sponge)
      : storage_(std::move(storage)), sponge_(sponge) {}
  void addPattern(BlockPattern& pattern) const { storage_.loop.addPattern(pattern); }
  std::vector<Index> slots(const BlockMatrix& matrix) const { return storage_.loop.slots(matrix); }

  /// Forces at x under the pressures of nodes.
  void addForce(ConstRows x, ConstRows pressure, OwnFluid own_fluid, Rows f) {
    if (x_.count() != x.count) x_.resize(x.count);
    copy(x, x_);
    storage_.loop.run<2, 1>({x, pressure}, {f}, [&](Index b, const auto& in, auto& out) {
      forEachTetrahedron(b, in[0], out[0], [&](int i, const Shape<Pack>& shape, auto& rest, V3<Pack>(&own)[4]) {
        auto& t = storage_.tangent[b].of[i];
        t.stress = sponge_.stress(shape.j) - mean(in[1], i);
        const Pack slope = sponge_.logarithmSlope(shape.j), tissue = sponge_.slope(shape.j);
        const Pack both = tissue + Pack(sponge_.limit) * slope;
        t.stiffness = (own_fluid.products ? both : tissue) * rest.inverse_volume;
        t.assembled = (own_fluid.matrices ? both : tissue) * rest.inverse_volume;
        t.root = sqrt(slope);
        Porous::forces(shape.a, -t.stress, own);
      });
    });
  }
  /// theta_a += factor V_0/4 ln J
  void addVolumes(ConstRows x, double factor, Rows theta) const {
    storage_.loop.run<1, 1>({x}, {theta}, [&](Index b, const auto& in, auto& out) {
      forEachTetrahedron(b, in[0], out[0], [&](int, const Shape<Pack>& shape, auto& rest, V3<Pack>(&own)[4]) {
        share(Pack(factor) * sponge_.logarithm(shape.j) * rest.quarter_volume, own);
      });
    });
  }
  /// theta_a += sum_e w_e^1/2 dV_e/4 for nodes that move by dx from the x of the last force, w_e = d ln J/dJ.
  void addVolumeChanges(ConstRows dx, Rows theta) const {
    storage_.loop.run<2, 1>({x_.rows(), dx}, {theta}, [&](Index b, const auto& in, auto& out) {
      forEachTetrahedron(b, in[0], out[0], [&](int i, const Shape<Pack>& shape, auto&, V3<Pack>(&own)[4]) {
        const Nodes& d = in[1];
        const Pack change = dot(shape.a[0], d[corner(i, 1)] - d[0]) + dot(shape.a[1], d[corner(i, 2)] - d[0]) +
                            dot(shape.a[2], d[corner(i, 3)] - d[0]);
        share(Pack(0.25) * storage_.tangent[b].of[i].root * change, own);
      });
    });
  }
  /// f += factor times the forces of w_e^1/2 times the pressures of nodes, at the x of the last force.
  void addPressureForces(ConstRows pressure, double factor, Rows f) const {
    storage_.loop.run<2, 1>({x_.rows(), pressure}, {f}, [&](Index b, const auto& in, auto& out) {
      forEachTetrahedron(b, in[0], out[0], [&](int i, const Shape<Pack>& shape, auto&, V3<Pack>(&own)[4]) {
        Porous::forces(shape.a, Pack(factor) * storage_.tangent[b].of[i].root * mean(in[1], i), own);
      });
    });
  }
  /// The potential of sigma_H, and of pressures that do not change, above the rest shape.
  double energy(ConstRows x, ConstRows pressure) const {
    if (energies_.count() != x.count) energies_.resize(x.count);
    clear(energies_);
    storage_.loop.run<2, 1>({x, pressure}, {energies_}, [&](Index b, const auto& in, auto& out) {
      forEachTetrahedron(b, in[0], out[0], [&](int i, const Shape<Pack>& shape, auto& rest, V3<Pack>(&own)[4]) {
        const Pack density = sponge_.energy(shape.j) - mean(in[1], i) * (shape.j - Pack(1.));
        share(density * rest.quarter_volume, own);
      });
    });
    double sum = 0;
    for (Index i = 0; i < x.count; ++i) sum += energies_[i].x();
    return sum;
  }

  ConstRows positions() const { return x_; }  ///< of the last force
  void addProduct(ConstRows dx, double factor, Rows df) const {
    const Pack scale(factor);
    storage_.loop.run<2, 1>({x_.rows(), dx}, {df}, [&](Index b, const auto& in, auto& out) {
      PorousFan::product(storage_.rest[b], storage_.tangent[b], scale, in[0], in[1], out[0]);
    });
  }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const {
    storage_.loop.assemble(factor, slots, values, [&](Index b, Matrix& k) { matrix(b, k); });
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const {
    storage_.loop.assembleDiagonal(factor, blocks, [&](Index b, Matrix& k) { matrix(b, k); });
  }

 private:
  /// body(i, shape, rest, own) for the tetrahedra of batch b; own is added to the nodes' out.
  template <class Body>
  void forEachTetrahedron(Index b, const Nodes& x, Nodes& out, Body&& body) const {
    for (auto& node : out) node = {};
    for (int i = 0; i < fan_size; ++i) {
      const auto& rest = storage_.rest[b].of[i];
      const V3<Pack> e[3] = {x[corner(i, 1)] - x[0], x[corner(i, 2)] - x[0], x[corner(i, 3)] - x[0]};
      V3<Pack> own[4];
      body(i, Shape<Pack>(e, rest.sixth, rest.inverse_six_volume), rest, own);
      for (int a = 0; a < 4; ++a) out[corner(i, a)] = out[corner(i, a)] + own[a];
    }
  }
  static Pack mean(const Nodes& of, int i) {
    return Pack(0.25) * (of[0].x + of[1].x + of[corner(i, 2)].x + of[corner(i, 3)].x);
  }
  static void share(Pack value, V3<Pack> (&own)[4]) {
    for (auto& node : own) node.x = value;
  }
  /// -stiffness a_i (x) a_j - stress/6 times the crossed edges that face i and j.
  void matrix(Index b, Matrix& k) const {
    Nodes x;
    storage_.loop.gather(b, x_.rows(), x);
    for (Pack& value : k) value = Pack(0.);
    for (int i = 0; i < fan_size; ++i) {
      const auto& rest = storage_.rest[b].of[i];
      const auto& t = storage_.tangent[b].of[i];
      const V3<Pack> e[3] = {x[corner(i, 1)] - x[0], x[corner(i, 2)] - x[0], x[corner(i, 3)] - x[0]};
      const Shape<Pack> shape(e, rest.sixth, rest.inverse_six_volume);
      const V3<Pack> a[4] = {-(shape.a[0] + shape.a[1] + shape.a[2]), shape.a[0], shape.a[1], shape.a[2]};
      const Pack held = t.stress * rest.sixth;
      const V3<Pack> c[3] = {e[0] * held, e[1] * held, e[2] * held};
      const V3<Pack> w[4][4] = {{{}, c[2] - c[1], c[0] - c[2], c[1] - c[0]},
                                {c[1] - c[2], {}, c[2], -c[1]},
                                {c[2] - c[0], -c[2], {}, c[0]},
                                {c[0] - c[1], c[1], -c[0], {}}};
      for (int p = 0; p < 4; ++p)
        for (int q = 0; q < 4; ++q) {
          Pack* out = k + (corner(i, p) * tetrahedron::fan_nodes + corner(i, q)) * 9;
          const V3<Pack> n = a[p] * (-t.assembled), &m = a[q], &v = w[p][q];
          out[0] += n.x * m.x, out[1] += n.x * m.y - v.z, out[2] += n.x * m.z + v.y;
          out[3] += n.y * m.x + v.z, out[4] += n.y * m.y, out[5] += n.y * m.z - v.x;
          out[6] += n.z * m.x - v.y, out[7] += n.z * m.y + v.x, out[8] += n.z * m.z;
        }
    }
  }
  StorageOf<PorousFan> storage_;
  Sponge sponge_;
  Vector x_;                 ///< of the last force
  mutable Vector energies_;  ///< work space
};

}  // namespace stroma::porous
