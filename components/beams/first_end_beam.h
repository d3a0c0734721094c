// SPDX-License-Identifier: LGPL-2.1-or-later
// A beam in the axes of the frame of its first end, as in SOFA. With u = R_a^T (c_b - c_a) less its value at rest and w the
// rotation vector of R_a^T R_b after that at rest, forces and torques of the ends are
//
//   -(R_a, R_a, R_a, R_a) K (0, 0, u, w)
//
// K is the Euler-Bernoulli stiffness matrix of a beam along x, whatever the direction of the beam in the frame. The tangent is
// -R_a K R_a^T with R_a fixed. Forces balance; torques balance only to first order in the displacement, and they derive from
// no energy.
#pragma once
#include <Eigen/Core>

#include "framework/mechanics/frames.h"
#include "framework/mechanics/node_group_field.h"

namespace stroma {

class FirstEndBeam {
 public:
  /// EA [N], EI and GJ [N m^2]; the ends at rest.
  FirstEndBeam(double axial, double bending, double twisting, const Vec3& c_a, const Quaternion& q_a, const Vec3& c_b,
               const Quaternion& q_b)
      : arm_(q_a.conjugate() * (c_b - c_a)), turn_(q_a.conjugate() * q_b) {
    const double l = arm_.norm(), shear = 12 * bending / (l * l * l), couple = 6 * bending / (l * l), bend = bending / l;
    k_.setZero();
    for (int sign : {1, -1}) {  // of the same end, and of the other
      const int other = sign > 0 ? 0 : 6;
      for (int end : {0, 6}) {
        const int row = end, column = (end + other) % 12;
        k_(row, column) = sign * axial / l, k_(row + 3, column + 3) = sign * twisting / l;
        k_(row + 1, column + 1) = k_(row + 2, column + 2) = sign * shear;
        k_(row + 4, column + 4) = k_(row + 5, column + 5) = (sign > 0 ? 4 : 2) * bend;
      }
    }
    for (int turn : {4, 10}) {  // the turns of both ends, by the displacements of a and of b
      const int y = turn, z = turn + 1;
      k_(y, 2) = k_(2, y) = -couple, k_(y, 8) = k_(8, y) = couple;
      k_(z, 1) = k_(1, z) = couple, k_(z, 7) = k_(7, z) = -couple;
    }
  }

  using Rows = std::array<Index, 4>;  ///< of c_a, a, c_b, b
  /// 1/2 (u, w) K (u, w), which is not a potential of the forces.
  double energy(ConstRows x, const Rows& rows) const {
    const Eigen::Matrix<double, 6, 1> d = displacement(x, rows);
    return 0.5 * d.dot(k_.bottomRightCorner<6, 6>() * d);
  }
  void addForce(ConstRows x, const Rows& rows, stroma::Rows f) const {
    const Eigen::Matrix<double, 12, 1> local = k_.rightCols<6>() * displacement(x, rows);
    const Quaternion a = orientationIn(x, rows[1]);
    for (std::size_t r = 0; r < 4; ++r) f[rows[r]] -= a * Vec3(local.segment<3>(Index(3 * r)));
  }
  void setTangent(const Mat3& axes, DenseTangent<4>& tangent) const {
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c) tangent.block(r, c) = -axes * k_.block<3, 3>(3 * r, 3 * c) * axes.transpose();
  }

 private:
  Eigen::Matrix<double, 6, 1> displacement(ConstRows x, const Rows& rows) const {
    const Quaternion back = orientationIn(x, rows[1]).conjugate();
    Eigen::Matrix<double, 6, 1> d;
    d << back * Vec3(x[rows[2]] - x[rows[0]]) - arm_, rotationVector(turn_.conjugate() * (back * orientationIn(x, rows[3])));
    return d;
  }

  Eigen::Matrix<double, 12, 12> k_;
  Vec3 arm_;         ///< R_a^T (c_b - c_a) at rest
  Quaternion turn_;  ///< R_a^T R_b at rest
};

}  // namespace stroma
