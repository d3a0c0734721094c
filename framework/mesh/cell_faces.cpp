// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mesh/cell_faces.h"

#include <algorithm>
#include <utility>

namespace stroma {

namespace {

/// A face with its nodes sorted, so that the two cells of an inner face name it alike.
template <std::size_t N>
struct FaceKey {
  std::array<Index, N> nodes;
  CellFace where;
};

/// Of a kind whose faces all have N nodes.
template <const CellKind& kind, std::size_t N, class Cell>
std::array<Index, N> nodesOf(const Cell& cell, std::size_t face) {
  std::array<Index, N> nodes;
  for (std::size_t i = 0; i < N; ++i) nodes[i] = cell[kind.faces[face].nodes[i]];
  return nodes;
}

/// Number by number: a comparison of arrays as a whole calls a function for these few bytes, millions of times.
template <std::size_t N>
bool sameNodes(const FaceKey<N>& a, const FaceKey<N>& b) {
  for (std::size_t i = 0; i < N; ++i)
    if (a.nodes[i] != b.nodes[i]) return false;
  return true;
}

/// Of faces with the same smallest node.
template <std::size_t N>
bool comesBefore(const FaceKey<N>& a, const FaceKey<N>& b) {
  for (std::size_t i = 1; i < N; ++i)
    if (a.nodes[i] != b.nodes[i]) return a.nodes[i] < b.nodes[i];
  return a.where.cell < b.where.cell;
}

/// All faces by their smallest node, those of a node in the order of their cells: a few each, which keeps the time of
/// what follows linear.
template <std::size_t N>
struct FaceBuckets {
  std::vector<FaceKey<N>> keys;
  std::vector<std::size_t> start;  ///< shape (nodes + 1)
};

template <const CellKind& kind, std::size_t N, class Cell>
FaceBuckets<N> bucketsOf(const std::vector<Cell>& cells) {
  constexpr std::size_t faces = kind.faces.size();
  Index nodes = 0;
  for (const Cell& cell : cells) nodes = std::max(nodes, *std::max_element(cell.begin(), cell.end()) + 1);
  const auto smallest = [&](const Cell& cell, std::size_t f) {
    const auto of_face = nodesOf<kind, N>(cell, f);
    Index least = of_face[0];
    for (std::size_t i = 1; i < N; ++i) least = std::min(least, of_face[i]);
    return std::size_t(least);
  };
  FaceBuckets<N> buckets;
  std::vector<std::size_t>& start = buckets.start;
  start.assign(std::size_t(nodes) + 1, 0);
  for (const Cell& cell : cells)
    for (std::size_t f = 0; f < faces; ++f) ++start[smallest(cell, f) + 1];
  for (std::size_t n = 0; n < std::size_t(nodes); ++n) start[n + 1] += start[n];
  buckets.keys.resize(cells.size() * faces);
  std::vector<std::size_t> next(start.begin(), start.end());
  for (std::size_t c = 0; c < cells.size(); ++c)
    for (std::size_t f = 0; f < faces; ++f) {
      auto key = nodesOf<kind, N>(cells[c], f);
      std::sort(key.begin(), key.end());
      buckets.keys[next[key[0]]++] = {key, {Index(c), int(f)}};
    }
  return buckets;
}

/// All faces, equal ones side by side and in the order of their cells.
template <const CellKind& kind, std::size_t N, class Cell>
std::vector<FaceKey<N>> sortedFaces(const std::vector<Cell>& cells) {
  auto [keys, start] = bucketsOf<kind, N>(cells);
  for (std::size_t n = 0; n + 1 < start.size(); ++n)
    std::sort(keys.begin() + std::ptrdiff_t(start[n]), keys.begin() + std::ptrdiff_t(start[n + 1]), comesBefore<N>);
  return std::move(keys);
}

/// Those of one cell alone, in the same order. Most faces have a partner, which a list for each second node finds
/// without sorting.
template <const CellKind& kind, std::size_t N, class Cell>
std::vector<FaceKey<N>> loneFaces(const std::vector<Cell>& cells) {
  const auto [keys, start] = bucketsOf<kind, N>(cells);
  std::vector<FaceKey<N>> lone;
  std::vector<std::size_t> newest(start.size(), 0), before;  // places in the bucket, from 1 on
  std::vector<char> shared;
  for (std::size_t n = 0; n + 1 < start.size(); ++n) {
    const FaceKey<N>* bucket = keys.data() + start[n];
    const std::size_t count = start[n + 1] - start[n], first = lone.size();
    before.assign(count + 1, 0), shared.assign(count + 1, 0);
    for (std::size_t k = 1; k <= count; ++k) {
      std::size_t& head = newest[bucket[k - 1].nodes[1]];
      for (std::size_t other = head; other > 0; other = before[other])
        if (sameNodes(bucket[k - 1], bucket[other - 1])) shared[k] = shared[other] = 1;
      before[k] = head;
      head = k;
    }
    for (std::size_t k = 1; k <= count; ++k) {
      newest[bucket[k - 1].nodes[1]] = 0;
      if (!shared[k]) lone.push_back(bucket[k - 1]);
    }
    std::sort(lone.begin() + std::ptrdiff_t(first), lone.end(), comesBefore<N>);
  }
  return lone;
}

template <const CellKind& kind, std::size_t N, class Cell>
std::vector<std::array<Index, N>> uniqueFacesOf(const std::vector<Cell>& cells, bool boundary_only) {
  const auto keys = boundary_only ? loneFaces<kind, N>(cells) : sortedFaces<kind, N>(cells);
  std::vector<std::array<Index, N>> out;
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (i == 0 || !sameNodes(keys[i - 1], keys[i]))
      out.push_back(nodesOf<kind, N>(cells[keys[i].where.cell], std::size_t(keys[i].where.face)));
  return out;
}

}  // namespace

std::vector<Triangle> uniqueFaces(const std::vector<Tetrahedron>& cells, bool boundary_only) {
  return uniqueFacesOf<cell_kinds::tetrahedron, 3>(cells, boundary_only);
}

std::vector<Quad> uniqueFaces(const std::vector<Hexahedron>& cells, bool boundary_only) {
  return uniqueFacesOf<cell_kinds::hexahedron, 4>(cells, boundary_only);
}

std::vector<QuadraticTriangle> uniqueFaces(const std::vector<QuadraticTetrahedron>& cells, bool boundary_only) {
  return uniqueFacesOf<cell_kinds::quadratic_tetrahedron, 6>(cells, boundary_only);
}

std::vector<std::array<CellFace, 2>> sharedFaces(const std::vector<Hexahedron>& cells) {
  const auto keys = sortedFaces<cell_kinds::hexahedron, 4>(cells);
  std::vector<std::array<CellFace, 2>> out;
  for (std::size_t i = 0; i + 1 < keys.size(); ++i)
    if (sameNodes(keys[i], keys[i + 1])) out.push_back({keys[i].where, keys[i + 1].where});
  return out;
}

}  // namespace stroma
