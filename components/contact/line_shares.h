// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <utility>
#include <vector>

#include "framework/algebra/vector.h"

namespace stroma::contact {

/// Of which place a force without friction has its shares of surfaces, in the solves of a step. Shares follow the first iterates and
/// then stay. A search along a line asks for energies first, which have the shares of where the line starts, or for forces alone,
/// whose shares follow along the line. Where that makes forces jump, no step along it seems to help, however short: at the eighth
/// force they go back to those of before the line, and stay. Were that from the second force on, a flat punch would end 4 % off.
class LineShares {
 public:
  /// `again`: the last solve has ended with shares that were others there, and this one has them.
  void solveBegins(bool again = false) { weighings_ = again ? most_weighings : 0, forces_ = 0, is_on_line_ = is_ahead_ = false; }
  void lineBegins(bool is_carried) { is_on_line_ = !is_carried, is_ahead_ = false, forces_ = 0; }
  /// The place to weigh at for a force at x; null: shares stay.
  const std::vector<Vec3>* placeFor(const std::vector<Vec3>& x) {
    constexpr int most_forces = 8;
    forces_ += is_on_line_;
    if (forces_ == most_forces && std::exchange(is_ahead_, false)) return weighings_ = most_weighings, &(at_ = before_);
    if (weighings_ == most_weighings) return nullptr;
    ++weighings_;
    if (forces_ == 1) before_ = at_;
    is_ahead_ = is_on_line_;
    at_ = x;
    return &x;  // who asks has been told that nothing changes there
  }

 private:
  static constexpr int most_weighings = 6;
  int weighings_ = 0, forces_ = 0;  ///< of the solve; along the line
  bool is_on_line_ = false;         ///< a line has begun in the solve, and not of what is carried
  bool is_ahead_ = false;           ///< shares are those of a place on the line
  std::vector<Vec3> at_, before_;   ///< places whose shares there are, and were before the line
};

/// Solves of a step that are repeated because shares are others where one has ended. Where they only swing between two states, the
/// change is that of two rounds before, and another solve gains nothing; a change that gets smaller slowly goes on.
class ShareRounds {
 public:
  void stepBegins() { *this = {}; }
  /// `change`: of the forces, by the shares of where a solve has ended. Whether another one is to follow.
  bool goOn(double change) {
    constexpr double settled = 1e-2, gains = 0.9;
    constexpr int most = 10;
    const bool swings = rounds_ >= 2 && change >= gains * before_;
    before_ = std::exchange(left_, change);
    return change > settled && !swings && ++rounds_ < most;
  }
  double left() const { return left_; }  ///< what the last change was

 private:
  int rounds_ = 0;
  double left_ = 0, before_ = 0;  ///< the last change, and the one before
};

}  // namespace stroma::contact
