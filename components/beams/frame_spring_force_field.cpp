// SPDX-License-Identifier: LGPL-2.1-or-later
// FrameSpringForceField: springs between pairs of rigid frames that draw a point of the second to a point of the first, and its
// axes to those of the first.
//
//   y = q_a^-1 (c_b + q_b v_b - c_a) - v_a,   psi = log(q_a^-1 q_b),   E = k/2 |y|^2 + kappa/2 |psi|^2
//
// v_a and v_b are the points in the axes of their frames. psi is the shortest turn. kd damps the relative velocity: force -kd v,
// torque -kd w. Frame b gets the force and the torque of the energy, frame a what balances them.
//
// `spring` is text in SOFA's words, for each spring
//
//   BEGIN_SPRING a b KS_T k KS_R kappa KD kd VEC1 x y z VEC2 x y z END_SPRING
//
// with what differs from zero alone.
//
// Source: the name and the words are SOFA's, whose torques are not those of an energy.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-12"/>
//   <MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1   1 0 0  0 0 0 1"/>
//   <UniformMass totalMass="2" inertia="0.1 0.1 0.1"/>
//   <FixedProjectiveConstraint indices="0"/>
//   <FrameSpringForceField spring="BEGIN_SPRING 0 1 KS_T 1e3 KS_R 10 VEC1 0.5 0 0 VEC2 -0.5 0 0 END_SPRING"/>
// </Node>
#include <fmt/format.h>

#include <cmath>
#include <sstream>

#include "components/beams/frame_pair_field.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/node_pairs.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// sin(r)/r, (1 - cos(r))/r^2 and (r - sin(r))/r^3 as functions of q = r^2, and their first derivatives.
struct TurnTerms {
  Pack s, c, d, s1, c1, d1;
  explicit TurnTerms(Pack q) {
    s = 1. + q * (-1. / 6 + q * (1. / 120 + q * (-1. / 5040 + q * (1. / 362880))));
    c = 0.5 + q * (-1. / 24 + q * (1. / 720 + q * (-1. / 40320 + q * (1. / 3628800))));
    d = 1. / 6 + q * (-1. / 120 + q * (1. / 5040 + q * (-1. / 362880 + q * (1. / 39916800))));
    s1 = -1. / 6 + q * (1. / 60 + q * (-1. / 1680 + q * (1. / 90720 + q * (-1. / 7983360))));
    c1 = -1. / 24 + q * (1. / 360 + q * (-1. / 13440 + q * (1. / 907200 + q * (-1. / 95800320))));
    d1 = -1. / 120 + q * (1. / 2520 + q * (-1. / 120960 + q * (1. / 9979200)));
    const auto is_large = q >= Pack(0.05);
    if (!any(is_large)) return;
    const Pack r = sqrt(q), cosine = cos(r), far = sin(r) / r, far_c = (1. - cosine) / q, far_d = (1. - far) / q;
    const Pack far1 = (cosine - far) / (2. * q);
    s = select(is_large, far, s), c = select(is_large, far_c, c), d = select(is_large, far_d, d);
    s1 = select(is_large, far1, s1), c1 = select(is_large, (far * 0.5 - far_c) / q, c1);
    d1 = select(is_large, (-far1 - far_d) / q, d1);
  }
};

struct FrameSpring {
  int a = 0, b = 0;
  double shift = 0, turn = 0, damping = 0;  ///< k, kappa, kd
  Vec3 first = Vec3::Zero(), second = Vec3::Zero();
};

class SpringReader {
 public:
  explicit SpringReader(const std::string& text) : words_(text) {}

  std::vector<FrameSpring> all() {
    std::vector<FrameSpring> springs;
    for (std::string word; words_ >> word;) {
      if (word != "BEGIN_SPRING") complain(word, "BEGIN_SPRING");
      springs.push_back(one());
    }
    if (springs.empty()) throw ComponentError("there is no spring", "spring=\"BEGIN_SPRING 0 1 KS_T 100 END_SPRING\"");
    return springs;
  }

 private:
  [[noreturn]] static void complain(const std::string& word, const std::string& expected) {
    throw ComponentError(fmt::format("spring: '{}' is not a word for it", word), expected);
  }
  double number(const std::string& of) {
    double value = 0;
    if (!(words_ >> value) || !std::isfinite(value))
      throw ComponentError("spring: " + of + " is not followed by its numbers", "numbers");
    return value;
  }
  FrameSpring one() {
    FrameSpring spring;
    spring.a = int(number("BEGIN_SPRING")), spring.b = int(number("BEGIN_SPRING"));
    for (std::string word; words_ >> word;) {
      if (word == "END_SPRING") return spring;
      if (word == "VEC1" || word == "VEC2") {
        for (int i = 0; i < 3; ++i) (word == "VEC1" ? spring.first : spring.second)[i] = number(word);
        continue;
      }
      double* const value =
          word == "KS_T" ? &spring.shift : word == "KS_R" ? &spring.turn : word == "KD" ? &spring.damping : nullptr;
      if (!value) complain(word, "KS_T, KS_R, KD, VEC1, VEC2 or END_SPRING");
      *value = number(word);
      if (!(*value >= 0)) throw ComponentError(fmt::format("spring: {} is {:g}", word, *value), "a number >= 0");
    }
    throw ComponentError("spring: one of them has no end", "END_SPRING");
  }

  std::istringstream words_;
};

class FrameSpringForceField final : public FramePairFieldOf<FrameSpringForceField> {
 public:
  void declare(DataTable& table) override {
    FramePairField::declare(table);
    table.addLink("object1", object1_).help("state of the first frames; the one of this node by default");
    table.addLink("object2", object2_).help("state of the second frames; the one of the first by default");
    table.add("spring", text_).help("the springs, in the words above").required();
    for (const char* name : {"showLawfulTorsion", "showExtraTorsion"}) table.addVisualOnly(name);
  }

  void init() override {
    setFirstState(object1_, mstate_);
    ForceField::init();
    State* other = object2_.get() ? object2_.get() : &state();
    springs_ = SpringReader(text_).all();
    std::vector<Pair> pairs;
    for (const FrameSpring& spring : springs_) {
      checkNode(spring.a, 0, state(), "spring");
      checkNode(spring.b, 0, *other, "spring");
      if (&state() == other && spring.a == spring.b)
        throw ComponentError(fmt::format("a spring joins frame {} to itself", spring.a), "two different frames");
      pairs.push_back({Index(2 * spring.a), Index(2 * spring.b), Quaternion::Identity(), Quaternion::Identity(), spring.damping});
    }
    setPairs(std::move(pairs), other);
  }

  void compile() override {
    FramePairField::compile();
    numbers_ = lanesOf<8>(springs_.size(), [this](std::size_t i, std::size_t k) {
      const FrameSpring& spring = springs_[i];
      return k < 3 ? spring.first[Index(k)] : k < 6 ? spring.second[Index(k - 3)] : k == 6 ? spring.shift : spring.turn;
    });
  }

  ForceTraits traits() const override {
    ForceTraits traits = FramePairField::traits();
    traits.exact_tangent = !traits.velocity_dependent;
    return traits;
  }

 private:
  friend FramePairFieldOf;
  template <class T>
  Wrench<T> evaluate(std::size_t batch, const Triple<T>& p, const Triple<T>& psi, const InverseTerm<Pack>&) const {
    const LanesOf<8>& numbers = numbers_[batch];
    const Pack shift = packOf(numbers[6]), turn = packOf(numbers[7]);
    const T square = dot(psi, psi);
    const TurnTerms at(valueOf(square));
    const T s = chain(square, at.s, at.s1), c = chain(square, at.c, at.c1), d = chain(square, at.d, at.d1);
    const auto fixed = [&](std::size_t first) {
      return Triple<T>{T(packOf(numbers[first])), T(packOf(numbers[first + 1])), T(packOf(numbers[first + 2]))};
    };
    // u = exp(psi) v_b, which changes by dexp(psi) dpsi x u
    const Triple<T> arm = fixed(3), once = cross(psi, arm), u = arm + s * once + c * cross(psi, once);
    const Triple<T> y = p + u - fixed(0);
    Wrench<T> wrench;
    wrench.n = T(shift) * y;
    const Triple<T> moment = cross(u, wrench.n), turned = cross(psi, moment);
    wrench.k = T(turn) * psi + moment - c * turned + d * cross(psi, turned);
    wrench.energy = 0.5 * (shift * valueOf(dot(y, y)) + turn * valueOf(square));
    return wrench;
  }

  Link<State> object1_{"mechanical state"}, object2_{"mechanical state"};
  std::string text_;
  std::vector<FrameSpring> springs_;
  std::vector<LanesOf<8>> numbers_;  ///< v_a, v_b, k and kappa of each batch
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(frame_spring_force_field) {
  factory.add<stroma::FrameSpringForceField>("FrameSpringForceField", "springs between points and axes of rigid frames");
}
