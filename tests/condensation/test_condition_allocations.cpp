// SPDX-License-Identifier: LGPL-2.1-or-later
// A step of a condensed body with contacts allocates no more than one without, as long as the number of conditions stays: all memory
// of the program is counted.
#include "tests/condensation/bodies.h"
#include "tests/support/counted_allocations.h"

#if defined(STROMA_COUNTS_ALLOCATIONS)
namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Of four steps, after ten.
long allocationsOf(const std::string& solver, const std::string& loads) {
  const Block block{.solver = solver, .loads = loads, .gravity = "0 0 0", .dt = 1};
  Simulation simulation = simulationFromText(block.text());
  for (int i = 0; i < 10; ++i) simulation.step();
  const long before = allocations;
  for (int i = 0; i < 4; ++i) {
    const StepReport report = simulation.step();
    EXPECT_TRUE(report.constraints_converged) << report.constraint_reason;
  }
  return allocations - before;
}

/// What is near comes and goes, and with it the rows that have forces: matrices of another size, a few times per step.
TEST(CondensedConditions, AllocateLittleInASteadyStep) {
  const std::string sphere =
      "<ConstraintContact spheres=\"0.105 0.033 0.09 0.024\" keyTimes=\"0 5 20\" movements=\"0 0 0  -0.005 0 0  -0.005 0.0001 "
      "0.0001\" contactDistance=\"1e-4\" friction=\"0.4\"/>";
  const std::string dragged =
      "<LinearMovementProjectiveConstraint indices=\"136\" keyTimes=\"0 20\" movements=\"0 0 0  0.002 0.001 -0.001\"/>";
  for (const std::string solver : {"<CondensedStaticSolver/>", "<CondensedDynamicSolver/>"})
    for (const std::string& more : {std::string(), dragged}) {
      SCOPED_TRACE(solver + more);
      EXPECT_LT(allocationsOf(solver, more + sphere), 4 * 60);
      EXPECT_EQ(allocationsOf(solver, more), 0);
    }
  EXPECT_GT(allocations, 0) << "the counter counts";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
#endif
