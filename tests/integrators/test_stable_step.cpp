// SPDX-License-Identifier: LGPL-2.1-or-later
// The warning of explicit methods above their stable step: the number against a closed form, and the element by name.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string warningOf(const std::string& scene) {
  ::testing::internal::CaptureStderr();
  const Simulation simulation = simulationFromText(scene);
  return ::testing::internal::GetCapturedStderr();
}

TEST(StableStep, NamesTheStiffElement) {
  for (const int stiff : {0, 13, 22}) {
    std::string moduli;
    for (int cell = 0; cell < 27; ++cell) moduli += cell == stiff ? "1e7 " : "1e3 ";
    const std::string warning = warningOf(fmt::format(
        R"(<Node name="root" dt="1" gravity="0 0 0"><EulerExplicitSolver name="explicit"/>
             <RegularGridTopology n="4 4 4" min="0 0 0" max="3 3 3"/><MechanicalObject/><UniformMass totalMass="64"/>
             <HexahedronFEMForceField name="fem" youngModulus="{}" poissonRatio="0.3" method="polar"/></Node>)",
        moduli));
    EXPECT_NE(warning.find("estimated stable step"), std::string::npos) << warning;
    EXPECT_NE(warning.find(fmt::format("strongest in element {} of /fem", stiff)), std::string::npos) << warning;
  }
}

/// A mass on a spring: w = sqrt(k/m) = 20 rad/s. In h w, symplectic Euler is stable up to 2 and the classical Runge-Kutta
/// method up to sqrt(8). The midpoint rule grows by sqrt(1 + (h w)^4 / 4), which is 1.01 at 0.5325.
TEST(StableStep, OfAnOscillatorIsItsClosedForm) {
  const auto scene = [](const std::string& integrator, double dt) {
    return fmt::format(
        R"(<Node name="root" dt="{}" gravity="0 0 0"><{}/>
             <MechanicalObject position="0 0 0 1 0 0"/><UniformMass vertexMass="2"/>
             <SpringForceField springsIndices1="0" springsIndices2="1" stiffness="800" lengths="1" damping="0"/>
             <FixedProjectiveConstraint indices="0"/></Node>)",
        dt, integrator);
  };
  const struct {
    const char *integrator, *words;
    double limit;  ///< h w
  } cases[] = {{"EulerExplicitSolver", "stable step of symplectic Euler, 0.1 s", 2},
               {"RungeKutta4Solver", "above the estimated stable step", std::sqrt(8)},
               {"RungeKutta2Solver", "adds energy to fast motions", std::pow(4 * (1.01 * 1.01 - 1), 0.25)}};
  for (const auto& [integrator, words, limit] : cases) {
    EXPECT_EQ(warningOf(scene(integrator, 0.998 * limit / 20)), "") << integrator;
    const std::string warning = warningOf(scene(integrator, 1.001 * limit / 20));
    EXPECT_NE(warning.find(words), std::string::npos) << warning;
  }
}

/// What steps that are too long have made of a run is a doubt at its end, of springs too, whose bodies have no shape that bursts.
TEST(StableStep, ARunThatGainedEnergySaysSo) {
  const std::string spring = R"(<MechanicalObject position="0 0 0 1.1 0 0"/><UniformMass vertexMass="2"/>
    <SpringForceField springsIndices1="0" springsIndices2="1" stiffness="800" lengths="1" damping="0"/>)";
  for (const std::string integrator : {"EulerExplicitSolver", "CentralDifferenceSolver", "RungeKutta4Solver", "NewtonCotesSolver"})
    for (const double angle : {0.6, 4.}) {  // h w
      Simulation simulation = simulationFromText(
          fmt::format(R"(<Node name="root" dt="{}" gravity="0 -9.81 0"><{}/>{}<FixedProjectiveConstraint indices="0"/></Node>)",
                      angle / 20, integrator, spring));
      for (int n = 0; n < 60; ++n) ASSERT_FALSE(simulation.step().failed()) << integrator << angle;
      const std::string doubt = simulation.systems()[0]->integrator().doubt();
      EXPECT_EQ(doubt.find("has gained") != std::string::npos, angle > 1) << integrator << " " << angle << ": " << doubt;
      simulation.reset();
      EXPECT_EQ(simulation.systems()[0]->integrator().doubt(), "");
    }
}

/// A run is right up to the limit, wherever it ends; just beyond it, it is not, and a dozen steps far beyond it are enough. With a start
/// out of balance or at speed.
TEST(StableStep, ARunBelowTheLimitIsNotDoubted) {
  const std::pair<std::string, double> limits[] = {
      {"EulerExplicitSolver", 2}, {"CentralDifferenceSolver", 2}, {"RungeKutta4Solver", std::sqrt(8)}};
  for (const auto& limit : limits)
    for (const double part : {0.3, 0.8, 0.95, 1.02, 2.})
      for (const std::string start : {"position=\"0 0 0 1.001 0 0\"", "position=\"0 0 0 1 0 0\" velocity=\"0 0 0 0.02 0 0\"",
                                      "position=\"0 0 0 1.001 0 0\" velocity=\"0 0 0 -0.02 0 0\""}) {
        Simulation simulation = simulationFromText(fmt::format(
            R"(<Node name="root" dt="{}" gravity="0 0 0"><{}/><MechanicalObject {}/><UniformMass vertexMass="2"/>
                 <SpringForceField springsIndices1="0" springsIndices2="1" stiffness="800" lengths="1" damping="0"/>
                 <FixedProjectiveConstraint indices="0"/></Node>)",
            part * limit.second / 20, limit.first, start));
        bool is_doubted = false;
        int n = 1;
        for (; n <= 60; ++n) {
          if (simulation.step().failed()) break;
          is_doubted = is_doubted || !simulation.systems()[0]->integrator().doubt().empty();
          if (part < 1) ASSERT_FALSE(is_doubted) << limit.first << " " << part << " " << start << ", step " << n;
          if (part >= 2 && n == 12) ASSERT_TRUE(is_doubted) << limit.first << " " << start << ", step " << n;
        }
        if (part < 1) EXPECT_EQ(n, 61) << "no step has failed";
        if (part > 1) EXPECT_TRUE(is_doubted) << limit.first << " " << part << " " << start;
      }
}

TEST(StableStep, NoNumberIsNoEnergyThatWasGained) {
  Simulation simulation = simulationFromText(
      R"(<Node name="root" dt="1e6" gravity="0 0 0"><EulerExplicitSolver/><MechanicalObject position="0 0 0 1.1 0 0"/>
           <UniformMass vertexMass="2"/><SpringForceField springsIndices1="0" springsIndices2="1" stiffness="1e6" lengths="1" damping="0"/>
           <FixedProjectiveConstraint indices="0"/></Node>)");
  for (int n = 0; n < 40; ++n)
    if (simulation.step().failed()) break;
  const std::string doubt = simulation.systems()[0]->integrator().doubt();
  EXPECT_EQ(doubt.find("inf"), std::string::npos) << doubt;
  EXPECT_FALSE(doubt.empty());
}

/// Newmark's method is stable with steps of any length when 2 beta >= gamma >= 1/2.
TEST(StableStep, NewmarksParametersThatLoseItAreNamed) {
  const auto warning = [](double beta, double gamma) {
    const std::string scene = fmt::format(
        R"(<Node name="root" dt="0.01" gravity="0 0 0"><NewmarkImplicitSolver beta="{}" gamma="{}"/><CGLinearSolver/>
             <MechanicalObject position="0 0 0"/><UniformMass totalMass="1"/></Node>)",
        beta, gamma);
    return sceneFromText(scene).diagnostics.text();
  };
  EXPECT_EQ(warning(0.25, 0.5), "");
  EXPECT_EQ(warning(0.31, 0.61), "");
  EXPECT_NE(warning(0.3, 0.61).find("beta = 0.3 is below gamma/2 = 0.305"), std::string::npos);
  EXPECT_NE(warning(0.25, 0.49).find("gamma = 0.49 adds energy"), std::string::npos);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
