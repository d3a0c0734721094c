// SPDX-License-Identifier: LGPL-2.1-or-later
// RestShapeSpringsForceField: nodes pulled to where they rest, or to the nodes of another body.
//
//   E = sum k_i/2 |D (x_i - t_i)|^2,   f_i = -k_i D (x_i - t_i),   K = -k_i D
//
// with D the diagonal matrix of activeDirections. The targets t are the rest positions of the nodes or, with
// external_rest_shape, the positions of its nodes (external_points, else those with the numbers of `points`) at the
// start of each step. The springs do not act on that other body.
//
// `stiffness` has a value for each point or one for all. Without `points` every node has a spring.
//
// Source: the attributes are SOFA's; those for rigid bodies have no meaning here.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="0.3"/>
//   <RestShapeSpringsForceField points="0 1 2" stiffness="100 200 300"/>
// </Node>
#include <fmt/format.h>

#include "framework/mechanics/drawn_segments.h"
#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class RestShapeSpringsForceField final : public NodeGroupField<1>, public DrawnSegments {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("points", points_).alias("indices").help("nodes with a spring; every node when not given");
    table.add("stiffness", stiffness_constants_)
        .recompiled()
        .help("spring constant, one per point or one for all")
        .unit("N/m")
        .min(0);
    table.addLink("external_rest_shape", external_).help("state whose nodes are the targets");
    table.add("external_points", external_points_).help("its nodes, one for each point");
    table.add("pivot_points", pivot_points_)
        .help("of rigid bodies only: a node here is a point and turns about nothing");
    table.add("activeDirections", directions_).help("for x, y and z: 1 pulled, 0 free");
    for (const char* name : {"drawSpring", "springColor", "recompute_indices", "angularStiffness"})
      table.addVisualOnly(name);
  }

  void init() override {
    ForceField::init();
    if (data().find("points")->isSet()) {
      nodes_ = checkedNodesInOrder(points_, state(), "points");
    } else {
      inform(fmt::format("no points: all {} nodes of {} have a spring", state().size(), state().path()));
      nodes_ = allNodes(state());
    }
    if (!pivot_points_.empty())
      throw ComponentError(
          fmt::format("pivot_points are of rigid bodies, and the nodes of {} are points", state().path()),
          "points, or external_points of another state");
    spread(stiffness_constants_, nodes_.size(), "stiffness", "points");
    if (directions_.size() != 3)
      throw ComponentError(fmt::format("activeDirections has {} values", directions_.size()), "3 values");
    for (int c = 0; c < 3; ++c) active_(c, c) = directions_[c] ? 1 : 0;
    findTargets();
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.linear = traits.constant_stiffness = traits.symmetric = traits.conservative = traits.exact_tangent = true;
    traits.time_dependent = external_.target() != nullptr;
    return traits;
  }

  void compile() override {
    setNodes(nodes_, false);
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      NodeGroupField::stiffness_[i].blocks[0] = -stiffness_constants_[i] * active_;
  }

  void setTime(double) override {
    const State& other = *external_.get();
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const Index node = external_nodes_[i];
      targets_[i] = other.isBound() ? Vec3(other.x()[node]) : other.position[node];
    }
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      sum += stiffness_constants_[i] / 2 * (active_ * (x[rows_[i][0]] - targets_[i])).squaredNorm();
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      f[rows_[i][0]] += NodeGroupField::stiffness_[i].blocks[0] * (x[rows_[i][0]] - targets_[i]);
  }

  /// To the nodes of another body; a place at rest is no node.
  void addSegments(std::vector<Segment>& segments) const override {
    if (const State* other = external_.get())
      for (std::size_t i = 0; i < nodes_.size(); ++i)
        segments.push_back({&state(), nodes_[i], other, external_nodes_[i]});
  }

 private:
  void findTargets() {
    const State* other = external_.get();
    if (!other && data().find("external_points")->isSet())
      throw ComponentError("external_points names nodes of another state, and external_rest_shape is not given",
                           "external_rest_shape=\"@path/of/a/MechanicalObject\"");
    if (other) {
      external_nodes_ = data().find("external_points")->isSet()
                            ? checkedNodesInOrder(external_points_, *other, "external_points")
                            : checkedNodesInOrder({nodes_.begin(), nodes_.end()}, *other, "points");
      if (external_nodes_.size() != nodes_.size())
        throw ComponentError(
            fmt::format("external_points has {} values for {} points", external_nodes_.size(), nodes_.size()),
            "as many of each");
    }
    targets_.clear();
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      targets_.push_back(other ? other->position[external_nodes_[i]] : state().rest_position[nodes_[i]]);
  }

  std::vector<int> points_, external_points_, pivot_points_;
  std::vector<double> stiffness_constants_{100};
  std::vector<bool> directions_{true, true, true};
  Link<State> external_{"mechanical state"};

  std::vector<Index> nodes_, external_nodes_;  ///< shape (points)
  std::vector<Vec3> targets_;                  ///< [m], shape (points)
  Mat3 active_ = Mat3::Zero();
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(rest_shape_springs_force_field) {
  factory.add<stroma::RestShapeSpringsForceField>("RestShapeSpringsForceField",
                                                  "springs from nodes to their rest positions or to another body");
}
