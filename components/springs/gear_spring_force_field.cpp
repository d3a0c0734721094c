// SPDX-License-Identifier: LGPL-2.1-or-later
// GearSpringForceField: pairs of wheels that drive each other. Each wheel m is a rigid frame on a pivot, the frame p, or on
// its initial position if p is m itself. a_m, a_p: the axis of the wheel in both frames.
//
//   E = sum over both wheels of [k_t/2 |c_m - c_p|^2 + k_r/2 beta^2] + k_s/(2 R) (R phi_1 + phi_2)^2
//
// beta is the angle between a_m and a_p, and phi the angle by which the wheel is turned about its axis against the pivot, counted
// over whole turns. With the ratio R = 1 the wheels turn against each other by the same angle, with R the second one turns R times
// as far. Forces and torques are those of the energy, on wheels and pivots; at the teeth the torques on both wheels are
//
//   T_1 = -k_s (R phi_1 + phi_2),   T_2 = T_1 / R
//
// KD damps what a wheel moves and turns against the body of its pivot, its turning about the axis too: force -kd v, torque -kd w.
//
// phi is the twist of q = q_p^-1 q_m about e, 2 atan2(v.e, w) of q = (v, w); its derivative by a turn of the wheel is, in the axes
// of the pivot, (w^2 e + w v x e + (v.e) v) / (w^2 + (v.e)^2). The stiffness is the derivative less its skew part.
//
// `spring` is text in SOFA's words, for each pair
//
//   BEGIN_SPRING p1 m1 p2 m2 AXIS i j KS_T k_t KS_R k_s k_r KD kd RATIO R END_SPRING
//
// where i and j are 0, 1, 2 for the axes x, y, z of both. The defaults are AXIS 0 0, 10000 for each stiffness and KD, RATIO 1.
//
// Source: the name and the words are SOFA's. There the teeth act on the wheels and not on the pivots (oneSided), and KD is not
// in the matrix (explicitDamping).
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1   2 0 0  0 0 0 1"/>
//   <UniformMass totalMass="2" inertia="0.1 0.1 0.1"/>
//   <ConstantForceField indices="0" forces="0 0 0 0 0 1"/>
//   <GearSpringForceField spring="BEGIN_SPRING 0 0 1 1 AXIS 2 2 KS_R 1e4 1e4 KD 0.1 RATIO 2 END_SPRING"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "components/springs/twist.h"
#include "framework/mechanics/drawn_segments.h"
#include "framework/mechanics/frames.h"
#include "framework/mechanics/history.h"
#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/node_pairs.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// Two wheels as they are written; of each what belongs to the first and to the second.
struct Gear {
  std::array<int, 2> pivot{}, wheel{}, axis{};
  double shift = 1e4, teeth = 1e4, turn = 1e4, damping = 1e4, ratio = 1;
};

std::vector<Gear> readGears(const std::string& text) {
  std::istringstream words(text);
  std::vector<Gear> gears;
  const auto complain = [](const std::string& what, const std::string& expected) {
    throw ComponentError("spring: " + what, expected);
  };
  for (std::string word; words >> word;) {
    const auto read = [&](auto& value) {
      if (!(words >> value)) complain(word + " is not followed by its numbers", "numbers");
    };
    if (word != "BEGIN_SPRING") complain("'" + word + "' does not begin a pair of wheels", "BEGIN_SPRING");
    Gear gear;
    read(gear.pivot[0]), read(gear.wheel[0]), read(gear.pivot[1]), read(gear.wheel[1]);
    while (words >> word && word != "END_SPRING") {
      if (word == "AXIS")
        read(gear.axis[0]), read(gear.axis[1]);
      else if (word == "KS_T")
        read(gear.shift);
      else if (word == "KS_R")
        read(gear.teeth), read(gear.turn);
      else if (word == "KD")
        read(gear.damping);
      else if (word == "RATIO")
        read(gear.ratio);
      else
        complain("'" + word + "' is not a word for it", "AXIS, KS_T, KS_R, KD, RATIO or END_SPRING");
    }
    if (word != "END_SPRING") complain("a pair of wheels has no end", "END_SPRING");
    for (const int axis : gear.axis)
      if (axis < 0 || axis > 2) complain(fmt::format("AXIS {} is no axis", axis), "0, 1 or 2");
    for (const double number : {gear.shift, gear.teeth, gear.turn, gear.damping})
      if (!(number >= 0) || !std::isfinite(number))
        complain(fmt::format("{:g} is no stiffness and no damping", number), "numbers >= 0");
    if (!(gear.ratio > 0) || !std::isfinite(gear.ratio))
      complain(fmt::format("RATIO {:g} turns nothing", gear.ratio), "a number > 0");
    gears.push_back(gear);
  }
  if (gears.empty()) complain("there are no wheels", "spring=\"BEGIN_SPRING 0 0 1 1 END_SPRING\"");
  return gears;
}

class GearSpringForceField final : public NodeGroupField<8>, public History, public DrawnSegments {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.addLink("object1", object1_).help("state of the first wheels; the one of this node by default");
    table.addLink("object2", object2_).help("state of the second wheels; the one of the first by default");
    table.add("spring", text_).help("the pairs of wheels, in the words above").required();
    table.add("oneSided", one_sided_).help("pivots feel no torque of the teeth, as in SOFA");
    table.add("explicitDamping", explicit_damping_).help("KD is no part of the matrix, as in SOFA: not stable for large ones");
    for (const char* name : {"filename", "period", "reinit", "showFactorSize"}) table.addVisualOnly(name);
  }

  void init() override {
    setFirstState(object1_, mstate_);
    ForceField::init();
    second_ = object2_.get() ? object2_.get() : &state();
    for (const State* each : {&state(), second_})
      if (!each->hasFrames()) throw ComponentError(fmt::format("{} has no frames", each->path()), "a state of template Rigid3");
    gears_ = readGears(text_);
    for (const Gear& gear : gears_)
      for (const std::size_t i : {0, 1})
        checkNode(gear.pivot[i], i, stateOf(i), "spring"), checkNode(gear.wheel[i], i, stateOf(i), "spring");
    starts_.clear(), angles_.clear();
    for (const Gear& gear : gears_)
      for (const std::size_t i : {0, 1}) {
        const auto at = [&](int node) { return std::size_t(2 * node); };
        const std::vector<Vec3>& x = stateOf(i).position;
        starts_.push_back({x[at(gear.wheel[i])], turnedBy(x[at(gear.wheel[i]) + 1])});
        const Quaternion pivot = turnedBy(x[at(gear.pivot[i]) + 1]);
        angles_.push_back(toHalfTurn(Twist(pivot.conjugate() * starts_.back().turn, Vec3::Unit(gear.axis[i])).angle));
      }
    first_angles_ = angles_;
    time_ = state().node().root().root_time;
  }

  std::vector<State*> states() const override {
    return second_ == &state() ? std::vector<State*>{second_} : std::vector<State*>{&state(), second_};
  }

  ForceTraits traits() const override {
    bool damped = false;
    for (const Gear& gear : gears_) damped = damped || gear.damping > 0;
    ForceTraits traits;
    traits.symmetric = true;
    traits.conservative = !one_sided_ && !(damped && explicit_damping_);  // what no C says is in no energy and no work of damping
    traits.exact_tangent = !one_sided_ && !damped;
    traits.velocity_dependent = damped && !explicit_damping_;
    return traits;
  }

  void compile() override {
    std::vector<Group> rows;
    for (const Gear& gear : gears_) {
      Group group{};
      for (const std::size_t i : {0, 1}) {
        const Index pivot = stateOf(i).firstRow() + 2 * gear.pivot[i], wheel = stateOf(i).firstRow() + 2 * gear.wheel[i];
        group[4 * i] = pivot, group[4 * i + 1] = pivot + 1, group[4 * i + 2] = wheel, group[4 * i + 3] = wheel + 1;
      }
      rows.push_back(group);
    }
    setGroups(std::move(rows), traits().velocity_dependent);
    wheels_.resize(gears_.size());
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t g = 0; g < gears_.size(); ++g) {
      const Gear& gear = gears_[g];
      for (const std::size_t i : {0, 1}) {
        const Wheel wheel = place(g, i, x);
        const double beta = std::atan2(wheel.axis.cross(wheel.pivot_axis).norm(), wheel.axis.dot(wheel.pivot_axis));
        sum += gear.shift / 2 * wheel.off.squaredNorm() + gear.turn / 2 * beta * beta;
      }
      const double slip = gear.ratio * place(g, 0, x).angle + place(g, 1, x).angle;
      sum += gear.teeth / (2 * gear.ratio) * slip * slip;
    }
    return sum;
  }

  void addForce(ConstRows x, ConstRows v, Rows f) override {
    for (std::size_t g = 0; g < gears_.size(); ++g) {
      wheels_[g] = {place(g, 0, x), place(g, 1, x)};
      for (const std::size_t i : {0, 1}) {
        addPivot(g, i, f);
        if (gears_[g].damping > 0) damp(g, i, v, f);
      }
      addTeeth(g, f);
    }
    outdateTangents();
  }

  // ---- whole turns ----
  /// Both states are rows of one system's vector.
  void stepEnded(double t) override {
    const double dt = t - std::exchange(time_, t);
    const Index end = std::max(state().firstRow() + state().size(), second_->firstRow() + second_->size());
    const auto before = std::ptrdiff_t(state().firstRow()) * row_doubles;
    const ConstRows x{state().x().data - before, end}, v{state().v().data - before, end};
    for (std::size_t g = 0; g < gears_.size(); ++g)
      for (const std::size_t i : {0, 1}) {
        const Wheel wheel = place(g, i, x);
        angles_[2 * g + i] = wheel.angle;
        const double pivot = wheel.is_free ? 0 : v[rows_[g][4 * i + 1]].dot(wheel.axis);
        largest_turn_ = std::max(largest_turn_, std::abs(v[rows_[g][4 * i + 3]].dot(wheel.axis) - pivot) * dt);
      }
  }
  std::string doubt(ConstRows) const override {
    if (!(largest_turn_ > 0.8 * std::numbers::pi)) return {};
    return fmt::format("a wheel of {} turns by {:.3g} rad in a step: more than half a turn is not counted; smaller steps are", path(),
                       largest_turn_);
  }
  const std::vector<double>& history() const override { return angles_; }
  void reset() override { angles_ = first_angles_, largest_turn_ = 0, time_ = state().node().root().root_time; }
  void serialize(Archive& archive) override {
    archive.value("largest_turn", largest_turn_);
    archive.value("time", time_);
    archive.list("angles", angles_);
    if (angles_.size() != 2 * gears_.size()) throw std::runtime_error("the checkpoint has the angles of other gears");
  }

  void addSegments(std::vector<Segment>& segments) const override {
    for (const Gear& gear : gears_) segments.push_back({&state(), 2 * gear.wheel[0], second_, 2 * gear.wheel[1]});
  }

 protected:
  bool takesAllRows() const override { return true; }
  void computeTangents() const override {
    for (std::size_t g = 0; g < gears_.size(); ++g) {
      stiffness_[g].setZero();
      for (const std::size_t i : {0, 1}) addPivotTangent(g, i);
      addTeethTangent(g);
      makeSymmetric(stiffness_[g]);
    }
  }

 private:
  struct Start {
    Vec3 place;
    Quaternion turn;
  };
  struct Wheel {
    bool is_free;  ///< from its start: without a pivot that moves
    Vec3 off, axis, pivot_axis, twist;
    Mat3 curve;    ///< derivative of twist by a turn of the wheel [in space]
    double angle;
  };
  State& stateOf(std::size_t i) const { return i == 0 ? state() : *second_; }
  static double toHalfTurn(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

  Wheel place(std::size_t g, std::size_t i, ConstRows x) const {
    const Group& rows = rows_[g];
    const Start& start = starts_[2 * g + i];
    const Vec3 e = Vec3::Unit(gears_[g].axis[i]);
    const bool is_free = rows[4 * i] == rows[4 * i + 2];
    const Quaternion pivot = is_free ? start.turn : orientationIn(x, rows[4 * i + 1]), wheel = orientationIn(x, rows[4 * i + 3]);
    const Vec3 centre = is_free ? start.place : Vec3(x[rows[4 * i]]);
    const Twist twist(pivot.conjugate() * wheel, e);
    const Mat3 axes = pivot.toRotationMatrix();
    const double before = angles_[2 * g + i];
    return {is_free,
            Vec3(x[rows[4 * i + 2]]) - centre,
            wheel * e,
            pivot * e,
            axes * twist.by_turn,
            axes * twist.curve * axes.transpose(),
            before + toHalfTurn(twist.angle - before)};
  }

  /// The torque k_r h n that turns an axis to that of the pivot: h = beta / sin beta, n = a_m x a_p. Axes that are opposite have no
  /// direction to turn to.
  struct Tilt {
    explicit Tilt(const Wheel& wheel) : n(wheel.axis.cross(wheel.pivot_axis)), c(wheel.axis.dot(wheel.pivot_axis)) {
      const double s2 = n.squaredNorm(), s = std::sqrt(s2);
      const bool is_near = c > 0 && s < 1e-4;
      h = is_near ? 1 + s2 / 6 : s > 0 ? std::atan2(s, c) / s : 0;
      slope = is_near ? -1. / 3 : s > 0 ? (c * h - 1) / s2 : 0;
    }
    Vec3 n;
    double c, h, slope;  ///< c = cos beta; slope = dh/dc
  };

  /// The spring that holds the centre, and the one that holds the axis.
  void addPivot(std::size_t g, std::size_t i, Rows f) const {
    const Wheel& wheel = wheels_[g][i];
    const Tilt tilt(wheel);
    const Vec3 force = -gears_[g].shift * wheel.off, torque = gears_[g].turn * tilt.h * tilt.n;
    const Index* const row = &rows_[g][4 * i];
    f[row[2]] += force, f[row[3]] += torque;
    if (!wheel.is_free) f[row[0]] -= force, f[row[1]] -= torque;
  }

  /// By the velocity of the centre against the pivot there, v_m - v_p - w_p x (c_m - c_p), and that of turning.
  void damp(std::size_t g, std::size_t i, ConstRows v, Rows f) {
    const double damping = gears_[g].damping;
    const bool is_free = wheels_[g][i].is_free;
    const Vec3& arm = wheels_[g][i].off;
    const Index* const row = &rows_[g][4 * i];
    Vec3 speed = v[row[2]], spin = v[row[3]];
    if (!is_free) speed -= Vec3(v[row[0]]) + Vec3(v[row[1]]).cross(arm), spin -= v[row[1]];
    f[row[2]] -= damping * speed, f[row[3]] -= damping * spin;
    if (!is_free) f[row[0]] += damping * speed, f[row[1]] += damping * (spin + arm.cross(speed));
    if (damping_.empty()) return;
    const Mat3 one = Mat3::Identity(), none = Mat3::Zero();
    // what a velocity of each row makes of both
    const std::array<Mat3, 4> moves{is_free ? none : -one, is_free ? none : crossMatrix(arm), one, none};
    const std::array<double, 4> turns{0, is_free ? 0. : -1., 0, 1};
    for (std::size_t r = 0; r < 4; ++r)
      for (std::size_t c = 0; c < 4; ++c)
        damping_[g].block(int(4 * i + r), int(4 * i + c)) =
            -damping * (moves[r].transpose() * moves[c] + turns[r] * turns[c] * one);
  }

  void addPivotTangent(std::size_t g, std::size_t i) const {
    const Gear& gear = gears_[g];
    const Wheel& wheel = wheels_[g][i];
    const auto& [n, c, h, slope] = Tilt(wheel);
    const int p = int(4 * i), m = p + 2;
    const Mat3 one = Mat3::Identity();
    const Mat3 by_wheel = gear.turn * (h * (wheel.axis * wheel.pivot_axis.transpose() - c * one) + slope * n * n.transpose());
    const Mat3 by_pivot = gear.turn * (h * (c * one - wheel.pivot_axis * wheel.axis.transpose()) - slope * n * n.transpose());
    DenseTangent<8>& k = stiffness_[g];
    k.block(m, m) -= gear.shift * one, k.block(m + 1, m + 1) += by_wheel;
    if (wheel.is_free) return;
    k.block(p, p) -= gear.shift * one, k.block(m, p) += gear.shift * one, k.block(p, m) += gear.shift * one;
    k.block(m + 1, p + 1) += by_pivot, k.block(p + 1, m + 1) -= by_wheel, k.block(p + 1, p + 1) -= by_pivot;
  }

  /// -k_s (R phi_1 + phi_2)
  double torqueOf(std::size_t g) const {
    return -gears_[g].teeth * (gears_[g].ratio * wheels_[g][0].angle + wheels_[g][1].angle);
  }
  bool isHeldByTeeth(std::size_t g, std::size_t i) const { return !wheels_[g][i].is_free && !one_sided_; }
  /// The share of that torque which a wheel gets.
  double shareOf(std::size_t g, std::size_t i) const { return i == 0 ? 1 : 1 / gears_[g].ratio; }

  void addTeeth(std::size_t g, Rows f) const {
    for (const std::size_t i : {0, 1}) {
      const Vec3 torque = torqueOf(g) * shareOf(g, i) * wheels_[g][i].twist;
      f[rows_[g][4 * i + 3]] += torque;
      if (isHeldByTeeth(g, i)) f[rows_[g][4 * i + 1]] -= torque;
    }
  }

  void addTeethTangent(std::size_t g) const {
    const std::array<double, 2> slope{gears_[g].ratio, 1};  // of the slip, by the angles
    const double torque = torqueOf(g);
    DenseTangent<8>& k = stiffness_[g];
    for (const std::size_t i : {0, 1}) {
      const int p = int(4 * i) + 1, m = p + 2;
      const Vec3 own = shareOf(g, i) * wheels_[g][i].twist;
      const bool reacts = isHeldByTeeth(g, i);
      for (const std::size_t j : {0, 1}) {
        const int pivot = int(4 * j) + 1, other = pivot + 2;
        const bool moves = isHeldByTeeth(g, j);
        const Mat3 block = -gears_[g].teeth * slope[j] * own * wheels_[g][j].twist.transpose();
        k.block(m, other) += block;
        if (moves) k.block(m, pivot) -= block;
        if (reacts) k.block(p, other) -= block;
        if (reacts && moves) k.block(p, pivot) += block;
      }
      if (one_sided_) continue;
      // by a turn of the wheel against the pivot, which carries it along
      const Mat3 curve = torque * shareOf(g, i) * wheels_[g][i].curve;
      const Mat3 carried = -crossMatrix(torque * own);
      k.block(m, m) += curve;
      if (!reacts) continue;
      k.block(m, p) += carried - curve, k.block(p, m) -= curve, k.block(p, p) -= carried - curve;
    }
  }

  static void makeSymmetric(DenseTangent<8>& k) {
    for (int r = 0; r < 8; ++r)
      for (int c = 0; c <= r; ++c) {
        const Mat3 mean = 0.5 * (k.block(r, c) + k.block(c, r).transpose());
        k.block(r, c) = mean, k.block(c, r) = mean.transpose();
      }
  }

  Link<State> object1_{"mechanical state"}, object2_{"mechanical state"};
  std::string text_;
  bool one_sided_ = false, explicit_damping_ = false;
  State* second_ = nullptr;
  std::vector<Gear> gears_;
  std::vector<std::array<Wheel, 2>> wheels_;   ///< where the last forces were asked for
  std::vector<Start> starts_;                  ///< of the wheels, two a gear
  std::vector<double> angles_, first_angles_;  ///< by which they have turned where the step starts [rad]
  double largest_turn_ = 0, time_ = 0;         ///< of a wheel in a step so far [rad]; where the step starts [s]
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(gear_spring_force_field) {
  factory.add<stroma::GearSpringForceField>("GearSpringForceField", "wheels that turn each other, rigid frames on pivots");
}
