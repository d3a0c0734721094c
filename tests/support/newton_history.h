// SPDX-License-Identifier: LGPL-2.1-or-later
// The residuals of Newton's method in the last step, and how fast they fall.
#pragma once
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/scene_fixture.h"

namespace stroma::test {

/// |R| before each iteration and after the last one, of the first system.
inline std::vector<double> residuals(const Simulation& simulation) {
  return *std::get<std::vector<double>*>(simulation.systems()[0]->integrator().data().find("residualGraph")->pointer());
}

/// The order log(r3/r2)/log(r2/r1) of the last three residuals above round-off, which is `round_off` of the first here;
/// 2 in the limit, and 1 for a tangent that is only nearly right.
inline void expectQuadratic(const std::vector<double>& graph, const std::string& what, double round_off = 1e-11) {
  std::string line;
  for (double r : graph) line += fmt::format(" {:.1e}", r / graph[0]);
  std::size_t n = graph.size();
  while (n > 3 && graph[n - 1] < round_off * graph[0]) --n;
  ASSERT_GE(n, 3u) << what << line;
  const double order = std::log(graph[n - 1] / graph[n - 2]) / std::log(graph[n - 2] / graph[n - 3]);
  std::printf("%-40s%s: order %.2f\n", what.c_str(), line.c_str(), order);
  EXPECT_GT(order, 1.4) << what;
}

}  // namespace stroma::test
