// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mesh/cell_faces.h"

#include <algorithm>

namespace stroma {

namespace {

/// A face with its nodes sorted, so that the two cells of an inner face name it alike.
template <std::size_t N>
struct FaceKey {
  std::array<Index, N> nodes;
  CellFace where;
};

template <class Cell, std::size_t Faces, std::size_t N>
std::array<Index, N> facesNodes(const Cell& cell, const std::array<std::array<int, N>, Faces>& faces, int face) {
  std::array<Index, N> nodes;
  for (std::size_t i = 0; i < N; ++i) nodes[i] = cell[std::size_t(faces[std::size_t(face)][i])];
  return nodes;
}

/// All faces, equal ones side by side and in the order of their cells. Buckets by the smallest node keep the time
/// linear: a bucket holds the few faces around a node.
template <class Cell, std::size_t Faces, std::size_t N>
std::vector<FaceKey<N>> sortedFaces(const std::vector<Cell>& cells,
                                    const std::array<std::array<int, N>, Faces>& faces) {
  Index nodes = 0;
  for (const Cell& cell : cells) nodes = std::max(nodes, *std::max_element(cell.begin(), cell.end()) + 1);
  const auto smallest = [&](const Cell& cell, std::size_t f) {
    Index least = cell[std::size_t(faces[f][0])];
    for (const int i : faces[f]) least = std::min(least, cell[std::size_t(i)]);
    return std::size_t(least);
  };
  std::vector<std::size_t> start(std::size_t(nodes) + 1, 0);
  for (const Cell& cell : cells)
    for (std::size_t f = 0; f < Faces; ++f) ++start[smallest(cell, f) + 1];
  for (std::size_t n = 0; n < std::size_t(nodes); ++n) start[n + 1] += start[n];
  std::vector<FaceKey<N>> sorted(cells.size() * Faces);
  std::vector<std::size_t> next(start.begin(), start.end());
  for (std::size_t c = 0; c < cells.size(); ++c)
    for (std::size_t f = 0; f < Faces; ++f) {
      auto key = facesNodes(cells[c], faces, int(f));
      std::sort(key.begin(), key.end());
      sorted[next[std::size_t(key[0])]++] = {key, {Index(c), int(f)}};
    }
  for (std::size_t n = 0; n < std::size_t(nodes); ++n)
    std::sort(sorted.begin() + std::ptrdiff_t(start[n]), sorted.begin() + std::ptrdiff_t(start[n + 1]),
              [](const FaceKey<N>& a, const FaceKey<N>& b) {
                return a.nodes != b.nodes ? a.nodes < b.nodes : a.where.cell < b.where.cell;
              });
  return sorted;
}

template <class Cell, std::size_t Faces, std::size_t N>
std::vector<std::array<Index, N>> uniqueFacesOf(const std::vector<Cell>& cells,
                                                const std::array<std::array<int, N>, Faces>& faces,
                                                bool boundary_only) {
  const auto keys = sortedFaces(cells, faces);
  std::vector<std::array<Index, N>> out;
  for (std::size_t i = 0; i < keys.size();) {
    std::size_t end = i + 1;
    while (end < keys.size() && keys[end].nodes == keys[i].nodes) ++end;
    if (!boundary_only || end == i + 1)
      out.push_back(facesNodes(cells[std::size_t(keys[i].where.cell)], faces, keys[i].where.face));
    i = end;
  }
  return out;
}

}  // namespace

std::vector<Triangle> uniqueFaces(const std::vector<Tetrahedron>& cells, bool boundary_only) {
  return uniqueFacesOf(cells, tetrahedron_faces, boundary_only);
}

std::vector<Quad> uniqueFaces(const std::vector<Hexahedron>& cells, bool boundary_only) {
  return uniqueFacesOf(cells, hexahedron_faces, boundary_only);
}

std::vector<std::array<CellFace, 2>> sharedFaces(const std::vector<Hexahedron>& cells) {
  const auto keys = sortedFaces(cells, hexahedron_faces);
  std::vector<std::array<CellFace, 2>> out;
  for (std::size_t i = 0; i + 1 < keys.size(); ++i)
    if (keys[i].nodes == keys[i + 1].nodes) out.push_back({keys[i].where, keys[i + 1].where});
  return out;
}

}  // namespace stroma
