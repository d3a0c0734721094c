// SPDX-License-Identifier: LGPL-2.1-or-later
// A block that is pressed to half its height or drawn to one and a half in a single static step, several cells at once:
// StaticSolver divides what is too much for one go. Between plates without friction the block stays a block, so that
// the closed form is an affine map whose lateral tractions vanish.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/hyperelasticity/law_cases.h"

using namespace stroma;
using namespace stroma::test;

namespace STROMA_TEST_FILE {

const std::string hexahedral = "HexahedronHyperelasticityFEMForceField";

/// A unit cube of 4x4x4 cells whose top face moves by `move` in one step; plates with friction hold the faces sideways.
std::string pressed(const LawCase& law, const std::string& field, double move, bool friction,
                    const std::string& statics = "") {
  const std::string held = friction
                               ? "<FixedProjectiveConstraint indices='@floor.indices'/>"
                               : "<PartialFixedProjectiveConstraint indices='@floor.indices' fixedDirections='0 0 1'/>"
                                 "<PartialFixedProjectiveConstraint indices='@left.indices' fixedDirections='1 0 0'/>"
                                 "<PartialFixedProjectiveConstraint indices='@front.indices' fixedDirections='0 1 0'/>";
  return fmt::format(
      R"(<Node name="root" dt="1" gravity="0 0 0">
  <StaticSolver {}/><SparseLDLSolver/>
  <RegularGridTopology name="grid" n="5 5 5" min="0 0 0" max="1 1 1"/>
  <MechanicalObject/>
  <BoxROI name="floor" box="-1 -1 -0.01  2 2 0.01"/><BoxROI name="top" box="-1 -1 0.99  2 2 1.01"/>
  <BoxROI name="left" box="-0.01 -1 -1  0.01 2 2"/><BoxROI name="front" box="-1 -0.01 -1  2 0.01 2"/>
  {}
  <PartialLinearMovementProjectiveConstraint indices="@top.indices" keyTimes="0 1" movements="0 0 0  0 0 {}"
                                             movedDirections="{}" outside="hold"/>
  <Node name="cells"><TetrahedronSetTopologyContainer name="tets"/>
    <Hexa2TetraTopologicalMapping input="@../grid" output="@tets"/>
    <{} topology="{}" {}/></Node></Node>)",
      statics, held, move, friction ? "1 1 1" : "0 0 1", field, field == hexahedral ? "@../grid" : "@tets",
      law.attributes);
}

struct Pressed {
  explicit Pressed(const std::string& scene) : simulation(simulationFromText(scene)), report(simulation.step()) {}
  Simulation simulation;
  StepReport report;
};

/// Under strong uniaxial compression the force of this law falls again: its tangent is singular at 1/sqrt(3).
bool allows(const LawCase& law, double move) { return law.name != "StVenantKirchhoff" || move > -0.4; }

TEST(LargeSteps, ABlockBetweenPlatesWithoutFrictionStaysABlock) {
  for (const LawCase& law : lawCases())
    for (const std::string& field : {tetrahedral, hexahedral})
      for (const double move : {-0.5, 0.5}) {
        if (!allows(law, move) || !law.directions.empty()) continue;  // fibres askew shear the block
        SCOPED_TRACE(fmt::format("{} {} {}", law.name, field, move));
        const Pressed pressed_block(pressed(law, field, move, false));
        ASSERT_TRUE(pressed_block.report.newton_converged) << pressed_block.report.reason;
        const State& body = *pressed_block.simulation.states().front();
        const ConstRows x = body.x();
        const double side = x[x.count - 1][0];
        for (Index i = 0; i < x.count; ++i) {
          const Vec3& rest = body.rest_position[i];
          EXPECT_LT((Vec3(x[i]) - Vec3(side * rest[0], side * rest[1], (1 + move) * rest[2])).norm(), 1e-6);
        }
        EXPECT_GT((side - 1) * -move, 0);
      }
}

TEST(LargeSteps, ABlockBetweenRoughPlatesArrivesWhereSmallStepsLeadIt) {
  for (const LawCase& law : lawCases())
    for (const double move : {-0.5, 0.5}) {
      if (!allows(law, move)) continue;
      SCOPED_TRACE(fmt::format("{} {}", law.name, move));
      const Pressed at_once(pressed(law, tetrahedral, move, true));
      ASSERT_TRUE(at_once.report.newton_converged) << at_once.report.reason;
      Simulation slowly = simulationFromText(pressed(law, tetrahedral, move, true));
      slowly.setAttribute("/", "dt", "0.05");
      for (int i = 0; i < 20; ++i) ASSERT_TRUE(slowly.step().newton_converged);
      const ConstRows x = at_once.simulation.states().front()->x(), y = slowly.states().front()->x();
      for (Index i = 0; i < x.count; ++i) EXPECT_LT((x[i] - y[i]).norm(), 1e-5);
    }
}

TEST(LargeSteps, AStepThatMayNotBeDividedSaysWhyItFailed) {
  const LawCase& neo_hookean = lawCases()[1];
  const Pressed block(pressed(neo_hookean, tetrahedral, -0.9, true, "smallest_part='1'"));
  EXPECT_FALSE(block.report.newton_converged && !block.report.diverged);
  EXPECT_FALSE(block.report.reason.empty());
  EXPECT_EQ(block.report.load_parts, 1);
}

}  // namespace STROMA_TEST_FILE
