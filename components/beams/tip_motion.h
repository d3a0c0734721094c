// SPDX-License-Identifier: LGPL-2.1-or-later
// The motion of the tip of a rod as a file prescribes it. Its rows contain the time [ms], the advance of the tip in each step
// from then on [m], and a third number that is ignored. A step uses the last row before its start, the first steps the first
// row. From the last row on the tip is at the opening, as in SOFA.
#pragma once
#include <array>
#include <vector>

#include "framework/scene/data.h"

namespace stroma {

class TipMotion {
 public:
  /// Throws ComponentError with the row that is invalid.
  void read(const FileName& name);
  bool empty() const { return rows_.empty(); }
  /// The new position [m] of a tip that is at `tip` when a step starts at t [s].
  double next(double tip, double t) const;

 private:
  std::vector<std::array<double, 2>> rows_;  ///< time [s], way of a step [m]
};

}  // namespace stroma
