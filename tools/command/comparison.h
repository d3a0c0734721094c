// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/state_file.h"

namespace stroma::command {

/// How far a recording of one state is from its reference.
struct Comparison {
  bool passed = false;
  std::string failure;           ///< a sentence with the worst node, time and value; empty when passed
  double position_error = 0;     ///< max over nodes and times of |dx| / size of the body
  double position_l2_error = 0;  ///< worst over the times of |dx|_2 / |x - centre|_2
  double velocity_error = 0;     ///< max of |dv| / max(size / duration, |v|_max)
  double velocity_l2_error = 0;  ///< worst over the times of |dv|_2 / (sqrt(nodes) * the same scale)
};

/// Passes when all four errors are at most `tolerance` and every number is finite. Another number of instants or nodes,
/// or another time, fails. The size of the body is the diagonal of the box around all reference positions (1 m for a
/// body that is one point at rest); the duration is the last reference time less the first [s].
Comparison compare(const std::vector<StateFrame>& reference, const std::vector<StateFrame>& actual, double tolerance);

}  // namespace stroma::command
