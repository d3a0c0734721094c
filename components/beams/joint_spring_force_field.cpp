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
// Source: the name and the words are SOFA's, whose forces are not those of an energy.
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
  bool has_place = false, has_turn = false;
  Vec3 place = Vec3::Zero();
  Quaternion turn = Quaternion::Identity();
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
      throw ComponentError("spring: REST_R is no orientation", "x y z w, not all of them zero");
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
        joint.block = next();
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
    table.addLink("object1", object1_).help("state of the first frames; the one of this node when not given");
    table.addLink("object2", object2_).help("state of the second frames; the one of the first when not given");
    table.add("spring", text_).help("the joints, in the words above").required();
    table.add("explicitForce", explicit_force_)
        .help("the joints are no part of the matrix, as in SOFA between bodies of different solvers: not stable for stiff ones");
    for (const char* name :
         {"outfile", "infile", "period", "reinit", "drawLawfulTorsion", "drawTorsion", "showFactorSize"})
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
      if (!joint.has_place) joint.place = back * (other->position[b] - state().position[a]);
      if (!joint.has_turn) joint.turn = back * turnedBy(other->position[b + 1]);
      // R_b = q_b q_r^-1 is R_a where the joint rests
      pairs.push_back({Index(a), Index(b), Quaternion::Identity(), joint.turn.conjugate(), joint.damping});
    }
    setPairs(std::move(pairs), other);
  }

  ForceTraits traits() const override {
    ForceTraits traits = FramePairField::traits();
    traits.exact_tangent = !traits.velocity_dependent;
    if (!explicit_force_) return traits;
    traits.conservative = !traits.velocity_dependent;  // damping that no C says is in no energy
    traits.has_stiffness = traits.velocity_dependent = traits.exact_tangent = false;
    return traits;
  }

 private:
  friend FramePairFieldOf;
  template <class T>
  Wrench<T> evaluate(std::size_t i, const Triple<T>& p, const Triple<T>& psi, const InverseTerm<double>&) const {
    const Joint& joint = joints_[i];
    Wrench<T> wrench;
    const auto shift = [&](int axis, const T& value) {
      const T way = value - T(joint.place[axis]);
      const T force = T(joint.free[std::size_t(axis)] ? joint.soft_shift : joint.hard_shift) * way;
      wrench.energy += 0.5 * valueOf(force) * valueOf(way);
      return force;
    };
    const auto turn = [&](std::size_t axis, const T& angle) {
      const bool free = joint.free[3 + axis];
      T torque = T(free ? joint.soft_turn : joint.hard_turn) * angle;
      wrench.energy += 0.5 * valueOf(torque) * valueOf(angle);
      const double limit = std::clamp(valueOf(angle), joint.low[axis], joint.high[axis]);
      if (!free || limit == valueOf(angle)) return torque;
      const T excess = angle - T(limit);
      wrench.energy += 0.5 * joint.block * valueOf(excess) * valueOf(excess);
      return torque + T(joint.block) * excess;
    };
    wrench.n = {shift(0, p.x), shift(1, p.y), shift(2, p.z)};
    wrench.k = {turn(0, psi.x), turn(1, psi.y), turn(2, psi.z)};
    return wrench;
  }

  Link<State> object1_{"mechanical state"}, object2_{"mechanical state"};
  std::string text_;
  bool explicit_force_ = false;
  std::vector<Joint> joints_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(joint_spring_force_field) {
  factory.add<stroma::JointSpringForceField>("JointSpringForceField", "joints between rigid frames, as springs");
}
