// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/scene/component.h"

namespace stroma {

/// A factor that a scene prescribes over time: `factors` at `times`, linear between them, constant outside; repeated
/// with `period` when it is given. Without any it is 1 at all times.
class FactorOverTime {
 public:
  enum class Sign { any, positive };
  /// Declares `times`, `factors` and `period`; `what` names the quantity in the help. Lengths and volumes take positive
  /// factors only.
  void declare(DataTable& table, const std::string& what, Sign sign);
  /// Throws ComponentError with a sentence when the lists do not fit.
  void check() const;
  bool varies() const { return factors_.size() > 1; }
  double at(double t) const;  ///< t [s]

 private:
  std::vector<double> times_, factors_;
  double period_ = 0;  ///< [s]; 0: not repeated
};

}  // namespace stroma
