// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/equilibrium_choice.h"

#include <utility>

namespace stroma {

void EquilibriumChoice::noteDefinite(const SolveReport& report) {
  constexpr int most_failures = 3;
  const bool led_here = std::exchange(was_definite, report.stop == SolveStop::converged);
  if (!led_here || report.stop != SolveStop::not_definite) return;
  strict_failures += is_strict;
  is_strict = strict_failures < most_failures;
}

bool EquilibriumChoice::isDear(const SolverCosts& costs, int iterations, bool has_patches, bool made) {
  constexpr double worth_changing = 1.15, of_patches = 2;
  if (!keeps_factors) return false;
  spent += iterations * (has_patches ? of_patches : 1) * costs.iteration + (made && solves > 0 ? costs.setup : 0);
  ++solves;
  return spent > worth_changing * (costs.first + solves * costs.with_factors);
}

void EquilibriumChoice::serialize(Archive& archive) {
  archive.value("way", way);
  archive.value("patience", patience);
  archive.value("is_close", is_close);
  archive.value("is_rough", is_rough);
  archive.value("lost_iterations", lost_iterations);
  archive.value("left", left);
  archive.value("keeps_factors", keeps_factors);
  archive.value("refusals", refusals);
  archive.value("solves_by_multigrid", solves);
  archive.value("spent_by_multigrid", spent);
  archive.value("strict", is_strict);
  archive.value("strict_failures", strict_failures);
  archive.value("was_definite", was_definite);
}

}  // namespace stroma
