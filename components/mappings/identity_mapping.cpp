// SPDX-License-Identifier: LGPL-2.1-or-later
// IdentityMapping: the nodes of a state are those of another one.
//
//   x_c = x_p,   v_c = v_p,   f_p += f_c
//
// It gives a body a second set of nodes with its own force fields and mesh. A state without positions gets those of its parent
// nodes; with resizes also a state with a different number of nodes.
//
// Source: the name and the attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="25" tolerance="1e-8"/>
//   <MechanicalObject name="body" position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="1"/>
//   <Node name="spring">
//     <MechanicalObject name="ends" position="0 0 0  1 0 0"/>
//     <IdentityMapping/>
//     <SpringForceField springsIndices1="0" springsIndices2="1" lengths="1" stiffness="100" damping="0"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include "components/mappings/followed_nodes.h"
#include "components/mappings/weighted_mapping.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class IdentityMapping final : public WeightedMapping {
 public:
  void declare(DataTable& table) override {
    WeightedMapping::declare(table);
    table.add("resizes", resizes_).help("a state of another number of nodes gets those that it follows, as in SOFA");
  }
  void init() override {
    WeightedMapping::init();
    std::vector<Index> first_rows;
    for (Index node = 0; node < input().nodes(); ++node) first_rows.push_back(node * input().rows_per_node);
    takeNodesOf(input(), first_rows, output(), resizes_);
    if (input().nodes() != output().nodes())
      throw ComponentError(fmt::format("{} has {} nodes and {} has {}", output().path(), output().nodes(),
                                       input().path(), input().nodes()),
                           "as many of each");
    for (const Index row : first_rows) addCopy(row);
  }

 private:
  bool resizes_ = false;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(identity_mapping) {
  factory.add<stroma::IdentityMapping>("IdentityMapping", "the nodes of a state are those of another one");
}
