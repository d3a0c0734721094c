// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <utility>
#include <vector>

#include "framework/algebra/vector.h"

namespace stroma::contact {

/// Decides at which positions the surface shares of a frictionless force are computed in the solves of a step. Shares follow the
/// first iterates and then stay. A line search evaluates energies first, with the shares at the start of the line, or only forces, whose
/// shares follow along the line. If forces then jump, no step along the line seems to help, however short: at the eighth force the shares
/// from before the line are restored and kept. Doing this from the second force on would leave a flat punch 4 % off.
class LineShares {
 public:
  /// `again`: shares changed at the end of the last solve, and this one uses the new ones.
  void solveBegins(bool again = false) { weighings_ = again ? most_weighings : 0, forces_ = 0, is_on_line_ = is_ahead_ = false; }
  void lineBegins(bool is_carried) { is_on_line_ = !is_carried, is_ahead_ = false, forces_ = 0; }
  /// The positions for computing shares for a force at x; null: shares stay.
  const std::vector<Vec3>* placeFor(const std::vector<Vec3>& x) {
    constexpr int most_forces = 8;
    forces_ += is_on_line_;
    if (forces_ == most_forces && std::exchange(is_ahead_, false)) return weighings_ = most_weighings, &(at_ = before_);
    if (weighings_ == most_weighings) return nullptr;
    ++weighings_;
    if (forces_ == 1) before_ = at_;
    is_ahead_ = is_on_line_;
    at_ = x;
    return &x;  // the caller assumes that nothing changes there
  }

 private:
  static constexpr int most_weighings = 6;
  int weighings_ = 0, forces_ = 0;  ///< of the solve; along the line
  bool is_on_line_ = false;         ///< a line search has begun in the solve, not a prescribed motion
  bool is_ahead_ = false;           ///< shares belong to a point on the line
  std::vector<Vec3> at_, before_;   ///< positions of the present shares, and of those before the line
};

/// Repeats the solves of a step because shares differ at the end of one. If shares oscillate between two states, the change equals the
/// one two rounds earlier, and another solve gains nothing. A slowly decreasing change continues.
class ShareRounds {
 public:
  void stepBegins() { *this = {}; }
  /// `change`: of the forces, with the shares at the end of a solve. Returns whether another solve must follow.
  bool goOn(double change) {
    constexpr double settled = 1e-2, gains = 0.9;
    constexpr int most = 10;
    const bool swings = rounds_ >= 2 && change >= gains * before_;
    before_ = std::exchange(left_, change);
    return change > settled && !swings && ++rounds_ < most;
  }
  double left() const { return left_; }  ///< the last change

 private:
  int rounds_ = 0;
  double left_ = 0, before_ = 0;  ///< the last change, and the one before
};

}  // namespace stroma::contact
