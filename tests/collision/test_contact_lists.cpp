// SPDX-License-Identifier: LGPL-2.1-or-later
// Contacts as SOFA lists them: their order by hand for a few points, and what its filters leave.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <sstream>

#include "framework/simulation/simulation.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Model, part, model, part of each contact of a body of points over `floor`.
std::vector<std::array<int, 4>> contactsOf(const std::string& points, const std::string& floor, const std::string& response) {
  const std::string scene = fmt::format(
      "<Node name='root' dt='0.01' gravity='0 0 0'><CollisionPipeline/><MinProximityIntersection alarmDistance='1' contactDistance='0.5'/>"
      "<CollisionResponse {}/><Node name='body'><EulerImplicitSolver/><CGLinearSolver iterations='100' tolerance='1e-14'/>"
      "<MechanicalObject position='{}'/><UniformMass totalMass='2'/><PointCollisionModel/></Node>"
      "<Node name='floor'><MeshTopology {}/><MechanicalObject/><TriangleCollisionModel simulated='0'/></Node></Node>",
      response, points, floor);
  FieldUnderTest t(scene, "CollisionResponse");
  t.force();
  std::istringstream numbers(t.field().data().find("pairs")->print());
  std::vector<std::array<int, 4>> pairs;
  for (std::array<int, 4> each{}; numbers >> each[0] >> each[1] >> each[2] >> each[3];) pairs.push_back(each);
  return pairs;
}

const std::string triangle = "position='-9 0 -9  9 0 -9  0 0 9' triangles='0 1 2'";
const std::string six = "0.3 0.2 0  0 0.2 0  0.5 0.2 0  0.1 0.2 0  0.4 0.2 0  0.2 0.2 0";

/// Six boxes along x are sorted and halved: {1 3 5} and {0 4 2}. Of two waiting cells the last one comes first.
TEST(ContactLists, ComeInTheOrderOfTheTrees) {
  std::vector<int> points;
  for (const auto& pair : contactsOf(six, triangle, "sofaLists='1'")) points.push_back(pair[3]);
  EXPECT_EQ(points, (std::vector<int>{0, 4, 2, 1, 3, 5}));
}

/// Cells of four are not cut, and with no depth nothing is: the order of the mesh.
TEST(ContactLists, AreOfTheMeshWhereNothingIsCut) {
  std::vector<int> points;
  for (const auto& pair : contactsOf(six, triangle, "sofaLists='1' treeDepth='0'")) points.push_back(pair[3]);
  EXPECT_EQ(points, (std::vector<int>{0, 1, 2, 3, 4, 5}));
}

/// A point between two triangles: penalties keep the nearer one, where native contacts push from both.
TEST(ContactLists, KeepTheNearestOfAPoint) {
  const std::string two = "position='-9 0 -9  9 0 -9  0 0 9  -9 0.5 -9  9 0.5 -9  0 0.5 9' triangles='0 1 2  3 4 5'";
  const auto kept = contactsOf("0 0.3 0", two, "sofaLists='1'"), all = contactsOf("0 0.3 0", two, "");
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0][1], 1) << "0.2 m below the second triangle, 0.3 m above the first";
  EXPECT_EQ(all.size(), 2u);
}

/// Two rows of points that slide on a floor and into each other, with the first contacts where the run starts.
Simulation sliding() {
  const auto body = [](const char* name, const char* points, const char* velocity, const char* models) {
    return fmt::format(
        "<Node name='{}'><EulerImplicitSolver newtonIterations='1' oneRound='true'/><SparseLDLSolver/><MechanicalObject position='{}' "
        "velocity='{}'/><UniformMass vertexMass='0.5'/><SpringForceField springsIndices1='0 1' springsIndices2='1 2' lengths='0.5 0.5' "
        "stiffness='80'/>{}</Node>",
        name, points, velocity, models);
  };
  return simulationFromText(
      "<Node name='root' dt='0.01' gravity='0 -9.81 0'><CollisionPipeline/><MinProximityIntersection alarmDistance='0.15' "
      "contactDistance='0.1'/><CollisionResponse response='FrictionContactConstraint' responseParams='mu=0.3' sofaLists='true'/>"
      "<ConstraintSweeps maxIterations='2' tolerance='1e-9' keepsUnsettled='true' resolutionMethod='NonlinearComplementarity' "
      "keepsContactForces='true'/>" +
      body("low", "0 0.1 0  0.5 0.11 0.1  1 0.1 0", "1 -0.2 0  1 -0.2 0  1 -0.2 0", "<PointCollisionModel/>") +
      body("high", "1.1 0.12 0.1  1.5 0.25 0  2 0.2 0.1", "-1 0 0  -1 0 0  -1 0 0", "<SphereCollisionModel radius='0.05'/>") +
      "<Node name='floor'><MeshTopology " + triangle + "/><MechanicalObject/><TriangleCollisionModel simulated='0'/></Node></Node>");
}

/// Sweeps begin with the forces of contacts that were there before: which these are is the same however a run has come to a step.
TEST(ContactLists, AreTheSameAfterAResetAndACheckpoint) {
  Simulation whole = sliding(), parted = sliding();
  std::vector<std::uint64_t> hashes;
  for (int step = 0; step < 40; ++step) {
    ASSERT_FALSE(whole.step().failed());
    hashes.push_back(whole.stateHash());
  }
  whole.reset();
  for (int step = 0; step < 40; ++step) {
    if (step % 3 == 0) parted.restore(whole.checkpoint().readable());
    whole.step(), parted.step();
    ASSERT_EQ(whole.stateHash(), hashes[std::size_t(step)]) << "after a reset, step " << step;
    ASSERT_EQ(parted.stateHash(), hashes[std::size_t(step)]) << "from a checkpoint, step " << step;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
