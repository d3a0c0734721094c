// SPDX-License-Identifier: LGPL-2.1-or-later
// PenaltyContact: its gap by the pressure, its derivatives, momentum, and that the three contacts take one scene.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>

#include "framework/mechanics/step_limiter.h"
#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string penalty(const std::string& attributes) {
  return fmt::format("<PenaltyContact name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" other=\"@b/dofs\" {}/>", attributes);
}

std::vector<double> valuesOf(Simulation& simulation, const std::string& type, const char* name) {
  std::vector<Component*> all;
  simulation.root().collect(all);
  std::vector<double> values;
  for (const Component* component : all)
    if (component->type() == type) {
      std::istringstream text(component->data().find(name)->print());
      for (double value = 0; text >> value;) values.push_back(value);
    }
  return values;
}

/// Two blocks under a pressure p rest at the gap 1 - p/kappa everywhere, whatever their cells are, and below zero where p is more.
TEST(PenaltyContact, BlocksRestAtTheGapOfTheirPressure) {
  constexpr double range = 0.02, kappa = 1e5;
  const std::string upright = "<PartialFixedProjectiveConstraint indices=\"{}\" fixedDirections=\"1 1 {}\"/>";
  for (const double share : {0.1, 0.5, 1.5}) {
    const Body low = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 0.5), {3, 3, 2}),
               high = boxOf(Vec3(0, 0, 0.5 + 0.9 * range), Vec3(1, 1, 1 + 0.9 * range), {3, 3, 2});
    std::string all, bottom;
    for (int i = 0; i < 48; ++i) all += fmt::format("{} ", i);
    for (int i = 0; i < 16; ++i) bottom += fmt::format("{} ", i);
    const std::string load = fmt::format("<SurfacePressureForceField pressure=\"{}\" min=\"-1 -1 {}\" max=\"2 2 2\"/>",
                                         -share * kappa, 0.99 + 0.9 * range);
    Simulation simulation = simulationFromText(contactScene(
        bodyNode("a", low, fmt::format(fmt::runtime(upright), all, 0) + fmt::format(fmt::runtime(upright), bottom, 1), "", 1e7, 0) +
            bodyNode("b", high, fmt::format(fmt::runtime(upright), all, 0) + load, "", 1e7, 0) +
            penalty(fmt::format("contactDistance=\"{}\" stiffness=\"{}\" thickness=\"{}\"", range, kappa, 0)),
        1, Vec3::Zero(), "<StaticSolver/>"));
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.newton_converged) << report.reason;
    const System& system = *simulation.systems()[0];
    const Index a = simulation.states()[0]->firstRow(), b = simulation.states()[1]->firstRow();
    for (Index i = 0; i < 16; ++i)
      EXPECT_NEAR((system.x[b + i].z() - system.x[a + 32 + i].z()) / range, 1 - share, 1e-4) << "p/kappa " << share;
    EXPECT_NEAR(valuesOf(simulation, "PenaltyContact", "smallestGap").at(0) / range, 1 - share, 1e-4);
    EXPECT_NEAR(valuesOf(simulation, "PenaltyContact", "wrenches").at(2), -share * kappa, 1e-4 * share * kappa);
    for (const double p : valuesOf(simulation, "PenaltyContact", "pressures"))
      if (p > 0) {
        EXPECT_NEAR(p, share * kappa, 1e-3 * share * kappa) << "of each node";
      }
  }
}

/// A block falls onto a plane in one step that would take it far through, and rests where its weight says: with a step, a stiffness
/// and a body a million times what is usual.
TEST(PenaltyContact, ABlockRestsAfterStepsThatAreFarTooLarge) {
  struct Case {
    double dt, kappa, young;
    const char* method;
  };
  constexpr double range = 1e-3;
  for (const Case& c : {Case{10, 1e3, 1e4, "svd"}, Case{10, 1e3, 1e4, "large"}, Case{1, 1e3, 1e4, "large"},
                        Case{0.01, 1e12, 1e4, "svd"}, Case{0.01, 1e3, 1e12, "large"}}) {
    SCOPED_TRACE(fmt::format("dt {}, stiffness {}, E {}, {}", c.dt, c.kappa, c.young, c.method));
    Simulation simulation = simulationFromText(fmt::format(
        "<Node dt='{}' gravity='0 0 -10'><EulerImplicitSolver newtonIterations='40'/><SparseLDLSolver/>"
        "<RegularGridTopology n='3 3 3' min='0 0 0.0015' max='0.1 0.1 0.1015'/><MechanicalObject name='dofs'/>"
        "<UniformMass totalMass='0.1'/><HexahedronFEMForceField method='{}' youngModulus='{}' poissonRatio='0.3'/>"
        "<PenaltyContact contactDistance='{}' stiffness='{}' planes='0 0 1 0'/></Node>",
        c.dt, c.method, c.young, range, c.kappa));
    int iterations = 0;
    for (int i = 0; i < 30; ++i) {
      const StepReport report = simulation.step();
      ASSERT_TRUE(report.newton_converged) << "step " << i << ": " << report.reason;
      iterations += report.newton_iterations;
    }
    EXPECT_LT(iterations, 300);
    EXPECT_NEAR(valuesOf(simulation, "PenaltyContact", "wrenches").at(2), 1, 0.05) << "the weight";
    const double gap = valuesOf(simulation, "PenaltyContact", "smallestGap").at(0);
    EXPECT_GT(gap, 0) << "under a pressure of 100";
    EXPECT_LT(gap, 1.0001 * range);
  }
}

/// In a step the contacts stay, so that force, energy, product, matrix and diagonal are of one potential.
TEST(PenaltyContact, ForceProductAndMatrixBelongTogether) {
  int checked = 0;
  for (unsigned seed = 1; seed < 20; ++seed) {
    const Body a = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)), b = boxAbove(seed, 0.03);
    FieldUnderTest t(contactScene(bodyNode("a", a, "") + bodyNode("b", b, "") +
                                  penalty("contactDistance=\"0.2\" planes=\"0 0 1 -0.1\" spheres=\"1.32 0.45 0.55 0.2\"")),
                     "PenaltyContact");
    if (const Vector f = t.force(); dot(f, f) == 0) continue;
    ++checked;
    const double step = 1e-6;
    expectForceOfEnergy(t, step, seed);
    EXPECT_LT(relativeDifference(t.differenceOfForces(step), t.product(t.direction)), 1e-6) << "seed " << seed;
    expectMatrixOfProducts(t);
    expectSymmetricProducts(t);
  }
  EXPECT_GT(checked, 10);
}

/// Two free bodies that hit each other keep their linear momentum to round-off, with explicit steps and with implicit ones.
TEST(PenaltyContact, CollidingBodiesKeepTheirMomentum) {
  for (const auto& [integrator, dt, steps] :
       {std::tuple("<EulerImplicitSolver/>", 0.005, 60), std::tuple("<EulerExplicitSolver/>", 2e-4, 1000)}) {
    SCOPED_TRACE(integrator);
    Body a = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {2, 2, 2}), b = boxOf(Vec3(0, 0, 0), Vec3(0.8, 0.8, 0.8), {2, 2, 2});
    b.turn(Eigen::AngleAxisd(0.7, Vec3(1, 2, 0.3).normalized()).toRotationMatrix(), Vec3(0.3, 0.2, 0));
    b.turn(Mat3::Identity(), Vec3(0, 0, 1.12 - b.lowest(2)));
    std::string velocity = "velocity=\"";
    for (int i = 0; i < 27; ++i) velocity += "0.2 0 -1 ";
    Simulation simulation =
        simulationFromText(contactScene(bodyNode("a", a, "", "", 1e5) + bodyNode("b", b, "", velocity + "\"", 1e5) +
                                            penalty("contactDistance=\"0.1\" friction=\"0.2\""),
                                        dt, Vec3::Zero(), integrator));
    System& system = *simulation.systems()[0];
    const Vec3 before = momentumOf(system);
    double pushed = 0;
    for (int i = 0; i < steps; ++i) {
      expectCleanStep(simulation, i, false);
      if (HasFatalFailure()) return;
      pushed = std::max(pushed, std::abs(valuesOf(simulation, "PenaltyContact", "wrenches").at(2)));
      ASSERT_LT((momentumOf(system) - before).norm(), 1e-9 * before.norm()) << "step " << i;
    }
    EXPECT_GT(pushed, 0) << "they never met";
  }
}

/// One line of a scene swaps the three: bodies, obstacles and attributes are the same, and the force that carries a block is its weight.
TEST(PenaltyContact, OneLineSwapsTheThree) {
  for (const char* type : {"BarrierContact", "ConstraintContact", "PenaltyContact"}) {
    SCOPED_TRACE(type);
    Simulation simulation = simulationFromText(contactScene(
        bodyNode("a", boxOf(Vec3(0, 0, 0.021), Vec3(1, 1, 0.521)), "") +
            bodyNode("b", boxOf(Vec3(0.1, 0.1, 0.542), Vec3(0.9, 0.9, 0.942)), "") +
            fmt::format("<{} name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" other=\"@b/dofs\" contactDistance=\"0.02\" "
                        "thickness=\"0\" friction=\"0.3\" selfContact=\"false\" planes=\"0 0 1 0\"/>",
                        type),
        0.01, Vec3(0, 0, -9.81), "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-9\" rayleighMass=\"20\"/>"));
    for (int i = 0; i < 60; ++i) {
      expectCleanStep(simulation, i, false);
      if (HasFatalFailure()) return;
    }
    const std::vector<double> wrenches = valuesOf(simulation, type, "wrenches");
    ASSERT_EQ(wrenches.size(), 12u);
    EXPECT_NEAR(wrenches[2], 500 * 9.81, 0.01 * 500 * 9.81) << "on the lower one: its weight";
    EXPECT_NEAR(wrenches[8], 256 * 9.81, 0.01 * 256 * 9.81) << "on the upper one: its weight";
  }
}

/// A sphere is drawn over a block 0.02 per step. Along the normal that each step has, its cells come 5e-4 out of reach of a penalty that
/// closes gaps by no more than 2e-4: the friction is that of the force before.
TEST(PenaltyContact, ARoundToolThatIsDrawnAlongRubs) {
  const Body block = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 0.5), {4, 4, 2});
  std::string bottom;
  for (int i = 0; i < 25; ++i) bottom += fmt::format("{} ", i);
  const std::string contact =
      "<FixedProjectiveConstraint indices=\"" + bottom +
      "\"/><PenaltyContact selfContact=\"false\" contactDistance=\"0.01\" stiffness=\"1e6\" friction=\"0.4\" slipVelocity=\"1e-3\" "
      "spheres=\"0.5 0.5 0.915 0.4\" keyTimes=\"0 4 14\" movements=\"0 0 0  0 0 -0.06  0.2 0 -0.06\"/>";
  Simulation simulation =
      simulationFromText(contactScene(bodyNode("a", block, contact, "", 1e4, 0.3), 1, Vec3::Zero(), "<StaticSolver/>"));
  for (int i = 0; i < 14; ++i) {
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.newton_converged) << report.reason;
    if (i < 6) continue;
    Vec3 along = Vec3::Zero(), normal = Vec3::Zero();
    const std::vector<double> rubs = valuesOf(simulation, "PenaltyContact", "frictionForces"),
                              pushes = valuesOf(simulation, "PenaltyContact", "contactForces");
    for (std::size_t k = 0; k < rubs.size(); ++k) along[int(k % 3)] += rubs[k], normal[int(k % 3)] += pushes[k];
    EXPECT_NEAR(along.x() / normal.norm(), 0.4, 0.04) << "step " << i;
  }
}

/// Who asks for forces after steps leaves the friction of a round body as it is: the same bits.
TEST(PenaltyContact, WhoAsksForForcesChangesNoFriction) {
  const auto run = [](bool asks) {
    const std::string contact =
        "<PenaltyContact selfContact=\"false\" contactDistance=\"0.01\" stiffness=\"1e6\" friction=\"0.4\" slipVelocity=\"1e-3\" "
        "spheres=\"0.5 0.5 -0.385 0.4\" keyTimes=\"0 4\" movements=\"0 0 0  2 0 0\"/>";
    const Body block = boxOf(Vec3(0, 0, 0.02), Vec3(1, 1, 0.52), {4, 4, 2});
    Simulation simulation = simulationFromText(
        contactScene(bodyNode("a", block, contact, "", 1e4, 0.3), 0.01, Vec3(0, 0, -9.81), "<EulerImplicitSolver/>"));
    if (asks) simulation.states().front()->requestForce();
    for (int i = 0; i < 60; ++i) simulation.step();
    const ConstRows x = simulation.systems()[0]->x;
    return std::vector<double>(x.data, x.data + x.doubles());
  };
  EXPECT_EQ(run(false), run(true));
}

/// A plane that is moved carries a block along by no more than mu g; a run that goes on from a checkpoint is the same to the bit.
TEST(PenaltyContact, GoesOnFromACheckpoint) {
  const auto make = [] {
    return simulationFromText(contactScene(
        bodyNode(
            "a", boxOf(Vec3(0, 0, 0.0195), Vec3(1, 1, 0.5195), {2, 2, 1}),
            "<PenaltyContact contactDistance=\"0.02\" friction=\"0.3\" staticFriction=\"0.4\" planes=\"0 0 1 0\" keyTimes=\"0 10\" "
            "movements=\"0 0 0  2 0 0\"/>"),
        0.01, Vec3(0, 0, -9.81), "<EulerImplicitSolver/>"));
  };
  Simulation whole = make(), half = make();
  double fastest = 0, before = 0;
  for (int i = 0; i < 40; ++i) {
    whole.step();
    const double speed = whole.systems()[0]->v[0].x();
    fastest = std::max(fastest, speed - before), before = speed;
  }
  EXPECT_GT(fastest, 0.005) << "it is carried along";
  for (int i = 0; i < 20; ++i) half.step();
  Simulation rest = make();
  rest.restore(half.checkpoint());
  for (int i = 20; i < 40; ++i) rest.step();
  for (Index i = 0; i < whole.systems()[0]->x.count(); ++i)
    EXPECT_EQ(Vec3(rest.systems()[0]->x[i]), Vec3(whole.systems()[0]->x[i])) << i;
}

/// Three masses of 1 kg at the corners of a triangle, at rest on the plane z = 0 by a penalty of 8.3e6 N/m each.
struct RubbingMasses {
  Simulation simulation;
  RubbingMasses(const std::string& integrator, double dt, double slope, const Vec3& velocity, const std::string& contact)
      : simulation(simulationFromText(sceneOf(integrator, dt, slope, velocity, contact))) {}
  static std::string sceneOf(const std::string& integrator, double dt, double slope, const Vec3& velocity,
                             const std::string& contact) {
    const Vec3 gravity = 9.81 / std::hypot(1, slope) * Vec3(slope, 0, -1), &v = velocity;
    const double z = 0.02 * (1 + gravity.z() * 6 / 1e6);
    return contactScene(
        fmt::format("<Node name=\"a\"><MeshTopology name=\"mesh\" position=\"0 0 {0}  1 0 {0}  0 1 {0}\" triangles=\"0 1 2\"/>"
                    "<MechanicalObject name=\"dofs\" velocity=\"{1} {2} {3}  {1} {2} {3}  {1} {2} {3}\"/><UniformMass "
                    "totalMass=\"3\"/><PenaltyContact contactDistance=\"0.02\" stiffness=\"1e6\" selfContact=\"0\" "
                    "planes=\"0 0 1 0\" {4}/></Node>",
                    z, v.x(), v.y(), v.z(), contact),
        dt, gravity, integrator);
  }
  void run(double time, double dt) {
    for (long i = std::lround(time / dt); i > 0; --i) ASSERT_FALSE(simulation.step().diverged);
  }
  Vec3 place() { return simulation.systems()[0]->x[0]; }
  Vec3 speed() { return simulation.systems()[0]->v[0]; }
};

/// What sticks on a slope is held by forces that can be read: rayleighStiffness damps nothing of a tangent that is no stiffness.
TEST(PenaltyContact, WhatSticksIsHeldByTheForceThatIsReported) {
  constexpr double slope = 0.1, mass = 3, dt = 0.01;
  RubbingMasses masses("<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-10\" rayleighStiffness=\"0.01\"/>", dt, slope,
                       Vec3::Zero(), "friction=\"0.3\"");
  masses.run(0.5, dt);
  const std::vector<double> wrench = valuesOf(masses.simulation, "PenaltyContact", "wrenches");
  ASSERT_GE(wrench.size(), 6U);
  const Vec3 sum(wrench[0], wrench[1], wrench[2]);
  const Vec3 weight = 9.81 * mass / std::hypot(1, slope) * Vec3(slope, 0, -1);
  EXPECT_LT((sum + weight).norm(), 1e-3 * weight.norm()) << sum.transpose();
}

/// mu l whatever the integrator: with one linear solve per step, which would hold what slides by the tangent of what sticks, and in
/// explicit steps, which take forces where nothing has slid yet.
TEST(PenaltyContact, EveryIntegratorRubs) {
  constexpr double g = 9.81;
  for (const char* integrator :
       {"<EulerImplicitSolver/>", "<EulerImplicitSolver newtonIterations=\"30\"/>", "<BDFOdeSolver/>", "<NewmarkImplicitSolver/>",
        "<TrapezoidalRuleSolver/>", "<EulerExplicitSolver/>", "<CentralDifferenceSolver/>", "<NewtonCotesSolver/>",
        "<RungeKutta2Solver/>", "<RungeKutta4Solver/>"}) {
    SCOPED_TRACE(integrator);
    const std::string name = integrator;
    const bool is_implicit = name.find("Impl") != name.npos || name.find("BDF") != name.npos || name.find("Rule") != name.npos;
    const double dt = is_implicit ? 0.002 : 2e-4;
    // what these do not damp begins to slide with the speed of its spring
    const double swing = name.find("Newmark") != name.npos || name.find("Rule") != name.npos ? 7e-3 : 1e-3;
    for (const double mu : {0.1, 0.3, 0.45}) {
      RubbingMasses down(integrator, dt, 0.5, Vec3::Zero(), fmt::format("friction=\"{}\"", mu));
      down.run(0.5, dt);
      const double way = 0.125 * g * (0.5 - mu) / std::hypot(1, 0.5);
      EXPECT_NEAR(down.place().x(), way, 0.01 * way + swing) << "slides, mu " << mu;
    }
    RubbingMasses still(integrator, dt, 0.5, Vec3::Zero(), "friction=\"0.6\"");
    still.run(0.5, dt);
    EXPECT_LT(std::abs(still.place().x()), swing) << "sticks";
    RubbingMasses sliding(integrator, dt, 0, Vec3(0.6, -0.8, 0), "friction=\"0.5\"");
    sliding.run(0.4, dt);
    const double stop = 1 / (2 * 0.5 * g);
    EXPECT_LT((sliding.place() - Vec3(0.6, -0.8, 0) * stop).head<2>().norm(), 2e-3) << "stops";
    EXPECT_LT(sliding.speed().norm(), 0.02);
    RubbingMasses carried(integrator, dt, 0, Vec3::Zero(), "friction=\"0.3\" keyTimes=\"0 10\" movements=\"0 0 0  10 0 0\"");
    carried.run(0.2, dt);
    EXPECT_NEAR(carried.speed().x(), 0.2 * 0.3 * g, 0.01) << "is carried along";
    carried.run(0.4, dt);
    EXPECT_NEAR(carried.speed().x(), 1, 0.02) << "and not faster than what carries it";
  }
}

/// A rigid box of 1 kg whose edges go straight slides at 1 m/s over a slab that is held, 5 mm per step, with a mesh of any cells: it passes
/// rows of nodes that are beside its front edge where a step starts. It has v t - mu g t^2/2 and its weight.
TEST(PenaltyContact, NodesBesideARimDoNotStopWhatSlides) {
  constexpr double g = 9.81, range = 1e-3, side = 0.1, kappa = 2e5, dt = 0.005;
  const auto rigid = [](const char* name, const Body& body, const std::string& frame, const char* more) {
    return fmt::format(
        "<Node name=\"{}\"><MechanicalObject name=\"frame\" template=\"Rigid3\" {}/><UniformMass totalMass=\"1\" inertia=\"{} {} {}\"/>"
        "{}<Node name=\"skin\">{}<MechanicalObject name=\"dofs\"/><RigidMapping/></Node></Node>",
        name, frame, side * side / 6, side * side / 6, side * side / 6, more, body.mesh());
  };
  for (const char* newton : {"newtonIterations=\"60\" newtonTolerance=\"1e-8\"", ""})
    for (const double mu : {0.0, 0.25}) {
      SCOPED_TRACE(fmt::format("{}, mu {}", newton, mu));
      const double rest = side / 2 + range * (1 - g / (side * side) / kappa);
      Simulation simulation = simulationFromText(contactScene(
          rigid("slab", boxOf(Vec3(-2, -.5, -.05), Vec3(2, .5, .05), {24, 6, 1}), "position=\"1 0.0123 -0.05  0 0 0 1\"",
                "<FixedProjectiveConstraint indices=\"0\"/>") +
              rigid("box", boxOf(Vec3(-side / 2, -side / 2, -side / 2), Vec3(side / 2, side / 2, side / 2), {2, 2, 2}),
                    fmt::format("position=\"-0.5 0 {}  0 0 0 1\" velocity=\"1 0 0  0 0 0\"", rest), "") +
              fmt::format("<PenaltyContact mstate=\"@box/skin/dofs\" other=\"@slab/skin/dofs\" contactDistance=\"{}\" "
                          "stiffness=\"{}\" friction=\"{}\" selfContact=\"0\"/>",
                          range, kappa, mu),
          dt, Vec3(0, 0, -g), fmt::format("<EulerImplicitSolver {}/>", newton)));
      const State* box = nullptr;
      for (const State* state : simulation.states())
        if (state->path() == "/box/frame") box = state;
      double highest = 0, lowest = 1;
      for (int i = 0; i < 80; ++i) {
        ASSERT_FALSE(simulation.step().diverged);
        highest = std::max(highest, box->x()[0].z() - side / 2), lowest = std::min(lowest, box->x()[0].z() - side / 2);
      }
      const double time = 80 * dt, way = time - 0.5 * mu * g * time * time;
      EXPECT_NEAR(box->x()[0].x() + 0.5, way, mu == 0 ? 1e-3 * way : 0.04 * way);
      EXPECT_GT(lowest, 0.9 * range);
      EXPECT_LT(highest, 1.5 * range);
    }
}

/// A run with friction by springs goes on from a checkpoint to the bit, sticking and sliding.
TEST(PenaltyContact, SpringsGoOnFromACheckpoint) {
  constexpr double dt = 0.002;
  for (const char* integrator : {"<EulerImplicitSolver/>", "<EulerExplicitSolver/>"})
    for (const double mu : {0.3, 0.6}) {
      const auto make = [&] { return RubbingMasses(integrator, dt, 0.5, Vec3(0.1, 0.1, 0), fmt::format("friction=\"{}\"", mu)); };
      RubbingMasses whole = make(), half = make(), rest = make();
      whole.run(0.2, dt), half.run(0.1, dt);
      rest.simulation.restore(half.simulation.checkpoint());
      rest.run(0.1, dt);
      EXPECT_EQ(rest.place(), whole.place()) << integrator << ", mu " << mu;
    }
}

TEST(PenaltyContact, RefusesWhatCanNeverAct) {
  const auto with = [](const std::string& attributes) {
    return problemsOf(contactScene(bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)), "<PenaltyContact " + attributes + "/>"), 0.01,
                                   Vec3::Zero(), "<EulerExplicitSolver/>"));
  };
  expectContains(with("selfContact=\"0\""), "nothing to be in contact with");
  expectContains(with("keyTimes=\"0 1\" movements=\"0 0 0  0 0 1\""), "move obstacles, and there is none");
  EXPECT_EQ(with("selfContact=\"0\" planes=\"0 0 1 -1\""), "");
  expectContains(with("planes=\"0 0 1 -1\" contactDistance=\"0.02\" alarmDistance=\"0.01\""), "alarmDistance of /a/PenaltyContact");
  expectContains(with("planes=\"0 0 1 -1\" alarmDistance=\"1e-9\""), "alarmDistance of /a/PenaltyContact");
  // told of the contact, not of the integrator that compiles it
  for (const char* wrong : {"planes=\"0 0 1\"", "planes=\"0 0 0 1\"", "spheres=\"0 0 9 -1\"", "capsules=\"0 0 9 0 0 8\"",
                            "cylinders=\"0 0 9 0 0 9 1\"", "boxes=\"0 0 9 1\""})
    expectContains(with(wrong), "/a/PenaltyContact: ");
}

/// What a box of 1 m and 1000 kg that falls on something says at the end of a second.
std::string doubtOfFall(const std::string& obstacle, double speed, double stiffness) {
  const Body box = boxOf(Vec3(0.1, 0.1, 0.3), Vec3(1.1, 1.1, 1.3), {1, 1, 1});
  std::string velocity = "velocity=\"";
  for (int i = 0; i < 8; ++i) velocity += fmt::format("0 0 {} ", -speed);
  const std::string sheet = "<Node name=\"sheet\"><MeshTopology name=\"mesh\" position=\"-2 -2 0  3 -2 0  3 3 0  -2 3 0\" "
                            "triangles=\"0 1 2  0 2 3\"/></Node>";
  Simulation simulation = simulationFromText(contactScene(
      sheet + fmt::format("<Node name=\"a\">{}<MechanicalObject name=\"dofs\" {}\"/><UniformMass totalMass=\"1000\"/>"
                          "<TetrahedronFEMForceField youngModulus=\"1e7\" poissonRatio=\"0.3\"/></Node>"
                          "<PenaltyContact name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" {} contactDistance=\"0.05\" "
                          "alarmDistance=\"0.2\" stiffness=\"{}\"/>",
                          box.mesh(), velocity, obstacle, stiffness),
      0.01, Vec3(0, 0, -10), "<EulerImplicitSolver newtonIterations=\"20\"/>"));
  for (int i = 0; i < 100; ++i) simulation.step();
  std::string said;
  for (ForceField* field : simulation.systems()[0]->forceFields()) said += field->doubt(simulation.systems()[0]->x);
  return said;
}

/// It rests on a sheet and on a plane; goes into and through both where they are soft; and jumps over the sheet within a step.
TEST(PenaltyContact, WhatGoesThroughIsSaid) {
  for (const std::string obstacle : {"meshes=\"@sheet/mesh\"", "planes=\"0 0 1 0\""}) {
    EXPECT_EQ(doubtOfFall(obstacle, 0, 1e6), "") << obstacle;
    EXPECT_THAT(doubtOfFall(obstacle, 0, 1e3), ::testing::AllOf(::testing::HasSubstr("in one another, first by t = 0.2"),
                                                                ::testing::HasSubstr("of /a/dofs")))
        << obstacle;
  }
  EXPECT_THAT(doubtOfFall("meshes=\"@sheet/mesh\"", 300, 1e6), ::testing::HasSubstr("passed through a surface of /contact by t = 0.01"));
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
