// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/shape_memory/neighbourhoods.h"

#include <algorithm>
#include <tuple>

#include "framework/algebra/vector.h"

namespace stroma {
namespace {

Index valence(const Adjacency& lists, Index node) { return lists.start[node + 1] - lists.start[node]; }

/// Appends one batch with the centres [first, last); lanes beyond them repeat the first centre and see only itself.
void appendBatch(const Adjacency& lists, const Index* first, const Index* last, int kind, Index first_row,
                 Neighbourhoods& out) {
  Neighbourhoods::Batch batch;
  batch.first = Index(out.neighbour.size()) / out.lanes;
  batch.kind = kind;
  for (const Index* node = first; node != last; ++node) batch.valence = std::max(batch.valence, valence(lists, *node));
  const auto offset = [first_row](Index node) { return (node + first_row) * row_doubles; };
  for (int l = 0; l < out.lanes; ++l) {
    const bool real = l < last - first;
    out.centre.push_back(real ? first[l] : -1);
    out.own.push_back(offset(real ? first[l] : *first));
  }
  for (Index k = 0; k < batch.valence; ++k)
    for (int l = 0; l < out.lanes; ++l) {
      const Index node = l < last - first ? first[l] : *first;
      const bool listed = l < last - first && k < valence(lists, node);
      out.neighbour.push_back(offset(listed ? lists.values[lists.start[node] + k] : node));
    }
  out.batches.push_back(batch);
}

}  // namespace

Neighbourhoods arrangeNeighbourhoods(const Adjacency& neighbours, const std::vector<int>& kind, Index first_row,
                                     int lanes) {
  Neighbourhoods out;
  out.lanes = lanes;
  std::vector<Index> centres;
  for (Index node = 0; node < neighbours.size(); ++node)
    if (valence(neighbours, node) > 0) centres.push_back(node);
  for (std::size_t begin = 0; begin < centres.size(); begin += std::size_t(neighbourhood_chunk)) {
    const std::size_t end = std::min(begin + std::size_t(neighbourhood_chunk), centres.size());
    const auto key = [&](Index node) { return std::make_tuple(kind[node], valence(neighbours, node), node); };
    std::sort(centres.begin() + std::ptrdiff_t(begin), centres.begin() + std::ptrdiff_t(end),
              [&key](Index a, Index b) { return key(a) < key(b); });
    for (std::size_t first = begin; first < end;) {
      const int its_kind = kind[centres[first]];
      std::size_t last = first;
      while (last < end && last - first < std::size_t(lanes) && kind[centres[last]] == its_kind) ++last;
      appendBatch(neighbours, centres.data() + first, centres.data() + last, its_kind, first_row, out);
      first = last;
    }
    out.chunk_start.push_back(out.count());
  }
  return out;
}

Adjacency transposed(const Adjacency& lists) {
  Adjacency out;
  const std::size_t nodes = std::size_t(lists.size());
  out.start.assign(nodes + 1, 0);
  for (const Index value : lists.values) ++out.start[value + 1];
  for (std::size_t n = 0; n < nodes; ++n) out.start[n + 1] += out.start[n];
  out.values.resize(lists.values.size());
  std::vector<Index> next(out.start.begin(), out.start.end() - 1);
  for (std::size_t n = 0; n < nodes; ++n)
    for (Index k = lists.start[n]; k < lists.start[n + 1]; ++k) out.values[next[lists.values[k]]++] = Index(n);
  return out;
}

}  // namespace stroma
