// SPDX-License-Identifier: LGPL-2.1-or-later
// Newton's method near incompressibility: a bar that bends under its weight, with one volume change a node or a cell.
#include <algorithm>

#include "framework/algebra/parallel.h"
#include "tests/support/field_under_test.h"
#include "tests/support/newton_history.h"

namespace stroma::test {
namespace {

/// 8 x 2 x 2 cells, held at the left end. `tetrahedra`: each cut into six.
std::string bar(bool tetrahedra, const std::string& attributes, double poisson, double mass = 0.3) {
  const std::string field =
      fmt::format("FEMForceField mstate='@../dofs' youngModulus='60000' poissonRatio='{}' {}/>", poisson, attributes);
  return R"(<Node name="root" dt="1" gravity="0 -9.81 0">
  <StaticSolver newton_iterations="60" relative_residual_tolerance_threshold="1e-7"/><SparseLDLSolver/>
  <RegularGridTopology name="grid" n="9 3 3" min="0 0 0" max="0.2 0.05 0.05"/>
  <MechanicalObject name="dofs"/><UniformMass totalMass=")" +
         std::to_string(mass) + R"("/>
  <BoxROI name="end" box="-0.001 -1 -1 0.001 1 1" position="@dofs.rest_position"/>
  <FixedProjectiveConstraint indices="@end.indices"/><Node name="cells">)" +
         (tetrahedra ? "<TetrahedronSetTopologyContainer name='tets'/><Hexa2TetraTopologicalMapping input='@../grid' "
                       "output='@tets' cutting='six'/><Tetrahedron" +
                           field
                     : "<HexahedronSetTopologyContainer src='@../grid'/><Hexahedron" + field) +
         "</Node></Node>";
}

double lowest(const Simulation& simulation) {
  double value = 0;
  const System& system = *simulation.systems()[0];
  for (Index i = 0; i < system.independentRows(); ++i) value = std::min(value, system.x[i].y());
  return value;
}

/// Once the residual is below the one of the start, where loads are off by all they are, it falls by squares: a tangent
/// that is only nearly right divides it by the same at every iteration, by ten at best here.
void expectSquares(const std::vector<double>& graph, const std::string& what) {
  std::string line;
  for (double r : graph) line += fmt::format(" {:.1e}", r / graph[0]);
  std::printf("%-28s%s\n", what.c_str(), line.c_str());
  ASSERT_LT(graph.back(), 1e-6 * graph[0]) << what;
  const auto last = std::find_if(graph.begin(), graph.end(), [&](double r) { return r < 1e-6 * graph[0]; });
  const auto above = std::find_if(std::reverse_iterator(last), graph.rend(), [&](double r) { return r >= graph[0]; });
  EXPECT_LE(last - above.base() + 1, 4) << what;
  EXPECT_LT(std::min(last[0] / last[-1], last[-1] / last[-2]), 2e-3) << what;
}

/// The lighter the more nearly incompressible: each bends as far as Newton's method goes from rest in one step.
TEST(ElasticNewton, TheMeanDilatationConvergesQuadraticallyUpToTheIncompressibleLimit) {
  for (const bool tetrahedra : {true, false})
    for (const std::string method : {"large", "polar", "svd"})
      for (const auto& [poisson, mass] : {std::pair(0.45, 0.3), std::pair(0.499, 0.1), std::pair(0.49999, 0.02)}) {
        const std::string what = fmt::format("{} {} {}", tetrahedra ? "tetrahedra" : "hexahedra", method, poisson);
        Simulation simulation = simulationFromText(
            bar(tetrahedra, "method='" + method + "' dilatation='mean' tangent='exact'", poisson, mass));
        const StepReport report = simulation.step();
        EXPECT_TRUE(report.newton_converged) << what << ": " << report.reason;
        expectSquares(residuals(simulation), what);
        EXPECT_LT(lowest(simulation), mass > 0.1 ? -0.03 : -0.001) << what << ": nothing large was tested";
      }
}

/// Both tangents lead to one equilibrium, the warped one where it arrives.
TEST(ElasticNewton, TheMeanDilatationHasOneEquilibrium) {
  for (const bool tetrahedra : {true, false}) {
    Simulation exact = simulationFromText(bar(tetrahedra, "method='svd' dilatation='mean' tangent='exact'", 0.45));
    std::string text = bar(tetrahedra, "method='svd' dilatation='mean'", 0.45);
    text.replace(text.find("\"60\""), 4, "\"1000\"");
    Simulation warped = simulationFromText(text);
    ASSERT_TRUE(exact.step().newton_converged);
    const StepReport report = warped.step();
    ASSERT_TRUE(report.newton_converged) << report.reason;
    EXPECT_GT(report.newton_iterations, int(residuals(exact).size()));
    EXPECT_NEAR(lowest(exact), lowest(warped), 1e-6);
  }
}

/// A warped tangent alone does not arrive this near to incompressibility under loads that bend the bar far (it does
/// under lighter ones). From a scene that leaves the tangent open the equilibrium of the exact one is found all the
/// same, the count tells that it was needed, and the next step begins with the exact one: it would fail again.
TEST(ElasticNewton, AStaticSolveThatFailsGoesOnWithTheExactTangent) {
  for (const bool tetrahedra : {true, false}) {
    const double mass = tetrahedra ? 0.15 : 0.05;
    Simulation exact = simulationFromText(bar(tetrahedra, "method='svd' tangent='exact'", 0.49999, mass));
    Simulation open = simulationFromText(bar(tetrahedra, "method='svd'", 0.49999, mass));
    ASSERT_TRUE(exact.step().newton_converged);
    const StepReport report = open.step();
    ASSERT_TRUE(report.newton_converged) << report.reason;
    EXPECT_EQ(report.load_parts, 1);
    EXPECT_NEAR(lowest(exact), lowest(open), 1e-6);
    const Data& count = *findComponent(open.root(), "/StaticSolver")->data().find("exactTangentSteps");
    EXPECT_EQ(count.print(), "1");
    EXPECT_TRUE(open.systems()[0]->forceFields()[0]->traits().exact_tangent);
    const auto unload = [](Simulation& simulation) {
      for (const State* state : simulation.states())
        for (Index i = 0; i < state->size(); ++i) simulation.systems()[0]->x[i] = state->rest_position[std::size_t(i)];
    };
    unload(open), unload(exact);
    const StepReport second = open.step(), named = exact.step();
    ASSERT_TRUE(second.newton_converged) << second.reason;
    EXPECT_LE(second.newton_iterations, named.newton_iterations + 1);
    EXPECT_EQ(count.print(), "1") << "it is told once";
    open.reset();
    EXPECT_EQ(count.print(), "0");
    EXPECT_FALSE(open.systems()[0]->forceFields()[0]->traits().exact_tangent);
    EXPECT_EQ(open.step().newton_iterations, report.newton_iterations) << "a run that starts again is the same";
  }
}

/// Where the approximate tangent gets on by small factors only, the exact one finds the same equilibrium in fewer iterations,
/// if the scene leaves it open and it is symmetric, as that of svd. Where it is not, nothing is lost: the bits are those of
/// the approximate one.
TEST(ElasticNewton, ASlowSolveGoesOnWithTheExactTangentWhereItIsSymmetric) {
  const auto countOf = [](const Simulation& simulation) {
    return findComponent(simulation.root(), "/StaticSolver")->data().find("exactTangentSteps")->print();
  };
  Simulation open = simulationFromText(bar(true, "method='svd'", 0.3, 0.6)),
             warped = simulationFromText(bar(true, "method='svd' tangent='warped'", 0.3, 0.6));
  const StepReport found = open.step(), slow = warped.step();
  ASSERT_TRUE(found.newton_converged && slow.newton_converged) << found.reason << slow.reason;
  EXPECT_GT(slow.newton_iterations, 14) << "the approximate tangent is good enough: nothing was tested";
  EXPECT_LE(found.newton_iterations, slow.newton_iterations * 2 / 3);
  EXPECT_NEAR(lowest(open), lowest(warped), 1e-6);
  EXPECT_LT(lowest(open), -0.03);
  EXPECT_EQ(countOf(open), "1");
  EXPECT_EQ(countOf(warped), "0");
  EXPECT_EQ(residuals(open).size(), std::size_t(found.newton_iterations) + 1);

  Simulation large = simulationFromText(bar(true, "method='large'", 0.3, 0.6)),
             named = simulationFromText(bar(true, "method='large' tangent='warped'", 0.3, 0.6));
  const StepReport same = large.step(), expected = named.step();
  ASSERT_TRUE(same.newton_converged && expected.newton_converged);
  EXPECT_GT(expected.newton_iterations, 14);
  EXPECT_EQ(same.newton_iterations, expected.newton_iterations);
  EXPECT_EQ(large.stateHash(), named.stateHash());
  EXPECT_EQ(countOf(large), "0");
}

/// A step that fails with both is not told as one that the exact tangent has helped.
TEST(ElasticNewton, AStepThatFailsWithBothTangentsIsNotCounted) {
  std::string text = bar(false, "method='svd'", 0.49999, 0.1);
  text.replace(text.find("\"60\""), 4, "\"5\" smallest_part=\"1\"");
  Simulation simulation = simulationFromText(text);
  const StepReport report = simulation.step();
  EXPECT_FALSE(report.newton_converged);
  EXPECT_NE(report.reason.find("with the exact tangent too"), std::string::npos) << report.reason;
  EXPECT_EQ(findComponent(simulation.root(), "/StaticSolver")->data().find("exactTangentSteps")->print(), "0");
  EXPECT_FALSE(simulation.systems()[0]->forceFields()[0]->traits().exact_tangent);
}

/// The same in time: what helped in one step is where the next one begins, whatever the number of threads.
TEST(ElasticNewton, AnImplicitStepThatFailsGoesOnWithTheExactTangent) {
  std::string text = bar(false, "method='svd'", 0.49999, 0.05);
  const std::string statics = text.substr(text.find("<StaticSolver"), text.find("<SparseLDLSolver") - text.find("<StaticSolver"));
  text.replace(text.find(statics), statics.size(), "<EulerImplicitSolver newtonIterations='60' newtonTolerance='1e-7'/>");
  std::vector<std::uint64_t> hashes;
  for (const int count : {1, 2}) {
    setThreads(count);
    Simulation simulation = simulationFromText(text);
    const Data& steps = *findComponent(simulation.root(), "/EulerImplicitSolver")->data().find("exactTangentSteps");
    const StepReport first = simulation.step();
    ASSERT_TRUE(first.newton_converged) << first.reason;
    ASSERT_EQ(steps.print(), "1") << "the approximate tangent arrives: nothing was tested";
    EXPECT_TRUE(simulation.systems()[0]->forceFields()[0]->traits().exact_tangent);
    const StepReport second = simulation.step();
    ASSERT_TRUE(second.newton_converged) << second.reason;
    EXPECT_LT(second.newton_iterations, first.newton_iterations / 2);
    EXPECT_EQ(steps.print(), "1") << "it is told once";
    hashes.push_back(simulation.stateHash());
  }
  setThreads(1);
  EXPECT_EQ(hashes[0], hashes[1]);
}

/// A run that goes on from a checkpoint has the bits of one that never stopped: what tangent helped is in it.
TEST(ElasticNewton, ACheckpointKnowsWhichTangentHelped) {
  const std::string text = bar(false, "method='svd'", 0.49999, 0.05);
  Simulation whole = simulationFromText(text), first = simulationFromText(text), second = simulationFromText(text);
  ASSERT_TRUE(first.step().newton_converged);
  second.restore(first.checkpoint().readable());
  whole.step();
  for (int step = 0; step < 2; ++step) {
    for (Simulation* simulation : {&whole, &second}) {
      Vector& x = simulation->systems()[0]->x;
      x[4] = Vec3(x[4]) * 1.01;
    }
    EXPECT_EQ(whole.step().newton_iterations, second.step().newton_iterations);
    EXPECT_EQ(whole.stateHash(), second.stateHash());
  }
}

/// The rate at which Newton's method converges with tangents that leave out how rotations and gradients change: about the
/// strain, which is 1 to 3 % here.
TEST(ElasticNewton, WarpedTangentsDivideTheResidualByTenAtLeast) {
  for (const bool tetrahedra : {true, false})
    for (const std::string method : {"large", "polar", "svd"})
      for (const std::string more : {"", "updateStiffnessMatrix='true'",
                                     "updateStiffnessMatrix='true' updateVolume='true'", "dilatation='mean'"}) {
        const std::string what = fmt::format("{} {} {}", tetrahedra ? "tetrahedra" : "hexahedra", method, more);
        Simulation simulation = simulationFromText(bar(tetrahedra, "method='" + method + "' " + more, 0.3, 0.04));
        const StepReport report = simulation.step();
        EXPECT_TRUE(report.newton_converged) << what << ": " << report.reason;
        const std::vector<double> graph = residuals(simulation);
        const double rate = graph.back() / graph[graph.size() - 2];
        std::printf("%-75s %2d iterations, rate %.3f, end at %.4f m\n", what.c_str(), report.newton_iterations, rate,
                    lowest(simulation));
        EXPECT_LT(rate, 0.1) << what;
      }
}

}  // namespace
}  // namespace stroma::test
