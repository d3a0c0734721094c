// SPDX-License-Identifier: LGPL-2.1-or-later
// Rods that an InterventionalRadiologyController pushes and turns, alone and one in the other.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "framework/mechanics/frames.h"
#include "framework/simulation/simulation.h"
#include "tests/beams/pushed_rods.h"
#include "tests/support/folder_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

class RodsOfFiles : public FolderTest {};

TEST(PushedRods, AStraightOneGoesStraightOnAndComesBack) {
  Rods rods;
  rods.add("guide", straight);
  Simulation simulation = simulationFromText(
      rods.scene("xtip=\"0.01\" speed=\"0.04\" startingPos=\"1 2 3  0 0 0.70710678118654757 0.70710678118654757\""));
  EXPECT_EQ(run(simulation, 50), 0);
  // 0.21 of it are out, straight along y, in ten beams: nine of 0.025 less what is not out yet
  EXPECT_NEAR(std::stod(valueOf(simulation, "xtip")), 0.21, 1e-12);
  EXPECT_LT((tipOf(simulation) - Vec3(1, 2.21, 3)).norm(), 1e-3 * 0.21);
  EXPECT_EQ(valueOf(simulation, "indexFirstNode"), "20");
  const System& system = *simulation.systems()[0];
  for (Index node = 0; node <= 20; ++node) EXPECT_EQ(Vec3(system.x[2 * node]), Vec3(1, 2, 3)) << node;
  simulation.setAttribute("/push", "speed", "-0.04");
  EXPECT_EQ(run(simulation, 40), 0);
  EXPECT_NEAR(std::stod(valueOf(simulation, "xtip")), 0.05, 1e-12);
  simulation.setAttribute("/push", "speed", "0");
  EXPECT_EQ(run(simulation, 30), 0);
  EXPECT_LT((tipOf(simulation) - Vec3(1, 2.05, 3)).norm(), 1e-6);
  simulation.setAttribute("/push", "xtip", "5");
  run(simulation, 30);
  EXPECT_NEAR(std::stod(valueOf(simulation, "xtip")), 0.3, 1e-12) << "it is no longer than that";
  EXPECT_LT((tipOf(simulation) - Vec3(1, 2.3, 3)).norm(), 1e-6);
}

/// By rows of times [ms] and ways: the last one before the start of a step, and from the last row on the opening.
TEST_F(RodsOfFiles, AFileMovesTheRod) {
  const auto written = [this](const std::string& rows) { return write("motion.txt", rows); };
  Rods rods;
  rods.add("guide", straight);
  const std::string path = written("0 0.002 7\n\n45 0.005 7\n85 -0.001 7\n125 0.1 7\n");
  Simulation simulation = simulationFromText(rods.scene("xtip=\"0.01\" motionFilename=\"" + path + "\""));
  const double dt = simulation.systems()[0]->node().dt();
  double tip = 0.01;
  for (int step = 0; step < 16; ++step) {
    const double t = 1000 * dt * step;
    tip = t > 125 ? 0 : tip + (t > 85 ? -0.001 : t > 45 ? 0.005 : 0.002);
    EXPECT_EQ(run(simulation, 1), 0);
    EXPECT_NEAR(std::stod(valueOf(simulation, "xtip")), tip, 1e-12) << step;
  }
  const auto told = [&](const std::string& rows) { return problemsOf(rods.scene("motionFilename=\"" + written(rows) + "\"")); };
  EXPECT_NE(told("0 1 2\n5 x 2\n").find(":2: '5 x 2' is no time and length"), std::string::npos);
  EXPECT_NE(told("0 1 2\n").find("has 1 row"), std::string::npos);
}

/// When all is at rest, what is out has its shape at rest, turned as the rod is.
TEST(PushedRods, AHookComesOutAsItsShapeAndTurnsWithTheRod) {
  Rods rods;
  rods.add("guide", hooked);
  Simulation simulation = simulationFromText(rods.scene("xtip=\"0.02\" speed=\"0.02\"", 30, 1));
  run(simulation, 5);
  simulation.setAttribute("/push", "speed", "0");
  run(simulation, 200);
  const Vec3 hook(0.07 + 0.025 * std::sin(2.), 0, 0.025 * (std::cos(2.) - 1));
  EXPECT_LT((tipOf(simulation) - hook).norm(), 1e-6);
  simulation.setAttribute("/push", "rotationInstrument", fmt::format("{:.17g}", std::numbers::pi / 2));
  run(simulation, 200);
  EXPECT_LT((tipOf(simulation) - Vec3(hook.x(), -hook.z(), 0)).norm(), 1e-6);
}

/// Of two rods of which one lies in the other each bends with the share of its stiffness.
TEST(PushedRods, OneInTheOtherHasTheMeanCurvature) {
  Rods rods;
  rods.add("catheter", "length=\"0.2\" straightLength=\"0\" spireDiameter=\"0.2\" spireHeight=\"0\" radiusExtremity=\"0.002\" "
                       "innerRadiusExtremity=\"0.001\" youngModulus=\"1e8\" youngModulusExtremity=\"1e8\" densityOfBeams=\"8\"");
  rods.add("guide", straight);
  Simulation simulation = simulationFromText(rods.scene("xtip=\"0.1 0.1\"", 40, 1));
  run(simulation, 200);
  const double of_catheter = 1e8 * (std::pow(0.002, 4) - std::pow(0.001, 4)), of_guide = 1e9 * std::pow(0.001, 4);
  const auto bent = [&](double stiffness, double length) {
    const double curvature = stiffness / 0.1;
    return Vec3(std::sin(curvature * length) / curvature, 0, (std::cos(curvature * length) - 1) / curvature);
  };
  const double share = of_catheter / (of_catheter + of_guide);
  EXPECT_LT((tipOf(simulation) - bent(share, 0.1)).norm(), 1e-6);
  // the guide goes on alone: straight, along the tangent
  simulation.setAttribute("/push", "xtip", "0.1 0.2");
  run(simulation, 300);
  const double turn = share / 0.1 * 0.1;
  EXPECT_LT((tipOf(simulation) - bent(share, 0.1) - 0.1 * Vec3(std::cos(turn), 0, -std::sin(turn))).norm(), 1e-5);
  // and back into it: the catheter goes on alone
  simulation.setAttribute("/push", "xtip", "0.1 0.05");
  run(simulation, 300);
  const double inside = share / 0.1 * 0.05;
  EXPECT_LT((tipOf(simulation) - bent(share, 0.05) - turnedBy(inside * Vec3::UnitY()) * bent(1, 0.05)).norm(), 1e-5);
}

TEST(PushedRods, ARunGoesOnFromACheckpointAndRepeatsItself) {
  for (const int count : {1, 2}) {
    Rods rods;
    if (count == 2) rods.add("catheter", straight);
    rods.add("guide", hooked);
    const std::string scene = rods.scene(count == 1 ? "xtip=\"0.02\" speed=\"0.03\""
                                                    : "xtip=\"0.06 0.02\" controlledInstrument=\"1\" speed=\"0.03\" "
                                                      "rotationInstrument=\"0 0.7\"", 40);
    Simulation one = simulationFromText(scene), other = simulationFromText(scene);
    run(one, 20);
    const System& system = *one.systems()[0];
    const Archive kept = one.checkpoint();
    const double energy = system.potentialEnergy(system.x);
    run(one, 15);
    other.restore(kept.readable());
    run(other, 15);
    EXPECT_EQ(one.stateHash(), other.stateHash()) << count;
    // what is asked for before a step is that of the beams that are there now
    one.restore(kept.readable());
    EXPECT_NEAR(system.potentialEnergy(system.x), energy, 1e-9 * energy) << count;
    const double length = count == 1 ? 0.08 : 0.06 + 0.08;
    EXPECT_NEAR(alongMass(one), 1000 * std::numbers::pi * 1e-6 * length, 1e-12) << count;
    one.reset();
    EXPECT_LT(alongMass(one), 0.9 * 1000 * std::numbers::pi * 1e-6 * length) << count;
    run(one, 35);
    EXPECT_EQ(one.stateHash(), other.stateHash()) << count;
  }
}

/// Points of the rod are on its curve as it comes out, and a load there is one on the rod.
TEST(PushedRods, PointsOfTheRodGoWithIt) {
  Rods rods;
  rods.add("guide", straight);
  const std::string on_tip = "<Node name=\"points\"><MechanicalObject name=\"points\" position=\"0.3 0 0  0.3 0.002 0  0.1 0 0\"/>"
                             "<AdaptiveBeamMapping interpolation=\"@../wire_guide\"/>{}</Node></Node>";
  const std::string scene = rods.scene("xtip=\"0.02\" speed=\"0.02\"");
  const std::string open = scene.substr(0, scene.rfind("</Node>"));
  Simulation carried = simulationFromText(
      open + fmt::format(fmt::runtime(on_tip), "<ConstantForceField indices=\"0\" forces=\"0 0 1e-3\"/>"));
  Simulation direct = simulationFromText(
      open + "<ConstantForceField indices=\"29\" forces=\"0 0 1e-3 0 0 0\"/>" + fmt::format(fmt::runtime(on_tip), ""));
  run(carried, 60), run(direct, 60);
  for (Simulation* each : {&carried, &direct}) {
    const System& system = *each->systems()[0];
    const State& points = *each->states()[1];
    const Vec3 tip = system.x[58];
    EXPECT_GT(tip.z(), 1e-4);
    EXPECT_LT((Vec3(points.x()[0]) - tip).norm(), 1e-12);
    EXPECT_LT((Vec3(points.x()[1]) - tip - orientationIn(system.x, 59) * Vec3(0, 0.002, 0)).norm(), 1e-12);
    EXPECT_LT(Vec3(points.x()[2]).norm(), 1e-12) << "not out yet: where the rod comes in";
  }
  EXPECT_LT((tipOf(carried) - tipOf(direct)).norm(), 1e-7);
}

/// The rest is a cantilever from the end of the rigid stretch on: P L^3/(3 E I) and P L^2/(2 E I). Pushed on, it goes straight on.
TEST(PushedRods, ARigidStretchIsHeldAndARodSlidesThroughIt) {
  const double load = 1e-4, bending = 1e9 * std::numbers::pi * 1e-12 / 4;
  for (const double speed : {0., 0.05}) {
    Rods rods;
    rods.add("guide", straight);
    rods.inside = fmt::format("<ConstantForceField indices=\"29\" forces=\"0 0 {} 0 0 0\"/>", speed > 0 ? 0 : load);
    Simulation simulation = simulationFromText(rods.scene(fmt::format("xtip=\"{}\" speed=\"{}\" step=\"0.01\" rigidCurvAbs=\"0.05 0.12\"",
                                                                      speed > 0 ? 0.02 : 0.2, speed)));
    run(simulation, speed > 0 ? 36 : 200);
    if (speed > 0) simulation.setAttribute("/push", "speed", "0"), run(simulation, 100);
    const System& system = *simulation.systems()[0];
    const double length = 0.08, deflection = speed > 0 ? 0 : load * length * length * length / (3 * bending);
    EXPECT_NEAR(tipOf(simulation).z(), deflection, 1e-3 * deflection + 1e-9) << speed;
    EXPECT_NEAR(tipOf(simulation).x(), 0.2, 1e-5) << speed;
    int held = 0;
    for (Index node = 0; node < 30; ++node)
      if (const Vec3 place = system.x[2 * node]; place.x() > 0.049 && place.x() < 0.121) {
        EXPECT_LT(std::abs(place.z()), 1e-12);
        ++held;
      }
    EXPECT_GE(held, 4) << "both ends and what lies between";
  }
}

TEST(PushedRods, SayWhatIsWrong) {
  const auto problems = [](const std::string& controller, int nodes = 30) {
    Rods rods;
    rods.add("guide", straight);
    return problemsOf(rods.scene(controller, nodes));
  };
  EXPECT_EQ(problems("xtip=\"0.1\""), "");
  expectContains(problems("xtip=\"0.3\"", 5), "the rods need 13 nodes");
  EXPECT_EQ(problems("xtip=\"0.01\" speed=\"0.1\"", 13), "");
  expectContains(problems("xtip=\"0.01\" speed=\"0.1\"", 12), "the rods need 13 nodes");
  expectContains(problems("startingPos=\"0 0 0\""), "startingPos has 3 numbers");
  expectContains(problems("controlledInstrument=\"2\""), "controlledInstrument is 2");
  expectContains(problems("rigidCurvAbs=\"0.1\""), "rigidCurvAbs has 1 lengths");
  expectContains(problems("rigidCurvAbs=\"0.2 0.1\""), "rigidCurvAbs has 2 lengths");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
