// SPDX-License-Identifier: LGPL-2.1-or-later
// The response of a pair of models where several could apply.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <sstream>

#include "framework/simulation/simulation.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A ball 0.3 m above a floor that it touches below 0.5 m.
std::string sceneOf(const std::string& of_ball, const std::string& of_floor, const std::string& response) {
  return fmt::format(
      "<Node name='root' dt='0.01' gravity='0 0 0'><CollisionPipeline/><MinProximityIntersection alarmDistance='1' contactDistance='0.5'/>"
      "<CollisionResponse {}/><Node name='ball'><EulerImplicitSolver/><CGLinearSolver iterations='100' tolerance='1e-14'/>"
      "<MechanicalObject position='0 0.3 0'/><UniformMass totalMass='2'/><PointCollisionModel name='ball' contactResponse='{}'/></Node>"
      "<Node name='floor'><MeshTopology position='-9 0 -9  9 0 -9  0 0 9' triangles='0 1 2'/><MechanicalObject/>"
      "<TriangleCollisionModel name='floor' simulated='0' contactResponse='{}'/></Node></Node>",
      response, of_ball, of_floor);
}

/// Penalties have a force where the step starts; conditions with friction have none there.
bool pushes(const std::string& of_ball, const std::string& of_floor, const std::string& response) {
  FieldUnderTest t(sceneOf(of_ball, of_floor, response), "CollisionResponse");
  return t.force()[0].norm() > 0;
}

const std::string penalty = "PenalityContactForceField", friction = "FrictionContactConstraint";

TEST(ContactResponses, OfOneModelOverrideThatOfTheScene) {
  EXPECT_TRUE(pushes(penalty, "", "response='" + friction + "'"));
  EXPECT_TRUE(pushes("", penalty, "response='" + friction + "'"));
  EXPECT_FALSE(pushes(friction, friction, "response='" + penalty + "'"));
}

/// The order of the scene does not decide.
TEST(ContactResponses, ThatDifferGiveTheResponseOfTheScene) {
  for (const auto& [ball, floor] : {std::pair(penalty, friction), std::pair(friction, penalty)}) {
    EXPECT_TRUE(pushes(ball, floor, "response='" + penalty + "'")) << ball;
    EXPECT_FALSE(pushes(ball, floor, "response='" + friction + "'")) << ball;
  }
}

TEST(ContactResponses, ThatDifferGiveTheFirstWhereTheSceneHasRules) {
  const std::string rules = "rules='ball floor " + friction + "'";
  EXPECT_TRUE(pushes(penalty, friction, rules));
  EXPECT_FALSE(pushes(friction, penalty, rules));
  EXPECT_FALSE(pushes("", "", rules));
}

TEST(ContactResponses, AreReadEvenWhereAnotherIsUsed) {
  expectContains(problemsOf(sceneOf(penalty, "Glue", "")), "contactResponse has \"Glue\", which is not a response");
  expectContains(problemsOf(sceneOf("Glue", penalty, "")), "contactResponse has \"Glue\", which is not a response");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
