// SPDX-License-Identifier: LGPL-2.1-or-later
// What people do to a run is one list: done again it gives the same bits, also through a file.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "tests/support/scene_fixture.h"
#include "tools/session/action_file.h"
#include "tools/session/replay.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string beam(const std::string& solver) {
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -9.81 0\"><EulerImplicitSolver/>" + solver +
         "<RegularGridTopology n=\"3 3 5\" min=\"0 0 0\" max=\"0.1 0.1 0.3\"/><MechanicalObject name=\"dofs\"/>"
         "<UniformMass totalMass=\"1\"/><HexahedronFEMForceField name=\"fem\" youngModulus=\"5000\" "
         "poissonRatio=\"0.3\" method=\"polar\"/><BoxROI name=\"roi\" box=\"-1 -1 -0.001 1 1 0.001\"/>"
         "<FixedProjectiveConstraint indices=\"@roi.indices\"/></Node>";
}

constexpr const char* direct = "<SparseLDLSolver/>";
constexpr const char* iterative = "<CGLinearSolver iterations=\"40\" tolerance=\"1e-7\"/>";

Input pull(Index node, const Vec3& to, double stiffness, double damping = 0) {
  Input input{"/dofs", {node}};
  input.targets = {to};
  input.stiffness = stiffness, input.damping = damping;
  return input;
}

void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) ASSERT_FALSE(simulation.step().diverged);
}

std::vector<RunEvent> throughText(const std::vector<RunEvent>& events) {
  std::istringstream text(printActions({"beam.xml", events}));
  const RecordedActions read = parseActions(text, "beam.actions");
  EXPECT_EQ(read.scene, "beam.xml");
  return read.events;
}

/// Ten steps of the scene with these events have the state of `played`, straight and through a text.
void expectRepeats(const Simulation& played, const std::string& scene) {
  for (const std::vector<RunEvent>& events : {played.events(), throughText(played.events())}) {
    Simulation replayed = simulationFromText(scene);
    replay(replayed, events);
    run(replayed, int(played.steps()));
    EXPECT_EQ(replayed.stateHash(), played.stateHash());
    EXPECT_EQ(stroma::replayed(replayed), events.size());
    EXPECT_EQ(printActions({"", replayed.events()}), printActions({"", played.events()}));
    replayed.reset();
    run(replayed, int(played.steps()));
    EXPECT_EQ(replayed.stateHash(), played.stateHash()) << "after a reset";
  }
  Simulation untouched = simulationFromText(scene);
  run(untouched, int(played.steps()));
  EXPECT_NE(untouched.stateHash(), played.stateHash()) << "nothing was done";
}

void pullAround(Simulation& simulation) {
  const long number = simulation.addInput(pull(40, {0.1 / 3, 0.15, 0.3}, 500, 2));
  run(simulation, 2);
  simulation.changeInput(number, pull(40, {0.15, 0.15 + 1e-17, 0.3}, 500, 2));
  run(simulation, 1);
  simulation.changeInput(number, pull(40, {-0.0, 0.1, 1e-300}, 700, 0));
  run(simulation, 1);
  simulation.removeInput(number);
  run(simulation, 1);
}

void edit(Simulation& simulation) {
  simulation.setAttribute("/fem", "youngModulus", "9e3");
  run(simulation, 2);
  simulation.setAttribute("/", "gravity", "1 2 3");
  simulation.setAttribute("/fem", "poissonRatio", "0.4");
  simulation.setAttribute("/fem", "youngModulus", "7000.1");
  simulation.setAttribute("/", "dt", "0.011");
  run(simulation, 3);
}

TEST(RunEvents, InputsEditsAndBothRepeatBitForBit) {
  for (const std::string solver : {direct, iterative})
    for (const int what : {1, 2, 3}) {
      SCOPED_TRACE(solver + std::to_string(what));
      Simulation played = simulationFromText(beam(solver));
      run(played, 1);
      if (what & 1) pullAround(played);
      if (what & 2) edit(played);
      if (what == 3) pullAround(played), edit(played);
      expectRepeats(played, beam(solver));
    }
}

TEST(RunEvents, AfterAResetTheListStartsWithTheEditsThatStay) {
  for (const std::string solver : {direct, iterative}) {
    SCOPED_TRACE(solver);
    Simulation played = simulationFromText(beam(solver));
    run(played, 2);
    edit(played);
    pullAround(played);
    played.reset();
    ASSERT_EQ(played.events().size(), 4u) << "one of each attribute";
    const char* order[] = {"gravity", "poissonRatio", "youngModulus", "dt"};
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(played.events()[i].step, 0);
      EXPECT_EQ(std::get<AttributeEdit>(played.events()[i].what).attribute, order[i]);
    }
    run(played, 2);
    pullAround(played);
    expectRepeats(played, beam(solver));
    played.reset();
    EXPECT_EQ(played.events().size(), 4u);
  }
}

TEST(RunEvents, ARefusedEditIsNotInTheList) {
  Simulation played = simulationFromText(beam(direct));
  run(played, 1);
  EXPECT_THROW(played.setAttribute("/fem", "youngModulus", "-5"), ComponentError);
  EXPECT_THROW(played.setAttribute("/fem", "method", "small"), ComponentError);
  EXPECT_THROW(played.addInput(pull(45, {0, 0, 0}, 1)), ComponentError);
  EXPECT_EQ(played.events().size(), 0u);
}

TEST(RunEvents, OfSeveralTargetsBeforeOneStepTheLastIsKept) {
  Simulation played = simulationFromText(beam(direct));
  run(played, 1);
  const long one = played.addInput(pull(40, {0, 0, 0.3}, 500, 2)), other = played.addInput(pull(44, {0, 0, 0.3}, 100));
  for (int i = 1; i <= 5; ++i) {
    played.changeInput(one, pull(40, {0.01 * i, 0, 0.3}, 500, 2));
    played.changeInput(other, pull(44, {0, 0.01 * i, 0.3}, 100));
  }
  EXPECT_EQ(played.events().size(), 2u);
  run(played, 2);
  for (int i = 1; i <= 5; ++i) played.changeInput(one, pull(40, {0, 0.01 * i, 0.3}, 500, 2));
  EXPECT_EQ(played.events().size(), 3u);
  // another stiffness is another matrix: an iterative solver may know of both
  played.changeInput(one, pull(40, {0, 0.01, 0.3}, 501, 2));
  played.changeInput(one, pull(40, {0, 0.01, 0.3}, 500, 2));
  EXPECT_EQ(played.events().size(), 5u);
  // an edit may have read what acted
  played.setAttribute("/fem", "youngModulus", "6000");
  played.changeInput(one, pull(40, {0, 0.02, 0.3}, 500, 2));
  EXPECT_EQ(played.events().size(), 7u);
  run(played, 2);
  expectRepeats(played, beam(direct));
}

TEST(RunEvents, WhatFollowsACheckpointRepeatsFromIt) {
  for (const std::string solver : {direct, iterative}) {
    SCOPED_TRACE(solver);
    Simulation first = simulationFromText(beam(solver));
    run(first, 1);
    first.setAttribute("/fem", "youngModulus", "9e3");
    first.addInput(pull(40, {0.1, 0.15, 0.3}, 500, 2));
    run(first, 2);
    const Archive then = first.checkpoint();
    Simulation played = simulationFromText(beam(solver)), replayed = simulationFromText(beam(solver));
    played.restore(then);
    ASSERT_EQ(played.events().size(), 2u);
    EXPECT_EQ(played.events()[0].step, 0);
    EXPECT_EQ(played.events()[1].step, 3);
    run(played, 1);
    played.changeInput(1, pull(40, {0.1, 0.2, 0.3}, 500, 2));
    played.setAttribute("/fem", "youngModulus", "8e3");
    run(played, 3);
    replayed.restore(then);
    replay(replayed, played.events());
    EXPECT_EQ(stroma::replayed(replayed), 1u) << "the edit that the checkpoint has";
    run(replayed, 4);
    EXPECT_EQ(replayed.stateHash(), played.stateHash());
  }
}

TEST(RunEvents, AHandDuringAReplayHasANumberOfItsOwn) {
  Simulation played = simulationFromText(beam(direct));
  run(played, 3);
  pullAround(played);
  Simulation replayed = simulationFromText(beam(direct));
  replay(replayed, played.events());
  EXPECT_EQ(replayed.addInput(pull(44, {0, 0, 0.3}, 10)), 2);
  run(replayed, 8);
  EXPECT_EQ(replayed.events().size(), played.events().size() + 1);
}

std::string refusal(Simulation& simulation, std::vector<RunEvent> events) {
  return problemsIn([&] { replay(simulation, std::move(events), "some.actions"); });
}

TEST(RunEvents, WhatCannotBeReplayedIsRefusedBeforeTheRun) {
  Simulation simulation = simulationFromText(beam(direct));
  Input elsewhere = pull(0, {0, 0, 0}, 1);
  elsewhere.state = "/dof";
  const std::string problems = refusal(simulation, {{1, AttributeEdit{"/fem", "youngModulus", "1"}},
                                                    {2, AttributeEdit{"/fem", "youngModul", "1"}},
                                                    {3, AttributeEdit{"/fem", "method", "small"}},
                                                    {4, InputChange{1, pull(45, {0, 0, 0}, 1)}},
                                                    {5, InputChange{1, elsewhere}},
                                                    {4, InputChange{1, pull(44, {0, 0, 0}, 1)}}});
  expectContains(problems, "some.actions:3: error: action 2 of the replay, before step 3: ");
  expectContains(problems, "youngModulus");
  expectContains(problems, "some.actions:4: error: action 3");
  expectContains(problems, "some.actions:5: error: action 4");
  expectContains(problems, "nodes 0 to 44");
  expectContains(problems, "some.actions:6: error: action 5");
  expectContains(problems, "some.actions:7: error: action 6");
  EXPECT_EQ(problems.find("some.actions:2:"), std::string::npos) << problems;
  run(simulation, 8);
  EXPECT_EQ(simulation.events().size(), 0u) << "a replay that was refused is not begun";
}

TEST(RunEvents, ARefusedValueEndsTheRunBeforeItsStep) {
  Simulation simulation = simulationFromText(beam(direct)), same = simulationFromText(beam(direct));
  replay(simulation, {{2, AttributeEdit{"/fem", "youngModulus", "-1"}}}, "some.actions");
  run(simulation, 2), run(same, 2);
  for (int i = 0; i < 2; ++i) {
    try {
      simulation.step();
      FAIL() << "the step was made";
    } catch (const ReplayError& error) {
      expectContains(error.what(), "some.actions:2: error: action 1 of the replay, before step 3: ");
      expectContains(error.what(), "youngModulus");
    }
  }
  EXPECT_EQ(simulation.steps(), 2);
  EXPECT_EQ(simulation.stateHash(), same.stateHash());
}

// ---- files ----

TEST(RunEvents, NumbersAndTextsAreKeptToTheBit) {
  const double numbers[] = {
      0.1, -0.0, 1.0 / 3, 5e-324, 1.7976931348623157e308, 123456789012345680000., 9007199254740992., -1e22, 3};
  for (const double number : numbers) {
    Input input = pull(3, {number, 1, number}, std::abs(number), std::abs(number));
    input.force = {0, number, -number};
    input.state = "/a \"b\"\\\n\t\xc3\xa9";
    const auto read = throughText({{7, InputChange{12, input}}});
    ASSERT_EQ(read.size(), 1u);
    EXPECT_EQ(read[0].step, 7);
    const auto& [which, got] = std::get<InputChange>(read[0].what);
    EXPECT_EQ(which, 12);
    EXPECT_EQ(got->state, input.state);
    EXPECT_EQ(got->nodes, input.nodes);
    const auto same = [](double a, double b) { return a == b && std::signbit(a) == std::signbit(b); };
    for (int c = 0; c < 3; ++c) {
      EXPECT_TRUE(same(got->force[c], input.force[c])) << number;
      EXPECT_TRUE(same(got->targets[0][c], input.targets[0][c])) << number;
    }
    EXPECT_TRUE(same(got->stiffness, input.stiffness) && same(got->damping, input.damping)) << number;
  }
  const auto read = throughText({{0, AttributeEdit{"/", "gravity", " 1\r\n2\t3 \"\\"}}});
  EXPECT_EQ(std::get<AttributeEdit>(read[0].what).text, " 1\r\n2\t3 \"\\");
}

TEST(RunEvents, WhatHasNoTextIsNotWritten) {
  Input input = pull(3, {1, NAN, 1}, 1);
  EXPECT_THROW(printActions({"", {{7, InputChange{12, input}}}}), std::runtime_error);
  EXPECT_THROW(printActions({"", {{7, AttributeEdit{"/", "gravity", "\xff"}}}}), std::runtime_error);
}

constexpr const char* head = "{\"stroma\":\"actions\",\"version\":1,\"scene\":\"a.xml\"}\n";
constexpr const char* good = "{\"step\":3,\"input\":1,\"state\":\"/dofs\",\"nodes\":[1,2]}\n";

std::string problemsOfText(const std::string& text) {
  return problemsIn([&] {
    std::istringstream stream(text);
    parseActions(stream, "x.actions");
  });
}

TEST(RunEvents, DamagedLinesAreRefusedWithTheirPlace) {
  EXPECT_EQ(problemsOfText(std::string(head) + good), "");
  const std::pair<const char*, const char*> lines[] = {
      {"", "no JSON"},
      {"{\"step\":3,\"end\":1", "no JSON"},
      {"[1]", "no object"},
      {"{\"step\":1e400,\"end\":1}", "number overflow"},
      {"{\"step\":3}", "\"input\" (a force, a pull or a ball)"},
      {"{\"step\":2,\"end\":1}", "step 2 comes after step 3"},
      {"{\"step\":3,\"end\":2}", "input 2 ends and has not begun"},
      {"{\"step\":3,\"end\":1,\"end\":1}", "'end' is there twice"},
      {"{\"step\":-3,\"end\":1}", "whole numbers from 0"},
      {"{\"step\":3.5,\"end\":1}", "whole numbers from 0"},
      {"{\"step\":18446744073709551615,\"end\":1}", "whole numbers from 0"},
      {"{\"step\":\"3\",\"end\":1}", "whole numbers from 0"},
      {"{\"end\":1}", "\"step\" is missing"},
      {"{\"step\":3,\"end\":0}", "whole numbers from 1"},
      {"{\"step\":3,\"ends\":1}", "does not say what was done"},
      {"{\"step\":3,\"set\":\"/fem\",\"atribute\":\"a\",\"value\":\"1\"}", "did you mean 'attribute'?"},
      {"{\"step\":3,\"set\":\"/fem\",\"value\":\"1\"}", "\"attribute\" is missing"},
      {"{\"step\":3,\"set\":\"/fem\",\"attribute\":\"a\",\"value\":1}", "a text in quotes"},
      {"{\"step\":3,\"input\":2,\"state\":\"/dofs\",\"nodes\":[4294967296]}", "whole numbers from 0 to 2147483647"},
      {"{\"step\":3,\"input\":2,\"state\":\"/dofs\",\"nodes\":4}", "a list of nodes"},
      {"{\"step\":3,\"input\":2,\"state\":\"/dofs\",\"nodes\":[4],\"force\":[1,2]}", "three numbers"},
      {"{\"step\":3,\"input\":2,\"state\":\"/dofs\",\"nodes\":[4],\"targets\":[1,2,3]}", "a list of targets"},
      {"{\"step\":3,\"input\":2,\"state\":\"/dofs\",\"nodes\":[4],\"targets\":[[1,2,null]]}", "a list of targets"},
      {"{\"step\":3,\"input\":2,\"state\":\"/dofs\",\"nodes\":[4],\"stiffness\":\"1\"}", "a number"}};
  for (const auto& [line, expected] : lines) {
    SCOPED_TRACE(line);
    const std::string problems = problemsOfText(std::string(head) + good + line + "\n" + good);
    expectContains(problems, "x.actions:3: error: ");
    expectContains(problems, expected);
    EXPECT_EQ(problems.find("x.actions:4"), std::string::npos) << problems;
  }
  const std::string several = problemsOfText(std::string(head) + "1\n" + good + "{}\n");
  expectContains(several, "x.actions:2: ");
  expectContains(several, "x.actions:4: ");
}

TEST(RunEvents, ThousandsOfProblemsAreNotTold) {
  std::string text = head;
  std::vector<RunEvent> events;
  for (int i = 0; i < 500; ++i) text += "{}\n", events.push_back({i, AttributeEdit{"/absent", "a", "1"}});
  Simulation simulation = simulationFromText(beam(direct));
  for (const std::string& problems : {problemsOfText(text), refusal(simulation, events)}) {
    EXPECT_EQ(std::count(problems.begin(), problems.end(), '\n'), told_action_problems + 1) << problems;
    expectContains(problems, "not looked at");
  }
}

TEST(RunEvents, OtherFilesAndOtherVersionsAreRefused) {
  for (const char* text : {"", "\n", "<Node/>\n", "{}\n", "{\"stroma\":\"recording\",\"version\":1,\"scene\":\"\"}\n"})
    expectContains(problemsOfText(std::string(text) + good), "x.actions:1: error: this is no file of actions");
  expectContains(problemsOfText("{\"stroma\":\"actions\",\"version\":2,\"scene\":\"\"}\n"), "version 1");
  expectContains(problemsOfText("{\"stroma\":\"actions\",\"version\":1}\n"), "\"scene\" is missing");
  const std::string endless = head + std::string(std::size_t(17) << 20, '[');
  expectContains(problemsOfText(endless + "\n" + good), "x.actions:2: error: the line is longer than 16777216 bytes");
  const std::string brackets(std::size_t(1) << 20, '[');
  expectContains(problemsOfText(head + brackets), "x.actions:2: error: this is no object");
  for (const std::string& deep : {"{\"targets\":" + brackets, std::string("{\"targets\":[[{}]]}")})
    expectContains(problemsOfText(head + deep), "x.actions:2: error: the line has lists within lists of lists");
  expectContains(problemsOfText(head + std::string("{\"step\":") + std::string(std::size_t(1) << 20, '1')), "no JSON");
  EXPECT_THROW(readActions("absent.actions"), std::runtime_error);
  EXPECT_THROW(readActions("."), std::runtime_error);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
