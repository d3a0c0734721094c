// SPDX-License-Identifier: LGPL-2.1-or-later
// SubsetMultiMapping: the nodes of a state are nodes of several others.
//
//   x_i = x of node indexPairs[2 i + 1] of state indexPairs[2 i] of `input`
//
// A soft body whose nodes are partly free and partly fixed in rigid bodies is such a state: its free nodes are those of one
// parent, the others those of points that a RigidMapping carries. Forces of its elements then act on both.
//
// Source: the name and the attributes are SOFA's.
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
//   </Node>
//   <Node name="both">
//     <MechanicalObject name="ends" position="0 0 0  1 0 0"/>
//     <SubsetMultiMapping input="@../a/dofs @../b/dofs" indexPairs="0 0  1 1"/>
//     <SpringForceField springsIndices1="0" springsIndices2="1" lengths="1.2" stiffness="100" damping="0"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include "components/mappings/weighted_mapping.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class SubsetMultiMapping final : public WeightedMapping {
 public:
  void declare(DataTable& table) override {
    WeightedMapping::declare(table);
    table.add("indexPairs", pairs_)
        .help("for each node the number of its state in input, and its node there")
        .required();
  }

  void init() override {
    WeightedMapping::init();
    if (pairs_.size() != 2 * std::size_t(output().nodes()))
      throw ComponentError(fmt::format("indexPairs has {} numbers for the {} nodes of {}", pairs_.size(),
                                       output().nodes(), output().path()),
                           "two for each node");
    for (std::size_t i = 0; i < pairs_.size(); i += 2) {
      const int state = pairs_[i];
      if (state < 0 || std::size_t(state) >= inputs().size())
        throw ComponentError(fmt::format("indexPairs names state {} of {}", state, inputs().size()),
                             fmt::format("0 to {}", inputs().size() - 1));
      const State& from = *inputs()[std::size_t(state)];
      checkNode(pairs_[i + 1], i + 1, from, "indexPairs");
      addCopy(pairs_[i + 1] * from.rows_per_node, state);
    }
  }

 protected:
  bool takesManyInputs() const override { return true; }

 private:
  std::vector<int> pairs_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(subset_multi_mapping) {
  factory.add<stroma::SubsetMultiMapping>("SubsetMultiMapping", "the nodes of a state are nodes of several others");
}
