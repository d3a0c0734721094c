// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/richardson.h"

#include <cmath>
#include <cstddef>

namespace stroma::sweep {

std::optional<double> fittedOrder(double s1, double s2, double s3, double fine, double coarse) {
  if (!(0 < s1 && s1 < s2 && s2 < s3 && fine > 0 && coarse > 0)) return {};
  const double wanted = coarse / fine;
  // sizes over s_2, so that no power overflows; the ratio grows with p
  const double below = s1 / s2, above = s3 / s2;
  const auto ratio = [&](double p) { return (std::pow(above, p) - 1) / (1 - std::pow(below, p)); };
  double low = 0.1, high = 10;
  if (!(ratio(low) <= wanted && wanted <= ratio(high))) return {};
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (ratio(middle) < wanted ? low : high) = middle;
  }
  return (low + high) / 2;
}

double correctionFactor(double s1, double s2, double order) { return 1 / (std::pow(s2 / s1, order) - 1); }

std::optional<double> slopeOf(const std::vector<double>& sizes, const std::vector<double>& errors) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (!(sizes[i] > 0 && errors[i] > 0)) continue;
    const double a = std::log(sizes[i]), b = std::log(errors[i]);
    n += 1, x += a, y += b, xx += a * a, xy += a * b;
  }
  const double spread = n * xx - x * x;
  if (n < 2 || !(spread > 1e-12 * n * xx)) return {};
  return (n * xy - x * y) / spread;
}

}  // namespace stroma::sweep
