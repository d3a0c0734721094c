// SPDX-License-Identifier: LGPL-2.1-or-later
// What the view chooses for a hand, and what it tells of one.
#include <gtest/gtest.h>

#include <cmath>

#include "framework/mechanics/frames.h"
#include "tests/support/scene_fixture.h"
#include "tools/view/hands.h"
#include "tools/view/orders.h"

namespace stroma::view {
namespace {

using nlohmann::json;
using test::expectContains;
using test::simulationFromText;

std::string block(const std::string& integrator, const std::string& dt = "0.01") {
  return "<Node name=\"root\" dt=\"" + dt + "\" gravity=\"0 0 0\">" + integrator +
         "<RegularGridTopology n=\"4 3 5\" min=\"0 0 0\" max=\"0.3 0.2 0.4\"/><MechanicalObject name=\"dofs\"/>"
         "<UniformMass totalMass=\"1\"/><HexahedronFEMForceField youngModulus=\"5000\" poissonRatio=\"0.3\"/></Node>";
}
const std::string implicit = "<EulerImplicitSolver/><CGLinearSolver iterations=\"200\" tolerance=\"1e-12\"/>";

json pull(const std::vector<int>& nodes, const std::string& kind = "pull", const std::string& name = "h") {
  json order{{"do", "pull"}, {"hand", name}, {"kind", kind}, {"body", 0}, {"nodes", nodes}, {"targets", json::array()}};
  for (std::size_t i = 0; i < nodes.size(); ++i) order["targets"].push_back({0.1, 0.2, 0.3});
  return order;
}

double stiffnessOf(const Hands& hands, const std::string& name) {
  const json all = hands.describe();
  for (const json& hand : all)
    if (hand["hand"] == name) return hand["stiffness"];
  ADD_FAILURE() << "there is no hand " << name;
  return 0;
}

TEST(Hands, AHandIsAsStiffAsTheBodyWhereItTakesItBeforeTheFirstStepAndAfter) {
  double at_start = 0;
  for (const int steps : {0, 1}) {
    Simulation simulation = simulationFromText(block(implicit));
    const Drawing drawing = drawingOf(simulation);
    for (int i = 0; i < steps; ++i) simulation.step();
    Hands hands(simulation, drawing);
    hands.apply(1, pull({0, 1, 2, 3, 4, 5}));
    const double k = stiffnessOf(hands, "h");
    if (steps == 0) at_start = k;
    // E h times a number near 1, h the size of a cell; a quarter of it
    EXPECT_GT(k, 0.25 * 5000 * 0.1 * 0.1);
    EXPECT_LT(k, 0.25 * 5000 * 0.1 * 10);
    EXPECT_NEAR(k, at_start, 1e-9 * k);
  }
}

TEST(Hands, OtherHandsAreNoPartOfTheBody) {
  Simulation simulation = simulationFromText(block(implicit));
  const Drawing drawing = drawingOf(simulation);
  simulation.step();
  Hands hands(simulation, drawing);
  hands.apply(1, pull({7}, "pull", "alone"));
  const double alone = stiffnessOf(hands, "alone");
  hands.apply(1, {{"do", "release"}, {"hand", "alone"}});
  hands.apply(1, pull({7}, "hold", "first"));
  hands.apply(1, pull({7}, "pull", "second"));
  EXPECT_NEAR(stiffnessOf(hands, "second"), alone, 1e-9 * alone);
  EXPECT_NEAR(stiffnessOf(hands, "first"), 100 * alone, 1e-7 * alone);
}

TEST(Hands, ExplicitStepsStayStableWhateverHolds) {
  Simulation simulation = simulationFromText(block("<EulerExplicitSolver/>", "0.002"));
  const Drawing drawing = drawingOf(simulation);
  Hands hands(simulation, drawing);
  hands.apply(1, pull({0, 1, 2}, "hold"));
  const double mass = 1. / 60;
  EXPECT_LE(stiffnessOf(hands, "h"), mass / (4 * 0.002 * 0.002) * (1 + 1e-12));
  for (int i = 0; i < 500; ++i) ASSERT_FALSE(simulation.step().diverged) << i;
}

TEST(Hands, AHandKeepsItsStiffnessWhileItMoves) {
  Simulation simulation = simulationFromText(block(implicit));
  const Drawing drawing = drawingOf(simulation);
  Hands hands(simulation, drawing);
  hands.apply(1, pull({3, 4}));
  const double k = stiffnessOf(hands, "h");
  for (int i = 0; i < 5; ++i) simulation.step();
  hands.apply(1, pull({3, 4}));
  EXPECT_EQ(stiffnessOf(hands, "h"), k);
  ASSERT_EQ(hands.describe().size(), 1u);
}

TEST(Hands, WhatNothingMovesIsNotPulled) {
  Simulation simulation = simulationFromText(
      "<Node name=\"root\"><CollisionPipeline/><MinProximityIntersection/><Node name=\"floor\"><MeshTopology "
      "position=\"-1 0 -1  1 0 -1  0 0 1\" triangles=\"0 2 1\"/><MechanicalObject name=\"dofs\"/><TriangleCollisionModel "
      "simulated=\"false\" moving=\"false\"/></Node><Node name=\"ball\"><EulerImplicitSolver/><CGLinearSolver/>"
      "<MechanicalObject position=\"0 1 0\"/><UniformMass totalMass=\"1\"/><SphereCollisionModel radius=\"0.1\"/></Node></Node>");
  const Drawing drawing = drawingOf(simulation);
  ASSERT_EQ(drawing.bodies.size(), 2u);
  ASSERT_EQ(drawing.bodies[1].state->path(), "/floor/dofs");
  Hands hands(simulation, drawing);
  json order = pull({0});
  order["body"] = 1;
  EXPECT_THROW(hands.apply(1, order), ComponentError);
  EXPECT_TRUE(hands.describe().empty());
}

TEST(Hands, TheForceOfABallIsThatOfItsLaw) {
  Simulation simulation = simulationFromText(block(implicit));
  const Drawing drawing = drawingOf(simulation);
  Hands hands(simulation, drawing);
  // node 0 of the scene is at the origin; the ball reaches it alone, along the diagonal
  hands.apply(1, {{"do", "push"},
                  {"hand", "b"},
                  {"body", 0},
                  {"centre", {-0.01, -0.01, -0.01}},
                  {"radius", 0.05},
                  {"stiffness", 40}});
  const json hand = hands.describe().at(0);
  EXPECT_EQ(hand["touched"], 1);
  const double depth = 0.05 - 0.01 * std::sqrt(3.);
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(hand["force"][std::size_t(k)].get<double>(), 40 * depth / std::sqrt(3.), 1e-12);
}

TEST(Hands, ReleasingAndGoingLeavesNoInput) {
  Simulation simulation = simulationFromText(block(implicit));
  const Drawing drawing = drawingOf(simulation);
  Hands hands(simulation, drawing);
  hands.apply(1, pull({0}));
  hands.apply(2, pull({1}, "hold", "other"));
  hands.apply(1, {{"do", "release"}, {"hand", "nobody"}});
  EXPECT_EQ(hands.describe().size(), 2u);
  hands.releaseAll(1);
  EXPECT_EQ(hands.describe().size(), 1u);
  hands.apply(2, {{"do", "release"}, {"hand", "other"}});
  EXPECT_EQ(hands.describe().size(), 0u);
  const Vector before = [&] {
    Vector x;
    x.resize(simulation.systems()[0]->allRows());
    copy(simulation.systems()[0]->x, x);
    return x;
  }();
  simulation.step();
  for (Index i = 0; i < simulation.systems()[0]->allRows(); ++i)
    EXPECT_LT((ConstRows(simulation.systems()[0]->x)[i] - ConstRows(before)[i]).norm(), 1e-12);
}

std::string refusal(const json& order) {
  try {
    checkedVerb(order);
  } catch (const ComponentError& error) {
    return sentenceOf(error);
  }
  return {};
}

TEST(Orders, WhatIsMisspeltIsNamedWithTheNearestRightName) {
  expectContains(refusal({{"do", "paus"}}), "did you mean pause?");
  expectContains(refusal({{"do", "pull"}, {"hand", "h"}, {"stifness", 5}}), "did you mean stiffness?");
  expectContains(refusal({{"do", "attach"}}), "there is nothing to do that is called 'attach'");
  expectContains(refusal(json::object()), "has no 'do'");
  EXPECT_EQ(refusal({{"do", "run"}, {"request", 3}, {"sequence", 4}}), "");
}

/// A frame is pulled by its centre and turned towards an orientation; a torque of stiffness times the angle to it.
TEST(Hands, PullAndTurnAFrame) {
  Simulation simulation = simulationFromText(
      "<Node name=\"root\" dt=\"0.02\" gravity=\"0 0 0\">" + implicit +
      "<MechanicalObject name=\"dofs\" template=\"Rigid3\" position=\"0 0 0  0 0 0 1   2 0 0  0 0 0.38268343 0.92387953\"/>"
      "<UniformMass totalMass=\"2\" inertia=\"0.1 0.2 0.3\"/></Node>");
  const Drawing drawing = drawingOf(simulation);
  Hands hands(simulation, drawing);
  hands.apply(1, pull({0}, "pull", "centre"));
  const double angle = 2.5;  // beyond the other frame's quarter of pi
  hands.apply(1, {{"do", "pull"}, {"hand", "turn"}, {"kind", "pull"}, {"body", 0}, {"frames", {1}}, {"stiffness", 4},
                  {"targets", {{0, 0, angle}}}});
  json told;
  for (const json& hand : hands.describe())
    if (hand["hand"] == "turn") told = hand;
  EXPECT_TRUE(told["turns"].get<bool>());
  EXPECT_NEAR(told["force"][2], 4 * (angle - M_PI / 4), 1e-6);
  EXPECT_EQ(told["node"], 1);
  EXPECT_EQ(told["at"], json({2, 0, 0}));
  simulation.step();
  const System& system = *simulation.systems()[0];
  EXPECT_GT(system.v[3][2], 0);
  for (int i = 0; i < 400; ++i) ASSERT_FALSE(simulation.step().diverged);
  EXPECT_NEAR(rotationVector(orientationIn(system.x, 3)).z(), angle, 1e-3) << "it comes to rest there";
  EXPECT_LT((system.x[0] - Vec3(0.1, 0.2, 0.3)).norm(), 1e-3);
  EXPECT_LT(rotationVector(orientationIn(system.x, 1)).norm(), 1e-12) << "pulled by its centre it does not turn";
  const json both{{"do", "pull"}, {"hand", "x"}, {"body", 0}, {"frames", {0}}, {"nodes", {0}}, {"targets", {{0, 0, 0}}}};
  EXPECT_THROW(hands.apply(1, both), ComponentError);
  json beyond = both;
  beyond.erase("nodes");
  beyond["frames"] = {2};
  EXPECT_THROW(hands.apply(1, beyond), ComponentError);
}

}  // namespace
}  // namespace stroma::view
