// SPDX-License-Identifier: LGPL-2.1-or-later
// Kernels of residual_stress.h. Over edges e_k of an element (of a tetrahedron those from its first node, of a
// hexahedron at each point the derivatives j_k along its axes) F = sum_k e_k (x) G_k and
//   k_ik = w G_i . H G_k,   forces on e_i: -sum_k k_ik e_k,   energy = 1/2 sum_ik k_ik e_i . e_k = w/2 H : C
// with w the point's volume at rest: six numbers per point for force and product alike.
#include "components/hyperelasticity/residual_stress.h"
#include "components/hyperelasticity/hyperelastic_tetrahedron.h"
#include "framework/fem/hexahedron.h"
#include "framework/scene/factory.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

template <class T>
struct PointRest {
  elastic::Gradients<T> g;  ///< [1/m]
  T volume;                 ///< w [m^3]
};

template <class T>
S3<T> stiffnessOf(const PointRest<T>& rest, const S3<T>& h) {
  const V3<T>&a = rest.g.g1, &b = rest.g.g2, &c = rest.g.g3;
  const V3<T> ha = (h * a) * rest.volume, hb = (h * b) * rest.volume, hc = (h * c) * rest.volume;
  using stroma::dot;
  return {dot(a, ha), dot(b, hb), dot(c, hc), dot(a, hb), dot(b, hc), dot(c, ha)};
}
/// out_i = sum_k k_ik e_k
template <class T>
void multiply(const S3<T>& k, const V3<T> (&e)[3], V3<T> (&out)[3]) {
  out[0] = fma(k.xx, e[0], fma(k.xy, e[1], e[2] * k.zx));
  out[1] = fma(k.xy, e[0], fma(k.yy, e[1], e[2] * k.yz));
  out[2] = fma(k.zx, e[0], fma(k.yz, e[1], e[2] * k.zz));
}
PointRest<double> pointOf(const Mat3& edges, const Mat3& axes, double volume) {
  const M3<double> g = fromEigen(axes.transpose() * edges.inverse().transpose());
  return {{g.c0, g.c1, g.c2}, volume};
}

// ---- tetrahedra, in fans ----

struct Held {
  static constexpr int nodes = 4;
  static constexpr bool reads_position = false;
  template <class T>
  using Rest = PointRest<T>;
  template <class T>
  struct Tangent {
    S3<T> k;  ///< [N/m]
  };
  template <class T>
  static void product(const Rest<T>&, const Tangent<T>& t, T factor, const V3<T> (&)[4], const V3<T> (&dx)[4],
                      V3<T> (&df)[4]) {
    const tetrahedron::Edges<T> edges(dx);
    V3<T> f[3];
    multiply(t.k * (-factor), edges.e, f);
    df[1] = f[0], df[2] = f[1], df[3] = f[2];
    df[0] = -(f[0] + f[1] + f[2]);
  }
  template <class T>
  static void force(const Rest<T>& rest, Tangent<T>& t, const V3<T> (&x)[4], V3<T> (&f)[4]) {
    product(rest, t, T(1.), x, x, f);
  }
  template <class T>
  static T energy(const Rest<T>&, const Tangent<T>& t, const V3<T> (&x)[4]) {
    const tetrahedron::Edges<T> edges(x);
    V3<T> f[3];
    multiply(t.k, edges.e, f);
    using stroma::dot;
    return T(0.5) * (dot(f[0], edges.e[0]) + dot(f[1], edges.e[1]) + dot(f[2], edges.e[2]));
  }
};

struct HeldFan : tetrahedron::FanOf<Held> {
  static constexpr int points = tetrahedron::fan_size;  ///< of an element of the loop
  using Nodes = V3<Pack>[nodes];
  static void hold(const Rest<Pack>& rest, int i, const S3<Pack>& h, Tangent<Pack>& t) {
    t.of[i].k = stiffnessOf(rest.of[i], h);
  }
  static void deformations(const Rest<Pack>& rest, const Nodes& n, M3<Pack> (&f)[points]) {
    for (int i = 0; i < points; ++i) {
      const V3<Pack> e[3] = {n[1] - n[0], n[2 + i] - n[0], n[3 + i] - n[0]};
      f[i] = elastic::outerSum(e, rest.of[i].g);
    }
  }
  /// Multiples of the identity.
  static void matrix(const Tangent<Pack>& t, Pack (&k)[nodes * nodes * 9]) {
    for (Pack& value : k) value = Pack(0.);
    for (int i = 0; i < points; ++i) {
      const S3<Pack>& h = t.of[i].k;
      const Pack x = h.xx + h.xy + h.zx, y = h.xy + h.yy + h.yz, z = h.zx + h.yz + h.zz;
      const Pack own[4][4] = {
          {x + y + z, -x, -y, -z}, {-x, h.xx, h.xy, h.zx}, {-y, h.xy, h.yy, h.yz}, {-z, h.zx, h.yz, h.zz}};
      for (int a = 0; a < 4; ++a)
        for (int c = 0; c < 4; ++c) {
          Pack* block = k + (tetrahedron::corner(i, a) * nodes + tetrahedron::corner(i, c)) * 9;
          for (int d : {0, 4, 8}) block[d] -= own[a][c];
        }
    }
  }
};

// ---- hexahedra, at 2x2x2 points ----

struct HeldHexahedron {
  static constexpr int nodes = 8, points = 8;
  static constexpr bool reads_position = false;
  using Nodes = V3<Pack>[nodes];
  template <class T>
  struct Rest {
    PointRest<T> of[points];  ///< of 8 j against 8 X (hexahedron.h)
  };
  template <class T>
  struct Tangent {
    S3<T> k[points];  ///< [N/m]
  };
  template <class T>
  static void product(const Rest<T>&, const Tangent<T>& t, T factor, const V3<T> (&)[8], const V3<T> (&dx)[8],
                      V3<T> (&df)[8]) {
    const auto j = hexahedron::atPoints(hexahedron::modesOf(dx));
    hexahedron::PointValues<T> forces;
    for (int p = 0; p < points; ++p) {
      V3<T> f[3];
      multiply(t.k[p] * (-factor), hexahedron::Columns<T>(j, p).d, f);
      hexahedron::addColumns(f[0], f[1], f[2], p, forces);
    }
    hexahedron::nodesOf(hexahedron::fromPoints(forces), df);
  }
  template <class T>
  static T energy(const Rest<T>&, const Tangent<T>& t, const V3<T> (&x)[8]) {
    const auto j = hexahedron::atPoints(hexahedron::modesOf(x));
    T sum(0.);
    for (int p = 0; p < points; ++p) {
      const hexahedron::Columns<T> e(j, p);
      V3<T> f[3];
      multiply(t.k[p], e.d, f);
      using stroma::dot;
      sum += T(0.5) * (dot(f[0], e.d[0]) + dot(f[1], e.d[1]) + dot(f[2], e.d[2]));
    }
    return sum;
  }
  static void hold(const Rest<Pack>& rest, int p, const S3<Pack>& h, Tangent<Pack>& t) {
    t.k[p] = stiffnessOf(rest.of[p], h);
  }
  static void deformations(const Rest<Pack>& rest, const Nodes& n, M3<Pack> (&f)[points]) {
    const auto j = hexahedron::atPoints(hexahedron::modesOf(n));
    for (int p = 0; p < points; ++p) f[p] = elastic::outerSum(hexahedron::Columns<Pack>(j, p).d, rest.of[p].g);
  }
  /// Multiples of the identity: three nodes a product, as the components do not meet.
  static void matrix(const Tangent<Pack>& t, Pack (&k)[nodes * nodes * 9]) {
    for (Pack& value : k) value = Pack(0.);
    for (int first = 0; first < nodes; first += 3) {
      Nodes unit{}, f;
      unit[first].x = Pack(1.);
      if (first + 1 < nodes) unit[first + 1].y = Pack(1.);
      if (first + 2 < nodes) unit[first + 2].z = Pack(1.);
      product(Rest<Pack>{}, t, Pack(1.), unit, unit, f);
      for (int a = 0; a < nodes; ++a) {
        const Pack value[3] = {f[a].x, f[a].y, f[a].z};
        for (int c = 0; c < 3 && first + c < nodes; ++c)
          for (int d : {0, 4, 8}) k[(a * nodes + first + c) * 9 + d] = value[c];
      }
    }
  }
};

// ---- both ----

/// Numbers of points to lanes and back.
template <class Model>
class ResidualPoints final : public StoredKernels<StorageOf<Model>>, public ResidualStress {
  using Base = StoredKernels<StorageOf<Model>>;
  using Base::storage_;
  using Loop = decltype(StorageOf<Model>::loop);
  using Nodes = typename Loop::Nodes;
  using Matrix = typename Loop::Matrix;
  static constexpr int points = Model::points;

 public:
  /// pointOf(element of the loop, i) is the number of its point i in lists of points, -1 where it has none.
  template <class PointOf>
  ResidualPoints(StorageOf<Model>&& storage, std::size_t count, PointOf&& pointOf)
      : Base(std::move(storage)), count_(count) {
    for (Index b = 0; b < storage_.loop.batches(); ++b)
      for (int i = 0; i < points; ++i)
        for (int l = 0; l < pack_lanes; ++l) {
          const Index element = storage_.loop.elementOf(b, l);
          point_.push_back(element >= 0 ? pointOf(std::size_t(element), std::size_t(i)) : -1);
        }
  }

  ElementKernels& forces() override { return *this; }
  void hold(const std::vector<double>& stress) override {
    storage_.loop.forEachBatch([&](Index b) {
      for (int i = 0; i < points; ++i) {
        alignas(64) double lane[6][pack_lanes];
        for (int l = 0; l < pack_lanes; ++l) {
          const Index point = pointAt(b, i, l);
          for (int k = 0; k < 6; ++k) lane[k][l] = point >= 0 ? stress[6 * std::size_t(point) + std::size_t(k)] : 0;
        }
        const auto pack = [&](int k) { return Pack::load_aligned(lane[k]); };
        Model::hold(storage_.rest[b], i, S3<Pack>{pack(0), pack(1), pack(2), pack(3), pack(4), pack(5)},
                    storage_.tangent[b]);
      }
    });
  }
  void deformations(ConstRows x, std::vector<double>& out) const override {
    out.resize(9 * count_);
    storage_.loop.forEachBatch([&](Index b) {
      Nodes n;
      M3<Pack> f[points];
      storage_.loop.gather(b, x, n);
      Model::deformations(storage_.rest[b], n, f);
      for (int i = 0; i < points; ++i) {
        const V3<Pack>* column[3] = {&f[i].c0, &f[i].c1, &f[i].c2};
        alignas(64) double lane[9][pack_lanes];
        for (int c = 0; c < 3; ++c)
          column[c]->x.store_aligned(lane[3 * c]), column[c]->y.store_aligned(lane[3 * c + 1]),
              column[c]->z.store_aligned(lane[3 * c + 2]);
        for (int l = 0; l < pack_lanes; ++l)
          if (const Index point = pointAt(b, i, l); point >= 0)
            for (int k = 0; k < 9; ++k) out[9 * std::size_t(point) + std::size_t(k)] = lane[k][l];
      }
    });
  }

  void addForce(ConstRows x, Rows f) override { addProduct(x, 1, f); }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override {
    addProduct(x, 1, f);
    addProduct(dx, factor, f);
  }
  double energy(ConstRows x) const override {
    return storage_.loop.sum(
        x, [&](Index b, const Nodes& in) { return Model::energy(storage_.rest[b], storage_.tangent[b], in); });
  }
  void addProduct(ConstRows dx, double factor, Rows df) const override {
    const Pack scale(factor);
    storage_.loop.template run<1, 1>({dx}, {df}, [&](Index b, const auto& in, auto& out) {
      Model::product(storage_.rest[b], storage_.tangent[b], scale, in[0], in[0], out[0]);
    });
  }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    storage_.loop.assemble(factor, slots.data(), values, [&](Index b, Matrix& k) { Model::matrix(storage_.tangent[b], k); });
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    storage_.loop.assembleDiagonal(factor, blocks, [&](Index b, Matrix& k) { Model::matrix(storage_.tangent[b], k); });
  }

 private:
  Index pointAt(Index b, int i, int l) const {
    return point_[(std::size_t(b) * points + std::size_t(i)) * pack_lanes + std::size_t(l)];
  }
  std::size_t count_;
  std::vector<Index> point_;  ///< shape (batches, points, lanes), -1: padding
};

std::unique_ptr<ResidualStress> heldTetrahedra(const Cells& cells) {
  using namespace tetrahedron;
  const std::vector<tetrahedron::Fan> fans = gatherFans(cells.mesh->tetrahedra, cells.rest->size());
  const auto nodes = nodesOf(fans);
  StorageOf<HeldFan> storage;
  storage.build(nodes, *cells.rest, cells.first_row, [&](std::size_t f, bool padding, auto& rest, auto&) {
    for (int i = 0; i < fan_size; ++i) {
      const Index e = fans[f].element[i];
      const auto at = [&](int a) -> const Vec3& { return (*cells.rest)[nodes[f][(corner(i, a))]]; };
      Mat3 edges;
      edges << at(1) - at(0), at(2) - at(0), at(3) - at(0);
      const double volume = padding || e < 0 ? 0 : std::abs(edges.determinant()) / (6 * cells.mesh->overlap);
      rest.of[i] = pointOf(edges, cells.axes(std::size_t(e >= 0 ? e : fans[f].element[0])), volume);
    }
  });
  return std::make_unique<ResidualPoints<HeldFan>>(std::move(storage), cells.mesh->tetrahedra.size(),
                                                   [&](std::size_t f, std::size_t i) { return fans[f].element[i]; });
}

std::unique_ptr<ResidualStress> heldHexahedra(const Cells& cells) {
  StorageOf<HeldHexahedron> storage;
  storage.build(cells.mesh->hexahedra, *cells.rest, cells.first_row,
                [&](std::size_t cell, bool padding, auto& rest, auto&) {
                  V3<double> x[8];
                  for (std::size_t a = 0; a < 8; ++a) x[a] = vectorOf((*cells.rest)[cells.mesh->hexahedra[cell][a]]);
                  const auto j = hexahedron::atPoints(hexahedron::modesOf(x));
                  for (int p = 0; p < 8; ++p) {
                    const Mat3 edges = toEigen(hexahedron::Columns<double>(j, p).matrix());
                    const double volume = padding ? 0 : std::abs(edges.determinant()) / (512 * cells.mesh->overlap);
                    rest.of[p] = pointOf(edges, cells.axes(cell), volume);
                  }
                });
  return std::make_unique<ResidualPoints<HeldHexahedron>>(
      std::move(storage), 8 * cells.mesh->hexahedra.size(),
      [](std::size_t cell, std::size_t p) { return Index(8 * cell + p); });
}

}  // namespace

STROMA_COMPONENT(residual_stress) {
  if (residualStressKernels().tetrahedra) return;
  residualStressKernels().tetrahedra = heldTetrahedra;
  residualStressKernels().hexahedra = heldHexahedra;
}
