// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/automatic_inverse.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace stroma {
namespace {

/// Bodies of fewer nodes are solved before it matters.
constexpr Index few_nodes = 2500;
/// Back and forth, and then it stays.
constexpr int most_changes = 2;

}  // namespace

bool AutomaticInverse::follow(SystemMatrix& matrix, SolveReport& report, StopToken stop) {
  costs_ = multigridCosts(matrix.rows(), product_);
  if (matrix.rows() < few_nodes || !may_change_) now_.lost = 0;
  const bool wrong = now_.lost > costs_.hierarchy && now_.changes < most_changes;
  if (wrong) change();
  if (!now_.has_multigrid) return blocks_.follow(matrix, report, stop);
  SolveReport refused;
  if (multigrid_.follow(matrix, refused, stop)) return true;
  if (refused.stop != SolveStop::not_definite) {
    report = refused;
    return false;
  }
  change();  // the conjugate gradients may come through
  now_.changes = most_changes;
  return blocks_.follow(matrix, report, stop);
}

void AutomaticInverse::change() {
  now_.has_multigrid = !now_.has_multigrid;
  now_.lost = 0;
  ++now_.changes;
  multigrid_.reset();
}

void AutomaticInverse::solved(const SolveReport& report) {
  if (report.iterations == 0) return;
  const double decades = std::max(0.5, -std::log10(std::max(report.relative_residual, 1e-16)));
  const double rate = report.iterations / decades;
  if (now_.has_multigrid) {
    multigrid_.solved(report);
    now_.multigrid_rate = rate;
    now_.lost += costs_.iteration * report.iterations - now_.rate * decades;
  } else {
    now_.rate = now_.rate == 0 ? rate : now_.rate + (rate - now_.rate) / 4;
    now_.lost += report.iterations - costs_.iteration * costs_.usual_rate * decades;
  }
  now_.lost = std::max(0.0, now_.lost);
}

void AutomaticInverse::reset() {
  blocks_.reset();
  multigrid_.reset();
  now_ = kept_ = {};
}

void AutomaticInverse::serialize(SystemMatrix& matrix, Archive& archive) {
  archive.value("auto_has_multigrid", now_.has_multigrid);
  archive.value("auto_changes", now_.changes);
  archive.value("auto_lost", now_.lost);
  archive.value("auto_rate", now_.rate);
  archive.value("auto_multigrid_rate", now_.multigrid_rate);
  if (now_.has_multigrid) multigrid_.serialize(matrix, archive);
}

std::string AutomaticInverse::choice() const {
  if (now_.has_multigrid)
    return fmt::format("preconditioned by multigrid: block Jacobi took {:.0f} iterations for a digit", now_.rate);
  if (now_.changes == most_changes && now_.multigrid_rate > 0)
    return fmt::format("preconditioned by block Jacobi: multigrid took {:.0f} iterations for a digit, at {:.0f} times the cost",
                       now_.multigrid_rate, costs_.iteration);
  return may_change_ ? "preconditioned by block Jacobi, or by multigrid once that costs less"
                     : "preconditioned by block Jacobi, because the scene caps iterations or wants no matrix";
}

}  // namespace stroma
