// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mesh/cell_faces.h"

#include <algorithm>
#include <utility>

namespace stroma {

namespace {

/// One face of one cell.
struct CellFace {
  Index cell = 0;  ///< in the order of the lists
  int face = 0;    ///< of CellKind::faces
};

/// A face with its nodes sorted, so that the two cells of an inner face name it alike.
template <std::size_t N>
struct FaceKey {
  std::array<Index, N> nodes;
  CellFace where;
};

/// One list of cells.
template <const CellKind& of, class Cell>
struct CellsOf {
  static constexpr const CellKind& kind = of;
  const std::vector<Cell>& cells;
};

template <const CellKind& kind, std::size_t N, class Cell>
std::array<Index, N> nodesOf(const Cell& cell, std::size_t face) {
  std::array<Index, N> nodes;
  for (std::size_t i = 0; i < N; ++i) nodes[i] = cell[kind.faces[face].nodes[i]];
  return nodes;
}

/// visit(where, nodes) for each face of N nodes.
template <std::size_t N, class Visit, class... Lists>
void forEachFace(Visit&& visit, const Lists&... lists) {
  Index number = 0;
  const auto look = [&]<class List>(const List& list) {
    for (const auto& cell : list.cells) {
      for (std::size_t f = 0; f < List::kind.faces.size(); ++f)
        if (kindOf(List::kind.faces[f].type).nodes == int(N)) visit(CellFace{number, int(f)}, nodesOf<List::kind, N>(cell, f));
      ++number;
    }
  };
  (look(lists), ...);
}
/// The nodes of one of them, as its cell has them.
template <std::size_t N, class... Lists>
std::array<Index, N> nodesAt(CellFace where, const Lists&... lists) {
  std::array<Index, N> nodes;
  const auto look = [&]<class List>(const List& list) {
    const Index count = Index(list.cells.size());
    if (where.cell >= 0 && where.cell < count) nodes = nodesOf<List::kind, N>(list.cells[where.cell], std::size_t(where.face));
    where.cell -= count;
  };
  (look(lists), ...);
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

template <std::size_t N, class... Lists>
FaceBuckets<N> bucketsOf(const Lists&... lists) {
  FaceBuckets<N> buckets;
  std::vector<std::size_t>& start = buckets.start;
  Index nodes = 0;
  const auto reach = [&nodes](CellFace, const auto& face) { nodes = std::max(nodes, 1 + *std::ranges::max_element(face)); };
  forEachFace<N>(reach, lists...);
  start.assign(std::size_t(nodes) + 1, 0);
  const auto add = [&start](CellFace, const auto& face) { ++start[std::size_t(*std::ranges::min_element(face)) + 1]; };
  forEachFace<N>(add, lists...);
  for (std::size_t n = 0; n < std::size_t(nodes); ++n) start[n + 1] += start[n];
  buckets.keys.resize(start.back());
  std::vector<std::size_t> next(start.begin(), start.end());
  const auto put = [&](CellFace where, std::array<Index, N> face) {
    std::sort(face.begin(), face.end());
    buckets.keys[next[face[0]]++] = {face, where};
  };
  forEachFace<N>(put, lists...);
  return buckets;
}

/// All faces, equal ones side by side and in the order of their cells.
template <std::size_t N, class... Lists>
std::vector<FaceKey<N>> sortedFaces(const Lists&... lists) {
  auto [keys, start] = bucketsOf<N>(lists...);
  for (std::size_t n = 0; n + 1 < start.size(); ++n)
    std::sort(keys.begin() + std::ptrdiff_t(start[n]), keys.begin() + std::ptrdiff_t(start[n + 1]), comesBefore<N>);
  return std::move(keys);
}

/// Those of one cell alone, in the same order. Most faces have a partner, which a list for each second node finds
/// without sorting.
template <std::size_t N, class... Lists>
std::vector<FaceKey<N>> loneFaces(const Lists&... lists) {
  const auto [keys, start] = bucketsOf<N>(lists...);
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

template <std::size_t N, class... Lists>
std::vector<std::array<Index, N>> uniqueFaces(bool boundary_only, const Lists&... lists) {
  const auto keys = boundary_only ? loneFaces<N>(lists...) : sortedFaces<N>(lists...);
  std::vector<std::array<Index, N>> out;
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (i == 0 || !sameNodes(keys[i - 1], keys[i])) out.push_back(nodesAt<N>(keys[i].where, lists...));
  return out;
}

using Tetrahedra = CellsOf<cell_kinds::tetrahedron, Tetrahedron>;
using Hexahedra = CellsOf<cell_kinds::hexahedron, Hexahedron>;
using Prisms = CellsOf<cell_kinds::prism, Prism>;
using Pyramids = CellsOf<cell_kinds::pyramid, Pyramid>;
using QuadraticTetrahedra = CellsOf<cell_kinds::quadratic_tetrahedron, QuadraticTetrahedron>;

}  // namespace

std::vector<Triangle> uniqueTriangles(const Mesh& mesh, bool boundary_only) {
  return uniqueFaces<3>(boundary_only, Tetrahedra{mesh.tetrahedra}, Prisms{mesh.prisms}, Pyramids{mesh.pyramids});
}

std::vector<Quad> uniqueQuads(const Mesh& mesh, bool boundary_only) {
  return uniqueFaces<4>(boundary_only, Hexahedra{mesh.hexahedra}, Prisms{mesh.prisms}, Pyramids{mesh.pyramids});
}

std::vector<QuadraticTriangle> uniqueQuadraticTriangles(const Mesh& mesh, bool boundary_only) {
  return uniqueFaces<6>(boundary_only, QuadraticTetrahedra{mesh.quadratic_tetrahedra});
}

}  // namespace stroma
