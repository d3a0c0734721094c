// SPDX-License-Identifier: LGPL-2.1-or-later
// What of contact is drawn: obstacles as closed surfaces of the right shape and place, values of nodes, forces.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <map>

#include "tests/support/scene_fixture.h"
#include "tools/drawing/contacts.h"
#include "tools/drawing/recording.h"
#include "tools/plan/plan.h"

namespace stroma::drawing {
namespace {

using test::expectContains;
using test::simulationFromText;

/// A block that lies nearer to a plane than its contact reaches, below other obstacles.
std::string scene(const std::string& type = "BarrierContact", const std::string& more = "") {
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 -9.81\"><EulerImplicitSolver newtonIterations=\"30\"/><SparseLDLSolver/>"
         "<RegularGridTopology n=\"3 3 3\" min=\"0 0 0.015\" max=\"1 1 1.015\"/><MechanicalObject name=\"dofs\"/>"
         "<UniformMass totalMass=\"10\"/><HexahedronFEMForceField youngModulus=\"1e5\" poissonRatio=\"0.3\"/>"
         "<" + type + " name=\"contact\" contactDistance=\"0.012\" planes=\"0 0 2 -0.01\" " +
         "spheres=\"3 4 5 0.5\" capsules=\"-3 0 0  -3 0 2  0.25\" boxes=\"5 5 5  6 7 8\" " + more + "/></Node>";
}

/// By the divergence theorem, positive when the faces look outwards; of the triangles whose points are near `place`.
double volumeAt(const Obstacle& obstacle, const Vec3& place, double reach) {
  double volume = 0;
  for (std::size_t t = 0; t < obstacle.solid; ++t) {
    const auto point = [&](std::size_t k) { return Vec3(obstacle.points[std::size_t(obstacle.triangles[t][k])] - place); };
    if (point(0).norm() < reach) volume += point(0).dot(point(1).cross(point(2))) / 6;
  }
  return volume;
}

TEST(Contacts, ObstaclesAreClosedAndWhereTheyAre) {
  for (const char* type : {"BarrierContact", "PenaltyContact", "ConstraintContact"}) {
    SCOPED_TRACE(type);
    Simulation simulation = simulationFromText(scene(type, "offset=\"0 0.1 0.005\" keyTimes=\"0 1\" movements=\"0 0 0  1 0 0\""));
    const Drawing drawing = drawingOf(simulation);
    ASSERT_EQ(drawing.obstacles.size(), 1u);
    const Obstacle& obstacle = drawing.obstacles.front();
    EXPECT_EQ(obstacle.owner->path(), "/contact");
    // of polyhedra with 32 sides, within what their chords leave out
    EXPECT_NEAR(volumeAt(obstacle, Vec3(3, 4, 5), 1) / (4 * M_PI / 3 * 0.125), 0.985, 0.015);
    EXPECT_NEAR(volumeAt(obstacle, Vec3(-3, 0, 1), 2) / (M_PI * 0.0625 * 2 + 4 * M_PI / 3 * 0.015625), 0.985, 0.015);
    EXPECT_NEAR(volumeAt(obstacle, Vec3(5.5, 6, 6.5), 3), 6, 1e-12);
    std::map<std::pair<Index, Index>, int> sides;
    for (std::size_t t = 0; t < obstacle.solid; ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& triangle = obstacle.triangles[t];
        const Index a = triangle[k], b = triangle[(k + 1) % 3];
        if ((obstacle.points[std::size_t(a)] - obstacle.points[std::size_t(b)]).norm() > 1e-9)
          sides[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
      }
    int open = 0;
    for (const auto& [side, turns] : sides) open += turns != 0 && (obstacle.points[std::size_t(side.first)] - Vec3(5.5, 6, 6.5)).norm() < 3;
    EXPECT_EQ(open, 0) << "sides of the box that one triangle has";
    for (std::size_t t = obstacle.solid; t < obstacle.triangles.size(); ++t)
      for (const Index point : obstacle.triangles[t]) EXPECT_NEAR(obstacle.points[std::size_t(point)].z(), -0.005, 1e-12);
    EXPECT_EQ(obstacle.triangles.size() - obstacle.solid, 2u) << "a square for the plane";
    EXPECT_EQ(obstacle.drawn->shapesMovedBy(), Vec3(0, 0.1, 0.005));
  }
}

TEST(Contacts, NodesHaveValuesAndForcesAfterAStep) {
  Simulation simulation = simulationFromText(scene("BarrierContact", "offset=\"0 0 0.01\""));
  const Drawing drawing = drawingOf(simulation);
  ASSERT_EQ(drawing.contacts.size(), 1u);
  EXPECT_EQ(drawing.contacts[0].bodies, std::vector<std::string>{"/dofs"});
  const auto called = [&](const std::string& name) -> const Field& {
    for (const Field& field : drawing.fields)
      if (field.name == name) return field;
    throw std::runtime_error("no field " + name);
  };
  std::vector<float> values;
  EXPECT_FALSE(nodeValues(called("pressures"), drawing.bodies[0], values)) << "before the first step";
  simulation.step();
  ASSERT_TRUE(nodeValues(called("pressures"), drawing.bodies[0], values));
  EXPECT_EQ(unitOf(called("pressures")), "Pa");
  EXPECT_EQ(unitOf(called("contactStates")), "-");
  const Body& body = drawing.bodies[0];
  int pushed = 0;
  for (std::size_t page = 0; page < values.size(); ++page) {
    const bool is_low = body.state->rest_position[std::size_t(body.node[page])].z() < 0.02;
    EXPECT_EQ(values[page] > 0, is_low) << "node " << body.node[page];
    pushed += values[page] > 0;
  }
  EXPECT_EQ(pushed, 9);
  const ContactForces forces = forcesOf(drawing.contacts[0], drawing);
  Vec3 sum = Vec3::Zero();
  for (const Vec3& force : forces.forces) sum += force;
  EXPECT_EQ(forces.pages.size(), 9u);
  EXPECT_LT((sum - (*vectorsOf(*drawing.contacts[0].owner, "wrenches"))[0]).norm(), 1e-12 * sum.norm());
  EXPECT_GT(sum.z(), 1);
}

/// What was computed at an instant comes back with it.
TEST(Contacts, AnInstantBringsBackWhatWasComputed) {
  Simulation simulation = simulationFromText(scene("BarrierContact", "offset=\"0 0 0.01\""));
  const std::vector<Component*> components = withNodeValues(simulation);
  ASSERT_EQ(components.size(), 1u);
  Recording recording(simulation.states().size() + 1);
  std::vector<std::map<std::string, std::vector<double>>> all;
  for (int instant = 0; instant < 3; ++instant) {
    if (instant > 0) simulation.step();
    for (std::size_t i = 0; i < simulation.states().size(); ++i) {
      StateFrame& frame = recording[i].emplace_back();
      for (Index row = 0; row < simulation.states()[i]->size(); ++row) frame.x.push_back(simulation.states()[i]->x()[row]);
    }
    recording.back().emplace_back().values = valuesOf(*components[0]);
    all.push_back(valuesOf(*components[0]));
  }
  ASSERT_NE(all[1].at("pressures"), all[2].at("pressures"));
  for (const std::size_t instant : {1u, 0u, 2u}) {
    showInstant(simulation, recording, instant);
    EXPECT_EQ(valuesOf(*components[0]), all[instant]) << instant;
  }
}

TEST(Contacts, AFileKeepsWhatWasComputedToTheBit) {
  EXPECT_EQ(valuesFileName("/body/contact"), "body.contact.values.gz");
  const auto folder = std::filesystem::temp_directory_path() / ("stroma_values_" + std::to_string(::getpid()));
  const std::string file = (folder / valuesFileName("/contact")).string();
  const std::vector<double> numbers{1.0 / 3, -2e-300, 0, 7};
  {
    StateWriter writer(file);
    for (const double t : {0.0, 0.1}) writer.time(t), writer.values("gaps", numbers), writer.values("pressures", {}), writer.finish();
    writer.close();
  }
  const std::vector<StateFrame> frames = readStateFile(file);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[1].time, 0.1);
  EXPECT_EQ(frames[1].values.at("gaps"), numbers);
  EXPECT_TRUE(frames[1].values.at("pressures").empty());
  EXPECT_TRUE(frames[1].x.empty());
  std::filesystem::remove_all(folder);
}

TEST(Contacts, ThePlanSaysWhatMatters) {
  const auto linesOf = [](const std::string& type, const std::string& more) {
    std::string text;
    for (const std::string& line : planOf(simulationFromText(scene(type, more))).lines()) text += line + "\n";
    return text;
  };
  expectContains(linesOf("BarrierContact", "friction=\"0.3\" staticFriction=\"0.4\" stiffness=\"2e4\""),
                 "/dofs and 4 obstacles, each body with itself too, which push below a gap of 0.012 m with a stiffness of 2e+04 Pa, static "
                 "friction 0.4, friction 0.3");
  expectContains(linesOf("PenaltyContact", "selfContact=\"false\""),
                 "/dofs and 4 obstacles, which push below a gap of 0.012 m with a stiffness of 1e+04 Pa");
  expectContains(linesOf("ConstraintContact", "friction=\"0.3\""), "/dofs and 4 obstacles, which keep a gap of 0.012 m, friction 0.3");
}

}  // namespace
}  // namespace stroma::drawing
