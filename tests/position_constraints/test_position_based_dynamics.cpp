// SPDX-License-Identifier: LGPL-2.1-or-later
// Nodes that are drawn to goals, and groups of nodes to their shapes.
#include <gtest/gtest.h>

#include "tests/position_constraints/position_scenes.h"

namespace stroma::test {
namespace {

const std::string corners = "0 0 0  1 0 0  0 1 0  0 0 1  1 1 1";
std::string drawn(const std::string& attributes, const std::string& more = "") {
  return root("<EulerExplicitSolver/><MechanicalObject position=\"" + corners + "\"/><UniformMass totalMass=\"5\"/>" + more +
              "<PositionBasedDynamicsProjectiveConstraint " + attributes + "/>");
}

/// One group of equal masses keeps both momenta, and with the whole stiffness its distances.
TEST(PositionBasedDynamics, AGroupKeepsItsMomentaAndItsShape) {
  Simulation simulation = simulationFromText(drawn("cluster=\"[0,1,2,3,4]\""));
  System& system = *simulation.systems()[0];
  for (Index i = 0; i < 5; ++i) system.v[i] = Vec3(0.3 * double(i), 1, -0.2 * double(i * i));
  const auto momenta = [&system] {
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
    for (Index i = 0; i < 5; ++i) linear += system.v[i], angular += Vec3(system.x[i]).cross(Vec3(system.v[i]));
    return std::pair(linear, angular);
  };
  const auto start = momenta();
  run(simulation, 100);
  const auto end = momenta();
  EXPECT_LT((end.first - start.first).norm(), 1e-11);  // each step rounds places of some metres and divides them by dt = 0.01 s
  EXPECT_GT(start.second.norm(), 0.5);
  // angles turn by the polar factor, so that a turn loses a share of (w dt)^2
  EXPECT_LT((end.second - start.second).norm(), 0.02 * start.second.norm());
  EXPECT_NEAR((system.x[4] - system.x[0]).norm(), std::sqrt(3.), 1e-12);
  EXPECT_NEAR((system.x[3] - system.x[1]).norm(), std::sqrt(2.), 1e-12);
}

/// A group that shears freely is not drawn anywhere by an affine motion.
TEST(PositionBasedDynamics, AnAffineShapeIsKept) {
  Simulation simulation = simulationFromText(drawn("cluster=\"[0 1 2 3 4]\" affineRatio=\"1\""));
  System& system = *simulation.systems()[0];
  for (Index i = 0; i < 5; ++i) system.v[i] = Vec3(2 * system.x[i].y(), -system.x[i].z(), 0.5 * system.x[i].x());
  const Vec3 expected = Vec3(system.x[4]) + 0.1 * Vec3(system.v[4]);
  run(simulation, 10);
  EXPECT_LT((Vec3(system.x[4]) - expected).norm(), 1e-12);
}

TEST(PositionBasedDynamics, NodesGoPartOfTheWayAndHeldOnesStay) {
  const std::string goals = "position=\"9 9 9  3 0 0  0 1 0  0 0 1  1 1 1\" stiffness=\"0.25\"";
  Simulation simulation = simulationFromText(drawn(goals, "<FixedProjectiveConstraint indices=\"0\"/>"));
  System& system = *simulation.systems()[0];
  run(simulation, 1);
  EXPECT_EQ(Vec3(system.x[0]), Vec3::Zero());
  EXPECT_NEAR(system.x[1].x(), 1.5, 1e-15);
  EXPECT_NEAR(system.v[1].x(), 50, 1e-12);
  run(simulation, 1);
  EXPECT_NEAR(system.x[1].x(), 2 + 0.25, 1e-14);
}

TEST(PositionBasedDynamics, WhatIsWrongIsNamed) {
  expectContains(problemsOf(drawn("")), "there are no goals");
  expectContains(problemsOf(drawn("position=\"0 0 0\"")), "position has 1 goals for 5 nodes");
  expectContains(problemsOf(drawn("cluster=\"[0 7]\"")), "cluster names node 7 of 5");
  expectContains(problemsOf(drawn("cluster=\"0 1\"")), "lists of nodes in brackets");
  expectContains(problemsOf(drawn("cluster=\"[0 1 2]\" affineRatio=\"0.5\"")), "is flat");
}

}  // namespace
}  // namespace stroma::test
