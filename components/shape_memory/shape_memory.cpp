// SPDX-License-Identifier: LGPL-2.1-or-later
// The rest shape of shape memory, once at the start.
#include "components/shape_memory/shape_memory.h"

namespace stroma {

void ShapeMemory::build(const Input& input) {
  const std::size_t nodes = input.rest_position.size();
  first_row_ = input.first_row;
  only_upright_ = input.only_upright;
  Vec3 origin = Vec3::Zero();
  for (const Vec3& p : input.rest_position) origin += p / double(nodes);
  rest_.resize(Index(nodes));
  std::vector<int> kind(nodes);
  for (std::size_t i = 0; i < nodes; ++i) {
    rest_[Index(i)] = input.rest_position[i] - origin;
    kind[i] = isCentred(Index(i), input) ? centred : framed;
  }
  around_ = arrangeNeighbourhoods(input.neighbours, kind, first_row_, pack_lanes);
  rest_of_.assign(batches(), {});
  frame_of_.assign(batches(), {identity<Pack>(), {}, Pack(1.)});
  rest_neighbour_.assign(around_.neighbour.size() / pack_lanes, {});
  partial_.assign(chunks(), 0);
  for (Index b = 0; b < batches(); ++b) storeRest(b, input, origin);
  std::size_t longest = 0;
  for (const auto& batch : around_.batches) longest = std::max(longest, std::size_t(batch.valence));
  nodes_.reserve(longest + 1), blocks_.reserve(longest + 1);
  if (!input.reaction) return;
  listenFor(input.neighbours, kind);
}

/// Who is heard is named by its place, batch * lanes + lane: batches then write what they do in one piece.
void ShapeMemory::listenFor(const Adjacency& neighbours, const std::vector<int>& kind) {
  std::vector<Index> place(kind.size());
  for (std::size_t p = 0; p < around_.centre.size(); ++p)
    if (around_.centre[p] >= 0) place[around_.centre[p]] = Index(p);
  const Adjacency heard = transposed(neighbours);
  heard_centred_ = heard_framed_ = {};
  for (std::size_t j = 0; j < kind.size(); ++j) {
    for (Index k = heard.start[j]; k < heard.start[j + 1]; ++k) {
      const std::size_t node = std::size_t(heard.values[k]);
      (kind[node] == framed ? heard_framed_ : heard_centred_).values.push_back(place[node]);
    }
    for (Adjacency* list : {&heard_centred_, &heard_framed_}) list->start.push_back(Index(list->values.size()));
  }
  pulls_.assign(around_.centre.size() * row_doubles, 0);
  turns_.assign(around_.centre.size(), {});
}

/// True when the node lies at the mean of its neighbours, to round-off: its target does not depend on the frame.
bool ShapeMemory::isCentred(Index node, const Input& input) {
  const auto& lists = input.neighbours;
  const Index first = lists.start[node], last = lists.start[node + 1];
  Vec3 sum = Vec3::Zero();
  double reach = 0;
  for (Index k = first; k < last; ++k) {
    const Vec3 edge = input.rest_position[lists.values[k]] - input.rest_position[node];
    sum += edge;
    reach = std::max(reach, edge.norm());
  }
  return sum.norm() <= 1e-12 * reach * (last - first);
}

void ShapeMemory::storeRest(Index batch, const Input& input, const Vec3& origin) {
  const auto& layout = around_.batches[batch];
  using Lanes = std::array<double, pack_lanes>;
  Lanes share{}, stiffness{}, scale{};
  std::array<Lanes, 3> r{}, centre{};
  std::vector<std::array<Lanes, 3>> edges(std::size_t(layout.valence), std::array<Lanes, 3>{});
  for (std::size_t l = 0; l < pack_lanes; ++l) {
    const Index at = node(batch, int(l));
    if (at < 0) continue;
    const Index first = input.neighbours.start[at];
    const Index count = input.neighbours.start[at + 1] - first;
    const Vec3& position = input.rest_position[at];
    const auto edge = [&](Index k) {
      return Vec3(input.rest_position[input.neighbours.values[(first + k)]] - position);
    };
    Vec3 mean = Vec3::Zero();
    for (Index k = 0; k < count; ++k) mean += edge(k) / count;
    double squares = 0;
    for (Index k = 0; k < count; ++k) squares += (edge(k) - mean).squaredNorm();
    if (squares == 0) squares = input.own_weight * mean.squaredNorm();  // one neighbour: only the node has a direction
    share[l] = 1. / count;
    stiffness[l] = input.stiffness[input.stiffness.size() == 1 ? 0 : at];
    scale[l] = squares > 0 ? 3 / squares : 1;
    for (std::size_t c = 0; c < 3; ++c) {
      r[c][l] = layout.kind == centred ? 0 : -mean[Index(c)];
      centre[c][l] = position[Index(c)] + mean[Index(c)] - origin[Index(c)];
      for (Index k = 0; k < count; ++k) edges[k][c][l] = (edge(k) - mean)[Index(c)] * scale[l];
    }
  }
  const auto pack = [](const Lanes& lanes) { return Pack::load_unaligned(lanes.data()); };
  const auto packs = [&pack](const std::array<Lanes, 3>& v) { return V3<Pack>{pack(v[0]), pack(v[1]), pack(v[2])}; };
  rest_of_[batch] = {pack(share), pack(stiffness), packs(r), pack(scale) * Pack(input.own_weight),
                     pack(scale), packs(centre)};
  for (Index k = 0; k < layout.valence; ++k) rest_neighbour_[layout.first + k] = packs(edges[k]);
}

}  // namespace stroma
