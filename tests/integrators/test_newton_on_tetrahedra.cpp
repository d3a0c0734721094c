// SPDX-License-Identifier: LGPL-2.1-or-later
// Newton's method on a soft beam that bends by half its length: steps, equilibrium, and that both agree.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/newton_history.h"

using namespace stroma;
using namespace stroma::test;

namespace {

Simulation beam(const std::string& integrator, const std::string& solver, double dt, const std::string& tangent) {
  return simulationFromText(fmt::format(
      R"(<Node name="root" dt="{}" gravity="0 -9.81 0">
           {} {}
           <RegularGridTopology name="grid" n="9 3 3" min="0 0 0" max="0.2 0.04 0.04"/>
           <MechanicalObject name="dofs"/>
           <UniformMass totalMass="0.3"/>
           <BoxROI name="end" box="-0.001 -1 -1  0.001 1 1" position="@dofs.rest_position"/>
           <FixedProjectiveConstraint indices="@end.indices"/>
           <Node name="cells">
             <TetrahedronSetTopologyContainer name="tetrahedra"/>
             <Hexa2TetraTopologicalMapping input="@../grid" output="@tetrahedra"/>
             <TetrahedronFEMForceField mstate="@../dofs" topology="@tetrahedra" youngModulus="60000" poissonRatio="0.3"
                                       method='svd' tangent="{}"/>
           </Node>
         </Node>)",
      dt, integrator, solver, tangent));
}

double lowest(const Simulation& simulation) {
  double value = 0;
  for (Index i = 0; i < simulation.systems()[0]->independentRows(); ++i)
    value = std::min(value, simulation.systems()[0]->x[i][1]);
  return value;
}

}  // namespace

TEST(NewtonOnTetrahedra, EquilibriumConvergesQuadraticallyWithTheExactTangent) {
  Simulation simulation = beam("<StaticSolver newton_iterations='40' relative_residual_tolerance_threshold='1e-12'/>",
                               "<SparseLDLSolver/>", 1, "exact");
  const StepReport report = simulation.step();
  ASSERT_TRUE(report.newton_converged) << report.reason;
  EXPECT_LE(report.newton_iterations, 15);
  const std::vector<double> graph = residuals(simulation);
  const std::size_t n = graph.size();
  const double last = graph[n - 1] / graph[0], before = graph[n - 2] / graph[0];
  EXPECT_LT(last, 1e-12);
  EXPECT_LT(last, 1e4 * before * before + 1e-14);
  EXPECT_LT(lowest(simulation), -0.05);
}

TEST(NewtonOnTetrahedra, TheWarpedTangentReachesTheSameEquilibrium) {
  Simulation exact = beam("<StaticSolver newton_iterations='40'/>", "<SparseLDLSolver/>", 1, "exact");
  Simulation warped = beam("<StaticSolver newton_iterations='200'/>", "<SparseLDLSolver/>", 1, "warped");
  ASSERT_TRUE(exact.step().newton_converged);
  const StepReport report = warped.step();
  ASSERT_TRUE(report.newton_converged) << report.reason;
  EXPECT_NEAR(lowest(exact), lowest(warped), 1e-6);
}

TEST(NewtonOnTetrahedra, StepsConvergeWithAndWithoutDampingOfEitherKind) {
  for (const char* damping : {"", "rayleighMass='2'", "rayleighStiffness='0.02'", "trapezoidalScheme='true'"})
    for (const char* tangent : {"warped", "exact"}) {
      Simulation simulation = beam(fmt::format("<EulerImplicitSolver newtonIterations='60' {}/>", damping),
                                   "<SparseLDLSolver/>", 0.02, tangent);
      for (int n = 0; n < 5; ++n) {
        const StepReport report = simulation.step();
        ASSERT_TRUE(report.newton_converged) << damping << ' ' << tangent << ": " << report.reason;
        ASSERT_LT(report.newton_residual, 1e-8);
      }
    }
}

TEST(NewtonOnTetrahedra, HugeDampedStepsEndInTheStaticEquilibrium) {
  Simulation still = beam("<StaticSolver newton_iterations='40'/>", "<SparseLDLSolver/>", 1, "exact");
  ASSERT_TRUE(still.step().newton_converged);
  Simulation moving =
      beam("<EulerImplicitSolver newtonIterations='100'/>",
           "<CGLinearSolver iterations='2000' tolerance='1e-10' preconditioner='block_jacobi'/>", 5, "exact");
  for (int n = 0; n < 25; ++n) {
    const StepReport report = moving.step();
    ASSERT_TRUE(report.newton_converged) << n << ": " << report.reason;
  }
  EXPECT_NEAR(lowest(still), lowest(moving), 1e-5);
}

/// Of six steps of a cube: the first that did not converge, or the last.
static StepReport reportOfCube(const std::string& integrator, double speed, double gravity, const std::string& more = {}) {
  std::string velocity;
  for (int i = 0; i < 64; ++i) velocity += fmt::format("{} 0 0 ", speed);
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="0.01" gravity="0 {} 0"><{} newtonIterations="30" newtonTolerance="1e-8"/><SparseLDLSolver/>
           <RegularGridTopology name="grid" min="0.3 0.2 0.1" max="0.41 0.3 0.2" n="4 4 4"/>
           <MechanicalObject name="dofs" velocity="{}"/>
           <UniformMass totalMass="1.2"/>
           {}
           <Node name="cells">
             <TetrahedronSetTopologyContainer name="tetrahedra"/>
             <Hexa2TetraTopologicalMapping input="@../grid" output="@tetrahedra"/>
             <TetrahedronFEMForceField mstate="@../dofs" topology="@tetrahedra" youngModulus="1e4" poissonRatio="0.45"
                                       method="svd"/>
           </Node></Node>)",
      gravity, integrator, velocity, more));
  StepReport report = simulation.step();
  for (int n = 1; n < 6 && report.newton_converged; ++n) report = simulation.step();
  return report;
}

/// Round-off is then all that there is of forces, and no part of it can be told from another.
TEST(NewtonOnTetrahedra, StepsConvergeWhereNothingActs) {
  for (const char* integrator : {"EulerImplicitSolver", "TrapezoidalRuleSolver", "NewmarkImplicitSolver", "BDFOdeSolver"})
    for (const double speed : {0., 1e-14, 1e-12, 1e-6, 0.1}) {
      const StepReport report = reportOfCube(integrator, speed, 0);
      EXPECT_TRUE(report.newton_converged) << integrator << " at " << speed << " m/s: " << report.reason;
      EXPECT_FALSE(report.diverged);
    }
}

TEST(NewtonOnTetrahedra, ALoadThatRoundOffHidesIsSaid) {
  const std::string held =
      R"(<BoxROI name="end" box="0.29 0 0  0.301 1 1"/><FixedProjectiveConstraint indices="@end.indices"/>)";
  const StepReport weight = reportOfCube("EulerImplicitSolver", 0, -2e-12, held);
  EXPECT_FALSE(weight.newton_converged);
  expectContains(weight.reason, "the loads are too small for this stiffness");
  const std::string push = R"(<ConstantForceField indices="63" forces="0 1e-15 0"/>)";
  const StepReport force = reportOfCube("EulerImplicitSolver", 0, 0, held + push);
  EXPECT_FALSE(force.newton_converged);
  expectContains(force.reason, "the loads are too small for this stiffness");
  EXPECT_TRUE(reportOfCube("EulerImplicitSolver", 0, 0, held).newton_converged);
  EXPECT_TRUE(reportOfCube("EulerImplicitSolver", 0, -1, held).newton_converged);
}

/// A bar pressed at its end until cells turn inside out, where the tangent whose stresses turn has unstable directions that many linear
/// solvers do not see.
TEST(NewtonOnTetrahedra, PressedBarsConvergeWithEverySolverAsWithOneThatSeesWhatIsNotDefinite) {
  const auto run = [](const std::string& solver) {
    Simulation bar = simulationFromText(fmt::format(
        R"(<Node name="root" dt="0.01" gravity="0 0 0">
             <EulerImplicitSolver newtonIterations='40' rayleighStiffness='1e-3'/> {}
             <RegularGridTopology name="grid" n="3 3 9" min="0 0 0" max="0.1 0.1 0.4"/>
             <MechanicalObject name="dofs"/>
             <UniformMass totalMass="1"/>
             <BoxROI name="foot" box="-1 -1 -0.001  1 1 0.001"/><FixedProjectiveConstraint indices="@foot.indices"/>
             <BoxROI name="head" box="-1 -1 0.399  1 1 0.401"/><ConstantForceField indices="@head.indices" totalForce="30 0 -1500"/>
             <Node name="cells">
               <TetrahedronSetTopologyContainer name="tetrahedra"/>
               <Hexa2TetraTopologicalMapping input="@../grid" output="@tetrahedra"/>
               <TetrahedronFEMForceField mstate="@../dofs" topology="@tetrahedra" youngModulus="1e5" poissonRatio="0" method='svd'/>
             </Node>
           </Node>)",
        solver));
    int converged = 0;
    double worst = 0;
    for (int n = 0; n < 12; ++n) {
      const StepReport report = bar.step();
      EXPECT_FALSE(report.failed()) << report.reason;
      EXPECT_TRUE(report.linear_converged) << solver << ": a solve that was tried is no solve that failed";
      converged += report.newton_converged;
      if (n > 0) worst = std::max(worst, report.newton_residual);
    }
    return std::pair(converged, worst);
  };
  const auto seen = run("<SparseLDLSolver/>");
  EXPECT_GE(seen.first, 8);
  for (const char* solver : {"<EigenSparseLU/>", "<MinResLinearSolver iterations='2000' tolerance='1e-10'/>"}) {
    const auto unseen = run(solver);
    EXPECT_GE(unseen.first, seen.first - 1) << solver;
    EXPECT_LT(unseen.second, 10 * seen.second) << solver;
  }
}
