// SPDX-License-Identifier: LGPL-2.1-or-later
// Springs between the nodes of the cells of a mesh, with the lengths of the rest shape.
//
// MeshSpringForceField: every pair of nodes of a cell is a spring: edges, sides of triangles, sides and diagonals of quads,
// edges of tetrahedra, edges and all diagonals of hexahedra. A pair has one spring whatever the number of cells that share it,
// with the stiffness and damping of the first kind that has one, in the order lines, triangles, quads, tetrahedra, cubes. A
// kind without stiffness and damping makes no springs. Edges and faces of solid cells are used as lines and faces if the mesh
// lists none. `stiffness` and `damping` set all kinds at once.
//
// RegularGridSpringForceField: the same for a grid: lines are the edges of its cells, quads the diagonals of their
// faces, cubes the diagonals through them.
//
//   E = sum k/2 (L - L0)^2, force and tangent as in SpringForceField; with noCompression only while L > L0
//
// With perLength="true" stiffness [N] and damping [N s] of a spring are divided by its length at rest, as SOFA does.
//
// Source: the attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-10"/>
//   <Node name="mesh">
//     <RegularGridTopology n="4 2 2" min="0 0 0" max="3 1 1"/>
//     <MechanicalObject name="dofs"/>
//     <UniformMass totalMass="1"/>
//     <FixedProjectiveConstraint indices="0 4 8 12"/>
//     <MeshSpringForceField stiffness="500"/>
//   </Node>
//   <Node name="grid">
//     <RegularGridTopology n="4 2 2" min="0 0 3" max="3 1 4"/>
//     <MechanicalObject name="dofs"/>
//     <UniformMass totalMass="1"/>
//     <FixedProjectiveConstraint indices="0 4 8 12"/>
//     <RegularGridSpringForceField linesStiffness="500" quadsStiffness="250" cubesStiffness="100" linesDamping="0"
//                                  quadsDamping="0" cubesDamping="0"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <set>

#include "components/springs/spring_field.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_faces.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// Stiffness [N/m] and damping [N s/m] of the springs of one kind of cell.
struct Kind {
  const char* name;
  const char* alias;
  double stiffness = 0, damping = 0;
  bool isSet() const { return stiffness != 0 || damping != 0; }
};

class MeshSprings : public SpringField {
 public:
  enum { lines, triangles, quads, tetrahedra, cubes };

  void declare(DataTable& table) override {
    ForceField::declare(table);
    declareDamping(table);
    topology_.declare(table, "mesh whose cells give the springs");
    table.add("perLength", per_length_).help("stiffness and damping are divided by the length of a spring at rest");
    table.add("stiffness", stiffness_).help("spring constant of all kinds of cells").unit("N/m").min(0).shorthand();
    table.add("damping", damping_of_all_).help("damping of all kinds of cells").unit("N s/m").min(0).shorthand();
    table.add("noCompression", no_compression_).help("springs resist elongation only");
    table.add("allowEmpty", allow_empty_).help("a mesh without cells that have springs is no error");
    table.add("localRange", range_).help("first and last node that springs may join; -1 -1: all nodes");
    table.add("rangeByEnds", range_by_ends_)
        .help("a spring may also join a node of localRange and one behind it, and each end of localRange counts alone, as in SOFA");
    for (const char* name : {"drawMinElongationRange", "drawMaxElongationRange", "drawSpringSize"})
      table.addVisualOnly(name);
  }

 protected:
  void declareKind(DataTable& table, int kind) {
    Kind& k = kinds_[kind];
    Data& stiffness = table.add(fmt::format("{}Stiffness", k.name), k.stiffness);
    stiffness.help(fmt::format("spring constant of {}", k.name)).unit("N/m").min(0);
    Data& damping = table.add(fmt::format("{}Damping", k.name), k.damping);
    damping.help(fmt::format("damping of {}", k.name)).unit("N s/m").min(0);
    if (!k.alias) return;
    table.find(fmt::format("{}Stiffness", k.name))->alias(fmt::format("{}Stiffness", k.alias));
    table.find(fmt::format("{}Damping", k.name))->alias(fmt::format("{}Damping", k.alias));
  }

  /// The mesh of the springs. Throws ComponentError.
  const Mesh& findMesh() {
    ForceField::init();
    const Topology* topology = topology_.find(*this, state());
    mesh_ = topology ? &topology->mesh() : nullptr;
    if (!topology) throw ComponentError("no mesh gives the springs", "a topology in this node or above");
    if (range_.size() != 2) throw ComponentError(fmt::format("localRange has {} values", range_.size()), "2 values");
    return topology->mesh();
  }

  /// A spring for the pair unless there is one already.
  void addPair(Index i, Index j, int kind) {
    if (i > j) std::swap(i, j);
    if (isOutOfRange(i, j)) return;
    if (!pairs_.insert({i, j}).second) return;
    springs_.push_back({i, j, kinds_[kind].stiffness, kinds_[kind].damping, 0, no_compression_});
  }

  void finish(const char* expected) {
    const std::string empty = "there is no spring: no kind of cell in the mesh has a stiffness";
    if (springs_.empty() && !allow_empty_) throw ComponentError(empty, expected);
    if (springs_.empty()) warn(empty, expected);
    for (Spring& spring : springs_) {
      spring.length = grid_lengths_ ? gridDistance(spring) : restDistance(spring);
      if (!per_length_) continue;
      if (!(spring.length > 0))
        throw ComponentError(fmt::format("nodes {} and {} are one place at rest", spring.a, spring.b),
                             "nodes apart, or perLength=\"false\"");
      spring.stiffness /= spring.length, spring.damping /= spring.length;
    }
    setSprings(std::move(springs_));
    pairs_.clear();
  }

  /// `stiffness` and `damping` where a kind has none of its own.
  void spreadToKinds() {
    for (Kind& kind : kinds_) {
      if (data().find("stiffness")->isSet()) overwrite(kind.stiffness, stiffness_, kind, "Stiffness");
      if (data().find("damping")->isSet()) overwrite(kind.damping, damping_of_all_, kind, "Damping");
    }
  }

  void warnOfDefault(const Kind& kind) const {
    const Data* own = data().find(std::string(kind.name) + "Stiffness");
    if (!own->isSet() && !data().find("stiffness")->isSet())
      warn(fmt::format("{} is not given: the default {:g} N/m is used", own->name(), kind.stiffness), "stiffness, of all kinds of cells");
  }

  bool grid_lengths_ = false;  ///< lengths at rest are those of the mesh, wherever the state puts its nodes
  Kind kinds_[5] = {
      {"lines", nullptr}, {"triangles", nullptr}, {"quads", nullptr}, {"tetrahedra", "tetras"}, {"cubes", "hexas"}};

 private:
  bool isOutOfRange(Index i, Index j) const {  // i < j
    if (range_by_ends_) return i < range_[0] || (range_[1] >= 0 && i > range_[1]);
    return range_[0] >= 0 && range_[1] >= 0 && (i < range_[0] || j > range_[1]);
  }
  void overwrite(double& value, double all, const Kind& kind, const char* what) const {
    const Data* own = data().find(std::string(kind.name) + what);
    if (own && !own->isSet()) value = all;
  }
  double gridDistance(const Spring& spring) const {
    const std::vector<Vec3>& places = mesh_->position;
    return (places.at(std::size_t(spring.b)) - places.at(std::size_t(spring.a))).norm();
  }
  TopologyLink topology_;
  const Mesh* mesh_ = nullptr;
  bool no_compression_ = false, per_length_ = false, allow_empty_ = false, range_by_ends_ = false;
  double stiffness_ = 0, damping_of_all_ = 0;
  std::vector<int> range_{-1, -1};
  std::set<Edge> pairs_;
  std::vector<Spring> springs_;
};

std::vector<Quad> quadsOf(const Mesh& mesh) {
  return mesh.quads.empty() ? uniqueQuads(mesh, false) : mesh.quads;
}

class MeshSpringForceField final : public MeshSprings {
 public:
  void declare(DataTable& table) override {
    MeshSprings::declare(table);
    for (int kind : {lines, triangles, quads, tetrahedra, cubes}) declareKind(table, kind);
    table.add("listedLines", listed_lines_).help("lines are the edges that the mesh lists, if there are any, and not those of its cells");
  }

  void init() override {
    const Mesh& mesh = findMesh();
    spreadToKinds();
    if (kinds_[lines].isSet()) addAllPairs(listed_lines_ && !mesh.edges.empty() ? mesh.edges : mesh.allEdges(), lines);
    if (kinds_[triangles].isSet())
      addAllPairs(mesh.triangles.empty() ? mesh.triangularFaces() : mesh.triangles, triangles);
    if (kinds_[quads].isSet()) addAllPairs(quadsOf(mesh), quads);
    if (kinds_[tetrahedra].isSet()) addAllPairs(mesh.tetrahedra, tetrahedra);
    if (kinds_[cubes].isSet()) addAllPairs(mesh.hexahedra, cubes);
    finish("stiffness, or linesStiffness ... cubesStiffness of cells that the mesh has");
  }

 private:
  bool listed_lines_ = false;
  template <class Cell>
  void addAllPairs(const std::vector<Cell>& cells, int kind) {
    for (const Cell& cell : cells)
      for (std::size_t i = 0; i < cell.size(); ++i)
        for (std::size_t j = i + 1; j < cell.size(); ++j) addPair(cell[i], cell[j], kind);
  }
};

class RegularGridSpringForceField final : public MeshSprings {
 public:
  RegularGridSpringForceField() {
    for (int kind : {lines, quads, cubes}) kinds_[kind].stiffness = 100;
  }
  void declare(DataTable& table) override {
    MeshSprings::declare(table);
    for (int kind : {lines, quads, cubes}) declareKind(table, kind);
    table.add("gridLengths", grid_lengths_)
        .help("lengths at rest are the distances in the grid, also if the state scales its nodes, as in SOFA");
  }

  void init() override {
    const Mesh& mesh = findMesh();
    spreadToKinds();
    if (mesh.hexahedra.empty() && mesh.quads.empty() && mesh.edges.empty())
      throw ComponentError("the mesh has no cells of a grid", "a RegularGridTopology");
    for (const int kind : {lines, quads, cubes})
      if (kind != cubes || !mesh.hexahedra.empty()) warnOfDefault(kinds_[kind]);
    if (kinds_[lines].isSet())
      for (const Edge& edge : mesh.allEdges()) addPair(edge[0], edge[1], lines);
    if (kinds_[quads].isSet())
      for (const Quad& face : quadsOf(mesh)) addPair(face[0], face[2], quads), addPair(face[1], face[3], quads);
    if (kinds_[cubes].isSet())
      for (const Hexahedron& cell : mesh.hexahedra)
        for (const auto& [i, j] : {Edge{0, 6}, Edge{1, 7}, Edge{2, 4}, Edge{3, 5}}) addPair(cell[i], cell[j], cubes);
    finish("linesStiffness, quadsStiffness or cubesStiffness");
  }
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_spring_force_field) {
  factory.add<stroma::MeshSpringForceField>("MeshSpringForceField", "springs between all nodes of each cell of a mesh");
  factory.add<stroma::RegularGridSpringForceField>("RegularGridSpringForceField",
                                                   "springs along the edges and diagonals of a grid");
}
