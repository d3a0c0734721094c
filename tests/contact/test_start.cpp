// SPDX-License-Identifier: LGPL-2.1-or-later
// resolveStart: bodies that start in one another are pushed apart, and what follows is the rest that they would have come to.
#include <Eigen/Geometry>
#include <cmath>

#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string statics = "<StaticSolver relative_residual_tolerance_threshold=\"1e-8\"/>";

std::string contactOf(const std::string& more) {
  return fmt::format("<BarrierContact name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" contactDistance=\"0.01\" "
                     "stiffness=\"1e6\" selfContact=\"0\" resolveStart=\"1\" {}/>",
                     more);
}

/// Nothing is nearer than 0.97 contact distances, and no exact test finds a common point.
void expectApart(Simulation& simulation, double most_moved) {
  const double moved = outputOf(simulation, "movedStart");
  EXPECT_GT(moved, 0);
  EXPECT_LT(moved, most_moved);
  simulation.step();
  EXPECT_EQ(outputOf(simulation, "crossings"), 0);
}

/// A block whose top is held and whose lower end is 0.05 m below a plane is compressed by that and by the gap: p = E (0.05 + d)/H,
/// and p/kappa = 2 (r - 1) ln r + (r - 1)^2/r.
TEST(ResolveStart, ABlockInAPlaneIsCompressedByWhatItWasIn) {
  constexpr double young = 1e5, way = 0.05;
  Simulation simulation = simulationFromText(
      contactScene(bodyNode("a", boxOf(Vec3(0, 0, -way), Vec3(1, 1, 1 - way), {3, 3, 4}),
                            "<BoxROI name=\"top\" box=\"-1 -1 0.9  2 2 1\"/><FixedProjectiveConstraint indices=\"@top.indices\"/>"
                            "<PartialFixedProjectiveConstraint fixAll=\"true\" fixedDirections=\"1 1 0\"/>",
                            "", young, 0) +
                       contactOf("planes=\"0 0 1 0\""), 1, Vec3::Zero(), statics));
  EXPECT_NEAR(outputOf(simulation, "movedStart"), way + 0.98 * 0.01, 2e-4);
  expectCleanStep(simulation, 1);
  const double gap = outputOf(simulation, "smallestGap"), pressure = numbersOf(simulation, "wrenches")[2];
  EXPECT_NEAR(pressure, young * (way + gap), 1e-3 * pressure);  // corotational cells: strains of 0.05 to first order
  const double r = gap / 0.01;
  EXPECT_NEAR(pressure, 1e6 * (2 * (r - 1) * std::log(r) + (r - 1) * (r - 1) / r), 1e-3 * pressure);
}

/// A corner, an edge and a face of a block in another one; the lower one stands.
TEST(ResolveStart, TwoBodiesAreApartWhereverTheyMet) {
  const Mat3 turns[] = {Mat3::Identity(), Eigen::AngleAxisd(M_PI / 4, Vec3::UnitX()).toRotationMatrix(),
                        (Eigen::AngleAxisd(std::atan(std::sqrt(2.)), Vec3(1, -1, 0).normalized())).toRotationMatrix()};
  for (const Mat3& turn : turns) {
    Body upper = boxOf(Vec3(-.3, -.3, -.3), Vec3(.3, .3, .3), {3, 3, 3});
    upper.turn(turn, Vec3(0.51, 0.52, 0));
    upper.turn(Mat3::Identity(), Vec3(0, 0, 0.95 - upper.lowest(2)));
    Simulation simulation = simulationFromText(contactScene(
        bodyNode("a", upper, "") +
            bodyNode("b", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {4, 4, 4}),
                     "<BoxROI name=\"foot\" box=\"-1 -1 -1  2 2 0.01\"/><FixedProjectiveConstraint indices=\"@foot.indices\"/>") +
            contactOf("other=\"@b/dofs\""), 1e-3));
    for (const State* state : simulation.states())
      if (state->path() == "/b/dofs") {
        EXPECT_EQ(Vec3(state->x()[0]), Vec3::Zero()) << "what is held stays";
      }
    expectApart(simulation, 0.12);
  }
}

/// Two bars cross like swords: no vertex is inside.
TEST(ResolveStart, EdgesThatCrossAreApart) {
  Body first = boxOf(Vec3(-.5, -.1, -.1), Vec3(.5, .1, .1)), second = first;
  const Mat3 edge_down = Eigen::AngleAxisd(M_PI / 4, Vec3::UnitX()).toRotationMatrix();
  first.turn(edge_down, Vec3::Zero());
  second.turn(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()).toRotationMatrix() * edge_down, Vec3(0.01, 0.02, 0.25));
  Simulation simulation = simulationFromText(
      contactScene(bodyNode("a", first, "") + bodyNode("b", second, "") + contactOf("other=\"@b/dofs\""), 1e-3));
  expectApart(simulation, 0.06);
}

TEST(ResolveStart, WhatIsTooDeepOrHeldIsRefused) {
  const std::string foot = "<BoxROI name=\"foot\" box=\"-1 -1 -1  2 2 0.01\"/><FixedProjectiveConstraint indices=\"@foot.indices\"/>";
  const std::string top = "<BoxROI name=\"top\" box=\"-1 -1 1.49  2 2 2\"/><FixedProjectiveConstraint indices=\"@top.indices\"/>";
  const Body lower = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {4, 4, 4}), deep = boxOf(Vec3(.21, .22, .2), Vec3(.8, .81, 1.5), {3, 3, 6});
  expectContains(problemsOf(contactScene(bodyNode("a", deep, top) + bodyNode("b", lower, foot) + contactOf("other=\"@b/dofs\""))),
                 "start in one another");
  const std::string all = "<FixedProjectiveConstraint fixAll=\"true\"/>";
  const Body upper = boxOf(Vec3(.21, .22, .97), Vec3(.8, .81, 1.5), {3, 3, 3});
  expectContains(problemsOf(contactScene(bodyNode("a", upper, all) + bodyNode("b", lower, all) + contactOf("other=\"@b/dofs\""))),
                 "cross");
}

/// A free block in a plane, and two of different meshes that share the way: afterwards gaps are those that ConstraintContact keeps.
TEST(ResolveStart, ConstraintContactBeginsAtTheGapThatItKeeps) {
  constexpr double range = 0.01, in = 0.05;
  const auto scene = [&](const std::string& attributes, const std::string& other) {
    return contactScene(bodyNode("a", boxOf(Vec3(0, 0, -in), Vec3(1, 1, 1 - in), {2, 2, 2}), "") + other +
                            fmt::format("<ConstraintContact name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" "
                                        "contactDistance=\"{}\" {}/>",
                                        range, attributes),
                        1e-3);
  };
  const std::string plane = "planes=\"0 0 1 0\"", block = bodyNode("b", boxOf(Vec3(0.1, 0.1, -1), Vec3(0.9, 0.9, 0), {2, 2, 2}), "");
  expectContains(problemsOf(scene(plane, "")), "start in one another");
  for (const bool has_block : {false, true}) {
    SCOPED_TRACE(has_block);
    const std::string text = scene(std::string("resolveStart=\"1\" ") + (has_block ? "other=\"@b/dofs\"" : plane), has_block ? block : "");
    EXPECT_EQ(saidOf(text).find("starts with a gap"), std::string::npos) << "before a step has moved anything";
    Simulation simulation = simulationFromText(text);
    const double way = in + range, moved = constraintOutput(simulation, "movedStart").at(0);
    EXPECT_GT(moved, (has_block ? 0.5 : 0.99) * way);
    EXPECT_LT(moved, (has_block ? 0.9 : 1.01) * way);
    expectCleanStep(simulation, 1);
    EXPECT_GT(constraintOutput(simulation, "smallestGap").at(0), 0.999 * range);
    EXPECT_LT(constraintOutput(simulation, "smallestGap").at(0), 1.1 * range);
  }
}

/// Reset begins at the same places, and a checkpoint does not move anything again.
TEST(ResolveStart, BeginsAgainAsItBegan) {
  Simulation simulation = simulationFromText(contactScene(
      bodyNode("a", boxOf(Vec3(0, 0, -.02), Vec3(1, 1, 1), {2, 2, 2}), "") + contactOf("planes=\"0 0 1 0\""), 1e-3));
  const auto start = simulation.stateHash();
  simulation.step();
  simulation.reset();
  EXPECT_EQ(simulation.stateHash(), start);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
