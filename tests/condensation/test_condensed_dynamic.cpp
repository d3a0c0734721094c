// SPDX-License-Identifier: LGPL-2.1-or-later
// The condensed dynamic solver against the paper's scheme on the whole matrix, formed here, and against closed forms.
#include <Eigen/Dense>

#include "tests/condensation/bodies.h"

using namespace stroma;
using namespace stroma::test;

namespace {

/// Masses on the boundary of the block alone (elsewhere nothing to speak of): what condensation keeps is then all there
/// is.
std::string surfaceMasses() {
  std::string list;
  for (int k = 0; k < 7; ++k)
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 5; ++i) {
        const bool inside = i > 0 && i < 4 && j > 0 && j < 3 && k > 0 && k < 6;
        list += inside ? "1e-25 " : std::to_string(0.004 + 0.001 * (i + j)) + " ";
      }
  return "<DiagonalMass vertexMass=\"" + list + "\"/>";
}

}  // namespace

/// A body that runs with some memory runs with more: where the inverse does not fit beside what makes it, the factor of
/// the whole body is taken.
TEST(CondensedDynamic, MoreMemoryIsNeverRefusedWhereLessWillDo) {
  bool has_run = false, was_refused = false, was_inverted = false;
  for (double limit = 2e-4; limit < 4e-3; limit *= 1.03) {
    Block block{.solver =
                    "<CondensedDynamicSolver condensed=\"false\" memoryLimit=\"" + std::to_string(limit) + "\"/>"};
    const std::string problems = problemsOf(block.text());
    has_run = has_run || problems.empty();
    was_refused = was_refused || !problems.empty();
    EXPECT_TRUE(problems.empty() || !has_run) << limit << " GB: " << problems;
    if (problems.empty() && !was_inverted)
      was_inverted = simulationFromText(block.text())
                         .systems()[0]
                         ->integrator()
                         .describe()
                         .find(
                             "no memory for the "
                             "inverse") == std::string::npos;
  }
  EXPECT_TRUE(has_run && was_refused && was_inverted);
}

TEST(CondensedDynamic, EqualsTheFullSystemWithTheSameMasses) {
  Block block{.solver = "", .loads = "<ConstantForceField indices=\"139 138\" totalForce=\"0.05 0.02 -0.03\"/>"};
  block.mass = surfaceMasses();
  for (const int steps : {1, 7, 60}) {
    block.solver = "<CondensedDynamicSolver condensed=\"false\" solve=\"factor\" rayleighMass=\"1.5\"/>";
    const Vector expected = after(block.text(), steps);
    EXPECT_GT(norm(expected), 1e-5);
    for (const std::string other :
         {"", "interiorMass=\"shared\"", "interiorMass=\"neglected\"", "condensed=\"false\" solve=\"inverse\""}) {
      block.solver = "<CondensedDynamicSolver rayleighMass=\"1.5\" " + other + "/>";
      EXPECT_LT(difference(after(block.text(), steps), expected), 1e-10) << other << " after " << steps;
    }
  }
}

TEST(CondensedDynamic, KeepsTheMassInsideExactly) {
  // loads that change in time inside and outside, and a node that is dragged
  Block block{.solver = "",
              .loads =
                  "<ConstantForceField indices=\"139 138\" totalForce=\"0.05 0.02 -0.03\"/>"
                  "<LinearForceField points=\"66 67 86 131\" times=\"0 0.1 0.5 3\" forces=\"0 0 0  0.2 0 -0.4  "
                  "-0.3 0.1 0  0 0 0\"/>"};
  const std::string dragged =
      "<LinearMovementProjectiveConstraint indices=\"120\" keyTimes=\"0 0.3 2\" movements=\"0 0 0  0.004 0 0.002  0 0 "
      "0\"/>";
  for (const std::string cells : {"tetrahedra", "hexahedra"})
    for (const std::string& more : {std::string(), dragged})
      for (const int steps : {1, 7, 60}) {
        block.cells = cells, block.more = more;
        block.solver = "<CondensedDynamicSolver condensed=\"false\" solve=\"factor\" rayleighMass=\"1.5\"/>";
        const Vector expected = after(block.text(), steps);
        block.solver = "<CondensedDynamicSolver rayleighMass=\"1.5\"/>";
        EXPECT_GT(*std::get<int*>(simulationFromText(block.text())
                                      .systems()
                                      .front()
                                      ->integrator()
                                      .data()
                                      .find("interiorNodes")
                                      ->pointer()),
                  20);
        EXPECT_LT(difference(after(block.text(), steps), expected), 1e-10) << cells << more << " after " << steps;
        block.solver = "<CondensedDynamicSolver rayleighMass=\"1.5\" precision=\"single\"/>";
        EXPECT_LT(difference(after(block.text(), steps), expected), 1e-4) << cells << more << " after " << steps;
        block.solver = "<CondensedDynamicSolver rayleighMass=\"1.5\" interiorMass=\"shared\"/>";
        EXPECT_GT(difference(after(block.text(), steps), expected), 1e-4) << cells << more << " after " << steps;
      }
}

TEST(CondensedDynamic, IsThePapersSchemeOnTheWholeMatrix) {
  Block block{.solver = "<CondensedDynamicSolver condensed=\"false\" rayleighMass=\"3\"/>",
              .loads = "<ConstantForceField indices=\"139\" totalForce=\"0.05 0.02 -0.03\"/>"};
  Simulation simulation = simulationFromText(block.text());
  System& system = *simulation.systems().front();
  const Index n = 3 * system.allRows();
  // K by columns of forces, so that nothing of the solver's own assembly is used
  Vector f0(system.allRows()), f1(system.allRows()), x(system.allRows()), v(system.allRows());
  copy(system.x, x);
  system.computeForce(x, v, f0);
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd load(n);
  std::vector<char> held(std::size_t(n), 0);
  for (Index j = 0; j < n; ++j) {
    held[j] = j < 60;
    load[j] = f0[j / 3][j % 3];
    x[j / 3][j % 3] += 0.5;
    system.computeForce(x, v, f1);
    x[j / 3][j % 3] -= 0.5;
    for (Index i = 0; i < n; ++i) k(i, j) = -2 * (f1[i / 3][i % 3] - f0[i / 3][i % 3]);
  }
  const double m = 0.7 / system.allRows(), d = 3 * m, dt = 0.02;
  Eigen::MatrixXd a = k + (m / (dt * dt) + d / (2 * dt)) * Eigen::MatrixXd::Identity(n, n);
  for (Index j = 0; j < n; ++j)
    if (held[j]) a.row(j).setZero(), a.col(j).setZero(), a(j, j) = 1, load[j] = 0;
  const Eigen::LDLT<Eigen::MatrixXd> inverse(a);
  Eigen::VectorXd before = Eigen::VectorXd::Zero(n), now = before;
  for (int i = 0; i < 20; ++i) {
    simulation.step();
    const Eigen::VectorXd next = inverse.solve(load + m / (dt * dt) * (2 * now - before) + d / (2 * dt) * before);
    before = now, now = next;
    const Vector u = displacement(simulation);
    double error = 0;
    for (Index j = 0; j < n; ++j) error = std::max(error, std::abs(u[j / 3][j % 3] - now[j]));
    ASSERT_LT(error, 1e-10 * now.norm()) << "step " << i;
  }
  EXPECT_GT(now.norm(), 1e-3);
}

namespace {

/// The whole body on another grid.
std::string wholeBody(const std::string& nodes, const std::string& attributes = "") {
  std::string text = Block{.solver = "<CondensedDynamicSolver condensed=\"false\" " + attributes + "/>"}.text();
  return text.replace(text.find("5 4 7"), 5, nodes);
}

std::string planOf(const Simulation& simulation) { return simulation.systems().front()->integrator().describe(); }

}  // namespace

TEST(CondensedDynamic, WholeBodiesAreSolvedByTheFormThatIsMeasuredToBeFaster) {
  for (const std::string nodes : {"5 4 2", "5 4 7", "7 7 8", "9 9 10"})
    for (const std::string precision : {"double", "single"}) {
      const std::string plan = planOf(simulationFromText(wholeBody(nodes, "precision=\"" + precision + "\"")));
      const std::string start = "; measured when it was made: ", at_least = "at least ";
      const auto at = plan.find(start);
      ASSERT_NE(at, std::string::npos) << plan;
      std::size_t length = 0;
      std::string rest = plan.substr(at + start.size());
      const double by_factor = std::stod(rest, &length);
      rest = rest.substr(length);
      ASSERT_EQ(rest.find(" ms by the factor, "), 0u) << plan;
      rest = rest.substr(std::string(" ms by the factor, ").size());
      if (rest.find(at_least) == 0) rest = rest.substr(at_least.size());
      const double by_inverse = std::stod(rest);
      EXPECT_GT(by_factor, 0);
      // the numbers are rounded to three digits
      if (std::abs(by_factor / by_inverse - 1) < 0.01) continue;
      EXPECT_EQ(plan.find("through the sparse factor") != std::string::npos, by_factor < by_inverse) << plan;
    }
  for (const std::string choice : {"inverse", "factor"})
    EXPECT_EQ(planOf(simulationFromText(wholeBody("5 4 7", "solve=\"" + choice + "\""))).find("measured"),
              std::string::npos);
}

TEST(CondensedDynamic, ABodyThatIsLoadedAgainHasTheSameForm) {
  // of a size at which both take the same time
  const auto run = [] {
    Simulation simulation = simulationFromText(wholeBody("6 6 6"));
    for (int i = 0; i < 3; ++i) simulation.step();
    return std::pair(planOf(simulation), simulation.stateHash());
  };
  const auto first = run();
  for (int i = 0; i < 5; ++i) EXPECT_EQ(run(), first);
}

TEST(CondensedDynamic, AnInverseThatDoesNotFitIsNotMadeWhereTheFactorDoes) {
  const std::string plan = planOf(simulationFromText(wholeBody("5 4 6", "memoryLimit=\"0.001\"")));
  EXPECT_NE(plan.find("through the sparse factor"), std::string::npos) << plan;
  EXPECT_NE(plan.find("no memory for the inverse"), std::string::npos) << plan;
}

TEST(CondensedDynamic, OscillatorHasTheSchemesRoots) {
  // one node on a spring: m u'' + alpha m u' + k u = 0 from u_0
  const double m = 0.5, spring = 200, alpha = 1.2, dt = 0.01, u0 = 0.3;
  const std::string scene =
      "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><CondensedDynamicSolver rayleighMass=\"1.2\"/>"
      "<MechanicalObject position=\"1.3 0 0\" rest_position=\"1 0 0\"/><UniformMass totalMass=\"0.5\"/>"
      "<RestShapeSpringsForceField points=\"0\" stiffness=\"200\"/></Node>";
  Simulation simulation = simulationFromText(scene);
  // (1 + a + w^2 dt^2) u+ = 2 u - (1 - a) u-
  const double a = alpha * dt / 2, w2 = spring / m * dt * dt;
  double before = u0, now = u0;
  for (int i = 0; i < 200; ++i) {
    simulation.step();
    const double next = (2 * now - (1 - a) * before) / (1 + a + w2);
    before = now, now = next;
    const double x = simulation.systems().front()->x[0][0] - 1;
    ASSERT_NEAR(x, now, 1e-12) << "step " << i;
  }
}

TEST(CondensedDynamic, TendsToTheDampedOscillationAtFirstOrder) {
  const double m = 0.5, spring = 200, alpha = 1.2, u0 = 0.3, end = 0.5;
  const double decay = alpha / 2, w = std::sqrt(spring / m - decay * decay);
  const double exact = u0 * std::exp(-decay * end) * (std::cos(w * end) + decay / w * std::sin(w * end));
  std::vector<double> errors;
  for (const int steps : {500, 1000, 2000, 4000}) {
    Simulation simulation = simulationFromText(
        "<Node name=\"root\" dt=\"" + std::to_string(end / steps) +
        "\" gravity=\"0 0 0\"><CondensedDynamicSolver rayleighMass=\"1.2\"/><MechanicalObject position=\"1.3 0 0\" "
        "rest_position=\"1 0 0\"/><UniformMass totalMass=\"0.5\"/><RestShapeSpringsForceField points=\"0\" "
        "stiffness=\"200\"/></Node>");
    for (int i = 0; i < steps; ++i) simulation.step();
    errors.push_back(std::abs(simulation.systems().front()->x[0][0] - 1 - exact));
  }
  for (std::size_t i = 1; i < errors.size(); ++i) EXPECT_NEAR(errors[i - 1] / errors[i], 2, 0.15);
}

namespace {

/// Period of the block's swing from a push at its top, by the times at which the top's middle passes its rest place.
double periodOf(const std::string& attributes) {
  Block block{.solver = "<CondensedDynamicSolver " + attributes + "/>",
              .loads = "<LinearForceField points=\"" + Block::nodes(120, 140) +
                       "\" times=\"0 0.0005 0.001\" forces=\"0 0 0  5 0 0  0 0 0\"/>",
              .gravity = "0 0 0",
              .dt = 0.0005};
  Simulation simulation = simulationFromText(block.text());
  simulation.computeOnDemand(true);
  const System& system = *simulation.systems().front();
  const double rest = system.x[127][0];
  std::vector<double> crossings;
  double before = 0;
  for (int i = 0; i < 4000 && crossings.size() < 5; ++i) {
    simulation.step();
    const double now = system.x[127][0] - rest;
    if (before * now < 0) crossings.push_back(simulation.time() - simulation.dt() * now / (now - before));
    before = now;
  }
  EXPECT_EQ(crossings.size(), 5u);
  return crossings.empty() ? 0 : (crossings.back() - crossings.front()) / 2;
}

}  // namespace

TEST(CondensedDynamic, SharedMassKeepsThePeriodOfTheWholeBody) {
  const double full = periodOf("condensed=\"false\"");
  EXPECT_NEAR(periodOf("interiorMass=\"exact\"") / full, 1, 1e-9);
  EXPECT_NEAR(periodOf("interiorMass=\"shared\"") / full, 1, 0.01);
  // 30 of 120 free nodes have no inertia: faster
  EXPECT_LT(periodOf("interiorMass=\"neglected\"") / full, 0.95);
}

TEST(CondensedDynamic, SlidingNodesStayInTheirPlane) {
  Block block{.solver = "<CondensedDynamicSolver/>", .mass = surfaceMasses()};
  block.more = "<FixedPlaneProjectiveConstraint name=\"plane\" direction=\"0 1 1\" indices=\"64 128 139\"/>";
  std::string scene = block.text();
  const std::string moving = "<MechanicalObject name=\"dofs\" velocity=\"";
  std::string velocities;
  for (int i = 0; i < 140; ++i) velocities += i < 20 ? "0 0 0 " : "0.1 0.3 -0.1 ";
  scene.replace(scene.find("<MechanicalObject name=\"dofs\""), 29, moving + velocities + "\"");
  const Vector u = after(scene, 5);
  EXPECT_GT(u[139].norm(), 1e-3);
  for (const Index node : {64, 128, 139}) EXPECT_NEAR(u[node][1] + u[node][2], 0, 1e-12) << node;
}

TEST(CondensedDynamic, NodesSlideInObliquePlanesWithTheMassOfTheInside) {
  Block block{.solver = "", .loads = "<ConstantForceField indices=\"139 138\" totalForce=\"2 1 -3\"/>", .dt = 0.002};
  block.more = "<FixedPlaneProjectiveConstraint direction=\"1 2 3\" indices=\"64 88 128 139\"/>";
  for (const std::string mass : {"exact", "shared", "neglected"}) {
    block.solver = "<CondensedDynamicSolver interiorMass=\"" + mass + "\"/>";
    const Vector u = after(block.text(), 40);
    EXPECT_GT(u[139].norm(), 1e-3) << mass;
    for (const Index node : {64, 88, 128, 139})
      EXPECT_LT(std::abs(u[node].dot(Vec3(1, 2, 3))), 1e-13 * norm(u)) << mass << " " << node;
  }
}

TEST(CondensedDynamic, BodiesThatSlideFreelyFallAsFast) {
  // every node in a plane across which nothing pulls: the whole body falls along it, by the scheme g_p dt^2 n (n +
  // 1)/2. Kept nodes have a mean mass there, which leaves the sum in each direction nearly the same
  Block block{.solver = "<CondensedDynamicSolver/>", .gravity = "0 -9.81 0", .dt = 0.01};
  const std::string floor = "<FixedProjectiveConstraint name=\"floor\" indices=\"" + Block::nodes(0, 20) + "\"/>";
  block.more = "<FixedPlaneProjectiveConstraint direction=\"1 2 3\" indices=\"" + Block::nodes(0, 140) + "\"/>";
  std::string text = block.text();
  text.replace(text.find(floor), floor.size(), "");
  const Vector u = after(text, 10);
  const Vec3 normal = Vec3(1, 2, 3).normalized(), g(0, -9.81, 0);
  const Vec3 fall = (g - g.dot(normal) * normal) * 1e-4 * 55;
  for (const Index node : {0, 47, 139}) EXPECT_LT((u[node] - fall).norm(), 0.03 * fall.norm()) << node;
}

TEST(CondensedDynamic, SlowestMotionIsFoundUnderUnequalDamping) {
  // two springs of 20 rad/s, one damped and one not: 3.18 Hz both
  const auto spring = [](const std::string& name, const std::string& damping) {
    return "<Node name=\"" + name + "\"><MechanicalObject position=\"1.3 0 0\" rest_position=\"1 0 0\"/><UniformMass " +
           "totalMass=\"0.5\" rayleighMass=\"" + damping +
           "\"/><RestShapeSpringsForceField points=\"0\" stiffness=\"200\"/></Node>";
  };
  for (const auto& [first, second] : {std::pair("0", "80"), std::pair("80", "0")}) {
    const Simulation simulation = simulationFromText(
        "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><CondensedDynamicSolver condensed=\"false\"/>" +
        spring("a", first) + spring("b", second) + "</Node>");
    const std::string plan = simulation.systems().front()->integrator().describe();
    EXPECT_NE(plan.find("below 3.18 Hz"), std::string::npos) << plan;
  }
}

TEST(CondensedDynamic, DampingThatTurnsVelocitiesIsWarnedOf) {
  const auto said = [](const std::string& alpha) {
    Block block{.solver = "<CondensedDynamicSolver rayleighMass=\"" + alpha + "\"/>"};
    testing::internal::CaptureStderr();
    simulationFromText(block.text());
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(said("95").find("velocities change"), std::string::npos);
  EXPECT_NE(said("105").find("is 2.1, above 2"), std::string::npos) << said("105");
}
