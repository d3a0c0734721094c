// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <utility>

#include "components/integrators/equilibrium.h"
#include "components/integrators/exact_tangent.h"
#include "components/integrators/newton.h"

namespace stroma {

/// A step that has failed in all its parts, from its start, in one go, and for as many iterations as the scene allows. Solves end before
/// that where |R| has not halved in ten iterations. But what buckles, or hangs as a slack thread of stiff springs, first slides down a
/// valley of its energy, in which |R| rises and falls; and parts of the step begin where the valley begins. `solve` makes the solve.
/// True when it ends the step, as `report` then says; else x and good have what they had in `good`.
template <class Solve>
bool solvesPatiently(Newton& newton, Equilibrium& problem, Rows x, Vector& good, StepReport& report, const Solve& solve) {
  Vector reached(good.count());
  copy(good, reached);
  const int patience = std::exchange(newton.settings.patience, 0);
  bool is_over = false;
  if (patience > 0) {
    problem.giveUp(), problem.setShare(1);
    copy(x, good);
    StepReport last = solve();
    is_over = last.stopped || (last.newton_converged && !last.diverged);
    const int parts = report.load_parts;
    is_over ? addCounts(std::exchange(report, last), report) : addCounts(last, report);
    report.load_parts = parts;
    if (!is_over) report.reason += "; once more in one go: " + last.reason + " (a larger newton_iterations goes on)";
  }
  newton.settings.patience = patience;
  if (!is_over) copy(reached, good), copy(reached, x);
  return is_over;
}

}  // namespace stroma
