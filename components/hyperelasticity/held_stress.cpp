// SPDX-License-Identifier: LGPL-2.1-or-later
// Kernels of held_stress.h for tetrahedra. With k_ij = V_0 G_i . H G_j over the edges e_j = x_j - x_0, i, j = 1..3,
//   f_i = -sum_j k_ij e_j,   f_0 = -sum_i f_i,   energy = 1/2 sum_ij k_ij e_i . e_j = V_0/2 H : C
// six numbers an element for force and product alike.
#include "framework/fem/held_stress.h"
#include "framework/fem/hyperelastic_tetrahedron.h"
#include "framework/scene/factory.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

struct Held {
  static constexpr int nodes = 4;
  static constexpr bool reads_position = false;
  template <class T>
  struct Rest {
    elastic::Gradients<T> g;  ///< [1/m]
    T volume;                 ///< V_0 [m^3]
  };
  template <class T>
  struct Tangent {
    S3<T> k;  ///< [N/m]
  };
  template <class T>
  static void hold(const Rest<T>& rest, const S3<T>& h, Tangent<T>& t) {
    const V3<T>&a = rest.g.g1, &b = rest.g.g2, &c = rest.g.g3;
    const V3<T> ha = (h * a) * rest.volume, hb = (h * b) * rest.volume, hc = (h * c) * rest.volume;
    using stroma::dot;
    t.k = {dot(a, ha), dot(b, hb), dot(c, hc), dot(a, hb), dot(b, hc), dot(c, ha)};
  }
  template <class T>
  static void product(const Rest<T>&, const Tangent<T>& t, T factor, const V3<T> (&)[4], const V3<T> (&dx)[4],
                      V3<T> (&df)[4]) {
    const S3<T> k = t.k * (-factor);
    const tetrahedron::Edges<T> edges(dx);
    const V3<T>(&e)[3] = edges.e;
    df[1] = fma(k.xx, e[0], fma(k.xy, e[1], e[2] * k.zx));
    df[2] = fma(k.xy, e[0], fma(k.yy, e[1], e[2] * k.yz));
    df[3] = fma(k.zx, e[0], fma(k.yz, e[1], e[2] * k.zz));
    df[0] = -(df[1] + df[2] + df[3]);
  }
  template <class T>
  static void force(const Rest<T>& rest, Tangent<T>& t, const V3<T> (&x)[4], V3<T> (&f)[4]) {
    product(rest, t, T(1.), x, x, f);
  }
  template <class T>
  static T energy(const Rest<T>& rest, const Tangent<T>& t, const V3<T> (&x)[4]) {
    V3<T> f[4];
    product(rest, t, T(1.), x, x, f);
    const tetrahedron::Edges<T> edges(x);
    using stroma::dot;
    return T(-0.5) * (dot(f[1], edges.e[0]) + dot(f[2], edges.e[1]) + dot(f[3], edges.e[2]));
  }
};
using HeldFan = tetrahedron::FanOf<Held>;

StorageOf<HeldFan> storageOf(const Cells& cells, const std::vector<tetrahedron::Fan>& fans) {
  std::vector<std::array<Index, tetrahedron::fan_nodes>> nodes;
  for (const auto& fan : fans) nodes.push_back(fan.nodes);
  StorageOf<HeldFan> storage;
  storage.build(nodes, *cells.rest, cells.first_row, [&](std::size_t f, bool padding, auto& rest, auto&) {
    for (int i = 0; i < tetrahedron::fan_size; ++i) {
      const Index e = fans[f].element[std::size_t(i)];
      const auto at = [&](int a) -> const Vec3& {
        return (*cells.rest)[std::size_t(nodes[f][std::size_t(tetrahedron::corner(i, a))])];
      };
      Mat3 edges;
      edges << at(1) - at(0), at(2) - at(0), at(3) - at(0);
      const Mat3 axes = cells.axes(std::size_t(e >= 0 ? e : fans[f].element[0]));
      const M3<double> g = fromEigen(axes.transpose() * edges.inverse().transpose());
      rest.of[i].g = {g.c0, g.c1, g.c2};
      rest.of[i].volume = padding || e < 0 ? 0 : std::abs(edges.determinant()) / (6 * cells.mesh->overlap);
    }
  });
  return storage;
}

/// Numbers of cells to lanes and back.
class HeldTetrahedra final : public StoredMethod<StorageOf<HeldFan>>, public HeldStress {
  using Loop = decltype(StorageOf<HeldFan>::loop);
  using Nodes = Loop::Nodes;
  using Matrix = Loop::Matrix;

 public:
  HeldTetrahedra(const Cells& cells, const std::vector<tetrahedron::Fan>& fans)
      : StoredMethod(storageOf(cells, fans)), cells_(cells.mesh->tetrahedra.size()) {
    for (Index b = 0; b < storage_.loop.batches(); ++b)
      for (int i = 0; i < tetrahedron::fan_size; ++i)
        for (int l = 0; l < pack_lanes; ++l) {
          const Index f = storage_.loop.elementOf(b, l);
          cell_.push_back(f >= 0 ? fans[std::size_t(f)].element[std::size_t(i)] : -1);
        }
  }

  ElementMethod& forces() override { return *this; }
  void hold(const std::vector<double>& stress) override {
    storage_.loop.forEachBatch([&](Index b) {
      for (int i = 0; i < tetrahedron::fan_size; ++i) {
        alignas(64) double lane[6][pack_lanes];
        for (int l = 0; l < pack_lanes; ++l) {
          const Index cell = cellOf(b, i, l);
          for (int k = 0; k < 6; ++k) lane[k][l] = cell >= 0 ? stress[6 * std::size_t(cell) + std::size_t(k)] : 0;
        }
        const auto pack = [&](int k) { return Pack::load_aligned(lane[k]); };
        Held::hold(storage_.rest[std::size_t(b)].of[i], S3<Pack>{pack(0), pack(1), pack(2), pack(3), pack(4), pack(5)},
                   storage_.tangent[std::size_t(b)].of[i]);
      }
    });
  }
  void deformations(ConstRows x, std::vector<double>& out) const override {
    out.resize(9 * cells_);
    storage_.loop.forEachBatch([&](Index b) {
      Nodes n;
      storage_.loop.gather(b, x, n);
      for (int i = 0; i < tetrahedron::fan_size; ++i) {
        const V3<Pack> e[3] = {n[1] - n[0], n[2 + i] - n[0], n[3 + i] - n[0]};
        const M3<Pack> f = elastic::outerSum(e, storage_.rest[std::size_t(b)].of[i].g);
        const V3<Pack>* column[3] = {&f.c0, &f.c1, &f.c2};
        alignas(64) double lane[9][pack_lanes];
        for (int c = 0; c < 3; ++c)
          column[c]->x.store_aligned(lane[3 * c]), column[c]->y.store_aligned(lane[3 * c + 1]),
              column[c]->z.store_aligned(lane[3 * c + 2]);
        for (int l = 0; l < pack_lanes; ++l)
          if (const Index cell = cellOf(b, i, l); cell >= 0)
            for (int k = 0; k < 9; ++k) out[9 * std::size_t(cell) + std::size_t(k)] = lane[k][l];
      }
    });
  }

  void addForce(ConstRows x, Rows f) override { addProduct(x, 1, f); }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override {
    addProduct(x, 1, f);
    addProduct(dx, factor, f);
  }
  double energy(ConstRows x) const override {
    return storage_.loop.sum(x, [&](Index b, const Nodes& in) {
      return HeldFan::energy(storage_.rest[std::size_t(b)], storage_.tangent[std::size_t(b)], in);
    });
  }
  void addProduct(ConstRows dx, double factor, Rows df) const override {
    const Pack scale(factor);
    storage_.loop.template run<1, 1>({dx}, {df}, [&](Index b, const auto& in, auto& out) {
      HeldFan::product(storage_.rest[std::size_t(b)], storage_.tangent[std::size_t(b)], scale, in[0], in[0], out[0]);
    });
  }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    storage_.loop.assemble(factor, slots, values, [&](Index b, Matrix& k) { matrix(b, k); });
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    storage_.loop.assembleDiagonal(factor, blocks, [&](Index b, Matrix& k) { matrix(b, k); });
  }

 private:
  Index cellOf(Index b, int i, int l) const {
    return cell_[(std::size_t(b) * tetrahedron::fan_size + std::size_t(i)) * pack_lanes + std::size_t(l)];
  }
  /// Multiples of the identity.
  void matrix(Index b, Matrix& k) const {
    for (Pack& value : k) value = Pack(0.);
    for (int i = 0; i < tetrahedron::fan_size; ++i) {
      const S3<Pack>& h = storage_.tangent[std::size_t(b)].of[i].k;
      const Pack x = h.xx + h.xy + h.zx, y = h.xy + h.yy + h.yz, z = h.zx + h.yz + h.zz;
      const Pack own[4][4] = {
          {x + y + z, -x, -y, -z}, {-x, h.xx, h.xy, h.zx}, {-y, h.xy, h.yy, h.yz}, {-z, h.zx, h.yz, h.zz}};
      for (int a = 0; a < 4; ++a)
        for (int c = 0; c < 4; ++c) {
          Pack* block = k + (tetrahedron::corner(i, a) * tetrahedron::fan_nodes + tetrahedron::corner(i, c)) * 9;
          for (int d : {0, 4, 8}) block[d] -= own[a][c];
        }
    }
  }
  std::size_t cells_;
  std::vector<Index> cell_;  ///< shape (batches, fan_size, lanes), -1: padding
};

std::unique_ptr<HeldStress> heldTetrahedra(const Cells& cells) {
  return std::make_unique<HeldTetrahedra>(cells, tetrahedron::gatherFans(cells.mesh->tetrahedra, cells.rest->size()));
}

}  // namespace

STROMA_COMPONENT(held_stress) { heldStressKernels().tetrahedra = heldTetrahedra; }
