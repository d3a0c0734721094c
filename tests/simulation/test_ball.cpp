// SPDX-License-Identifier: LGPL-2.1-or-later
// A ball that pushes: closed forms, its derivatives, nothing left behind, and runs that repeat themselves.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "tests/simulation/matrix_of_system.h"
#include "tests/simulation/refused_input.h"
#include "tests/support/scene_fixture.h"
#include "tools/session/action_file.h"
#include "tools/session/replay.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A block of 0.1 x 0.1 x 0.3 m, held at z = 0; node 43 is in the middle of the edge y = 0.1 of its free end.
std::string blockScene(const std::string& integrator, const std::string& dt = "0.01") {
  return "<Node name=\"root\" dt=\"" + dt + "\" gravity=\"0 0 0\">" + integrator +
         "<RegularGridTopology n=\"3 3 5\" min=\"0 0 0\" max=\"0.1 0.1 0.3\"/><MechanicalObject name=\"dofs\"/>"
         "<UniformMass totalMass=\"1\"/><HexahedronFEMForceField name=\"fem\" youngModulus=\"1e5\" "
         "poissonRatio=\"0.3\" method=\"polar\"/><BoxROI name=\"roi\" box=\"-1 -1 -0.001 1 1 0.001\"/>"
         "<FixedProjectiveConstraint indices=\"@roi.indices\"/></Node>";
}

const std::string direct = "<SparseLDLSolver/>";
const std::string iterative = "<CGLinearSolver iterations=\"300\" tolerance=\"1e-13\"/>";

Input ball(const Vec3& centre, double radius, double stiffness, double damping = 0) {
  Input input;
  input.state = "/dofs";
  input.ball = Ball{centre, radius};
  input.stiffness = stiffness, input.damping = damping;
  return input;
}
/// On the block: a ball from above that touches the free end.
Input pushing(double y, double damping = 1) { return ball({0.05, y, 0.3}, 0.08, 200, damping); }

void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) ASSERT_FALSE(simulation.step().diverged);
}

Vector positions(const Simulation& simulation) {
  Vector x(simulation.systems()[0]->allRows());
  copy(simulation.systems()[0]->x, x);
  return x;
}

TEST(Ball, ANodeOnASpringRestsWhereBothForcesAreEqual) {
  const std::tuple<std::string, const char*, int> ways[] = {
      {"<EulerImplicitSolver/>" + iterative, "0.1", 400},
      {"<EulerImplicitSolver/>" + direct, "0.1", 400},
      {"<EulerImplicitSolver newtonIterations=\"5\"/>" + direct, "0.1", 400},
      {"<BDFOdeSolver order=\"2\"/>" + direct, "0.1", 400},
      {"<StaticSolver/>" + direct, "0.1", 1},
      {"<EulerExplicitSolver/>", "0.005", 4000}};
  for (const auto& [integrator, dt, steps] : ways) {
    SCOPED_TRACE(integrator);
    Simulation simulation = simulationFromText(springScene(integrator, dt));
    run(simulation, 1);
    const Vec3 along(0.6, 0.8, 0);
    // 300 (0.3 - 0.1 - s) = 100 s
    const long number = simulation.addInput(ball(-0.1 * along, 0.3, 300, 5));
    run(simulation, steps);
    EXPECT_LT((Vec3(simulation.systems()[0]->x[0]) - 0.15 * along).norm(), 1e-6);
    // nearer: 300 (0.3 - 0.02 - s) = 100 s
    simulation.changeInput(number, ball(-0.02 * along, 0.3, 300, 5));
    run(simulation, steps);
    EXPECT_LT((Vec3(simulation.systems()[0]->x[0]) - 0.21 * along).norm(), 1e-6);
    // out of reach
    simulation.changeInput(number, ball(-0.2 * along, 0.1, 300, 5));
    if (integrator == "<EulerExplicitSolver/>") continue;  // nothing damps it then
    run(simulation, steps);
    EXPECT_LT(Vec3(simulation.systems()[0]->x[0]).norm(), 1e-6);
  }
}

TEST(Ball, ANodeInTheCentreLeavesItAndNothingIsNotANumber) {
  for (const Vec3& at : {Vec3(0, 0, 0), Vec3(1e-170, -1e-170, 0), Vec3(0, 5e-324, 0)}) {
    Simulation simulation = simulationFromText(springScene("<EulerImplicitSolver/>" + direct, "0.1"));
    simulation.addInput(ball(at, 0.3, 300, 5));
    run(simulation, 400);
    EXPECT_LT((Vec3(simulation.systems()[0]->x[0]) - Vec3(0.225, 0, 0)).norm(), 1e-6) << "300 (0.3 - s) = 100 s";
  }
}

/// All but the part k (r/d - 1) (I - n n^T) that is left out.
TEST(Ball, DerivativesAreThoseOfFiniteDifferences) {
  Simulation simulation = simulationFromText(blockScene("<EulerImplicitSolver/>" + direct));
  const double radius = 0.08, k = 200, c = 3;
  const Vec3 centre(0.05, 0.14, 0.3);
  simulation.addInput(ball(centre, radius, k, c));
  System& system = *simulation.systems()[0];
  ForceField& field = *system.forceFields().back();
  ASSERT_EQ(&field, system.inputs());
  EXPECT_FALSE(field.traits().linear || field.traits().constant_stiffness || field.traits().exact_tangent);
  EXPECT_TRUE(field.traits().symmetric && field.traits().velocity_dependent);
  const Index rows = system.allRows();
  Vector x(rows), v(rows), p(rows), none(rows);
  copy(system.x, x);
  for (Index i = 0; i < rows; ++i)
    p[i] = Vec3(std::sin(i), std::cos(3 * i), std::sin(7 * i + 1)), none[i] = Vec3(0, 0, 0);
  const auto force = [&](const Vector& at, const Vector& velocity) {
    Vector f(rows);
    clear(f);
    field.addForce(at, velocity, f);
    return f;
  };
  const auto moved = [&](const Vector& from, double by) {
    Vector to(rows);
    for (Index i = 0; i < rows; ++i) to[i] = from[i] + by * p[i];
    return to;
  };
  const double h = 1e-6;
  const Vector ahead = force(moved(x, h), none), behind = force(moved(x, -h), none);
  const double slope = (field.energy(moved(x, h)) - field.energy(moved(x, -h))) / (2 * h);
  const Vector faster = force(x, moved(none, 1)), f = force(x, none);
  Vector product(rows), damping(rows);
  clear(product), clear(damping);
  field.addStiffnessProduct(p, 1, product);
  field.addDampingProduct(p, 1, damping);
  int touched = 0;
  double power = 0;
  for (Index i = 0; i < rows; ++i) {
    const Vec3 from = Vec3(x[i]) - centre;
    const double d = from.norm();
    const Vec3 n = from / d, q = p[i];
    const bool inside = d < radius;
    touched += inside;
    power += Vec3(f[i]).dot(q);
    const Vec3 force_there = inside ? Vec3(k * (radius - d) * n) : Vec3(0, 0, 0);
    EXPECT_LT((Vec3(f[i]) - force_there).norm(), 1e-13 * k) << i;
    const Vec3 left_out = inside ? Vec3(k * (radius / d - 1) * (q - n.dot(q) * n)) : Vec3(0, 0, 0);
    // the third derivative of a distance is of the order of 1/d^2
    const double error = 1e-8 * k + k * radius * h * h / (d * d * d);
    EXPECT_LT(((Vec3(ahead[i]) - Vec3(behind[i])) / (2 * h) - left_out - Vec3(product[i])).norm(), error) << i;
    EXPECT_LT((Vec3(faster[i]) - Vec3(f[i]) - Vec3(damping[i])).norm(), 1e-13 * (k + c)) << i;
  }
  EXPECT_EQ(touched, 3);
  EXPECT_NEAR(slope, -power, 1e-7 * k);
}

/// Products, the assembled matrix and the diagonal from the fields and from the matrix are of one stiffness and damping.
TEST(Ball, DiagonalMatrixAndProductsAreOfOneStiffness) {
  Simulation simulation = simulationFromText(blockScene("<EulerImplicitSolver/>" + iterative));
  run(simulation, 1);
  simulation.addInput(ball({0.03, 0.13, 0.32}, 0.08, 5e4, 3e4));
  run(simulation, 1);
  System& system = *simulation.systems()[0];
  Vector f(system.allRows());
  system.computeForce(system.x, system.v, f);
  const std::vector<double> with = expectOneMatrix(system, {.mass = 1, .stiffness = -1, .damping = -0.5}, 8e4);
  simulation.removeInput(1);
  system.computeForce(system.x, system.v, f);
  std::vector<double> without;
  system.matrix().diagonalBlocks(without);
  double most = 0;
  for (std::size_t i = 0; i < without.size(); ++i) most = std::max(most, with[i] - without[i]);
  EXPECT_GT(most, 1e4) << "the ball was in it";
}

TEST(Ball, ABlockIsPushedAlikeWhateverSolvesIt) {
  const auto pushed = [](const std::string& solver) {
    Simulation simulation = simulationFromText(blockScene("<EulerImplicitSolver/>" + solver));
    const long number = simulation.addInput(pushing(0.17));
    for (int i = 0; i < 20; ++i) {
      simulation.changeInput(number, pushing(0.17 - 0.002 * i));
      run(simulation, 1);
    }
    return positions(simulation);
  };
  const Vector exact = pushed(direct), approximate = pushed(iterative);
  EXPECT_LT(distance(exact, approximate), 1e-9);
  EXPECT_LT(exact[43].y(), 0.1 - 0.003) << "nothing was pushed";
}

TEST(Ball, AtRestABlockHasTheShapeOfStatics) {
  Simulation moving = simulationFromText(blockScene("<EulerImplicitSolver/>" + direct, "0.1"));
  Simulation still = simulationFromText(
      blockScene("<StaticSolver newton_iterations=\"100\" relative_residual_tolerance_threshold=\"1e-10\"/>" + direct));
  const long number = moving.addInput(pushing(0.14));
  still.addInput(pushing(0.14));
  run(moving, 300), run(still, 1);
  const Vector there = positions(still);
  EXPECT_LT(distance(positions(moving), there), 1e-7);
  EXPECT_LT(there[43].y(), 0.1 - 0.003) << "nothing was pushed";
  moving.removeInput(number);
  run(moving, 300);
  for (Index i = 0; i < there.count(); ++i)
    EXPECT_LT((Vec3(moving.systems()[0]->x[i]) - moving.states()[0]->rest_position[std::size_t(i)]).norm(), 1e-7) << i;
}

/// Both rules are of first order: at 1e-4 s the way of 10 ms differs by parts in a hundred.
TEST(Ball, ExplicitStepsArePushedAsImplicitOnes) {
  const auto pushed = [](const std::string& integrator) {
    Simulation simulation = simulationFromText(blockScene(integrator, "1e-4"));
    simulation.addInput(pushing(0.14));
    run(simulation, 100);
    return positions(simulation);
  };
  const Vector with = pushed("<EulerImplicitSolver/>" + direct), without = pushed("<EulerExplicitSolver/>");
  const double way = 0.1 - with[43].y();
  EXPECT_GT(way, 1e-3);
  EXPECT_NEAR(0.1 - without[43].y(), way, 0.05 * way);
}

TEST(Ball, OnesThatWentBeforeAStepLeaveNothingBehind) {
  for (const std::string& solver : {direct, iterative})
    for (const char* integrator : {"<EulerImplicitSolver/>", "<BDFOdeSolver order=\"2\"/>", "<StaticSolver/>"}) {
      SCOPED_TRACE(solver + integrator);
      Simulation touched = simulationFromText(blockScene(integrator + solver));
      Simulation never = simulationFromText(blockScene(integrator + solver));
      run(touched, 3), run(never, 3);
      const std::size_t fields = touched.systems()[0]->forceFields().size();
      const long number = touched.addInput(pushing(0.14));
      touched.changeInput(number, pushing(0.12));
      EXPECT_EQ(touched.systems()[0]->forceFields().size(), fields + 1);
      touched.removeInput(number);
      EXPECT_EQ(touched.systems()[0]->forceFields().size(), fields);
      run(touched, 5), run(never, 5);
      EXPECT_EQ(touched.stateHash(), never.stateHash());
    }
}

TEST(Ball, ARunIsReplayedBitForBitAlsoThroughATextAndACheckpointHoldsIt) {
  for (const std::string& solver : {direct, iterative})
    for (const char* integrator : {"<EulerImplicitSolver/>", "<BDFOdeSolver order=\"2\"/>", "<StaticSolver/>"}) {
      SCOPED_TRACE(solver + integrator);
      const std::string scene = blockScene(integrator + solver);
      Simulation played = simulationFromText(scene);
      run(played, 2);
      const long number = played.addInput(pushing(0.14));
      run(played, 3);
      for (const double y : {0.13, 0.4, 0.12 + 1.0 / 300}) played.changeInput(number, pushing(y));
      EXPECT_EQ(played.events().size(), 2u) << "of several places before one step the last is kept";
      const Archive in_hand = played.checkpoint();
      run(played, 3);
      const std::uint64_t pushed = played.stateHash();
      played.removeInput(number);
      run(played, 3);
      std::istringstream text(printActions({"block.xml", played.events()}));
      for (const std::vector<RunEvent>& events : {played.events(), parseActions(text, "block.actions").events}) {
        Simulation replayed = simulationFromText(scene);
        replay(replayed, events);
        run(replayed, 11);
        EXPECT_EQ(replayed.stateHash(), played.stateHash());
        EXPECT_EQ(printActions({"", replayed.events()}), printActions({"", played.events()}));
      }
      Simulation restored = simulationFromText(scene);
      restored.restore(in_hand);
      run(restored, 3);
      restored.removeInput(number);
      run(restored, 3);
      EXPECT_EQ(restored.stateHash(), played.stateHash());
      Simulation untouched = simulationFromText(scene);
      run(untouched, 8);
      EXPECT_NE(untouched.stateHash(), pushed);
    }
}

/// What an integrator keeps between steps is in the checkpoint also while a ball touches.
TEST(Ball, EveryIntegratorGoesOnFromACheckpointBitForBit) {
  for (const char* integrator :
       {"<NewmarkImplicitSolver/>", "<TrapezoidalRuleSolver/>", "<VariationalSymplecticSolver/>",
        "<EulerImplicitSolver newtonIterations=\"3\"/>", "<EulerImplicitSolver rayleighStiffness=\"0.1\"/>",
        "<NewtonCotesSolver/>", "<CentralDifferenceSolver/>", "<RungeKutta2Solver/>", "<RungeKutta4Solver/>"})
    for (const double damping : {0., 1.}) {
      SCOPED_TRACE(integrator + std::to_string(damping));
      const bool is_implicit = std::string(integrator).find_first_of("NT") == 1 ||
                               std::string(integrator).find("Implicit") != std::string::npos;
      const bool solves = is_implicit && std::string(integrator).find("Cotes") == std::string::npos;
      const std::string scene = blockScene(integrator + (solves ? iterative : std::string()), "0.0005");
      Simulation played = simulationFromText(scene), restored = simulationFromText(scene);
      const long number = played.addInput(pushing(0.14, damping));
      run(played, 4);
      played.changeInput(number, pushing(0.138, damping));
      restored.restore(played.checkpoint());
      run(played, 4), run(restored, 4);
      EXPECT_EQ(restored.stateHash(), played.stateHash());
      EXPECT_LT(positions(played)[43].y(), 0.1) << "nothing was pushed";
      Simulation replayed = simulationFromText(scene);
      replay(replayed, played.events());
      run(replayed, 8);
      EXPECT_EQ(replayed.stateHash(), played.stateHash());
    }
}

TEST(Ball, WhatIsNoBallIsRefusedWithASentence) {
  Simulation simulation = simulationFromText(blockScene("<EulerImplicitSolver/>" + direct));
  Input both = pushing(0.14), forced = pushing(0.14);
  both.nodes = {3};
  forced.force = {0, 1, 0};
  for (const Input& input : {both, forced}) {
    expectContains(refusal(simulation, input), "a ball and also nodes");
    EXPECT_THROW(printActions({"", {{1, InputChange{1, input}}}}), std::runtime_error);
  }
  for (const double radius : {0., -1., double(NAN), double(INFINITY)})
    expectContains(refusal(simulation, ball({0, 0, 0}, radius, 1)), "radius is not positive");
  expectContains(refusal(simulation, ball({0, NAN, 0}, 1, 1)), "not finite");
  expectContains(refusal(simulation, ball({0, 0, 0}, 1, -1)), "stiffness or damping is negative");
  EXPECT_EQ(simulation.events().size(), 0u);
}

TEST(Ball, ItsTextIsKeptToTheBitAndWhatIsDamagedIsRefused) {
  const std::string head = "{\"stroma\":\"actions\",\"version\":1,\"scene\":\"a.xml\"}\n";
  const Input input = ball({-0.0, 1.0 / 3, 5e-324}, 0.1, 1e300, 1e-300);
  std::istringstream written(printActions({"a.xml", {{7, InputChange{12, input}}}}));
  const RecordedActions read = parseActions(written, "a.actions");
  ASSERT_EQ(read.events.size(), 1u);
  const auto& [which, got] = std::get<InputChange>(read.events[0].what);
  EXPECT_EQ(which, 12);
  ASSERT_TRUE(got->ball);
  EXPECT_TRUE(*got->ball == *input.ball && got->hasDerivativesOf(input));
  EXPECT_TRUE(std::signbit(got->ball->centre[0]));
  const std::pair<const char*, const char*> lines[] = {{"\"ball\":[1,2,3]", "its radius, as"},
                                                       {"\"ball\":[1,2,3,\"4\"]", "its radius, as"},
                                                       {"\"ball\":4", "its radius, as"},
                                                       {"\"ball\":[1,2,3,4],\"nodes\":[1]", "'nodes' is no name"},
                                                       {"\"ball\":[1,2,3,4],\"force\":[1,2,3]", "'force' is no name"},
                                                       {"\"bal\":[1,2,3,4]", "'bal' is no name"}};
  for (const auto& [part, expected] : lines) {
    SCOPED_TRACE(part);
    std::istringstream text(head + "{\"step\":3,\"input\":1,\"state\":\"/dofs\"," + part + "}\n");
    expectContains(problemsIn([&] { parseActions(text, "x.actions"); }), expected);
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
