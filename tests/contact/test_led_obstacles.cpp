// SPDX-License-Identifier: LGPL-2.1-or-later
// Obstacles that a hand leads while a scene runs: however fast, they stop at what they meet.
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double radius = 0.15, top = 0.3;
const Vec3 centre(0.5, 0.5, top + radius + 0.05);

/// A soft block that is held at its bottom, and a ball above it.
std::string ballOverBlock(const std::string& type, double range) {
  const Body block = boxOf(Vec3(0, 0, 0), Vec3(1, 1, top), {5, 5, 2});
  std::string bottom;
  for (int i = 0; i < 36; ++i) bottom += fmt::format("{} ", i);
  return contactScene(
      bodyNode("a", block, fmt::format("<FixedProjectiveConstraint indices=\"{}\"/>", bottom), "", 1e4, 0.3) +
          fmt::format("<{} name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" contactDistance=\"{}\" friction=\"0.2\" "
                      "selfContact=\"false\" spheres=\"{} {} {} {}\"/>",
                      type, range, centre[0], centre[1], centre[2], radius),
      0.01, Vec3::Zero(), "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-4\"/>");
}

Vec3 vectorOf(const Simulation& simulation, const char* name) {
  std::vector<Component*> all;
  simulation.root().collect(all);
  Vec3 v = Vec3::Zero();
  for (const Component* component : all)
    if (component->name() == "contact") std::istringstream(component->data().find(name)->print()) >> v[0] >> v[1] >> v[2];
  return v;
}

void lead(Simulation& simulation, const Vec3& offset) {
  simulation.setAttribute("/contact", "offset", fmt::format("{} {} {}", offset[0], offset[1], offset[2]));
}

/// The nearest node of the block's surface to that of the ball [m]. A ball that presses a surface down to the bottom turns cells of this
/// law inside out: their inner nodes may be anywhere.
double gapOfBall(const Simulation& simulation) {
  const Vec3 now = centre + vectorOf(simulation, "moved");
  const State& state = *simulation.states().front();
  double least = 1e300;
  for (Index node = 0; node < state.size(); ++node) {
    const Index i = node % 6, j = node / 6 % 6, k = node / 36;
    const bool is_inside = i % 5 != 0 && j % 5 != 0 && k == 1;
    if (!is_inside) least = std::min(least, (Vec3(state.x()[node]) - now).norm() - radius);
  }
  return least;
}

/// Thrust through the block to the other side, torn sideways and back: jumps of up to 1 m in a step of 10 ms.
class LedAnyhow : public testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(LedObstacles, LedAnyhow, testing::Values(5, 7, 11));

TEST_P(LedAnyhow, StopAtWhatTheyMeetHoweverFast) {
  Simulation simulation = simulationFromText(ballOverBlock("BarrierContact", 0.01));
  std::mt19937 random(GetParam());
  std::uniform_real_distribution<double> uniform(-1, 1);
  bool was_late = false;
  for (int step = 0; step < 24; ++step) {
    Vec3 offset(0, 0, -0.1 * (step + 1));
    if (step >= 8) {
      const double x = 0.4 * uniform(random), y = 0.4 * uniform(random);  // one after the other: the order of arguments is a compiler's
      offset = Vec3(x, y, -0.5 * (1 + uniform(random)));
    }
    lead(simulation, offset);
    expectCleanStep(simulation, step, false);
    ASSERT_EQ(outputOf(simulation, "crossings"), 0) << "step " << step;
    ASSERT_GE(outputOf(simulation, "smallestGap"), 0) << "step " << step;  // 0: nothing is in reach
    ASSERT_GT(gapOfBall(simulation), 0) << "step " << step;
    was_late = was_late || (vectorOf(simulation, "moved") - offset).norm() > 0.05;
  }
  EXPECT_TRUE(was_late) << "nothing was in its way";
  lead(simulation, Vec3(0, 0, 0.3));
  for (int step = 0; step < 40 && vectorOf(simulation, "moved") != Vec3(0, 0, 0.3); ++step) {
    expectCleanStep(simulation, step, false);
    ASSERT_EQ(outputOf(simulation, "crossings"), 0);
  }
  EXPECT_EQ(vectorOf(simulation, "moved"), Vec3(0, 0, 0.3)) << "the way back is free";
}

/// A ball that is pressed in by ten times contactDistance per step closes its gaps to some thousandths of that. Obstacles that went on
/// only as far as bodies let them where they stand would go by such a gap per solve: 29,500 iterations in these ten steps.
TEST(LedObstacles, GoOnWithWhatGivesWay) {
  const Body block = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 0.3), {8, 8, 3});
  std::string bottom;
  for (int i = 0; i < 81; ++i) bottom += fmt::format("{} ", i);
  Simulation simulation = simulationFromText(contactScene(
      bodyNode("a", block, fmt::format("<FixedProjectiveConstraint indices=\"{}\"/>", bottom), "", 1e4, 0.3) +
          "<BarrierContact name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" contactDistance=\"0.005\" selfContact=\"false\" "
          "spheres=\"0.5 0.5 0.46 0.15\" keyTimes=\"0 0.1\" movements=\"0 0 0  0 0 -0.1\"/>",
      0.01, Vec3::Zero(), "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-4\"/>"));
  int iterations = 0;
  for (int step = 0; step < 10; ++step) {
    const StepReport report = simulation.step();
    EXPECT_TRUE(report.newton_converged && !report.failed()) << report.reason;
    iterations += report.newton_iterations;
  }
  EXPECT_EQ(vectorOf(simulation, "moved"), Vec3(0, 0, -0.1));
  EXPECT_LT(outputOf(simulation, "smallestGap"), 0.01 * 0.005) << "gaps are small";
  EXPECT_LT(iterations, 1500);
}

/// What nothing stops comes in the step.
TEST(LedObstacles, ComeAtOnceWhereNothingIsInTheWay) {
  Simulation simulation = simulationFromText(ballOverBlock("BarrierContact", 0.01));
  lead(simulation, Vec3(0.3, -2, 1));
  expectCleanStep(simulation, 0, false);  // without any load there is nothing to converge to
  EXPECT_EQ(vectorOf(simulation, "moved"), Vec3(0.3, -2, 1));
}

/// A run goes on from a checkpoint in the midst of a way.
TEST(LedObstacles, GoOnFromACheckpoint) {
  Simulation simulation = simulationFromText(ballOverBlock("BarrierContact", 0.01));
  for (int step = 0; step < 4; ++step) {
    lead(simulation, Vec3(0.1, 0, -0.1 * (step + 1)));
    expectCleanStep(simulation, step, false);
  }
  ASSERT_NE(vectorOf(simulation, "moved"), Vec3(0.1, 0, -0.4)) << "it has come already";
  const auto checkpoint = simulation.checkpoint();
  Simulation other = simulationFromText(ballOverBlock("BarrierContact", 0.01));
  other.restore(checkpoint);
  for (int step = 0; step < 3; ++step) {
    expectCleanStep(simulation, step, false), expectCleanStep(other, step, false);
    EXPECT_EQ(simulation.stateHash(), other.stateHash()) << "step " << step;
    EXPECT_EQ(vectorOf(simulation, "moved"), vectorOf(other, "moved"));
  }
}

/// Forces of constraint refuse what they cannot prove, so a hand leads the ball by an eighth of the mean edge per step.
TEST(LedObstacles, ConstraintsAreLedInShortSteps) {
  Simulation simulation = simulationFromText(ballOverBlock("ConstraintContact", 0.01));
  lead(simulation, Vec3(0, 0, -0.12));
  Vec3 before = Vec3::Zero();
  for (int step = 0; step < 12; ++step) {
    expectCleanStep(simulation, step, false);
    const Vec3 now = vectorOf(simulation, "moved");
    EXPECT_LT((now - before).norm(), 0.125 * 0.35) << "step " << step;  // no edge is longer
    EXPECT_GT(gapOfBall(simulation), 0.9 * 0.01) << "step " << step;
    before = now;
  }
  EXPECT_EQ(before, Vec3(0, 0, -0.12));
}

/// A reset takes bodies back to where they were written, and obstacles too. From there they are led to where the hand still is.
TEST(LedObstacles, BeginAgainAfterAReset) {
  for (const char* type : {"BarrierContact", "ConstraintContact", "PenaltyContact"}) {
    SCOPED_TRACE(type);
    Simulation simulation = simulationFromText(ballOverBlock(type, 0.01));
    lead(simulation, Vec3(0, 0, -0.12));
    for (int step = 0; step < 12; ++step) expectCleanStep(simulation, step, false);
    simulation.reset();
    EXPECT_EQ(vectorOf(simulation, "moved"), Vec3(0, 0, 0));
    for (int step = 0; step < 3; ++step) {
      expectCleanStep(simulation, step, false);
      if (HasFatalFailure()) return;
      EXPECT_GT(gapOfBall(simulation), 0) << "step " << step;
    }
    EXPECT_LT(vectorOf(simulation, "moved").z(), 0) << "nobody leads it";
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
