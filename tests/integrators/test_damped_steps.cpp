// SPDX-License-Identifier: LGPL-2.1-or-later
// Stiffness-proportional damping where a motion crushes cells until their stiffness has unstable directions.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "framework/simulation/simulation.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double side = 0.1;

/// A cube on its foot, whose nodes move down in proportion to their height, the upper ones by four fifths of it per step.
std::string crushedCube(const std::string& law, double damping, const std::string& solver) {
  constexpr int n = 4;
  constexpr double speed = 8;
  std::string velocity;
  for (int node = 0; node < n * n * n; ++node) velocity += fmt::format("0 0 {}  ", -speed * (node / (n * n)) / (n - 1));
  return fmt::format(
      R"(<Node name="root" dt="0.01">
           <EulerImplicitSolver newtonIterations="60" newtonTolerance="1e-6" rayleighStiffness="{}"/> {}
           <RegularGridTopology n="{} {} {}" min="0 0 0" max="{} {} {}"/>
           <MechanicalObject name="dofs" velocity="{}"/>
           <UniformMass totalMass="1"/>
           <BoxROI name="foot" box="-1 -1 -1  1 1 0.001"/><FixedProjectiveConstraint indices="@foot.indices"/>
           <HexahedronHyperelasticityFEMForceField materialName="{}" youngModulus="1e4" poissonRatio="0.45"/>
         </Node>)",
      damping, solver, n, n, n, side, side, side, velocity, law);
}

double energyOf(const Simulation& simulation) {
  const System& system = *simulation.systems()[0];
  return system.kineticEnergy() + system.potentialEnergy(system.independent(system.x));
}

/// Damping takes energy out of each step, however crushed the cells are, and steps converge; with a damping of twice dt the tangent lacks
/// too much of the derivative for that. With the unstable part of the stiffness in it the cube grew to hundreds of times its size.
TEST(DampedSteps, OfCrushedCellsConvergeAndLoseEnergy) {
  for (const char* law : {"StableNeoHookean", "NeoHookean"})
    for (const double damping : {0.005, 0.02})
      for (const char* solver : {"<SparseLDLSolver/>", "<CGLinearSolver iterations='500' tolerance='1e-8' threshold='1e-12'/>", ""}) {
        SCOPED_TRACE(fmt::format("{}, {} s, {}", law, damping, solver));
        Simulation simulation = simulationFromText(crushedCube(law, damping, solver));
        const State& cube = *simulation.states().front();
        double before = energyOf(simulation);
        for (int step = 0; step < 10; ++step) {
          const StepReport report = simulation.step();
          ASSERT_FALSE(report.failed()) << "step " << step << ": " << report.reason;
          EXPECT_LE(report.newton_residual, damping < 0.01 ? 1e-6 : 0.01) << "step " << step << ": " << report.reason;
          const double now = energyOf(simulation);
          EXPECT_LE(now, before * (1 + 1e-6)) << "step " << step;
          before = now;
        }
        for (Index node = 0; node < cube.size(); ++node) EXPECT_LT(Vec3(cube.x()[node]).norm(), 3 * side) << "node " << node;
      }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
