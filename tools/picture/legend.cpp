// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/picture/legend.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace stroma::picture {
namespace {

constexpr int most_steps = 7;  // from mark to mark

struct Prefix {
  const char* text;
  double factor;
};
constexpr std::array<Prefix, 7> prefixes{
    {{"G", 1e9}, {"M", 1e6}, {"k", 1e3}, {"", 1}, {"m", 1e-3}, {"µ", 1e-6}, {"n", 1e-9}}};

constexpr std::array<Prefix, 9> given_prefixes{
    {{"G", 1e9}, {"M", 1e6}, {"k", 1e3}, {"", 1}, {"c", 1e-2}, {"m", 1e-3}, {"u", 1e-6}, {"µ", 1e-6}, {"n", 1e-9}}};

}  // namespace

Scale scaleFor(double largest, const std::string& unit) {
  if (unit.empty() || unit == "-" || !(largest > 0)) return {1, unit == "-" ? "" : unit};
  double own = 1;  // of the unit: 1000 of kPa
  std::string plain = unit;
  for (const char* base : {"Pa", "m/s", "m", "N", "J"})
    for (const Prefix& prefix : given_prefixes)
      if (unit == std::string(prefix.text) + base) own = prefix.factor, plain = base;
  for (const Prefix& prefix : prefixes)
    if (largest * own >= 0.9999 * prefix.factor) {
      if (plain.starts_with("m") && prefix.factor > 1) break;  // nobody measures bodies in km
      return {prefix.factor / own, prefix.text + plain};
    }
  return {1 / own, plain};
}

double roundStep(double span, int most) {
  const double least = span / most;
  const double power = std::pow(10., std::floor(std::log10(least)));
  for (const double part : {1., 2., 2.5, 5.})
    if (part * power >= least * (1 - 1e-9)) return part * power;
  return 10 * power;
}

Range rounded(const Range& range) {
  const double size = std::max(std::abs(range.low), std::abs(range.high));
  if (!(range.low <= range.high)) return {0, 1};
  if (range.high - range.low <= 1e-5 * size || size == 0) {
    const double half = size > 0 ? 0.05 * size : 0.5;
    return size > 0 ? rounded({range.low - half, range.high + half}) : Range{0, 1};
  }
  double low = range.low;
  if (low > 0 && low < 0.3 * range.high) low = 0;  // from nothing on, when most of the way is there
  const double step = roundStep(range.high - low, most_steps);
  return {step * std::floor(low / step + 1e-6), step * std::ceil(range.high / step - 1e-6)};
}

std::vector<std::string> alike(const std::vector<double>& numbers) {
  constexpr int most_decimals = 15;
  double largest = 0;
  for (const double number : numbers) largest = std::max(largest, std::abs(number));
  std::vector<double> sorted = numbers;
  std::sort(sorted.begin(), sorted.end());
  double slack = 1e-4 * largest;
  for (std::size_t i = 1; i < sorted.size(); ++i)  // the same number, but for rounding, may come again
    if (const double gap = sorted[i] - sorted[i - 1]; gap > 1e-12 * largest) slack = std::min(slack, 0.01 * gap);
  const bool is_long = largest >= 1e5 || (largest > 0 && largest < 1e-3);
  for (int decimals = 0;; ++decimals) {
    std::vector<std::string> texts;
    bool exact = true;
    for (const double number : numbers) {
      texts.push_back(is_long ? fmt::format("{:.{}e}", number, decimals) : fmt::format("{:.{}f}", number, decimals));
      if (texts.back().starts_with('-') && std::stod(texts.back()) == 0) texts.back().erase(0, 1);
      exact = exact && std::abs(std::stod(texts.back()) - number) <= slack;
    }
    if (exact || decimals == most_decimals) return texts;
  }
}

Legend::Legend(const ColourMap& map, const Range& range, const Range& extremes, const FieldWord& field,
               std::string note)
    : map_(map), range_(range), extremes_(extremes), field_(field), note_(std::move(note)) {
  scale_ = scaleFor(std::max(std::abs(range.low), std::abs(range.high)), field.unit);
  const double step = roundStep(range.high - range.low, most_steps);
  std::vector<double> shown;
  const double first = std::ceil(range.low / step - 1e-6);
  for (int i = 0; i <= most_steps; ++i) {
    const double mark = step * (first + i);
    if (!(mark <= range.high + 1e-6 * step)) break;
    marks_.push_back(mark);
    shown.push_back(mark / scale_.factor);
  }
  texts_ = alike(shown);
}

std::string Legend::caption() const {
  return scale_.unit.empty() ? field_.title : fmt::format("{} [{}]", field_.title, scale_.unit);
}

std::string Legend::summary() const {
  // four digits of what tells the ends apart
  const double size = std::max(std::abs(range_.low), std::abs(range_.high));
  const int digits = std::clamp(3 + int(std::ceil(std::log10(size / (range_.high - range_.low)))), 4, 16);
  return fmt::format("{} {:.{}g} to {:.{}g}{}{}", field_.title, range_.low / scale_.factor, digits,
                     range_.high / scale_.factor, digits, scale_.unit.empty() ? "" : " ", scale_.unit);
}

int Legend::width(double size) const {
  int numbers = 0;
  for (const std::string& text : texts_) numbers = std::max(numbers, sizeOf(text, {size})[0]);
  const double notes = note_.empty() ? 0 : 1.1 * size;
  return int(1.1 * size + 0.6 * size + numbers + 0.5 * size + 1.2 * size + notes + 0.5 * size);
}

void Legend::draw(Canvas& canvas, int x, int y, int height, double size) const {
  const int bar = int(1.1 * size), tip = int(0.8 * bar);
  for (int row = 0; row < height; ++row) canvas.fill(x, y + row, bar, 1, map_.at(1 - (row + 0.5) / height));
  const double span = range_.high - range_.low, bottom = y + height, right = x + bar;
  if (extremes_.high > range_.high + 1e-6 * span)
    canvas.fillTriangle({double(x), double(y), right, double(y), x + 0.5 * bar, double(y - tip)}, map_.at(1));
  if (extremes_.low < range_.low - 1e-6 * span)
    canvas.fillTriangle({double(x), bottom, right, bottom, x + 0.5 * bar, bottom + tip}, map_.at(0));
  int numbers = 0;
  for (std::size_t i = 0; i < marks_.size(); ++i) {
    const double at = y + (1 - (marks_[i] - range_.low) / span) * height;
    canvas.fill(x + bar, int(at - 0.5), int(0.3 * size), std::max(1, int(size / 14)), Letters().colour);
    canvas.text(texts_[i], x + bar + 0.6 * size, at, {0, 0.5}, {size});
    numbers = std::max(numbers, sizeOf(texts_[i], {size})[0]);
  }
  Letters upwards{1.05 * size};
  upwards.upwards = true;
  const double left = x + bar + 1.1 * size + numbers, middle = y + 0.5 * height;
  canvas.text(caption(), left, middle, {0, 0.5}, upwards);
  upwards.size = 0.75 * size, upwards.colour = {0.42, 0.44, 0.47};
  canvas.text(note_, left + 1.35 * size, middle, {0, 0.5}, upwards);
}

}  // namespace stroma::picture
