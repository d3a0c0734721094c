// SPDX-License-Identifier: LGPL-2.1-or-later
// A session: loads, runs to a limit, is stopped from another thread, and is watched by observers that come and go.
#include "tools/session/session.h"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "tests/support/folder_fixture.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string stone =
    "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -10 0\"><EulerExplicitSolver name=\"euler\"/><MechanicalObject "
    "name=\"dofs\" position=\"0 0 0\"/><UniformMass name=\"mass\" totalMass=\"2\"/></Node>";

class Counter final : public Observer {
 public:
  void declare(DataTable&) override {}
  void begin(const Simulation& simulation) override { begun_at = simulation.steps(); }
  void afterStep(const Simulation&, const StepContext& context) override { last = context.index, ++count; }
  void end(const Simulation&) override { ended = true; }
  std::string describe() const override { return "counts"; }
  long begun_at = -1, last = -1;
  int count = 0;
  bool ended = false;
};

TEST(Session, RunsToEachKindOfLimit) {
  Session session;
  EXPECT_FALSE(session.isLoaded());
  EXPECT_THROW(session.simulation(), std::logic_error);
  Simulation& simulation = session.loadText(stone, "stone.xml");
  EXPECT_EQ(session.run({.steps = 7}).end, RunEnd::done);
  EXPECT_EQ(simulation.steps(), 7);
  EXPECT_EQ(session.stepsUntil(0.2), 13);
  session.run({.until = 0.2});
  EXPECT_EQ(simulation.steps(), 20);
  EXPECT_NEAR(simulation.time(), 0.2, 1e-15);
  EXPECT_EQ(session.run({.until = 0.1}).statistics.step_ms.size(), 0u) << "the past is no limit ahead";
  EXPECT_THROW(session.stepsUntil(0.1), std::invalid_argument);
  EXPECT_THROW(session.stepsUntil(std::nan("")), std::invalid_argument);
  RunLimits limits;
  limits.reached = [](const Simulation& s) { return s.states()[0]->x()[0].y() < -1; };
  long told = 0;
  limits.after_step = [&told](const StepReport&, double) { ++told; };
  const RunReport report = session.run(limits);
  EXPECT_EQ(report.end, RunEnd::done);
  EXPECT_LT(simulation.states()[0]->x()[0].y(), -1);
  EXPECT_EQ(told, long(report.statistics.step_ms.size()));
  EXPECT_EQ(told, simulation.steps() - 20);
}

TEST(Session, IsStoppedByAnotherThreadAfterAWholeStep) {
  Session session;
  Simulation& simulation = session.loadText(stone, "stone.xml");
  session.requestStop();
  EXPECT_EQ(session.run({.steps = 5}).end, RunEnd::stopped);
  EXPECT_EQ(simulation.steps(), 0) << "a stop before the run is a stop at once";
  std::atomic<long> done = 0;
  RunLimits limits;
  limits.after_step = [&](const StepReport&, double) { done = simulation.steps(); };
  std::thread stopper([&] {
    while (done < 100) std::this_thread::yield();
    session.requestStop();
  });
  const RunReport report = session.run(limits);
  stopper.join();
  EXPECT_EQ(report.end, RunEnd::stopped);
  EXPECT_EQ(simulation.steps(), done);
  EXPECT_EQ(session.run({.steps = 3}).end, RunEnd::done);
  EXPECT_EQ(simulation.steps(), done + 3) << "a stop is asked for once";
}

TEST(Session, ObserversComeAndGo) {
  Session session;
  Simulation& simulation = session.loadText(stone, "stone.xml");
  Counter early, late;
  simulation.addObserver(early);
  session.run({.steps = 3});
  simulation.addObserver(late);
  simulation.addObserver(late);
  session.run({.steps = 3});
  simulation.removeObserver(early);
  EXPECT_TRUE(early.ended);
  session.run({.steps = 3});
  EXPECT_EQ(early.begun_at, 0);
  EXPECT_EQ(early.count, 6);
  EXPECT_EQ(late.begun_at, 3);
  EXPECT_EQ(late.count, 6);
  EXPECT_EQ(late.last, 9);
  EXPECT_FALSE(late.ended);
  session.finish();
  EXPECT_TRUE(late.ended);
  simulation.removeObserver(late);
}

TEST(Session, ResetAndLoadStartAnew) {
  Session session;
  Simulation& first = session.loadText(stone, "stone.xml");
  const std::uint64_t start = first.stateHash();
  session.run({.steps = 4});
  const std::uint64_t end = first.stateHash();
  first.reset();
  EXPECT_EQ(first.stateHash(), start);
  session.run({.steps = 4});
  EXPECT_EQ(first.stateHash(), end);
  Simulation& second =
      session.loadText(stone, "stone.xml", {Override::parse("/mass.totalMass=3"), Override::parse("dt=0.1")});
  EXPECT_EQ(second.steps(), 0);
  EXPECT_EQ(second.dt(), 0.1);
  EXPECT_THROW(session.loadText("<Node><Nonsense/></Node>", "bad.xml"), SceneError);
  EXPECT_FALSE(session.isLoaded());
}

class SessionFiles : public FolderTest {};

TEST_F(SessionFiles, ACheckpointIsAFileAndTellsWhoWroteIt) {
  const std::string path = file("stone.checkpoint");
  Session session;
  Simulation& simulation = session.loadText(stone, "stone.xml");
  session.run({.steps = 4});
  session.writeCheckpoint(path);
  session.run({.steps = 4});
  const std::uint64_t end = simulation.stateHash();
  EXPECT_TRUE(session.restore(path).empty());
  EXPECT_EQ(simulation.steps(), 4);
  session.run({.steps = 4});
  EXPECT_EQ(simulation.stateHash(), end);
  session.loadText(stone, "other.xml");
  ASSERT_EQ(session.restore(path).size(), 1u);
  Checkpoint foreign = Checkpoint::read(path);
  foreign.build = "another";
  foreign.write(path);
  EXPECT_EQ(session.restore(path).size(), 2u);
  EXPECT_THROW(session.restore(path + ".absent"), std::runtime_error);
}

/// What a run rests on is not forgotten when it goes on in another program.
TEST_F(SessionFiles, StepsThatDidNotConvergeBeforeACheckpointStayKnown) {
  const std::string spring =
      "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -10 0\"><EulerImplicitSolver/><CGLinearSolver name=\"cg\" "
      "iterations=\"1\" tolerance=\"1e-12\"/><MechanicalObject position=\"0 0 0 1 0 0 2 1 0 3 0 2\"/><UniformMass "
      "totalMass=\"2\"/><SpringForceField springsIndices1=\"0 1 2\" springsIndices2=\"1 2 3\" lengths=\"1 1 1\" "
      "stiffness=\"2000\"/><FixedProjectiveConstraint indices=\"0\"/></Node>";
  const std::string path = file("spring.checkpoint");
  Session first, second;
  first.loadText(spring, "spring.xml");
  const RunReport before = first.run({.steps = 4});
  ASSERT_EQ(before.statistics.unconverged.linear, 4);
  first.writeCheckpoint(path);
  second.loadText(spring, "spring.xml");
  second.restore(path);
  second.simulation().setAttribute("/cg", "iterations", "100");
  const RunReport after = second.run({.steps = 3});
  EXPECT_EQ(after.statistics.step_ms.size(), 3u);
  EXPECT_EQ(after.statistics.unconverged.linear, 4);
  EXPECT_EQ(after.statistics.unconverged.steps, 7);
  EXPECT_EQ(after.statistics.unconverged.worst_residual, before.statistics.unconverged.worst_residual);
  ASSERT_EQ(after.statistics.unconverged.warnings().size(), 1u);
  EXPECT_NE(after.statistics.unconverged.warnings()[0].find("4 of 7 steps"), std::string::npos);
  second.loadText(spring, "spring.xml");
  EXPECT_EQ(second.run({.steps = 0}).statistics.unconverged.steps, 0) << "another run";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
