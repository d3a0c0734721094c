// SPDX-License-Identifier: LGPL-2.1-or-later
// ReadState: what was written comes back bit by bit, at the times it belongs to.
#include <cmath>
#include <fstream>
#include <iterator>

#include "framework/simulation/state_file.h"
#include "tests/support/folder_fixture.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace {

namespace fs = std::filesystem;

class ReadState : public FolderTest {
 protected:
  /// Three nodes, two springs, a step of 0.01 s.
  static std::string springs(const std::string& attributes, const std::string& state, const std::string& more) {
    return "<Node name='root' dt='0.01' gravity='0 -10 0' " + attributes +
           "><EulerExplicitSolver/><MechanicalObject name='dofs' " + state +
           "/><UniformMass totalMass='0.3'/>"
           "<SpringForceField springsIndices1='0 1' springsIndices2='1 2' lengths='1 0.8' stiffness='200' "
           "damping='1'/>" +
           more + "</Node>";
  }
  static constexpr const char* start_ = "position='0 0 0  1 0 0  2 0.5 0' velocity='0 0 1  0 3 0  -1 0 0'";
  static constexpr const char* elsewhere_ = "position='0 5 0  1 5 0  2 5 0'";

  static std::string reads(const std::string& attributes) { return "<ReadState " + attributes + "/>"; }

  /// Two nodes, free of forces, that read `attributes`.
  static Simulation drifting(const std::string& attributes, const std::string& state = "position='0 0 0  1 0 0'") {
    return simulationFromText(
        "<Node name='root' dt='0.1' gravity='0 0 0'><EulerExplicitSolver/><MechanicalObject "
        "name='dofs' " +
        state + "/><UniformMass totalMass='2'/>" + reads(attributes) + "</Node>");
  }
};

std::vector<double> numbers(const Simulation& simulation) {
  std::vector<double> out;
  for (const State* state : simulation.states())
    for (Index i = 0; i < state->size(); ++i)
      for (int c = 0; c < 3; ++c) out.push_back(state->x()[i][c]), out.push_back(state->v()[i][c]);
  return out;
}

double height(const Simulation& simulation) { return simulation.states()[0]->x()[0].y(); }
double speed(const Simulation& simulation) { return simulation.states()[0]->v()[0].y(); }

/// Heights of node 0 at the start and after each of some steps.
std::vector<double> heights(Simulation simulation, int steps) {
  std::vector<double> out{height(simulation)};
  for (int i = 0; i < steps; ++i) {
    EXPECT_FALSE(simulation.step().diverged);
    out.push_back(height(simulation));
  }
  return out;
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_F(ReadState, AReplayHasTheBitsOfTheRunWithOtherForcesToo) {
  for (const std::string name : {"run.state", "run.state.gz"}) {
    const std::string path = file(name);
    std::vector<std::vector<double>> recorded;
    {
      Simulation run = simulationFromText(springs("", start_, "<WriteState writeV='1' filename='" + path + "'/>"));
      run.begin();
      recorded.push_back(numbers(run));
      for (int i = 0; i < 30; ++i) run.step(), recorded.push_back(numbers(run));
      run.end();
    }
    const std::string other_force = "<ConstantForceField indices='0' forces='7 7 7'/>";
    Simulation replay = simulationFromText(springs("", elsewhere_, reads("filename='" + path + "'") + other_force));
    EXPECT_EQ(numbers(replay), recorded[0]);
    for (std::size_t i = 1; i < recorded.size(); ++i) {
      ASSERT_FALSE(replay.step().diverged);
      EXPECT_EQ(numbers(replay), recorded[i]) << "step " << i;
    }
    replay.step();
    EXPECT_NE(numbers(replay), recorded.back()) << "after the last instant the forces have it";
    replay.reset();
    EXPECT_EQ(numbers(replay), recorded[0]);
    replay.step();
    EXPECT_EQ(numbers(replay), recorded[1]);
  }
}

TEST_F(ReadState, ARunResumesFromItsLastInstant) {
  const std::string path = file("last.state");
  Simulation whole =
      simulationFromText(springs("", start_, "<WriteState writeV='1' time='0.2' filename='" + path + "'/>"));
  for (int i = 0; i < 40; ++i) whole.step();
  whole.end();
  Simulation resumed = simulationFromText(springs("time='0.2'", elsewhere_, reads("filename='" + path + "'")));
  for (int i = 0; i < 20; ++i) resumed.step();
  EXPECT_EQ(numbers(resumed), numbers(whole));
  EXPECT_NEAR(resumed.time(), 0.4, 1e-15);
}

TEST_F(ReadState, BetweenInstantsTheStateMovesFreely) {
  const std::string path = write("f.state", "T= 0.2\n X= 0 4 0 1 4 0\n V= 0 1 0 0 1 0\nT= 0.4\n X= 0 8 0 1 8 0\n");
  Simulation run = drifting("filename='" + path + "'", "position='0 0 0  1 0 0' velocity='0 2 0  0 2 0'");
  EXPECT_EQ(height(run), 0);
  run.step();
  EXPECT_NEAR(height(run), 0.2, 1e-14) << "before the first instant";
  run.step();
  EXPECT_EQ(height(run), 4);
  EXPECT_EQ(speed(run), 1);
  run.step();
  EXPECT_NEAR(height(run), 4.1, 1e-14);
  run.step();
  EXPECT_EQ(height(run), 8);
  EXPECT_NEAR(speed(run), (8 - 4.1) / 0.1, 1e-12) << "without V the velocity is that of the step";
}

TEST_F(ReadState, ShiftIntervalAndLoopAreAsDocumented) {
  const std::string path = write("f.state",
                                 "T= 0\n X= 0 0 0 1 0 0\n V= 0 0 0 0 0 0\n"
                                 "T= 0.1\n X= 0 1 0 1 1 0\n V= 0 0 0 0 0 0\n"
                                 "T= 0.2\n X= 0 2 0 1 2 0\n V= 0 0 0 0 0 0\n"
                                 "T= 0.3\n X= 0 3 0 1 3 0\n V= 0 0 0 0 0 0\n");
  const std::string name = "filename='" + path + "' ";
  using List = std::vector<double>;
  EXPECT_EQ(heights(drifting(name), 5), (List{0, 1, 2, 3, 3, 3}));
  EXPECT_EQ(heights(drifting(name + "shift='0.1'"), 4), (List{1, 2, 3, 3, 3}));
  EXPECT_EQ(heights(drifting(name + "shift='-0.2'", "position='0 9 0  1 0 0'"), 5), (List{9, 9, 0, 1, 2, 3}));
  EXPECT_EQ(heights(drifting(name + "interval='0.2'"), 4), (List{0, 0, 2, 2, 3}));
  EXPECT_EQ(heights(drifting(name + "loop='true'"), 8), (List{0, 1, 2, 0, 1, 2, 0, 1, 2}));
  EXPECT_EQ(heights(drifting(name + "endTime='0.15'"), 4), (List{0, 1, 2, 2, 2}));
}

TEST_F(ReadState, AStepOverSeveralInstantsTakesTheLast) {
  const std::string path =
      write("f.state", "T= 0.02\n X= 0 1 0 1 1 0\nT= 0.07\n X= 0 2 0 1 2 0\nT= 0.11\n X= 0 3 0 1 3 0\n");
  Simulation run = drifting("filename='" + path + "'");
  run.step();
  EXPECT_EQ(height(run), 2);
  run.step();
  EXPECT_EQ(height(run), 3);
}

TEST_F(ReadState, PositionsAndVelocitiesAreScaledTurnedAndMoved) {
  const std::string path = write("f.state", "T= 0\n X= 1 2 3 1 0 0\n V= 1 0 0 0 1 0\n");
  const Simulation run = drifting("filename='" + path + "' scalePos='2' rotation='0 0 90' translation='10 20 30'");
  const State& state = *run.states()[0];
  EXPECT_NEAR((state.x()[0] - Vec3(10 - 4, 20 + 2, 30 + 6)).norm(), 0, 1e-13);
  EXPECT_NEAR((state.v()[0] - Vec3(0, 2, 0)).norm(), 0, 1e-14);
  EXPECT_NEAR((state.v()[1] - Vec3(-2, 0, 0)).norm(), 0, 1e-14);
}

TEST_F(ReadState, WhatIsAttachedIsCarriedAlong) {
  // a node on a stiff spring in a bath of its own: pulled by the replayed one at constant speed it ends at that speed
  std::string text;
  for (int i = 0; i <= 100; ++i) {
    const std::string y = std::to_string(0.01 * i);
    text += "T= " + std::to_string(0.01 * i) + "\n X= 0 " + y + " 0\n";
  }
  const std::string path = write("pull.state", text);
  Simulation run = simulationFromText(
      "<Node name='root' dt='0.01' gravity='0 0 0'><EulerImplicitSolver/><CGLinearSolver iterations='50' "
      "tolerance='1e-12'/><Node name='led'><MechanicalObject name='dofs' position='0 0 0'/><UniformMass "
      "totalMass='1'/>" +
      reads("filename='" + path + "'") +
      "</Node><Node name='drawn'><MechanicalObject name='dofs' "
      "position='0 0 0'/><UniformMass totalMass='1'/><SpringForceField object1='@/led/dofs' object2='@/drawn/dofs' "
      "springsIndices1='0' springsIndices2='0' lengths='0' stiffness='1000' damping='30'/></Node></Node>");
  for (int i = 0; i < 100; ++i) ASSERT_FALSE(run.step().diverged);
  EXPECT_NEAR(run.states()[0]->x()[0].y(), 1, 1e-15);
  EXPECT_NEAR(run.states()[1]->v()[0].y(), 1, 1e-3);
}

/// What a killed run leaves.
TEST_F(ReadState, ARecordingThatIsNotFinishedIsReadWithAWarning) {
  for (const char* name : {"killed.state", "killed.state.gz"}) {
    StateWriter writer(file(name));
    for (int i = 0; i < 3; ++i) {
      writer.time(0.1 * i);
      writer.rows("X", std::vector<Vec3>{{0, 1. * i, 0}, {1, 1. * i, 0}});
      writer.finish();
    }
    std::ifstream stream(file(name), std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(stream), {}};
    for (const std::size_t cut : {0, 1, 20}) {
      write(name, whole.substr(0, whole.size() - cut));
      const Simulation run = drifting("filename='" + file(name) + "'");
      const std::string said = run.scene().diagnostics.text();
      const char* last = cut == 0 ? "its last whole instant is T = 0.2 s" : "its last whole instant is T = 0.1 s";
      EXPECT_TRUE(has(said, "test.xml:") && has(said, "warning: ") && has(said, last)) << said;
    }
  }
}

TEST_F(ReadState, MistakesAreNamed) {
  const auto problem = [&](const std::string& attributes) { return problemsIn([&] { drifting(attributes); }); };
  const auto of_file = [&](const std::string& text) { return problem("filename='" + write("bad.state", text) + "'"); };
  EXPECT_TRUE(has(problem(""), "filename")) << problem("");
  EXPECT_TRUE(has(problem("filename='nowhere.state'"), "nowhere.state"));
  EXPECT_TRUE(has(of_file(""), "holds no instant")) << of_file("");
  EXPECT_TRUE(has(of_file("T= 0\n X= 0 0 0\n"), "1 positions and 0 velocities")) << of_file("T= 0\n X= 0 0 0\n");
  EXPECT_TRUE(has(of_file("T= 0\n V= 0 0 0 0 0 0\n"), "0 positions"));
  EXPECT_TRUE(has(of_file("T= 0\n X= 0 0 0 0 nan 0\n"), "not finite"));
  EXPECT_TRUE(has(of_file("T= 1\n X= 0 0 0 0 0 0\nT= 0\n X= 0 0 0 0 0 0\n"), "ascending times"));
  EXPECT_TRUE(has(of_file("T= 1\n X= 0 0 0 0 0 "), "cut short"));
  const std::string one = write("one.state", "T= 0\n X= 0 0 0 0 0 0\n");
  EXPECT_TRUE(has(problem("loop='1' filename='" + one + "'"), "cannot be repeated"));
  EXPECT_TRUE(has(problem("interval='-1' filename='" + one + "'"), "interval"));
  const std::string unmoved = problemsOf("<Node name='root'><MechanicalObject name='dofs' position='0 0 0 1 0 0'/>" +
                                         reads("filename='" + one + "'") + "</Node>");
  EXPECT_TRUE(has(unmoved, "no integrator moves it")) << unmoved;
}

}  // namespace
}  // namespace stroma::test
