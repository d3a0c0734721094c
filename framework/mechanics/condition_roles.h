// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/mechanics/lagrangian_constraint.h"
namespace stroma {
/// What a LagrangianConstraint knows of the forces of its rows: some say the same as others, and no force is the only one.
class SharesForces {
 public:
  virtual ~SharesForces() = default;
  /// Where the search begins [N], and by what rows that say the same yield to a force, in comparison; 0: this one says it alone.
  virtual void expectForces(std::span<double> forces, std::span<double> yields) const = 0;
};
/// A LagrangianConstraint whose forces say which conditions it has, as those of a point that a corner of its curve stops.
struct ChangesConditions {
  virtual ~ChangesConditions() = default;
  /// Its conditions hold at x by these forces, which move them by `answers` [m/N]. True: it has others from now on, as many.
  virtual bool changeConditions(ConstRows x, std::span<const double> forces, std::span<const double> answers) = 0;
  /// Of all that have rows up to `ends`.
  static bool changeAny(auto& all, const std::vector<std::size_t>& ends, ConstRows x, const double* forces, const double* answers) {
    bool have_changed = false;
    for (std::size_t i = 0, begin = 0; i < ends.size(); begin = ends[i++])
      if (auto* each = dynamic_cast<ChangesConditions*>(all[i]))
        have_changed |= each->changeConditions(x, {forces + begin, ends[i] - begin}, {answers + begin, ends[i] - begin});
    return have_changed;
  }
};
}  // namespace stroma
