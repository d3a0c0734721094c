// SPDX-License-Identifier: LGPL-2.1-or-later
// Contacts on the way of a step, by CCDTightInclusionIntersection.
#include "components/collision/path_contacts.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>

#include "framework/simulation/simulation.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using collision::firstNear;

double distanceAt(PairKind kind, FourPoints x, const FourPoints& way, double t) {
  for (std::size_t i = 0; i < 4; ++i) x[i] += t * way[i];
  return closestPoints(kind, x).distance();
}

/// A point that falls on a triangle, and a line on a line across it, at the speed of a step.
TEST(PathContacts, HaveTheirMoment) {
  const FourPoints point{Vec3(0.2, 1, 0.2), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 0, 1)};
  const FourPoints lines{Vec3(0.5, 1, -1), Vec3(0.5, 1, 1), Vec3(0, 0, 0), Vec3(1, 0, 0)};
  const FourPoints falls{Vec3(0, -4, 0), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  const FourPoints line_falls{Vec3(0, -4, 0), Vec3(0, -4, 0), Vec3::Zero(), Vec3::Zero()};
  EXPECT_NEAR(firstNear(PairKind::point_triangle, point, falls, 0.1), 0.225, 1e-4);
  EXPECT_NEAR(firstNear(PairKind::edge_edge, lines, line_falls, 0.1), 0.225, 1e-4);
  EXPECT_EQ(firstNear(PairKind::point_triangle, point, falls, 1.5), 0);
  EXPECT_GT(firstNear(PairKind::point_triangle, point, line_falls, 0.5), 0);  // with a corner that moves too
  EXPECT_GT(firstNear(PairKind::point_triangle, point, {Vec3(0, 4, 0), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()}, 0.1), 1);
}

/// Against the distances at many moments: none is below the contact distance before, and it is reached then.
TEST(PathContacts, MissNothing) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  int near = 0, far = 0;
  for (int i = 0; i < 4000; ++i) {
    const PairKind kind = i % 2 ? PairKind::edge_edge : PairKind::point_triangle;
    const double distance = 0.02 + 0.1 * std::abs(any(random));
    FourPoints x, way;
    for (std::size_t k = 0; k < 4; ++k)
      x[k] = Vec3(any(random), any(random), any(random)), way[k] = 2 * Vec3(any(random), any(random), any(random));
    const double t = firstNear(kind, x, way, distance);
    t > 1 ? ++far : ++near;
    for (int k = 0; k <= 200; ++k)
      if (const double at = k / 200.; at < std::min(t, 1.)) EXPECT_GT(distanceAt(kind, x, way, at), distance) << i << " at " << at;
    if (t <= 1) EXPECT_LT(distanceAt(kind, x, way, t), 1.0011 * distance + 4e-6) << i;
  }
  EXPECT_GT(near, 500);
  EXPECT_GT(far, 800);
}

/// A free triangle above a fixed one, smaller and turned so that points meet the triangle, or across its edge.
std::string scene(const std::string& type, const std::string& response, const std::string& falling, double speed) {
  return fmt::format(
      "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><CollisionPipeline/><CollisionResponse response=\"{1}\" responseParams=\"{5}\"/>"
      "<CCDTightInclusionIntersection continuousCollisionType=\"{0}\" alarmDistance=\"0.02\" contactDistance=\"0.01\"/><Node name=\"a\">"
      "<EulerImplicitSolver/><SparseLDLSolver/><MeshTopology position=\"{2}\" triangles=\"0 1 2\"/><MechanicalObject name=\"dofs\" "
      "velocity=\"0 -{3} 0  0 -{3} 0  0 -{3} 0\"/><UniformMass vertexMass=\"0.1\"/>{4}</Node><Node name=\"floor\"><MeshTopology "
      "position=\"-1 0 -1  1 0 -1  0 0 1\" triangles=\"0 1 2\"/><MechanicalObject/><TriangleCollisionModel simulated=\"0\"/>"
      "<LineCollisionModel simulated=\"0\"/><PointCollisionModel simulated=\"0\"/></Node></Node>",
      type, response, falling, speed, "<TriangleCollisionModel/><LineCollisionModel/><PointCollisionModel/>",
      response == "FrictionContactConstraint" ? "mu=0" : "");
}

/// 30 m/s is 0.3 m in a step, from 0.5 m above: it goes through, but not where contacts are found on the way.
TEST(PathContacts, StopWhatIsFast) {
  const std::string on_points = "-0.1 0.5 -0.1  0.1 0.5 -0.1  0 0.52 0.1", across = "-0.2 0.5 -0.9  -0.2 0.5 -2  0.2 0.55 -2.5";
  for (const std::string falling : {on_points, across})
    for (const std::string type : {"None", "Inertia", "FreeMotion"}) {
      Simulation simulation = simulationFromText(scene(type, "FrictionContactConstraint", falling, 30));
      for (int i = 0; i < 6; ++i) ASSERT_FALSE(simulation.step().diverged);
      const Rows x = simulation.systems()[0]->x;
      const double lowest = std::min({x[0].y(), x[1].y(), x[2].y()});
      if (falling == on_points) {
        EXPECT_EQ(lowest > 0.0099, type != "None") << type << " " << lowest;
      } else {  // over an edge of the floor: the part of the line above it does not pass
        const double above = x[0].y() + (x[1].y() - x[0].y()) * (-1 - x[0].z()) / (x[1].z() - x[0].z());
        EXPECT_EQ(above > 0.0099, type != "None") << type << " " << above;
      }
    }
}

/// A point falls at a triangle that gravity does not act on and that comes up to it: they meet only by what gravity adds to the paths, and
/// are 5 cm apart at the ends of these. However small the alarm distance, contact is found.
TEST(PathContacts, FreeMotionFindsWhatGravityAdds) {
  for (const std::string alarm : {"0.0011", "0.06"}) {
    Simulation simulation = simulationFromText(fmt::format(
        "<Node name=\"root\" dt=\"0.1\" gravity=\"0 0 -9.81\"><CollisionPipeline/><CollisionResponse "
        "response=\"FrictionContactConstraint\" responseParams=\"mu=0\"/><CCDTightInclusionIntersection "
        "continuousCollisionType=\"FreeMotion\" contactDistance=\"0.001\" alarmDistance=\"{}\"/><Node name=\"a\"><EulerImplicitSolver/>"
        "<SparseLDLSolver/><MechanicalObject position=\"0.3 0.3 0.45\" velocity=\"0 0 -2\"/><UniformMass totalMass=\"0.02\"/>"
        "<PointCollisionModel/></Node><Node name=\"b\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/><MeshTopology "
        "position=\"0 0 0  1 0 0  0 1 0\" triangles=\"0 1 2\"/><MechanicalObject velocity=\"0 0 2  0 0 2  0 0 2\"/>"
        "<UniformMass totalMass=\"0.3\"/><TriangleCollisionModel/></Node></Node>", alarm));
    ASSERT_FALSE(simulation.step().diverged);
    const Rows x = simulation.systems()[0]->x;
    EXPECT_GT(x[0].z(), 0.4 * x[1].z() + 0.3 * x[2].z() + 0.3 * x[3].z()) << alarm;
  }
}

/// Lines meet lines, and points triangles, as in SOFA.
TEST(PathContacts, AreOfPointsAndTrianglesAndOfLines) {
  const auto told = [](const std::string& models) {
    return simulationFromText(fmt::format("<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><CollisionPipeline/><CollisionResponse/>"
                                          "<CCDTightInclusionIntersection name=\"method\"/><Node name=\"a\"><EulerImplicitSolver/>"
                                          "<CGLinearSolver/><MechanicalObject position=\"0 3 0\"/><UniformMass/>{}</Node><Node name=\"b\">"
                                          "<MeshTopology position=\"-1 0 -1  1 0 -1  0 0 1\" triangles=\"0 1 2\"/><MechanicalObject/>"
                                          "<TriangleCollisionModel simulated=\"0\"/></Node></Node>", models)).diagnostics().text();
  };
  expectContains(told("<SphereCollisionModel/>"), "do not meet by /method");
  EXPECT_EQ(told("<PointCollisionModel/>").find("do not meet"), std::string::npos);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
