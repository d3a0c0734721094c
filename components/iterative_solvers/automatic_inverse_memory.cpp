// SPDX-License-Identifier: LGPL-2.1-or-later
// What AutomaticInverse remembers, for checkpoints and in words.
#include <fmt/format.h>

#include "components/iterative_solvers/automatic_inverse.h"

namespace stroma {

void AutomaticInverse::Memory::serialize(Archive& archive) {
  archive.value("auto_way", way);
  archive.value("auto_next", next);
  archive.value("auto_changes", changes);
  archive.value("auto_lost", lost);
  archive.rows("auto_rates", rates.data(), rates.size());
  archive.rows("auto_spent", spent.data(), spent.size());
  archive.rows("auto_gained", gained.data(), gained.size());
  archive.value("auto_decades", decades);
  archive.value("auto_with_factors", with_factors);
  archive.value("auto_factor_solves", factor_solves);
  archive.value("auto_factored_solves", factored_solves);
  archive.value("auto_multigrid_solves", multigrid_solves);
  archive.value("auto_renewals", renewals);
  archive.value("auto_fresh_rate", fresh_rate);
  archive.value("auto_given_up", given_up);
  archive.value("auto_product", product);
  former.serialize(archive);
  drifts.serialize(archive);
  archive.value("auto_next_former", next_former);
  archive.value("auto_wasted", wasted);
  archive.value("auto_solves", solves);
  archive.value("auto_matrices", matrices);
  archive.value("auto_patterns", patterns);
  archive.value("auto_refusals", refusals);
  archive.value("auto_blocks", blocks);
  archive.value("auto_expected_rate", expected_rate);
  archive.value("auto_may_factor", may_factor);
  archive.value("auto_new_pattern", has_new_pattern);
  archive.value("auto_at_once", at_once);
  archive.value("auto_counted", is_counted);
  archive.value("auto_single", factor_costs.is_single);
  archive.value("auto_order", factor_costs.order);
  archive.value("auto_factor", factor_costs.factor);
  archive.value("auto_application", factor_costs.application);
  archive.value("auto_entries", factor_costs.entries);
}

void AutomaticInverse::serialize(SystemMatrix& matrix, Archive& archive) {
  bool has_same_pattern = now_.key.matrix && now_.key.pattern == matrix.key().pattern, is_current = now_.key == matrix.key();
  archive.value("auto_pattern", has_same_pattern);
  archive.value("auto_current", is_current);
  now_.serialize(archive);
  if (archive.isReading()) {
    now_.key = has_same_pattern ? matrix.key() : MatrixKey{};
    if (!is_current) now_.key.values = -1;
  }
  if (now_.way == Way::multigrid) multigrid_.serialize(matrix, archive);
  if (now_.way == Way::factors) factors().serialize(matrix, archive);
}

std::string AutomaticInverse::choice() const {
  const double jacobi = now_.rates[at(Way::block_jacobi)];
  if (isRefused())
    return fmt::format("preconditioned by block Jacobi: the matrix was not definite in {} solves in a row", most_refusals);
  if (now_.way == Way::multigrid)
    return fmt::format("preconditioned by multigrid: block Jacobi took {:.0f} iterations for a digit", jacobi);
  if (isFactored(now_.way))
    return fmt::format("{}: block Jacobi took {:.0f} iterations for a digit",
                       isDirect()     ? "factors instead of iterations"
                       : now_.at_once ? "preconditioned by factors of each matrix"
                                      : "preconditioned by factors of former matrices",
                       jacobi);
  if (now_.changes > 0) {
    std::string others;
    if (const double rate = now_.rates[at(Way::multigrid)]; rate > 0)
      others = fmt::format("multigrid took {:.0f} iterations for a digit, at {:.0f} times the cost", rate,
                           iteration(Way::multigrid) / iteration(Way::block_jacobi));
    if (now_.factor_solves > 0)
      others += fmt::format("{}a solve by factors cost {:.1f} times as much", others.empty() ? "" : ", and ",
                            solve(Way::factors) / solve(Way::block_jacobi));
    return "preconditioned by block Jacobi: " + (others.empty() ? "a direct solver cost more" : others);
  }
  return may_change_ ? "preconditioned by block Jacobi, or by multigrid or factors once these cost less"
                     : "preconditioned by block Jacobi, because the scene caps iterations or wants no matrix";
}

}  // namespace stroma
