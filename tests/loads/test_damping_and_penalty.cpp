// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string scene(const std::string& load, const std::string& integrator, double dt,
                  const std::string& gravity = "0 0 0", const std::string& positions = "0 0 0") {
  return fmt::format(R"(<Node name="root" dt="{}" gravity="{}">{}<CGLinearSolver iterations="50" tolerance="1e-13"/>
    <MechanicalObject name="dofs" position="{}"/><UniformMass vertexMass="2"/>{}</Node>)",
                     dt, gravity, integrator, positions, load);
}

/// v' = -c/m v: exact for explicit Euler as a power of 1 - hc/m, for backward Euler of 1/(1 + hc/m).
TEST(VelocityDamping, DecaysExponentially) {
  const double h = 0.01, c = 3, m = 2;
  for (bool implicit : {false, true}) {
    Simulation simulation =
        simulationFromText(scene("<UniformVelocityDampingForceField dampingCoefficient='3'/>",
                                 implicit ? "<EulerImplicitSolver/>" : "<EulerExplicitSolver/>", h));
    System& system = *simulation.systems().at(0);
    system.v[0] = Vec3(1, 2, 3);
    for (int i = 0; i < 100; ++i) ASSERT_FALSE(simulation.step().diverged);
    const double factor = implicit ? 1 / (1 + h * c / m) : 1 - h * c / m;
    EXPECT_LT((system.v[0] - Vec3(1, 2, 3) * std::pow(factor, 100)).norm(), 1e-12);
    EXPECT_NEAR(system.v[0].x(), std::exp(-c / m), 0.02 * std::exp(-c / m)) << "first order: h c^2 t / 2 m^2";
  }
}

TEST(VelocityDamping, ImplicitWithAHugeCoefficientStops) {
  Simulation simulation = simulationFromText(
      scene("<UniformVelocityDampingForceField dampingCoefficient='1e9'/>", "<EulerImplicitSolver/>", 1));
  System& system = *simulation.systems().at(0);
  system.v[0] = Vec3(1, 2, 3);
  simulation.step();
  EXPECT_NEAR(system.v[0].x(), 1 / (1 + 1e9 / 2), 1e-14);
}

TEST(VelocityDamping, DiagonalDampsEachAxis) {
  Simulation simulation =
      simulationFromText(scene("<DiagonalVelocityDampingForceField dampingCoefficient='1 0 4  0 3 0'/>",
                               "<EulerImplicitSolver/>", 0.5, "0 0 0", "0 0 0 1 0 0"));
  System& system = *simulation.systems().at(0);
  for (Index i = 0; i < 2; ++i) system.v[i] = Vec3(1, 1, 1);
  simulation.step();
  const auto left = [](double c) { return 1 / (1 + 0.5 * c / 2); };
  EXPECT_LT((system.v[0] - Vec3(left(1), 1, left(4))).norm(), 1e-12);
  EXPECT_LT((system.v[1] - Vec3(1, left(3), 1)).norm(), 1e-12);
  expectContains(problemsOf(scene("<DiagonalVelocityDampingForceField dampingCoefficient='1 0 4  0 3 0'/>",
                                  "<EulerImplicitSolver/>", 0.5, "0 0 0", "0 0 0 1 0 0 2 0 0")),
                 "6 numbers for 3 nodes (expected 3 for all, or 3 of each)");
  expectContains(problemsOf(scene("<DiagonalVelocityDampingForceField/>", "<EulerImplicitSolver/>", 1)),
                 "dampingCoefficient");
}

/// A node at rest on the plane: k depth = m g, whatever the plane's direction.
TEST(PlaneForceField, NodesRestAtTheDepthOfTheirWeight) {
  const Vec3 n = Vec3(1, 2, 2) / 3;
  Simulation simulation = simulationFromText(
      scene("<PlaneForceField normal='2 4 4' d='0.5' stiffness='1000' damping='2000'/>", "<EulerImplicitSolver/>", 0.01,
            fmt::format("{:.17g} {:.17g} {:.17g}", -3 * n.x(), -3 * n.y(), -3 * n.z()), "1 1 1"));
  System& system = *simulation.systems().at(0);
  for (int i = 0; i < 3000; ++i) ASSERT_FALSE(simulation.step().diverged);
  EXPECT_NEAR(0.5 - n.dot(system.x[0]), 2 * 3 / 1000., 1e-9);
}

/// The static solver finds the same depth; the energy is k/2 depth^2.
TEST(PlaneForceField, StaticsAndLimit) {
  Simulation simulation = simulationFromText(
      scene("<PlaneForceField stiffness='1000' damping='0'/>", "<StaticSolver/>", 1, "0 -5 0", "0 -0.1 0"));
  System& system = *simulation.systems().at(0);
  ASSERT_FALSE(simulation.step().diverged);
  EXPECT_NEAR(system.x[0].y(), -0.01, 1e-12);
  EXPECT_NEAR(system.elasticEnergy(system.x), 500 * 1e-4, 1e-12);
  Simulation limited = simulationFromText(scene("<PlaneForceField stiffness='1000' damping='0' maxForce='4'/>",
                                                "<EulerExplicitSolver/>", 0.01, "0 0 0", "0 -0.1 0"));
  System& s = *limited.systems().at(0);
  EXPECT_NEAR(s.elasticEnergy(s.x), 4 * 0.1 - 16 / 2000., 1e-15);
  limited.step();
  EXPECT_NEAR(s.v[0].y(), 0.01 * 4 / 2, 1e-15);
}

TEST(PlaneForceField, BilateralPullsBack) {
  for (double side : {-1., 1.}) {
    Simulation simulation =
        simulationFromText(scene("<PlaneForceField stiffness='100' damping='0' bilateral='1'/>",
                                 "<EulerExplicitSolver/>", 0.01, "0 0 0", fmt::format("0 {} 0", 0.2 * side)));
    simulation.step();
    EXPECT_NEAR(simulation.systems().at(0)->v[0].y(), -side * 0.01 * 100 * 0.2 / 2, 1e-15);
  }
}

TEST(PlaneForceField, SaysWhatIsWrong) {
  const auto problems = [](const std::string& attributes) {
    return problemsOf(scene("<PlaneForceField " + attributes + "/>", "<EulerExplicitSolver/>", 1));
  };
  expectContains(problems("normal='0 0 0'"), "no direction");
  expectContains(problems("indices='4'"), "indices in 0 ... 0");
  expectContains(problems("localRange='0 4'"), "no range");
  expectContains(problemsOf("<Node name='root'><EulerExplicitSolver/><MechanicalObject template='Rigid3' "
                            "position='0 0 0 0 0 0 1  1 0 0 0 0 0 1'/><UniformMass totalMass='1'/>"
                            "<PlaneForceField localRange='0 4'/></Node>"),
                 "no range of the 2 nodes");
}

/// For a sphere the depth is the distance: a node held inside one by its weight hangs m g / k outside of it.
TEST(EllipsoidForceField, SphereHoldsAtTheDepthOfTheWeight) {
  for (const char* field : {"<EllipsoidForceField vradius='0.5 0.5 0.5' stiffness='-1000' damping='2000'/>",
                            "<SphereForceField radius='0.5' stiffness='-1000' damping='2000'/>"}) {
    Simulation simulation = simulationFromText(scene(field, "<EulerImplicitSolver/>", 0.01, "0 -3 0", "0.01 0 0.02"));
    System& system = *simulation.systems().at(0);
    for (int i = 0; i < 20000; ++i) ASSERT_FALSE(simulation.step().diverged);
    EXPECT_LT((system.x[0] - Vec3(0, -0.5 - 2 * 3 / 1000., 0)).norm(), 1e-6);
  }
  // pushed out of a sphere: along the radius, in proportion to the depth; nothing at the centre
  Simulation out = simulationFromText(scene("<SphereForceField radius='1' stiffness='10' damping='0'/>",
                                            "<EulerExplicitSolver/>", 0.01, "0 0 0", "0.3 0 0.4 0 0 0 3 0 0"));
  out.step();
  System& system = *out.systems().at(0);
  EXPECT_LT((system.v[0] - 0.01 * 10 * 0.5 / 2 * Vec3(0.6, 0, 0.8)).norm(), 1e-15);
  EXPECT_EQ(Vec3(system.v[1]), Vec3::Zero());
  EXPECT_EQ(Vec3(system.v[2]), Vec3::Zero());
  expectContains(problemsOf(scene("<EllipsoidForceField vradius='1 0 1'/>", "<EulerExplicitSolver/>", 1)),
                 "not positive");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
