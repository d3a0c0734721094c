// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/elasticity/nodal_averages.h"

namespace stroma::tetrahedron {
namespace {

/// Cells by their bulk modulus.
std::map<double, std::vector<Index>> materialsOf(const Mesh& mesh, const LameOf& lame) {
  std::map<double, std::vector<Index>> cells;
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) cells[lame(e).bulk()].push_back(Index(e));
  constexpr std::size_t most = 100;
  if (cells.size() > most)
    throw ComponentError(fmt::format("the mean dilatation is taken over cells with equal constants, and there are {} "
                                     "bulk moduli",
                                     cells.size()),
                         fmt::format("at most {} materials", most), "dilatation=\"local\"");
  return cells;
}

/// V_0 tr of the strain of dx.
Pack volumeChange(const auto& t, const V3<Pack> (&dx)[fan_nodes], int i) {
  const V3<Pack> origin = dx[0];
  const V3<Pack> d[3] = {dx[corner(i, 1)] - origin, dx[corner(i, 2)] - origin, dx[corner(i, 3)] - origin};
  return t.weight * (dot(d[0], t.g.g1) + (dot(d[1], t.g.g2) + dot(d[2], t.g.g3)));
}
/// -V_e p_e of both tetrahedra from sums_ after addPressures() has made pressures of them.
std::pair<Pack, Pack> pressures(const auto& t, const V3<Pack> (&sums)[fan_nodes]) {
  const Pack common = sums[0].x + sums[1].x + sums[3].x;
  return {t.of[0].weight * (common + sums[2].x), t.of[1].weight * (common + sums[4].x)};
}
/// A quarter of weight times `of` for the nodes of a cell, in the order of Cells::cells; the first one's is minus the
/// sum of the others', because nothing changes where all move as one.
std::array<Vec3, 4> ofLane(const auto& m, const Gradients<Pack>& of, const Pack& weight, int lane, const Fan& fan, int i) {
  const auto at = [&](const Pack& value) {
    alignas(64) double lanes[pack_lanes];
    value.store_aligned(lanes);
    return lanes[lane];
  };
  const double scale = at(weight) / 4;
  const auto vector = [&](const V3<Pack>& v) -> Vec3 { return scale * Vec3(at(v.x), at(v.y), at(v.z)); };
  const Vec3 g1 = vector(of.g1), g2 = vector(of.g2), g3 = vector(of.g3), g[4] = {-(g1 + g2 + g3), g1, g2, g3};
  const Tetrahedron& rows = m.cells[fan.element[i]];
  std::array<Vec3, 4> result;
  for (int a = 0; a < 4; ++a) {
    const Index row = fan.nodes[corner(i, a)];
    result[std::size_t(std::find(rows.begin(), rows.end(), row) - rows.begin())] = g[a];
  }
  return result;
}

}  // namespace

/// The warped tangent on the data of a storage.
template <class Storage>
struct NodalAverages<Storage>::Warped : Model {
  template <class>
  using Rest = typename NodalAverages::Rest;
  template <class>
  using Tangent = typename NodalAverages::Tangent;
  static void ofFan(const auto& rest, const auto& t, const V3<Pack> (&x)[fan_nodes], auto& k) {
    fanMatrix<WarpedBlocks<Pack>>(rest, t, x, k);
  }
};

template <class Storage>
NodalAverages<Storage>::NodalAverages(const Elements& elements)
    : shapes_(elements.shapes),
      first_row_(elements.first_row),
      lame_(elements.lame),
      cells_(materialsOf(elements.shapes.mesh(), elements.lame)) {
  for (const auto& [bulk, numbers] : cells_) {
    Cells& m = materials_.emplace_back();
    std::vector<double> volume;
    for (Index e : numbers) {
      m.cells.push_back(shapes_.mesh().tetrahedra[e]);
      volume.push_back(shapes_.weight(shapes_.restEdges(m.cells.back())));
    }
    m.fans = gatherFans(m.cells, shapes_.positions().size());
    std::vector<Fan>& fans = fans_.emplace_back(m.fans);
    for (Fan& fan : fans)
      for (Index& e : fan.element) e = e >= 0 ? numbers[e] : -1;
    m.storage = fanStorage<Storage>(fans, elements);
    for (Fan& fan : m.fans)
      for (Index& node : fan.nodes) node += first_row_;
    for (Tetrahedron& cell : m.cells)
      for (Index& node : cell) node += first_row_;
    m.average(bulk, volume);
  }
}

/// Only where the same cells have equal constants as before.
template <class Storage>
bool NodalAverages<Storage>::refill() {
  gradients_ready_ = false;
  const std::map<double, std::vector<Index>> now = materialsOf(shapes_.mesh(), lame_);
  const auto same = [](const auto& a, const auto& b) { return a.second == b.second; };
  if (!std::equal(cells_.begin(), cells_.end(), now.begin(), now.end(), same)) return false;
  std::size_t i = 0;
  for (const auto& [bulk, numbers] : now) {
    fillFans(materials_[i].storage, fans_[i], shapes_, lame_);
    materials_[i++].setBulk(bulk);
  }
  return true;
}

template <class Storage>
void NodalAverages<Storage>::addPattern(BlockPattern& pattern) const {
  preparePatches();
  for (const Cells& m : materials_) {
    m.storage.loop.addPattern(pattern);
    m.patches.addPattern(pattern);
  }
}
template <class Storage>
std::vector<Index> NodalAverages<Storage>::slots(const BlockMatrix& matrix) const {
  preparePatches();
  std::vector<Index> all;
  for (const Cells& m : materials_)
    for (const std::vector<Index>& part : {m.storage.loop.slots(matrix), m.patches.slots(matrix)})
      all.insert(all.end(), part.begin(), part.end());
  return all;
}
template <class Storage>
void NodalAverages<Storage>::assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const {
  updatePatches();
  const Index* at = slots.data();
  for (const Cells& m : materials_) {
    m.storage.loop.assemble(factor, at, values, [&](Index b, Matrix& k) { matrix(m, b, k); });
    at += m.storage.loop.slotCount();
    m.patches.assemble(factor, m.factor, at, values);
    at += m.patches.slotCount();
  }
}
template <class Storage>
void NodalAverages<Storage>::assembleDiagonal(double factor, std::vector<double>& blocks) const {
  updatePatches();
  for (const Cells& m : materials_) {
    m.storage.loop.assembleDiagonal(factor, blocks, [&](Index b, Matrix& k) { matrix(m, b, k); });
    m.patches.assembleDiagonal(factor, m.factor, blocks);
  }
}

template <class Storage>
[[gnu::noipa, gnu::flatten]] void NodalAverages<Storage>::matrix(const Cells& m, Index b, Matrix& k) const {
  if constexpr (!exact) {
    Nodes x{};
    FanOf<Warped>::matrix(m.storage.rest[b], m.storage.tangent[b], x, k);
  }
}
template <class Storage>
void NodalAverages<Storage>::differentiate(const Cells&, Index, Derivatives&) const {}

template <class Storage>
void NodalAverages<Storage>::keep(ConstRows x) {
  if (x_.count() != x.count) x_.resize(x.count);
  copy(x, x_);
}
template <class Storage>
void NodalAverages<Storage>::startSums(const Cells& m, Index rows) const {
  if (sums_.count() != rows) sums_.resize(rows);
  for (Index row : m.rows) sums_[row].setZero();
}
template <class Storage>
void NodalAverages<Storage>::addWarpedProduct(const Cells& m, ConstRows dx, double factor, Rows df) const {
  const Pack scale(factor);
  if constexpr (!exact)
    m.storage.loop.template run<1, 2>({dx}, {df, sums_.rows()}, [&](Index b, const auto& in, auto& out) {
      const FanTangent& t = m.storage.tangent[b];
      FanOf<Warped>::product(m.storage.rest[b], t, scale, in[0], in[0], out[0]);
      spread(volumeChange(t.of[0], in[0], 0), volumeChange(t.of[1], in[0], 1), out[1]);
    });
}
template <class Storage>
void NodalAverages<Storage>::addPressures(const Cells& m, double factor, Rows f) const {
  for (std::size_t a = 0; a < m.rows.size(); ++a) sums_[m.rows[a]].x() *= -0.25 * factor * m.factor[a];
  m.storage.loop.template run<1, 1>({sums_.rows()}, {f}, [&](Index b, const auto& in, auto& out) {
    const FanTangent& t = m.storage.tangent[b];
    const auto [first, second] = pressures(t, in[0]);
    const Gradients<Pack>&g = t.of[0].g, &h = t.of[1].g;
    const V3<Pack> f1 = g.g1 * first, f2 = g.g2 * first, f3 = g.g3 * first;
    const V3<Pack> h1 = h.g1 * second, h2 = h.g2 * second, h3 = h.g3 * second;
    out[0][0] = -(f1 + f2 + f3 + h1 + h2 + h3);
    out[0][1] = f1 + h1;
    out[0][2] = f2;
    out[0][3] = f3 + h2;
    out[0][4] = h3;
  });
}
template <class Storage>
void NodalAverages<Storage>::keepPressures(Cells& m) const {
  if constexpr (exact)
    m.storage.loop.forEachBatch([&](Index b) {
      Nodes sums;
      m.storage.loop.gather(b, sums_.rows(), sums);
      FanTangent& t = m.storage.tangent[b];
      const auto [first, second] = pressures(t, sums);
      t.of[0].pressure = first, t.of[1].pressure = second;
    });
}
template <class Storage>
double NodalAverages<Storage>::withEnergyOfSums(double sum, const Cells& m) const {
  for (std::size_t a = 0; a < m.rows.size(); ++a) {
    const double volume_change = sums_[m.rows[a]].x();
    sum += 0.5 * m.factor[a] * volume_change * volume_change;
  }
  return sum;
}

// ---- the matrix of the volume changes ----

template <class Storage>
void NodalAverages<Storage>::preparePatches() const {
  for (Cells& m : materials_)
    if (m.patches.empty()) m.patches = NodalPatches(m.cells, m.rows);
}
/// With the gradients of the last force.
template <class Storage>
void NodalAverages<Storage>::updatePatches() const {
  preparePatches();
  if (gradients_ready_) return;
  for (Cells& m : materials_) {
    m.patches.clear();
    Derivatives derivatives;
    m.storage.loop.forEachLane([&](Index b, int l) {
      const Fan& fan = m.fans[m.storage.loop.elementOf(b, l)];
      if constexpr (exact)
        if (l == 0) differentiate(m, b, derivatives);
      for (int i = 0; i < fan_size; ++i)
        if (const Index cell = fan.element[i]; cell >= 0) {
          const Tangent& t = m.storage.tangent[b].of[i];
          m.patches.add(std::size_t(cell), ofLane(m, t.g, t.weight, l, fan, i));
          if constexpr (exact)
            m.patches.addDerivative(std::size_t(cell), ofLane(m, derivatives[i], Pack(1.), l, fan, i));
        }
    });
  }
  gradients_ready_ = true;
}

template class NodalAverages<StorageOf<FanOf<Deviatoric<Linear>>>>;
template class NodalAverages<StorageOf<FanOf<Deviatoric<Corotational<rotation::Qr, Update::none>>>>>;
template class NodalAverages<StorageOf<FanOf<Deviatoric<Corotational<rotation::Qr, Update::strain_displacement>>>>>;
template class NodalAverages<StorageOf<FanOf<ExactDeviatoric<rotation::Qr, Update::none>>>>;
template class NodalAverages<StorageOf<FanOf<ExactDeviatoric<rotation::Qr, Update::strain_displacement>>>>;

}  // namespace stroma::tetrahedron
