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
  State& second() const { return second_ ? *second_ : state(); }

  template <class T>
  struct Wrench {
    Triple<T> n, k;  ///< dE/dp, dE/dpsi
    double energy = 0;
  };
  virtual Wrench<double> wrench(std::size_t pair, const Triple<double>& p, const Triple<double>& psi) const = 0;
  virtual Wrench<Jet> wrench(std::size_t pair, const Triple<Jet>& p, const Triple<Jet>& psi) const = 0;

 private:
  struct Motion {
    Mat3 axes;         ///< R_a in space
    Vec3 arm, p, psi;  ///< c_b - c_a; p; psi
  };
  Motion motionOf(std::size_t pair, ConstRows x) const;
  void computeTangents() const override;

  std::vector<Pair> pairs_;
  State* second_ = nullptr;
  bool damped_ = false;
  mutable std::vector<Motion> motions_;  ///< of the last addForce()
};

}  // namespace stroma
