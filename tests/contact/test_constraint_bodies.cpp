// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces of constraint between bodies: blocks on blocks, free bodies that hit each other, edges on edges, tools, Coulomb's law.
#include "framework/algebra/parallel.h"
#include "framework/collision/pair_distances.h"
#include "framework/mechanics/state_topology.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string euler = "<EulerImplicitSolver/>", damped = "<EulerImplicitSolver rayleighMass=\"20\"/>";
const std::string floor_is_held =
    "<BoxROI name=\"floor\" box=\"-9 -9 -0.1 9 9 0.001\"/><FixedProjectiveConstraint indices=\"@floor.indices\"/>";

std::string keeps(const std::string& more) {
  return "<ConstraintContact name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" other=\"@b/dofs\" " + more + "/>";
}

std::string velocityOf(const Body& body, const Vec3& v) {
  std::string text = "velocity=\"";
  for (std::size_t i = 0; i < body.points.size(); ++i) text += fmt::format("{} {} {}  ", v.x(), v.y(), v.z());
  return text + "\"";
}

/// Of all pairs of vertices and triangles and of edges, asked one by one.
double apart(const State& a, const State& b) {
  double least = 1e300;
  const auto edges = [](const State& s) {
    std::vector<std::array<Vec3, 2>> all;
    for (const Triangle& t : topologyOf(s)->mesh().boundaryTriangles())
      for (std::size_t k = 0; k < 3; ++k)
        if (t[k] < t[(k + 1) % 3]) all.push_back({s.x()[t[k]], s.x()[t[(k + 1) % 3]]});  // each has two triangles
    return all;
  };
  for (const auto& [p, q] : {std::array{&a, &b}, std::array{&b, &a}})
    for (Index i = 0; i < p->size(); ++i)
      for (const Triangle& t : topologyOf(*q)->mesh().boundaryTriangles())
        least = std::min(least, closestPoints(PairKind::point_triangle, {p->x()[i], q->x()[t[0]], q->x()[t[1]], q->x()[t[2]]}).distance());
  for (const auto& [p0, p1] : edges(a))
    for (const auto& [q0, q1] : edges(b)) least = std::min(least, closestPoints(PairKind::edge_edge, {p0, p1, q0, q1}).distance());
  return least;
}

Vec3 momentumOf(const Simulation& simulation) {
  Vec3 sum = Vec3::Zero();
  for (const auto& system : simulation.systems())
    for (const Mass* mass : system->masses())
      for (Index i = 0; i < mass->state().size(); ++i)
        sum += mass->lumped()[std::size_t(i)] * Vec3(system->v[mass->state().firstRow() + i]);
  return sum;
}

/// Two meshes that do not match, pressed together by weight: forces are equal and opposite, carry it, and keep the gap.
TEST(ConstraintBodies, ABlockRestsOnABlock) {
  constexpr double gap = 0.01;
  for (const double friction : {0.0, 0.3}) {
    SCOPED_TRACE(friction);
    const Body low = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 0.5), {3, 3, 2}), high = boxOf(Vec3(0.1, 0.15, 0.51), Vec3(0.8, 0.9, 1), {2, 3, 2});
    Simulation simulation = simulationFromText(contactScene(
        bodyNode("a", high, "") + bodyNode("b", low, floor_is_held) +
            keeps(fmt::format("contactDistance=\"{}\" friction=\"{}\"", gap, friction)),
        0.02, Vec3(0, 0, -9.81), damped));
    for (int i = 0; i < 100; ++i) {
      expectCleanStep(simulation, i);
      if (HasFatalFailure()) return;
      if (i % 5 != 0) continue;
      // edges along each other have no condition, nor those whose bend is no higher than a thousandth of the gap
      ASSERT_GE(apart(*simulation.states()[0], *simulation.states()[1]), gap - 2e-3 * gap) << "step " << i;
    }
    const std::vector<double> wrench = constraintOutput(simulation, "wrenches"), forces = constraintOutput(simulation, "contactForces"),
                              rubs = constraintOutput(simulation, "frictionForces");
    ASSERT_EQ(forces.size(), rubs.size());
    ASSERT_EQ(wrench.size(), 12u);
    const double weight = 1000 * 0.7 * 0.75 * 0.49 * 9.81;
    EXPECT_NEAR(wrench[2], weight, 1e-6 * weight);
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    for (std::size_t i = 0; i < forces.size(); ++i) sum[Eigen::Index(i % 3)] += forces[i] + rubs[i];
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(wrench[k], -wrench[6 + k], 1e-12 * weight);
      EXPECT_NEAR(wrench[k], sum[Eigen::Index(k)], 1e-9 * weight);
      moment[Eigen::Index(k)] = wrench[3 + k];
    }
    const Vec3 middle(0.45, 0.525, 0);  // the moment of the weight
    EXPECT_LT((moment - middle.cross(Vec3(0, 0, weight))).norm(), 2e-3 * weight);
    EXPECT_NEAR(constraintOutput(simulation, "smallestGap").at(0), gap, 2e-3 * gap);
  }
}

/// Cubes that turn to each other in any way: a corner, an edge or a side comes first.
TEST(ConstraintBodies, FreeBodiesThatHitKeepTheirMomentum) {
  const std::string integrators[] = {euler, "<TrapezoidalRuleSolver/>", "<BDFOdeSolver order=\"2\"/>",
                                     "<EulerImplicitSolver newtonIterations=\"30\"/>"};
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int pair = 0; pair < 12; ++pair) {
    SCOPED_TRACE(pair);
    const double friction = pair % 3 == 0 ? 0 : 0.4;
    Body a = boxOf(Vec3(-.5, -.5, -.5), Vec3(.5, .5, .5), {1 + pair % 2, 1, 2});
    Body b = boxOf(Vec3(-.4, -.4, -.4), Vec3(.4, .4, .4), {2, 2, 2});
    const auto turned = [&] {
      const double w = normal(random), x = normal(random), y = normal(random), z = normal(random);
      return Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix();
    };
    const double aside = 0.3 * normal(random), along = 0.3 * normal(random);
    a.turn(turned(), Vec3::Zero()), b.turn(turned(), Vec3(aside, along, 1.7));
    Simulation simulation = simulationFromText(contactScene(
        bodyNode("a", a, "", velocityOf(a, Vec3(0, 0, 2)), 1e5) + bodyNode("b", b, "", velocityOf(b, Vec3(0, 0.2, -3)), 1e6) +
            keeps(fmt::format("contactDistance=\"0.01\" friction=\"{}\"", friction)),
        0.01, Vec3::Zero(), integrators[pair % 4]));
    const Vec3 start = momentumOf(simulation);
    const double size = 1000 * 2 + 512 * 3;
    double pushed = 0;
    for (int i = 0; i < 60; ++i) {
      expectCleanStep(simulation, i);
      if (HasFatalFailure()) return;
      pushed = std::max(pushed, -constraintOutput(simulation, "wrenches").at(2));
      ASSERT_LT((momentumOf(simulation) - start).norm(), 1e-11 * size) << "step " << i;
      if (i % 4 != 0) continue;
      ASSERT_GE(apart(*simulation.states()[0], *simulation.states()[1]), 0.01 - 1e-5) << "step " << i;
    }
    EXPECT_GT(pushed, 100) << "they meet";
  }
}

/// Two wedges with their ridges across each other: only edges meet.
TEST(ConstraintBodies, EdgesAreKeptApart) {
  Body a = wedge(), b = wedge(true);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitY()).toRotationMatrix();
  b.turn(turn, Vec3(0.05, 6.1, 0.03));
  Simulation simulation = simulationFromText(contactScene(
      bodyNode("a", a, "", velocityOf(a, Vec3(0, 0.5, 0)), 1e7) + bodyNode("b", b, "", velocityOf(b, Vec3(0, -0.5, 0)), 1e7) +
          keeps("contactDistance=\"0.02\""),
      0.02, Vec3::Zero(), euler));
  double nearest = 1;
  for (int i = 0; i < 20; ++i) {
    expectCleanStep(simulation, i);
    const State &p = *simulation.states()[0], &q = *simulation.states()[1];
    const double here = closestPoints(PairKind::edge_edge, {p.x()[2], p.x()[5], q.x()[2], q.x()[5]}).distance();
    ASSERT_GE(here, 0.02 - 1e-9) << "step " << i;
    nearest = std::min(nearest, here);
  }
  EXPECT_NEAR(nearest, 0.02, 1e-9);
  const double whole = 1000 * 3;  // momentum of one: half a metre per second each, and it turns round
  EXPECT_LT(simulation.states()[0]->v()[2].y(), 0);
  EXPECT_LT(momentumOf(simulation).norm(), 1e-11 * whole);
}

/// A block on a block that leans by tan 0.5, as gravity that leans.
Simulation blocksOnSlope(double friction, const std::string& integrator, double speed) {
  const double down = 9.81 / std::sqrt(1.25);
  const Body high = boxOf(Vec3(0.2, 0.3, 0.501), Vec3(1.2, 1.3, 1.501));
  return simulationFromText(contactScene(
      bodyNode("a", high, "", velocityOf(high, Vec3(speed, 0, 0)), 1e7) +
          bodyNode("b", boxOf(Vec3(0, 0, 0), Vec3(4, 2, 0.5), {5, 3, 1}), "<FixedProjectiveConstraint fixAll=\"true\"/>", "", 1e7) +
          keeps(fmt::format("contactDistance=\"1e-3\" friction=\"{}\"", friction)),
      0.01, Vec3(0.5 * down, 0, -down), integrator));
}
double movedX(const Simulation& simulation) {
  const State& state = *simulation.states().front();
  double sum = 0;
  for (Index node = 0; node < 8; ++node) sum += (state.x()[node].x() - state.rest_position[std::size_t(node)].x()) / 8;
  return sum;
}

TEST(ConstraintBodies, WhatSticksOnABodyDoesNotMove) {
  Simulation simulation = blocksOnSlope(0.505, damped, 0);
  for (int i = 0; i < 60; ++i) {
    expectCleanStep(simulation, i);
    if (HasFatalFailure()) return;
  }
  const double before = movedX(simulation);
  for (int i = 0; i < 50; ++i) expectCleanStep(simulation, i);
  EXPECT_LT(std::abs(movedX(simulation) - before), 1e-10);
}

/// It starts with 1 m/s, so that all of it slides one way from the first step on.
TEST(ConstraintBodies, WhatSlidesOnABodyHasCoulombsForce) {
  for (const double friction : {0.49, 0.3}) {
    SCOPED_TRACE(friction);
    Simulation simulation = blocksOnSlope(friction, euler, 1);
    for (int i = 0; i < 100; ++i) {
      expectCleanStep(simulation, i);
      if (HasFatalFailure()) return;
    }
    const double expected = 9.81 / std::sqrt(1.25) * (0.5 - friction) * 1e-4 * 100 * 101 / 2;
    EXPECT_NEAR(movedX(simulation) - 1, expected, 0.01 * expected);
  }
}

/// A soft cube dents the soft block that it begins to slide on by several gaps: many contacts, of which hardly any says something
/// that others do not. What pushes and rubs it with its weight is what changes its momentum.
TEST(ConstraintBodies, WhatDentsASoftBodySlidesOnIt) {
  constexpr double dt = 0.01, mass_of_cube = 216;
  const Vec3 gravity(2, 1, -9.81);
  Simulation simulation = simulationFromText(contactScene(
      bodyNode("a", boxOf(Vec3(0.1, 0.1, 0.52), Vec3(0.7, 0.7, 1.12), {2, 2, 2}), "", "", 1e5) +
          bodyNode("b", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 0.5), {3, 3, 1}), floor_is_held, "", 1e5) +
          keeps("contactDistance=\"0.01\" friction=\"0.3\""),
      dt, gravity, euler));
  const State &high = *simulation.states()[0], &low = *simulation.states()[1];
  const auto momentum = [&] {
    Vec3 sum = Vec3::Zero();
    for (const Mass* mass : simulation.systems().front()->masses())
      for (Index i = 0; i < high.size() && &mass->state() == &high; ++i) sum += mass->lumped()[std::size_t(i)] * Vec3(high.v()[i]);
    return sum;
  };
  double deepest = 0;
  for (int i = 0; i < 60; ++i) {
    const Vec3 before = momentum();
    expectCleanStep(simulation, i);
    if (HasFatalFailure()) return;
    const std::vector<double> wrench = constraintOutput(simulation, "wrenches");
    const Vec3 expected = before + dt * (mass_of_cube * gravity + Vec3(wrench[0], wrench[1], wrench[2]));
    ASSERT_LT((momentum() - expected).norm(), 1e-8 * mass_of_cube) << "step " << i;
    for (Index node = 0; node < low.size(); ++node)
      deepest = std::max(deepest, low.rest_position[std::size_t(node)].z() - low.x()[node].z());
  }
  EXPECT_GT(deepest, 0.03) << "three gaps";
  EXPECT_GT(high.x()[0].x() - high.rest_position[0].x(), 0.01);
}

/// A soft ball whose top is pressed down and dragged, on a soft block.
TEST(ConstraintBodies, ASoftBallIsDraggedOverASoftBlock) {
  constexpr double gap = 0.0025, mu = 0.3, radius = 0.2;
  Body ball = boxOf(Vec3(-1, -1, -1), Vec3(1, 1, 1), {4, 4, 4});
  for (Vec3& p : ball.points)
    if (const double length = p.norm(); length > 0) p *= radius * p.cwiseAbs().maxCoeff() / length;
  ball.turn(Mat3::Identity(), Vec3(0.4, 0.5, 0.4 + radius + 1.2 * gap));
  const std::string hand =
      "<BoxROI name=\"top\" box=\"-9 -9 0.74 9 9 9\"/><LinearMovementProjectiveConstraint indices=\"@top.indices\" "
      "keyTimes=\"0 0.2 0.5\" outside=\"hold\" movements=\"0 0 0  0 0 -0.05  0.1 0 -0.05\"/>";
  Simulation simulation = simulationFromText(contactScene(
      bodyNode("a", ball, hand, "", 2e4) + bodyNode("b", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 0.4), {6, 6, 2}), floor_is_held, "", 2e4) +
          keeps(fmt::format("contactDistance=\"{}\" friction=\"{}\"", gap, mu)),
      0.02, Vec3::Zero(), euler));
  const State &top = *simulation.states()[0], &low = *simulation.states()[1];
  double deepest = 0;
  for (int i = 0; i < 25; ++i) {
    expectCleanStep(simulation, i);
    if (HasFatalFailure()) return;
    for (Index node = 0; node < low.size(); ++node)
      deepest = std::max(deepest, low.rest_position[std::size_t(node)].z() - low.x()[node].z());
    if (i % 6 != 0) continue;
    ASSERT_GE(apart(top, low), gap - 0.01 * gap) << "step " << i;
  }
  EXPECT_GT(deepest, 5 * gap);
  const std::vector<double> wrench = constraintOutput(simulation, "wrenches");
  EXPECT_NEAR(-wrench[0] / wrench[2], mu, 0.1) << "it slides";
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(wrench[k], -wrench[6 + k], 1e-10 * wrench[2]);
}

/// At 20 mm per step over cells of 0.4 m, without friction: nothing that it passes holds it up.
TEST(ConstraintBodies, WhatSlidesFastOverAFlatBodyIsNotHeldUp) {
  const Body top = boxOf(Vec3(-0.6, -0.1, 0.101), Vec3(-0.4, 0.1, 0.301), {2, 2, 2});
  Simulation simulation = simulationFromText(contactScene(
      bodyNode("a", top, "", velocityOf(top, Vec3(2, 0, 0))) +
          bodyNode("b", boxOf(Vec3(-1, -1, 0), Vec3(1, 1, 0.1), {5, 5, 1}), "<FixedProjectiveConstraint fixAll=\"true\"/>") +
          keeps("contactDistance=\"1e-3\""),
      0.01, Vec3(0, 0, -9.81), euler));
  const State& state = *simulation.states().front();
  for (int i = 0; i < 50; ++i) {
    expectCleanStep(simulation, i);
    if (HasFatalFailure()) return;
    for (Index node = 0; node < state.size(); ++node) ASSERT_GT(state.x()[node].z(), 0.101 - 1e-6) << "node " << node;
  }
  Vec3 mean = momentumOf(simulation) / 8;  // of 8 kg
  EXPECT_NEAR(mean.x(), 2, 1e-6);
  EXPECT_NEAR(mean.z(), 0, 1e-3);
}

/// A frame that carries a surface is pressed into a soft block on a path, and a free one falls on it.
TEST(ConstraintBodies, ARigidToolMeetsASoftBlock) {
  const Body tip = boxOf(Vec3(-.1, -.1, -.1), Vec3(.1, .1, .1));
  for (const bool is_moved : {true, false}) {
    SCOPED_TRACE(is_moved);
    const std::string hand = "<LinearMovementProjectiveConstraint indices=\"0\" keyTimes=\"0 0.2 0.6\" outside=\"hold\" "
                             "movements=\"0 0 0 0 0 0  0 0 -0.08 0 0 0  0.1 0 -0.08 0 0 0.3\"/>";
    Simulation simulation = simulationFromText(contactScene(
        fmt::format("<Node name=\"tool\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"0.52 0.47 0.63 0 0 0 1\"/>"
                    "<UniformMass totalMass=\"4\" inertia=\"0.03 0.03 0.03\"/>{}<Node name=\"skin\">{}<MechanicalObject name=\"dofs\"/>"
                    "<RigidMapping/></Node></Node>",
                    is_moved ? hand : "", tip.mesh()) +
            bodyNode("b", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 0.5), {4, 4, 2}), floor_is_held, "", is_moved ? 2e4 : 2e5) +
            fmt::format("<ConstraintContact mstate=\"@b/dofs\" topology=\"@b/mesh\" other=\"@tool/skin/dofs\" contactDistance=\"0.01\" "
                        "friction=\"{}\"/>",
                        is_moved ? 0.3 : 0.0),
        0.02, Vec3(0, 0, -9.81), "<EulerImplicitSolver rayleighMass=\"2\"/>"));
    const State *tool = nullptr, *block = nullptr;
    for (const State* state : simulation.states()) {
      if (state->path() == "/tool/skin/dofs") tool = state;
      if (state->path() == "/b/dofs") block = state;
    }
    ASSERT_TRUE(tool && block);
    for (int i = 0; i < 40; ++i) {
      expectCleanStep(simulation, i);
      if (HasFatalFailure()) return;
      ASSERT_GE(apart(*block, *tool), 0.01 - 0.25e-3 * 0.35) << "step " << i;  // flat edges, as above
    }
    const std::vector<double> wrench = constraintOutput(simulation, "wrenches");
    EXPECT_GT(wrench[8], 10) << "the tool is pushed up";
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(wrench[k], -wrench[6 + k], 1e-10 * wrench[8]);
  }
}

/// One line of a scene swaps the methods. A block that slides on another one and comes to rest: the barrier leaves a gap that is
/// less than contactDistance, and what sticks creeps with slipVelocity.
TEST(ConstraintBodies, TheBarrierComesToTheSamePlaces) {
  const Body low = boxOf(Vec3(0, 0, 0), Vec3(2, 1, 0.5), {4, 2, 1});
  const Body high = boxOf(Vec3(0.11, 0.13, 0.51), Vec3(0.71, 0.73, 1.11), {2, 2, 2});
  std::vector<Vec3> middles, pushes;
  for (const std::string method : {"ConstraintContact", "BarrierContact"}) {
    SCOPED_TRACE(method);
    Simulation simulation = simulationFromText(contactScene(
        bodyNode("a", high, "", velocityOf(high, Vec3(1, 0, 0)), 1e6) + bodyNode("b", low, floor_is_held, "", 1e6) + "<" + method +
            " name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" other=\"@b/dofs\" contactDistance=\"0.01\" friction=\"0.3\" "
            "selfContact=\"false\"/>",
        0.01, Vec3(0, 0, -9.81)));
    for (int i = 0; i < 70; ++i) {
      expectCleanStep(simulation, i, false);
      if (HasFatalFailure()) return;
    }
    const State& state = *simulation.states().front();
    Vec3 middle = Vec3::Zero();
    for (Index i = 0; i < state.size(); ++i) middle += Vec3(state.x()[i]) / double(state.size());
    middles.push_back(middle);
    std::vector<Component*> all;
    simulation.root().collect(all);
    for (const Component* component : all)
      if (component->name() == "contact") {
        std::istringstream text(component->data().find("wrenches")->print());
        Vec3 push;
        text >> push.x() >> push.y() >> push.z();
        pushes.push_back(push);
      }
  }
  // it goes v^2/(2 mu g) = 0.17 m
  EXPECT_NEAR(middles[0].x() - 0.41, 1 / (2 * 0.3 * 9.81), 0.01);
  EXPECT_LT((middles[0] - middles[1]).norm(), 0.01);
  const double weight = 1000 * 0.216 * 9.81;
  for (const Vec3& push : pushes) EXPECT_NEAR(push.z(), weight, 0.05 * weight);
}

const std::string on_each_other = bodyNode("a", boxOf(Vec3(0.1, 0.1, 0.52), Vec3(0.7, 0.7, 1.12), {2, 2, 2}), "", "", 1e6) +
                                  bodyNode("b", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 0.5), {3, 3, 1}), floor_is_held, "", 1e6);

std::vector<double> placesOf(const Simulation& simulation) {
  std::vector<double> all;
  for (const State* state : simulation.states())
    for (Index i = 0; i < state->size(); ++i)
      for (int k = 0; k < 3; ++k) all.push_back(state->x()[i][k]);
  return all;
}

TEST(ConstraintBodies, ARunRepeatsBitForBitAlsoFromACheckpoint) {
  const std::string text = contactScene(on_each_other + keeps("contactDistance=\"0.01\" friction=\"0.3\""), 0.01, Vec3(2, 1, -9.81), euler);
  Simulation whole = simulationFromText(text), restored = simulationFromText(text);
  for (int i = 0; i < 15; ++i) whole.step();
  restored.restore(whole.checkpoint());
  for (int i = 0; i < 10; ++i) expectCleanStep(whole, i), expectCleanStep(restored, i);
  EXPECT_EQ(placesOf(whole), placesOf(restored));
  EXPECT_GT(constraintOutput(whole, "contacts").at(0), 0);
  setThreads(2);
  Simulation on_two = simulationFromText(text);
  for (int i = 0; i < 25; ++i) on_two.step();
  setThreads(1);
  EXPECT_EQ(placesOf(whole), placesOf(on_two));
}

/// Two bodies as one state: what is one piece or two has the same contact.
TEST(ConstraintBodies, PiecesOfOneStateMeetBySelfContact) {
  const Body low = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 0.5), {3, 3, 1}), high = boxOf(Vec3(0.1, 0.1, 0.52), Vec3(0.7, 0.7, 1.12), {2, 2, 2});
  Body both = high;
  for (const Vec3& p : low.points) both.points.push_back(p);
  for (auto c : low.cells) {
    for (int& node : c) node += int(high.points.size());
    both.cells.push_back(c);
  }
  const std::string keep = "contactDistance=\"0.01\" friction=\"0.3\"";
  Simulation one = simulationFromText(contactScene(
      bodyNode("a", both, floor_is_held + "<ConstraintContact selfContact=\"true\" " + keep + "/>", "", 1e6), 0.01, Vec3(2, 1, -9.81),
      euler));
  Simulation two = simulationFromText(contactScene(on_each_other + keeps(keep), 0.01, Vec3(2, 1, -9.81), euler));
  for (int i = 0; i < 25; ++i) {
    expectCleanStep(one, i), expectCleanStep(two, i);
    if (HasFatalFailure()) return;
  }
  const std::vector<double> a = placesOf(one), b = placesOf(two);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-8);
}

/// A box and the mesh of that box are as good as a plane below a cube.
TEST(ConstraintBodies, FlatObstaclesCarryAsAPlaneDoes) {
  const Body cube = boxOf(Vec3(0, 0, 0.02), Vec3(1, 1, 1.02), {2, 2, 2});
  const std::string mesh =
      "<Node name=\"o\"><MeshTopology name=\"mesh\" position=\"-1 -1 0  2 -1 0  2 2 0  -1 2 0\" triangles=\"0 1 2  0 2 3\"/></Node>";
  std::vector<double> expected;
  for (const char* obstacle : {"planes=\"0 0 1 0\"", "boxes=\"-1 -1 -1  2 2 0\"", "meshes=\"@/o/mesh\""}) {
    SCOPED_TRACE(obstacle);
    Simulation simulation = simulationFromText(contactScene(
        mesh + bodyNode("a", cube,
                        fmt::format("<ConstraintContact contactDistance=\"0.01\" keyTimes=\"0 1\" movements=\"0 0 0  0 0 0.1\" {}/>",
                                    obstacle),
                        "", 1e5),
        0.02, Vec3(0, 0, -9.81), damped));
    for (int i = 0; i < 30; ++i) {
      expectCleanStep(simulation, i);
      if (HasFatalFailure()) return;
    }
    EXPECT_NEAR(simulation.states().front()->x()[4].z(), 0.01 + 0.06, 1e-9);
    const std::vector<double> places = placesOf(simulation);
    if (expected.empty()) expected = places;
    for (std::size_t i = 0; i < places.size(); ++i) ASSERT_NEAR(places[i], expected[i], 1e-8);
  }
}

/// Nothing can mend what moves on a path into what is held.
TEST(ConstraintBodies, WhatDoesNotHoldIsNamedWithItsNodes) {
  for (const double way : {-0.3, -3.0}) {
    Simulation simulation = simulationFromText(contactScene(
        bodyNode("a", boxOf(Vec3(0.3, 0.3, 1.02), Vec3(0.6, 0.6, 1.32)),
                 fmt::format("<LinearMovementProjectiveConstraint indices=\"0 1 2 3 4 5 6 7\" keyTimes=\"0 1\" "
                             "movements=\"0 0 0  0 0 {}\"/>",
                             way)) +
            bodyNode("b", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)), "<FixedProjectiveConstraint fixAll=\"true\"/>") +
            keeps("contactDistance=\"0.01\""),
        0.05, Vec3::Zero(), euler));
    StepReport report;
    for (int i = 0; i < 5 && report.constraints_converged; ++i) report = simulation.step();
    ASSERT_FALSE(report.constraints_converged);
    expectContains(report.constraint_reason, "the Lagrangian constraint /contact does not hold");
    expectContains(report.constraint_reason, "(node ");
    expectContains(report.constraint_reason, " of /a/dofs, node ");
    expectContains(report.constraint_reason, " of /b/dofs");
  }
}

/// What is in one another is refused; what is nearer than the gap that is kept is told of.
TEST(ConstraintBodies, BadStartsAreSaidWithTheirPlaces) {
  const auto problems = [](const Vec3& shift, double size, double distance) {
    Body high = boxOf(Vec3(0, 0, 0), Vec3(size, size, size));
    high.turn(Mat3::Identity(), shift);
    return saidOf(contactScene(
        bodyNode("a", high, "") + bodyNode("b", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)), "") +
            keeps(fmt::format("contactDistance=\"{}\"", distance)),
        0.01, Vec3::Zero(), euler));
  };
  const std::string crossing = problems(Vec3(0.5, 0.4, 0.9), 0.3, 0.01);
  expectContains(crossing, "bodies of /contact start in one another");
  expectContains(crossing, "through the triangle of node");
  expectContains(problems(Vec3(0.5, 0.4, 0.3), 0.3, 0.01), "of /contact is inside of another body");
  const std::string near = problems(Vec3(0.5, 0.4, 1.02), 0.3, 0.05);
  expectContains(near, "starts with a gap of 0.02 m from the surface at node");
  expectContains(near, "contactDistance is 0.05 m");
  EXPECT_EQ(problems(Vec3(0.5, 0.4, 1.02), 0.3, 0.02), "");
  const auto mapped = [](double height, double distance) {  // of a tool that a frame carries
    return saidOf(contactScene(
        fmt::format("<Node name=\"tool\"><MechanicalObject template=\"Rigid3\" position=\"0.5 0.5 {} 0 0 0 1\"/>"
                    "<UniformMass totalMass=\"4\" inertia=\"0.03 0.03 0.03\"/><Node name=\"skin\">{}<MechanicalObject name=\"dofs\"/>"
                    "<RigidMapping/></Node></Node>",
                    height, boxOf(Vec3(-.1, -.1, -.1), Vec3(.1, .1, .1)).mesh()) +
            bodyNode("b", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)), "") +
            fmt::format("<ConstraintContact name=\"contact\" mstate=\"@b/dofs\" topology=\"@b/mesh\" other=\"@tool/skin/dofs\" "
                        "contactDistance=\"{}\"/>",
                        distance),
        0.01, Vec3::Zero(), euler));
  };
  expectContains(mapped(1.05, 0.01), "error: /contact: bodies of /contact start in one another");
  expectContains(mapped(0.5, 0.01), "of /contact is inside of another body");
  expectContains(mapped(1.12, 0.03), "starts with a gap of 0.02 m from the surface at node");
  EXPECT_EQ(mapped(1.12, 0.01), "");
  const auto above = [](double height) {  // a plane that begins half a metre below where it is written
    return saidOf(contactScene(
        fmt::format("<MechanicalObject template=\"Rigid3\" position=\"0 0 {} 0 0 0 1\"/><UniformMass totalMass=\"4\" "
                    "inertia=\"0.03 0.03 0.03\"/><Node name=\"skin\">{}<MechanicalObject/><RigidMapping/><ConstraintContact "
                    "planes=\"0 0 1 0\" contactDistance=\"0.01\" keyTimes=\"0 1\" movements=\"0 0 -0.5  0 0 -0.4\"/></Node>",
                    height, boxOf(Vec3(-.1, -.1, -.1), Vec3(.1, .1, .1)).mesh()),
        0.01, Vec3::Zero(), euler));
  };
  EXPECT_EQ(above(-0.3), "");
  expectContains(above(-0.395), "starts with a gap of 0.005 m");
  const Body cube = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1));
  expectContains(problemsOf(contactScene(bodyNode("a", cube, "<ConstraintContact/>"), 0.01, Vec3::Zero(), euler)), 
                 "nothing to be in contact with");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
