// SPDX-License-Identifier: LGPL-2.1-or-later
// Raises the order of a mesh: tetrahedra become quadratic ones of ten nodes, triangles become quadratic triangles of six. Each edge gets a
// node at its middle, which its cells share.
//
// The nodes of the linear mesh come first and keep their numbers. The new nodes follow in the order of the edges, sorted by the smaller,
// then the larger end. Cells keep their order. So a list with one value per tetrahedron (materials, labels, fibres) also fits the
// quadratic tetrahedra, and the index of a triangle is that of its quadratic triangle: pass what was in triangleIndices of a load to
// quadraticTriangleIndices. Edges are straight. Meshes with curved edges come from a file (MeshGmshLoader, MeshVTKLoader).
//
// A selection by position (BoxROI on the raised mesh) includes the new nodes. Pass a selection by numbers of the linear mesh to `indices`.
// `raisedIndices` then also has the middles of edges between two of these nodes. If the mesh lists triangles, only edges of triangles whose
// corners are all selected count.
//
// Without `input` the mesh is that of another topology in this node, or of the nearest node above.
//
// Source: the node order of VTK's quadratic cells.
//
// Example:
// <Node name="root">
//   <RegularGridTopology name="grid" n="2 2 3" min="0 0 0" max="1 1 2"/>
//   <Node name="body">
//     <Hexa2TetraTopologicalMapping name="tets" input="@../grid"/>
//     <Linear2QuadraticTopologicalMapping name="mesh" input="@tets"/>
//     <MechanicalObject src="@mesh"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "framework/mesh/cell_attributes.h"
#include "framework/mesh/topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class Linear2QuadraticTopologicalMapping : public Topology {
 public:
  void declare(DataTable& table) override {
    table.addLink("input", input_)
        .help("topology with tetrahedra or triangles; without it, another one of this node or the nearest above");
    table.add("indices", indices_).help("nodes of the linear mesh to be raised, as a selection");
    table.add("raisedIndices", raised_indices_).help("indices, with the middles between two of them").output();
    table.add("position", mesh_.position).alias("points").unit("m").help("nodes").output();
    addCellList(table, cell_kinds::quadratic_tetrahedron, mesh_.quadratic_tetrahedra)
        .help("the tetrahedra, ten nodes each")
        .output();
    addCellList(table, cell_kinds::quadratic_triangle, mesh_.quadratic_triangles)
        .help("the triangles, six nodes each")
        .output();
  }

  void init() override {
    const Topology* source = input_.target() ? input_.get() : otherTopology();
    if (!source)
      throw ComponentError("there is no topology to raise", "input=\"@...\", or a topology in this node or above");
    const Mesh& from = source->mesh();
    if (from.tetrahedra.empty() && from.triangles.empty())
      throw ComponentError(fmt::format("{} has neither tetrahedra nor triangles", source->path()),
                           "a topology with tetrahedra or triangles",
                           from.hexahedra.empty() ? "" : "cut its hexahedra with Hexa2TetraTopologicalMapping");
    if (!from.hexahedra.empty() || !from.quads.empty())
      throw ComponentError(fmt::format("{} has hexahedra or quads too, which would be lost", source->path()),
                           "a topology of tetrahedra and triangles alone");
    mesh_.position = from.position;
    mesh_.overlap = from.overlap;
    mesh_.quadratic_tetrahedra = raised<QuadraticTetrahedron>(from.tetrahedra, cell_tables::tetrahedron_middles);
    mesh_.quadratic_triangles = raised<QuadraticTriangle>(from.triangles, cell_tables::triangle_middles);
    number(from.position);
    raiseIndices(from);
  }

 private:
  Topology* otherTopology() const {
    for (const auto& component : node().components())
      if (auto* other = dynamic_cast<Topology*>(component.get()); other && other != this) {
        other->ensureReady();
        return other;
      }
    return node().parent() ? node().parent()->find<Topology>(this, true) : nullptr;
  }

  /// The cells, with their middles still without a number; the edges go to middle_.
  template <class Raised, class Cell, std::size_t E>
  std::vector<Raised> raised(const std::vector<Cell>& cells, const std::array<std::array<int, 2>, E>& middles) {
    std::vector<Raised> out;
    out.reserve(cells.size());
    for (const Cell& cell : cells) {
      Raised& more = out.emplace_back();
      std::copy(cell.begin(), cell.end(), more.begin());
      for (const auto& [a, b] : middles) edges_.push_back(sorted(cell[a], cell[b]));
    }
    return out;
  }
  static Edge sorted(Index a, Index b) { return {std::min(a, b), std::max(a, b)}; }

  /// Gives each edge a node.
  void number(const std::vector<Vec3>& corners) {
    const std::vector<Edge> of_cells = std::move(edges_);
    edges_ = of_cells;
    std::sort(edges_.begin(), edges_.end());
    edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
    for (const auto& [a, b] : edges_) mesh_.position.push_back((corners[a] + corners[b]) / 2);
    auto next = of_cells.begin();
    const auto fill = [&](auto& cells, std::size_t first) {
      for (auto& cell : cells)
        for (std::size_t k = first; k < cell.size(); ++k) cell[k] = middleOf(*next++);
    };
    first_middle_ = Index(corners.size());
    fill(mesh_.quadratic_tetrahedra, 4);
    fill(mesh_.quadratic_triangles, 3);
  }
  Index middleOf(const Edge& edge) const {
    return first_middle_ + Index(std::lower_bound(edges_.begin(), edges_.end(), edge) - edges_.begin());
  }

  void raiseIndices(const Mesh& from) {
    std::vector<char> selected(from.position.size(), 0);
    for (std::size_t i = 0; i < indices_.size(); ++i) {
      if (indices_[i] < 0 || std::size_t(indices_[i]) >= selected.size())
        throw ComponentError(
            fmt::format("indices[{}] is {}, and the mesh has {} nodes", i, indices_[i], selected.size()),
            fmt::format("indices in 0 ... {}", selected.size() - 1));
      selected[indices_[i]] = 1;
    }
    raised_indices_ = indices_;
    const auto take = [&](const Edge& edge) {
      if (selected[edge[0]] && selected[edge[1]]) raised_indices_.push_back(middleOf(edge));
    };
    if (from.triangles.empty()) {
      for (const Edge& edge : edges_) take(edge);
    } else {
      for (const Triangle& t : from.triangles)
        if (selected[t[0]] && selected[t[1]] && selected[t[2]])
          for (const auto& [a, b] : cell_tables::triangle_edges) take(sorted(t[a], t[b]));
    }
    std::sort(raised_indices_.begin(), raised_indices_.end());
    raised_indices_.erase(std::unique(raised_indices_.begin(), raised_indices_.end()), raised_indices_.end());
  }

  Link<Topology> input_{"topology"};
  std::vector<int> indices_, raised_indices_;
  std::vector<Edge> edges_;  ///< ascending; node first_middle_ + i lies on edge i
  Index first_middle_ = 0;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(linear2quadratic_topological_mapping) {
  factory.add<stroma::Linear2QuadraticTopologicalMapping>(
      "Linear2QuadraticTopologicalMapping",
      "raises tetrahedra and triangles to second order, with nodes on their edges");
}
