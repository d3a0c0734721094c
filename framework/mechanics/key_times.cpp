// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/key_times.h"

#include <fmt/format.h>

#include <algorithm>

namespace stroma {

void KeyTimes::declare(DataTable& table, const std::string& values_name, const std::string& values_help,
                       const std::string& unit) {
  values_name_ = values_name;
  table.add("keyTimes", times_).help("times, ascending").unit("s").required();
  table.add(values_name, values_).help(values_help).unit(unit).required();
}

void KeyTimes::check() const {
  if (times_.size() < 2) throw ComponentError(fmt::format("keyTimes has {} values", times_.size()), "at least 2 times");
  if (values_.size() != times_.size())
    throw ComponentError(fmt::format("{} has {} values for {} keyTimes", values_name_, values_.size(), times_.size()),
                         fmt::format("{} values, one for each time", times_.size()));
  for (std::size_t i = 1; i < times_.size(); ++i)
    if (!(times_[i] > times_[i - 1]))
      throw ComponentError(
          fmt::format("keyTimes[{}] = {:g} is not after keyTimes[{}] = {:g}", i, times_[i], i - 1, times_[i - 1]),
          "ascending times");
}

std::size_t KeyTimes::segment(double t) const {
  std::size_t i = 0;
  while (i + 2 < times_.size() && t > times_[i + 1] && !same(t, times_[i + 1])) ++i;
  return i;
}

Vec3 KeyTimes::at(double t) const {
  const std::size_t i = segment(t);
  if (t >= times_[i + 1] || same(t, times_[i + 1])) return values_[i + 1];
  if (t <= times_[i] || same(t, times_[i])) return values_[i];
  const double s = (t - times_[i]) / (times_[i + 1] - times_[i]);
  return (1 - s) * values_[i] + s * values_[i + 1];
}

Vec3 KeyTimes::slope(double t) const {
  if (!touches(t, t) || (t > last() && !same(t, last()))) return Vec3::Zero();
  const std::size_t i = segment(t);
  return (values_[i + 1] - values_[i]) / (times_[i + 1] - times_[i]);
}

Vec3 KeyTimes::integral(double a, double b) const {
  // trapezoids between the keys that lie inside: exact, the function is linear there
  Vec3 sum = Vec3::Zero();
  double from = a;
  for (double key : times_) {
    if (key <= from || key >= b) continue;
    sum += (key - from) * (at(from) + at(key)) / 2;
    from = key;
  }
  return sum + (b - from) * (at(from) + at(b)) / 2;
}

bool KeyTimes::touches(double t, double t_end) const {
  const bool begun = t_end > first() && !same(t_end, first());
  const bool over = t_end > t && (t > last() || same(t, last()));
  return begun && !over;
}

}  // namespace stroma
