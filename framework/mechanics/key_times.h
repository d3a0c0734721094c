// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "framework/scene/component.h"
#include "framework/scene/types.h"

namespace stroma {

/// Times [s] that differ by no more than the round-off of summed steps are equal.
inline bool sameTime(double a, double b) { return std::abs(a - b) <= 1e-12 * (std::abs(a) + std::abs(b)); }

/// A value (double or Vec3) given at some times, linear between them, and constant before the first and after the last.
/// The only table of this kind: attributes with other names use assign().
template <class Value>
class KeyTimes {
 public:
  /// Declares "keyTimes" and `values_name`.
  void declare(DataTable& table, const std::string& values_name, const std::string& values_help,
               const std::string& unit);
  /// Used instead of declared attributes; `times_name` and `values_name` appear in messages.
  void assign(std::vector<double> times, std::vector<Value> values, const std::string& times_name,
              const std::string& values_name);
  /// Throws ComponentError unless there are at least two times, ascending, and one value each.
  void check() const;
  /// Throws ComponentError unless the times ascend.
  void checkAscending() const;

  // ---- with at least one time ----
  double first() const { return times_.front(); }  ///< [s]
  double last() const { return times_.back(); }    ///< [s]
  /// The value at t [s].
  Value at(double t) const;

  // ---- with at least two times ----
  /// The slope at t [1/s]; at a key, the slope before it.
  Value slope(double t) const;
  /// Integral from a to b [s].
  Value integral(double a, double b) const;
  /// True if a step from t to t_end overlaps the range of the keys.
  bool touches(double t, double t_end) const;

 private:
  std::size_t segment(double t) const;  ///< the i with times[i] < t <= times[i + 1]
  std::vector<double> times_;           ///< [s], shape (keys)
  std::vector<Value> values_;           ///< shape (keys)
  std::string times_name_ = "keyTimes", values_name_;
};

extern template class KeyTimes<double>;
extern template class KeyTimes<Vec3>;

}  // namespace stroma
