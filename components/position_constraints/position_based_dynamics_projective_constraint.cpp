// SPDX-License-Identifier: LGPL-2.1-or-later
// PositionBasedDynamicsProjectiveConstraint: after each step nodes are drawn to goals, and their velocities follow.
//
//   x_i += stiffness (g_i - x_i),   v_i += (change of x_i) / dt
//
// g_i are `position`, or with `cluster` where groups of nodes would have them that keep their shape: the mean over the groups of a
// node of  c + T (X_i - C),  c and C the centres of the group now and at rest, and
//
//   T = affineRatio A + (1 - affineRatio) R,   A = sum (x - c)(X - C)^T (sum (X - C)(X - C)^T)^-1,   R the rotation of A's first factor
//
// again `iterations` times from there. Nodes of no group stay. A node that is held stays. Every node counts the same, whatever its
// mass, so that momentum is kept only where all masses are equal. The stiffness is not that of a material: it depends on dt.
//
// Source: Mueller, Heidelberger, Teschner and Gross 2005, "Meshless deformations based on shape matching"; Mueller et al. 2007,
// "Position based dynamics". The name, stiffness and position are SOFA's, where ShapeMatching makes the goals.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <EulerExplicitSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1  1 1 1"/>
//   <UniformMass totalMass="5"/>
//   <PositionBasedDynamicsProjectiveConstraint cluster="[0,1,2,3,4]" stiffness="0.5"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Dense>
#include <charconv>

#include "components/position_constraints/best_rotation.h"
#include "framework/mechanics/position_constraint.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class PositionBasedDynamics final : public PositionConstraint {
 public:
  void declare(DataTable& table) override {
    PositionConstraint::declare(table);
    table.add("stiffness", stiffness_).help("share of the way to the goal that a step makes").unit("-").min(0).max(1);
    table.add("position", goals_).help("a goal for each node; where no cluster is given").unit("m");
    table.add("cluster", clusters_).help("groups of nodes that keep their shape, in brackets");
    table.add("iterations", iterations_).help("how often the groups are matched in a step").min(1);
    table.add("affineRatio", affine_).help("0: groups turn; 1: they shear and stretch freely").unit("-").min(0).max(1);
  }

  void init() override {
    PositionConstraint::init();
    readGroups();
    const bool has_groups = !groups_.empty(), has_goals = data().find("position")->isSet();
    if (has_groups == has_goals)
      throw ComponentError(has_goals ? "position and cluster are both given" : "there are no goals", "one of position and cluster");
    if (has_goals && Index(goals_.size()) != state().size())
      throw ComponentError(fmt::format("position has {} goals for {} nodes", goals_.size(), state().size()), "one for each");
    for (Group& group : groups_) rest(group);
  }

  void compile() override {
    goals_now_ = goals_;
    goals_now_.resize(std::size_t(state().size()));
    sums_ = goals_now_;
    counts_.assign(goals_now_.size(), 0);
  }

  void begin(const PositionStep&) override { is_done_ = false; }
  /// Once in a step: what is only drawn to a goal does not hold anything.
  double correctPositions(const PositionStep& step, Rows x, Rows) override {
    if (is_done_) return 0;
    is_done_ = true;
    if (!groups_.empty()) match(x);
    for (Index node = 0; node < state().size(); ++node) {
      if (step.mobility.isHeld(row(node))) continue;
      const Vec3 way = goals_now_[std::size_t(node)] - Vec3(x[row(node)]);
      x[row(node)] += stiffness_ * step.mobility.freePart(row(node), way);
    }
    return 0;
  }
  double correctVelocities(const PositionStep&, ConstRows, Rows) override { return 0; }
  std::string violation() const override { return {}; }
  std::string describe() const override {
    if (groups_.empty()) return fmt::format("{} nodes are drawn to their goals", goals_.size());
    return fmt::format("{} groups of nodes are drawn to their shapes", groups_.size());
  }

 private:
  struct Group {
    std::vector<Index> nodes;
    Vec3 centre = Vec3::Zero();   ///< C [m]
    Mat3 inverse = Mat3::Zero();  ///< (sum (X - C)(X - C)^T)^-1 [1/m^2]
  };

  void readGroups() {
    groups_.clear();
    const auto fail = [this](std::size_t at) {
      throw ComponentError("cluster holds '" + clusters_.substr(at, 20) + "'", "lists of nodes in brackets, as [0,1,2] [2,3]");
    };
    bool is_open = false;
    for (std::size_t at = 0; at < clusters_.size();) {
      const char c = clusters_[at];
      if (c == '[' && !is_open) {
        groups_.emplace_back(), is_open = true, ++at;
      } else if (c == ']' && is_open) {
        is_open = false, ++at;
      } else if (c == ',' || c == ' ' || c == '\n' || c == '\t' || c == '\r') {
        ++at;
      } else {
        int node = 0;
        const auto [end, error] = std::from_chars(clusters_.data() + at, clusters_.data() + clusters_.size(), node);
        if (error != std::errc() || !is_open) fail(at);
        if (node < 0 || node >= state().size())
          throw ComponentError(fmt::format("cluster names node {} of {}", node, state().size()), "nodes of the state");
        groups_.back().nodes.push_back(node);
        at = std::size_t(end - clusters_.data());
      }
    }
    if (is_open) fail(clusters_.rfind('['));
    std::erase_if(groups_, [](const Group& group) { return group.nodes.empty(); });
  }

  void rest(Group& group) const {
    group.centre.setZero();
    for (const Index node : group.nodes) group.centre += state().rest_position[std::size_t(node)] / double(group.nodes.size());
    Mat3 spread = Mat3::Zero();
    for (const Index node : group.nodes) {
      const Vec3 arm = state().rest_position[std::size_t(node)] - group.centre;
      spread += arm * arm.transpose();
    }
    if (affine_ == 0) return;
    constexpr double flat = 1e-12;
    if (!(spread.determinant() > flat * std::pow(spread.trace(), 3)))
      throw ComponentError(fmt::format("the group of node {} is flat: it has no affine shape", group.nodes[0]), "affineRatio=\"0\"");
    group.inverse = spread.inverse();
  }

  void match(ConstRows x) {
    for (Index node = 0; node < state().size(); ++node) goals_now_[std::size_t(node)] = x[row(node)];
    for (int iteration = 0; iteration < iterations_; ++iteration) {
      std::fill(sums_.begin(), sums_.end(), Vec3::Zero());
      std::fill(counts_.begin(), counts_.end(), 0);
      for (const Group& group : groups_) {
        Vec3 centre = Vec3::Zero();
        for (const Index node : group.nodes) centre += goals_now_[std::size_t(node)] / double(group.nodes.size());
        Mat3 a = Mat3::Zero();
        for (const Index node : group.nodes)
          a += (goals_now_[std::size_t(node)] - centre) * (state().rest_position[std::size_t(node)] - group.centre).transpose();
        Mat3 shape = Mat3::Zero();
        if (affine_ != 1) shape += (1 - affine_) * bestRotation(a);
        if (affine_ != 0) shape += affine_ * a * group.inverse;
        for (const Index node : group.nodes) {
          sums_[std::size_t(node)] += centre + shape * (state().rest_position[std::size_t(node)] - group.centre);
          ++counts_[std::size_t(node)];
        }
      }
      for (std::size_t i = 0; i < sums_.size(); ++i)
        goals_now_[i] = counts_[i] > 0 ? Vec3(sums_[i] / counts_[i]) : Vec3(x[row(Index(i))]);
    }
  }

  double stiffness_ = 1, affine_ = 0;
  int iterations_ = 1;
  std::vector<Vec3> goals_;
  std::string clusters_;
  std::vector<Group> groups_;
  std::vector<Vec3> goals_now_, sums_;  ///< [m], shape (nodes)
  std::vector<int> counts_;
  bool is_done_ = false;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(position_based_dynamics_projective_constraint) {
  factory.add<stroma::PositionBasedDynamics>("PositionBasedDynamicsProjectiveConstraint", "draws nodes to goals after each step");
}
