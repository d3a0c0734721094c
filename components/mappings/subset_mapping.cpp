// SPDX-License-Identifier: LGPL-2.1-or-later
// SubsetMapping: the nodes of a state are a subset of those of another one.
//
//   x_c = x_p(c),   v_c = v_p(c),   f_p(c) += f_c
//
// p(c) are the `indices`; or the nodes from `first` to `last`; or, when neither is given, the node nearest to each
// node's initial position, which must be within `radius` of it. With the first two a state may be without positions: it gets
// those of the nodes that it follows; with resizes also a state with a different number of nodes.
//
// ignoreNotFound: a node that is not near any other stays at its initial position, and forces on it are lost. Otherwise this
// is an error.
//
// Source: the attributes are SOFA's, whose nodes that are not found stay in both cases.
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
#include "framework/mechanics/frames.h"
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
        .help("largest distance of a node from the one it follows, if neither is given")
        .unit("m")
        .min(0);
    table.add("resizes", resizes_).help("a state of another number of nodes gets those of indices or of the range, as in SOFA");
    table.add("ignoreNotFound", may_stay_).help("a node farther than radius from all others stays where it starts");
  }

  void init() override {
    WeightedMapping::init();
    const std::vector<Index> nodes = chosen();
    takeNodesOf(input(), nodes, output(), resizes_);
    if (Index(nodes.size()) != output().nodes())
      throw ComponentError(
          fmt::format("{} has {} nodes, and {} are to be followed", output().path(), output().nodes(), nodes.size()),
          "as many of each");
    staying_.clear();
    for (Index point = 0; point < Index(nodes.size()); ++point) {
      if (nodes[std::size_t(point)] >= 0) {
        addCopy(nodes[std::size_t(point)]);
        continue;
      }
      const Index first = point * output().rows_per_node;
      for (Index row = first; row < first + output().rows_per_node; ++row) staying_.push_back(row), addNode({});
    }
    if (!staying_.empty())
      inform(fmt::format("{} nodes of {} are not near any node that they could follow: they stay where they are",
                         Index(staying_.size()) / output().rows_per_node, output().path()));
  }

  void apply(Rows x) const override {
    WeightedMapping::apply(x);
    for (const Index row : staying_) {
      const Vec3& start = output().position[std::size_t(row)];
      if (output().kindOf(row) == RowKind::turn)
        putOrientation(turnedBy(start), x, output().firstRow() + row);
      else
        x[output().firstRow() + row] = start;
    }
  }
  void applyJ(Rows v) const override { WeightedMapping::apply(v); }

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

  /// The first row of each; -1 where there is none.
  std::vector<Index> nearest() const {
    std::vector<Index> nodes;
    for (const Index i : allNodes(output())) {
      const Vec3& own = output().position[std::size_t(i)];
      Index best = 0;
      for (const Index node : allNodes(input()))
        if ((input().position[node] - own).squaredNorm() < (input().position[best] - own).squaredNorm()) best = node;
      const double distance = (input().position[best] - own).norm();
      if (!(distance <= radius_) && may_stay_) {
        nodes.push_back(-1);
        continue;
      }
      if (!(distance <= radius_))
        throw ComponentError(fmt::format("node {} of {} is {:.3g} m from the nearest node of {}",
                                         i / output().rows_per_node, output().path(), distance, input().path()),
                             fmt::format("at most radius = {:g} m", radius_), "indices, a larger radius, or ignoreNotFound=\"true\"");
      nodes.push_back(best);
    }
    return nodes;
  }

  std::vector<int> indices_;
  int first_ = 0, last_ = 0;
  double radius_ = 1e-5;
  bool may_stay_ = false, resizes_ = false;
  std::vector<Index> staying_;  ///< rows of output() that follow nothing
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(subset_mapping) {
  factory.add<stroma::SubsetMapping>("SubsetMapping", "the nodes of a state are some of another one's");
}
