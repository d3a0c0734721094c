// SPDX-License-Identifier: LGPL-2.1-or-later
// Heaps of free rigid bodies by forces of constraint: boxes and balls of twenty triangles that fall into a box.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "framework/algebra/parallel.h"
#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double gravity = 9.81, mu = 0.4, half = 0.025, radius = 0.03;
constexpr double box_mass = 8000 * half * half * half, ball_mass = 4000. / 3 * M_PI * radius * radius * radius;
constexpr double box_inertia = box_mass * half * half * 2 / 3, ball_inertia = 0.4 * ball_mass * radius * radius;

std::string ballMesh() {
  const double golden = (1 + std::sqrt(5.)) / 2, size = radius / std::sqrt(1 + golden * golden);
  std::string points;
  for (int axis = 0; axis < 3; ++axis)
    for (const double a : {-size, size})
      for (const double b : {-size * golden, size * golden}) {
        Vec3 p = Vec3::Zero();
        p[(axis + 1) % 3] = a, p[(axis + 2) % 3] = b;
        points += fmt::format("{} {} {}  ", p.x(), p.y(), p.z());
      }
  return "<MeshTopology name=\"mesh\" position=\"" + points +
         "\" triangles=\"0 2 8  0 8 4  0 4 6  0 6 9  0 9 2  2 7 5  2 5 8  8 5 10  8 10 4  4 10 1  4 1 6  6 1 11  6 11 9  9 11 7  9 7 2  "
         "3 1 10  3 10 5  3 5 7  3 7 11  3 11 1\"/>";
}

/// In layers of four, each turned another way.
std::string heap(int count, double dt, const std::string& integrator) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> aside(-0.008, 0.008);
  std::string content, others;
  for (int i = 0; i < count; ++i) {
    const bool is_box = i % 2 == 0;
    const Eigen::Quaterniond turn = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
    const double x = 0.1 * (i % 2) - 0.05 + aside(random), y = 0.1 * (i / 2 % 2) - 0.05 + aside(random), z = 0.06 + 0.095 * (i / 4);
    content += fmt::format(
        "<Node name=\"b{}\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"{} {} {}  {} {} {} {}\"/><UniformMass "
        "totalMass=\"{}\" inertia=\"{} {} {}\"/><Node name=\"skin\">{}<MechanicalObject name=\"dofs\"/><RigidMapping/></Node></Node>",
        i, x, y, z, turn.x(), turn.y(), turn.z(), turn.w(), is_box ? box_mass : ball_mass, is_box ? box_inertia : ball_inertia,
        is_box ? box_inertia : ball_inertia, is_box ? box_inertia : ball_inertia,
        is_box ? boxOf(Vec3::Constant(-half), Vec3::Constant(half)).mesh() : ballMesh());
    if (i > 0) others += fmt::format("@b{}/skin/dofs ", i);
  }
  content += fmt::format("<ConstraintContact name=\"contact\" mstate=\"@b0/skin/dofs\" other=\"{}\" contactDistance=\"1e-3\" "
                         "friction=\"{}\" selfContact=\"0\" planes=\"0 0 1 0  1 0 0 -0.11  -1 0 0 -0.11  0 1 0 -0.11  0 -1 0 -0.11\"/>",
                         others, mu);
  return contactScene(content, dt, Vec3(0, 0, -gravity), integrator);
}

const std::string newton = "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-6\"/>", one_solve = "<EulerImplicitSolver/>";

struct Motion {
  double energy = 0;  ///< with the height [J]
  double speed = 0;   ///< the largest [m/s]
};

Motion motionOf(const Simulation& simulation) {
  Motion motion;
  for (const State* state : simulation.states()) {
    if (state->name() != "frame") continue;
    const bool is_box = std::stoi(state->path().substr(2)) % 2 == 0;
    const double mass = is_box ? box_mass : ball_mass, inertia = is_box ? box_inertia : ball_inertia;
    const double v = state->v()[0].norm(), w = state->v()[1].norm();
    motion.energy += mass * gravity * state->x()[0].z() + mass * v * v / 2 + inertia * w * w / 2;
    motion.speed = std::max(motion.speed, v + w * radius);
  }
  return motion;
}

/// Twenty contacts and more at once: bodies do not meet, no step gains energy, friction is within its cone.
Motion fall(int count, double dt, int steps, const std::string& integrator) {
  Simulation simulation = simulationFromText(heap(count, dt, integrator));
  Motion before = motionOf(simulation);
  for (int step = 0; step < steps; ++step) {
    expectCleanStep(simulation, step, false);
    if (::testing::Test::HasFatalFailure()) return before;
    const Motion now = motionOf(simulation);
    EXPECT_LE(now.energy, before.energy + 1e-5) << "step " << step;
    before = now;
    const std::vector<double> forces = constraintOutput(simulation, "forces");
    for (std::size_t i = 0; i + 2 < forces.size(); i += 3)
      EXPECT_LE(std::hypot(forces[i + 1], forces[i + 2]), mu * forces[i] * 1.0005 + 1e-5) << "step " << step;
  }
  return before;
}

TEST(Heaps, OfTwelveBodiesComeToRest) { EXPECT_LT(fall(12, 5e-3, 240, newton).speed, 2e-3); }

/// Where the search for exact forces ends without any: 150 rows on 80 ways to move and more.
TEST(Heaps, OfThirtyBodiesGoOnWhereManyMeet) { fall(30, 5e-3, 50, newton); }

/// Bodies go by as much as they are long in a step of 10 ms, so that directions of forces turn to and fro from round to round.
TEST(Heaps, ByOneSolveOfEachStepComeToRest) { EXPECT_LT(fall(30, 1e-2, 140, one_solve).speed, 2e-3); }

/// Contacts come in most of these steps. What a step finds may depend on nothing that the one before has left but what a checkpoint has.
void expectSameBits(const std::string& text, int fallen, int steps) {
  Simulation whole = simulationFromText(text), restored = simulationFromText(text);
  std::vector<double> energies;
  std::size_t most_forces = 0;
  for (int step = 0; step < steps; ++step) {
    if (step >= fallen) restored.restore(whole.checkpoint()), restored.step();
    whole.step();
    energies.push_back(motionOf(whole).energy);
    if (step >= fallen) EXPECT_EQ(motionOf(restored).energy, energies.back()) << "restarted before step " << step;
    most_forces = std::max(most_forces, constraintOutput(whole, "forces").size());
  }
  EXPECT_GT(most_forces, 30u);
  setThreads(2);
  Simulation on_two = simulationFromText(text);
  for (int step = 0; step < steps; ++step) on_two.step();
  setThreads(1);
  EXPECT_EQ(motionOf(on_two).energy, energies.back());
  whole.reset();
  for (int step = 0; step < steps; ++step) whole.step();
  EXPECT_EQ(motionOf(whole).energy, energies.back());
}

/// A spring of no account between two frames couples them in the matrix of a step, so that all rows go by W.
TEST(Heaps, SweepsThroughBodiesFindTheForcesOfW) {
  const std::string alone = heap(16, 1e-2, one_solve);
  std::string coupled = alone;
  coupled.insert(coupled.rfind("<ConstraintContact"),
                 "<StiffSpringForceField object1=\"@b0/skin/dofs\" object2=\"@b15/skin/dofs\" spring=\"0 0 1e-9 0 0\"/>");
  Simulation by_bodies = simulationFromText(alone), by_w = simulationFromText(coupled);
  double most = 0;
  for (int step = 0; step < 14; ++step) {
    expectCleanStep(by_bodies, step, false), expectCleanStep(by_w, step, false);
    const double speed = motionOf(by_w).speed;
    EXPECT_NEAR(motionOf(by_bodies).speed, speed, 2e-3 * speed) << "step " << step;  // forces are those of sweeps to a tolerance
    EXPECT_NEAR(motionOf(by_bodies).energy, motionOf(by_w).energy, 1e-3 * motionOf(by_w).energy) << "step " << step;
    most = std::max(most, constraintOutput(by_bodies, "contacts").at(0));
  }
  EXPECT_GT(most, 20);
}

/// A ridge falls towards another one, parallel to it and a little aside, and turns about the vertical by `turn` in the step.
double gapOfTurnedRidges(double turn) {
  constexpr double dt = 0.01, half_diagonal = 0.025 * 1.41421356237309505, apart = 4.5e-3, below = M_PI / 4, above = M_PI / 6;
  const auto body = [&](const std::string& name, double z, double tilt, const std::string& velocity, const std::string& more) {
    return fmt::format("<Node name=\"{}\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"0 0 {}  {} 0 0 {}\" "
                       "velocity=\"{}\"/><UniformMass totalMass=\"0.1\" inertia=\"1e-4 1e-4 1e-4\"/>{}<Node name=\"skin\">{}"
                       "<MechanicalObject name=\"dofs\"/><RigidMapping/></Node></Node>",
                       name, z, std::sin(tilt / 2), std::cos(tilt / 2), velocity, more,
                       boxOf(Vec3(-0.1, -half, -half), Vec3(0.1, half, half)).mesh());
  };
  const double height = half_diagonal * (1 + std::cos(below - above)) + apart;
  const std::string text = contactScene(
      body("below", 0, below, "0 0 0  0 0 0", "<FixedProjectiveConstraint indices=\"0\"/>") +
          body("above", height, above, fmt::format("0 0 -0.4  0 0 {}", turn / dt), "") +
          "<ConstraintContact mstate=\"@below/skin/dofs\" other=\"@above/skin/dofs\" contactDistance=\"1e-3\" selfContact=\"0\"/>",
      dt, Vec3::Zero(), one_solve);
  Simulation simulation = simulationFromText(text);
  expectCleanStep(simulation, 0, false);
  EXPECT_EQ(constraintOutput(simulation, "contacts").at(0), 1);
  return constraintOutput(simulation, "smallestGap").at(0);
}

/// Nearly parallel edges have a condition as soon as rigid bodies turn them out of parallel.
TEST(Heaps, EdgesThatAStepTurnsOutOfParallelKeepTheGap) {
  for (const double turn : {0.1, 0.3}) EXPECT_NEAR(gapOfTurnedRidges(turn), 1e-3, 1e-6) << turn;
}

/// A box on a long arm goes around a block: along the arc it keeps 16 mm from it, and its straight way would cut it.
TEST(Heaps, ABoxThatTurnsGoesAroundWhatItsStraightWayWouldCut) {
  const std::string text = contactScene(
      "<Node name=\"b0\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"0 0 0  0 0 -0.149438132473599 0.988771077936042\" "
      "velocity=\"0 0 0  0 0 100\"/>"
      "<UniformMass totalMass=\"0.1\" inertia=\"1e-3 1e-3 1e-3\"/><Node name=\"skin\">" +
          boxOf(Vec3(0.19, -0.01, -0.01), Vec3(0.21, 0.01, 0.01)).mesh() +
          "<MechanicalObject name=\"dofs\"/><RigidMapping/></Node></Node>"
          "<ConstraintContact mstate=\"@b0/skin/dofs\" contactDistance=\"1e-3\" selfContact=\"0\" "
          "boxes=\"0.1594 0.0283 -0.02  0.1694 0.0383 0.02\"/>",
      1e-2, Vec3::Zero(), one_solve);
  Simulation simulation = simulationFromText(text);
  for (int step = 0; step < 3; ++step) expectCleanStep(simulation, step, false);
  const State& frame = *simulation.states().front();
  EXPECT_NEAR(frame.v()[1].z(), 100, 1e-6) << "nothing is in its way";
}

std::string cubeOf(int cells, const std::string& name, const std::string& place, double speed, const std::string& more = "") {
  return fmt::format("<Node name=\"{}\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"{} 0 0 0 1\" "
                     "velocity=\"{} 0 0 0 0 0\"/><UniformMass totalMass=\"1\" inertia=\"1.7e-3 1.7e-3 1.7e-3\"/>{}"
                     "<Node name=\"skin\">{}<MechanicalObject name=\"dofs\"/><RigidMapping/></Node></Node>",
                     name, place, speed, more, boxOf(Vec3::Constant(-0.05), Vec3::Constant(0.05), {cells, cells, cells}).mesh());
}

/// Of two cubes whose faces across x have a corner of the other nearest: the separation along the normal of such a face [m].
double gapBetween(const Simulation& simulation, const std::string& left, const std::string& right) {
  const auto skinOf = [&](const std::string& name) {
    std::vector<Vec3> points;
    for (const State* state : simulation.states())
      if (state->path() == "/" + name + "/skin/dofs")
        for (Index i = 0; i < state->size(); ++i) points.push_back(state->x()[i]);
    return points;
  };
  const std::vector<Vec3> a = skinOf(left), b = skinOf(right);
  double gap = -1e300;
  for (const std::vector<Vec3>* cube : {&a, &b}) {
    const std::size_t cells = std::size_t(std::lround(std::cbrt(double(cube->size())))) - 1;
    const Vec3 across = (cube->at(cells) - cube->at(0)).normalized();
    double most = -1e300, least = 1e300;
    for (const Vec3& p : a) most = std::max(most, across.dot(p));
    for (const Vec3& p : b) least = std::min(least, across.dot(p));
    gap = std::max(gap, least - most);
  }
  return gap;
}

/// A force takes a cube in one step through 85 mm, where no pair was near.
TEST(Heaps, WhatAForceTakesFartherThanPairsWereSearchedEndsTheRun) {
  const std::string force =
      "<LinearForceField points=\"0\" keyTimes=\"0 0.0499 0.05 0.06 0.0601 1\" forces=\"0 0 0 0 0 0  0 0 0 0 0 0  -1100 0 0 0 0 0  "
      "-1100 0 0 0 0 0  0 0 0 0 0 0  0 0 0 0 0 0\"/>";
  Simulation simulation = simulationFromText(contactScene(
      cubeOf(4, "b0", "0 0 0", 0) + cubeOf(4, "b1", "0.105 0.01 0.01", 2, force) +
          "<ConstraintContact mstate=\"@b0/skin/dofs\" other=\"@b1/skin/dofs\" contactDistance=\"2e-3\" selfContact=\"0\"/>",
      1e-2, Vec3::Zero(), one_solve));
  for (int step = 0; step < 4; ++step) expectCleanStep(simulation, step, false);
  const StepReport report = simulation.step();
  EXPECT_FALSE(report.constraints_converged) << "gap " << gapBetween(simulation, "b0", "b1");
  EXPECT_NE(report.constraint_reason.find("farther than what it can prove"), std::string::npos) << report.constraint_reason;
}

/// The first hits the second, which then comes to the third in the same step.
TEST(Heaps, WhatIsPushedOnWithinAStepKeepsTheGap) {
  for (const double speed : {4.45, 4.6, 4.8}) {
    Simulation simulation = simulationFromText(contactScene(
        cubeOf(3, "b0", "0 0 0", 0) + cubeOf(1, "b1", "-0.11 0 0", speed) + cubeOf(3, "b2", "0.12 0.01 0.01", 0) +
            "<ConstraintContact mstate=\"@b0/skin/dofs\" other=\"@b1/skin/dofs @b2/skin/dofs\" contactDistance=\"2e-3\" "
            "selfContact=\"0\"/>",
        1e-2, Vec3::Zero(), one_solve));
    const StepReport report = simulation.step();
    EXPECT_TRUE(report.constraints_converged) << "speed " << speed << ": " << report.constraint_reason;
    EXPECT_GT(gapBetween(simulation, "b0", "b2"), 2e-3 - 2.1e-5) << "speed " << speed;
    EXPECT_GT(gapBetween(simulation, "b1", "b0"), 2e-3 - 2.1e-5) << "speed " << speed;
  }
}

TEST(Heaps, HaveTheSameBitsOnTwoThreadsAfterARestartAndAReset) { expectSameBits(heap(8, 5e-3, newton), 25, 45); }
TEST(Heaps, ByOneSolveOfEachStepHaveTheSameBits) { expectSameBits(heap(12, 1e-2, one_solve), 12, 24); }

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
