// SPDX-License-Identifier: LGPL-2.1-or-later
// SimpleTesselatedHexaTopologicalMapping: cuts each hexahedron of the input into eight.
//
// The nodes are those of the input, followed by the new ones of each cell in turn: the middles of its edges, of its faces, and its centre.
// With corners 0 to 7 in VTK's order, the edges are 01 12 32 03 04 15 26 37 45 56 76 47 and the faces 0123 0154 1265 3267 0374 4567. Part k
// is at corner k. Mesh2PointMechanicalMapping maps a state in the same way.
//
// Source: the name and the order are SOFA's. In SOFA an edge that two cells name in opposite directions has two middles.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-10"/>
//   <RegularGridTopology name="grid" n="3 2 2" min="0 0 0" max="2 1 1"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 3 6 9"/>
//   <Node name="fine">
//     <HexahedronSetTopologyContainer name="cells"/>
//     <SimpleTesselatedHexaTopologicalMapping input="@../grid" output="@cells"/>
//     <MechanicalObject/>
//     <Mesh2PointMechanicalMapping/>
//     <HexahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>
//   </Node>
// </Node>
#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "framework/mesh/topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class SplitHexahedra final : public TopologicalMapping {
 public:
  void declare(DataTable& table) override {
    table.addLink("input", input_).help("topology of hexahedra").required();
    table.addLink("output", output_).help("container to fill; without it the mapping is a topology itself");
    table.add("position", mesh_.position).alias("points").help("the nodes").unit("m").output();
    table.add("hexahedra", mesh_.hexahedra).help("eight for each of the input").output();
    table.add("pointNodes", nodes_).help("nodes of the input whose mean each node is, one node after the other").output();
    table.add("pointWeights", weights_).help("their weights").unit("-").output();
    table.add("pointEnds", ends_).help("of each node one past its last one in pointNodes").output();
    table.add("pointOffsets", offsets_).help("zero").unit("m").output();
  }

  void init() override {
    const Topology* source = input_.get();
    if (!source) throw ComponentError("there is no topology to take parts of", "input=\"@...\"");
    const Mesh& from = source->mesh();
    if (from.hexahedra.empty()) throw ComponentError(source->path() + " has no hexahedra", "a mesh that has some");
    mesh_ = Mesh();
    nodes_.clear();
    ends_.clear();
    weights_.clear();
    offsets_.clear();
    for (Index i = 0; i < from.nodes(); ++i) addMean(from, {i});
    std::map<std::vector<Index>, Index> known;  // by the sorted nodes whose mean it is
    for (const Hexahedron& cell : from.hexahedra) {
      std::array<Index, 27> all;
      for (std::size_t part = 0; part < 27; ++part) {
        std::vector<Index> of;
        for (const int corner : means[part])
          if (corner >= 0) of.push_back(cell[std::size_t(corner)]);
        if (part < 8) {
          all[part] = of[0];
          continue;
        }
        std::vector<Index> key = of;
        std::sort(key.begin(), key.end());
        const auto [found, is_new] = known.try_emplace(std::move(key), Index(mesh_.position.size()));
        if (is_new) addMean(from, of);
        all[part] = found->second;
      }
      for (const auto& part : parts) {
        Hexahedron& made = mesh_.hexahedra.emplace_back();
        for (std::size_t k = 0; k < 8; ++k) made[k] = all[std::size_t(part[k])];
      }
    }
  }

 private:
  static constexpr int no = -1;
  static constexpr int means[27][8] = {
      {0, no, no, no, no, no, no, no}, {1, no, no, no, no, no, no, no}, {2, no, no, no, no, no, no, no},
      {3, no, no, no, no, no, no, no}, {4, no, no, no, no, no, no, no}, {5, no, no, no, no, no, no, no},
      {6, no, no, no, no, no, no, no}, {7, no, no, no, no, no, no, no}, {0, 1, no, no, no, no, no, no},
      {1, 2, no, no, no, no, no, no},  {3, 2, no, no, no, no, no, no},  {0, 3, no, no, no, no, no, no},
      {0, 4, no, no, no, no, no, no},  {1, 5, no, no, no, no, no, no},  {2, 6, no, no, no, no, no, no},
      {3, 7, no, no, no, no, no, no},  {4, 5, no, no, no, no, no, no},  {5, 6, no, no, no, no, no, no},
      {7, 6, no, no, no, no, no, no},  {4, 7, no, no, no, no, no, no},  {0, 1, 2, 3, no, no, no, no},
      {0, 1, 5, 4, no, no, no, no},    {1, 2, 6, 5, no, no, no, no},    {3, 2, 6, 7, no, no, no, no},
      {0, 3, 7, 4, no, no, no, no},    {4, 5, 6, 7, no, no, no, no},    {0, 1, 2, 3, 4, 5, 6, 7}};
  static constexpr int parts[8][8] = {{0, 8, 20, 11, 12, 21, 26, 24},  {8, 1, 9, 20, 21, 13, 22, 26},
                                      {20, 9, 2, 10, 26, 22, 14, 23},  {11, 20, 10, 3, 24, 26, 23, 15},
                                      {12, 21, 26, 24, 4, 16, 25, 19}, {21, 13, 22, 26, 16, 5, 17, 25},
                                      {26, 22, 14, 23, 25, 17, 6, 18}, {24, 26, 23, 15, 19, 25, 18, 7}};

  void addMean(const Mesh& from, const std::vector<Index>& of) {
    Vec3 sum = Vec3::Zero();
    for (const Index node : of) sum += from.position[std::size_t(node)];
    mesh_.position.push_back(sum / double(of.size()));
    nodes_.insert(nodes_.end(), of.begin(), of.end());
    weights_.insert(weights_.end(), of.size(), 1 / double(of.size()));
    ends_.push_back(int(nodes_.size()));
    offsets_.push_back(Vec3::Zero());
  }

  std::vector<int> nodes_, ends_;
  std::vector<double> weights_;
  std::vector<Vec3> offsets_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(split_hexahedra_mapping) {
  factory.add<stroma::SplitHexahedra>("SimpleTesselatedHexaTopologicalMapping", "hexahedra cut into eight each");
}
