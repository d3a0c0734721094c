// SPDX-License-Identifier: LGPL-2.1-or-later
// Resistance of a surface to bending, by springs across the edges that two of its cells share.
//
// TriangularBendingSprings: a spring joins the two nodes opposite each inner edge of the triangles.
// QuadBendingSprings: two springs across each inner edge of the quads, each in line with a side of them: with the
// shared edge (i, j) and the quads (a, i, j, b) and (j, i, c, d), from a to c and from b to d.
//
//   E = sum k/2 (L - L0)^2, force and tangent as in SpringForceField; L0 is the distance in the rest shape
//
// Bending a flat surface shortens these springs only to second order: they resist weakly about flat shapes, and to first order
// about curved ones. An edge shared by more than two cells has a spring for each pair of them.
//
// Source: the names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-10"/>
//   <Node name="triangles">
//     <MechanicalObject position="0 0 0  1 0 0  0.5 1 0  0.5 -1 0.2"/>
//     <MeshTopology position="0 0 0  1 0 0  0.5 1 0  0.5 -1 0.2" triangles="0 1 2  1 0 3"/>
//     <UniformMass totalMass="0.1"/>
//     <FixedProjectiveConstraint indices="0 1"/>
//     <MeshSpringForceField linesStiffness="500"/>
//     <TriangularBendingSprings stiffness="300" damping="0"/>
//   </Node>
//   <Node name="quads">
//     <RegularGridTopology n="4 3 1" min="0 0 1" max="3 2 1"/>
//     <MechanicalObject/>
//     <UniformMass totalMass="0.1"/>
//     <FixedProjectiveConstraint indices="0 4 8"/>
//     <MeshSpringForceField quadsStiffness="500"/>
//     <QuadBendingSprings stiffness="300" damping="0"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <map>

#include "components/springs/spring_field.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// A cell seen from one of its edges: the nodes that follow the edge's ends around the cell.
struct Wing {
  Index after_first, after_second;  ///< neighbours of the edge's lower and higher node, not on the edge
};

template <class Cell>
std::map<Edge, std::vector<Wing>> wingsOf(const std::vector<Cell>& cells) {
  std::map<Edge, std::vector<Wing>> wings;
  constexpr std::size_t n = std::tuple_size_v<Cell>;
  for (const Cell& cell : cells)
    for (std::size_t i = 0; i < n; ++i) {
      const Index a = cell[i], b = cell[(i + 1) % n], before_a = cell[(i + n - 1) % n], after_b = cell[(i + 2) % n];
      wings[{std::min(a, b), std::max(a, b)}].push_back(a < b ? Wing{before_a, after_b} : Wing{after_b, before_a});
    }
  return wings;
}

template <class Cell>
const std::vector<Cell>& cellsOf(const Mesh& mesh);
template <>
const std::vector<Triangle>& cellsOf<Triangle>(const Mesh& mesh) {
  return mesh.triangles;
}
template <>
const std::vector<Quad>& cellsOf<Quad>(const Mesh& mesh) {
  return mesh.quads;
}

template <class Cell>
class BendingSprings final : public SpringField {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    declareDamping(table);
    topology_.declare(table, "surface");
    table.add("stiffness", stiffness_).help("spring constant").unit("N/m").min(0).physical();
    table.add("damping", damping_).help("force along a spring over its speed of elongation").unit("N s/m").min(0).physical();
    table.add("allowEmpty", allow_empty_).help("a mesh without inner edges of such cells is no error");
    table.add("localRange", range_).help("first and last node that springs may join; -1 -1: all nodes");
    for (const char* name : {"showSprings", "drawMode", "showArrowSize"}) table.addVisualOnly(name);
  }

  void init() override {
    ForceField::init();
    const CellKind& kind = std::tuple_size_v<Cell> == 3 ? cell_kinds::triangle : cell_kinds::quad;
    const Topology* any = allow_empty_ ? topology_.find(*this, state()) : nullptr;
    const Mesh& mesh = any ? any->mesh() : topology_.meshWith(kind, *this, state());
    if (range_.size() != 2) throw ComponentError(fmt::format("localRange has {} values", range_.size()), "2 values");
    std::map<Edge, bool> springs;
    bool shares_edges = false;
    for (const auto& [edge, wings] : wingsOf(cellsOf<Cell>(mesh)))
      for (std::size_t i = 0; i < wings.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
          shares_edges = true;
          addPair(wings[i].after_first, wings[j].after_first, springs);
          addPair(wings[i].after_second, wings[j].after_second, springs);
        }
    const std::string why = shares_edges ? "localRange has both ends of no spring" : "no two cells of the surface share an edge";
    const std::string wanted = shares_edges ? "a wider range" : "a connected surface";
    if (springs.empty() && !allow_empty_) throw ComponentError(why, wanted);
    if (springs.empty()) warn("there is no spring: " + why, wanted);
    std::vector<Spring> list;
    for (const auto& [pair, unused] : springs) {
      list.push_back({pair[0], pair[1], stiffness_, damping_, 0});
      list.back().length = restDistance(list.back());
    }
    setSprings(std::move(list));
  }

 private:
  void addPair(Index i, Index j, std::map<Edge, bool>& springs) const {
    const Edge pair{std::min(i, j), std::max(i, j)};
    const bool outside = range_[0] >= 0 && range_[1] >= 0 && (pair[0] < range_[0] || pair[1] > range_[1]);
    if (i != j && !outside) springs[pair] = true;
  }

  TopologyLink topology_;
  bool allow_empty_ = false;
  double stiffness_ = 1e5, damping_ = 1;
  std::vector<int> range_{-1, -1};
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(bending_springs) {
  factory.add<stroma::BendingSprings<stroma::Triangle>>("TriangularBendingSprings",
                                                        "springs across the inner edges of triangles");
  factory.add<stroma::BendingSprings<stroma::Quad>>("QuadBendingSprings", "springs across the inner edges of quads");
}
