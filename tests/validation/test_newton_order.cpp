// SPDX-License-Identifier: LGPL-2.1-or-later
// Newton's method with the exact tangent falls quadratically once it is near: e_{k+1} <= C e_k^2. With the warped
// tangent R K R^T each iteration gains a factor.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/validation/scene_run.h"

namespace stroma::test {
namespace {

/// |R| of the iterations over the first one, on the organ under weight and pull.
std::vector<double> history(const std::string& method, const std::string& update, const std::string& tangent) {
  std::vector<Override> overrides;
  const auto set = [&](const std::string& text) { overrides.push_back(Override::parse("/organ/" + text)); };
  set("fem.method=" + method);
  set("fem.tangent=" + tangent);
  set("solver.newton_iterations=60");
  set("solver.relative_residual_tolerance_threshold=1e-11");
  if (update != "none") set("fem.updateStiffnessMatrix=true");
  Simulation simulation(
      loadScene(STROMA_SOURCE_DIR "/scenes/examples/organ_static.xml", overrides, factory(), modules()));
  simulation.dropObservers();
  const StepReport report = simulation.step();
  EXPECT_FALSE(report.diverged) << report.reason;
  std::vector<double> out = reals(*findComponent(simulation.root(), "/organ/solver"), "residualGraph");
  const double first = out.at(0);
  std::string text = fmt::format("{:5} {:4} {:6}:", method, update, tangent);
  for (double& residual : out) text += fmt::format(" {:.1e}", residual /= first);
  fmt::print("{}\n", text);
  return out;
}

/// The largest e_{k+1} / e_k^2 once e is below 0.03, round-off left out: bounded where the convergence is quadratic.
double quadraticConstant(const std::vector<double>& e) {
  double largest = 0;
  for (std::size_t k = 1; k + 1 < e.size(); ++k)
    if (e[k] < 0.03 && e[k + 1] > 1e-12) largest = std::max(largest, e[k + 1] / (e[k] * e[k]));
  return largest;
}
int iterationsTo(const std::vector<double>& e, double tolerance) {
  for (std::size_t k = 0; k < e.size(); ++k)
    if (e[k] <= tolerance) return int(k);
  return 1000;
}

TEST(Newton, ExactTangentConvergesQuadraticallyAndWarpedDoesNot) {
  for (const std::string method : {"large", "polar", "svd"})
    for (const std::string update : {"none", "B"}) {
      const std::vector<double> exact = history(method, update, "exact"), warped = history(method, update, "warped");
      EXPECT_LE(exact.back(), 1e-11) << method << " " << update;
      EXPECT_GT(exact[exact.size() - 3], 1e-9) << "too few iterations near the solution to judge";
      EXPECT_LT(quadraticConstant(exact), 50) << method << " " << update;
      EXPECT_GT(quadraticConstant(warped), 1e5) << method << " " << update;
      EXPECT_GE(iterationsTo(warped, 1e-9), iterationsTo(exact, 1e-9) + 3) << method << " " << update;
    }
}

}  // namespace
}  // namespace stroma::test
