// SPDX-License-Identifier: LGPL-2.1-or-later
// A rigid plate pushed by a force: balance, derivatives, a block that it compresses, and the rest at which it comes.
#include <fmt/format.h>

#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string type = "RigidPlateForceField";

/// One hexahedron, free to contract across, below a plate that touches it.
std::string block(const std::string& solver, const std::string& plate, double force, const std::string& more = "") {
  return fmt::format(
      R"(<Node name="root" dt="0.01" gravity="0 0 0">{}
  <Node name="plate"><MechanicalObject name="dofs" position="0.3 0.6 1"/><UniformMass totalMass="0.5"/>
    <PartialFixedProjectiveConstraint indices="0" fixedDirections="1 1 0"/>
    <ConstantForceField indices="0" totalForce="0 0 {}"/></Node>
  <Node name="body"><RegularGridTopology name="grid" n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/>
    <UniformMass totalMass="1"/>{}
    <HexahedronFEMForceField method="small" youngModulus="1000" poissonRatio="0.3"/>
    <BoxROI name="x" box="-1 -1 -1 0.001 2 2"/><BoxROI name="y" box="-1 -1 -1 2 0.001 2"/>
    <BoxROI name="z" box="-1 -1 -1 2 2 0.001"/>
    <PartialFixedProjectiveConstraint indices="@x.indices" fixedDirections="1 0 0"/>
    <PartialFixedProjectiveConstraint indices="@y.indices" fixedDirections="0 1 0"/>
    <PartialFixedProjectiveConstraint indices="@z.indices" fixedDirections="0 0 1"/>
    <RigidPlateForceField plate="@../plate/dofs" normal="0 0 -1" indices="4 5 6 7" stiffness="5000" {}/>
  </Node></Node>)",
      solver, force, more, plate);
}
const std::string statics =
    "<StaticSolver relative_residual_tolerance_threshold=\"1e-12\" newton_iterations=\"30\"/><SparseLDLSolver/>";

/// The block shortens by F L/(E A), the plate sinks into its four nodes by F/(4 k).
TEST(RigidPlate, AForceCompressesABlockAsHookeSays) {
  for (const double force : {-30., 30.}) {  // pushed, and pulled where it is glued
    const std::string attributes = "bilateral=\"true\"";
    Simulation simulation = simulationFromText(block(statics, attributes, force));
    ASSERT_TRUE(simulation.step().newton_converged);
    const System& system = *simulation.systems()[0];
    const State &plate = *simulation.states()[0], &body = *simulation.states()[1];
    ASSERT_EQ(plate.size(), 1u);
    for (Index i = 4; i < 8; ++i) EXPECT_NEAR(system.x[body.firstRow() + i].z(), 1 + force / 1000, 1e-10);
    EXPECT_NEAR(system.x[plate.firstRow()].z(), 1 + force / 1000 + force / (4 * 5000), 1e-10);
  }
}

/// Without glue: damped steps bring it to the same place, and a plate that is drawn away leaves.
TEST(RigidPlate, PressesWithoutPulling) {
  const std::string steps = "<EulerImplicitSolver rayleighMass=\"2\" newtonIterations=\"20\"/><SparseLDLSolver/>";
  Simulation pushed = simulationFromText(block(steps, "", -30));
  Simulation drawn = simulationFromText(block(steps, "", 30));
  for (int i = 0; i < 1500; ++i) {
    ASSERT_FALSE(pushed.step().diverged);
    if (i < 100) ASSERT_FALSE(drawn.step().diverged);
  }
  EXPECT_NEAR(pushed.systems()[0]->x[pushed.states()[0]->firstRow()].z(), 1 - 0.03 - 30. / 20000, 1e-6);
  const Index body = drawn.states()[1]->firstRow();
  for (Index i = 4; i < 8; ++i) EXPECT_EQ(drawn.systems()[0]->x[body + i].z(), 1) << "nothing pulls it";
  EXPECT_GT(drawn.systems()[0]->x[drawn.states()[0]->firstRow()].z(), 2);
}

TEST(RigidPlate, ForcesBalanceAndHaveTheirDerivatives) {
  for (const std::string attributes : {"offset=\"0.4\"", "bilateral=\"true\"", ""}) {
    FieldUnderTest t(block(statics, attributes, -1), type);
    for (Index i = 0; i < t.x.count(); ++i) t.x[i] += Vec3(0.1 * i, -0.05 * i, 0.07 * i - 0.2);
    const Vector f = t.force();
    ASSERT_GT(dot(f, f), 0);
    EXPECT_LT(momentumOf(t.x, f).force, 1e-15);
    EXPECT_LT(relativeDifference(t.product(t.direction), t.differenceOfForces(1e-6)), 1e-8);
    expectMatrixOfProducts(t), expectSymmetricProducts(t);
    Vector a(t.x.count()), b(t.x.count());
    copy(t.x, a), copy(t.x, b);
    axpy(1e-6, t.direction, a), axpy(-1e-6, t.direction, b);
    EXPECT_NEAR((t.field().energy(b) - t.field().energy(a)) / 2e-6, dot(f, t.direction), 1e-5);
  }
}

TEST(RigidPlate, SaysWhatIsWrong) {
  expectContains(problemsOf(block(statics, "plateNode=\"3\"", 1)), "plateNode");
  std::string flat = block(statics, "", 1);
  flat.replace(flat.find("normal=\"0 0 -1\""), 15, "normal=\"0 0 0\"");
  expectContains(problemsOf(flat), "normal has no direction");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
