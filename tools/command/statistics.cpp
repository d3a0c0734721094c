// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/statistics.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <numeric>

namespace stroma::command {

using Json = nlohmann::ordered_json;

Energies energiesOf(const Simulation& simulation) {
  simulation.complete();
  Energies energies;
  for (const auto& system : simulation.systems()) {
    energies.kinetic += system->kineticEnergy();
    energies.elastic += system->elasticEnergy(system->x);
    energies.gravity += system->gravityEnergy(system->x);
  }
  return energies;
}

Statistics::Statistics(long expected_steps) { step_ms_.reserve(std::min(expected_steps, 1000000L)); }

void Statistics::add(const StepReport& report, double step_seconds) {
  step_ms_.push_back(1e3 * step_seconds);
  ++stops_[report.linear_stop];
  linear_iterations_ += report.linear_iterations;
  newton_iterations_ += report.newton_iterations;
  factorisations_ += report.factorisations;
  linear_unconverged_ += report.linear_converged ? 0 : 1;
  newton_unconverged_ += report.newton_converged ? 0 : 1;
  constraints_unconverged_ += report.constraints_converged ? 0 : 1;
  if (!report.constraints_converged && constraint_reason_.empty()) constraint_reason_ = report.constraint_reason;
  residual_sum_ += report.linear_residual;
  residual_worst_ = std::max(residual_worst_, report.linear_residual);
  newton_residual_worst_ = std::max(newton_residual_worst_, report.newton_residual);
}

std::vector<std::string> Statistics::warnings() const {
  std::vector<std::string> warnings;
  if (linear_unconverged_ > 0)
    warnings.push_back(fmt::format(
        "the linear solver stopped before its tolerance in {} of {} steps (worst relative residual {:.2g}): raise its "
        "iterations or its tolerance",
        linear_unconverged_, step_ms_.size(), residual_worst_));
  if (newton_unconverged_ > 0)
    warnings.push_back(
        fmt::format("Newton's method did not converge in {} of {} steps (worst relative residual {:.2g})",
                    newton_unconverged_, step_ms_.size(), newton_residual_worst_));
  if (constraints_unconverged_ > 0)
    warnings.push_back(fmt::format("position constraints did not hold in {} of {} steps; the first time: {}",
                                   constraints_unconverged_, step_ms_.size(), constraint_reason_));
  return warnings;
}

double Statistics::meanMs() const {
  if (step_ms_.empty()) return 0;
  return std::accumulate(step_ms_.begin(), step_ms_.end(), 0.0) / double(step_ms_.size());
}

double Statistics::quantileMs(double q) const {
  if (step_ms_.empty()) return 0;
  std::vector<double> sorted = step_ms_;
  const auto rank =
      sorted.begin() + std::ptrdiff_t(std::min(sorted.size() - 1, std::size_t(q * double(sorted.size()))));
  std::nth_element(sorted.begin(), rank, sorted.end());
  return *rank;
}

Json Statistics::timing() const { return {{"mean", meanMs()}, {"median", quantileMs(0.5)}, {"p99", quantileMs(0.99)}}; }

Json Statistics::solvers() const {
  const double steps = std::max<double>(1, double(step_ms_.size()));
  Json stops = Json::object();
  for (const auto& [stop, count] : stops_) stops[std::string(describe(stop))] = count;
  const auto limit = stops_.find(SolveStop::iteration_limit);
  Json json;
  json["linear"] = {{"iterations", linear_iterations_},
                    {"iterations_per_step", double(linear_iterations_) / steps},
                    {"residual_mean", residual_sum_ / steps},
                    {"residual_worst", residual_worst_},
                    {"iteration_limit_reached", limit == stops_.end() ? 0 : limit->second},
                    {"stops", stops},
                    {"factorisations", factorisations_}};
  json["newton"] = {{"iterations", newton_iterations_},
                    {"residual_worst", newton_residual_worst_},
                    {"steps_not_converged", newton_unconverged_}};
  return json;
}

Json phaseSeconds(const Simulation& simulation) {
  PhaseTimes sum;
  for (const auto& system : simulation.systems()) {
    const PhaseTimes& times = system->times;
    sum.force += times.force, sum.product += times.product, sum.assembly += times.assembly, sum.solve += times.solve;
    sum.observers += times.observers, sum.total += times.total;
  }
  // products and assembly happen inside the solve: what is reported as solve is the solver's own work
  const double solve = std::max(0.0, sum.solve - sum.product - sum.assembly);
  const double other = std::max(0.0, sum.total - sum.force - sum.product - sum.assembly - solve);
  return {{"force", sum.force}, {"product", sum.product},     {"assembly", sum.assembly},
          {"solve", solve},     {"observers", sum.observers}, {"other", other}};
}

long peakMemory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss * 1024;
}

}  // namespace stroma::command
