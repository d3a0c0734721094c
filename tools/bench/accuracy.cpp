// SPDX-License-Identifier: LGPL-2.1-or-later
// Error against run time. A cantilever is bent to a third of its length by a force at its end and brought to rest by
// Newton's method with a sparse factorisation. The reference is the deflection of method polar extrapolated from its
// two finest meshes, of spacing h and h/2, with the second order of linear elements:  w = w(h/2) + (w(h/2) - w(h)) / 3;
// its uncertainty is taken as the difference to the same extrapolation one pair of meshes earlier.
#include "tools/bench/accuracy.h"

#include <fmt/format.h>
#include <time.h>

#include <cmath>
#include <fstream>
#include <vector>

#include "framework/algebra/parallel.h"
#include "tools/bench/body.h"

namespace stroma::bench {
namespace {

constexpr int repetitions = 3;

struct Method {
  std::string name;
  std::vector<std::string> overrides;
};

struct Outcome {
  double deflection = 0;    ///< mean of the end's nodes, downwards [m]
  double milliseconds = 0;  ///< least processor time of a solution from the rest shape
  int newton_iterations = 0;
  Index nodes = 0;
  std::string trouble;  ///< why it did not converge
};

double threadMilliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * double(now.tv_sec) + 1e-6 * double(now.tv_nsec);
}

double endDeflection(const State& state) {
  double end = 0, sum = 0;
  int count = 0;
  for (const Vec3& p : state.rest_position) end = std::max(end, p.x());
  for (Index i = 0; i < state.size(); ++i)
    if (state.rest_position[std::size_t(i)].x() > end * (1 - 1e-6))
      sum += state.rest_position[std::size_t(i)].y() - state.x()[i].y(), ++count;
  return sum / count;
}

/// `cells`: elements across the height.
Outcome solve(const Method& method, int cells) {
  std::vector<std::string> overrides = method.overrides;
  overrides.push_back(fmt::format("/beam/grid.n={} {} {}", 10 * cells + 1, cells + 1, cells + 1));
  const auto simulation = loadSimulation("benchmarks/cantilever.xml", overrides);
  Outcome outcome;
  outcome.milliseconds = INFINITY;
  for (int r = 0; r < repetitions; ++r) {
    simulation->reset();
    const double start = threadMilliseconds();
    const StepReport report = simulation->step();
    outcome.milliseconds = std::min(outcome.milliseconds, threadMilliseconds() - start);
    outcome.newton_iterations = report.newton_iterations;
    if (report.diverged || !report.newton_converged) outcome.trouble = report.reason;
    if (!outcome.trouble.empty() || outcome.milliseconds > 2000) break;
  }
  const State& state = *simulation->states().at(0);
  outcome.deflection = endDeflection(state);
  outcome.nodes = state.size();
  return outcome;
}

double extrapolated(double coarse, double fine) { return fine + (fine - coarse) / 3; }

}  // namespace

void compareAccuracy(const std::string& csv_file) {
  setThreads(1);
  const std::string field = "/beam/cells/fem.";
  const auto method = [&](const char* name, std::vector<std::string> settings, const char* cutting) {
    for (std::string& setting : settings) setting = field + setting;
    settings.push_back(std::string("/beam/cells/cut.cutting=") + cutting);
    return Method{name, settings};
  };
  const std::vector<Method> methods{
      method("small", {"method=small"}, "five"),
      method("large", {"method=large"}, "five"),
      method("large, B", {"method=large", "updateStiffnessMatrix=true"}, "five"),
      method("polar", {"method=polar", "tangent=exact"}, "five"),
      method("polar, B", {"method=polar", "updateStiffnessMatrix=true"}, "five"),
      method("svd", {"method=svd", "tangent=exact"}, "five"),
      method("polar, ten tetrahedra a cell", {"method=polar", "tangent=exact"}, "ten"),
      method("polar, six tetrahedra a cell", {"method=polar", "tangent=exact"}, "six"),
  };
  const Method& exact = methods[3];
  const double w2 = solve(exact, 2).deflection, w4 = solve(exact, 4).deflection, w8 = solve(exact, 8).deflection;
  const double reference = extrapolated(w4, w8), uncertainty = std::abs(reference - extrapolated(w2, w4)) / reference;
  fmt::print("reference deflection {:.5g} m, uncertain by about {:.1g} %\n\n", reference, 100 * uncertainty);
  fmt::print("{:<30} {:>6} {:>8} {:>12} {:>10} {:>8} {:>8}\n", "method", "cells", "nodes", "deflection", "error %",
             "ms", "Newton");
  std::string csv = "method,cells_across,nodes,deflection_m,relative_error,milliseconds,newton_iterations,converged\n";
  for (const Method& m : methods)
    for (int cells : {1, 2, 3, 4, 6}) {
      const Outcome outcome = solve(m, cells);
      const double error = outcome.deflection / reference - 1;
      fmt::print("{:<30} {:>6} {:>8} {:>12.5g} {:>10.2f} {:>8.3g} {:>8} {}\n", m.name, cells, outcome.nodes,
                 outcome.deflection, 100 * error, outcome.milliseconds, outcome.newton_iterations, outcome.trouble);
      std::fflush(stdout);
      csv += fmt::format("\"{}\",{},{},{:.8g},{:.6g},{:.5g},{},{}\n", m.name, cells, outcome.nodes, outcome.deflection,
                         error, outcome.milliseconds, outcome.newton_iterations, outcome.trouble.empty() ? 1 : 0);
    }
  if (csv_file.empty()) return;
  std::ofstream stream(csv_file);
  stream << csv;
  if (!stream.flush()) throw std::runtime_error(fmt::format("cannot write {}", csv_file));
}

}  // namespace stroma::bench
