// SPDX-License-Identifier: LGPL-2.1-or-later
// Nodes of several states combined to one state, and the centre of mass of states.
//
//   SubsetMultiMapping    x_i = x of node indexPairs[2 i + 1] of state indexPairs[2 i] of `input`
//   IdentityMultiMapping  all nodes of the states of `input`, one state after the other
//   CenterOfMassMapping   x = sum m_i x_i / sum m_i, with the masses m_i of the state that is followed; one node
//   CenterOfMassMultiMapping   the same of several states together
//
// A soft body whose nodes are partly free and partly fixed in rigid bodies is such a state: its free nodes are those of one
// parent, the others those of points that a RigidMapping carries. Forces of its elements then act on both. A force on the
// centre of mass is distributed over the masses. Points mapped from frames follow the centres.
//
// A child state without positions gets the required number of nodes.
//
// Source: the names and the attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="25" tolerance="1e-8"/>
//   <Node name="a">
//     <MechanicalObject name="dofs" position="0 0 0"/>
//     <UniformMass totalMass="1"/>
//   </Node>
//   <Node name="b">
//     <MechanicalObject name="dofs" position="2 0 0  1 0 0"/>
//     <UniformMass totalMass="2"/>
//     <Node name="middle">
//       <MechanicalObject name="centre"/>
//       <CenterOfMassMapping/>
//       <ConstantForceField forces="0 0 0.1"/>
//     </Node>
//   </Node>
//   <Node name="common">
//     <MechanicalObject name="centre_of_all"/>
//     <CenterOfMassMultiMapping input="@../a/dofs @../b/dofs"/>
//     <ConstantForceField forces="0 0.1 0"/>
//   </Node>
//   <Node name="both">
//     <MechanicalObject name="ends" position="0 0 0  1 0 0"/>
//     <SubsetMultiMapping input="@../a/dofs @../b/dofs" indexPairs="0 0  1 1"/>
//     <SpringForceField springsIndices1="0" springsIndices2="1" lengths="1.2" stiffness="100" damping="0"/>
//   </Node>
//   <Node name="all">
//     <MechanicalObject name="three"/>
//     <IdentityMultiMapping input="@../a/dofs @../b/dofs"/>
//     <SpringForceField springsIndices1="0" springsIndices2="1" lengths="2" stiffness="10" damping="0"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include "components/mappings/followed_nodes.h"
#include "components/mappings/weighted_mapping.h"
#include "framework/mechanics/mass.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// A node of one of the inputs.
struct FollowedNode {
  int state = 0;
  Index first_row = 0;
};

/// What follows nodes of several states.
class MultiMapping : public WeightedMapping {
 protected:
  bool takesManyInputs() const override { return true; }

  /// At the end of init(): one node of the output for each.
  void follow(const std::vector<FollowedNode>& nodes) {
    if (!hasPlaces(output())) givePlaces(nodes);
    if (output().nodes() != Index(nodes.size()))
      throw ComponentError(
          fmt::format("{} has {} nodes, and {} are to be followed", output().path(), output().nodes(), nodes.size()),
          "as many of each, or no positions");
    for (const FollowedNode& node : nodes) addCopy(node.first_row, node.state);
  }
  static bool hasPlaces(const State& child) {
    bool is_given = hasNodesOfMesh(child);
    for (const char* name : {"position", "rest_position", "size"})
      if (const Data* data = child.data().find(name)) is_given = is_given || data->isSet();
    return is_given;
  }

 private:
  void givePlaces(const std::vector<FollowedNode>& nodes) {
    State& child = output();
    const std::vector<RowKind> kinds = child.row_kinds;
    child.row_kinds.clear();
    for (std::vector<Vec3>* rows : {&child.position, &child.rest_position, &child.velocity}) rows->clear();
    for (const FollowedNode& node : nodes) {
      const State& from = *inputs()[std::size_t(node.state)];
      for (Index k = 0; k < child.rows_per_node; ++k) {
        const auto row = std::size_t(node.first_row + std::min(k, from.rows_per_node - 1));
        child.position.push_back(from.position[row]);
        child.rest_position.push_back(from.rest_position[row]);
        child.velocity.push_back(from.velocity[row]);
        if (!kinds.empty()) child.row_kinds.push_back(kinds[std::size_t(k)]);
      }
    }
  }
};

class SubsetMultiMapping final : public MultiMapping {
 public:
  void declare(DataTable& table) override {
    MultiMapping::declare(table);
    table.add("indexPairs", pairs_).help("for each node the number of its state in input, and its node there").required();
  }

  void init() override {
    MultiMapping::init();
    if (pairs_.size() % 2 != 0) throw ComponentError(fmt::format("indexPairs has {} numbers", pairs_.size()), "two for each node");
    std::vector<FollowedNode> nodes;
    for (std::size_t i = 0; i < pairs_.size(); i += 2) {
      const int state = pairs_[i];
      if (state < 0 || std::size_t(state) >= inputs().size())
        throw ComponentError(fmt::format("indexPairs names state {} of {}", state, inputs().size()),
                             fmt::format("0 to {}", inputs().size() - 1));
      const State& from = *inputs()[std::size_t(state)];
      checkNode(pairs_[i + 1], i + 1, from, "indexPairs");
      nodes.push_back({state, pairs_[i + 1] * from.rows_per_node});
    }
    if (nodes.empty()) throw ComponentError("indexPairs names no node", "two numbers for each node");
    follow(nodes);
  }

 private:
  std::vector<int> pairs_;
};

class IdentityMultiMapping final : public MultiMapping {
 public:
  void init() override {
    MultiMapping::init();
    std::vector<FollowedNode> nodes;
    for (std::size_t state = 0; state < inputs().size(); ++state)
      for (const Index first : allNodes(*inputs()[state])) nodes.push_back({int(state), first});
    follow(nodes);
  }
};

class CenterOfMassMapping final : public WeightedMapping {
 public:
  bool of_several = false;  ///< set by the registration of a name

  void init() override {
    WeightedMapping::init();
    std::vector<Weight> weights;
    double total = 0;
    for (std::size_t s = 0; s < inputs().size(); ++s) {
      const State& parent = *inputs()[s];
      const std::vector<double> masses = massesOf(parent);
      const std::vector<Index> nodes = allNodes(parent);
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        total += masses[i];
        if (masses[i] > 0) weights.push_back({nodes[i], masses[i], int(s)});
      }
    }
    checkKinds();
    for (Weight& weight : weights) weight.value /= total;
    addNode(weights);
  }

 protected:
  bool takesManyInputs() const override { return of_several; }

 private:
  void checkKinds() const {
    const std::string expected = "one point, the middle of points or frames";
    const auto refuseNumbers = [&](const State& state) {
      if (state.kindOf(0) != RowKind::place) throw ComponentError(fmt::format("{} is of numbers", state.path()), expected);
    };
    refuseNumbers(output());
    for (const State* parent : inputs()) refuseNumbers(*parent);
    if (output().rows_per_node != 1) throw ComponentError(fmt::format("{} is of frames", output().path()), expected);
    if (output().nodes() != 1) throw ComponentError(fmt::format("{} has {} nodes", output().path(), output().nodes()), expected);
  }
  static std::vector<double> massesOf(const State& parent) {
    std::vector<Mass*> masses;
    parent.node().root().collect(masses);
    std::vector<double> values(std::size_t(parent.nodes()), 0.0);
    bool found = false;
    for (Mass* mass : masses) {
      if (&mass->node() != &parent.node()) continue;
      mass->ensureReady();
      if (&mass->state() != &parent) continue;
      found = true;
      for (std::size_t i = 0; i < values.size(); ++i) values[i] += mass->lumped().at(i * std::size_t(parent.rows_per_node));
    }
    if (!found) throw ComponentError(fmt::format("{} has no mass", parent.path()), "a mass beside it, as UniformMass");
    return values;
  }
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(subset_multi_mapping) {
  factory.add<stroma::SubsetMultiMapping>("SubsetMultiMapping", "the nodes of a state are nodes of several others");
  factory.add<stroma::IdentityMultiMapping>("IdentityMultiMapping", "the nodes of a state are all of several others");
  factory.add<stroma::CenterOfMassMapping>("CenterOfMassMapping", "a point at the centre of mass of another state");
  factory.add<stroma::CenterOfMassMapping>("CenterOfMassMultiMapping", "a point at the common centre of mass of several states",
                                           [](stroma::CenterOfMassMapping& mapping) { mapping.of_several = true; });
}
