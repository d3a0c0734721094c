// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces of Lagrangian constraints by sweeps that end at a tolerance: what they leave is told.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "components/integrators/constraint_sweeps.h"
#include "framework/simulation/integrator.h"
#include "tests/support/scene_fixture.h"

using namespace stroma;
using namespace stroma::test;

namespace {

/// Bars in a row, each tied to the next, that swing down from their first end. `more`: another component of the node.
std::string chain(const std::string& sweeps, int bars = 10, const std::string& more = "") {
  std::string positions, first, second, from, to, lengths;
  for (int i = 0; i < bars; ++i) {
    positions += fmt::format("{} 0 0  {} 0 0  ", i, i + 1);
    from += fmt::format("{} ", 2 * i), to += fmt::format("{} ", 2 * i + 1), lengths += "1 ";
    if (i > 0) first += fmt::format("{} ", 2 * i - 1), second += fmt::format("{} ", 2 * i);
  }
  return fmt::format(R"(<Node name="root" dt="0.01" gravity="0 -9.81 0">
      <EulerImplicitSolver newtonIterations="1" oneRound="true"/><SparseLDLSolver/>
      {}
      <MechanicalObject name="dofs" position="{} 0 5 0  1 5 0  0.5 5 0"/><UniformMass vertexMass="1"/>
      <FixedProjectiveConstraint indices="{} {}"/>
      <SpringForceField springsIndices1="{}" springsIndices2="{}" lengths="{}" stiffness="2e4"/>
      <FixedLagrangianConstraint indices="0"/>
      <BilateralLagrangianConstraint first_point="{}" second_point="{}"/>{}
    </Node>)",
                     sweeps, positions, 2 * bars, 2 * bars + 1, from, to, lengths, first, second, more);
}

double gapIn(Simulation& simulation, int bars = 10) {
  const Rows x = simulation.systems()[0]->x;
  double gap = 0;
  for (Index i = 1; i < bars; ++i) gap = std::max(gap, (Vec3(x[2 * i - 1]) - Vec3(x[2 * i])).norm());
  return gap;
}

}  // namespace

TEST(ConstraintSweeps, ThatDoNotComeToTheirToleranceAreNoResult) {
  Simulation simulation = simulationFromText(chain("<ConstraintSweeps tolerance='1e-9' maxIterations='1'/>"));
  const StepReport report = simulation.step();
  EXPECT_FALSE(report.constraints_converged);
  expectContains(report.constraint_reason, "/ConstraintSweeps has made 1 sweeps");
}

TEST(ConstraintSweeps, AreKeptAndToldOfWhereTheSceneWantsThat) {
  Simulation simulation = simulationFromText(chain("<ConstraintSweeps tolerance='1e-9' maxIterations='1' keepsUnsettled='true'/>"));
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.constraints_converged);
  expectContains(report.constraint_reason, "/ConstraintSweeps has made 1 sweeps");
}

TEST(ConstraintSweeps, ThatComeToTheirToleranceSayNothing) {
  for (const char* how : {"", "tolerance='1e-9'", "tolerance='1e-9' allVerified='true'", "tolerance='1e-9' sor='1.2'"}) {
    Simulation simulation = simulationFromText(chain(fmt::format("<ConstraintSweeps {}/>", how)));
    for (int n = 0; n < 5; ++n) {
      const StepReport report = simulation.step();
      EXPECT_TRUE(report.constraints_converged) << how;
      EXPECT_EQ(report.constraint_reason, "") << how;
    }
  }
}

/// Without a tolerance they end where round-off is all that still moves.
TEST(ConstraintSweeps, WithoutAToleranceEndAtRoundOff) {
  for (const char* method : {"ProjectedGaussSeidel", "UnbuiltGaussSeidel", "NonsmoothNonlinearConjugateGradient"}) {
    Simulation simulation = simulationFromText(chain(fmt::format("<ConstraintSweeps tolerance='0' resolutionMethod='{}'/>", method)));
    for (int n = 0; n < 5; ++n) {
      const StepReport report = simulation.step();
      ASSERT_FALSE(report.failed()) << method << ": " << report.reason;
      EXPECT_EQ(report.constraint_reason, "") << method;
    }
    EXPECT_LT(gapIn(simulation), 1e-12) << method;
  }
}

TEST(ConstraintSweeps, GoLessThanTwiceTheirWay) {
  for (const char* sor : {"2", "2.2"}) expectContains(problemsOf(chain(fmt::format("<ConstraintSweeps sor='{}'/>", sor))), "range of sor");
}

TEST(ConstraintSweeps, OfWhichASceneHasTwoAreTheFirst) {
  testing::internal::CaptureStderr();
  simulationFromText(chain("<ConstraintSweeps name='one'/><ConstraintSweeps name='two' tolerance='1'/>"));
  expectContains(testing::internal::GetCapturedStderr(), "/two: has no effect: /one stands before it");
}

TEST(ConstraintSweeps, AreNotMadeInStaticsAndSaySoOnce) {
  std::string text = chain("<ConstraintSweeps tolerance='1'/>", 10, "<RestShapeSpringsForceField points='0' stiffness='1'/>");
  const std::string steps = "<EulerImplicitSolver newtonIterations=\"1\" oneRound=\"true\"/>";
  text.replace(text.find(steps), steps.size(), "<StaticSolver/>");
  testing::internal::CaptureStderr();
  Simulation simulation = simulationFromText(text);
  expectContains(testing::internal::GetCapturedStderr(), "/ConstraintSweeps: has no effect: /StaticSolver finds equilibria");
  testing::internal::CaptureStderr();
  simulation.setAttribute("/RestShapeSpringsForceField", "points", "1");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(ConstraintSweeps, AreNotMadeForOtherConditionsAndSaySo) {
  Simulation alone = simulationFromText(chain("<ConstraintSweeps/>"));
  Simulation bead = simulationFromText(chain("<ConstraintSweeps/>", 10, "<SlidingLagrangianConstraint sliding_point='22' curve='20 21'/>"));
  for (int n = 0; n < 3; ++n) alone.step(), bead.step();
  EXPECT_EQ(alone.systems()[0]->integrator().doubt(), "");
  expectContains(bead.systems()[0]->integrator().doubt(),
                 "/ConstraintSweeps had no effect in some steps: the conditions of /SlidingLagrangianConstraint are neither equalities nor "
                 "contacts with sofaLists");
}

/// A step that is not taken leaves nothing where the next one's sweeps begin.
TEST(ConstraintSweeps, OfAStepThatIsTriedAgainHaveTheSameBits) {
  Simulation simulation = simulationFromText(chain("<ConstraintSweeps tolerance='1e-4'/>"));
  for (int n = 0; n < 3; ++n) simulation.step();
  System& system = *simulation.systems()[0];
  const Index count = ConstRows(system.x).count;
  Vector x(count), v(count), first(count), second(count);
  copy(system.x, x), copy(system.v, v);
  const auto attempt = [&](Vector& end) {
    copy(x, system.x), copy(v, system.v);
    const StepContext context{.index = 4, .t = 0.03, .dt = 0.01, .t_end = 0.04};
    system.beginStep(context);
    EXPECT_FALSE(system.integrator().step(system, context).failed());
    copy(system.x, end);
  };
  attempt(first), attempt(second);
  for (Index i = 0; i < first.count(); ++i) EXPECT_EQ(Vec3(first[i]), Vec3(second[i])) << i;
}

TEST(ConstraintSweeps, EndWhereTheyAreAskedTo) {
  ConstraintSweeps sweeps;
  const Eigen::MatrixXd w = Eigen::MatrixXd::Identity(2, 2) + 0.9 * Eigen::MatrixXd::Ones(2, 2);
  const Eigen::VectorXd g = Eigen::VectorXd::Ones(2);
  const std::vector<ConstraintSweeps::Block> blocks(2);
  StopRequest request;
  Eigen::VectorXd l = Eigen::VectorXd::Zero(2);
  EXPECT_GT(sweeps.solve(w, g, blocks, 1, StopToken(request), l), 1);
  request.make();
  EXPECT_EQ(sweeps.solve(w, g, blocks, 1, StopToken(request), l), 0);
}
