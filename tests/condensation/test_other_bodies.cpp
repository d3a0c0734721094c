// SPDX-License-Identifier: LGPL-2.1-or-later
// Rigid frames beside condensed bodies, against the same scene in EulerImplicitSolver, which solves with the whole matrix.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <sstream>

#include "framework/algebra/parallel.h"
#include "framework/mechanics/state.h"
#include "tests/condensation/bodies.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string euler = "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-13\"/><SparseLDLSolver/>";
const std::string condensed = "<CondensedDynamicSolver/>";
const std::string floor_held = "<BoxROI name=\"held\" box=\"-1 -1 -1 1 1 0.001\"/><FixedProjectiveConstraint indices=\"@held.indices\"/>";

/// `solver`: of its node.
std::string block(const std::string& more = floor_held, const std::string& solver = "", const std::string& state = "") {
  return fmt::format(
      "<Node name=\"b\">{}<Node name=\"source\"><RegularGridTopology name=\"grid\" n=\"5 5 4\" min=\"0 0 0\" "
      "max=\"0.08 0.06 0.06\"/></Node>"
      "<TetrahedronSetTopologyContainer name=\"mesh\"/><Hexa2TetraTopologicalMapping input=\"@source/grid\" output=\"@mesh\"/>"
      "<MechanicalObject name=\"dofs\" {}/><UniformMass name=\"mass\" totalMass=\"0.3\"/><TetrahedronFEMForceField method=\"small\" "
      "youngModulus=\"5000\" poissonRatio=\"0.35\"/>{}</Node>",
      solver, state, more);
}

constexpr double radius = 0.012;

/// The corners of an icosahedron about the centre of a frame, obliquely.
std::vector<Vec3> corners() {
  const double g = 0.5 * (1 + std::sqrt(5.0)), length = std::hypot(1, g);
  const Mat3 turn = (Eigen::AngleAxisd(0.3, Vec3::UnitX()) * Eigen::AngleAxisd(0.5, Vec3::UnitY())).toRotationMatrix();
  std::vector<Vec3> all{{-1, g, 0}, {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                        {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  for (Vec3& p : all) p = turn * p * (radius / length);
  return all;
}

std::string shell() {
  std::string text = "<MeshTopology name=\"mesh\" position=\"";
  for (const Vec3& at : corners()) text += fmt::format("{} {} {}  ", at.x(), at.y(), at.z());
  return text +
         "\" triangles=\"0 11 5 0 5 1 0 1 7 0 7 10 0 10 11 1 5 9 5 11 4 11 10 2 10 7 6 7 1 8 3 9 4 3 4 2 3 2 6 3 6 8 3 8 9 4 9 5 2 4 11 "
         "6 2 10 8 6 7 9 8 1\"/>";
}

struct Tool {
  std::string place = "0.043 0.031 0.0735  0 0 0 1", velocity = {}, inertia = "2e-6 2e-6 2e-6", more = {}, mapped = {}, solver = {};
  double mass = 0.02;
  std::string text() const {
    return fmt::format(
        "<Node name=\"tool\">{}<MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"{}\" {}/><UniformMass totalMass=\"{}\" "
        "inertia=\"{}\"/>{}<Node name=\"skin\">{}<MechanicalObject name=\"dofs\"/><RigidMapping/>{}</Node></Node>",
        solver, place, velocity.empty() ? "" : "velocity=\"" + velocity + "\"", mass, inertia, more, shell(), mapped);
  }
};

std::string contact(double friction = 0) {
  return fmt::format("<ConstraintContact name=\"contact\" mstate=\"@b/dofs\" topology=\"@b/mesh\" other=\"@tool/skin/dofs\" "
                     "contactDistance=\"2e-4\" friction=\"{}\"/>",
                     friction);
}

std::string scene(const std::string& solver, const std::string& content, double dt = 0.005, const std::string& gravity = "0 0 -9.81") {
  return fmt::format("<Node name=\"root\" dt=\"{}\" gravity=\"{}\">{}{}</Node>", dt, gravity, solver, content);
}

struct Outcome {
  std::vector<Vec3> places, speeds;  ///< of all states in the order of their paths, orientations by their first three numbers, times radius
  std::vector<double> wrenches;
};

std::vector<double> outputOf(Simulation& simulation, const std::string& name, const std::string& attribute) {
  std::vector<Component*> all;
  simulation.root().collect(all);
  std::vector<double> values;
  for (const Component* component : all)
    if (component->name() == name) {
      std::istringstream text(component->data().find(attribute)->print());
      for (double value; text >> value;) values.push_back(value);
    }
  return values;
}

void step(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.diverged || report.unsolved) << "step " << i << ": " << report.reason;
    ASSERT_TRUE(report.constraints_converged) << "step " << i << ": " << report.constraint_reason;
  }
}

Outcome run(const std::string& text, int steps) {
  Simulation simulation = simulationFromText(text);
  step(simulation, steps);
  simulation.complete();
  Outcome result;
  std::vector<State*> states;
  simulation.root().collect(states);
  for (const State* state : states)
    for (Index i = 0; i < state->size() && state->isBound(); ++i) {
      const double arm = state->kindOf(i) == RowKind::turn ? radius : 1;
      result.places.push_back(arm * state->x()[i]), result.speeds.push_back(arm * state->v()[i]);
    }
  result.wrenches = outputOf(simulation, "contact", "wrenches");
  return result;
}

/// Places within `apart` [m], velocities within as much in a step of 5 ms, and wrenches within `part` of the largest force.
void expectSame(const Outcome& found, const Outcome& expected, double apart, double part = 1e-5) {
  ASSERT_EQ(found.places.size(), expected.places.size());
  for (std::size_t i = 0; i < found.places.size(); ++i) {
    ASSERT_LT((found.places[i] - expected.places[i]).norm(), apart) << i;
    ASSERT_LT((found.speeds[i] - expected.speeds[i]).norm(), apart / 0.005) << i;
  }
  ASSERT_EQ(found.wrenches.size(), expected.wrenches.size());
  double largest = 0;
  for (const double value : expected.wrenches) largest = std::max(largest, std::abs(value));
  for (std::size_t i = 0; i < found.wrenches.size(); ++i) EXPECT_NEAR(found.wrenches[i], expected.wrenches[i], part * largest) << i;
}

/// A ball falls on the block, rolls and spins.
TEST(OtherBodies, AFreeFrameMeetsACondensedBodyAsTheWholeOne) {
  for (const double friction : {0.0, 0.3})
    for (const char* inertia : {"1.2e-6 1.2e-6 1.2e-6", "0.6e-6 1.2e-6 1.5e-6"}) {
      SCOPED_TRACE(fmt::format("friction {} inertia {}", friction, inertia));
      const Tool tool{.velocity = "0.05 0.02 -0.1  3 -5 2", .inertia = inertia};
      const std::string content = block() + tool.text() + contact(friction);
      const Outcome expected = run(scene(euler, content), 40);
      EXPECT_GT(expected.wrenches[8], 0.1) << "they meet";
      const double tolerated = 2e-7;  // of conditions: a thousandth of contactDistance
      expectSame(run(scene(condensed, content), 40), expected, tolerated);
      expectSame(run(scene("<CondensedDynamicSolver condensed=\"false\"/>", content), 40), expected, tolerated);
    }
}

/// Each body below an integrator of its own, in either order.
TEST(OtherBodies, AFrameOfAnotherIntegratorMovesWithTheCondensedBody) {
  const Tool alone{.solver = "<EulerImplicitSolver/><SparseLDLSolver/>"};
  const std::string soft = block(floor_held, condensed);
  const Outcome expected = run(scene(euler, block() + Tool().text() + contact(0.3)), 30);
  expectSame(run(scene("", soft + alone.text() + contact(0.3)), 30), expected, 2e-8);
  Outcome found = run(scene("", alone.text() + soft + contact(0.3)), 30);
  std::rotate(found.places.begin(), found.places.begin() + 14, found.places.end());
  std::rotate(found.speeds.begin(), found.speeds.begin() + 14, found.speeds.end());
  expectSame(found, expected, 2e-8);
}

/// A frame on a path, in time and in steps so long that nothing has inertia.
TEST(OtherBodies, AFrameOnAPathIsPressedIntoACondensedBody) {
  for (const double dt : {0.005, 1e5}) {
    SCOPED_TRACE(dt);
    const Tool tool{.more = fmt::format("<LinearMovementProjectiveConstraint indices=\"0\" keyTimes=\"0 {} {}\" outside=\"hold\" "
                                        "movements=\"0 0 0 0 0 0  0 0 -0.006 0 0 0  0.006 0 -0.006 0 0 0.4\"/>",
                                        10 * dt, 30 * dt)};
    const std::string content = block() + tool.text() + contact(0.3);
    const Outcome expected = run(scene(euler, content, dt, "0 0 0"), 30);
    EXPECT_GT(expected.wrenches[8], 0.1) << "they meet";
    Outcome found = run(scene(dt < 1 ? condensed : "<CondensedStaticSolver/>", content, dt, "0 0 0"), 30);
    if (dt > 1) found.speeds = expected.speeds;
    expectSame(found, expected, 2e-8);
  }
}

TEST(OtherBodies, AFrameAtRestPushesWithItsWeight) {
  const std::string content = block() + Tool{.place = "0.04 0.03 0.0735 0 0 0 1"}.text() + contact(0.5);
  Simulation simulation = simulationFromText(scene("<CondensedDynamicSolver rayleighMass=\"20\"/>", content, 0.01));
  step(simulation, 600);
  const std::vector<double> wrenches = outputOf(simulation, "contact", "wrenches");
  EXPECT_NEAR(wrenches[8], 0.02 * 9.81, 1e-4 * 0.02 * 9.81);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(wrenches[std::size_t(k)] + wrenches[std::size_t(6 + k)], 0, 1e-12 * wrenches[8]);
}

/// Two free bodies collide: what one loses the other gains.
TEST(OtherBodies, MomentumIsKept) {
  for (const double friction : {0.0, 0.4}) {
    SCOPED_TRACE(friction);
    std::string velocities = "velocity=\"";
    for (int i = 0; i < 100; ++i) velocities += "0 0 0.2 ";
    const Tool tool{.place = "0.05 0.036 0.0735 0 0 0 1", .velocity = "0.1 0 -0.3 0 0 0"};
    const std::string content = block("", "", velocities + "\"") + tool.text() + contact(friction);
    Simulation simulation = simulationFromText(scene("<CondensedDynamicSolver condensed=\"false\"/>", content, 0.002, "0 0 0"));
    const auto momentum = [&] {
      Vec3 sum = Vec3::Zero();
      for (const State* state : simulation.states())
        if (state->path() == "/b/dofs")
          for (Index i = 0; i < state->size(); ++i) sum += 0.3 / double(state->size()) * state->v()[i];
        else if (state->path() == "/tool/frame")
          sum += 0.02 * state->v()[0];
      return sum;
    };
    const Vec3 before = momentum();
    double most = 0;
    for (int i = 0; i < 60; ++i) {
      step(simulation, 1);
      const std::vector<double> wrenches = outputOf(simulation, "contact", "wrenches");
      most = std::max(most, wrenches[8]);
      ASSERT_LT((momentum() - before).norm(), 1e-11 * before.norm()) << "step " << i;
    }
    EXPECT_GT(most, 0.1) << "they collide";
    EXPECT_GT(before.norm(), 0.05);
  }
}

/// A hand holds the frame by springs, at its centre or at a mapped point, and pulls it down.
TEST(OtherBodies, SpringsHoldAFrame) {
  const std::string spring = "<RestShapeSpringsForceField points=\"0\" stiffness=\"40\" angularStiffness=\"1e-3\"/>";
  const std::string at_point = "<RestShapeSpringsForceField points=\"0 5\" stiffness=\"40\"/>";
  const std::string load = "<ConstantForceField indices=\"0\" forces=\"0.1 0 -0.3 0 0 0\"/>";
  for (const Tool& tool : {Tool{.more = spring + load}, Tool{.more = load, .mapped = at_point}}) {
    const std::string content = block() + tool.text() + contact(0.2);
    const Outcome expected = run(scene("<EulerImplicitSolver/><SparseLDLSolver/>", content), 30);
    EXPECT_GT(expected.wrenches[8], 0.05) << "they meet";
    // one linear solve turns the frame by its free motion first, and then by what the forces of contact add
    expectSame(run(scene(condensed, content), 30), expected, 1e-5, 1e-3);
  }
}

/// v' = v + h (m g - k (x + h v) - alpha m v) / (m (1 + h alpha) + h^2 k), x' = x + h v', without and with a spring.
TEST(OtherBodies, TheDampingOfTheCondensedSolverIsTheirsToo) {
  const double h = 0.005, alpha = 20, m = 0.02, g = -9.81;
  for (const double k : {0.0, 30.0}) {
    const std::string spring = fmt::format("<RestShapeSpringsForceField points=\"0\" stiffness=\"{}\"/>", k);
    const Tool tool{.place = "0.5 0 5  0 0 0 1", .more = k == 0 ? "" : spring};
    const std::string solver = fmt::format("<CondensedDynamicSolver rayleighMass=\"{}\"/>", alpha);
    Simulation simulation = simulationFromText(scene(solver, block() + tool.text()));
    step(simulation, 100);
    double x = 0, v = 0;
    for (int i = 0; i < 100; ++i) {
      v += h * (m * g - k * (x + h * v) - alpha * m * v) / (m * (1 + h * alpha) + h * h * k);
      x += h * v;
    }
    std::vector<State*> states;
    simulation.root().collect(states);
    const auto frame = std::ranges::find_if(states, [](const State* state) { return state->name() == "frame"; });
    ASSERT_NE(frame, states.end());
    EXPECT_NEAR((*frame)->v()[0].z(), v, 1e-9) << k;
    EXPECT_NEAR((*frame)->x()[0].z(), 5 + x, 1e-9) << k;
  }
}

/// Attached nodes of the body carry a frame.
TEST(OtherBodies, ACondensedNodeIsAttachedToAFrame) {
  std::string tie = "<BilateralLagrangianConstraint object1=\"@b/dofs\" object2=\"@tool/skin/dofs\" first_point=\"99 98 94\" "
                    "second_point=\"0 1 2\" rest_vector=\"";
  const Vec3 nodes[] = {{0.08, 0.06, 0.06}, {0.06, 0.06, 0.06}, {0.08, 0.045, 0.06}};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 apart = Vec3(0.043, 0.031, 0.0735) + corners()[i] - nodes[i];
    tie += fmt::format("{} {} {} ", apart.x(), apart.y(), apart.z());
  }
  tie += "\"/>";
  const std::string content = block() + Tool{.inertia = "0.6e-6 1.2e-6 1.5e-6"}.text() + tie;
  const Outcome expected = run(scene(euler, content), 20), found = run(scene(condensed, content), 20);
  expectSame(found, expected, 2e-8);
}

/// A soft body above the condensed one, of the corotational method, whose matrix is another one in each step.
std::string softBlock(const std::string& solver, const std::string& more) {
  return fmt::format(
      "<Node name=\"c\">{}<Node name=\"source\"><RegularGridTopology name=\"grid\" n=\"4 3 4\" min=\"0.015 0.013 0.0605\" "
      "max=\"0.065 0.048 0.1\"/></Node><TetrahedronSetTopologyContainer name=\"mesh\"/><Hexa2TetraTopologicalMapping "
      "input=\"@source/grid\" output=\"@mesh\"/><MechanicalObject name=\"dofs\"/><MeshMatrixMass massDensity=\"400\"/>"
      "<TetrahedronFEMForceField method=\"large\" youngModulus=\"3000\" poissonRatio=\"0.3\"/>{}</Node>",
      solver, more);
}

std::string softBall(const std::string& solver) {
  return "<Node name=\"c\">" + solver +
         "<GenerateSphere name=\"ball\" radius=\"0.012\" origin=\"0.043 0.031 0.0728\" tessellationDegree=\"2\"/>"
         "<TetrahedronSetTopologyContainer name=\"mesh\" position=\"@ball.output_TetrahedraPosition\" tetrahedra=\"@ball.tetrahedra\"/>"
         "<MechanicalObject name=\"dofs\"/><MeshMatrixMass massDensity=\"2000\"/><ConstantForceField totalForce=\"0.05 0.02 -0.2\"/>"
         "<TetrahedronFEMForceField method=\"large\" youngModulus=\"20000\" poissonRatio=\"0.3\"/></Node>";
}

std::string contactWithBall(double friction) {
  return fmt::format("<ConstraintContact name=\"contact\" mstate=\"@b/dofs\" topology=\"@b/mesh\" other=\"@c/dofs\" "
                     "contactDistance=\"2e-4\" friction=\"{}\"/>",
                     friction);
}

/// A soft ball falls on the block and is pushed along.
TEST(OtherBodies, ASoftBodyMeetsACondensedBodyAsTheWholeOne) {
  const std::string whole = "<EulerImplicitSolver/><SparseLDLSolver/>";
  for (const double friction : {0.0, 0.3}) {
    SCOPED_TRACE(friction);
    const Outcome expected = run(scene(whole, block() + softBall("") + contactWithBall(friction)), 20);
    EXPECT_GT(std::abs(expected.wrenches[2]), 0.1) << "they meet";
    expectSame(run(scene("", block(floor_held, condensed) + softBall(whole) + contactWithBall(friction)), 20), expected, 2e-7);
  }
}

TEST(OtherBodies, ASoftBodyIsAttachedToACondensedBody) {
  const std::string whole = "<EulerImplicitSolver/><SparseLDLSolver/>";
  const std::string tie = "<BilateralLagrangianConstraint object1=\"@b/dofs\" object2=\"@c/dofs\" first_point=\"81 82 86 87\" "
                          "second_point=\"0 1 4 5\" rest_vector=\"-0.005 -0.002 0.0005  -0.008 -0.002 0.0005  -0.005 0.0005 0.0005  "
                          "-0.008 0.0005 0.0005\"/>";
  const Outcome expected = run(scene(whole, block() + softBlock("", "") + tie), 20);
  const Outcome found = run(scene("", block(floor_held, condensed) + softBlock(whole, "") + tie), 20);
  expectSame(found, expected, 1e-10);
}

TEST(OtherBodies, InputsPullAFrame) {
  const std::string content = block() + Tool().text() + contact(0.2);
  std::vector<Outcome> runs;
  for (const std::string& solver : {euler, condensed}) {
    Simulation simulation = simulationFromText(scene(solver, content));
    step(simulation, 5);
    Input pull{"/tool/frame", {0}};
    pull.targets = {Vec3(0.03, 0.03, 0.065)}, pull.stiffness = 30, pull.damping = 0.1;
    const long number = simulation.addInput(pull);
    step(simulation, 15);
    runs.emplace_back();
    const auto note = [&] {
      for (const State* state : simulation.states())
        if (state->path() == "/tool/frame") runs.back().places.push_back(state->x()[0]), runs.back().speeds.push_back(state->v()[1]);
    };
    note(), simulation.removeInput(number), step(simulation, 10), note();
  }
  expectSame(runs[1], runs[0], 5e-10);
}

std::vector<double> placesOf(const Simulation& simulation) {
  std::vector<double> all;
  simulation.complete();
  for (const State* state : simulation.states())
    for (Index i = 0; i < state->size(); ++i)
      for (int k = 0; k < 3; ++k) all.push_back(state->x()[i][k]);
  return all;
}

TEST(OtherBodies, ARunRepeatsBitForBitAlsoFromACheckpoint) {
  const Tool tool{.velocity = "0.05 0.02 -0.1  3 -5 2", .inertia = "0.6e-6 1.2e-6 1.5e-6"};
  const std::string body = block(floor_held, condensed), implicit = "<EulerImplicitSolver/>";
  for (const std::string& text :
       {scene(condensed, block() + tool.text() + contact(0.3)),
        scene("", body + softBall(implicit + "<SparseLDLSolver/>") + contactWithBall(0.3)),
        scene("", body + softBall(implicit + "<CGLinearSolver iterations=\"500\" tolerance=\"1e-12\"/>") + contactWithBall(0.3))}) {
    SCOPED_TRACE(text);
    Simulation whole = simulationFromText(text), restored = simulationFromText(text);
    step(whole, 15);
    restored.restore(whole.checkpoint());
    step(whole, 5), step(restored, 5);
    EXPECT_EQ(placesOf(whole), placesOf(restored));
    setThreads(2);
    Simulation on_two = simulationFromText(text);
    step(on_two, 20);
    setThreads(1);
    EXPECT_EQ(placesOf(whole), placesOf(on_two));
    restored.reset();
    step(restored, 20);
    EXPECT_EQ(placesOf(whole), placesOf(restored));
  }
}

TEST(OtherBodies, WhatTheyCannotBeIsSaid) {
  const auto expectRefused = [](const std::string& text, const std::vector<std::string>& words) {
    const std::string problems = problemsOf(text);
    for (const std::string& word : words) EXPECT_NE(problems.find(word), std::string::npos) << word << " in: " << problems;
  };
  const std::string tool = Tool().text();
  expectRefused(scene("<CondensedStaticSolver/>", block() + tool + contact()), {"is free", "CondensedDynamicSolver"});
  std::string barrier = contact();
  barrier.replace(1, 17, "BarrierContact");
  expectRefused(scene(condensed, block() + tool + barrier), {"constraint forces only", "ConstraintContact"});
  expectRefused(scene("", block(floor_held, condensed) + Tool{.solver = "<EulerImplicitSolver rayleighStiffness=\"0.1\"/>" +
                                                                        std::string("<SparseLDLSolver/>")}.text() + contact()),
                {"rayleighStiffness", "/tool"});
  const std::string tie =
      "<DistanceLagrangianConstraint object1=\"@b/dofs\" object2=\"@c/dofs\" first_point=\"99\" second_point=\"0\"/>";
  expectRefused(scene("", block(floor_held, condensed) + softBlock("<EulerExplicitSolver/>", "") + tie), {"/c/dofs", "no linear solver"});
  expectRefused(scene("", block(floor_held, "<CondensedStaticSolver/>") + softBlock("<StaticSolver/><SparseLDLSolver/>", "") + tie),
                {"/c/dofs is free", "CondensedDynamicSolver"});
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
