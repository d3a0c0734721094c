// SPDX-License-Identifier: LGPL-2.1-or-later
// RestShapeSpringsForceField: nodes pulled to their rest positions, or to the nodes of another body.
//
//   E = sum k_i/2 |D (x_i - t_i)|^2,   f_i = -k_i D (x_i - t_i),   K = -k_i D
//
// with D the diagonal matrix of activeDirections. The targets t are the rest positions of the nodes or, with
// external_rest_shape, the positions of its nodes (external_points, else those with the numbers of `points`) at the start of
// each step. The springs do not act on that other body. `targets` gives them as numbers, and can be changed during a run to
// guide a body.
//
// A rigid frame also gets a restoring torque along the shortest rotation th from its target orientation q_t to q:
//
//   E = sum a_i/2 |th_i|^2,   exp(th_i) = q_i q_t^-1,   torque = -a_i th_i
//   K = -a_i (I + c [th]^2), the symmetric part, with c as in dexp^-1;   a = angularStiffness
//
// With turnTangent="unturned" K = -a_i I, as in SOFA.
//
// `stiffness` has a value for each point or one for all; with firstForOthers points without a value use the first. Without
// `points` every node has a spring.
//
// Source: the attributes are SOFA's.
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

#include <algorithm>

#include "framework/mechanics/drawn_segments.h"
#include "framework/mechanics/frames.h"
#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class RestShapeSpringsForceField final : public NodeGroupField<1>, public DrawnSegments {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("points", points_).alias("indices").recompiled().help("nodes with a spring; every node by default");
    table.add("emptyMeansAll", empty_is_all_).help("an empty list of points means all nodes, as in SOFA");
    table.add("firstForOthers", first_for_others_)
        .help("of several values the first is that of points without one, and those beyond are left out, as in SOFA");
    table.add("stiffness", stiffness_constants_)
        .recompiled()
        .help("spring constant, one per point or one for all")
        .unit("N/m")
        .min(0)
        .physical();
    table.addLink("external_rest_shape", external_).help("state whose nodes are the targets");
    table.add("external_points", external_points_).help("its nodes, one for each point");
    table.add("requiredPoints", required_points_)
        .help("these must be nodes of the state, or the springs have no effect, as SOFA's external_points without another body");
    table.add("pivot_points", pivot_points_)
        .help("for rigid bodies only: the nodes here are points without orientation");
    table.add("activeDirections", directions_).help("for x, y and z: 1 pulled, 0 free");
    table.add("angularStiffness", angular_stiffness_)
        .recompiled()
        .help("torque over the turn of frames, one per point or one for all")
        .unit("N m")
        .min(0);
    table.addChoice("turnTangent", turn_tangent_, {"symmetric", "unturned"})
        .help("of the torques on frames: how they change, or -a I as in SOFA");
    table.add("targets", given_targets_)
        .recompiled()
        .help("targets of the points instead of their rest positions: 3 numbers each, for frames 7")
        .unit("m");
    for (const char* name : {"drawSpring", "springColor", "recompute_indices"}) table.addVisualOnly(name);
  }

  void init() override {
    ForceField::init();
    const bool is_given = data().find("points")->isSet();
    const bool takes_all = points_.empty() && empty_is_all_;
    if (is_given && takes_all)
      warn(fmt::format("points is empty: springs act on all {} nodes of {}", state().nodes(), state().path()));
    if (is_given && !takes_all) {
      nodes_ = checkedNodesInOrder(points_, state(), "points");
    } else {
      if (!is_given) inform(fmt::format("no points: all {} nodes of {} have a spring", state().nodes(), state().path()));
      nodes_ = allNodes(state());
    }
    if (!hasRequiredPoints()) {
      nodes_.clear(), targets_.clear(), turns_.clear();
      return;
    }
    if (!pivot_points_.empty())
      throw ComponentError(
          fmt::format("pivot_points are of rigid bodies, and the nodes of {} are points", state().path()),
          "points, or external_points of another state");
    constants_ = spreadValues(stiffness_constants_, "stiffness");
    if (state().hasFrames() && !data().find("angularStiffness")->isSet())
      warn(fmt::format("angularStiffness is not given: the default {:g} N m is used", angular_stiffness_[0]));
    turn_constants_ = spreadValues(angular_stiffness_, "angularStiffness");
    if (directions_.size() == 7 && state().hasFrames()) directions_.pop_back();  // SOFA's have one for each number of a frame
    const std::size_t count = directions_.size();
    if (count != 3 && !(count == 6 && state().hasFrames()))
      throw ComponentError(fmt::format("activeDirections has {} values", count), "3 values");
    if (count == 6 && (directions_[3] != directions_[4] || directions_[4] != directions_[5]))
      throw ComponentError("activeDirections has some turns only", "1 1 1 or 0 0 0 for the turns about x, y and z");
    for (int c = 0; c < 3; ++c) active_(c, c) = directions_[c] ? 1 : 0;
    findTargets();
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = traits.conservative = true;
    traits.exact_tangent = turn_tangent_ == TurnTangent::symmetric || !state().hasFrames();
    traits.linear = traits.constant_stiffness = !state().hasFrames();
    traits.time_dependent = external_.target() != nullptr;
    return traits;
  }

  void compile() override {
    std::vector<Index> rows = isOfNumbers() ? rowsOf(nodes_, state()) : nodes_;
    if (state().hasFrames())
      for (const Index node : nodes_) rows.push_back(node + 1);  // orientations after all centres
    setNodes(rows, false);
    for (std::size_t i = 0; i < targets_.size(); ++i)
      NodeGroupField::stiffness_[i].blocks[0] = -constantOf(i) * active_;
  }

  void setTime(double) override {
    const State& other = *external_.get();
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      const Index node = external_nodes_[i];
      targets_[i] = other.isBound() ? Vec3(other.x()[node]) : other.position[node];
      if (i < turns_.size())
        turns_[i] = other.isBound() ? orientationIn(other.x(), node + 1) : turnedBy(other.position[node + 1]);
    }
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t i = 0; i < targets_.size(); ++i)
      sum += constantOf(i) / 2 * (active_ * (x[rows_[i][0]] - targets_[i])).squaredNorm();
    for (std::size_t i = 0; i < turns_.size(); ++i) sum += angularOf(i) / 2 * turnOf(i, x).squaredNorm();
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t i = 0; i < targets_.size(); ++i)
      f[rows_[i][0]] += NodeGroupField::stiffness_[i].blocks[0] * (x[rows_[i][0]] - targets_[i]);
    for (std::size_t i = 0; i < turns_.size(); ++i) {
      const Vec3 turn = turnOf(i, x);
      const Mat3 inverse = dexpInverse(turn);
      f[rows_[targets_.size() + i][0]] -= angularOf(i) * turn;
      NodeGroupField::stiffness_[targets_.size() + i].blocks[0] =
          -angularOf(i) / 2 *
          (turn_tangent_ == TurnTangent::unturned ? Mat3(2 * Mat3::Identity()) : Mat3(inverse + inverse.transpose()));
    }
  }

  /// To the nodes of another body; a place at rest is no node.
  void addSegments(std::vector<Segment>& segments) const override {
    if (const State* other = external_.get())
      for (std::size_t i = 0; i < nodes_.size(); ++i)
        segments.push_back({&state(), nodes_[i], other, external_nodes_[i]});
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  bool hasRequiredPoints() const {
    const auto outside = std::find_if(required_points_.begin(), required_points_.end(),
                                      [this](int point) { return point < 0 || point >= state().nodes(); });
    if (outside == required_points_.end()) return true;
    warn(fmt::format("requiredPoints names node {} of {}, which has {} nodes: the springs have no effect", *outside, state().path(),
                     state().nodes()));
    return false;
  }
  /// One for each point. What is written stays: other points may be as many others.
  std::vector<double> spreadValues(std::vector<double> values, const char* attribute) const {
    const std::size_t given = values.size(), count = nodes_.size();
    if (first_for_others_ && given > 1 && given != count) {
      warn(fmt::format("{} has {} values for {} points: {}", attribute, given, count,
                       given < count ? "the others take the first" : "those beyond are left out"));
      values.resize(count, values.front());
    }
    spread(values, count, attribute, "points");
    return values;
  }
  double constantOf(std::size_t target) const {
    return constants_[target / (targets_.size() / nodes_.size())];
  }
  double angularOf(std::size_t i) const { return directions_.size() == 3 || directions_[3] ? turn_constants_[i] : 0; }
  bool isOfNumbers() const { return state().kindOf(0) == RowKind::value; }
  std::vector<int> nodeNumbers() const {
    std::vector<int> numbers(nodes_.begin(), nodes_.end());
    for (int& number : numbers) number /= state().rows_per_node;
    return numbers;
  }
  /// From the target to the orientation.
  Vec3 turnOf(std::size_t i, ConstRows x) const {
    return rotationVector(orientationIn(x, rows_[targets_.size() + i][0]) * turns_[i].conjugate());
  }

  void findTargets() {
    const State* other = external_.get();
    if (!other && data().find("external_points")->isSet())
      throw ComponentError("external_points names nodes of another state, and external_rest_shape is not given",
                           "external_rest_shape=\"@path/of/a/MechanicalObject\"");
    if (other) {
      external_nodes_ = data().find("external_points")->isSet()
                            ? checkedNodesInOrder(external_points_, *other, "external_points")
                            : checkedNodesInOrder(nodeNumbers(), *other, "points");
      if (external_nodes_.size() != nodes_.size())
        throw ComponentError(
            fmt::format("external_points has {} values for {} points", external_nodes_.size(), nodes_.size()),
            "as many of each");
    }
    if (other)
      inform(fmt::format(
          "the springs only pull {}: there is no reaction on {}, whose nodes are taken at the start of the step. SpringForceField "
          "between the two acts on both",
          state().path(), other->path()));
    if (other && other->hasFrames() != state().hasFrames())
      throw ComponentError(fmt::format("the nodes of {} and {} are of different types", other->path(), state().path()),
                           "frames for frames, points for points");
    if (other && isOfNumbers()) {
      if (other->kindOf(0) != RowKind::value || other->rows_per_node != state().rows_per_node)
        throw ComponentError(fmt::format("the nodes of {} and {} are of different types", other->path(), state().path()),
                             "states of one template");
      external_nodes_ = rowsOf(external_nodes_, *other);
    }
    targets_.clear(), turns_.clear();
    if (!given_targets_.empty()) return takeTargets();
    const std::vector<Vec3>& from = other ? other->position : state().rest_position;
    for (const Index row : other ? external_nodes_ : isOfNumbers() ? rowsOf(nodes_, state()) : nodes_)
      targets_.push_back(from[std::size_t(row)]);
    for (std::size_t i = 0; state().hasFrames() && i < nodes_.size(); ++i)
      turns_.push_back(turnedBy(from[std::size_t((other ? external_nodes_[i] : nodes_[i]) + 1)]));
  }

  void takeTargets() {
    if (external_.target())
      throw ComponentError("targets and external_rest_shape exclude each other", "one of the two");
    const bool is_point = state().kindOf(0) != RowKind::value;
    const std::size_t width = state().hasFrames() ? 7 : is_point ? 3 : std::size_t(state().rows_per_node);
    if (given_targets_.size() != width * nodes_.size())
      throw ComponentError(fmt::format("targets has {} numbers for {} points", given_targets_.size(), nodes_.size()),
                           fmt::format("{} for each point", width));
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const double* t = given_targets_.data() + width * i;
      if (is_point) targets_.emplace_back(t[0], t[1], t[2]);
      for (std::size_t c = 0; !is_point && c < width; ++c) targets_.emplace_back(t[c], 0., 0.);
      if (width != 7) continue;
      const Quaternion turn(t[6], t[3], t[4], t[5]);
      if (!(turn.norm() > 0)) throw ComponentError("targets has an orientation of length zero", "x y z w of length 1");
      turns_.push_back(turn.normalized());
    }
  }

  std::vector<int> points_, external_points_, required_points_, pivot_points_;
  bool empty_is_all_ = false, first_for_others_ = false;
  enum class TurnTangent { symmetric, unturned } turn_tangent_ = TurnTangent::symmetric;
  std::vector<double> given_targets_;
  std::vector<double> stiffness_constants_{100}, angular_stiffness_{100};
  std::vector<bool> directions_{true, true, true};
  Link<State> external_{"mechanical state"};

  std::vector<Index> nodes_, external_nodes_;  ///< shape (points)
  std::vector<double> constants_, turn_constants_;  ///< shape (points)
  std::vector<Vec3> targets_;                  ///< [m], shape (points)
  std::vector<Quaternion> turns_;              ///< of frames, shape (points)
  Mat3 active_ = Mat3::Zero();
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(rest_shape_springs_force_field) {
  factory.add<stroma::RestShapeSpringsForceField>("RestShapeSpringsForceField",
                                                  "springs from nodes to their rest positions or to another body");
}
