// SPDX-License-Identifier: LGPL-2.1-or-later
// The tables that Mesh derives from its cells. Each takes time linear in the number of cells and gives the same
// order whatever the order of evaluation.
#include <algorithm>

#include "framework/mesh/cell_faces.h"
#include "framework/mesh/cell_lists.h"

namespace stroma {

namespace {

/// Calls `visit(a, b)` with a < b for each edge of each cell.
template <class Visit>
void forEachEdge(const Mesh& mesh, Visit&& visit) {
  const auto ordered = [&visit](Index a, Index b) { a < b ? visit(a, b) : visit(b, a); };
  forEachCellList(
      [&](const CellKind& kind, const auto& cells) {
        for (const auto& cell : cells)
          for (const auto& [i, j] : kind.edges) ordered(cell[i], cell[j]);
      },
      mesh);
}

std::vector<Edge> uniqueEdges(const Mesh& mesh) {
  const std::size_t nodes = mesh.position.size();
  std::vector<std::size_t> start(nodes + 1, 0);
  forEachEdge(mesh, [&](Index a, Index) { ++start[a + 1]; });
  for (std::size_t n = 0; n < nodes; ++n) start[n + 1] += start[n];
  std::vector<Index> other(start.back());
  std::vector<std::size_t> next(start.begin(), start.end());
  forEachEdge(mesh, [&](Index a, Index b) { other[next[a]++] = b; });
  std::vector<Edge> edges;
  for (std::size_t n = 0; n < nodes; ++n) {
    const auto first = other.begin() + std::ptrdiff_t(start[n]), last = other.begin() + std::ptrdiff_t(start[n + 1]);
    std::sort(first, last);
    for (auto it = first, end = std::unique(first, last); it != end; ++it) edges.push_back({Index(n), *it});
  }
  return edges;
}

template <class Cell>
Adjacency cellsAroundNodes(const std::vector<Cell>& cells, std::size_t nodes) {
  Adjacency out;
  out.start.assign(nodes + 1, 0);
  for (const Cell& cell : cells)
    for (Index node : cell) ++out.start[node + 1];
  for (std::size_t n = 0; n < nodes; ++n) out.start[n + 1] += out.start[n];
  out.values.resize(out.start.back());
  std::vector<Index> next(out.start.begin(), out.start.end());
  for (std::size_t c = 0; c < cells.size(); ++c)
    for (Index node : cells[c]) out.values[next[node]++] = Index(c);
  return out;
}

Adjacency nodesAroundNodes(const std::vector<Edge>& edges, std::size_t nodes) {
  Adjacency out;
  out.start.assign(nodes + 1, 0);
  for (const auto& [a, b] : edges) ++out.start[a + 1], ++out.start[b + 1];
  for (std::size_t n = 0; n < nodes; ++n) out.start[n + 1] += out.start[n];
  out.values.resize(out.start.back());
  std::vector<Index> next(out.start.begin(), out.start.end());
  // Edges ascend in (a, b) with a < b: a first pass over the smaller ends, then one over the larger, fills every list
  // in ascending order.
  for (const auto& [a, b] : edges) out.values[next[b]++] = a;
  for (const auto& [a, b] : edges) out.values[next[a]++] = b;
  return out;
}

}  // namespace

const std::vector<Edge>& Mesh::allEdges() const {
  if (!all_edges_) all_edges_ = uniqueEdges(*this);
  return *all_edges_;
}

const std::vector<Triangle>& Mesh::tetrahedronFaces() const {
  if (!tetrahedron_faces_) tetrahedron_faces_ = uniqueFaces(tetrahedra, false);
  return *tetrahedron_faces_;
}

const std::vector<Triangle>& Mesh::boundaryTriangles() const {
  if (!boundary_triangles_) boundary_triangles_ = uniqueFaces(tetrahedra, true);
  return *boundary_triangles_;
}

const std::vector<Quad>& Mesh::boundaryQuads() const {
  if (!boundary_quads_) boundary_quads_ = uniqueFaces(hexahedra, true);
  return *boundary_quads_;
}

const std::vector<QuadraticTriangle>& Mesh::boundaryQuadraticTriangles() const {
  if (!boundary_quadratic_triangles_) boundary_quadratic_triangles_ = uniqueFaces(quadratic_tetrahedra, true);
  return *boundary_quadratic_triangles_;
}

const Adjacency& Mesh::tetrahedraAroundNode() const {
  if (!tetrahedra_around_node_) tetrahedra_around_node_ = cellsAroundNodes(tetrahedra, position.size());
  return *tetrahedra_around_node_;
}

const Adjacency& Mesh::hexahedraAroundNode() const {
  if (!hexahedra_around_node_) hexahedra_around_node_ = cellsAroundNodes(hexahedra, position.size());
  return *hexahedra_around_node_;
}

const Adjacency& Mesh::nodesAroundNode() const {
  if (!nodes_around_node_) nodes_around_node_ = nodesAroundNodes(allEdges(), position.size());
  return *nodes_around_node_;
}

int Mesh::derivedTables() const {
  return int(all_edges_.has_value()) + int(tetrahedron_faces_.has_value()) + int(boundary_triangles_.has_value()) +
         int(boundary_quads_.has_value()) + int(boundary_quadratic_triangles_.has_value()) +
         int(tetrahedra_around_node_.has_value()) + int(hexahedra_around_node_.has_value()) +
         int(nodes_around_node_.has_value());
}

}  // namespace stroma
