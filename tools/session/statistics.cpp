// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace stroma {

Energies energiesOf(const Simulation& simulation) {
  simulation.complete();
  return energiesOf(simulation.systems());
}

void RunStatistics::add(const StepReport& report, double step_seconds) {
  step_ms.push_back(1e3 * step_seconds);
  ++stops[report.linear_stop];
  linear_iterations += report.linear_iterations;
  newton_iterations += report.newton_iterations;
  divided_steps += report.load_parts > 1;
  most_load_parts = std::max(most_load_parts, report.load_parts);
  factorisations += report.factorisations;
  residual_sum += report.linear_residual;
  unconverged.add(report);
}

void UnconvergedSteps::add(const StepReport& report) {
  ++steps;
  const bool is_at_limit = !report.linear_converged && report.linear_at_limit;
  linear += report.linear_converged ? 0 : 1;
  linear_at_limit += is_at_limit;
  linear_at_round_off += is_at_limit && report.linear_stop == SolveStop::stagnated;
  newton += report.newton_converged ? 0 : 1;
  constraints += report.constraints_converged ? 0 : 1;
  kept += report.constraints_converged && !report.constraint_reason.empty();
  if (constraint_reason.empty()) constraint_reason = report.constraint_reason;
  if (report.unsolved && report.newton_converged && without_result++ == 0) without_result_reason = report.reason;
  if (is_at_limit) worst_residual = std::max(worst_residual, report.linear_residual);
  worst_newton_residual = std::max(worst_newton_residual, report.newton_residual);
}

void UnconvergedSteps::serialize(Archive& archive) {
  archive.value("steps", steps);
  archive.value("linear", linear);
  archive.value("linear_at_limit", linear_at_limit);
  archive.value("linear_at_round_off", linear_at_round_off);
  archive.value("newton", newton);
  archive.value("constraints", constraints);
  archive.value("kept", kept);
  archive.value("without_result", without_result);
  archive.value("without_result_reason", without_result_reason);
  archive.value("constraint_reason", constraint_reason);
  archive.value("worst_residual", worst_residual);
  archive.value("worst_newton_residual", worst_newton_residual);
}

std::vector<std::string> UnconvergedSteps::warnings() const {
  std::vector<std::string> warnings;
  if (linear_at_limit > 0)
    warnings.push_back(fmt::format(
        "the linear solver stopped before its tolerance in {} of {} steps (worst relative residual {:.2g}): {}",
        linear_at_limit, steps, worst_residual,
        linear_at_round_off > 0 ? "round-off limits the accuracy if stiffnesses differ by orders of magnitude or a body is hardly supported"
                                : "raise its iterations or its tolerance; if the `threshold` of a CGLinearSolver in SOFA's dialect "
                                  "ended it, lower that"));
  if (linear > linear_at_limit)
    warnings.push_back(fmt::format(
        "the matrix of the linear solves was singular or not positive definite in {} of {} steps: these continued along an earlier "
        "direction, or with a larger diagonal",
        linear - linear_at_limit, steps));
  if (newton > 0)
    warnings.push_back(
        fmt::format("Newton's method did not converge in {} of {} steps (worst relative residual {:.2g})", newton,
                    steps, worst_newton_residual));
  if (without_result > 0)
    warnings.push_back(
        fmt::format("{} of {} steps have no result; the first time: {}", without_result, steps, without_result_reason));
  if (kept > 0)
    warnings.push_back(fmt::format("forces of contacts or constraints did not converge in {} of {} steps, which were kept; the first "
                                   "time: {}",
                                   kept, steps, constraint_reason));
  if (constraints > 0)
    warnings.push_back(fmt::format("position constraints or contacts were violated in {} of {} steps; the first time: {}",
                                   constraints, steps, constraint_reason));
  return warnings;
}

double RunStatistics::meanMs() const {
  if (step_ms.empty()) return 0;
  return std::accumulate(step_ms.begin(), step_ms.end(), 0.0) / double(step_ms.size());
}

double RunStatistics::quantileMs(double q) const {
  if (step_ms.empty()) return 0;
  std::vector<double> sorted = step_ms;
  const auto rank =
      sorted.begin() + std::ptrdiff_t(std::min(sorted.size() - 1, std::size_t(q * double(sorted.size()))));
  std::nth_element(sorted.begin(), rank, sorted.end());
  return *rank;
}

}  // namespace stroma
