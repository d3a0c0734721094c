// SPDX-License-Identifier: LGPL-2.1-or-later
// Error against run time. A cantilever is bent to a third of its length by a force at its end and brought to rest by
// Newton's method with a sparse factorisation. The reference is the deflection of method polar extrapolated from meshes
// of spacing 2h and h with the second order of linear elements,  w = w(h) + (w(h) - w(2h)) / 3;  its uncertainty is
// taken as the difference to the same extrapolation from coarser meshes. The elastica (P L^2 / EI = 1: w = 0.30172 L,
// no shear, no thickness) is printed beside it as an independent number.
#include "tools/bench/accuracy.h"

#include <fmt/format.h>
#include <time.h>

#include <cmath>
#include <vector>

#include "framework/algebra/parallel.h"
#include "framework/scene/output_file.h"
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
    if (state.rest_position[i].x() > end * (1 - 1e-6)) sum += state.rest_position[i].y() - state.x()[i].y(), ++count;
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
      method("small", {"method=small", "tangent=warped"}, "five"),
      method("large", {"method=large", "tangent=warped"}, "five"),
      method("large, exact tangent (L U)", {"method=large"}, "five"),
      method("large, B", {"method=large", "tangent=warped", "updateStiffnessMatrix=true"}, "five"),
      method("svd", {"method=svd"}, "five"),
      method("svd, warped tangent", {"method=svd", "tangent=warped"}, "five"),
      method("polar", {"method=polar", "tangent=warped"}, "five"),
      method("polar, B", {"method=polar", "tangent=warped", "updateStiffnessMatrix=true"}, "five"),
      method("svd, ten tetrahedra per cell", {"method=svd"}, "ten"),
      method("svd, six tetrahedra per cell", {"method=svd"}, "six"),
  };
  const auto deflection = [&](int cells) { return solve(methods[4], cells).deflection; };
  const double earlier = extrapolated(deflection(4), deflection(8));
  const double reference = extrapolated(deflection(5), deflection(10));
  fmt::print("reference deflection {:.5g} m ({:.2g} % from that of coarser meshes); elastica {:.5g} m\n\n", reference,
             100 * std::abs(reference - earlier) / reference, 0.30172 * 0.2);
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
  if (!csv_file.empty()) writeWholeFile(csv_file, csv);
}

}  // namespace stroma::bench
