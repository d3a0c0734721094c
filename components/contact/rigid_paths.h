// SPDX-License-Identifier: LGPL-2.1-or-later
// The way by which forces on points of a rigid body do their work in a step. The frame at o goes by d and turns by the rotation vector w,
// which are the means of its velocities times h. A solve has the arms of all its forces at the end x1 of the step, those of the start's
// forces too, so that their torques move them with
//
//   d + w x (x1 - o1)
//
// On an arc that differs from x1 - x0, by about w^2 |x - o|/2. Points that no frame carries go straight, by x1 - x0.
#pragma once
#include <vector>

#include "components/contact/contact_bodies.h"

namespace stroma::contact {

class RigidPaths {
 public:
  void compile(const Surfaces& surfaces, const std::vector<State*>& bodies);
  /// Vertices have come from `start` to x; rows: positions of all rows.
  void find(const std::vector<Vec3>& start, const std::vector<Vec3>& x, ConstRows rows);
  /// One frame at least has turned on that way, by more than round-off.
  bool turns() const { return turns_; }
  const Vec3& of(std::size_t v) const { return ways_[v]; }

 private:
  struct Frame {
    std::size_t first = 0, end = 0;  ///< vertices
    Index row = 0;                   ///< of its centre
  };
  std::vector<Frame> frames_;
  std::vector<Vec3> ways_;
  bool turns_ = false;
};

}  // namespace stroma::contact
