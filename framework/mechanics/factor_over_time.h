// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/mechanics/key_times.h"

namespace stroma {

/// A factor prescribed over time: `factors` at `times`, linear between them, constant outside, and repeated with `period`
/// if that is set. It is 1 if nothing is given.
class FactorOverTime {
 public:
  enum class Sign { any, positive };
  /// Declares `times`, `factors` and `period`; `what` names the quantity in the help. Lengths and volumes take positive
  /// factors only.
  void declare(DataTable& table, const std::string& what, Sign sign);
  /// In init(), before at(): throws ComponentError with a sentence when the lists do not fit.
  void check();
  bool varies() const { return factors_.size() > 1; }
  double at(double t) const;  ///< t [s]

 private:
  std::vector<double> times_, factors_;  ///< [s] and [-], as written
  KeyTimes<double> keys_;                ///< the same, once checked
  double period_ = 0;                    ///< [s]; 0: not repeated
};

}  // namespace stroma
