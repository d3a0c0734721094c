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
  const auto visitCells = [&ordered](const CellKind& kind, const auto& cells) {
    for (const auto& cell : cells)
      for (const auto& [i, j] : kind.edges) ordered(cell[i], cell[j]);
  };
  forEachCellList(visitCells, mesh);
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

/// The table, made when it is asked for first.
template <class Table, class Make>
const Table& made(std::optional<Table>& table, Make&& make) {
  if (!table) table = make();
  return *table;
}

}  // namespace

const std::vector<Edge>& Mesh::allEdges() const { return made(all_edges_, [&] { return uniqueEdges(*this); }); }
const std::vector<Triangle>& Mesh::triangularFaces() const {
  return made(triangular_faces_, [&] { return uniqueTriangles(*this, false); });
}
const std::vector<Triangle>& Mesh::boundaryTriangles() const {
  return made(boundary_triangles_, [&] { return uniqueTriangles(*this, true); });
}
const std::vector<Quad>& Mesh::boundaryQuads() const { return made(boundary_quads_, [&] { return uniqueQuads(*this, true); }); }
const std::vector<QuadraticTriangle>& Mesh::boundaryQuadraticTriangles() const {
  return made(boundary_quadratic_triangles_, [&] { return uniqueQuadraticTriangles(*this, true); });
}
const Adjacency& Mesh::nodesAroundNode() const {
  return made(nodes_around_node_, [&] { return nodesAroundNodes(allEdges(), position.size()); });
}

int Mesh::derivedTables() const {
  return int(all_edges_.has_value()) + int(triangular_faces_.has_value()) + int(boundary_triangles_.has_value()) +
         int(boundary_quads_.has_value()) + int(boundary_quadratic_triangles_.has_value()) + int(nodes_around_node_.has_value());
}

}  // namespace stroma
