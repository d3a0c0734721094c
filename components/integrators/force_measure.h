// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/linear_solver.h"
#include "framework/mechanics/motion.h"
#include "framework/scene/archive.h"

namespace stroma {

/// Norms |f| of forces and torques, and |d| of displacements and rotations:
///   |f|^2 = sum |force|^2 + sum |torque|^2 / l^2,   |d|^2 = sum |displacement|^2 + l^2 sum |rotation|^2
/// with one length l for all frames, the geometric mean over them of (tr K_rotation / tr K_displacement)^1/2, where K are the diagonal
/// blocks of the system matrix. For a rod l is between its radius and the length of its elements, for a rigid body its radius of
/// gyration. Without l, sums of N and N m would depend on the unit of length. Without frames, l is not used.
class ForceMeasure {
 public:
  void compile(const Motion& motion) { motion_ = motion.turns() ? &motion : nullptr; }
  /// Computes l from `matrix`; unchanged if no frame has both stiffnesses.
  void take(const SystemMatrix& matrix);
  double force(ConstRows f) const { return motion_ ? sum(f, 1 / length_) : norm(f); }
  double way(ConstRows d) const { return motion_ ? sum(d, length_) : norm(d); }
  /// l is that of the last matrix with frames that have both stiffnesses.
  void serialize(Archive& archive, std::string_view name) {
    if (motion_) archive.value(name, length_);
  }

 private:
  double sum(ConstRows rows, double turns) const;

  const Motion* motion_ = nullptr;  ///< null: there are no frames
  double length_ = 1;               ///< l [m]
  std::vector<double> blocks_;      ///< work space
};

}  // namespace stroma
