// SPDX-License-Identifier: LGPL-2.1-or-later
// Statics with forces of constraint: a step begins with those of the step before, also where a run goes on or begins again; and
// iterations that go to and fro between the sides of an edge are said to. What needs no force changes nothing.
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A sphere that is pressed into a block and drawn along, and then stays; two steps each.
Simulation pressed(const std::string& attributes = "contactDistance=\"1e-3\"") {
  return simulationFromText(
      contactScene("<RegularGridTopology n=\"7 7 4\" min=\"-0.03 -0.03 -0.02\" max=\"0.03 0.03 0\"/><MechanicalObject "
                   "name=\"dofs\"/>"
                   "<UniformMass totalMass=\"1\"/><HexahedronFEMForceField youngModulus=\"1e4\" poissonRatio=\"0.4\" "
                   "method=\"polar\"/>"
                   "<BoxROI name=\"bottom\" box=\"-1 -1 -0.021 1 1 -0.0199\"/><FixedProjectiveConstraint "
                   "indices=\"@bottom.indices\"/>"
                   "<ConstraintContact friction=\"0.3\" spheres=\"0.001 0.0007 0.02101 0.02\" keyTimes=\"0 2 9\" "
                   "movements=\"0 0 0  0.001 0 -0.002  0.001 0 -0.002\" " +
                       attributes + "/>",
                   1, Vec3::Zero(), "<StaticSolver newton_iterations=\"60\"/>"));
}

int iterationsOf(Simulation& simulation) {
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.newton_converged && report.constraints_converged) << report.reason << report.constraint_reason;
  return report.newton_iterations;
}

std::vector<double> placesOf(const Simulation& simulation) {
  std::vector<double> all;
  const ConstRows x = simulation.systems()[0]->x;
  for (Index i = 0; i < x.count; ++i)
    for (int k = 0; k < 3; ++k) all.push_back(x[i][k]);
  return all;
}

TEST(ConditionedStatics, AStepInWhichNothingMovesKnowsItsForces) {
  Simulation simulation = pressed();
  EXPECT_GT(iterationsOf(simulation), 2);
  EXPECT_GT(iterationsOf(simulation), 2);
  const std::vector<double> forces = constraintOutput(simulation, "contactForces"), places = placesOf(simulation);
  EXPECT_LE(iterationsOf(simulation), 2) << "friction lets go of what its last step has slid";
  EXPECT_EQ(iterationsOf(simulation), 1) << "the forces of the step before are those of this one";
  EXPECT_LT(constraintOutput(simulation, "wrenches").at(2), 0) << "it is pressed";
}

TEST(ConditionedStatics, ForcesGoOnFromACheckpointAndBeginAgain) {
  Simulation whole = pressed(), half = pressed();
  std::vector<int> iterations;
  for (int i = 0; i < 4; ++i) iterations.push_back(iterationsOf(whole));
  for (int i = 0; i < 2; ++i) iterationsOf(half);
  Simulation rest = pressed();
  rest.restore(half.checkpoint());
  for (int i = 2; i < 4; ++i) EXPECT_EQ(iterationsOf(rest), iterations[std::size_t(i)]);
  EXPECT_EQ(placesOf(rest), placesOf(whole));
  half.reset();
  for (int i = 0; i < 4; ++i) EXPECT_EQ(iterationsOf(half), iterations[std::size_t(i)]) << "begun again, step " << i;
  EXPECT_EQ(placesOf(half), placesOf(whole));
}

/// A bar of 0.4 m that is pressed by `way` in one step, which has to be divided.
Simulation pressedBar(const std::string& integrator, double way, double aside, double poisson_ratio, const std::string& beside) {
  return simulationFromText(fmt::format(
      "<Node name=\"root\" dt=\"1\" gravity=\"0 0 0\">{}<SparseLDLSolver/><Node name=\"bar\"><RegularGridTopology n=\"3 3 9\" "
      "min=\"0 0 0\" max=\"0.1 0.1 0.4\"/><MechanicalObject/><UniformMass totalMass=\"1\"/>"
      "<HexahedronHyperelasticityFEMForceField materialName=\"NeoHookean\" youngModulus=\"1e4\" poissonRatio=\"{}\"/>"
      "<BoxROI name=\"low\" box=\"-1 -1 -0.01 1 1 0.01\"/><BoxROI name=\"high\" box=\"-1 -1 0.39 1 1 0.41\"/>"
      "<FixedProjectiveConstraint indices=\"@low.indices\"/><LinearMovementProjectiveConstraint indices=\"@high.indices\" "
      "keyTimes=\"0 1 9\" movements=\"0 0 0  {} 0 {}  {} 0 {}\"/></Node>{}</Node>",
      integrator, poisson_ratio, aside, -way, aside, -way, beside));
}

/// What needs no force of constraint leaves everything as it is: bits, iterations and parts.
TEST(ConditionedStatics, AnIdleStopperChangesNothing) {
  const std::string idle =
      "<Node name=\"idle\"><MechanicalObject template=\"Vec1\" position=\"0\"/><UniformMass totalMass=\"1\"/>"
      "<RestShapeSpringsForceField stiffness=\"10\" points=\"0\"/><StopperLagrangianConstraint index=\"0\" min=\"-5\" max=\"5\"/></Node>";
  int divided = 0;
  for (const std::string integrator : {"<StaticSolver/>", "<EulerImplicitSolver newtonIterations=\"60\"/>"})
    for (const auto& [way, aside, poisson_ratio] : {std::tuple(0.2, 0.0, 0.3), std::tuple(0.3, 0.02, 0.45)}) {
      SCOPED_TRACE(fmt::format("{}, {} m", integrator, way));
      Simulation alone = pressedBar(integrator, way, aside, poisson_ratio, "");
      Simulation beside = pressedBar(integrator, way, aside, poisson_ratio, idle);
      const StepReport of_alone = alone.step(), of_both = beside.step();
      ASSERT_TRUE(of_alone.newton_converged) << of_alone.reason;
      ASSERT_TRUE(of_both.newton_converged && of_both.constraints_converged) << of_both.reason << of_both.constraint_reason;
      divided += of_alone.load_parts > 1;
      EXPECT_EQ(of_both.newton_iterations, of_alone.newton_iterations);
      EXPECT_EQ(of_both.load_parts, of_alone.load_parts);
      for (Index i = 0; i < 81; ++i)
        EXPECT_EQ(Vec3(beside.systems()[0]->x[i]), Vec3(alone.systems()[0]->x[i])) << "node " << i;
    }
  EXPECT_GE(divided, 2) << "steps that were too much for one go";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
