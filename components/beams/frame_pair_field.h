// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces between two rigid frames that have an energy E of how the one lies in the other:
//
//   p = R_a^T (c_b - c_a),   psi = log(R_a^T R_b)
//
// with R_a, R_b the axes of both as they are fixed in the frames. With n = dE/dp and k = dE/dpsi the force and the torque on
// frame b are, in the axes R_a, f = -n and m = -dexp^-T(psi) k; frame a gets -f and -m - p x f, so that forces and torques
// balance to round-off. The stiffness is the derivative of these, less its skew part: 1/2 [torque] of each frame, which adds
// up to zero over all that acts on a frame in equilibrium.
#pragma once
#include "components/beams/relative_motion.h"
#include "framework/mechanics/drawn_segments.h"
#include "framework/mechanics/frames.h"
#include "framework/mechanics/node_group_field.h"

namespace stroma {

class FramePairField : public NodeGroupField<4>, public DrawnSegments {
 public:
  std::vector<State*> states() const override;
  ForceTraits traits() const override;
  void compile() override;
  double energy(ConstRows x) const override;
  void addForce(ConstRows x, ConstRows v, Rows f) override;
  void addSegments(std::vector<Segment>& segments) const override;

 protected:
  bool takesAllRows() const override { return true; }
  struct Pair {
    Index a = 0, b = 0;         ///< rows of the centres, of state() and of second()
    Quaternion axes_a, axes_b;  ///< R_a and R_b in the axes of the frames
    double damping = 0;         ///< of the relative velocity, f = -damping v, torque = -damping w [N s/m], [N m s]
  };
  /// In init(), after ForceField::init(). Throws ComponentError unless both states have frames.
  void setPairs(std::vector<Pair> pairs, State* second = nullptr);
  const std::vector<Pair>& pairs() const { return pairs_; }
  virtual double drawnRadius() const { return 0; }  ///< of beams [m]
  State& second() const { return second_ ? *second_ : state(); }

  template <class T>
  struct Wrench {
    Triple<T> n, k;  ///< dE/dp, dE/dpsi
    double energy = 0;
  };
  /// How frame b lies in the axes of a.
  struct Motion {
    Mat3 axes;                ///< R_a in space
    Vec3 arm;                 ///< c_b - c_a
    Triple<double> p{}, psi{};
    InverseTerm term{0};      ///< of |psi|^2
  };
  /// n, k and E of each pair, and with their derivatives by p and psi.
  virtual void evaluateAll(const std::vector<Motion>& motions, std::vector<Wrench<double>>& out) const = 0;
  virtual void evaluateAll(const std::vector<Motion>& motions, std::vector<Wrench<Jet>>& out) const = 0;

 private:
  void place(ConstRows x, std::vector<Motion>& motions) const;
  void computeTangents() const override;

  std::vector<Pair> pairs_;
  State* second_ = nullptr;
  bool damped_ = false;
  mutable std::vector<Motion> motions_, work_motions_;  ///< of the last addForce(); of energy()
  mutable std::vector<Wrench<double>> wrenches_, work_wrenches_;
  mutable std::vector<Wrench<Jet>> tangent_wrenches_;
};

/// `Energy` has evaluate(pair, p, psi, term), once for all number types.
template <class Energy>
class FramePairFieldOf : public FramePairField {
 private:
  void evaluateAll(const std::vector<Motion>& motions, std::vector<Wrench<double>>& out) const final {
    const auto& energy = static_cast<const Energy&>(*this);
    for (std::size_t i = 0; i < motions.size(); ++i)
      out[i] = energy.evaluate(i, motions[i].p, motions[i].psi, motions[i].term);
  }
  void evaluateAll(const std::vector<Motion>& motions, std::vector<Wrench<Jet>>& out) const final {
    const auto& energy = static_cast<const Energy&>(*this);
    for (std::size_t i = 0; i < motions.size(); ++i) {
      const auto &p = motions[i].p, &psi = motions[i].psi;
      out[i] = energy.evaluate(i, Triple<Jet>{{p.x, 0}, {p.y, 1}, {p.z, 2}}, Triple<Jet>{{psi.x, 3}, {psi.y, 4}, {psi.z, 5}},
                               motions[i].term);
    }
  }
};

}  // namespace stroma
