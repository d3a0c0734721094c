// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace {

TEST(FixedProjectiveConstraint, HoldsTheListedNodes) {
  Simulation simulation(sceneFromText(fourNodes("<FixedProjectiveConstraint indices='3 1 3'/>")));
  System& system = *simulation.systems()[0];
  ASSERT_EQ(system.constraints().projectors().size(), 2u);
  EXPECT_EQ(system.constraints().projectors()[0].row, 1);
  EXPECT_EQ(system.constraints().projectors()[1].row, 3);
  EXPECT_TRUE(system.constraints().projectors()[0].projector.isZero());
  simulation.step();
  EXPECT_EQ(Vec3(system.v[1]), Vec3(1, 2, 3)) << "a held node keeps its velocity";
}

TEST(FixedProjectiveConstraint, ProjectsVelocityAndEnds) {
  Simulation simulation(sceneFromText(
      fourNodes("<FixedProjectiveConstraint indices='1' activate_projectVelocity='1' endTime='0.015'/>")));
  System& system = *simulation.systems()[0];
  simulation.step();
  EXPECT_EQ(Vec3(system.v[1]), Vec3::Zero());
  EXPECT_EQ(Vec3(system.v[2]), Vec3(1, 2, 3));
  simulation.step();
  EXPECT_EQ(system.constraints().projectors().size(), 1u);
  system.v[1] = Vec3(4, 5, 6);
  const MatrixKey before = system.matrix().key();
  simulation.step();  // from t = 0.02
  EXPECT_TRUE(system.constraints().projectors().empty());
  EXPECT_EQ(Vec3(system.v[1]), Vec3(4, 5, 6));
  EXPECT_FALSE(system.matrix().key() == before);
}

TEST(FixedProjectiveConstraint, AStepFromItsEndIsFree) {
  Simulation simulation(sceneFromText(fourNodes("<FixedProjectiveConstraint indices='1' endTime='0.02'/>")));
  for (const std::size_t held : {1u, 1u, 0u}) {  // from t = 0, 0.01 and 0.02
    simulation.step();
    EXPECT_EQ(simulation.systems()[0]->constraints().projectors().size(), held);
  }
}

TEST(FixedProjectiveConstraint, ThatNeverHoldsIsTold) {
  const auto told = [](const std::string& end) {
    const std::string held = "<PartialFixedProjectiveConstraint indices='1' endTime='" + end + "'/>";
    Simulation simulation(sceneFromText(fourNodes(held)));
    return simulation.diagnostics().text();
  };
  expectContains(told("0"), "/PartialFixedProjectiveConstraint: no step starts before endTime");
  for (const char* end : {"-1", "0.005"}) EXPECT_EQ(told(end).find("endTime"), std::string::npos);
}

TEST(PartialFixedProjectiveConstraint, HoldsDirections) {
  Simulation simulation(sceneFromText(
      fourNodes("<PartialFixedProjectiveConstraint indices='2' fixedDirections='1 0 1' projectVelocity='true'/>")));
  System& system = *simulation.systems()[0];
  simulation.step();
  EXPECT_EQ(Vec3(system.v[2]), Vec3(0, 2, 0));
  Vector force(4);
  for (Index i = 0; i < 4; ++i) force[i] = Vec3(1, 1, 1);
  system.constraints().project(force);
  EXPECT_EQ(Vec3(force[2]), Vec3(0, 1, 0));
  EXPECT_EQ(Vec3(force[1]), Vec3(1, 1, 1));
}

TEST(Constraints, SayWhatIsWrong) {
  expectContains(problemsOf(fourNodes("<FixedProjectiveConstraint name='hold'/>")), "which nodes should be fixed");
  expectContains(problemsOf(fourNodes("<FixedProjectiveConstraint indices='1 4'/>")),
                 "indices[1] is 4, and /dofs has 4 nodes");
  expectContains(problemsOf(fourNodes("<FixedProjectiveConstraint indices='-1'/>")), "indices in 0 ... 3");
  expectContains(problemsOf(fourNodes("<FixedProjectiveConstraint indices=''/>")), "lists no node");
  expectContains(problemsOf(fourNodes("<PartialFixedProjectiveConstraint indices='1' fixedDirections='1 1'/>")),
                 "2 values");
  expectContains(sceneFromText(fourNodes("<PartialFixedProjectiveConstraint indices='1' fixedDirections='0 0 0'/>"))
                     .diagnostics.text(),
                 "selects no direction");
}

}  // namespace
}  // namespace stroma::test
