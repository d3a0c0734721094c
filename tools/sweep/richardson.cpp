// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/richardson.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace stroma::sweep {
namespace {

/// Elements and integrators of the framework have no higher order: a fit above it is luck, and would flatter.
constexpr double highest_order = 2;
/// Below it a fit cannot be told from differences that do not shrink.
constexpr double lowest_order = 0.5;
/// Differences that point less the same way than this are no approach to a limit.
constexpr double least_cosine = 0.5;

/// Orders up to `highest`, and the uncertainty of the limit over the correction. Near 1 and 2, which methods have, a fit
/// is believed most; between them two terms are at work, and either may be what remains.
struct Trust {
  double highest, factor;
};
constexpr double factor_near_orders = 1.25;  // Roache's
constexpr Trust trust[] = {
    {0.85, factor_near_orders}, {1.15, factor_near_orders}, {1.75, 2.5}, {2.2, factor_near_orders}};
/// Above them all, where the differences shrink faster than they can.
constexpr double factor_above = 5;
/// Of the range of the values, where they follow no order.
constexpr double factor_without_order = 3;

const Trust* trustIn(const std::optional<double>& order) {
  return std::find_if(std::begin(trust), std::end(trust),
                      [&](const Trust& each) { return order && *order <= each.highest; });
}

/// The finest value is off by the correction, and by what that is off.
Extrapolation withLimit(std::optional<double> order, double factor, double difference, const Margin& of_limit) {
  const double correction = factor * difference;
  return {order,
          factor,
          correction,
          of_limit,
          {correction + of_limit.size, "the correction to size zero, and for its own uncertainty " + of_limit.how}};
}

Extrapolation withoutLimit(double correction, const Margin& margin) { return {{}, 0, correction, margin, margin}; }

/// One direction may carry the error and another one the refinement, so the differences tell no order.
Extrapolation ofUneven(const Triple& t) {
  constexpr double least = 1.1;  // below it a direction counts as not refined, and bounds nothing
  const double by_fine = t.fine / (std::max(t.least_refinement, least) - 1);
  const double by_coarse = t.coarse * correctionFactor(t.s2, t.s3, 1) * t.s1 / t.s2;
  return withLimit({}, correctionFactor(t.s1, t.s2, highest_order), t.fine,
                   {std::max(by_fine, by_coarse),
                    "the correction by the direction that is refined least: the refinement is uneven"});
}

}  // namespace

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

Extrapolation extrapolate(const Triple& t) {
  const auto order = fittedOrder(t.s1, t.s2, t.s3, t.fine, t.coarse);
  const bool is_above = !order && t.coarse > t.fine;
  if (t.cosine <= least_cosine || (!is_above && (!order || *order < lowest_order)))
    return withoutLimit(t.fine, {factor_without_order * std::max({t.fine, t.coarse, t.whole}),
                                 "three times the range of the three finest: the differences follow no order"});
  if (t.least_refinement > 0) return ofUneven(t);
  const double factor = correctionFactor(t.s1, t.s2, std::min(order.value_or(highest_order), highest_order));
  // the error of the finest value by the two others: larger where the order is above the highest
  const double by_coarse =
      t.coarse * correctionFactor(t.s2, t.s3, highest_order) * std::pow(t.s1 / t.s2, highest_order);
  const Trust* const band = trustIn(order);
  const bool is_believed = band != std::end(trust);
  Margin margin{(is_believed ? band->factor : factor_above) * std::max(factor * t.fine, by_coarse), {}};
  if (!is_believed)
    margin.how = "five times the correction to size zero: the differences shrink faster than any method's";
  else if (band->factor > factor_near_orders)
    margin.how = "2.5 times the correction to size zero: no method has this order";
  else
    margin.how = "1.25 times the correction to size zero";
  return withLimit(order, factor, t.fine, margin);
}

Extrapolation confirmed(Extrapolation finest, const Extrapolation& next, double apart) {
  if (!finest.hasLimit() || !next.hasLimit()) return finest;
  const Trust* const band = trustIn(finest.order);
  const bool is_near_order = band == &trust[1] || band == &trust[3];
  if (is_near_order && band == trustIn(next.order)) {
    finest.of_limit = {std::max(2 * apart, (factor_near_orders - 1) * finest.correction),
                       "twice the difference to the extrapolation without the finest, or a quarter of the correction"};
    finest.of_finest = {1.5 * finest.correction, "1.5 times the correction to size zero"};
  } else if (apart > finest.of_limit.size) {
    finest = withLimit(finest.order, finest.factor, finest.correction / finest.factor,
                       {apart, "the difference to the extrapolation without the finest"});
  }
  return finest;
}

Extrapolation ofTwo(double s1, double s2, double difference) {
  const double correction = correctionFactor(s1, s2, 1) * difference;
  return withoutLimit(correction, {3 * correction,
                                   "three times the correction to size zero by an order of 1: two "
                                   "values tell no order"});
}

}  // namespace stroma::sweep
