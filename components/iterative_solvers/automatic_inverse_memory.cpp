// SPDX-License-Identifier: LGPL-2.1-or-later
// What AutomaticInverse remembers, for checkpoints and in words.
#include <fmt/format.h>

#include "components/iterative_solvers/automatic_inverse.h"

namespace stroma {

/// What the names of values begin with that outlive a change of the mesh (tools/session/carried_values.cpp).
constexpr const char* after_mesh_changes = "after_mesh_changes";

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
  archive.value("auto_jacobi_is_guess", jacobi_is_guess);
  archive.value("auto_may_factor", may_factor);
  archive.value("auto_new_pattern", has_new_pattern);
  archive.value("auto_at_once", at_once);
  archive.value("auto_counted", is_counted);
  factor_costs.serialize("auto_", archive);
  lessons.serialize("auto_lessons", archive);
}

void AutomaticInverse::Lessons::serialize(const std::string& name, Archive& archive) {
  archive.value(name + "_lifetime", lifetime);
  archive.value(name + "_decades", decades);
  archive.rows(name + "_rates", rates.data(), rates.size());
  archive.value(name + "_guess", jacobi_is_guess);
  archive.value(name + "_blocks", blocks_each);
  archive.value(name + "_expected_rate", expected_rate);
  factor_costs.serialize(name + "_", archive);
}

/// With those of the present mesh.
AutomaticInverse::Lessons AutomaticInverse::lessonsOfAll() const {
  constexpr double newest = 0.5;  // its part in the mean
  Lessons all = now_.lessons;
  if (now_.matrices == 0) return all;
  all.lifetime = all.isEmpty() ? now_.matrices : all.lifetime + newest * (now_.matrices - all.lifetime);
  if (now_.decades > 0) all.decades = now_.decades;
  for (const Way way : {Way::block_jacobi, Way::multigrid})
    if (const double rate = now_.rates[at(way)]; rate > 0) all.rates[at(way)] = rate;
  all.jacobi_is_guess = now_.jacobi_is_guess;
  if (now_.is_counted) all.factor_costs = now_.factor_costs;
  if (now_.blocks > 0) all.blocks_each = double(now_.blocks) / double(rows_), all.expected_rate = now_.expected_rate;
  return all;
}

/// Where the mesh has changed, they are of the run before and the rest is that of a new solver.
void AutomaticInverse::serializeLessons(Archive& archive) {
  Lessons all = lessonsOfAll();
  const Lessons own = all;
  all.serialize(after_mesh_changes, archive);
  if (!archive.isReading() || all == own) return;
  now_.lessons = all;
  now_.decades = all.decades, now_.rates = all.rates, now_.jacobi_is_guess = all.jacobi_is_guess;
  if (all.expected_rate > 0) now_.expected_rate = all.expected_rate;
  if (all.factor_costs.order > 0) now_.factor_costs = all.factor_costs, now_.is_counted = true;
  for (std::size_t way = 0; way < ways; ++way)
    if (all.rates[way] > 0) now_.gained[way] = all.decades, now_.spent[way] = all.rates[way] * all.decades;
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
  rows_ = matrix.rows();
  serializeLessons(archive);
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
