// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/linear_solver.h"
#include "framework/mechanics/motion.h"
#include "framework/scene/archive.h"

namespace stroma {

/// The size |f| of forces and torques, and |d| of ways and turns:
///   |f|^2 = sum |force|^2 + sum |torque|^2 / l^2,   |d|^2 = sum |way|^2 + l^2 sum |turn|^2
/// with one length l for all frames, the geometric mean over them of (tr K_turn / tr K_place)^1/2, K the diagonal blocks of the
/// matrix that is solved with. A rod has some l between its radius and the length of its elements, a rigid body its radius of
/// gyration. Without it sums of N and N m would depend on the unit of length. Where nothing turns, l is not used.
class ForceMeasure {
 public:
  void compile(const Motion& motion) { motion_ = motion.turns() ? &motion : nullptr; }
  /// l becomes that of `matrix`; it stays where no frame is stiff both ways.
  void take(const SystemMatrix& matrix);
  double force(ConstRows f) const { return motion_ ? sum(f, 1 / length_) : norm(f); }
  double way(ConstRows d) const { return motion_ ? sum(d, length_) : norm(d); }
  /// l is that of the last matrix with frames that are stiff both ways.
  void serialize(Archive& archive, std::string_view name) {
    if (motion_) archive.value(name, length_);
  }

 private:
  double sum(ConstRows rows, double turns) const;

  const Motion* motion_ = nullptr;  ///< null: nothing turns
  double length_ = 1;               ///< l [m]
  std::vector<double> blocks_;      ///< work space
};

}  // namespace stroma
