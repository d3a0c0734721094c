// SPDX-License-Identifier: LGPL-2.1-or-later
// What is told of steps with one linear solve where a law needs more.
#include "framework/simulation/simulation.h"
#include "tests/support/scene_fixture.h"
#include "tools/checks/result_doubts.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A block that is held at one end and let go in its weight.
std::string block(const std::string& integrator, double poisson, const std::string& more = "") {
  return fmt::format(
      "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 -9.81\"><{0}/><SparseLDLSolver/><RegularGridTopology n=\"4 3 3\" min=\"0 0 0\" "
      "max=\"0.06 0.04 0.04\"/><MechanicalObject name=\"dofs\"/><DiagonalMass massDensity=\"1000\"/>"
      "<HexahedronHyperelasticityFEMForceField name=\"fem\" materialName=\"NeoHookean\" youngModulus=\"1e4\" poissonRatio=\"{1}\"/>"
      "<BoxROI name=\"b\" box=\"-0.001 -1 -1 0.001 1 1\"/><FixedProjectiveConstraint indices=\"@b.indices\"/>{2}</Node>",
      integrator, poisson, more);
}

std::string doubtsAfter(const std::string& scene, int steps) {
  Simulation simulation = simulationFromText(scene);
  for (int i = 0; i < steps; ++i) EXPECT_FALSE(simulation.step().failed());
  std::string all;
  for (const std::string& sentence : doubtsOf(simulation)) all += sentence + "\n";
  return all;
}

TEST(OneSolve, OfANearlyIncompressibleLawIsDoubted) {
  const std::string sentence = ", and /fem is nearly incompressible";
  for (const char* integrator : {"EulerImplicitSolver", "BDFOdeSolver", "TrapezoidalRuleSolver", "NewmarkImplicitSolver"}) {
    const bool is_twice = integrator[0] == 'T' || integrator[0] == 'N';
    expectContains(doubtsAfter(block(integrator, 0.499), 3), std::string("solves each step ") + (is_twice ? "twice" : "once") + sentence);
    EXPECT_EQ(doubtsAfter(block(integrator, 0.45), 3).find(sentence), std::string::npos) << integrator;
    EXPECT_EQ(doubtsAfter(block(integrator + std::string(" newtonIterations=\"20\""), 0.499), 3).find(sentence), std::string::npos)
        << integrator;
  }
}

/// The way that the sentence speaks of: the tip falls as far with 0.499 as with 0.45 where steps are solved.
TEST(OneSolve, LagsBehind) {
  const auto way = [](const std::string& integrator, double poisson) {
    Simulation simulation = simulationFromText(block(integrator, poisson));
    for (int i = 0; i < 10; ++i) EXPECT_FALSE(simulation.step().failed());
    return simulation.systems()[0]->states()[0]->rest_position[35].z() - simulation.systems()[0]->x[35].z();
  };
  const double solved = way("EulerImplicitSolver newtonIterations=\"20\"", 0.499);
  EXPECT_NEAR(solved, way("EulerImplicitSolver newtonIterations=\"20\"", 0.45), 0.05 * solved);
  EXPECT_LT(way("EulerImplicitSolver", 0.499), 0.8 * solved);
}

/// A step that goes so far that the energy is infinite is not followed by another: the sentence says what helps.
TEST(OneSolve, SaysWhatShortensAStep) {
  Simulation simulation = simulationFromText(block("EulerImplicitSolver", 0.3,
      "<BoxROI name=\"end\" box=\"0.059 -1 -1 1 1 1\"/><ConstantForceField indices=\"@end.indices\" totalForce=\"-300 100 0\"/>"));
  StepReport report;
  for (int i = 0; i < 20 && !report.failed(); ++i) report = simulation.step();
  ASSERT_TRUE(report.diverged);
  expectContains(report.reason, "newtonIterations=\"20\" shortens steps that go too far");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
