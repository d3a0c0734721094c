// SPDX-License-Identifier: LGPL-2.1-or-later
// Inputs on condensed bodies: forces and pulls are those of the whole body, and nothing is left when they have gone.
#include "tests/condensation/bodies.h"
#include "tools/session/replay.h"

using namespace stroma;
using namespace stroma::test;

namespace {

const std::string whole_static =
    "<StaticSolver newton_iterations=\"9\" relative_residual_tolerance_threshold=\"1e-12\"/><SparseLDLSolver/>";

Input force(std::vector<Index> nodes, const Vec3& each) { return {"/body/dofs", std::move(nodes), each}; }
Input pull(const Simulation& simulation, std::vector<Index> nodes, const Vec3& by, double stiffness,
           double damping = 0) {
  Input input{"/body/dofs", std::move(nodes)};
  for (const Index node : input.nodes) input.targets.push_back(simulation.states().front()->rest_position[node] + by);
  input.stiffness = stiffness, input.damping = damping;
  return input;
}

void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.diverged || report.unsolved) << report.reason;
  }
}

/// Both after the same story; displacements are compared after each chapter.
template <class Story>
void expectSame(const std::string& one, const std::string& other, double tolerance, Story&& story) {
  Simulation a = simulationFromText(one), b = simulationFromText(other);
  run(a, 2), run(b, 2);
  Vector untouched = displacement(b);
  const auto check = [&](const char* what, double least) {
    run(a, 3), run(b, 3);
    EXPECT_LT(difference(displacement(a), displacement(b)), tolerance) << what;
    EXPECT_GT(difference(displacement(b), untouched), least) << what << " has no effect";
    untouched = displacement(b);
  };
  story(a, b, check);
}

/// A hand with several fingers, step by step.
template <class Check>
void useHands(Simulation& a, Simulation& b, Check&& check) {
  long first = 0, second = 0, third = 0;
  const auto both = [&](auto&& act) { act(a), act(b); };
  both([&](Simulation& s) { first = s.addInput(force({139, 120}, {0.02, 0, 0.01})); });
  check("a force", 1e-3);
  both([&](Simulation& s) { second = s.addInput(pull(s, {134}, {0.004, 0.002, -0.003}, 20)); });
  check("a pull", 1e-3);
  both([&](Simulation& s) { s.changeInput(second, pull(s, {134}, {-0.003, 0.001, 0}, 20)); });
  check("another target", 1e-3);
  both([&](Simulation& s) { third = s.addInput(pull(s, {134, 135, 119}, {0, 0.003, 0.001}, 7)); });
  check("three more nodes, one of them pulled already", 1e-3);
  both([&](Simulation& s) { s.changeInput(second, pull(s, {134}, {-0.003, 0.001, 0}, 2e3)); });
  check("a stiffer spring", 1e-3);
  both([&](Simulation& s) { s.changeInput(third, pull(s, {119, 3}, {0, 0.003, 0.001}, 1e-2)); });
  check("a node less, and one that is held", 1e-4);
  both([&](Simulation& s) { s.removeInput(second); });
  check("the first pull has ended", 1e-3);
  both([&](Simulation& s) { s.removeInput(third), s.removeInput(first); });
  check("all have ended", 1e-4);
}

const std::string dragged =
    "<LinearMovementProjectiveConstraint indices=\"136 134\" keyTimes=\"0 1 100\" outside=\"hold\" "
    "movements=\"0 0 0  0.004 0.002 -0.003  0.001 0 0\"/>";
const std::string slide = "<FixedPlaneProjectiveConstraint indices=\"139 135\" direction=\"1 2 1\"/>";
const std::string changing =
    "<ConstantForceField indices=\"120\" totalForce=\"0.01 0 0.02\"/>"
    "<ConstantForceField indices=\"134 100 101 102\" totalForce=\"0.01 0 0.02\"/>";

/// All mass is on the surface, so that condensed and full bodies move alike.
std::string surfaceMass() {
  std::string masses;
  for (int i = 0; i < 140; ++i) {
    const int x = i % 5, y = i / 5 % 4, z = i / 20;
    const bool inside = x > 0 && x < 4 && y > 0 && y < 3 && z > 0 && z < 6;
    masses += inside ? "1e-25 " : "0.005 ";
  }
  return "<DiagonalMass vertexMass=\"" + masses + "\"/>";
}

constexpr const char* dynamic_solvers[] = {
    "<CondensedDynamicSolver rayleighMass=\"2\"/>",
    "<CondensedDynamicSolver rayleighMass=\"2\" interiorMass=\"neglected\"/>",
    "<CondensedDynamicSolver rayleighMass=\"2\" condensed=\"false\" solve=\"factor\"/>",
    "<CondensedDynamicSolver rayleighMass=\"2\" condensed=\"false\" solve=\"inverse\"/>"};

}  // namespace

TEST(PulledNodes, StaticBodiesAreTheWholeBodyWithTheSameInputs) {
  for (const std::string& loads : {std::string(), changing, dragged, slide, dragged + slide + changing})
    for (const char* solver :
         {"<CondensedStaticSolver/>", "<CondensedStaticSolver condensed=\"false\"/>",
          "<CondensedStaticSolver incremental=\"false\"/>", "<CondensedStaticSolver precision=\"single\"/>"}) {
      SCOPED_TRACE(loads + solver);
      const bool is_single = std::string(solver).find("single") != std::string::npos;
      Block block{.solver = solver, .loads = loads};
      const std::string condensed = block.text();
      block.solver = whole_static;
      expectSame(condensed, block.text(), is_single ? 1e-5 : 1e-9,
                 [](auto& a, auto& b, auto&& check) { useHands(a, b, check); });
    }
}

TEST(PulledNodes, DynamicBodiesOfTheSameMassesMoveAlike) {
  for (const std::string& loads : {std::string(), dragged + slide + changing}) {
    Block block{.solver = dynamic_solvers[2], .loads = loads};
    block.mass = surfaceMass();
    const std::string full = block.text();
    for (const char* solver : {dynamic_solvers[0], dynamic_solvers[1], dynamic_solvers[3]}) {
      SCOPED_TRACE(loads + solver);
      block.solver = solver;
      expectSame(block.text(), full, 1e-9, [](auto& a, auto& b, auto&& check) { useHands(a, b, check); });
    }
  }
}

/// The spring of a pull is in no matrix: here it is one of the body's.
TEST(PulledNodes, APullIsASpringOfTheBody) {
  for (const char* solver : dynamic_solvers) {
    SCOPED_TRACE(solver);
    Block block{.solver = solver, .loads = slide};
    Simulation pulled = simulationFromText(block.text());
    pulled.addInput(pull(pulled, {134, 139}, {0, 0, 0}, 30));
    block.loads += "<RestShapeSpringsForceField points=\"134 139\" stiffness=\"30\"/>";
    Simulation sprung = simulationFromText(block.text());
    block.loads = slide;
    Simulation untouched = simulationFromText(block.text());
    run(pulled, 25), run(sprung, 25), run(untouched, 25);
    EXPECT_LT(difference(displacement(pulled), displacement(sprung)), 1e-10);
    EXPECT_GT(difference(displacement(untouched), displacement(sprung)), 1e-2);
  }
}

/// m (u+ - 2u + u-)/dt^2 + c (u+ - u-)/2dt + k u+ = k p + f, for one particle.
TEST(PulledNodes, DampingIsTheCentralDifferenceOfTheMethod) {
  const double dt = 0.01, m = 0.4, k = 30, c = 3, p = 0.7, f = 2;
  for (const double stiffness : {k, 0.}) {
    Simulation simulation = simulationFromText(
        "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><CondensedDynamicSolver condensed=\"false\"/><Node "
        "name=\"body\"><MechanicalObject name=\"dofs\" position=\"1 2 3\" velocity=\"0 0.5 0\"/><UniformMass "
        "totalMass=\"0.4\"/></Node></Node>");
    double u = 0, before = -dt * 0.5;
    Input input{"/body/dofs", {0}, {0, f, 0}};
    if (stiffness > 0) input.targets = {{1, 2 + p, 3}};
    input.stiffness = stiffness, input.damping = c;
    simulation.addInput(input);
    for (int i = 0; i < 50; ++i) {
      run(simulation, 1);
      const double right = stiffness * p + f + m * (2 * u - before) / (dt * dt) + c * before / (2 * dt);
      before = std::exchange(u, right / (m / (dt * dt) + c / (2 * dt) + stiffness));
      ASSERT_NEAR(simulation.systems()[0]->x[0].y() - 2, u, 1e-12);
    }
    EXPECT_GT(std::abs(u), 0.05);
  }
}

TEST(PulledNodes, WhatWentBeforeAStepOrAResetLeavesNothingBehind) {
  std::vector<std::string> solvers(std::begin(dynamic_solvers), std::end(dynamic_solvers));
  solvers.insert(solvers.end(), {"<CondensedStaticSolver/>", "<CondensedStaticSolver precision=\"single\"/>"});
  for (const std::string& solver : solvers)
    for (const std::string& loads : {slide + changing, dragged}) {
      SCOPED_TRACE(solver + loads);
      const Block block{.solver = solver, .loads = loads};
      Simulation touched = simulationFromText(block.text()), never = simulationFromText(block.text());
      run(touched, 3), run(never, 3);
      const long number = touched.addInput(pull(touched, {134, 120}, {0.001, 0, 0}, 10, 3));
      touched.removeInput(number);
      run(touched, 3), run(never, 3);
      EXPECT_EQ(touched.stateHash(), never.stateHash());
      touched.addInput(pull(touched, {134, 120}, {0.001, 0, 0}, 10, 3));
      run(touched, 2);
      EXPECT_NE(touched.stateHash(), never.stateHash());
      touched.reset(), never.reset();
      run(touched, 5), run(never, 5);
      EXPECT_EQ(touched.stateHash(), never.stateHash()) << "after a reset";
      if (touched.systems()[0]->integrator().movesInTime()) continue;
      const long again = touched.addInput(pull(touched, {134, 120}, {0.001, 0, 0}, 10, 3));
      run(touched, 2), run(never, 2);
      touched.removeInput(again);
      run(touched, 1), run(never, 1);
      EXPECT_EQ(touched.stateHash(), never.stateHash()) << "an equilibrium has no memory";
    }
}

TEST(PulledNodes, ARunRepeatsBitForBitAlsoFromACheckpoint) {
  for (const char* solver : {dynamic_solvers[0], dynamic_solvers[1], dynamic_solvers[2], "<CondensedStaticSolver/>"}) {
    SCOPED_TRACE(solver);
    const Block block{.solver = solver, .loads = dragged + changing};
    Simulation played = simulationFromText(block.text());
    run(played, 2);
    const long number = played.addInput(pull(played, {134, 139}, {0.001, 0, 0}, 10, 3));
    run(played, 2);
    played.changeInput(number, pull(played, {134, 139}, {0.001, 0.002, 0}, 10, 3));
    Archive in_hand = played.checkpoint();
    run(played, 2);
    played.removeInput(number);
    Archive let_go = played.checkpoint();
    run(played, 2);
    Simulation replayed = simulationFromText(block.text()), restored = simulationFromText(block.text());
    replay(replayed, played.events());
    run(replayed, 8);
    EXPECT_EQ(replayed.stateHash(), played.stateHash());
    restored.restore(std::move(let_go));
    run(restored, 2);
    EXPECT_EQ(restored.stateHash(), played.stateHash()) << "restored when the hand had gone";
    restored.restore(std::move(in_hand));
    run(restored, 2);
    restored.removeInput(number);
    run(restored, 2);
    EXPECT_EQ(restored.stateHash(), played.stateHash()) << "restored with the hand";
  }
}

TEST(PulledNodes, NodesInsideAreRefusedAndEditsStillAre) {
  const Index inside = 1 + 5 * 1 + 20 * 3;
  for (const char* solver : {"<CondensedStaticSolver/>", dynamic_solvers[1]}) {
    Simulation simulation = simulationFromText(Block{.solver = solver}.text());
    try {
      simulation.addInput(force({139, inside}, {1, 0, 0}));
      ADD_FAILURE() << "a force on a node inside was taken by " << solver;
    } catch (const ComponentError& error) {
      expectContains(error.what(), "no input acts on node 66 of /body/dofs: it is inside");
      expectContains(error.expected + error.suggestion, "condensed=\"false\"");
    }
    EXPECT_TRUE(simulation.events().empty());
    EXPECT_THROW(simulation.setAttribute("/body/fem", "youngModulus", "6000"), ComponentError);
    EXPECT_THROW(simulation.setAttribute("/", "gravity", "0 0 0"), ComponentError);
  }
  for (const char* solver : {"<CondensedStaticSolver condensed=\"false\"/>", dynamic_solvers[0], dynamic_solvers[2]})
    EXPECT_NO_THROW(simulationFromText(Block{.solver = solver}.text()).addInput(force({inside}, {1, 0, 0})));
}

TEST(PulledNodes, ABallIsRefusedWithASentence) {
  Input ball;
  ball.state = "/body/dofs", ball.ball = Ball{{0, 0, 0}, 0.1}, ball.stiffness = 10;
  for (const std::string solver : {"<CondensedStaticSolver/>", dynamic_solvers[0], dynamic_solvers[1]}) {
    SCOPED_TRACE(solver);
    Simulation simulation = simulationFromText(Block{.solver = solver}.text());
    try {
      simulation.addInput(ball);
      ADD_FAILURE() << "the ball was taken";
    } catch (const ComponentError& error) {
      expectContains(error.what(), "no ball pushes /body/dofs: ");
      expectContains(error.suggestion, solver[10] == 'S' ? "StaticSolver" : "EulerImplicitSolver");
    }
    EXPECT_EQ(simulation.events().size(), 0u);
  }
}

TEST(PulledNodes, ForcesThatObserversReadHaveTheInputs) {
  Simulation simulation = simulationFromText(Block{.solver = "<CondensedStaticSolver/>"}.text());
  simulation.addInput(pull(simulation, {134}, {0.004, 0.002, -0.003}, 20));
  run(simulation, 1);
  System& system = *simulation.systems().front();
  system.computeForce(system.x, system.v, system.f);
  EXPECT_LT(system.f[134].norm(), 1e-9) << "an equilibrium";
  EXPECT_GT(
      20 * (Vec3(simulation.states().front()->rest_position[134] + Vec3(0.004, 0.002, -0.003)) - Vec3(system.x[134]))
               .norm(),
      1e-3);
}
