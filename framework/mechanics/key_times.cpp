// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/key_times.h"

#include <fmt/format.h>

#include <algorithm>

namespace stroma {

namespace {

template <class Value>
Value zero() {
  if constexpr (std::is_same_v<Value, double>)
    return 0;
  else
    return Value::Zero();
}

}  // namespace

template <class Value>
void KeyTimes<Value>::declare(DataTable& table, const std::string& values_name, const std::string& values_help, const std::string& unit) {
  values_name_ = values_name;
  table.add("keyTimes", times_).help("times, ascending").unit("s").required();
  table.add(values_name, values_).help(values_help).unit(unit).required();
}

template <class Value>
void KeyTimes<Value>::assign(std::vector<double> times, std::vector<Value> values, const std::string& times_name,
                             const std::string& values_name) {
  times_ = std::move(times), values_ = std::move(values), times_name_ = times_name, values_name_ = values_name;
}

template <class Value>
void KeyTimes<Value>::check() const {
  if (times_.size() < 2) throw ComponentError(fmt::format("{} has {} values", times_name_, times_.size()), "at least 2 times");
  if (values_.size() != times_.size())
    throw ComponentError(fmt::format("{} has {} values for {} {}", values_name_, values_.size(), times_.size(), times_name_),
                         fmt::format("{} values, one for each time", times_.size()));
  checkAscending();
}

template <class Value>
void KeyTimes<Value>::checkAscending() const {
  for (std::size_t i = 1; i < times_.size(); ++i)
    if (!(times_[i] > times_[i - 1]))
      throw ComponentError(fmt::format("{0}[{1}] = {2:g} is not after {0}[{3}] = {4:g}", times_name_, i, times_[i], i - 1, times_[i - 1]),
                           "ascending times");
}

template <class Value>
std::size_t KeyTimes<Value>::segment(double t) const {
  std::size_t i = 0;
  while (i + 2 < times_.size() && t > times_[i + 1] && !sameTime(t, times_[i + 1])) ++i;
  return i;
}

template <class Value>
Value KeyTimes<Value>::at(double t) const {
  if (times_.size() == 1) return values_[0];
  const std::size_t i = segment(t);
  if (t >= times_[i + 1] || sameTime(t, times_[i + 1])) return values_[i + 1];
  if (t <= times_[i] || sameTime(t, times_[i])) return values_[i];
  const double s = (t - times_[i]) / (times_[i + 1] - times_[i]);
  return (1 - s) * values_[i] + s * values_[i + 1];
}

template <class Value>
Value KeyTimes<Value>::slope(double t) const {
  if (!touches(t, t) || (t > last() && !sameTime(t, last()))) return zero<Value>();
  const std::size_t i = segment(t);
  return (values_[i + 1] - values_[i]) / (times_[i + 1] - times_[i]);
}

template <class Value>
Value KeyTimes<Value>::integral(double a, double b) const {
  // trapezoids between the keys that lie inside: exact, the function is linear there
  Value sum = zero<Value>();
  double from = a;
  for (double key : times_) {
    if (key <= from || key >= b) continue;
    sum += (key - from) * (at(from) + at(key)) / 2, from = key;
  }
  return sum + (b - from) * (at(from) + at(b)) / 2;
}

template <class Value>
bool KeyTimes<Value>::touches(double t, double t_end) const {
  const bool begun = t_end > first() && !sameTime(t_end, first());
  const bool over = t_end > t && (t > last() || sameTime(t, last()));
  return begun && !over;
}

template class KeyTimes<double>;
template class KeyTimes<Vec3>;

}  // namespace stroma
