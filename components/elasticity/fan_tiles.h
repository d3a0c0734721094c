// SPDX-License-Identifier: LGPL-2.1-or-later
// Loops over fans of tetrahedra in parts: a few batches (a tile) go through gathering, then rotations, then forces. Each part is
// short and its batches do not wait for each other, so a processor works at several of them at once; a kernel that does all of a
// batch in one chain of operations waits for that chain.
#pragma once
#include "framework/fem/fan_model.h"

namespace stroma::tetrahedron {

/// Edges from node 0 to the four other nodes of the fans of a batch, x y z each. Those of tetrahedron i are 0, 1 + i and 2 + i.
struct FanEdges {
  Pack of[12];
  void set(int edge, const V3<Pack>& e) { of[3 * edge] = e.x, of[3 * edge + 1] = e.y, of[3 * edge + 2] = e.z; }
  V3<Pack> operator[](int edge) const { return {of[3 * edge], of[3 * edge + 1], of[3 * edge + 2]}; }
};

/// The batches of the ElementLoop of the same fans, in its order.
class FanTiles {
 public:
  /// As ElementLoop::build().
  void build(const std::vector<std::array<Index, fan_nodes>>& fans, const std::vector<Vec3>& position, Index first_row) {
    arrangement_ = arrangeElements(fans.empty() ? nullptr : fans[0].data(), fan_nodes, Index(fans.size()), position, pack_lanes);
    offsets_.resize(std::size_t(arrangement_.batches) * fan_nodes * pack_lanes);
    for (std::size_t at = 0; at < arrangement_.element.size(); ++at) {
      const std::size_t batch = at / pack_lanes, lane = at % pack_lanes;
      const Index e = arrangement_.element[at] >= 0 ? arrangement_.element[at] : arrangement_.element[batch * pack_lanes];
      for (std::size_t a = 0; a < fan_nodes; ++a)
        offsets_[(batch * fan_nodes + a) * pack_lanes + lane] = (fans[std::size_t(e)][a] + first_row) * row_doubles;
    }
    arrangement_.element = {};
  }

  /// body(first batch, batches), at most `size` of them: tiles of a block in their order, blocks as in ElementLoop.
  template <Index size, class Body>
  void forEach(Body&& body) const {
    const auto block = [&](Index k) {
      const Index last = arrangement_.block_start[k + 1];
      for (Index first = arrangement_.block_start[k]; first < last; first += size) body(first, std::min(size, last - first));
    };
    const auto& colour_start = arrangement_.colour_start;
    for (std::size_t c = 0; c + 1 < colour_start.size(); ++c) {
      const Index first = colour_start[c], count = colour_start[c + 1] - first;
      if (arrangement_.elements < parallelElements(fan_nodes))
        for (Index k = 0; k < count; ++k) block(first + k);
      else
        parallelFor(count, [&](int k) { block(first + k); });
    }
  }

  void gather(Index batch, ConstRows x, FanEdges& edges) const {
    const V3<Pack> origin = gatherRows(x.data, offset(batch, 0));
#pragma GCC unroll 4
    for (int a = 1; a < fan_nodes; ++a) edges.set(a - 1, gatherRows(x.data, offset(batch, a)) - origin);
  }
  /// f += the forces `a` and `b` on the nodes of both tetrahedra of the fans.
  void scatter(Index batch, const V3<Pack> (&a)[4], const V3<Pack> (&b)[4], Rows f) const {
    const V3<Pack> sum[fan_nodes] = {a[0] + b[0], a[1] + b[1], a[2], a[3] + b[2], b[3]};
#pragma GCC unroll 5
    for (int node = 0; node < fan_nodes; ++node) addToRows(sum[node], offset(batch, node), f.data);
  }

 private:
  /// Where node a of each lane lies in the numbers of a vector, shape (lanes).
  const Index* offset(Index batch, int a) const {
    return offsets_.data() + (std::size_t(batch) * fan_nodes + std::size_t(a)) * pack_lanes;
  }
  Arrangement arrangement_;  ///< without its elements
  Array<Index> offsets_;     ///< rows times row_doubles, shape (batches, fan_nodes, lanes)
};

}  // namespace stroma::tetrahedron
