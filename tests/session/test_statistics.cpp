// SPDX-License-Identifier: LGPL-2.1-or-later
// What a run says of the linear solves that its steps relied on.
#include "tools/session/statistics.h"

#include <gtest/gtest.h>

namespace stroma::test {
namespace STROMA_TEST_FILE {

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

StepReport step(SolveStop stop, double residual) {
  StepReport report;
  report.linear_stop = stop;
  report.linear_converged = stop == SolveStop::converged;
  report.linear_at_limit = stop == SolveStop::iteration_limit || stop == SolveStop::stagnated;
  report.linear_residual = residual;
  return report;
}

TEST(UnconvergedSteps, AdviseMoreIterationsWhereThereWereTooFew) {
  UnconvergedSteps steps;
  steps.add(step(SolveStop::converged, 1e-3));
  steps.add(step(SolveStop::iteration_limit, 1e-5));
  const auto warnings = steps.warnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(has(warnings[0], "in 1 of 2 steps (worst relative residual 1e-05): raise its iterations")) << warnings[0];
}

TEST(UnconvergedSteps, AdviseNoIterationsWhereRoundOffIsToBlame) {
  UnconvergedSteps steps;
  steps.add(step(SolveStop::stagnated, 2e-4));
  const auto warnings = steps.warnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_FALSE(has(warnings[0], "iterations")) << warnings[0];
  EXPECT_TRUE(has(warnings[0], "in 1 of 1 steps (worst relative residual 0.0002): round-off limits the accuracy")) << warnings[0];
}

/// A factorisation has no iterations, and its residual of round-off is none to warn of.
TEST(UnconvergedSteps, AdviseNoIterationsWhereTheMatrixIsToBlame) {
  for (const SolveStop stop : {SolveStop::not_definite, SolveStop::breakdown}) {
    UnconvergedSteps steps;
    steps.add(step(stop, 1.1e-14));
    const auto warnings = steps.warnings();
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_FALSE(has(warnings[0], "iterations")) << warnings[0];
    EXPECT_FALSE(has(warnings[0], "e-14")) << warnings[0];
    EXPECT_TRUE(has(warnings[0], "singular or not positive definite in 1 of 1 steps")) << warnings[0];
    EXPECT_FALSE(steps.none());
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
