// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/statistics.h"

#include <sys/resource.h>

#include <algorithm>

namespace stroma::command {

using Json = nlohmann::ordered_json;

Json timing(const RunStatistics& run) {
  return {{"mean", run.meanMs()}, {"median", run.quantileMs(0.5)}, {"p99", run.quantileMs(0.99)}};
}

Json solvers(const RunStatistics& run) {
  const double steps = std::max<double>(1, double(run.step_ms.size()));
  Json stops = Json::object();
  for (const auto& [stop, count] : run.stops) stops[std::string(describe(stop))] = count;
  const auto limit = run.stops.find(SolveStop::iteration_limit);
  Json json;
  json["linear"] = {{"iterations", run.linear_iterations},
                    {"iterations_per_step", double(run.linear_iterations) / steps},
                    {"residual_mean", run.residual_sum / steps},
                    {"residual_worst", run.unconverged.worst_residual},
                    {"iteration_limit_reached", limit == run.stops.end() ? 0 : limit->second},
                    {"stops", stops},
                    {"factorisations", run.factorisations}};
  json["newton"] = {{"iterations", run.newton_iterations},
                    {"residual_worst", run.unconverged.worst_newton_residual},
                    {"steps_not_converged", run.unconverged.newton},
                    {"steps_divided", run.divided_steps},
                    {"most_parts_of_a_step", run.most_load_parts}};
  return json;
}

Json phaseSeconds(const Simulation& simulation) {
  PhaseTimes sum;
  for (const auto& system : simulation.systems()) {
    const PhaseTimes& times = system->times;
    sum.force += times.force;
    sum.product += times.product;
    sum.assembly += times.assembly;
    sum.solve += times.solve;
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
