// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/mechanics/lagrangian_constraint.h"
namespace stroma {
/// What a LagrangianConstraint knows of the forces of its rows: some rows are redundant, so that their forces are not unique.
class SharesForces {
 public:
  virtual ~SharesForces() = default;
  /// The initial guess [N], and the relative compliance by which redundant rows share a force; 0: this row is not redundant.
  virtual void expectForces(std::span<double> forces, std::span<double> yields) const = 0;
};
/// A LagrangianConstraint whose forces decide which conditions it has, as those of a point stopped at a corner of its curve.
struct ChangesConditions {
  virtual ~ChangesConditions() = default;
  /// Its conditions hold at x by these forces, with compliances `answers` [m/N]. True: it has replaced them by as many others.
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
