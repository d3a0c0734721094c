// SPDX-License-Identifier: LGPL-2.1-or-later
// Steps in time whose prescribed motion is too much for one go are divided.
#include <fmt/format.h>

#include "tests/support/scene_fixture.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string neo_hookean =
    R"(<HexahedronHyperelasticityFEMForceField materialName="NeoHookean" youngModulus="3000" poissonRatio="0.3"/>)";
const std::string corotational = R"(<HexahedronFEMForceField method="svd" youngModulus="3000" poissonRatio="0.3"/>)";

/// A bar of 4 x 1 x 1 with next to no mass. Its near end is `held`, its far end moves within one second.
std::string bar(const std::string& integrator, const std::string& field, double dt, const std::string& held, const std::string& motion) {
  return fmt::format(
      R"(<Node name="root" dt="{}" gravity="0 0 0"><{}/><SparseLDLSolver/><RegularGridTopology name="grid" n="9 3 3" min="0 0 0"
  max="4 1 1"/><MechanicalObject/><UniformMass totalMass="1e-6"/>{}<BoxROI name="near" box="-1 -1 -1 1e-6 2 2"/><BoxROI name="far"
  box="3.9999 -1 -1 5 2 2"/>{}{}</Node>)",
      dt, integrator, field, held, motion);
}

const std::string clamp = R"(<FixedProjectiveConstraint indices="@near.indices"/>)";
std::string moved(const std::string& way) {
  return fmt::format(
      R"(<LinearMovementProjectiveConstraint indices="@far.indices" keyTimes="0 1" movements="0 0 0  {}" outside="hold"/>)", way);
}
const std::string twist = R"(<AffineMovementProjectiveConstraint indices="@far.indices" endConstraintTime="1"
  rotation="1 0 0  0 0 -1  0 1 0" translation="0 1 0"/>)";

/// Ends that may glide, and no node that could leave the corner: the bar stays a bar.
const std::string gliding = R"(<PartialFixedProjectiveConstraint indices="@near.indices" fixedDirections="1 0 0"/><BoxROI name="floor"
  box="-1 -1 -1 5 2 1e-6"/><PartialFixedProjectiveConstraint indices="@floor.indices" fixedDirections="0 0 1"/><BoxROI name="wall"
  box="-1 -1 -1 5 1e-6 2"/><PartialFixedProjectiveConstraint indices="@wall.indices" fixedDirections="0 1 0"/>)";
const std::string pressed = R"(<PartialLinearMovementProjectiveConstraint indices="@far.indices" keyTimes="0 1"
  movements="0 0 0  -2 0 0" outside="hold" movedDirections="1 0 0"/>)";

struct Outcome {
  std::vector<Vec3> place;
  int parts = 0;
};

Outcome run(const std::string& scene, int steps) {
  Simulation simulation = simulationFromText(scene);
  Outcome outcome;
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.step();
    EXPECT_TRUE(!report.failed() && report.newton_converged) << report.reason;
    if (report.failed()) return outcome;
    outcome.parts = std::max(outcome.parts, report.load_parts);
  }
  const ConstRows x = simulation.systems()[0]->x;
  for (Index i = 0; i < x.count; ++i) outcome.place.push_back(x[i]);
  return outcome;
}

double apart(const Outcome& a, const Outcome& b) {
  if (a.place.size() != b.place.size()) return 1e300;
  double largest = 0;
  for (std::size_t i = 0; i < a.place.size(); ++i) largest = std::max(largest, (a.place[i] - b.place[i]).norm());
  return largest;
}

const std::vector<std::string> integrators{"EulerImplicitSolver newtonIterations=\"60\"", "BDFOdeSolver newtonIterations=\"60\""};

/// Twice as long, sheared by its length, its end turned by a quarter: in one step as in ten.
TEST(PrescribedParts, OneStepEndsWhereTenDo) {
  for (const std::string& integrator : integrators)
    for (const std::string& field : {neo_hookean, corotational})
      for (const std::string& motion : {moved("4 0 0"), moved("0 4 0"), twist}) {
        const Outcome one = run(bar(integrator, field, 1, clamp, motion), 1), ten = run(bar(integrator, field, 0.1, clamp, motion), 10);
        ASSERT_FALSE(ten.place.empty());
        EXPECT_LT(apart(one, ten), 1e-5) << integrator << field << motion;
      }
}

/// Pressed to half its length between gliding plates, the cells at the moved end turned inside out at first. Hooke's law in the
/// axes of the cells makes it 1 + 0.3 * 0.5 thick.
TEST(PrescribedParts, PressedToHalfInOneStep) {
  for (const std::string& integrator : integrators) {
    const Outcome hooke = run(bar(integrator, corotational, 1, gliding, pressed), 1);
    ASSERT_FALSE(hooke.place.empty());
    EXPECT_GT(hooke.parts, 1);
    EXPECT_LT((hooke.place.back() - Vec3(2, 1.15, 1.15)).norm(), 1e-6) << integrator;
    const Outcome one = run(bar(integrator, neo_hookean, 1, gliding, pressed), 1);
    EXPECT_GT(one.parts, 1);
    EXPECT_LT(apart(one, run(bar(integrator, neo_hookean, 0.1, gliding, pressed), 10)), 1e-5) << integrator;
    EXPECT_LT(apart(one, run(bar("StaticSolver", neo_hookean, 1, gliding, pressed), 1)), 1e-5) << integrator;
  }
}

/// A tool that moves, with the end of the bar attached to it, presses it as if the end were moved itself.
TEST(PrescribedParts, AnAttachedToolPressesToHalfInOneStep) {
  const std::string own = bar(integrators[0], neo_hookean, 1, clamp, moved("-2 0 0"));
  const Outcome reference = run(own, 1);
  EXPECT_GT(reference.parts, 1);
  std::string places, ends;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j) places += fmt::format("4 {} {}  ", 0.5 * j, 0.5 * k), ends += fmt::format("{} ", 8 + 9 * (j + 3 * k));
  for (const std::string both : {"true", "false"}) {
    std::string scene = bar(integrators[0], neo_hookean, 1, clamp, "");
    const std::string start = "<RegularGridTopology", end = "</Node>";
    scene.insert(scene.rfind(end), fmt::format(R"(</Node><AttachProjectiveConstraint object1="@tool/dofs" object2="@body/MechanicalObject"
  indices1="0 1 2 3 4 5 6 7 8" indices2="{}" twoWay="{}"/>)", ends, both));
    scene.insert(scene.find(start),
                 fmt::format(R"(<Node name="tool"><MechanicalObject name="dofs" position="{}"/><UniformMass totalMass="1e-6"/>
  <LinearMovementProjectiveConstraint indices="0 1 2 3 4 5 6 7 8" keyTimes="0 1" movements="0 0 0  -2 0 0" outside="hold"/></Node>
  <Node name="body">)", places));
    Outcome attached = run(scene, 1);
    EXPECT_GT(attached.parts, 1);
    ASSERT_EQ(attached.place.size(), reference.place.size() + 9);
    attached.place.erase(attached.place.begin(), attached.place.begin() + 9);
    EXPECT_LT(apart(attached, reference), 1e-5) << both;
  }
}

/// The same where forces of constraint hold the end at the tool. Without them the pressed bar buckles, which Cholesky's factors refuse.
TEST(PrescribedParts, AToolThatConstraintsHoldPressesToHalfInOneStep) {
  const Outcome reference = run(bar(integrators[0], neo_hookean, 1, clamp, moved("-2 0 0")), 1);
  std::string places, ends;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j) places += fmt::format("4 {} {}  ", 0.5 * j, 0.5 * k), ends += fmt::format("{} ", 8 + 9 * (j + 3 * k));
  for (const std::string& integrator : {integrators[0], integrators[1], std::string("StaticSolver")}) {
    std::string scene = bar(integrator, neo_hookean, 1, clamp, "");
    const std::string start = "<RegularGridTopology", end = "</Node>";
    scene.insert(scene.rfind(end), fmt::format(R"(</Node><BilateralLagrangianConstraint object1="@tool/dofs"
  object2="@body/MechanicalObject" first_point="0 1 2 3 4 5 6 7 8" second_point="{}"/>)", ends));
    scene.insert(scene.find(start),
                 fmt::format(R"(<Node name="tool"><MechanicalObject name="dofs" position="{}"/><UniformMass totalMass="1e-6"/>
  <LinearMovementProjectiveConstraint indices="0 1 2 3 4 5 6 7 8" keyTimes="0 1" movements="0 0 0  -2 0 0" outside="hold"/></Node>
  <Node name="body">)", places));
    Simulation refused = simulationFromText(scene);
    const std::string reason = refused.step().reason;
    EXPECT_NE(reason.find("without these forces a body is unstable"), std::string::npos) << reason;
    if (integrator == "StaticSolver") {  // no part is as large as half of a step: what was not tried is not told
      std::string whole = scene;
      whole.insert(whole.find("StaticSolver") + 12, " smallest_part=\"0.5\"");
      Simulation undivided = simulationFromText(whole);
      const std::string told = undivided.step().reason;
      EXPECT_NE(told.find("without these forces a body is unstable"), std::string::npos) << told;
      EXPECT_EQ(told.find("divided"), std::string::npos) << told;
    }
    scene.replace(scene.find("SparseLDLSolver"), 15, "EigenSparseLU");
    Outcome held = run(scene, 1);
    ASSERT_EQ(held.place.size(), reference.place.size() + 9);
    held.place.erase(held.place.begin(), held.place.begin() + 9);
    EXPECT_LT(apart(held, reference), 1e-5) << integrator;
  }
}

/// Constraints elsewhere, and obstacles that nothing touches, do not keep a step from being divided.
TEST(PrescribedParts, ConstraintsAndContactElsewhereChangeNothing) {
  const std::string away = R"(<Node name="pair"><MechanicalObject position="0 9 0  1 9 0"/><UniformMass totalMass="1"/>
  <DistanceLagrangianConstraint first_point="0" second_point="1"/></Node>)";
  const std::string wall = R"(<BarrierContact contactDistance="0.01" planes="0 0 1 -30"/>)";
  for (const std::string& integrator : integrators) {
    const Outcome reference = run(bar(integrator, neo_hookean, 1, clamp, moved("-2 0 0")), 1);
    for (const std::string* each : {&away, &wall}) {
      const std::string& beside = *each;
      std::string scene = bar(integrator, neo_hookean, 1, clamp, moved("-2 0 0") + beside);
      // pressed so far the bar might buckle, and forces of constraint are found with its matrix as it is
      if (&beside == &away) scene.replace(scene.find("SparseLDLSolver"), 15, "EigenSparseLU");
      Outcome one = run(scene, 1);
      ASSERT_GE(one.place.size(), reference.place.size()) << integrator << beside;
      one.place.resize(reference.place.size());
      EXPECT_LT(apart(one, reference), 1e-5) << integrator << beside;
    }
  }
}

/// With few iterations too: the last part may end before the tolerance, as steps with few iterations do.
TEST(PrescribedParts, FewIterationsDivideToo) {
  const Outcome reference = run(bar(integrators[0], neo_hookean, 1, clamp, moved("-2 0 0")), 1);
  for (const int iterations : {2, 3, 4}) {
    Simulation few = simulationFromText(
        bar(fmt::format("EulerImplicitSolver newtonIterations=\"{}\"", iterations), neo_hookean, 1, clamp, moved("-2 0 0")));
    const StepReport report = few.step();
    EXPECT_FALSE(report.failed()) << iterations << report.reason;
    EXPECT_GT(report.load_parts, 1) << iterations;
    const ConstRows x = few.systems()[0]->x;
    for (std::size_t i = 0; i < reference.place.size(); ++i)
      EXPECT_LT((x[Index(i)] - reference.place[i]).norm(), 1e-2) << iterations << " " << i;
  }
}

/// What has no place to go says how far the motion came, and is put back.
TEST(PrescribedParts, WhatCannotBeSaysHowFarItCame) {
  const std::string straight = R"(<BoxROI name="all" box="-1 -1 -1 5 2 2"/><PartialFixedProjectiveConstraint indices="@all.indices"
  fixedDirections="0 1 1"/>)";
  Simulation simulation = simulationFromText(bar(integrators[0], neo_hookean, 1, clamp + straight, moved("-4.5 0 0")));
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.diverged);
  EXPECT_NE(report.reason.find("of its prescribed motion, and no part of"), std::string::npos) << report.reason;
  EXPECT_EQ(simulation.systems()[0]->x[simulation.systems()[0]->allRows() - 1], Vec3(4, 1, 1));
}

/// A step that needs no division has none.
TEST(PrescribedParts, SmallMotionIsNotDivided) {
  EXPECT_LE(run(bar(integrators[0], neo_hookean, 1, clamp, moved("0.1 0 0")), 1).parts, 1);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
