// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

namespace stroma::sweep {

/// A logarithmic axis: values to positions on the paper, and where its marks are.
class LogScale {
 public:
  /// Around all values above zero; `from` and `to` are the ends on the paper.
  LogScale(const std::vector<double>& values, double from, double to);
  /// Values at or below zero lie at the lower end.
  double at(double value) const;
  double low() const { return low_; }
  double high() const { return high_; }
  struct Mark {
    double value;
    bool has_label;
  };
  std::vector<Mark> marks() const;

 private:
  double low_ = 0.1, high_ = 10, from_, to_;
};

}  // namespace stroma::sweep
