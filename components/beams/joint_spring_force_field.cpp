// SPDX-License-Identifier: LGPL-2.1-or-later
// JointSpringForceField: joints between pairs of rigid frames, as springs for how the second lies in the axes of the first.
//
//   p = q_a^-1 (c_b - c_a) - t,   psi = log(q_a^-1 q_b q_r^-1)
//   E = sum over x, y, z of 1/2 k p_i^2 + 1/2 kappa psi_i^2 + 1/2 b (psi_i beyond its limit)^2
//
// t and q_r say where the second frame rests. Of each axis k and kappa are the soft stiffness where the motion is free and the
// hard one where it is blocked. A free rotation may have limits. kd damps the relative velocity: force -kd v, torque -kd w.
// Frame b gets the force and the torque of the energy, frame a what balances them. psi is the shortest turn: a hinge that
// passes half a turn from its rest jumps to the other side, and what it blocks with it. ArticulatedSystemMapping has no such
// limit.
//
// `spring` is text in SOFA's words, for each joint
//
//   BEGIN_SPRING a b FREE_AXIS tx ty tz rx ry rz KS_T soft hard KS_R soft hard KS_B b KD kd R_LIM_X low high R_LIM_Y low high
//   R_LIM_Z low high REST_T x y z REST_R x y z w END_SPRING
//
// with what differs from the usual alone: translations blocked, rotations free, KS_T 0 10000, KS_R 0 10000, KS_B 100, KD 0,
// no limits [rad]. Where REST_T or REST_R is not given the frames rest as they start.
//
// Source: the name and the words are SOFA's, whose forces are not those of an energy. `unbalanced` has them: with t in fixed axes,
// d = c_b - c_a - t, and th = log(q_a^-1 q_b q_0),
//
//   force on a = R_a K R_a^T d + kd (v_b - v_a),   torque on a = R_a T(th) + kd (w_b - w_a),   the opposite on b
//
// without the arm of the force. T = kappa th by axes. Where one rotation is free and within its limits, with e' the free axis e
// turned by exp(th), the two that are blocked have kappa angle(e, e') e x e'. Beyond a limit T is b times what is beyond. The
// tangent is R_a K R_a^T and R_a kappa R_a^T by differences of both frames, without the damping. REST_T, whatever its numbers,
// stands for t = c_b - c_a and q_0 = q_b q_a^-1 of the start; without it t = 0 and q_0 is REST_R. KS_B is a hundredth of the hard
// stiffness by default and if it is 0, and a rotation whose limits are equal is blocked.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-12"/>
//   <MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1   1 0 0  0 0 0 1"/>
//   <UniformMass totalMass="2" inertia="0.1 0.1 0.1"/>
//   <FixedProjectiveConstraint indices="0"/>
//   <JointSpringForceField spring="BEGIN_SPRING 0 1 FREE_AXIS 0 0 0 0 0 1 KS_T 0 1e5 KS_R 0 1e4 END_SPRING"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>

#include "components/beams/frame_pair_field.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/node_pairs.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// A joint as it is written.
struct Joint {
  int a = 0, b = 0;
  std::array<bool, 6> free{false, false, false, true, true, true};
  double soft_shift = 0, hard_shift = 1e4, soft_turn = 0, hard_turn = 1e4, block = 100, damping = 0;
  std::array<double, 3> low, high;
  bool has_place = false, has_turn = false, has_block = false;
  Vec3 place = Vec3::Zero();
  Quaternion turn = Quaternion::Identity();
  Vec3 shifts() const { return constants(0, soft_shift, hard_shift); }
  Vec3 turns() const { return constants(3, soft_turn, hard_turn); }
  /// Some free rotation ends somewhere.
  bool isLimited() const {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (free[3 + axis] && (std::isfinite(low[axis]) || std::isfinite(high[axis]))) return true;
    return false;
  }
  /// The angle within the limits that is nearest, over whole turns.
  double lawful(std::size_t axis, double angle) const {
    if (angle > low[axis] && angle < high[axis]) return angle;
    const double turn = 2 * std::numbers::pi;
    const double above = angle - high[axis] + (angle > 0 ? 0 : turn), below = low[axis] - angle + (angle > 0 ? turn : 0);
    return above < below ? high[axis] : low[axis];
  }
  Vec3 constants(std::size_t first, double soft, double hard) const {
    return {free[first] ? soft : hard, free[first + 1] ? soft : hard, free[first + 2] ? soft : hard};
  }
  Joint() { low.fill(-std::numeric_limits<double>::infinity()), high.fill(std::numeric_limits<double>::infinity()); }
};

class JointReader {
 public:
  explicit JointReader(const std::string& text) : words_(text) {}

  std::vector<Joint> all() {
    std::vector<Joint> joints;
    for (std::string word; words_ >> word;) {
      if (word != "BEGIN_SPRING") complain(word, "BEGIN_SPRING");
      joints.push_back(one());
    }
    if (joints.empty()) throw ComponentError("there is no joint", "spring=\"BEGIN_SPRING 0 1 END_SPRING\"");
    return joints;
  }

 private:
  [[noreturn]] static void complain(const std::string& word, const std::string& expected) {
    throw ComponentError(fmt::format("spring: '{}' is not a word for it", word), expected);
  }
  double number(const std::string& of) {
    double value = 0;
    if (!(words_ >> value)) throw ComponentError("spring: " + of + " is not followed by its numbers", "numbers");
    return value;
  }

  static const Joint& checked(const Joint& joint) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (!(joint.low[axis] <= joint.high[axis]))
        throw ComponentError(fmt::format("spring: the limits {:g} and {:g} leave no angle", joint.low[axis], joint.high[axis]),
                             "the lower one first");
    if (joint.has_turn && !(std::abs(joint.turn.norm() - 1) < 1e-9))
      throw ComponentError("spring: REST_R is not an orientation", "x y z w, not all of them zero");
    for (const double number : {joint.soft_shift, joint.hard_shift, joint.soft_turn, joint.hard_turn, joint.block, joint.damping})
      if (!(number >= 0) || !std::isfinite(number))
        throw ComponentError(fmt::format("spring: {:g} is no stiffness and no damping", number), "numbers >= 0");
    return joint;
  }

  Joint one() {
    Joint joint;
    joint.a = int(number("BEGIN_SPRING")), joint.b = int(number("BEGIN_SPRING"));
    for (std::string word; words_ >> word;) {
      const auto next = [&] { return number(word); };
      if (word == "END_SPRING") return checked(joint);
      if (word == "FREE_AXIS") {
        for (bool& free : joint.free) free = next() != 0;
      } else if (word == "KS_T") {
        joint.soft_shift = next(), joint.hard_shift = next();
      } else if (word == "KS_R") {
        joint.soft_turn = next(), joint.hard_turn = next();
      } else if (word == "KS_B") {
        joint.block = next(), joint.has_block = joint.block > 0;
      } else if (word == "KD") {
        joint.damping = next();
      } else if (word == "R_LIM_X" || word == "R_LIM_Y" || word == "R_LIM_Z") {
        const std::size_t axis = std::size_t(word.back() - 'X');
        joint.low[axis] = next(), joint.high[axis] = next();
      } else if (word == "REST_T") {
        joint.has_place = true;
        for (int c = 0; c < 3; ++c) joint.place[c] = next();
      } else if (word == "REST_R") {
        joint.has_turn = true;
        for (int c = 0; c < 4; ++c) joint.turn.coeffs()[c] = next();
        joint.turn.normalize();
      } else {
        complain(word, "FREE_AXIS, KS_T, KS_R, KS_B, KD, R_LIM_X, R_LIM_Y, R_LIM_Z, REST_T, REST_R or END_SPRING");
      }
    }
    throw ComponentError("spring: a joint has no end", "END_SPRING");
  }

  std::istringstream words_;
};

class JointSpringForceField final : public FramePairFieldOf<JointSpringForceField> {
 public:
  void declare(DataTable& table) override {
    FramePairField::declare(table);
    table.addLink("object1", object1_).help("state of the first frames; the one of this node by default");
    table.addLink("object2", object2_).help("state of the second frames; the one of the first by default");
    table.add("spring", text_).help("the joints, in the words above").required();
    table.add("explicitForce", explicit_force_)
        .help("the joints are no part of the matrix, as in SOFA between bodies of different solvers: not stable for stiff ones");
    table.add("unbalanced", unbalanced_).help("SOFA's forces: torques do not balance, and rest positions stay in fixed axes");
    for (const char* name :
         {"outfile", "period", "reinit", "drawLawfulTorsion", "drawTorsion", "showFactorSize"})
      table.addVisualOnly(name);
  }

  void init() override {
    setFirstState(object1_, mstate_);
    ForceField::init();
    State* other = object2_.get() ? object2_.get() : &state();
    joints_ = JointReader(text_).all();
    std::vector<Pair> pairs;
    for (Joint& joint : joints_) {
      checkNode(joint.a, 0, state(), "spring");
      checkNode(joint.b, 0, *other, "spring");
      if (&state() == other && joint.a == joint.b)
        throw ComponentError(fmt::format("a joint joins frame {} to itself", joint.a), "two different frames");
      const std::size_t a = std::size_t(2 * joint.a), b = std::size_t(2 * joint.b);
      if (!state().hasFrames() || !other->hasFrames())
        throw ComponentError("joints are between rigid frames", "states of template Rigid3");
      const Quaternion back = turnedBy(state().position[a + 1]).conjugate();
      if (unbalanced_) {
        restAsInSofa(joint, other->position[b] - state().position[a], turnedBy(other->position[b + 1]) * back);
        pairs.push_back({Index(a), Index(b), Quaternion::Identity(), joint.turn, 0});
        continue;
      }
      if (!joint.has_place) joint.place = back * (other->position[b] - state().position[a]);
      if (!joint.has_turn) joint.turn = back * turnedBy(other->position[b + 1]);
      // R_b = q_b q_r^-1 is R_a where the joint rests
      pairs.push_back({Index(a), Index(b), Quaternion::Identity(), joint.turn.conjugate(), joint.damping});
    }
    setPairs(std::move(pairs), other);
  }

  void compile() override {
    FramePairField::compile();
    numbers_ = lanesOf<9>(joints_.size(), [this](std::size_t i, std::size_t k) {
      const Joint& joint = joints_[i];
      return k < 3 ? joint.place[Index(k)] : k < 6 ? joint.shifts()[Index(k - 3)] : joint.turns()[Index(k - 6)];
    });
    const bool limited = std::any_of(joints_.begin(), joints_.end(), [](const Joint& joint) { return joint.isLimited(); });
    limits_ = lanesOf<7>(limited ? joints_.size() : 0, [this](std::size_t i, std::size_t k) {
      const Joint& joint = joints_[i];
      const double inside = std::numeric_limits<double>::infinity();
      if (k == 6) return joint.block;
      if (!joint.free[3 + k % 3]) return k < 3 ? -inside : inside;
      return k < 3 ? joint.low[k] : joint.high[k - 3];
    });
  }

  void addForce(ConstRows x, ConstRows v, Rows f) override {
    if (!unbalanced_) return FramePairField::addForce(x, v, f);
    for (std::size_t i = 0; i < joints_.size(); ++i) addUnbalanced(i, x, v, f);
  }
  void computeTangents() const override {
    if (!unbalanced_) FramePairFieldOf::computeTangents();
  }
  double energy(ConstRows x) const override {
    if (!unbalanced_) return FramePairFieldOf::energy(x);
    double sum = 0;
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      const Local local(joints_[i], rows_[i], x);
      sum += local.way.dot(joints_[i].shifts().cwiseProduct(local.way)) / 2 + local.torsion.dot(torqueOf(joints_[i], local)) / 2;
    }
    return sum;
  }

  ForceTraits traits() const override {
    ForceTraits traits = FramePairField::traits();
    traits.exact_tangent = !traits.velocity_dependent;
    if (unbalanced_) traits.conservative = traits.exact_tangent = false;
    if (!explicit_force_) return traits;
    traits.conservative = !traits.velocity_dependent;  // damping that no C says is in no energy
    traits.has_stiffness = traits.velocity_dependent = traits.exact_tangent = false;
    return traits;
  }

 private:
  friend FramePairFieldOf;
  /// How the second frame lies, as SOFA's forces have it.
  struct Local {
    Mat3 axes, turn;    ///< R_a, R_a^T R_b R_0
    Vec3 way, torsion;  ///< R_a^T d, th
    Local(const Joint& joint, const Group& rows, ConstRows x) {
      const Quaternion a = orientationIn(x, rows[1]), relative = a.conjugate() * orientationIn(x, rows[3]) * joint.turn;
      axes = a.toRotationMatrix(), turn = relative.toRotationMatrix();
      way = axes.transpose() * (x[rows[2]] - x[rows[0]] - joint.place);
      torsion = rotationVector(relative);
    }
  };
  static void restAsInSofa(Joint& joint, const Vec3& place, const Quaternion& turn) {
    if (!joint.has_place && !joint.has_turn) joint.turn = Quaternion::Identity();
    if (!joint.has_place) joint.place = Vec3::Zero();
    if (joint.has_place) joint.place = place, joint.turn = turn;
    if (!joint.has_block) joint.block = joint.hard_turn / 100;
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (joint.low[axis] == joint.high[axis]) joint.free[3 + axis] = false;
  }

  /// Of SOFA's forces. `stiffness`: of each axis, where a limit makes it another one.
  static Vec3 torqueOf(const Joint& joint, const Local& local, Vec3* stiffness = nullptr) {
    Vec3 k = joint.turns(), torque = k.cwiseProduct(local.torsion), beyond = Vec3::Zero();
    int free = -1, frees = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t i = std::size_t(axis);
      if (!joint.free[3 + i]) beyond[axis] = local.torsion[axis];
      if (!joint.free[3 + i]) continue;
      ++frees, free = axis;
      beyond[axis] = local.torsion[axis] - joint.lawful(i, local.torsion[axis]);
    }
    if (frees == 1 && beyond[free] == 0) {  // between the free axis then and now
      const Vec3 axis = Vec3::Unit(free), across = axis.cross(local.turn.col(free));
      const double angle = std::atan2(across.norm(), local.turn(free, free));
      for (int other : {(free + 1) % 3, (free + 2) % 3}) torque[other] = k[other] * angle * across[other];
    } else if (const double size = beyond.norm(); frees > 0 && size > 0) {
      const double turns = std::remainder(size, 2 * std::numbers::pi);
      for (int axis = 0; axis < 3; ++axis) {
        if (!joint.free[3 + std::size_t(axis)] || beyond[axis] == 0) continue;
        k[axis] = joint.block;
        torque[axis] = k[axis] * beyond[axis] * turns / size;
      }
    }
    if (stiffness) *stiffness = k;
    return torque;
  }

  void addUnbalanced(std::size_t i, ConstRows x, ConstRows v, Rows f) {
    const Joint& joint = joints_[i];
    const Group& rows = rows_[i];
    const Local local(joint, rows, x);
    Vec3 turns;
    const Vec3 torque = local.axes * torqueOf(joint, local, &turns) + joint.damping * (v[rows[3]] - v[rows[1]]);
    const Vec3 force = local.axes * joint.shifts().cwiseProduct(local.way) + joint.damping * (v[rows[2]] - v[rows[0]]);
    f[rows[0]] += force, f[rows[1]] += torque;
    f[rows[2]] -= force, f[rows[3]] -= torque;
    const Mat3 by_shift = local.axes * joint.shifts().asDiagonal() * local.axes.transpose();
    const Mat3 by_turn = local.axes * turns.asDiagonal() * local.axes.transpose();
    for (int r = 0; r < 2; ++r)
      for (int c = 0; c < 2; ++c) {
        stiffness_[i].block(2 * r, 2 * c) = (r == c ? -1 : 1) * by_shift;
        stiffness_[i].block(2 * r + 1, 2 * c + 1) = (r == c ? -1 : 1) * by_turn;
      }
  }

  template <class T>
  Wrench<T> evaluate(std::size_t batch, const Triple<T>& p, const Triple<T>& psi, const InverseTerm<Pack>&) const {
    const LanesOf<9>& numbers = numbers_[batch];
    Wrench<T> wrench;
    const auto shift = [&](std::size_t axis, const T& value) {
      const T way = value - T(packOf(numbers[axis])), force = T(packOf(numbers[3 + axis])) * way;
      wrench.energy += 0.5 * valueOf(force) * valueOf(way);
      return force;
    };
    const auto turn = [&](std::size_t axis, const T& angle) {
      T torque = T(packOf(numbers[6 + axis])) * angle;
      wrench.energy += 0.5 * valueOf(torque) * valueOf(angle);
      if (limits_.empty()) return torque;
      const LanesOf<7>& limits = limits_[batch];
      const Pack limit = xsimd::clip(valueOf(angle), packOf(limits[axis]), packOf(limits[3 + axis]));
      const Pack block = select(limit == valueOf(angle), Pack(0.), packOf(limits[6]));
      const T excess = angle - T(limit);
      wrench.energy += 0.5 * block * valueOf(excess) * valueOf(excess);
      return torque + T(block) * excess;
    };
    wrench.n = {shift(0, p.x), shift(1, p.y), shift(2, p.z)};
    wrench.k = {turn(0, psi.x), turn(1, psi.y), turn(2, psi.z)};
    return wrench;
  }

  Link<State> object1_{"mechanical state"}, object2_{"mechanical state"};
  std::string text_;
  bool explicit_force_ = false, unbalanced_ = false;
  std::vector<Joint> joints_;
  std::vector<LanesOf<9>> numbers_;  ///< t, k and kappa of each batch
  std::vector<LanesOf<7>> limits_;   ///< lower and upper limits and b of each batch, where there are limits
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(joint_spring_force_field) {
  factory.add<stroma::JointSpringForceField>("JointSpringForceField", "joints between rigid frames, as springs");
}
