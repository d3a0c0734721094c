// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "framework/scene/component.h"
#include "framework/scene/types.h"

namespace stroma {

/// A vector that is given at some times and linear between them; constant before the first and after the last.
class KeyTimes {
 public:
  /// Declares "keyTimes" and `values_name`.
  void declare(DataTable& table, const std::string& values_name, const std::string& values_help,
               const std::string& unit);
  /// Instead of attributes of its own.
  void assign(std::vector<double> times, std::vector<Vec3> values, const std::string& values_name) {
    times_ = std::move(times), values_ = std::move(values), values_name_ = values_name;
  }
  /// Throws ComponentError: at least two times, ascending, and as many values.
  void check() const;
  double first() const { return times_.front(); }  ///< [s]
  double last() const { return times_.back(); }    ///< [s]
  Vec3 at(double t) const;
  /// The slope at t; at a key the one before it.
  Vec3 slope(double t) const;
  /// Integral from a to b.
  Vec3 integral(double a, double b) const;
  /// True when a step from t to t_end has a part between the first and the last key.
  bool touches(double t, double t_end) const;

  /// Two times closer than round-off of sums of steps are one.
  static bool same(double a, double b) { return std::abs(a - b) <= 1e-12 * (std::abs(a) + std::abs(b)); }

 private:
  std::size_t segment(double t) const;  ///< the i with times[i] < t <= times[i + 1]
  std::vector<double> times_;
  std::vector<Vec3> values_;
  std::string values_name_;
};

}  // namespace stroma
