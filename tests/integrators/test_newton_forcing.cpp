// SPDX-License-Identifier: LGPL-2.1-or-later
// Implicit steps by Newton's method whose scene names no linear solver: early solves are loose, and what a step finds is not.
#include <fmt/format.h>

#include <utility>
#include <vector>

#include "framework/simulation/integrator.h"
#include "framework/simulation/system.h"
#include "tests/integrators/bent_bar.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string bar(const std::string& integrator, const std::string& solver, const std::string& method = "svd") {
  return bentBar(0.02, 4, R"(newtonIterations="30" )" + integrator, solver, R"(poissonRatio="0.4" method=")" + method + "\"");
}

struct Effort {
  int newton = 0, linear = 0;
};
Effort run(Simulation& simulation, int steps) {
  Effort sum;
  for (int step = 0; step < steps; ++step) {
    const StepReport report = simulation.step();
    EXPECT_TRUE(report.newton_converged && report.linear_converged) << report.reason;
    sum.newton += report.newton_iterations, sum.linear += report.linear_iterations;
  }
  return sum;
}

TEST(NewtonForcing, LooseSolvesFindWhatExactOnesDoWithFewerProducts) {
  const std::string tolerance = "newtonTolerance='1e-7'", exact_solver = "<PCGLinearSolver tolerance='1e-12'/>";
  Simulation open = simulationFromText(bar(tolerance, "")), exact = simulationFromText(bar(tolerance, exact_solver));
  constexpr int steps = 15;
  const Effort loose = run(open, steps), tight = run(exact, steps);
  const Vector &x = open.systems()[0]->x, &y = exact.systems()[0]->x;
  double moved = 0;
  for (const State* state : open.states())
    for (Index i = 0; i < state->size(); ++i) moved = std::max(moved, (x[i] - state->rest_position[std::size_t(i)]).norm());
  EXPECT_GT(moved, 0.05) << "it hardly moves";
  for (Index i = 0; i < x.count(); ++i) EXPECT_LT((x[i] - y[i]).norm(), 1e-5 * moved) << "node " << i;
  EXPECT_LT(loose.linear, tight.linear / 2);
  EXPECT_LE(loose.newton, tight.newton * 2);
  expectContains(open.systems()[0]->integrator().describe(), "early linear solves to 0.1");
}

/// A solver that the scene names keeps its tolerance, and so do forces for which one solve is the solution.
TEST(NewtonForcing, IsOfScenesThatLeaveTheSolverOpenAndAreNotLinear) {
  const auto hashOf = [](const std::string& text) {
    Simulation simulation = simulationFromText(text);
    run(simulation, 3);
    return simulation.stateHash();
  };
  const std::uint64_t named = hashOf(bar("", "<PCGLinearSolver/>"));
  EXPECT_EQ(hashOf(bar("newtonForcing='0'", "")), named);
  EXPECT_NE(hashOf(bar("", "")), named);
  EXPECT_EQ(hashOf(bar("newtonForcing='0.1'", "<PCGLinearSolver/>")), hashOf(bar("", "")));
  EXPECT_EQ(hashOf(bar("", "", "small")), hashOf(bar("newtonForcing='0'", "", "small")));
}

/// A thin plate that is pressed in its plane until it would buckle: the round-off of a solve decides there whether it stays flat. What
/// the solver of a scene that names none takes is near what factors of each matrix take.
TEST(NewtonForcing, FormerFactorsCostAPressedPlateLittle) {
  struct Counts {
    int newton = 0, factorisations = 0;
  };
  const auto press = [](const std::string& solver, double poisson, double by) {
    Simulation simulation = simulationFromText(fmt::format(R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver/>{}<Node name="plate">
      <RegularGridTopology n="25 21 4" min="0 0 0" max="0.24 0.2 0.008"/><MechanicalObject/><UniformMass totalMass="1"/>
      <HexahedronHyperelasticityFEMForceField materialName="NeoHookean" youngModulus="1e4" poissonRatio="{}"/>
      <BoxROI name="low" box="-1 -1 -1 0.0001 1 1"/><BoxROI name="high" box="0.2399 -1 -1 1 1 1"/>
      <FixedProjectiveConstraint indices="@low.indices"/>
      <LinearMovementProjectiveConstraint indices="@high.indices" keyTimes="0 1 9" movements="0 0 0  {} 0 0  {} 0 0"/>
      </Node></Node>)", solver, poisson, -by, -by));
    const StepReport report = simulation.step();
    EXPECT_TRUE(report.newton_converged) << report.reason;
    return Counts{report.newton_iterations, report.factorisations};
  };
  for (const auto& [poisson, by] : std::vector<std::pair<double, double>>{{0.49, 0.004}, {0.499, 0.002}, {0.499, 0.01}}) {
    const Counts open = press("", poisson, by), named = press("<SparseLDLSolver/>", poisson, by);
    EXPECT_LE(open.newton, named.newton + 1) << poisson << " " << by;
    EXPECT_LE(open.factorisations, named.factorisations + 1) << poisson << " " << by;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
