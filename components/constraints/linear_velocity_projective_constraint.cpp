// SPDX-License-Identifier: LGPL-2.1-or-later
// LinearVelocityProjectiveConstraint: nodes whose velocity is given at key times, linear between them.
//
//   v(t) = w(t),   x(t) = x(t_0) + integral of w from t_0 to t
//
// with t_0 the start of the first step in which the velocities apply. Positions and velocities are exact at the end of every
// step. `coordinates` lists the axes that are driven (0, 1, 2; all by default). Before the first key time the nodes are free,
// and after the last too, unless continueAfterEnd keeps the last velocity.
//
// With late="true", for points, the displacement is a sum over steps of h from t_i, with the velocity at the start of each
// step, as in SOFA:
//   x_{i+1} = x_i + h w(t_i),   v_{i+1} = w(t_i)
//
// continueAfterEnd then extrapolates from the last two keys, unless a step starts exactly at the last one.
//
// Of a rigid frame a velocity has six numbers: of its centre, and its angular velocity [rad/s] in fixed axes, which are the
// coordinates 3, 4 and 5. Nodes that are numbers have one each.
//
// Source: the attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="0.3"/>
//   <SpringForceField springsIndices1="0" springsIndices2="1" lengths="1" stiffness="200"/>
//   <LinearVelocityProjectiveConstraint indices="0" keyTimes="0 1 2" velocities="0 0 0  0 1 0  0 0 0"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "components/constraints/held_nodes.h"
#include "components/constraints/row_keys.h"
#include "framework/mechanics/start_velocity.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class LinearVelocityProjectiveConstraint final : public HeldNodes, public StartVelocity {
 public:
  void declare(DataTable& table) override {
    HeldNodes::declare(table);
    velocity_.declare(table, "velocities", "velocity of the nodes at each of keyTimes", "m/s");
    table.add("coordinates", axes_).help("axes that are driven (0, 1, 2, of frames to 5); all by default");
    table.add("ahead", ahead_)
        .help("by how much nodes that are driven from the start of a simulation are ahead of where they start, as SOFA's")
        .unit("m");
    table.add("late", late_).help("in a step the nodes keep the velocity of its start, as in SOFA; for points only");
    table.add("continueAfterEnd", continue_).help("keep the last velocity after the last key time");
  }

  void init() override {
    HeldNodes::init();
    velocity_.compile(state());
    if (late_ && !state().hasPointsOnly()) throw ComponentError("late is of points", "a state of template Vec3");
    if (!ahead_.isZero(0) && velocity_.first() > node().root().root_time)
      throw ComponentError(
          fmt::format("ahead is of nodes that are driven from the start on, and the first key is at {:g} s", velocity_.first()),
          "no ahead");
    runs_on_ = late_ && continue_ && !beginsAt(velocity_.last());
    holdAllRows();
    if (data().find("coordinates")->isSet()) setProjectors(freeDirections(drivenAxes(), state(), "coordinates"));
    start_.reserve(nodes().size() * std::size_t(heldRows()));
  }

  bool activeIn(double t, double t_end) const override {
    const bool after = continue_ && (t > velocity_.last() || sameTime(t, velocity_.last()));
    if (late_) {
      const bool begun = t > velocity_.first() || sameTime(t, velocity_.first());
      const bool over = !continue_ && (t > velocity_.last() || sameTime(t, velocity_.last()));
      return ProjectiveConstraint::activeIn(t, t_end) && begun && !over;
    }
    return ProjectiveConstraint::activeIn(t, t_end) && (after || velocity_.touches(t, t_end));
  }
  bool keepsStartVelocity() const override { return late_; }
  void placeStart(double t, Rows x, Rows v) const override {
    if (!late_ || t > node().root().root_time || !activeIn(t, t)) return;  // SOFA projects before the first step too
    const Mat3 held = Mat3::Identity() - projector(0);
    for (std::size_t i = 0; i < nodes().size(); ++i) {
      moveHeld(state().kindOf(0), state().position[std::size_t(nodes()[i])] + ahead_, held, x, row(i));
      v[row(i)] += held * (velocity_.of(0).at(t) - v[row(i)]);
    }
  }
  bool isConstant() const override { return false; }
  bool prescribesMotion() const override { return true; }
  void reset() override {
    start_.clear();
    way_.setZero();
    last_start_ = never;
  }
  void serialize(Archive& archive) override {
    archive.value("start_time", start_time_);
    if (late_) {
      archive.value("last_start", last_start_);
      archive.value("start_before", start_before_);
      for (const int axis : {0, 1, 2}) archive.value(fmt::format("way_{}", axis), way_[axis]);
    }
    serializeStart(archive, start_);
  }

  void beginMotion(double t, ConstRows x) override {
    if (late_ && t > last_start_) {
      if (!start_.empty() && activeIn(last_start_, last_start_)) way_ += (t - last_start_) * lateVelocity(last_start_);
      const bool is_first = last_start_ == never;
      start_before_ = !is_first ? last_start_ : t > node().root().root_time ? t - node().dt() : t;
      last_start_ = t;
    }
    if (!start_.empty()) return;
    way_.setZero();
    start_time_ = std::max(t, velocity_.first());
    for (const Index node : nodes()) noteRows(state(), node, x, start_);
    // only what starts with the simulation: nodes that are found under way, as after a change of the mesh, are ahead already
    if (late_ || t > node().root().root_time) return;
    for (std::size_t i = 0; i < start_.size(); ++i)
      if (state().kindOf(Index(i) % heldRows()) != RowKind::turn) start_[i] += ahead_;
  }

  void prescribe(double t, Rows x, Rows v) const override {
    if (late_) return prescribeLate(t, x, v);
    const double until = continue_ ? t : std::min(t, velocity_.last());
    for (Index k = 0; k < heldRows(); ++k) {
      const Mat3 held = Mat3::Identity() - projector(k);
      const bool turns = state().kindOf(k) == RowKind::turn;
      const Quaternion turned = turns ? velocity_.turn(k, held, start_time_, until) : Quaternion::Identity();
      const Vec3 movement = turns ? Vec3(Vec3::Zero()) : velocity_.of(k).integral(start_time_, until);
      const Vec3 velocity = velocity_.of(k).at(t);
      for (std::size_t i = 0; i < nodes().size(); ++i) {
        const Vec3& start = start_[i * std::size_t(heldRows()) + std::size_t(k)];
        const Vec3 target = turns ? rotationVector(turned * turnedBy(start)) : Vec3(start + movement);
        moveHeld(state().kindOf(k), target, held, x, row(i) + k);
        v[row(i) + k] += held * (velocity - v[row(i) + k]);
      }
    }
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  /// Whether a step begins there: times of steps are sums.
  bool beginsAt(double time) const {
    double t = node().root().root_time;
    const double h = node().dt();
    if (!((time - t) / h < 1e6)) return false;
    while (t < time) t += h;
    return t == time;
  }
  Vec3 lateVelocity(double t) const {
    const double beyond = runs_on_ ? std::max(t - velocity_.last(), 0.) : 0;
    return velocity_.of(0).at(t) + beyond * velocity_.of(0).slope(velocity_.last());
  }
  void prescribeLate(double time, Rows x, Rows v) const {
    // where a step starts, that of the start before it
    const double t = time > last_start_ ? last_start_ : start_before_;
    if (t < velocity_.first() && !sameTime(t, velocity_.first())) return;
    const Mat3 held = Mat3::Identity() - projector(0);
    const Vec3 movement = way_ + (time - last_start_) * lateVelocity(last_start_), velocity = lateVelocity(t);
    for (std::size_t i = 0; i < nodes().size(); ++i) {
      moveHeld(state().kindOf(0), start_[i * std::size_t(heldRows())] + movement, held, x, row(i));
      v[row(i)] += held * (velocity - v[row(i)]);
    }
  }

  std::vector<bool> drivenAxes() const {
    const int count = state().kindOf(0) == RowKind::value ? int(state().rows_per_node) : 3 * int(state().rows_per_node);
    if (axes_.empty()) throw ComponentError("coordinates lists no axis", fmt::format("0 to {}", count - 1));
    std::vector<bool> driven(std::size_t(count), false);
    for (const int axis : axes_) {
      if (axis < 0 || axis >= count)
        throw ComponentError(fmt::format("coordinates lists the axis {}", axis), fmt::format("0 to {}", count - 1));
      driven[std::size_t(axis)] = true;
    }
    return driven;
  }

  RowKeys velocity_;
  std::vector<int> axes_;
  bool continue_ = false, late_ = false, runs_on_ = false;
  Vec3 ahead_ = Vec3::Zero();
  double start_time_ = 0;    ///< [s]
  static constexpr double never = std::numeric_limits<double>::lowest();
  double last_start_ = never, start_before_ = 0;  ///< of the step, and of the one before, where late [s]
  Vec3 way_ = Vec3::Zero();  ///< until then [m]
  std::vector<Vec3> start_;  ///< rows of the nodes at start_time_, as State::position has them; empty until then
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(linear_velocity_projective_constraint) {
  factory.add<stroma::LinearVelocityProjectiveConstraint>("LinearVelocityProjectiveConstraint",
                                                          "Drives nodes with velocities given at times");
}
