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
  /// The orientations of independent states. Bodies that are tied are one, with the sum of their inertias.
  void compile(const System& system);
  bool empty() const { return bodies_.empty(); }
  std::size_t count() const { return bodies_.size(); }
  /// The inertia of one changes in fixed axes.
  bool anyTurns() const;
  bool turns(std::size_t body) const { return bodies_[body].turns; }
  /// Of a body; of tied ones the first.
  Index row(std::size_t body) const { return bodies_[body].row; }
  /// The rows of a body get this velocity, or acceleration.
  void put(std::size_t body, const Vec3& value, Rows v) const;
  /// The sum over the rows of a body: of forces, its torque.
  Vec3 sum(std::size_t body, ConstRows f) const;
  /// J w and J^-1 L of a body in row orientations of x.
  Vec3 times(std::size_t body, ConstRows x, const Vec3& w) const;
  Vec3 inverse(std::size_t body, ConstRows x, const Vec3& momentum) const;
  /// J w of each body.
  void momenta(ConstRows x, ConstRows v, std::vector<Vec3>& out) const;
  /// out += factor w x J w in the first rows of the bodies.
  void addGyroscopic(ConstRows x, ConstRows v, double factor, Rows out) const;
  /// J a = f in the directions of the bodies' turns that constraints leave free, a = 0 in the others.
  void divide(ConstRows x, ConstRows f, Rows a) const;
  /// v of the bodies becomes J^-1 L in the directions that constraints leave free, the others keep theirs.
  void setVelocities(ConstRows x, const std::vector<Vec3>& momenta, Rows v) const;
  /// Solves the equations above for the angular velocity u of one body, from a first guess; held directions keep theirs.
  /// `x` has q0.
  Vec3 solve(std::size_t body, ConstRows x, const Vec3& turn, double displacement, const Vec3& w0, const Vec3& momentum,
             Vec3 u) const;
  /// What a correction makes of u whose change of momentum is J(exp(r + c (u - w0)) q0) change.
  Vec3 corrected(std::size_t body, ConstRows x, const Vec3& turn, double displacement, const Vec3& w0, const Vec3& u,
                 const Vec3& change) const;

 private:
  struct Body {
    Index row = 0;  ///< of the system; -1: it has become part of another
    Mat3 inertia = Mat3::Zero();
    bool turns = true;  ///< false: the inertia stays as it is in fixed axes, and w x J w is left out
    Index group = -1;   ///< of rows that are tied to it
    Vec3 moments = Vec3::Zero(), inverse = Vec3::Zero();  ///< principal ones, and one over each
    Quaternion axes = Quaternion::Identity();             ///< their axes in those of the body
    Mat3 inertiaAt(const Quaternion& q) const;
    /// Times the diagonal matrix `factors` in the principal axes.
    Vec3 scaled(const Quaternion& q, const Vec3& factors, const Vec3& w) const;
  };
  const Mat3* projectorOf(Index row) const;
  /// J^-1 L in the directions that constraints leave free, u in the others.
  Vec3 velocityOf(std::size_t body, ConstRows x, const Vec3& momentum, const Vec3& u) const;
  void join(const System& system, Index group, const std::vector<Index>& body_of_row);
  const ConstraintSet* constraints_ = nullptr;
  std::vector<Body> bodies_;
};

}  // namespace stroma
