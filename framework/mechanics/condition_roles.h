// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/mechanics/lagrangian_constraint.h"
namespace stroma {
/// What a LagrangianConstraint knows about the forces of redundant rows, whose forces are not unique.
class GuessesForces {
 public:
  virtual ~GuessesForces() = default;
  /// The initial force of each row [N], and its compliance relative to the other redundant rows; 0: the row is not redundant.
  virtual void guessForces(std::span<double> forces, std::span<double> yields) const = 0;
};
/// A LagrangianConstraint whose active conditions depend on its forces, like a point that is stopped at a corner of its curve.
struct ChangesConditions {
  virtual ~ChangesConditions() = default;
  /// The conditions hold at x with these forces, whose compliances are `answers` [m/N]. Returns true if it switches to others;
  /// their number stays the same.
  virtual bool changeConditions(ConstRows x, std::span<const double> forces, std::span<const double> answers) = 0;
  /// For all constraints, with rows up to `ends`.
  static bool changeAny(auto& all, const std::vector<std::size_t>& ends, ConstRows x, const double* forces, const double* answers) {
    bool have_changed = false;
    for (std::size_t i = 0, begin = 0; i < ends.size(); begin = ends[i++])
      if (auto* each = dynamic_cast<ChangesConditions*>(all[i]))
        have_changed |= each->changeConditions(x, {forces + begin, ends[i] - begin}, {answers + begin, ends[i] - begin});
    return have_changed;
  }
};
}  // namespace stroma
