// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces that push nodes back to one side of a surface. With g(x) the signed depth of a node (a length, positive inside
// the material of the obstacle), stiffness k and damping c:
//
//   E = k/2 g^2,   f = -k g grad g - c g v   where g > 0
//   df/dx = -k (grad g grad g^T + g H) - c (v.grad g) grad g grad g^T,   df/dv = -c g I,   H the second derivative of g
//
// The damping grows with the depth, so that the force has no jump at the contact. Of its derivative with respect to x
// only the normal part is kept: the rest is not symmetric. A force that is limited to F has E = F g - F^2/(2k) beyond
// the depth F/k.
//
// With explicitDamping, which is SOFA's, nothing of the damping is in the derivatives and df/dv = 0; the limit is that of force and
// damping together, and df/dx is that of the force without a limit; in front of a surface that pulls too, c is negative.
#pragma once
#include <vector>

#include "framework/mechanics/node_group_field.h"

namespace stroma {

/// Depth of a point and its derivatives.
struct Depth {
  double g = 0;                  ///< [m]
  Vec3 gradient = Vec3::Zero();  ///< [-]
  Mat3 hessian = Mat3::Zero();   ///< [1/m]
  bool in_front = false;         ///< of a surface that pulls too
};

class PenaltyField : public NodeGroupField<1> {
 public:
  /// Declares indices and localRange, damping and drawing attributes; the stiffness is the derived class's.
  void declare(DataTable& table) override;
  void init() override;
  ForceTraits traits() const override;
  void compile() override;
  double energy(ConstRows x) const override;
  void addForce(ConstRows x, ConstRows v, Rows f) override;

 protected:
  /// Depth at x; only its sign matters where it is not positive.
  virtual Depth depth(const Vec3& x) const = 0;

  double stiffness_constant_ = 500;  ///< k [N/m]
  double damping_constant_ = 0;      ///< c [N s/m^2]
  double largest_force_ = 0;         ///< F [N]; 0: not limited
  bool explicit_damping_ = false;

 private:
  std::vector<int> indices_, range_{-1, -1};
  std::vector<Index> nodes_;
};

}  // namespace stroma
