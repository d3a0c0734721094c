// SPDX-License-Identifier: LGPL-2.1-or-later
// Friction where several triangles are near a vertex, and Coulomb's law of a block of tetrahedra by forces of constraint.
#include <Eigen/Geometry>
#include <cmath>

#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A tip slides along the bottom of a valley that is nearly flat, where it is near both sides and near their edge: the force
/// along the valley is mu times the one that carries it.
TEST(Friction, InAValleyIsNotCountedTwice) {
  const double mu = 0.2, range = 0.02, mass = 1, share = 0.5 * 0.15 / 3;
  const std::string tool = fmt::format(
      "<Node name=\"tool\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"0 0 {}  0 0 0 1\" velocity=\"1 0 0  "
      "0 0 0\"/><UniformMass totalMass=\"{}\" inertia=\"1 1 1\"/><PartialFixedProjectiveConstraint indices=\"0\" "
      "fixedDirections=\"0 1 0 1 1 1\"/><Node name=\"skin\"><MeshTopology position=\"0 0 0  -.3 -.2 1  .3 -.2 1  0 .3 1\" "
      "triangles=\"0 2 1  0 3 2  0 1 3  1 2 3\"/><MechanicalObject name=\"dofs\"/><RigidMapping/></Node></Node>",
      0.8285 * range, mass);
  const std::string valley =
      "<Node name=\"b\"><MeshTopology name=\"mesh\" position=\"-5 0 0  5 0 0  0 -4 0.08  0 4 0.08\" triangles=\"0 2 1  0 1 3\"/>"
      "<MechanicalObject name=\"dofs\"/><UniformMass totalMass=\"1\"/><FixedProjectiveConstraint fixAll=\"true\"/></Node>";
  Simulation simulation = simulationFromText(contactScene(
      tool + valley +
          fmt::format("<BarrierContact mstate=\"@tool/skin/dofs\" other=\"@b/dofs\" contactDistance=\"{}\" stiffness=\"{}\" "
                      "friction=\"{}\" frictionIterations=\"50\" selfContact=\"0\"/>",
                      range, 10 * mass * 9.81 / share, mu),
      0.005, Vec3(0, 0, -9.81)));
  for (int i = 0; i < 20; ++i) expectCleanStep(simulation, i, false);
  const std::vector<double> wrench = numbersOf(simulation, "wrenches");
  EXPECT_NEAR(wrench[2], mass * 9.81, 0.01 * mass * 9.81);
  EXPECT_NEAR(-wrench[0] / wrench[2], mu, 0.01 * mu);
}

/// tan 0.5, a block of tetrahedra on the corners of its lower side: it stays with mu 0.5, and goes
/// 1/2 g (sin q - mu cos q) t^2 with less.
TEST(Friction, OfConstraintsHoldsABlockOrLetsItSlide) {
  const double c = 1 / std::sqrt(1.25), s = 0.5 * c, dt = 0.01, distance = 0.05;
  constexpr int n = 100;
  for (const double mu : {0.5, 0.49}) {
    const Body block = boxOf(Vec3(0, 0, distance), Vec3(1, 1, distance + 0.2));
    Simulation simulation = simulationFromText(fmt::format(
        "<Node name=\"root\" dt=\"{}\" gravity=\"{} 0 {}\"><CollisionPipeline/><CollisionResponse "
        "response=\"FrictionContactConstraint\" responseParams=\"mu={}\"/><MinProximityIntersection alarmDistance=\"0.1\" "
        "contactDistance=\"{}\"/>{}<Node name=\"floor\"><MeshTopology position=\"-9 -6 0  9 -9 0  9 9 0  -9 9 0\" triangles=\"0 1 2  "
        "0 2 3\"/><MechanicalObject/><TriangleCollisionModel simulated=\"0\"/></Node></Node>",
        dt, 9.81 * s, -9.81 * c, mu, distance,
        bodyNode("a", block,
                 "<EulerImplicitSolver/><SparseLDLSolver/><PointCollisionModel/><PartialFixedProjectiveConstraint "
                 "indices=\"0 1 2 3 4 5 6 7\" fixedDirections=\"1 1 0\" endTime=\"0.495\"/>",
                 "", 1e10, 0)));
    const auto mean = [&] {
      Vec3 sum = Vec3::Zero();
      for (Index i = 0; i < 8; ++i) sum += simulation.states()[0]->x()[i] / 8;
      return sum;
    };
    for (int i = 0; i < 50; ++i) expectCleanStep(simulation, i, false);  // it settles, held against sliding
    const Vec3 start = mean();
    for (int i = 0; i < n; ++i) expectCleanStep(simulation, i, false);
    const double closed_form = 9.81 * (s - 0.49 * c) / 2 * std::pow(n * dt, 2), expected = mu == 0.5 ? 0 : closed_form;
    EXPECT_NEAR(closed_form, 0.0438717, 1e-6);
    // Euler's implicit method goes (n + 1)/n times as far as the parabola
    EXPECT_NEAR(mean().x() - start.x(), expected * (n + 1) / n, 0.01 * closed_form) << "mu " << mu;
    EXPECT_NEAR(mean().z(), start.z(), 1e-3);
  }
}

/// Coulomb's force is at most mu times the normal one, also in the rule that takes the forces of both ends of a step.
TEST(Friction, ATableThatMovesAcceleratesByNoMoreThanMuG) {
  constexpr double mu = 0.5, g = 9.81, dt = 0.01;
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="{}" gravity="0 0 -{}">
    <EulerImplicitSolver trapezoidalScheme="true" newtonIterations="50"/><SparseLDLSolver/>
    <RegularGridTopology n="3 3 3" min="0 0 0.0095" max="0.1 0.1 0.1095"/><MechanicalObject/><UniformMass totalMass="1"/>
    <HexahedronFEMForceField youngModulus="1e6" poissonRatio="0.3" method="svd"/>
    <BarrierContact contactDistance="0.01" friction="{}" planes="0 0 1 0" keyTimes="0 10" movements="0 0 0  0.1 0 0"/></Node>)",
      dt, g, mu));
  const auto speed = [&] {
    const System& system = *simulation.systems()[0];
    Vec3 mean = Vec3::Zero();
    for (Index i = 0; i < 27; ++i) mean += system.v[i] / 27;
    return mean.x();
  };
  double before = 0, largest = 0;
  for (int step = 0; step < 30; ++step) {
    simulation.step();
    largest = std::max(largest, std::abs(speed() - before));
    before = speed();
  }
  EXPECT_GT(largest, 0.002) << "it is carried along";
  EXPECT_LT(largest, 2 * mu * g * dt) << "twice: it bounces a little";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
