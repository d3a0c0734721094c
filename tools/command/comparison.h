// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/mechanics/frames.h"
#include "framework/simulation/state_file.h"

namespace stroma::command {

/// What leads from one value in the form of State::position to another; of orientations the shortest rotation vector [rad].
inline Vec3 wayBetween(RowKind kind, const Vec3& from, const Vec3& to) {
  return kind == RowKind::turn ? rotationVector(turnedBy(to) * turnedBy(from).conjugate()) : Vec3(to - from);
}

/// How far a recording of one state is from its reference. Places, orientations and numbers are compared apart, each by its
/// own size; the errors are those of the worst kind.
struct Comparison {
  bool passed = false;
  std::string failure;           ///< a sentence with the worst node, time and value; empty when passed
  double position_error = 0;     ///< max over nodes and times of |dx| / size
  double position_l2_error = 0;  ///< worst over the times of |dx|_2 / |x - centre|_2, or / (sqrt(rows) * size)
  double velocity_error = 0;     ///< max of |dv| / max(size / duration, |v|_max)
  double velocity_l2_error = 0;  ///< worst over the times of |dv|_2 / (sqrt(rows) * the same scale)
};

/// Passes when all four errors are at most `tolerance` and every number is finite. Another number of instants or nodes,
/// or another time, fails. The size of places is the diagonal of the box around all of the reference (1 m for a body that
/// is one point at rest), that of orientations 1 rad, that of numbers their range in the reference (their magnitude if they
/// are all equal). The duration is the last reference time less the first [s]. `state` says what the rows are.
Comparison compare(const std::vector<StateFrame>& reference, const std::vector<StateFrame>& actual, double tolerance,
                   const State& state);

}  // namespace stroma::command
