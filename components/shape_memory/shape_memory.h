// SPDX-License-Identifier: LGPL-2.1-or-later
// The mathematics of shape memory: d = P_target - P = c + R r - P of each node, its derivative J along a direction and
// the transposed product J^T F, in batches of packs. c is the mean of the node's neighbours x_j, R the rotation that
// fits their rest positions X_j best (local_frame.h), r the place of the node in their frame at rest.
//   A = sum_j scale (x_j - c) (X_j - C)^T + own (P - c) r^T,   R = argmax tr(R^T A)
//   dd = dc + R (w x r) - dP,  w = G^-1 axial(R^T dA)
// Source: Nesme et al. 2005, section 4, for the target; the derivative is that of the best rotation.
#pragma once
#include <Eigen/Core>
#include <algorithm>

#include "components/shape_memory/neighbourhoods.h"
#include "components/shape_memory/spin.h"
#include "framework/algebra/parallel.h"

namespace stroma {

class ShapeMemory {
 public:
  /// What a rest shape and its neighbourhoods are; vectors are those of a state.
  struct Input {
    const Adjacency& neighbours;             ///< shape (nodes); an empty list: no target
    const std::vector<Vec3>& rest_position;  ///< [m], shape (nodes)
    const std::vector<double>& stiffness;    ///< [N/m], one, or shape (nodes)
    double own_weight;                       ///< of the node in the fit, a neighbour has 1
    bool reaction;                           ///< act() spreads a force to the neighbours too
    bool only_upright;                       ///< but not where the neighbourhood is turned inside out
    Index first_row;
  };
  void build(const Input& input);

  Index batches() const { return around_.count(); }
  Pack stiffness(Index batch) const { return rest_of_[batch].stiffness; }  ///< [N/m]; 0 in padding
  const Index* rows(Index batch) const { return around_.ownOffsets(batch); }
  Index node(Index batch, int lane) const {
    return around_.centre[std::size_t(batch) * pack_lanes + std::size_t(lane)];
  }
  Index chunks() const { return around_.chunks(); }

  /// d at x; keeps the frame for drawnChange(), act() and forEachJacobian().
  V3<Pack> drawn(ConstRows x, Index batch) { return drawnAt(x, batch, &frame_of_[batch]); }
  V3<Pack> drawnOnly(ConstRows x, Index batch) const { return drawnAt(x, batch, nullptr); }
  /// The derivative of d at the frames kept, along dx.
  V3<Pack> drawnChange(ConstRows dx, Index batch) const;
  /// Adds what a force F that draws P to P_target does: F on the node and, with reaction, what addReactions() adds to
  /// its neighbours once all batches have acted. The whole is -(dd/dx)^T F.
  void act(Index batch, const V3<Pack>& force, Rows f) const;
  void addReactions(Rows f) const;

  /// body(batch) for all batches, chunks on the threads.
  template <class Body>
  void forEachBatch(Body&& body) const {
    forEachPiece(
        chunks(), [&](int c) __attribute__((flatten)) {
          for (Index b = around_.chunk_start[c]; b < around_.chunk_start[c + 1]; ++b) body(b);
        });
  }
  /// Sum over nodes of value(batch), a pack; always in the same order.
  template <class Value>
  double sum(Value&& value) const {
    forEachPiece(chunks(), [&](int c) {
      Pack total(0.);
      for (Index b = around_.chunk_start[c]; b < around_.chunk_start[c + 1]; ++b) total += value(b);
      partial_[c] = xsimd::hadd(total);
    });
    double result = 0;
    for (const double part : partial_) result += part;
    return result;
  }
  /// visit(nodes, blocks, stiffness, passes) for each node: the nodes that P - P_target depends on, itself first, the
  /// derivatives by their positions, and false where the neighbours feel no reaction (if there is one at all).
  template <class Visit>
  void forEachJacobian(const Adjacency& neighbours, Visit&& visit) const;

 private:
  enum Kind : int { centred, framed };
  /// Of one batch; does not change. Lengths in the fit are scaled by 3 / sum |X_j - C|^2, so that A is near the
  /// identity.
  struct Rest {
    Pack share;       ///< 1 / number of neighbours; 0 in padding
    Pack stiffness;   ///< [N/m]; 0 in padding
    V3<Pack> r;       ///< [m] from the mean of the neighbours to the node
    Pack own;         ///< own_weight * scale
    Pack scale;       ///< [1/m^2]
    V3<Pack> centre;  ///< [m] mean of the neighbours, from the mean of all rest positions
  };
  struct Frame {
    M3<Pack> r;
    S3<Pack> spin;  ///< G^-1 of local_frame::spinInverse
    Pack passes;    ///< 1, or 0 where nothing reaches the neighbours
  };
  /// A framed node does -(g + U X) to a neighbour at rest position X: the columns of U, then g. A centred one does -g.
  struct alignas(64) Turn {
    double rows[4][row_doubles];
  };
  /// sum_j (x_j - x_i) and sum_j scale (x_j - x_i) (X_j - C)^T
  struct Sums {
    V3<Pack> difference;
    M3<Pack> outer;
  };

  template <class Piece>
  void forEachPiece(int count, Piece&& piece) const {
    if (chunks() >= 8) return parallelFor(count, piece);
    for (int p = 0; p < count; ++p) piece(p);  // too little work to wake a thread for
  }
  static bool isCentred(Index node, const Input& input);
  /// Fills heard_centred_ and heard_framed_; makes room for reactions.
  void listenFor(const Adjacency& neighbours, const std::vector<int>& kind);
  /// Fills rest_of_ and rest_neighbour_ of a batch, lane by lane; padding gets share and stiffness zero.
  void storeRest(Index batch, const Input& input, const Vec3& origin);
  /// The sums over the neighbours of each lane at x; without the outer products where no frame is needed.
  template <bool with_frame>
  Sums sums(ConstRows x, Index batch) const;
  /// d at x; the frame goes to `keep` unless it is null.
  V3<Pack> drawnAt(ConstRows x, Index batch, Frame* keep) const;
  /// out -= what centred, and what framed nodes do to node j.
  void hearCentred(Index j, double* out) const;
  void hearFramed(Index j, double* out) const;
  bool isFramed(Index batch) const { return around_.batches[batch].kind == framed; }
  /// A flat neighbourhood counts as upright: the sign of its determinant is round-off.
  Pack passes(const M3<Pack>& a) const {
    if (!only_upright_) return Pack(1.);
    const Pack size = squaredNorm(a);
    return select(dot(a.c0, cross(a.c1, a.c2)) < Pack(-1e-6) * size * sqrt(size), Pack(0.), Pack(1.));
  }
  /// A of the fit: the neighbours' outer products and the node's own.
  static M3<Pack> withOwn(const Sums& s, const Rest& rest, const V3<Pack>& mean) {
    const V3<Pack> own = rest.r * rest.own;
    return {fma(-own.x, mean, s.outer.c0), fma(-own.y, mean, s.outer.c1), fma(-own.z, mean, s.outer.c2)};
  }

  /// Nodes and their neighbours in batches of equal length (neighbourhoods.h).
  Neighbourhoods around_;
  /// The places (batch and lane) of the centred and of the framed nodes that a node is a neighbour of.
  Adjacency heard_centred_, heard_framed_;
  /// Shape (batches).
  Array<Rest> rest_of_;
  /// Shape (batches), of the last drawn().
  Array<Frame> frame_of_;
  Array<V3<Pack>> rest_neighbour_;  ///< scale (X_j - C), as Neighbourhoods::neighbour; 0 in padding
  Vector rest_;                     ///< rest positions from their mean, shape (nodes)
  Index first_row_ = 0;
  bool only_upright_ = false;
  mutable Array<double> pulls_;  ///< g of centred nodes, shape (batches, lanes, row_doubles), only with reaction
  mutable Array<Turn> turns_;    ///< of framed nodes, shape (batches, lanes), only with reaction
  mutable std::vector<double> partial_;
  mutable std::vector<Index> nodes_;  ///< of one node's Jacobian, as large as the longest list needs
  mutable std::vector<Mat3> blocks_;
};

// ---- one batch ----

template <bool with_frame>
ShapeMemory::Sums ShapeMemory::sums(ConstRows x, Index batch) const {
  const auto& layout = around_.batches[batch];
  const V3<Pack> own = gatherRows(x.data, rows(batch));
  const V3<Pack>* edge = rest_neighbour_.data() + layout.first;
  Sums sums;
  for (Index k = 0; k < layout.valence; ++k) {
    const V3<Pack> d = gatherRows(x.data, around_.neighbourOffsets(batch, k)) - own;
    sums.difference = sums.difference + d;
    if (!with_frame) continue;
    sums.outer.c0 = fma(edge[k].x, d, sums.outer.c0);
    sums.outer.c1 = fma(edge[k].y, d, sums.outer.c1);
    sums.outer.c2 = fma(edge[k].z, d, sums.outer.c2);
  }
  return sums;
}

inline V3<Pack> ShapeMemory::drawnAt(ConstRows x, Index batch, Frame* keep) const {
  const Rest& rest = rest_of_[batch];
  if (!isFramed(batch)) return sums<false>(x, batch).difference * rest.share;
  const Sums s = sums<true>(x, batch);
  const V3<Pack> mean = s.difference * rest.share;
  const M3<Pack> a = withOwn(s, rest, mean), r = local_frame::bestRotation(a);
  if (keep) *keep = {r, local_frame::spinInverse(r, a), passes(a)};
  return mean + r * rest.r;
}

inline V3<Pack> ShapeMemory::drawnChange(ConstRows dx, Index batch) const {
  const Rest& rest = rest_of_[batch];
  if (!isFramed(batch)) return sums<false>(dx, batch).difference * rest.share;
  const Sums s = sums<true>(dx, batch);
  const Frame& frame = frame_of_[batch];
  const V3<Pack> mean = s.difference * rest.share;
  const V3<Pack> spin = frame.spin * local_frame::axial(transposedTimes(frame.r, withOwn(s, rest, mean)));
  return mean + frame.r * cross(spin, rest.r);
}

/// With mu = G^-1 (r x R^T F) in the axes of the frame, the node gets h = F - R (mu x own r) and a neighbour
/// -(share h + R (mu x scale (X_j - C))), kept as a linear function of X_j.
inline void ShapeMemory::act(Index batch, const V3<Pack>& force, Rows f) const {
  if (turns_.empty()) return addToRows(force, rows(batch), f.data);
  const Rest& rest = rest_of_[batch];
  if (!isFramed(batch)) {
    addToRows(force, rows(batch), f.data);
    return setRows(force * rest.share, pulls_.data() + std::size_t(batch) * pack_lanes * row_doubles);
  }
  const Frame& frame = frame_of_[batch];
  const V3<Pack> mu = frame.spin * cross(rest.r, transposedTimes(frame.r, force)) * frame.passes;
  const V3<Pack> own = force - frame.r * (cross(mu, rest.r) * rest.own);
  const M3<Pack> u = rotation::timesCross(frame.r, mu) * rest.scale;
  const V3<Pack> pull = own * (rest.share * frame.passes) - u * rest.centre;
  addToRows(own, rows(batch), f.data);
  Turn* turns = turns_.data() + std::size_t(batch) * pack_lanes;
  const V3<Pack>* parts[] = {&u.c0, &u.c1, &u.c2, &pull};
  for (int p = 0; p < 4; ++p) forEachRow(*parts[p], [&](int l, const auto& row) { setRow(row, turns[l].rows[p]); });
}

/// Each node collects what the neighbourhoods that it belongs to do to it: no two threads write to one row.
inline void ShapeMemory::addReactions(Rows f) const {
  if (turns_.empty()) return;
  const Index nodes = heard_centred_.size();
  forEachPiece((nodes + neighbourhood_chunk - 1) / neighbourhood_chunk, [&](int p) {
    const Index last = std::min(nodes, (p + 1) * neighbourhood_chunk);
    for (Index j = p * neighbourhood_chunk; j < last; ++j) {
      double* out = f.data + std::size_t(first_row_ + j) * row_doubles;
      hearCentred(j, out);
      hearFramed(j, out);
    }
  });
}

inline void ShapeMemory::hearCentred(Index j, double* out) const {
  double sum[row_doubles]{};
  for (Index k = heard_centred_.start[j]; k < heard_centred_.start[j + 1]; ++k)
    for (int c = 0; c < row_doubles; ++c)
      sum[c] += pulls_[std::size_t(heard_centred_.values[k]) * row_doubles + std::size_t(c)];
  for (int c = 0; c < row_doubles; ++c) out[c] -= sum[c];
}

inline void ShapeMemory::hearFramed(Index j, double* out) const {
  const Index first = heard_framed_.start[j], last = heard_framed_.start[j + 1];
  if (first == last) return;
  constexpr int packs = 4 * row_doubles / pack_lanes;
  Pack total[packs]{};
  for (Index k = first; k < last; ++k) {
    const double* turn = turns_[heard_framed_.values[k]].rows[0];
    for (int p = 0; p < packs; ++p) total[p] += Pack::load_aligned(turn + p * pack_lanes);
  }
  alignas(64) double sum[4][row_doubles];
  for (int p = 0; p < packs; ++p) total[p].store_aligned(sum[0] + p * pack_lanes);
  const double* position = rest_.rows().data + std::size_t(j) * row_doubles;
  for (int c = 0; c < row_doubles; ++c)
    out[c] -= sum[3][c] + sum[0][c] * position[0] + sum[1][c] * position[1] + sum[2][c] * position[2];
}

// ---- the matrix ----

template <class Visit>
void ShapeMemory::forEachJacobian(const Adjacency& neighbours, Visit&& visit) const {
  const auto crossMatrix = [](const Vec3& v) {
    Mat3 m;
    m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return m;
  };
  std::vector<Index>& nodes = nodes_;
  std::vector<Mat3>& blocks = blocks_;
  for (Index b = 0; b < batches(); ++b) {
    const Rest& rest = rest_of_[b];
    const Frame& frame = frame_of_[b];
    for (int l = 0; l < pack_lanes && node(b, l) >= 0; ++l) {
      const auto lane = [l](const V3<Pack>& v) { return Vec3(v.x.get(l), v.y.get(l), v.z.get(l)); };
      Mat3 r, lever = Mat3::Zero();  // lever = R [r]x G^-1
      r << lane(frame.r.c0), lane(frame.r.c1), lane(frame.r.c2);
      if (isFramed(b)) {
        const S3<Pack>& g = frame.spin;
        Mat3 spin;
        spin << lane({g.xx, g.xy, g.zx}), lane({g.xy, g.yy, g.yz}), lane({g.zx, g.yz, g.zz});
        lever = r * crossMatrix(lane(rest.r)) * spin;
      }
      const double share = rest.share.get(l);
      const Vec3 own = lane(rest.r) * rest.own.get(l);
      nodes.assign(1, node(b, l));
      blocks.assign(1, Mat3::Identity() + lever * crossMatrix(own) * r.transpose());
      const Index first = neighbours.start[nodes[0]];
      for (Index k = first; k < neighbours.start[nodes[0] + 1]; ++k) {
        const Vec3 edge = lane(rest_neighbour_[around_.batches[b].first + k - first]);
        nodes.push_back(neighbours.values[k]);
        blocks.push_back(lever * crossMatrix(edge - share * own) * r.transpose() - share * Mat3::Identity());
      }
      visit(nodes, blocks, rest.stiffness.get(l), frame.passes.get(l) > 0);
    }
  }
}

}  // namespace stroma
