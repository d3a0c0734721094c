// SPDX-License-Identifier: LGPL-2.1-or-later
// The filter of LocalMinDistance: which directions edges and corners of a known shape keep, and what slides over flat ones.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "framework/simulation/simulation.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// What a point at `place` meets of an obstacle: contacts that push in the first step.
int contactsAt(const Vec3& place, const std::string& mesh, const std::string& models, const std::string& method) {
  Simulation simulation = simulationFromText(fmt::format(
      "<Node name=\"root\" dt=\"1e-6\" gravity=\"0 0 0\"><CollisionPipeline/><CollisionResponse name=\"response\"/>{}<Node name=\"a\">"
      "<EulerImplicitSolver/><CGLinearSolver iterations=\"50\" tolerance=\"1e-12\"/><MechanicalObject position=\"{} {} {}\"/>"
      "<UniformMass totalMass=\"1\"/><PointCollisionModel group=\"1\"/></Node><Node name=\"floor\"><MeshTopology {}/>"
      "<MechanicalObject/>{}</Node></Node>",
      method, place.x(), place.y(), place.z(), mesh, models));
  EXPECT_FALSE(simulation.step().failed());
  std::vector<Component*> components;
  simulation.root().collect(components);
  for (const Component* component : components)
    if (component->type() == "CollisionResponse") return std::stoi(component->data().find("contacts")->print());
  return -1;
}

std::string minimumDistance(double factor, double angle, const std::string& more = "") {
  return fmt::format("<LocalMinDistance alarmDistance=\"0.5\" contactDistance=\"0.4\" coneFactor=\"{}\" angleCone=\"{}\" {}/>", factor,
                     angle, more);
}

/// Slopes of a roof or a valley, and what widens the cones.
struct Slope {
  double rise, factor, angle;
  double beta() const { return std::atan(rise); }
  /// Largest angle of the direction from the vertical: sin(beta - phi) >= -(c max(0, sin beta) + a).
  double last() const { return beta() + std::asin(factor * std::max(0.0, std::sin(beta())) + angle); }
};
const Slope slopes[] = {{0.5, 0.5, 0}, {0.5, 0, 0}, {1, 0.5, 0.1}, {0.2, 1, 0}, {0, 0.5, 0}, {0, 0.5, 0.05}, {-0.1, 0.5, 0.2}};

/// Between two faces that fall by `rise` to both sides the ridge keeps directions up to a known angle.
TEST(NormalCones, ARidgeKeepsWhatLiesBetweenItsFaces) {
  const std::string line = "<LineCollisionModel simulated=\"0\"/>";
  for (const Slope& slope : slopes)
    for (const double side : {1.0, -1.0}) {
      SCOPED_TRACE(fmt::format("rise {}, factor {}, angle {}", slope.rise, slope.factor, slope.angle));
      const std::string roof = fmt::format("position=\"0 0 -1  0 0 1  1 {0} 0  -1 {0} 0\" triangles=\"0 1 2  1 0 3\" edges=\"0 1\"",
                                           -slope.rise);
      const auto at = [&](double phi) {
        return contactsAt(0.3 * Vec3(side * std::sin(phi), std::cos(phi), 0), roof, line, minimumDistance(slope.factor, slope.angle));
      };
      EXPECT_EQ(at(std::max(0.0, slope.last() - 1e-4)), 1);
      EXPECT_EQ(at(slope.last() + 1e-4), 0);
    }
}

/// The same of a corner between four faces, where lines stand by; alone, points take every direction.
TEST(NormalCones, ACornerKeepsWhatLiesBetweenItsEdges) {
  for (const Slope& slope : slopes) {
    SCOPED_TRACE(fmt::format("rise {}, factor {}, angle {}", slope.rise, slope.factor, slope.angle));
    const std::string pyramid = fmt::format("position=\"0 0 0  1 {0} 0  0 {0} 1  -1 {0} 0  0 {0} -1\" "
                                            "triangles=\"0 2 1  0 3 2  0 4 3  0 1 4\"", -slope.rise);
    const auto at = [&](double phi, const std::string& more) {
      return contactsAt(0.3 * Vec3(std::sin(phi), std::cos(phi), 0), pyramid, "<PointCollisionModel simulated=\"0\"/>" + more,
                        minimumDistance(slope.factor, slope.angle));
    };
    const std::string lines = "<LineCollisionModel simulated=\"0\" group=\"1\"/>";  // which the point does not meet
    EXPECT_EQ(at(std::max(0.0, slope.last() - 1e-4), lines), 1);
    EXPECT_EQ(at(slope.last() + 1e-4, lines), 0);
    EXPECT_EQ(at(slope.last() + 1e-4, ""), 1);
  }
}

/// Two faces of a floor leave out a strip of a millionth of their size beside the edge between them, and the edge does so at its ends.
TEST(NormalCones, NothingFallsThroughBetweenTwoFaces) {
  const std::string floor = "position=\"0 0 0  4 0 0  4 0 4  0 0 4\" triangles=\"0 2 1  0 3 2\"";
  const std::string models = "<TriangleCollisionModel simulated=\"0\"/><LineCollisionModel simulated=\"0\"/><PointCollisionModel "
                             "simulated=\"0\"/>";
  for (const double along : {2.0, 1e-3, 3e-6, 1e-6, 0.0})
    for (const double beside : {0.0, 1e-12, 1e-9, 1e-7, 1e-6, 3e-6, 4.1e-6, 1e-5, 1e-3})
      for (const double side : {1.0, -1.0}) {
        const Vec3 place(along + std::max(side, 0.0) * beside, 0.2, along + std::max(-side, 0.0) * beside);
        EXPECT_GE(contactsAt(place, floor, models, minimumDistance(0.5, 0)), 1) << along << ' ' << side * beside;
      }
}

/// The same where neither lines nor points stand: one of the faces takes it, with every method, and where they do stand nothing is
/// taken twice. Beside the rim of the floor there is nothing.
TEST(NormalCones, NothingFallsThroughWhereNoLineStands) {
  const std::string floor = "position=\"0 0 0  4 0 0  4 0 4  0 0 4\" triangles=\"0 2 1  0 3 2\"";
  const std::string top = "<TriangleCollisionModel simulated=\"0\"/>";
  for (const std::string method : {"LocalMinDistance", "MinProximityIntersection", "NewProximityIntersection"})
    for (const double along : {2.0, 1e-3, 0.0})
      for (const double beside : {0.0, 1e-9, 1e-6, 3e-6, 1e-5, 1e-3}) {
        SCOPED_TRACE(fmt::format("{} {} {}", method, along, beside));
        const std::string near = fmt::format("<{} alarmDistance=\"0.5\" contactDistance=\"0.4\"/>", method);
        const auto at = [&](const std::string& models) { return contactsAt(Vec3(along + beside, 0.2, along), floor, models, near); };
        EXPECT_EQ(at(top), 1);
        if (along == 2 && beside == 0) EXPECT_EQ(at(top + "<LineCollisionModel simulated=\"0\"/>"), 1);
      }
  EXPECT_EQ(contactsAt(Vec3(2, 0.2, -1e-3), floor, top, minimumDistance(0.5, 0)), 0);
}

/// Over a flat floor of two triangles, beside the edge between them: with the filter it is the face alone that meets, from its
/// outer side; over the edge the edge.
TEST(NormalCones, AFlatFloorMeetsAlongItsNormalAlone) {
  const std::string floor = "position=\"0 0 0  4 0 0  4 0 4  0 0 4\" triangles=\"0 2 1  0 3 2\"";
  const auto contacts = [&](const Vec3& place, const std::string& more, const std::string& side = "") {
    std::string models;
    for (const char* kind : {"Triangle", "Line", "Point"}) models += fmt::format("<{}CollisionModel simulated=\"0\" {}/>", kind, side);
    return contactsAt(place, floor, models, minimumDistance(0.5, 0, more));
  };
  const Vec3 beside(2, 0.2, 2.3), over(2, 0.2, 2), below(2, -0.2, 2.3);
  EXPECT_EQ(contacts(beside, ""), 1);
  EXPECT_EQ(contacts(over, ""), 1);
  EXPECT_EQ(contacts(below, ""), 0);
  EXPECT_EQ(contacts(below, "", "bothSide=\"1\""), 1);
  for (const char* off : {"filterIntersection=\"0\"", "useLMDFilters=\"1\""}) {
    EXPECT_EQ(contacts(beside, off), 2) << off;
    EXPECT_EQ(contacts(below, off), 2) << off;
  }
}

std::string gridOf(int cells, double size) {
  std::string positions, triangles;
  for (int i = 0; i <= cells; ++i)
    for (int j = 0; j <= cells; ++j) {
      positions += fmt::format("{} 0 {}  ", i * size - 1.03, j * size - 1.07);
      const int at = i * (cells + 1) + j, next = at + cells + 1;
      if (i < cells && j < cells) triangles += fmt::format("{} {} {}  {} {} {}  ", at, at + 1, next + 1, at, next + 1, next);
    }
  return "position=\"" + positions + "\" triangles=\"" + triangles + "\"";
}

/// A rigid box with all its models slides on a floor of many triangles: with v = v_0 - mu g t, as on a plane, and stays upright.
TEST(NormalCones, ABoxSlidesOverTheEdgesOfAFlatFloor) {
  for (const double mu : {0.0, 0.4}) {
    SCOPED_TRACE(mu);
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="0.01" gravity="0 -9.81 0"><CollisionPipeline/>
          <LocalMinDistance alarmDistance="0.12" contactDistance="0.04"/>
          <CollisionResponse response="FrictionContactConstraint" responseParams="mu={}"/><Node name="box"><EulerImplicitSolver/>
          <SparseLDLSolver/><MechanicalObject template="Rigid3" position="0 0.24 0 0 0 0 1" velocity="2 0 0 0 0 0"/>
          <UniformMass totalMass="3" inertia="0.08 0.08 0.08"/><Node name="skin"><MeshTopology position="-0.2 -0.2 -0.2  0.2 -0.2 -0.2
          0.2 -0.2 0.2  -0.2 -0.2 0.2  -0.2 0.2 -0.2  0.2 0.2 -0.2  0.2 0.2 0.2  -0.2 0.2 0.2" triangles="0 1 2  0 2 3  4 6 5  4 7 6
          0 5 1  0 4 5  1 6 2  1 5 6  2 7 3  2 6 7  3 4 0  3 7 4"/><MechanicalObject/><TriangleCollisionModel/><LineCollisionModel/>
          <PointCollisionModel/><RigidMapping/></Node></Node><Node name="floor"><MeshTopology {}/><MechanicalObject/>
          <TriangleCollisionModel simulated="0"/><LineCollisionModel simulated="0"/><PointCollisionModel simulated="0"/></Node></Node>)",
        mu, gridOf(24, 0.1)));
    const State& box = *simulation.states()[0];
    for (int i = 1; i <= 25; ++i) {
      ASSERT_FALSE(simulation.step().failed()) << i;
      EXPECT_NEAR((box.v()[0] - Vec3(2 - mu * 9.81 * 0.01 * i, 0, 0)).norm(), 0, 1e-9) << i;
      EXPECT_NEAR(box.v()[1].norm(), 0, 1e-9) << i;
      EXPECT_NEAR(box.x()[0].y(), 0.24, 1e-10) << i;
    }
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
