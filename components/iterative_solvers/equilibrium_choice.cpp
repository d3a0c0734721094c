// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/equilibrium_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "components/iterative_solvers/krylov_solver.h"
#include "components/iterative_solvers/scene_volumes.h"

namespace stroma {
namespace {

constexpr Index always_factored = 500;  // nodes
constexpr int usual_solves = 6;         // by Newton's method

/// Whether the laws of factors might choose wrongly.
bool isClose(const SolverCosts& by_law) {
  constexpr double too_high = 5, too_low = 2;
  return by_law.multigrid < too_low * by_law.direct && by_law.direct < too_high * by_law.multigrid;
}

}  // namespace

EquilibriumChoice chooseFirst(SystemMatrix& matrix, const Node& root, Index most_factored, SolverCosts& costs, std::string& reason) {
  EquilibriumChoice choice{.way = EquilibriumChoice::Way::factors};
  const Index rows = matrix.rows();
  reason = fmt::format("{} nodes are few", rows);
  if (rows < always_factored) return choice;
  const bool depends_on_state = matrixDependsOnState(root);
  const int solves = depends_on_state ? usual_solves : 1;
  const Extents extents = extentsOf(rows, matrix.positions());
  const auto costsOf = [&](const FactorCounts& counts) { return solverCosts(matrix, counts, solves); };
  costs = costsOf(factorCountsOf(extents));
  if (isClose(costs) || isWide(matrix.pattern()))
    costs = costsOf(fewest(matrix.pattern(), countFactors(matrix.pattern()), extents));
  choice.keeps_factors = costs.keeps_factors && depends_on_state && matrix.symmetric() && matrix.isOfLooseNodes();
  reason = fmt::format("{} nodes, {:.0f} x {:.0f} x {:.0f}, estimated {:.2g} s with factors of {:.2g} GB, {:.2g} s with multigrid",
                       rows, extents.length, extents.width, extents.height, costs.direct, 8e-9 * costs.factor_entries,
                       costs.multigrid);
  if (const VolumeTerms volumes = volumesOfFields(matrix, root); volumes.count() > 0) {
    const double with_pressures = secondsWithPressures(matrix, extents, volumes.count(), double(volumes.rows.size()), solves);
    reason += fmt::format(", {:.2g} s with pressures", with_pressures);
    // from 9,000 nodes on multigrid with patches takes more in any case
    if (with_pressures < costs.direct) choice.pressures = EquilibriumChoice::Pressures::expected;
  }
  if (costs.multigrid >= costs.direct && rows <= most_factored) return choice;
  choice.way = EquilibriumChoice::Way::multigrid;
  choice.patience = costs.patience();
  choice.is_close = costs.direct < IterationCosts::with_patches * costs.multigrid;
  return choice;
}

bool refutesPressures(SystemMatrix& matrix, const Node& root, EquilibriumChoice& choice) {
  using Pressures = EquilibriumChoice::Pressures;
  if (choice.pressures != Pressures::expected) return false;
  choice.pressures = hasStiffVolumes(matrix, root) ? Pressures::unknowns : Pressures::refuted;
  return choice.pressures == Pressures::refuted;
}

void EquilibriumChoice::givePressuresUp(const SolveReport& report) {
  pressures = Pressures::given_up;
  lost_with_pressures = report.iterations, left_with_pressures = report.relative_residual;
}

std::string EquilibriumChoice::ofPressures() const {
  if (pressures == Pressures::refuted) return "; not with pressures: the matrix has other terms than its force fields";
  if (pressures != Pressures::given_up) return {};
  if (lost_with_pressures == 0) return "; not with pressures: the body is not stable without its resistance to changes of volume";
  return fmt::format("; {} iterations with pressures left a residual of {:.2g}", lost_with_pressures, left_with_pressures);
}

std::vector<double> estimateSolves(SystemMatrix& matrix, bool has_patches) {
  constexpr double nanosecond = 1e-9, refined = 2;
  const BlockMatrix& pattern = matrix.pattern();
  const double rows = pattern.rows(), blocks = pattern.blocks();
  const FactorCounts counts = fewest(pattern, dissected(blocks, countFactors(pattern)), extentsOf(pattern.rows(), matrix.positions()));
  const SolverCosts costs = solverCosts(matrix, counts, 2);  // of one solve and of a later one
  const FactorCosts factors = factorCosts(rows, blocks, counts);
  const double cycle = nanosecond * IterationCosts::cycle(rows, blocks), iteration = costs.iteration - cycle;
  const double application = nanosecond * factors.application * (factors.is_single ? refined : 1);
  const double factorisation = nanosecond * (factors.factor + IterationCosts::assembly(matrix));
  const double times = has_patches ? IterationCosts::with_patches : 1, fit = factorsFit(counts.entries);
  return {iteration, cycle, application, costs.setup, costs.first - factorisation, factorisation, costs.with_factors, times, fit};
}

double roundOff(const SystemMatrix& matrix, ConstRows b, ConstRows x) {
  std::vector<double> blocks;
  matrix.diagonalBlocks(blocks);
  double sum = 0;
  for (Index row = 0; row < x.count; ++row)
    sum += (Eigen::Map<const Mat3>(blocks.data() + 9 * std::size_t(row)).transpose() * x[row]).squaredNorm();
  return std::numeric_limits<double>::epsilon() * std::sqrt(sum) / norm(b);
}

bool isAtRoundOff(const SystemMatrix& matrix, ConstRows b, ConstRows x, double left) {
  constexpr double little = 1e-6;
  return left <= std::max(little, 2 * roundOff(matrix, b, x));
}

void EquilibriumChoice::noteDefinite(const SolveReport& report) {
  constexpr int most_failures = 3;
  const bool led_here = std::exchange(was_definite, report.stop == SolveStop::converged);
  if (!led_here || report.stop != SolveStop::not_definite) return;
  strict_failures += is_strict;
  is_strict = strict_failures < most_failures;
}

int EquilibriumChoice::expectedIterations(double target, bool is_loose, int usual) const {
  constexpr int few = 8;
  constexpr double most = 1e6;
  if (rate == 0) return is_loose ? std::min(few, usual) : usual;
  return int(std::clamp(std::ceil(-rate * std::log10(target)), 1.0, most));
}

void EquilibriumChoice::noteRate(const SolveReport& report, double began) {
  constexpr double least_gain = 0.5;  // decades
  if (report.iterations == 0 || !report.usable()) return;
  rate = report.iterations / std::max(least_gain, std::log10(began / std::max(report.relative_residual, 1e-16)));
}

bool EquilibriumChoice::isDear(const SolverCosts& costs, int iterations, bool has_patches, bool made) {
  constexpr double worth_changing = 1.15, of_patches = 2;
  if (!keeps_factors) return false;
  spent += iterations * (has_patches ? of_patches : 1) * costs.iteration + (made && solves > 0 ? costs.setup : 0);
  ++solves;
  return factorsFit(costs.factor_entries) && spent > worth_changing * (costs.first + solves * costs.with_factors);
}

int FormerFactorAccount::mostIterations(const WarpedFactor::Prices& prices) const {
  if (!(prices.iteration > 0)) return 0;
  const double one = ofOne(prices);
  return int(std::clamp((worth * (of_each + one) - spent - one) / prices.iteration, 0.0, 1e6));
}

void FormerFactorAccount::serialize(Archive& archive) {
  archive.value("by_former_factors", spent);
  archive.value("by_factors_of_each", of_each);
}

std::string EquilibriumChoice::ofFactors(const std::string& type, const std::string& reason) const {
  if (lost_iterations > 0)
    return fmt::format("{} factors, after {} iterations with multigrid left a residual of {:.2g}", type, lost_iterations, left);
  const char* const later = !keeps_factors  ? ""
                            : triesFormer() ? "; they serve later matrices too"
                                            : "; each matrix gets its own, as a former one's did not serve";
  return fmt::format("{} factors: {}{}{}{}", type, reason, is_rough ? ", but diagonal blocks hardly smooth" : "",
                     solves > 0 ? fmt::format(", but {} solves by it took more", solves) : "", later);
}

void EquilibriumChoice::serialize(Archive& archive) {
  account.serialize(archive);
  archive.value("way", way);
  archive.value("patience", patience);
  archive.value("is_close", is_close);
  archive.value("is_rough", is_rough);
  archive.value("lost_iterations", lost_iterations);
  archive.value("left", left);
  archive.value("keeps_factors", keeps_factors);
  archive.value("refusals", refusals);
  archive.value("is_indefinite", is_indefinite);
  archive.value("solves_by_multigrid", solves);
  archive.value("spent_by_multigrid", spent);
  archive.value("strict", is_strict);
  archive.value("strict_failures", strict_failures);
  archive.value("was_definite", was_definite);
  archive.value("pressures", pressures);
  archive.value("lost_with_pressures", lost_with_pressures);
  archive.value("left_with_pressures", left_with_pressures);
  archive.value("multigrid_rate", rate);
}

}  // namespace stroma
