// SPDX-License-Identifier: LGPL-2.1-or-later
// How a file moves the tip of a rod. Its rows are the time [ms], by how much the tip goes on in each step from then on [m], and a
// third number that nobody reads. A step goes by the last row that is before its start, the first steps by the first row. From the
// last row on the tip is at the opening, as in SOFA.
#pragma once
#include <array>
#include <vector>

#include "framework/scene/data.h"

namespace stroma {

class TipMotion {
 public:
  /// Throws ComponentError with the row that is none.
  void read(const FileName& name);
  bool empty() const { return rows_.empty(); }
  /// Where the tip goes [m] that is at `tip` when a step starts at t [s].
  double next(double tip, double t) const;

 private:
  std::vector<std::array<double, 2>> rows_;  ///< time [s], way of a step [m]
};

}  // namespace stroma
