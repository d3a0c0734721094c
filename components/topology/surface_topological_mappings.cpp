// SPDX-License-Identifier: LGPL-2.1-or-later
// Meshes made of the parts of another mesh. Nodes are the same and keep their numbers.
//
// Tetra2TriangleTopologicalMapping: the faces of only one tetrahedron, oriented outward (flipNormals: inward).
// Hexa2QuadTopologicalMapping: the same for hexahedra.
// Triangle2EdgeTopologicalMapping: the edges of only one triangle, the border of a surface.
// Quad2TriangleTopologicalMapping: two triangles per quad. Quad q of a grid of nx by ny cells is cut along the diagonal of
//   its corners 1 and 3, (0 1 3)(2 3 1), if swapping is on and one of q mod nx and q / nx is odd. Otherwise it is cut along 0 and 2,
//   (1 2 0)(3 0 2). Without a grid nx is 2.
// IdentityTopologicalMapping: all cells.
// Faces are in the order of their cells.
//
// The mesh goes to the container named by `output`. Without one, the mapping itself is the topology of its node.
//
// Source: the names, attributes and diagonals are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-10"/>
//   <RegularGridTopology name="grid" n="3 3 3" min="0 0 0" max="1 1 1"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="1"/>
//   <HexahedronFEMForceField youngModulus="1e4" poissonRatio="0.3"/>
//   <Node name="skin">
//     <QuadSetTopologyContainer name="quads"/>
//     <Hexa2QuadTopologicalMapping input="@../grid" output="@quads"/>
//     <SurfacePressureForceField topology="@quads" pressure="100"/>
//     <Node name="cut">
//       <TriangleSetTopologyContainer name="triangles"/>
//       <Quad2TriangleTopologicalMapping input="@../quads" output="@triangles"/>
//     </Node>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "framework/mesh/cell_attributes.h"
#include "framework/mesh/cell_lists.h"
#include "framework/mesh/simplex_size.h"
#include "framework/mesh/topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// The parts (faces, edges) that belong to a single cell, in the order of the cells and of `parts`, local nodes.
template <class Part, class Cell, std::size_t count>
std::vector<Part> singleParts(const std::vector<Cell>& cells, const std::array<Part, count>& parts) {
  std::map<Part, int> uses;
  const auto partOf = [](const Cell& cell, const Part& local) {
    Part part;
    for (std::size_t i = 0; i < part.size(); ++i) part[i] = cell[local[i]];
    return part;
  };
  const auto sorted = [](Part part) { return std::sort(part.begin(), part.end()), part; };
  for (const Cell& cell : cells)
    for (const Part& local : parts) ++uses[sorted(partOf(cell, local))];
  std::vector<Part> single;
  for (const Cell& cell : cells)
    for (const Part& local : parts)
      if (const Part part = partOf(cell, local); uses.at(sorted(part)) == 1) single.push_back(part);
  return single;
}

/// Faces opposite to nodes 0 to 3, outward of a cell of positive volume.
constexpr std::array<Triangle, 4> tetrahedron_faces{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
constexpr std::array<Quad, 6> hexahedron_faces{
    {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};
constexpr std::array<Edge, 3> triangle_sides{{{1, 2}, {2, 0}, {0, 1}}};

class SurfaceMapping : public TopologicalMapping {
 public:
  void declare(DataTable& table) override {
    table.addLink("input", input_).help("topology whose parts are taken; without it, that of the nearest node above");
    table.addLink("output", output_).help("container to fill; without it the mapping is a topology itself");
    table.add("position", mesh_.position).alias("points").unit("m").help("nodes").output();
  }
  void init() override {
    const Topology* source = input_.target() ? input_.get() : above();
    if (!source) throw ComponentError("there is no topology to take parts of", "input=\"@...\"");
    if (input_.target() && input_.target() == output_.target())
      throw ComponentError("input and output are the same topology", "two topologies");
    mesh_ = Mesh();
    mesh_.position = source->mesh().position;
    take(*source, source->mesh());
  }

 protected:
  virtual void take(const Topology& source, const Mesh& from) = 0;
  template <class Cell>
  static void flip(std::vector<Cell>& cells) {
    for (Cell& cell : cells) std::reverse(cell.begin() + 1, cell.end());
  }

 private:
  Topology* above() const { return node().parent() ? node().parent()->find<Topology>(this, true) : nullptr; }
};

class Tetra2Triangle final : public SurfaceMapping {
 public:
  void declare(DataTable& table) override {
    SurfaceMapping::declare(table);
    table.add("flipNormals", flip_).help("turn the faces inward");
    table.add("noInitialTriangles", none_).help("take no faces");
    table.addVisualOnly("noNewTriangles");
    addCellList(table, cell_kinds::triangle, mesh_.triangles).help("the faces").output();
  }
  void take(const Topology&, const Mesh& from) override {
    if (none_) return;
    std::vector<Tetrahedron> cells = from.tetrahedra;
    for (Tetrahedron& cell : cells)  // faces of an inverted cell are outward all the same
      if (tetrahedronVolume(from.position[cell[0]], from.position[cell[1]], from.position[cell[2]],
                            from.position[cell[3]]) < 0)
        std::swap(cell[2], cell[3]);
    mesh_.triangles = singleParts<Triangle>(cells, tetrahedron_faces);
    if (flip_) flip(mesh_.triangles);
  }

 private:
  bool flip_ = false, none_ = false;
};

class Hexa2Quad final : public SurfaceMapping {
 public:
  void declare(DataTable& table) override {
    SurfaceMapping::declare(table);
    table.add("flipNormals", flip_).help("turn the faces inward");
    addCellList(table, cell_kinds::quad, mesh_.quads).help("the faces").output();
  }
  void take(const Topology&, const Mesh& from) override {
    mesh_.quads = singleParts<Quad>(from.hexahedra, hexahedron_faces);
    if (flip_) flip(mesh_.quads);
  }

 private:
  bool flip_ = false;
};

class Triangle2Edge final : public SurfaceMapping {
 public:
  void declare(DataTable& table) override {
    SurfaceMapping::declare(table);
    addCellList(table, cell_kinds::edge, mesh_.edges).help("the border").output();
  }
  void take(const Topology&, const Mesh& from) override {
    mesh_.edges = singleParts<Edge>(from.triangles, triangle_sides);
  }
};

class Quad2Triangle final : public SurfaceMapping {
 public:
  void declare(DataTable& table) override {
    SurfaceMapping::declare(table);
    table.add("flipNormals", flip_).help("turn the triangles round");
    table.add("swapping", swapping_).help("diagonals alternate from quad to quad");
    addCellList(table, cell_kinds::triangle, mesh_.triangles).help("the halves").output();
  }
  void take(const Topology& source, const Mesh& from) override {
    std::array<int, 3> nodes{};
    if (const Data* n = source.data().find("n"))
      if (auto* const* value = std::get_if<std::array<int, 3>*>(&n->pointer())) nodes = **value;
    const int across = nodes[0] > 1 ? nodes[0] - 1 : 2;
    for (int i = 0; i < int(from.quads.size()); ++i) {
      const Quad& q = from.quads[std::size_t(i)];
      if (swapping_ && ((i % across) ^ (i / across)) & 1) {
        mesh_.triangles.push_back({q[0], q[1], q[3]});
        mesh_.triangles.push_back({q[2], q[3], q[1]});
      } else {
        mesh_.triangles.push_back({q[1], q[2], q[0]});
        mesh_.triangles.push_back({q[3], q[0], q[2]});
      }
    }
    if (flip_) flip(mesh_.triangles);
  }

 private:
  bool flip_ = false, swapping_ = true;
};

class WholeMesh final : public SurfaceMapping {
 public:
  void take(const Topology&, const Mesh& from) override { mesh_ = from; }
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(surface_topological_mappings) {
  factory.add<stroma::Tetra2Triangle>("Tetra2TriangleTopologicalMapping", "the surface of tetrahedra");
  factory.add<stroma::Hexa2Quad>("Hexa2QuadTopologicalMapping", "the surface of hexahedra");
  factory.add<stroma::Triangle2Edge>("Triangle2EdgeTopologicalMapping", "the border of a surface");
  factory.add<stroma::Quad2Triangle>("Quad2TriangleTopologicalMapping", "quads cut into triangles");
  factory.add<stroma::WholeMesh>("IdentityTopologicalMapping", "all cells of another mesh");
}
