// SPDX-License-Identifier: LGPL-2.1-or-later
// Euler's equations of rigid bodies whose inertia is not the same about all axes. With q the orientation, J = R J0 R^T
// the inertia in fixed axes, w the angular velocity and L = J w the angular momentum,
//
//   L' = torque,   that is   J w' = torque - w x J w
//
// Integrators step L where they can: a body without torque then keeps it to round-off. What is left is w from L and the
// orientation that the step ends with, three equations a body,
//
//   J(exp(r + c (u - w0)) q0) u = L,   r the turn of the step for u = w0, c = dx/du
#pragma once
#include <vector>

#include "framework/mechanics/frames.h"
#include "framework/simulation/system.h"

namespace stroma {

class TurningBodies {
 public:
  /// The orientations of independent states.
  void compile(const System& system);
  bool empty() const { return bodies_.empty(); }
  std::size_t count() const { return bodies_.size(); }
  Index row(std::size_t body) const { return bodies_[body].row; }
  /// J of a body in row orientations of x.
  Mat3 inertia(std::size_t body, ConstRows x) const;
  /// J w of each body.
  void momenta(ConstRows x, ConstRows v, std::vector<Vec3>& out) const;
  /// out += factor w x J w in the rows of the bodies.
  void addGyroscopic(ConstRows x, ConstRows v, double factor, Rows out) const;
  /// a = J^-1 f in the rows of the bodies.
  void divide(ConstRows x, ConstRows f, Rows a) const;
  /// v of the bodies becomes J^-1 L in the directions that `constraints` leave free, the others keep theirs.
  void setVelocities(ConstRows x, const std::vector<Vec3>& momenta, const ConstraintSet& constraints, Rows v) const;
  /// Solves the equations above for the angular velocity u of one body, from a first guess; held directions keep theirs.
  /// `x` has q0.
  Vec3 solve(std::size_t body, ConstRows x, const Vec3& turn, double displacement, const Vec3& w0, const Vec3& momentum,
             const ConstraintSet& constraints, Vec3 u) const;

 private:
  struct Body {
    Index row = 0;  ///< of the system
    Mat3 inertia = Mat3::Zero();
    bool turns = true;  ///< false: the inertia stays as it is in fixed axes, and w x J w is left out
    Mat3 inertiaAt(const Quaternion& q) const;
  };
  std::vector<Body> bodies_;
};

}  // namespace stroma
