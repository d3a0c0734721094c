// SPDX-License-Identifier: LGPL-2.1-or-later
// A bar of length L, held at one end, waves of speed c. Its first mode is sin(k x), k = pi / 2L, for the continuous bar and for
// one cut into linear cells of length h, whose frequencies are
//
//   continuous: w = c k     consistent mass: w^2 = 6 (c/h)^2 (1 - cos kh) / (2 + cos kh)     lumped: w^2 = 2 (c/h)^2 (1 - cos kh)
//
// so that the error of an integrator is separated from that of the mesh (Hughes, The Finite Element Method, 1987, section
// 7.1). From x = X with v = a w sin(k X):  u_end(t) = a sin(w t).  With u and v of the end, phase = atan2(w u, v) and the
// energy is as w^2 u^2 + v^2.
#include "tools/bench/vibration.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tools/bench/accuracy.h"
#include "tools/bench/body.h"

namespace stroma::bench {
namespace {

constexpr double length = 1, speed = 10, amplitude = 1e-3;  // of scenes/benchmarks/vibrating_bar.xml
constexpr int cells = 20, periods = 5;
constexpr double wave = std::numbers::pi / 2 / length, period = 2 * std::numbers::pi / (speed * wave);

struct Rule {
  const char *name, *component;
  bool is_lumped = false;
};
constexpr Rule rules[] = {
    {"implicit Euler", "<EulerImplicitSolver name=\"solver\"/>"},
    {"BDF, order 2", "<BDFOdeSolver name=\"solver\" order=\"2\"/>"},
    {"trapezoid", "<EulerImplicitSolver name=\"solver\" trapezoidalScheme=\"true\"/>"},
    {"Newmark", "<NewmarkImplicitSolver name=\"solver\"/>"},
    {"midpoint", "<VariationalSymplecticSolver name=\"solver\"/>"},
    {"symplectic Euler", "<EulerExplicitSolver name=\"solver\" symplectic=\"true\"/>", true},
    {"central differences", "<CentralDifferenceSolver name=\"solver\"/>", true},
    {"Runge-Kutta 4", "<RungeKutta4Solver name=\"solver\"/>", true},
};
constexpr int steps_a_period[] = {20, 40, 80, 160, 320};

struct End {
  int steps = 0;  ///< a period
  double phase = 0, energy = 0;  ///< errors: radians; a share
  double milliseconds = 0;
  std::string trouble;
};

double frequency(bool is_lumped) {
  const double h = length / cells, cosine = std::cos(wave * h), share = is_lumped ? 2 : 6 / (2 + cosine);
  return speed / h * std::sqrt(share * (1 - cosine));
}

End vibrate(const Rule& rule, int steps) {
  std::vector<std::pair<std::string, std::string>> parts{{rules[0].component, rule.component}};
  if (rule.is_lumped) parts.push_back({"<MeshMatrixMass name=\"mass\"", "<DiagonalMass name=\"mass\""});
  const auto simulation = loadSimulation("benchmarks/vibrating_bar.xml",
                                         {fmt::format("dt={}", period / steps), "weight.totalForce=0 0 0"}, parts);
  System& system = *simulation->systems().at(0);
  const State& state = *simulation->states().at(0);
  const double w = frequency(rule.is_lumped);
  Index end = 0;
  for (Index i = 0; i < state.size(); ++i) {
    const double x = state.rest_position[std::size_t(i)].x();
    system.v[state.firstRow() + i] = Vec3(amplitude * w * std::sin(wave * x), 0, 0);
    if (x > length - 1e-9) end = i;
  }
  End result;
  result.steps = steps;
  const double start = threadMilliseconds();
  for (int step = 0; step < periods * steps && result.trouble.empty(); ++step)
    if (const StepReport report = simulation->step(); report.diverged) result.trouble = report.reason;
  result.milliseconds = threadMilliseconds() - start;
  const double u = w * (state.x()[end].x() - state.rest_position[std::size_t(end)].x()), v = state.v()[end].x();
  result.phase = std::remainder(std::atan2(u, v) - w * periods * period, 2 * std::numbers::pi);
  result.energy = (u * u + v * v) / (amplitude * w * amplitude * w) - 1;
  if (result.trouble.empty() && !(result.energy < 1)) result.trouble = "unstable";
  return result;
}

void conclude(const Rule& rule, const std::vector<End>& ends) {
  const End *coarse = nullptr, *fine = nullptr;
  for (const End& end : ends)
    if (end.trouble.empty()) coarse = fine, fine = &end;
  if (!fine) return fmt::print("- {}: unstable.\n", rule.name);
  fmt::print("- {}: ", rule.name);
  if (coarse && 2 * coarse->steps == fine->steps)
    fmt::print("half the step divides the error of the phase by {:.2g}; ", coarse->phase / fine->phase);
  fmt::print("with {} steps a period {:.3g} % of the energy {}.\n", fine->steps, 100 * std::abs(fine->energy),
             fine->energy < 0 ? "is gone" : "has come in");
}

}  // namespace

std::vector<int> vibrationSizes() { return {std::begin(steps_a_period), std::end(steps_a_period)}; }

void compareVibration(const std::vector<int>& sizes, std::string& csv) {
  const auto shift = [](bool is_lumped) { return 360 * periods * (frequency(is_lumped) / speed / wave - 1); };
  fmt::print("\nvibration, the end of a bar after {} periods\nreference: closed form of the bar cut into {} cells (the mesh "
             "alone shifts the phase by {:.2g} and {:.2g} degrees, consistent and lumped)\n\n",
             periods, cells, shift(false), shift(true));
  fmt::print("{:<22} {:>12} {:>12} {:>12} {:>8}\n", "integrator", "steps/period", "phase, deg", "energy, %", "ms");
  std::vector<std::vector<End>> all;
  for (const Rule& rule : rules) {
    all.emplace_back();
    for (const int steps : steps_a_period) {
      if (!isAsked(sizes, steps)) continue;
      all.back().push_back(vibrate(rule, steps));
      const End& end = all.back().back();
      const double degrees = 180 / std::numbers::pi * end.phase;
      if (end.trouble.empty())
        fmt::print("{:<22} {:>12} {:>12.3f} {:>12.4f} {:>8.3g}\n", rule.name, steps, degrees, 100 * end.energy,
                   end.milliseconds);
      else
        fmt::print("{:<22} {:>12} {:>12} {:>12}\n", rule.name, steps, "-", "unstable");
      std::fflush(stdout);
      csv += fmt::format("vibration: phase in degrees,\"{}\",{},,{:.6g},0,{:.6g},{:.5g},,{}\n", rule.name, steps, degrees,
                         degrees / 360 / periods, end.milliseconds, end.trouble.empty() ? 1 : 0);
    }
  }
  fmt::print("\n");
  for (std::size_t r = 0; r < all.size(); ++r) conclude(rules[r], all[r]);
}

}  // namespace stroma::bench
