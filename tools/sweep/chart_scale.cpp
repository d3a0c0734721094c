// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/chart_scale.h"

#include <algorithm>
#include <cmath>

namespace stroma::sweep {

LogScale::LogScale(const std::vector<double>& values, double from, double to) : from_(from), to_(to) {
  std::vector<double> positive;
  for (const double value : values)
    if (value > 0 && std::isfinite(value)) positive.push_back(value);
  if (positive.empty()) return;
  low_ = *std::ranges::min_element(positive), high_ = *std::ranges::max_element(positive);
  // room at both ends, and for at least a third of a decade
  const double decades = std::log10(high_ / low_), margin = std::max(0.08 * decades, (0.5 - decades) / 2);
  low_ *= std::pow(10, -std::max(margin, 0.06)), high_ *= std::pow(10, std::max(margin, 0.06));
}

double LogScale::at(double value) const {
  const double share = value > 0 ? std::log(value / low_) / std::log(high_ / low_) : 0;
  return from_ + (to_ - from_) * std::clamp(share, 0.0, 1.0);
}

std::vector<LogScale::Mark> LogScale::marks() const {
  const double decades = std::log10(high_ / low_);
  std::vector<Mark> marks;
  for (int power = int(std::floor(std::log10(low_))); power <= int(std::ceil(std::log10(high_))); ++power)
    for (int digit = 1; digit < 10; ++digit) {
      const double value = digit * std::pow(10.0, power);
      if (value < low_ || value > high_) continue;
      const bool is_round = digit == 1 || (decades < 2.5 && (digit == 2 || digit == 5)) ||
                            (decades < 0.8 && digit % 2 == 0) || decades < 0.5;
      const bool every_other = digit == 1 && decades > 8 && power % 2 != 0;
      marks.push_back({value, is_round && !every_other});
    }
  return marks;
}

}  // namespace stroma::sweep
