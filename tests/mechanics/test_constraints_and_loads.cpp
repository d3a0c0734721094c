// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>

#include "tests/mechanics/scene_text.h"

namespace stroma::test {
namespace {

std::string scene(const std::string& component) {
  return fmt::format(R"(<Node name="root" gravity="0 0 0"><TestIntegrator/>
    <MechanicalObject name="dofs" position="0 0 0 1 0 0 2 0 0 3 0 0" velocity="1 2 3 1 2 3 1 2 3 1 2 3"/>
    <UniformMass totalMass="4"/>{}</Node>)",
                     component);
}

TEST(FixedProjectiveConstraint, HoldsTheListedNodes) {
  Simulation simulation(sceneFromText(scene("<FixedProjectiveConstraint indices='3 1 3'/>")));
  System& system = *simulation.systems()[0];
  ASSERT_EQ(system.projectors().size(), 2u);
  EXPECT_EQ(system.projectors()[0].row, 1);
  EXPECT_EQ(system.projectors()[1].row, 3);
  EXPECT_TRUE(system.projectors()[0].projector.isZero());
  simulation.step();
  EXPECT_EQ(Vec3(system.v[1]), Vec3(1, 2, 3)) << "a held node keeps its velocity";
}

TEST(FixedProjectiveConstraint, ProjectsVelocityAndEnds) {
  Simulation simulation(
      sceneFromText(scene("<FixedProjectiveConstraint indices='1' activate_projectVelocity='1' endTime='0.015'/>")));
  System& system = *simulation.systems()[0];
  simulation.step();
  EXPECT_EQ(Vec3(system.v[1]), Vec3::Zero());
  EXPECT_EQ(Vec3(system.v[2]), Vec3(1, 2, 3));
  simulation.step();
  EXPECT_EQ(system.projectors().size(), 1u);
  system.v[1] = Vec3(4, 5, 6);
  const long before = system.revision();
  simulation.step();  // from t = 0.02
  EXPECT_TRUE(system.projectors().empty());
  EXPECT_EQ(Vec3(system.v[1]), Vec3(4, 5, 6));
  EXPECT_NE(system.revision(), before);
}

TEST(PartialFixedProjectiveConstraint, HoldsDirections) {
  Simulation simulation(sceneFromText(
      scene("<PartialFixedProjectiveConstraint indices='2' fixedDirections='1 0 1' projectVelocity='true'/>")));
  System& system = *simulation.systems()[0];
  simulation.step();
  EXPECT_EQ(Vec3(system.v[2]), Vec3(0, 2, 0));
  Vector force(4);
  for (Index i = 0; i < 4; ++i) force[i] = Vec3(1, 1, 1);
  system.project(force);
  EXPECT_EQ(Vec3(force[2]), Vec3(0, 1, 0));
  EXPECT_EQ(Vec3(force[1]), Vec3(1, 1, 1));
}

TEST(Constraints, SayWhatIsWrong) {
  expectContains(problemsOf(scene("<FixedProjectiveConstraint name='hold'/>")), "which nodes are held");
  expectContains(problemsOf(scene("<FixedProjectiveConstraint indices='1 4'/>")),
                 "indices[1] is 4, and /dofs has 4 nodes");
  expectContains(problemsOf(scene("<FixedProjectiveConstraint indices='-1'/>")), "indices in 0 ... 3");
  expectContains(problemsOf(scene("<FixedProjectiveConstraint indices=''/>")), "lists no node");
  expectContains(problemsOf(scene("<PartialFixedProjectiveConstraint indices='1' fixedDirections='1 1'/>")),
                 "2 values");
  expectContains(sceneFromText(scene("<PartialFixedProjectiveConstraint indices='1' fixedDirections='0 0 0'/>"))
                     .diagnostics.text(),
                 "holds no direction");
}

std::vector<Vec3> forcesOf(const std::string& attributes) {
  Simulation simulation(sceneFromText(scene("<ConstantForceField " + attributes + "/>")));
  System& system = *simulation.systems()[0];
  system.computeForce(system.x, system.v, system.f);
  // the force is minus the gradient of the energy, which is linear: any difference serves
  for (Index i = 0; i < 4; ++i)
    for (int c = 0; c < 3; ++c) {
      const double before = system.potentialEnergy(system.x);
      system.x[i][c] += 0.5;
      EXPECT_NEAR((system.potentialEnergy(system.x) - before) / -0.5, system.f[i][c], 1e-13);
      system.x[i][c] -= 0.5;
    }
  std::vector<Vec3> forces;
  for (Index i = 0; i < 4; ++i) forces.push_back(system.f[i]);
  return forces;
}

TEST(ConstantForceField, LoadsNodes) {
  const Vec3 f(0, -2, 1), zero = Vec3::Zero();
  EXPECT_EQ(forcesOf("indices='1 3' forces='0 -2 1 0 -4 2'"), (std::vector<Vec3>{zero, f, zero, 2 * f}));
  EXPECT_EQ(forcesOf("indices='1 3' forces='0 -2 1'"), (std::vector<Vec3>{zero, f, zero, f}));
  EXPECT_EQ(forcesOf("indices='1 3' force='0 -2 1'"), (std::vector<Vec3>{zero, f, zero, f}));
  EXPECT_EQ(forcesOf("indices='1 3' totalForce='0 -4 2'"), (std::vector<Vec3>{zero, f, zero, f}));
  EXPECT_EQ(forcesOf("indices='2 2' totalForce='0 -2 1'"), (std::vector<Vec3>{zero, zero, f, zero}));
  EXPECT_EQ(forcesOf("indices='0' indexFromEnd='true' totalForce='0 -2 1'"), (std::vector<Vec3>{zero, zero, zero, f}));
  EXPECT_EQ(forcesOf("totalForce='0 -8 4'"), (std::vector<Vec3>{f, f, f, f}));
}

TEST(ConstantForceField, SaysWhatIsWrong) {
  const auto problems = [](const std::string& attributes) {
    return problemsOf(scene("<ConstantForceField " + attributes + "/>"));
  };
  expectContains(problems("indices='0'"), "there is no force");
  expectContains(problems("indices='0' totalForce='1 0 0' forces='1 0 0'"), "more than one");
  expectContains(problems("indices='0 1' forces='1 0 0 2 0 0 3 0 0'"), "3 values for 2 nodes");
  expectContains(problems("indices='9' totalForce='1 0 0'"), "indices in 0 ... 3");
  expectContains(problems("indices='' totalForce='1 0 0'"), "lists no node");
  expectContains(sceneFromText(scene("<ConstantForceField totalForce='1 0 0'/>")).diagnostics.text(), "all 4 nodes");
}

}  // namespace
}  // namespace stroma::test
