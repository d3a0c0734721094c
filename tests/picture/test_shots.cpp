// SPDX-License-Identifier: LGPL-2.1-or-later
// What a picture is made of: the field that suits the scene, values at nodes and cells, ranges, what is hidden.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/scene_fixture.h"
#include "tools/picture/shots.h"

namespace stroma::picture {
namespace {

using test::simulationFromText;

std::string block(const std::string& more = "") {
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -9.81 0\"><Node "
         "name=\"block\"><EulerImplicitSolver/><CGLinearSolver/>"
         "<RegularGridTopology name=\"grid\" n=\"4 3 5\" min=\"0 0 0\" max=\"3 2 4\"/><MechanicalObject name=\"dofs\"/>"
         "<UniformMass totalMass=\"1\"/><HexahedronFEMForceField youngModulus=\"1000\" poissonRatio=\"0.3\"/>"
         "<FixedProjectiveConstraint indices=\"0 1 2 3\"/>" +
         more + "</Node></Node>";
}

TEST(Shots, TheFieldIsTheStressWhereThereIsOne) {
  Simulation simulation = simulationFromText(block());
  const PictureRequest request;
  EXPECT_EQ(ShotTaker(simulation, request).field(), "vonMises");
  const Simulation points = simulationFromText(
      "<Node name=\"root\"><EulerExplicitSolver/><MechanicalObject position=\"0 0 0  1 0 0\"/><UniformMass "
      "totalMass=\"1\"/></Node>");
  EXPECT_EQ(ShotTaker(points, request).field(), "displacement");
}

TEST(Shots, ValuesAtNodesAreTheMeansOfTheCellsAround) {
  Simulation simulation = simulationFromText(block());
  for (int i = 0; i < 3; ++i) simulation.step();
  PictureRequest request;
  request.field = "vonMises";
  ShotTaker taker(simulation, request);
  const Shot shot = taker.take(simulation.time());
  const drawing::Body& body = taker.drawing().bodies.at(0);
  std::vector<double> cells;
  for (const drawing::Field& field : taker.drawing().fields)
    if (field.name == "vonMises") field.source->cellField("vonMises", simulation.systems()[0]->x, cells);
  ASSERT_EQ(shot.bodies.at(0).values.size(), std::size_t(body.surface));
  double largest = 0;
  for (Index page = 0; page < body.surface; ++page) {
    double sum = 0, count = 0;
    for (std::size_t c = 0; c < cells.size(); ++c)
      for (const Index node : body.mesh->hexahedra[c])
        if (node == body.node[std::size_t(page)]) sum += cells[c], ++count;
    EXPECT_NEAR(shot.bodies[0].values[std::size_t(page)], sum / count, 1e-5 * sum / count);
    largest = std::max(largest, sum / count);
  }
  EXPECT_GT(largest, 0);
  EXPECT_NEAR(taker.extremes().high, largest, 1e-5 * largest);
  EXPECT_LE(taker.bulk().high, taker.extremes().high);
}

TEST(Shots, FlatValuesAreThoseOfTheCells) {
  Simulation simulation = simulationFromText(block());
  for (int i = 0; i < 3; ++i) simulation.step();
  PictureRequest request;
  request.field = "J", request.flat = true;
  ShotTaker taker(simulation, request);
  EXPECT_EQ(taker.valuesAt(0), ValuesAt::cells);
  EXPECT_EQ(taker.take(0).bodies.at(0).values.size(), 24u);
}

TEST(Shots, DisplacementsAreMeasuredFromRestAndHeldNodesAreMarked) {
  Simulation simulation = simulationFromText(block());
  PictureRequest request;
  request.field = "displacement";
  ShotTaker taker(simulation, request);
  const Shot start = taker.take(0);
  for (const float value : start.bodies[0].values) EXPECT_EQ(value, 0);
  for (int i = 0; i < 3; ++i) simulation.step();
  const Shot shot = taker.take(simulation.time());
  const drawing::Body& body = taker.drawing().bodies[0];
  for (Index page = 0; page < body.surface; ++page) {
    const auto row = std::size_t(body.node[std::size_t(page)]);
    const Vec3 x = body.state->x()[Index(row)];
    EXPECT_NEAR(shot.bodies[0].values[std::size_t(page)], (x - body.state->rest_position[row]).norm(), 1e-6);
  }
  EXPECT_EQ(shot.bodies[0].held.size(), 4u);
  EXPECT_EQ(taker.bulk().low, 0);
  EXPECT_DOUBLE_EQ(taker.bulk().high, taker.extremes().high);
}

TEST(Shots, ACutKeepsTheInside) {
  const Simulation simulation = simulationFromText(block());
  PictureRequest request;
  EXPECT_EQ(ShotTaker(simulation, request).take(0).bodies[0].x.size(), 3u * (60 - 6));
  request.cut = Cut{};
  EXPECT_EQ(ShotTaker(simulation, request).take(0).bodies[0].x.size(), 3u * 60);
}

TEST(Shots, WhatThereIsNotIsRefusedWithTheNearestName) {
  const Simulation simulation = simulationFromText(block());
  PictureRequest request;
  request.field = "vonMisses";
  try {
    ShotTaker(simulation, request);
    FAIL();
  } catch (const ComponentError& error) {
    EXPECT_EQ(error.suggestion, "vonMises");
  }
  request.field = "", request.hidden = {"/blok"};
  try {
    ShotTaker(simulation, request);
    FAIL();
  } catch (const ComponentError& error) {
    EXPECT_EQ(error.suggestion, "/block");
  }
  for (const std::string path : {"/block", "/block/", "/block/dofs"}) {
    request.hidden = {path};
    EXPECT_FALSE(ShotTaker(simulation, request).isDrawn(0)) << path;
  }
}

TEST(Shots, FieldsHaveTitlesForPeople) {
  EXPECT_EQ(titleOf("vonMises"), "von Mises stress");
  EXPECT_EQ(titleOf("strain"), "strain (norm)");
  EXPECT_EQ(titleOf("porePressure"), "pore pressure");
  EXPECT_EQ(titleOf("displacement"), "displacement");
}

/// Few nodes are pressed, and their largest value is seen; obstacles go their way, unless they are hidden.
TEST(Shots, ContactPressuresAreOfNodesAndObstaclesMove) {
  Simulation simulation = simulationFromText(
      "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><EulerImplicitSolver newtonIterations=\"30\"/><SparseLDLSolver/>"
      "<RegularGridTopology n=\"7 7 3\" min=\"0 0 0\" max=\"1 1 0.3\"/><MechanicalObject name=\"dofs\"/>"
      "<UniformMass totalMass=\"10\"/><HexahedronFEMForceField youngModulus=\"1e4\" poissonRatio=\"0.3\"/>"
      "<BarrierContact name=\"contact\" contactDistance=\"0.01\" spheres=\"0.5 0.5 0.508 0.2\" keyTimes=\"0 0.1\" "
      "movements=\"0 0 0  0 0 -0.05\"/></Node>");
  PictureRequest request;
  request.field = "pressures";
  request.flat = true;
  ShotTaker taker(simulation, request);
  for (int i = 0; i < 2; ++i) simulation.step();
  const Shot shot = taker.take(simulation.time());
  EXPECT_EQ(taker.valuesAt(0), ValuesAt::nodes);
  int pressed = 0;
  float largest = 0;
  for (const float value : shot.bodies[0].values) pressed += value > 0, largest = std::max(largest, value);
  EXPECT_GT(pressed, 0);
  EXPECT_LT(pressed, 10);
  EXPECT_EQ(taker.bulk().low, 0);
  EXPECT_EQ(taker.bulk().high, double(largest));
  ASSERT_EQ(shot.moved.size(), 1u);
  EXPECT_NEAR(shot.moved[0].z(), -0.01, 1e-12);
  EXPECT_TRUE(taker.isObstacleDrawn(0));
  request.hidden = {"/contact"};
  EXPECT_FALSE(ShotTaker(simulation, request).isObstacleDrawn(0));
}

}  // namespace
}  // namespace stroma::picture
