// SPDX-License-Identifier: LGPL-2.1-or-later
// Contact by forces of constraint in an implicit step: Coulomb's law on a slope, a fast body, a tool that is moved, steps
// in which nothing is near.
#include "framework/collision/pair_distances.h"
#include "framework/mechanics/state_topology.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string euler = "<EulerImplicitSolver/>";

/// A cube on a slope of 1 in 2, which is a plane with gravity that leans.
Simulation cubeOnSlope(double friction, const std::string& integrator = euler) {
  const double down = 9.81 / std::sqrt(1.25);
  return simulationFromText(contactScene(
      bodyNode("a", boxOf(Vec3(0, 0, 0.001), Vec3(1, 1, 1.001)),
               fmt::format("<ConstraintContact contactDistance=\"1e-3\" planes=\"0 0 1 0\" friction=\"{}\"/>", friction), "", 1e7),
      0.01, Vec3(0.5 * down, 0, -down), integrator));
}

TEST(ConstraintContact, WhatSticksDoesNotMove) {
  Simulation simulation = cubeOnSlope(0.505, "<EulerImplicitSolver rayleighMass=\"20\"/>");
  const State& state = *simulation.states().front();
  for (int i = 0; i < 50; ++i) {
    expectCleanStep(simulation, i);
    if (HasFatalFailure()) return;
  }
  // at rest: four corners that bear the weight, and none of them creeps
  std::vector<Vec3> before;
  for (Index node = 0; node < 8; ++node) before.push_back(state.x()[node]);
  for (int i = 0; i < 50; ++i) expectCleanStep(simulation, i);
  for (Index node = 0; node < 4; ++node)
    EXPECT_LT((state.x()[node] - before[std::size_t(node)]).norm(), 1e-12) << "node " << node;
}

TEST(ConstraintContact, WhatSlidesHasCoulombsForce) {
  Simulation simulation = cubeOnSlope(0.3);
  const System& system = *simulation.systems().front();
  for (int i = 0; i < 100; ++i) expectCleanStep(simulation, i);
  // steps of this rule add up g (sin - mu cos) dt^2 n (n + 1)/2
  const double expected = 9.81 / std::sqrt(1.25) * (0.5 - 0.3) * 1e-4 * 100 * 101 / 2;
  double moved = 0;
  for (Index node = 0; node < 8; ++node) moved += (system.x[node].x() - system.states().front()->rest_position[std::size_t(node)].x()) / 8;
  EXPECT_NEAR(moved, expected, 0.01 * expected);
}

/// Of a tool that is pressed into a cube: no triangle comes nearer than its radius and the gap.
TEST(ConstraintContact, NothingIsInWhatIsMoved) {
  const std::string held = "<BoxROI name=\"floor\" box=\"-1 -1 -0.1 2 2 0.1\"/><FixedProjectiveConstraint indices=\"@floor.indices\"/>";
  const Body cube = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {3, 3, 3});
  Simulation simulation = simulationFromText(contactScene(
      bodyNode("a", cube, held + "<ConstraintContact contactDistance=\"0.01\" spheres=\"0.5 0.45 1.32 0.3\" keyTimes=\"0 0.2 1\" "
                                 "movements=\"0 0 0  0 0 -0.1  0.1 0 -0.1\" friction=\"0.2\"/>", "", 1e5),
      0.02, Vec3::Zero(), "<EulerImplicitSolver rayleighMass=\"20\"/>"));
  const State& state = *simulation.states().front();
  const auto triangles = topologyOf(state)->mesh().boundaryTriangles();
  double nearest = 1;
  for (int i = 1; i <= 30; ++i) {
    expectCleanStep(simulation, i);
    if (HasFatalFailure()) return;
    const double t = 0.02 * i;
    const Vec3 centre(0.5 + (t > 0.2 ? 0.1 * (t - 0.2) / 0.8 : 0), 0.45, 1.32 - 0.1 * std::min(1.0, t / 0.2));
    for (const Triangle& f : triangles)
      nearest = std::min(
          nearest, closestPoints(PairKind::point_triangle, {centre, state.x()[f[0]], state.x()[f[1]], state.x()[f[2]]}).distance());
  }
  EXPECT_NEAR(nearest, 0.31, 1e-8);
  EXPECT_GT(-constraintOutput(simulation, "wrenches").at(2), 0) << "the cube is pressed down";
}

/// Three times as far in a step as it is away from what it meets.
TEST(ConstraintContact, WhatIsFastDoesNotPass) {
  Simulation simulation = simulationFromText(contactScene(
      bodyNode("a", boxOf(Vec3(0, 0, 1), Vec3(1, 1, 2)), "<ConstraintContact contactDistance=\"0.01\" planes=\"0 0 1 0.6\"/>",
               "velocity=\"0 0 -60  0 0 -60  0 0 -60  0 0 -60  0 0 -60  0 0 -60  0 0 -60  0 0 -60\"", 1e9),
      0.02, Vec3::Zero(), euler));
  const State& state = *simulation.states().front();
  for (int i = 0; i < 3; ++i) expectCleanStep(simulation, i);
  for (Index node = 0; node < 8; ++node) EXPECT_GT(state.x()[node].z(), 0.61 - 1e-9) << "node " << node;
}

/// A sphere under a node of the bottom of a cube that falls on it, far deeper in a step than the sphere is large: it is held, or the
/// step says that it does not know.
TEST(ConstraintContact, ASphereUnderANodeIsNotPassed) {
  for (const double speed : {-0.1, -2.0, -18.0, -60.0}) {
    SCOPED_TRACE(speed);
    std::string velocity = "velocity=\"";
    for (int i = 0; i < 27; ++i) velocity += fmt::format("0 0 {} ", speed);
    Simulation simulation = simulationFromText(contactScene(
        bodyNode("a", boxOf(Vec3(-0.5, -0.5, 0.4), Vec3(0.5, 0.5, 1.4), {2, 2, 2}),
                 "<ConstraintContact contactDistance=\"0.01\" spheres=\"0 0 0 0.05\"/>", velocity + "\"", 1e8),
        0.05, Vec3::Zero(), euler));
    const State& state = *simulation.states().front();
    int done = 0;
    for (int i = 0; i < (speed == -2 ? 10 : 100); ++i, ++done) {
      const StepReport report = simulation.step();
      if (report.failed() || !report.constraints_converged) break;
      ASSERT_GT(state.x()[4].norm(), 0.06 - 1e-9) << "step " << i;
      ASSERT_GT(state.x()[4].z(), 0) << "step " << i;
    }
    if (speed == -0.1 || speed == -2) {
      EXPECT_EQ(done, speed == -2 ? 10 : 100) << "half a contact distance per step, or ten";
    }
  }
}

/// A node comes straight down on a sphere. In the step in which it would go into it, it stops where the gap is kept, whatever its
/// speed, and in each step what pushes takes the momentum that the body loses (implicit Euler: m (v1 - v0) = dt l n).
TEST(ConstraintContact, ANodeIsStoppedByASphereAtAnySpeed) {
  constexpr double dt = 0.05;
  for (const double speed : {-0.04, -0.11, -0.3, -0.5, -1.0, -2.0}) {
    SCOPED_TRACE(speed);
    std::string velocity = "velocity=\"";
    for (int i = 0; i < 27; ++i) velocity += fmt::format("0 0 {} ", speed);
    Simulation simulation = simulationFromText(contactScene(
        bodyNode("a", boxOf(Vec3(-0.5, -0.5, 0.1), Vec3(0.5, 0.5, 1.1), {2, 2, 2}),
                 "<ConstraintContact contactDistance=\"0.01\" spheres=\"0 0 0 0.05\"/>", velocity + "\"", 1e8),
        dt, Vec3::Zero(), euler));
    const System& system = *simulation.systems().front();
    const std::vector<double>& mass = system.masses().front()->lumped();
    const auto momentum = [&] {
      Vec3 sum = Vec3::Zero();
      for (Index node = 0; node < 27; ++node) sum += mass[std::size_t(node)] * system.v[node];
      return sum;
    };
    const double whole = std::abs(momentum().z());
    int stopped = 0;
    for (int i = 1; i <= 40; ++i) {
      const Vec3 before = momentum();
      expectCleanStep(simulation, i);
      if (HasFatalFailure()) return;
      const std::vector<double> push = constraintOutput(simulation, "wrenches");
      ASSERT_EQ(push.size(), 6u);
      EXPECT_LT((momentum() - before - dt * Vec3(push[0], push[1], push[2])).norm(), 1e-9 * whole) << "step " << i;
      const double away = system.x[4].norm();
      ASSERT_GE(away, 0.06 - 1e-9) << "step " << i;
      if (push[2] == 0) continue;
      EXPECT_GT(push[2], 0) << "step " << i;
      if (++stopped > 1) continue;
      EXPECT_NEAR(system.x[4].z(), 0.06, 1e-6) << "where it first meets the sphere";
      EXPECT_NEAR(0.1 + i * dt * speed, 0.06 + 0.5 * dt * speed, -0.5 * dt * speed + 1e-9) << "in the step that would take it in";
    }
    EXPECT_GT(stopped, 0);
  }
}

TEST(ConstraintContact, AnObstacleInsideIsRefused) {
  const std::string problems = problemsOf(contactScene(
      bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)), "<ConstraintContact contactDistance=\"0.01\" spheres=\"0.5 0.5 0.5 0.1\"/>"),
      0.01, Vec3::Zero(), euler));
  expectContains(problems, "is inside of a body");
}

/// Somebody else puts nodes into what they keep a distance from: the next step is refused.
TEST(ConstraintContact, WhatIsPutIntoAnObstacleIsRefused) {
  Simulation simulation = simulationFromText(contactScene(
      bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)), "<ConstraintContact contactDistance=\"0.01\" planes=\"0 0 1 -0.02\"/>"), 0.01,
      Vec3::Zero(), euler));
  expectCleanStep(simulation, 1);
  System& system = *simulation.systems().front();
  for (Index node = 0; node < 8; ++node) system.x[node] -= Vec3(0, 0, 0.049);
  EXPECT_THROW(simulation.step(), ComponentError);
}

/// Nearer than the gap that is kept: a plane below a cube, and a sphere below its bottom. The first step parts them.
TEST(ConstraintContact, AStartNearerThanTheGapIsParted) {
  for (const char* obstacle : {"planes=\"0 0 1 -0.02\"", "spheres=\"0.6 0.5 -0.22 0.2\""}) {
    const auto scene = [&](double distance) {
      return contactScene(bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)),
                                   fmt::format("<ConstraintContact contactDistance=\"{}\" {}/>", distance, obstacle)),
                          0.01, Vec3::Zero(), euler);
    };
    const std::string problems = saidOf(scene(0.05));
    expectContains(problems, "of /a/dofs starts with a gap of 0.02 m, and contactDistance is 0.05 m");
    expectContains(problems, "gaps that are not smaller than contactDistance");
    EXPECT_EQ(saidOf(scene(0.02)), "") << "a start at the gap is none";
    Simulation simulation = simulationFromText(scene(0.05));
    for (int i = 1; i <= 3; ++i) {
      expectCleanStep(simulation, i);
      EXPECT_GT(constraintOutput(simulation, "smallestGap").at(0), 0.05 - 1e-4) << obstacle << ", step " << i;
    }
  }
}

TEST(ConstraintContact, AStartInOneAnotherIsRefused) {
  const std::string problems = problemsOf(contactScene(
      bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)), "<ConstraintContact planes=\"0 0 1 0.5\"/>"), 0.01, Vec3::Zero(), euler));
  expectContains(problems, "node 0 of /a/dofs is 0.5 m inside a plane");
}

/// A bar that is held at one end, as it bends under its weight; no linear solver is named. `more`: in its node.
std::string heldBar(const std::string& integrator, const std::string& more) {
  const std::string held = "<BoxROI name=\"end\" box=\"-0.01 -9 -9 0.01 9 9\"/><FixedProjectiveConstraint indices=\"@end.indices\"/>";
  const Body body = boxOf(Vec3(0, 0, 0), Vec3(1, 0.2, 0.2), {10, 2, 2});
  return fmt::format("<Node name=\"root\" dt=\"0.02\" gravity=\"0 0 -9.81\">{}{}</Node>", integrator,
                     bodyNode("a", body, held + more, "", 1e5));
}

const std::string far = "<ConstraintContact name=\"contact\" contactDistance=\"0.01\" planes=\"0 0 1 -3\" friction=\"0.2\"/>";
/// It is watched from the first step on, and never met: the bar falls along it.
const std::string beside = "<ConstraintContact name=\"contact\" contactDistance=\"0.01\" planes=\"0 1 0 -0.02\"/>";

struct Steps {
  std::vector<int> newton, linear;
  Vector x;
  explicit Steps(const std::string& text, int steps = 12) {
    Simulation simulation = simulationFromText(text);
    for (int step = 0; step < steps; ++step) {
      const StepReport report = simulation.step();
      EXPECT_TRUE(report.newton_converged && !report.failed() && report.constraints_converged) << "step " << step << report.reason;
      newton.push_back(report.newton_iterations), linear.push_back(report.linear_iterations);
    }
    const Vector& end = simulation.systems().front()->x;
    x.resize(end.count());
    copy(end, x);
  }
};

TEST(ConstraintContact, WhereNothingIsNearAStepIsThatWithoutContact) {
  for (const char* integrator : {"<EulerImplicitSolver newtonIterations=\"30\"/>", "<TrapezoidalRuleSolver newtonIterations=\"30\"/>",
                                 "<BDFOdeSolver order=\"2\" newtonIterations=\"30\"/>", "<TrapezoidalRuleSolver/>"}) {
    const Steps without(heldBar(integrator, ""));
    EXPECT_GT(without.linear.back(), without.newton.back()) << "products solve";
    for (const std::string& contact : {far, beside}) {
      SCOPED_TRACE(integrator + contact);
      const Steps with(heldBar(integrator, contact));
      EXPECT_EQ(with.newton, without.newton);
      EXPECT_EQ(with.linear, without.linear);
      for (Index i = 0; i < with.x.count(); ++i) ASSERT_EQ(Vec3(with.x[i]), Vec3(without.x[i])) << "node " << i;
    }
  }
}

/// Its free end meets a plane in the fourth step or so: what is solved roughly before has no part in what is found.
TEST(ConstraintContact, WhatMeetsSomethingIsSolvedToTheSameTolerance) {
  const std::string contact = "<ConstraintContact name=\"contact\" contactDistance=\"0.01\" planes=\"0 0 1 -0.03\" friction=\"0.2\"/>";
  const auto scene = [&](const char* forcing) {
    return heldBar(fmt::format("<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-7\" newtonForcing=\"{}\"/>", forcing),
                   contact);
  };
  Simulation rough = simulationFromText(scene("0.1")), exact = simulationFromText(scene("0"));
  const Vector &x = rough.systems().front()->x, &y = exact.systems().front()->x;
  int met = 0, rough_products = 0, exact_products = 0;
  for (int step = 1; step <= 8; ++step) {
    const StepReport one = rough.step(), other = exact.step();
    SCOPED_TRACE(step);
    for (const StepReport& report : {one, other}) {
      ASSERT_FALSE(report.failed()) << report.reason;
      EXPECT_TRUE(report.newton_converged && report.constraints_converged) << report.reason << report.constraint_reason;
      EXPECT_LE(report.newton_residual, 1e-7);
    }
    double lowest = 1;
    for (Index i = 0; i < x.count(); ++i) {
      lowest = std::min(lowest, x[i].z());
      EXPECT_LT((x[i] - y[i]).norm(), 1e-6) << "node " << i;
    }
    EXPECT_GE(lowest, -0.03 + 0.01 - 1.001e-5) << "gaps may be off by a thousandth";
    const double pushes = constraintOutput(rough, "wrenches").at(2);
    if (met == 0 && pushes == 0) rough_products += one.linear_iterations, exact_products += other.linear_iterations;
    met += pushes > 0;
    if (met == 1) EXPECT_LT(lowest, -0.03 + 0.01 + 1e-4);
  }
  EXPECT_GT(met, 3);
  EXPECT_LT(rough_products, exact_products);
}

/// Forces that another body carries keep a step from being tried without forces: what is tried leaves no trace in what is found.
TEST(ConstraintContact, AStepThatIsTriedWithoutForcesLeavesNoTrace) {
  const std::string bar = heldBar("<EulerImplicitSolver newtonIterations=\"90\" newtonTolerance=\"1e-11\"/>",
                                  "<ConstraintContact name=\"contact\" contactDistance=\"0.01\" planes=\"0 0 1 -0.03\" friction=\"0.2\" "
                                  "toleratedError=\"1e-9\" spheres=\"1.02 0.1 -0.1 0.06\"/>");
  std::string both = bar;
  both.insert(both.rfind("</Node>"), bodyNode("b", boxOf(Vec3(0, 5, 0), Vec3(0.2, 5.2, 0.2)),
                                              "<ConstraintContact contactDistance=\"0.01\" planes=\"0 0 1 -0.01\"/>", "", 1e5));
  Simulation tried = simulationFromText(bar), carrying = simulationFromText(both);
  const State &one = *tried.states().front(), &other = *carrying.states().front();
  ASSERT_EQ(one.path(), other.path());
  int met = 0;
  for (int step = 1; step <= 10; ++step) {
    SCOPED_TRACE(step);
    for (Simulation* simulation : {&tried, &carrying}) {
      const StepReport report = simulation->step();
      ASSERT_TRUE(report.newton_converged && report.constraints_converged) << report.reason << report.constraint_reason;
    }
    for (Index i = 0; i < one.size(); ++i) EXPECT_LT((one.x()[i] - other.x()[i]).norm(), 1e-8) << "node " << i;
    met += constraintOutput(tried, "wrenches").at(2) > 0;
  }
  EXPECT_GT(met, 2);
  EXPECT_LT(met, 9) << "steps are tried before that";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
