// SPDX-License-Identifier: LGPL-2.1-or-later
// AngularSpringForceField: springs that align each of some rigid frames with the previous frame.
//
//   E = sum k_i/2 |th_i|^2,   exp(th_i) = q_i q_p^-1,   p = i - 1, the frame with the number before
//   torque on i = -k_i th_i,   torque on p = k_i th_i
//   K = -k_i [S, -D^T; -D, S] on (i, p),   D = dexp^-1(th_i),   S = (D + D^T)/2
//
// th is the shortest rotation. `indices` lists the frames; the first of the list has no spring, and neither has frame 0.
// Frames listed as one chain bend like a rod. angularStiffness has a value for each of indices or one for all. K is the
// symmetric part of the derivative.
//
// With limit="least most ..." a spring acts only while the angle |th| lies between the two; a pair for each, or one for all.
//
// Source: name and attributes are SOFA's. There the previous frame gets no torque, and `limit` is not read: oneSided does
// this, with K = -k I of each listed frame, also of the first, which has no force. If there are fewer constants than indices,
// the first is used for the others.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-12"/>
//   <MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1   1 0 0  0 0 0.6 0.8   2 0 0  0.28 0 0 0.96"/>
//   <UniformMass totalMass="3" inertia="0.1 0.1 0.1"/>
//   <FixedProjectiveConstraint indices="0"/>
//   <AngularSpringForceField indices="0 1 2" angularStiffness="50"/>
// </Node>
#include <fmt/format.h>

#include <limits>

#include "framework/mechanics/drawn_segments.h"
#include "framework/mechanics/frames.h"
#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class AngularSpringForceField final : public NodeGroupField<2>, public DrawnSegments {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("indices", indices_).help("frames, each except the first coupled to the previous one").required();
    table.add("angularStiffness", constants_)
        .recompiled()
        .help("torque over the angle, one per frame or one for all")
        .unit("N m")
        .min(0)
        .physical();
    table.add("limit", limits_)
        .help("the least and the largest angle at which a spring acts, for each or for all")
        .unit("rad")
        .min(0);
    table.add("oneSided", one_sided_).help("the frame before feels no torque, as in SOFA");
    for (const char* name : {"drawSpring", "springColor"}) table.addVisualOnly(name);
  }

  void init() override {
    ForceField::init();
    if (!state().hasFrames())
      throw ComponentError(fmt::format("the nodes of {} have no orientation", state().path()), "a state of template Rigid3");
    const std::vector<Index> rows = checkedNodesInOrder(indices_, state(), "indices");
    stiffness_of_ = constants_;
    if (one_sided_ && !constants_.empty() && constants_.size() < rows.size()) stiffness_of_.resize(rows.size(), constants_[0]);
    spread(stiffness_of_, rows.size(), "angularStiffness", "indices");
    std::vector<double> limits = limits_.empty() ? std::vector<double>{0, std::numeric_limits<double>::infinity()} : limits_;
    if (limits.size() == 2)
      while (limits.size() < 2 * rows.size()) limits.push_back(limits[limits.size() - 2]);
    if (limits.size() != 2 * rows.size())
      throw ComponentError(fmt::format("limit has {} values for {} indices", limits_.size(), rows.size()), "two, or two for each");
    springs_.clear();
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const bool has_force = i > 0 && rows[i] != 0;
      if (!has_force && !one_sided_) continue;
      if (!(limits[2 * i] <= limits[2 * i + 1]))
        throw ComponentError(fmt::format("the limits {:g} and {:g} leave no angle", limits[2 * i], limits[2 * i + 1]),
                             "the lower one first");
      springs_.push_back({rows[i], has_force ? rows[i] - 2 : rows[i], stiffness_of_[i], limits[2 * i], limits[2 * i + 1]});
    }
    if (springs_.empty()) throw ComponentError("there is no spring", "at least two indices, the second not 0");
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = true;
    // where a limit lets go, the energy jumps
    traits.conservative = traits.exact_tangent = !one_sided_ && limits_.empty();
    return traits;
  }

  void compile() override {
    std::vector<Group> rows;
    for (const AngularSpring& spring : springs_)
      rows.push_back({state().firstRow() + spring.frame + 1, state().firstRow() + spring.before + 1});
    setGroups(std::move(rows), false);
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t s = 0; s < springs_.size(); ++s)
      if (const Vec3 turn = turnOf(s, x); isBeyondLimits(s, turn)) sum += springs_[s].stiffness / 2 * turn.squaredNorm();
    return sum;
  }

  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t s = 0; s < springs_.size(); ++s) {
      const Vec3 turn = turnOf(s, x);
      stiffness_[s].setZero();
      if (!isBeyondLimits(s, turn)) continue;
      const double k = springs_[s].stiffness;
      f[rows_[s][0]] -= k * turn;
      if (one_sided_) {
        stiffness_[s].block(0, 0) = -k * Mat3::Identity();
        continue;
      }
      f[rows_[s][1]] += k * turn;
      const Mat3 d = dexpInverse(turn);
      stiffness_[s].block(0, 0) = stiffness_[s].block(1, 1) = -k / 2 * (d + d.transpose());
      stiffness_[s].block(0, 1) = k * d.transpose();
      stiffness_[s].block(1, 0) = k * d;
    }
  }

  void addSegments(std::vector<Segment>& segments) const override {
    for (const AngularSpring& spring : springs_)
      if (spring.before != spring.frame) segments.push_back({&state(), spring.before, &state(), spring.frame});
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  struct AngularSpring {
    Index frame, before;  ///< first rows; the same: a tangent without a force
    double stiffness;     ///< [N m]
    double least, most;   ///< [rad]
  };
  Vec3 turnOf(std::size_t s, ConstRows x) const {
    if (springs_[s].before == springs_[s].frame) return Vec3::Zero();
    return rotationVector(orientationIn(x, rows_[s][0]) * orientationIn(x, rows_[s][1]).conjugate());
  }
  bool isBeyondLimits(std::size_t s, const Vec3& turn) const {
    const double angle = turn.norm();
    return one_sided_ || (angle >= springs_[s].least && angle <= springs_[s].most);
  }

  std::vector<int> indices_;
  std::vector<double> constants_{100}, stiffness_of_, limits_;
  bool one_sided_ = false;
  std::vector<AngularSpring> springs_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(angular_spring_force_field) {
  factory.add<stroma::AngularSpringForceField>("AngularSpringForceField", "springs between the orientations of rigid frames");
}
