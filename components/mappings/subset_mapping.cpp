// SPDX-License-Identifier: LGPL-2.1-or-later
// SubsetMapping: the nodes of a state are some of another one's.
//
//   x_c = x_p(c),   v_c = v_p(c),   f_p(c) += f_c
//
// p(c) are the `indices`; or the nodes from `first` to `last`; or, when neither is given, the node nearest to each
// node's initial position, which must be within `radius` of it. With the first two a state may be without positions: it gets
// those of the nodes that it follows.
//
// Source: the attributes are SOFA's. There, a node that is not found is left out or placed at node 0; here it is an
// error.
//
// Example:
// <Node name="root" dt="0.01">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="25" tolerance="1e-8"/>
//   <MechanicalObject name="body" position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="1"/>
//   <Node name="ends">
//     <MechanicalObject position="0 0 0  2 0 0"/>
//     <SubsetMapping indices="0 2"/>
//     <SpringForceField springsIndices1="0" springsIndices2="1" lengths="2" stiffness="100" damping="0"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include "components/mappings/followed_nodes.h"
#include "components/mappings/weighted_mapping.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class SubsetMapping final : public WeightedMapping {
 public:
  void declare(DataTable& table) override {
    WeightedMapping::declare(table);
    table.add("indices", indices_).help("nodes of the state that is followed");
    table.add("first", first_).help("the first of a range of them").min(0);
    table.add("last", last_).help("the last of the range").min(0);
    table.add("radius", radius_)
        .help("how far a node may be from the one it follows, when neither is given")
        .unit("m")
        .min(0);
  }

  void init() override {
    WeightedMapping::init();
    const std::vector<Index> nodes = chosen();
    takeNodesOf(input(), nodes, output());
    if (Index(nodes.size()) != output().nodes())
      throw ComponentError(
          fmt::format("{} has {} nodes, and {} are to be followed", output().path(), output().nodes(), nodes.size()),
          "as many of each");
    for (const Index node : nodes) addCopy(node);
  }

 private:
  std::vector<Index> chosen() const {
    const bool listed = data().find("indices")->isSet();
    const bool ranged = data().find("first")->isSet() || data().find("last")->isSet();
    if (data().find("first")->isSet() != data().find("last")->isSet())
      throw ComponentError("one end of the range is missing", "first and last");
    if (listed && ranged) throw ComponentError("indices and a range are both given", "one of them");
    if (listed) return checkedNodesInOrder(indices_, input(), "indices");
    if (!ranged) return nearest();
    if (first_ > last_ || last_ >= input().nodes())
      throw ComponentError(
          fmt::format("the range {} to {} of the {} nodes of {}", first_, last_, input().nodes(), input().path()),
          "first <= last, both nodes");
    std::vector<Index> nodes;
    for (Index node = first_; node <= last_; ++node) nodes.push_back(node * input().rows_per_node);
    return nodes;
  }

  std::vector<Index> nearest() const {
    std::vector<Index> nodes;
    for (const Index i : allNodes(output())) {
      const Vec3& own = output().position[std::size_t(i)];
      Index best = 0;
      for (const Index node : allNodes(input()))
        if ((input().position[node] - own).squaredNorm() < (input().position[best] - own).squaredNorm()) best = node;
      const double distance = (input().position[best] - own).norm();
      if (!(distance <= radius_))
        throw ComponentError(fmt::format("node {} of {} is {:.3g} m from the nearest node of {}",
                                         i / output().rows_per_node, output().path(), distance, input().path()),
                             fmt::format("at most radius = {:g} m", radius_), "indices, or a larger radius");
      nodes.push_back(best);
    }
    return nodes;
  }

  std::vector<int> indices_;
  int first_ = 0, last_ = 0;
  double radius_ = 1e-5;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(subset_mapping) {
  factory.add<stroma::SubsetMapping>("SubsetMapping", "the nodes of a state are some of another one's");
}
