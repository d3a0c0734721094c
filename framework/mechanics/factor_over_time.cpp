// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/factor_over_time.h"

#include <fmt/format.h>

#include <cmath>

namespace stroma {

void FactorOverTime::declare(DataTable& table, const std::string& what, Sign sign) {
  table.add("times", times_).help("times at which " + what + " is given, ascending").unit("s");
  auto& factors =
      table.add("factors", factors_).help("factor on " + what + " at each of the times, linear between them; 1 by default").unit("-");
  if (sign == Sign::positive) factors.min(0, false);
  table.add("period", period_).help("repeats times and factors; 0: the last factor is kept").unit("s").min(0);
}

void FactorOverTime::check() {
  if (times_.size() != factors_.size())
    throw ComponentError(fmt::format("there are {} times and {} factors", times_.size(), factors_.size()), "as many of each");
  keys_.assign(times_, factors_, "times", "factors");
  keys_.checkAscending();
  if (period_ == 0) return;
  if (times_.size() < 2) throw ComponentError("a period is given but nothing to repeat", "times and factors");
  if (times_.front() != 0 || times_.back() > period_ * (1 + 1e-12))
    throw ComponentError(fmt::format("times run from {:g} to {:g} s and the period is {:g} s", times_.front(), times_.back(), period_),
                         "times from 0 up to the period");
  if (factors_.front() != factors_.back())
    throw ComponentError(
        fmt::format("the first factor is {:g} and the last {:g}: a period would end with a jump", factors_.front(), factors_.back()),
        "the same factor at the start and at the end of a period");
}

double FactorOverTime::at(double t) const {
  if (factors_.empty()) return 1;
  if (period_ > 0) t -= period_ * std::floor(t / period_);
  return keys_.at(t);
}

}  // namespace stroma
