// SPDX-License-Identifier: LGPL-2.1-or-later
// Points and frames that are put somewhere, by a way or a force, against the closed forms of springs.
#include "framework/mechanics/frames.h"
#include "tests/lagrangian/lagrangian_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using namespace lagrangian;

/// Two points of springs of 100 N/m are pushed by 0.1 m along y: 10 N each, and the other way round, with any step.
TEST(PutSomewhere, PointsArePutSomewhereByAWayOrAForce) {
  for (const double dt : {1e-1, 1e-2})
    for (const char* type : {"displacement", "force"}) {
      SCOPED_TRACE(fmt::format("{}, dt {}", type, dt));
      Simulation simulation = simulationFromText(sceneOf(
          fmt::format("<MechanicalObject position=\"0 0 0  1 0 0  2 0 0\"/><UniformMass totalMass=\"3\"/>"
                      "<RestShapeSpringsForceField stiffness=\"100\"/><PositionConstraint indices=\"2 1\" useDirections=\"0 1 0\" "
                      "valueType=\"{}\" value=\"{}\"/>",
                      type, type[0] == 'd' ? 0.1 : 10),
          dt, "0 0 0", "<EulerImplicitSolver rayleighMass=\"10\"/>"));
      run(simulation, int(std::lround(4 / dt)));
      for (const double force : numbersOf(simulation, "PositionConstraint", "forces")) EXPECT_NEAR(force, 10, 1e-6);
      EXPECT_NEAR(numberOf(simulation, "PositionConstraint", "force"), 10, 1e-6);
      EXPECT_NEAR(numberOf(simulation, "PositionConstraint", "displacement"), 0.1, 1e-8);
      EXPECT_NEAR(at(simulation, 2).y(), 0.1, 1e-8);
      EXPECT_NEAR(at(simulation, 1).y(), 0.1, 1e-8);
      EXPECT_EQ(at(simulation, 0).y(), 0);
    }
}

/// A bound of the force holds a point of springs of 100 N/m at 4 N back at 0.04 m, and a bound of the way one that is pushed by
/// 10 N at 0.05 m.
TEST(PutSomewhere, PointsArePutWithinBounds) {
  const auto put = [](const char* attributes) {
    Simulation simulation = simulationFromText(
        sceneOf(fmt::format("<MechanicalObject position='0 0 0'/><UniformMass totalMass='1'/><RestShapeSpringsForceField "
                            "stiffness='100'/><PositionConstraint useDirections='0 0 1' {}/>", attributes),
                0.01, "0 0 0", "<EulerImplicitSolver rayleighMass='10'/>"));
    run(simulation, 400);
    return std::pair(at(simulation, 0).z(), numberOf(simulation, "PositionConstraint", "force"));
  };
  const auto by_force = put("value='0.1' maxForce='4'"), by_way = put("valueType='force' value='10' maxPositiveDisp='0.05'");
  EXPECT_NEAR(by_force.first, 0.04, 1e-8);
  EXPECT_NEAR(by_force.second, 4, 1e-9);
  EXPECT_NEAR(by_way.first, 0.05, 1e-8);
  EXPECT_NEAR(by_way.second, 5, 1e-6);
}

/// Directions that are not square to each other; after a reset it starts again to the bit: places are those of the start.
TEST(PutSomewhere, PointsThatArePutStartAgain) {
  const std::string scene = sceneOf("<MechanicalObject position='0 0 0  1 0 0'/><UniformMass totalMass='2'/><RestShapeSpringsForceField "
                                    "stiffness='100'/><PositionConstraint indices='1' directions='1 1 0  0 1 0  0 0 1' value='0.1'/>",
                                    0.01, "0 -10 0");
  Simulation simulation = simulationFromText(scene);
  run(simulation, 5);
  const Vec3 there = at(simulation, 1);
  const double s = 0.1 * std::sqrt(2.0) - 0.1;
  EXPECT_NEAR((there - Vec3(1 + s, 0.1, 0.1)).norm(), 0, 1e-9);
  simulation.reset();
  run(simulation, 5);
  EXPECT_EQ(at(simulation, 1), there);
}

/// What is wrong with its directions is told.
TEST(PutSomewhere, PointsArePutAlongThreeDirections) {
  const auto why = [](const char* attributes) {
    return problemsOf(
        sceneOf(fmt::format("<MechanicalObject position='0 0 0'/><UniformMass totalMass='1'/><PositionConstraint {}/>", attributes)));
  };
  EXPECT_NE(why("useDirections='0 1'").find("useDirections has 2 entries"), std::string::npos);
  EXPECT_NE(why("useDirections='0 0 0'").find("useDirections selects no direction"), std::string::npos);
  EXPECT_NE(why("weight='1 2'").find("weight has 2 numbers"), std::string::npos);
  EXPECT_NE(why("indices=''").find("indices names no point"), std::string::npos);
  EXPECT_NE(why("weight='0'").find("entry 0 of directions has no length or no weight"), std::string::npos);
  EXPECT_NE(why("indices='7'").find("indices names node 7"), std::string::npos);
}

/// A frame on springs of 100 N/m and 20 N m with what is held by `held`, after 10 s.
struct Frame {
  Vec3 centre, turn;
  double force;
  std::vector<double> ways;
};

Frame frame(const std::string& held, double dt = 0.01, const std::string& more = "") {
  Simulation simulation = simulationFromText(
      sceneOf("<MechanicalObject template='Rigid3' position='1 2 3 0 0 0 1'" + more + "/><UniformMass totalMass='1' inertia='1 1 1'/>"
              "<RestShapeSpringsForceField stiffness='100' angularStiffness='20'/>" + held, dt, "0 0 0",
              "<EulerImplicitSolver rayleighMass='10'/>"));
  run(simulation, int(std::lround(10 / dt)));
  return {at(simulation, 0), rotationVector(orientationIn(simulation.states()[0]->x(), 1)),
          numberOf(simulation, "PositionConstraint", "force"), numbersOf(simulation, "PositionConstraint", "delta")};
}

/// From where they start, frames are moved as points are, and turned by 0.3 rad about z with 6 N m.
TEST(PutSomewhere, FramesAreMovedAndTurned) {
  for (const double dt : {1e-1, 1e-2})
    for (const char* value : {"value='0.3'", "valueType='force' value='6'"}) {
      SCOPED_TRACE(fmt::format("{}, dt {}", value, dt));
      const Frame turned = frame(fmt::format("<PositionConstraint useDirections='0 0 0 0 0 1' {}/>", value), dt);
      EXPECT_NEAR(turned.force, 6, 1e-6);
      EXPECT_NEAR((turned.turn - Vec3(0, 0, 0.3)).norm(), 0, 1e-8);
      EXPECT_NEAR((turned.centre - Vec3(1, 2, 3)).norm(), 0, 1e-8);
    }
  const Frame moved = frame("<PositionConstraint weight='2 2 2 1 1 1' useDirections='0 1 0 0 0 0' value='0.1'/>");
  EXPECT_NEAR((moved.centre - Vec3(1, 2.05, 3)).norm(), 0, 1e-8);
  EXPECT_NEAR(moved.force, 2.5, 1e-6);
}

/// All six at once: `delta` has the ways of all, and the rotation vector is what is written also where it is long.
TEST(PutSomewhere, FramesAreHeldInAllDirections) {
  const Frame held = frame("<PositionConstraint value='0.7'/>");
  EXPECT_NEAR((held.turn - Vec3(0.7, 0.7, 0.7)).norm(), 0, 1e-8);
  EXPECT_NEAR((held.centre - Vec3(1.7, 2.7, 3.7)).norm(), 0, 1e-8);
  ASSERT_EQ(held.ways.size(), 6u);
  for (const double way : held.ways) EXPECT_NEAR(way, 0.7, 1e-8);
}

/// A frame that is turned far about x and pushed about y by f: its torque has the work f ds. It comes to rest where the energy of springs
/// that rest elsewhere, less f s, is least; found here by halving steps, with nothing but rotation vectors.
TEST(PutSomewhere, ATorqueHasTheWorkOfItsWay) {
  const Quaternion rest = turnedBy(Vec3(0.5, -0.3, 0.8));
  const auto energy = [&](double y, double z) {
    return 10 * rotationVector(turnedBy(Vec3(1.2, y, z)) * rest.conjugate()).squaredNorm() - 8 * y;
  };
  double y = 0, z = 0;
  for (double h = 0.5; h > 1e-9;) {
    const double here = energy(y, z);
    if (energy(y + h, z) < here) y += h;
    else if (energy(y - h, z) < here) y -= h;
    else if (energy(y, z + h) < here) z += h;
    else if (energy(y, z - h) < here) z -= h;
    else h /= 2;
  }
  const Frame both = frame("<PositionConstraint useDirections='0 0 0 1 0 0' value='1.2'/>"
                           "<PositionConstraint useDirections='0 0 0 0 1 0' valueType='force' value='8'/>", 0.01,
                           fmt::format(" rest_position='1 2 3 {} {} {} {}'", rest.x(), rest.y(), rest.z(), rest.w()));
  EXPECT_NEAR((both.turn - Vec3(1.2, y, z)).norm(), 0, 1e-6);
  EXPECT_GT(std::abs(z), 0.1);  // turns about the axes do not stand alone
}

/// A frame's directions have six numbers, its halves of any length: screws of 1 m for 1 rad.
TEST(PutSomewhere, AFrameScrews) {
  const Frame screwed =
      frame("<PositionConstraint directions='0 0 5 0 0 2  0 1 0 0 0 0  1 0 0 0 0 0  0 0 0 1 0 0  0 0 0 0 1 0  0 0 0 0 0 1' "
            "useDirections='1 0 0 0 0 0' valueType='force' value='4'/>");
  EXPECT_NEAR(screwed.centre.z(), 3 + 4.0 / 100, 1e-8);
  EXPECT_NEAR(screwed.turn.z(), 4.0 / 20, 1e-8);
}

/// A run that goes on from a checkpoint has the bits of one that never stopped, and what is told can be read at once.
TEST(PutSomewhere, ItGoesOnFromACheckpoint) {
  const std::string scene =
      sceneOf("<MechanicalObject template='Rigid3' position='1 2 3 0 0 0 1'/><UniformMass totalMass='1' inertia='1 1 1'/>"
              "<RestShapeSpringsForceField stiffness='100' angularStiffness='20'/>"
              "<PositionConstraint useDirections='0 1 0 0 0 1' value='0.2' maxForce='1000'/>");
  Simulation whole = simulationFromText(scene);
  run(whole, 5);
  Simulation restored = simulationFromText(scene);
  restored.restore(whole.checkpoint());
  for (const char* name : {"forces", "force", "displacement", "delta"})
    EXPECT_EQ(numbersOf(restored, "PositionConstraint", name), numbersOf(whole, "PositionConstraint", name)) << name;
  run(whole, 5), run(restored, 5);
  EXPECT_EQ(restored.stateHash(), whole.stateHash());
}

/// What is wrong with the directions of frames is told.
TEST(PutSomewhere, FramesHaveSixDirections) {
  const auto why = [](const char* attributes) {
    return problemsOf(sceneOf(fmt::format("<MechanicalObject template='Rigid3' position='0 0 0 0 0 0 1'/><UniformMass totalMass='1' "
                                          "inertia='1 1 1'/><PositionConstraint {}/>", attributes)));
  };
  EXPECT_NE(why("useDirections='0 1 0'").find("useDirections has 3 entries (expected six"), std::string::npos);
  EXPECT_NE(why("directions='1 0 0 0 1 0 0 0 1'").find("directions has 9 numbers (expected six directions of 6 numbers"),
            std::string::npos);
  EXPECT_NE(why("weight='1 2 3'").find("weight has 3 numbers"), std::string::npos);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
