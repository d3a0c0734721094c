// SPDX-License-Identifier: LGPL-2.1-or-later
// What the forces of Lagrangian constraints of a step are worth when their rounds have ended.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "components/integrators/multipliers.h"
#include "framework/simulation/integrator.h"

namespace stroma {

/// The constraint that a row is of.
std::string Multipliers::nameOf(std::size_t row) const {
  const auto end = std::upper_bound(ends_.begin(), ends_.end(), row);
  const auto* constraint = system_->actors().lagrangian_constraints[std::size_t(end - ends_.begin())];
  return dynamic_cast<const Component&>(*constraint).path();
}

/// " (node 3 of /a/dofs, node 4 of /b/dofs)"
std::string Multipliers::nodesOf(std::size_t row) const {
  constexpr std::size_t most = 4;
  std::string nodes;
  const auto entries = rows_.entriesOf(rows_.rows()[row]);
  for (std::size_t i = 0; i < std::min(most, entries.size()); ++i)
    nodes += (i == 0 ? " (" : ", ") + system_->actors().describeRow(entries[i].row);
  return nodes.empty() ? nodes : nodes + (entries.size() > most ? " and others)" : ")");
}

/// That of all rows: no row says whose the forces of a step are.
double Multipliers::leastTolerance(bool kept) {
  findTolerances(system_->actors().lagrangian_constraints, ends_, kept, allowed_);
  return allowed_.empty() ? 0 : *std::min_element(allowed_.begin(), allowed_.end());
}

/// Bodies still move and turn by so little [m, rad] that what sweeps have left of a tolerated error does it.
bool Multipliers::isNoise(double step) {
  constexpr double most = 30;  // a small body turns by its error over its arms
  return !yields_.empty() && redundant_.areSwept() && step <= most * leastTolerance(false);
}

/// Where rounds begin: the forces of the one before hold where they have led, and others along directions that stay would be no better.
bool Multipliers::conditionsHold(int round, double& step) {
  if (keepDirections(round)) {
    is_answered_.clear();
    return false;
  }
  if (round == 0 || carries_ || !(keeps_ || isNoise(step))) return false;
  constexpr int many = 12;  // bodies that jam leave a violation that is reported: not all of what may be kept, as rounds go on
  constexpr double more = 10;
  if (keeps_) {
    leastTolerance(true);
    kept_allowed_ = allowed_;
    leastTolerance(false);
    for (std::size_t i = 0; i < allowed_.size() && round > many; ++i) allowed_[i] = std::min(more * allowed_[i], kept_allowed_[i]);
  }
  if (worst().off > 0) return false;
  step = 0;
  return true;
}

/// True, and the step has failed: its budget is spent.
bool Multipliers::isSpent(StepReport& report) {
  if (!is_spent_) return false;
  const auto farthest = worst();
  report.diverged = true;
  report.reason = fmt::format("{} finds no forces of Lagrangian constraints within the budget of a step, {} iterations on {} rows: {} "
                              "does not hold, a condition is off by {:.3g}{}. A smaller dt helps, or fewer places that meet at once; "
                              "conditionBudget, now {:g}, lets it search longer",
                              system_->integrator().path(), iterationsOfAll() - made_before_, live_.size(), nameOf(farthest.row),
                              farthest.off, nodesOf(farthest.row), budget_);
  return true;
}

/// What has not come to rest and what does not hold.
void Multipliers::judge(double step, double size, double rounding, StepReport& report) {
  if (!std::isfinite(step)) {
    report.diverged = true;
    report.reason = "the forces of Lagrangian constraints are not finite";
    return;
  }
  if (changes_left_ == 0 && !is_left_) {
    report.constraints_converged = false;
    report.constraint_reason = fmt::format("the conditions that {} finds forces for still change by these forces where its rounds end, as "
                                           "of a point that goes to and fro over corners of its curve. A smaller dt helps",
                                           system_->integrator().path());
    return;
  }
  if (isOnce()) {
    if (!is_swept_ || sweeps_->unsettled().empty()) return;
    report.constraints_converged = sweeps_->keepsUnsettled();
    report.constraint_reason = sweeps_->unsettled();
    return;
  }
  constexpr double still = 1e-6;  // of the place: what directions of forces still turn bodies by
  const double held = held_within * size + rounding + 1e-300;
  ConditionForces::Violation farthest;
  bool is_kept = true;
  for (const bool kept : {true, false}) {
    findTolerances(system_->actors().lagrangian_constraints, ends_, kept, allowed_);
    if (is_kept) farthest = worst(), is_kept = !kept || farthest.off <= held;
  }
  const auto refuse = [&](std::string reason) {
    report.constraints_converged = is_kept;
    report.constraint_reason = std::move(reason);
  };
  if (!(farthest.off <= held)) {
    const std::string name = nameOf(farthest.row), nodes = nodesOf(farthest.row);
    if (farthest.rubs)
      return refuse(fmt::format("the friction of {} is not Coulomb's: a slide is off by {:.3g} m{}", name, farthest.off, nodes));
    const auto entries = rows_.entriesOf(rows_.rows()[farthest.row]);
    const bool is_of_way = std::all_of(entries.begin(), entries.end(), [](const auto& entry) { return entry.gradient.isZero(0); });
    is_kept = is_kept && !is_of_way;
    if (is_of_way)
      return refuse(fmt::format("the Lagrangian constraint {} does not hold and no force mends it: the step goes farther than what "
                                "it can prove to be free{}. A smaller dt helps, or larger gaps",
                                name, nodes));
    const double g = std::abs(solve_.g[Eigen::Index(farthest.row)]);
    return refuse(fmt::format("the Lagrangian constraint {} does not hold: a condition is off by {:.3g}{}", name, g, nodes));
  }
  if (!isNoise(step) && !(step <= std::max(still * size, leastTolerance(false)) + rounding + 1e-300)) {
    is_kept = step <= leastTolerance(true);
    refuse(fmt::format("the forces of Lagrangian constraints that {} finds still move bodies by {:.2g} of their largest coordinate "
                       "when their rounds end",
                       system_->integrator().path(), step / size));
  }
}

}  // namespace stroma
