// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "framework/scene/archive.h"

namespace stroma::porous {

/// Finds pressures that turn around at every step without getting smaller: those of a fluid stiffer than its tissue,
/// which come a step late and push too far, in turn to both sides.
class PressureSwings {
 public:
  void start(std::size_t nodes) { change_.assign(nodes, 0.), in_a_row_ = longest_ = 0, largest_ = 0; }
  void serialize(Archive& archive) {
    archive.rows("changes", change_.data(), change_.size());
    archive.value("swings", in_a_row_);
    archive.value("longest_swings", longest_);
    archive.value("largest_swing", largest_);
  }
  /// The pressures [Pa] before a step and after it (x of each row); changes below `noise` [Pa] in the mean are round-off.
  void note(const std::vector<double>& before, ConstRows after, double noise) {
    constexpr double turned = -0.9, smaller = 0.9;
    double along = 0, now = 0, then = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      const double change = after[Index(i)].x() - before[i];
      along += change * change_[i], now += change * change, then += change_[i] * change_[i];
      change_[i] = change;
    }
    const bool swings = along < turned * std::sqrt(now * then) && now > smaller * smaller * then &&
                        now > noise * noise * double(before.size());
    in_a_row_ = swings ? in_a_row_ + 1 : 0;
    longest_ = std::max(longest_, in_a_row_);
    if (in_a_row_ >= enough) largest_ = std::max(largest_, std::sqrt(now / double(before.size())));
  }
  static constexpr long enough = 3;  ///< steps in a row that swing and do not settle
  /// The most that have swung in a row so far, and the largest change of pressure in those beyond `enough` [Pa], in the mean.
  long longest() const { return longest_; }
  double largest() const { return largest_; }
  /// Steps up to the last one that swung.
  long inARow() const { return in_a_row_; }

 private:
  std::vector<double> change_;  ///< in the last step [Pa], shape (nodes)
  long in_a_row_ = 0, longest_ = 0;
  double largest_ = 0;
};

}  // namespace stroma::porous
