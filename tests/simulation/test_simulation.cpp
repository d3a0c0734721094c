// SPDX-License-Identifier: LGPL-2.1-or-later
// The loop: what it refuses, what it does in a step, what it undoes.
#include "framework/simulation/simulation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/scene_fixture.h"
#include "tools/plan/plan.h"

namespace stroma {
namespace STROMA_TEST_FILE {

class TestState final : public State {
 public:
  void declare(DataTable& table) override { table.add("position", position).help("initial positions"); }
  void init() override {
    rest_position = position;
    velocity.assign(position.size(), Vec3(0.1, 0.2, 0.3));
  }
};

class TestMass final : public Mass {
 public:
  void init() override {
    Mass::init();
    lumped_.assign(state().size(), 1.0);
  }
  const std::vector<double>& lumped() const override { return lumped_; }
  bool isDiagonal() const override { return true; }

 private:
  std::vector<double> lumped_;
};

/// x += dt v, v *= 0.9; on request gives up, or leaves a number that is not finite.
class TestIntegrator final : public Integrator {
 public:
  void declare(DataTable& table) override {
    table.add("giveUpAt", give_up_at_).help("step at which it reports a divergence");
    table.add("poisonAt", poison_at_).help("step at which it leaves a NaN");
  }
  void compile(System&) override {}
  StepReport step(System& system, const StepContext& context) override {
    axpy(context.dt, system.v, system.x);
    scale(0.9, system.v);
    StepReport report;
    report.linear_iterations = 3;
    report.linear_residual = 0.25;
    if (context.index == poison_at_) system.x[1].y() = std::nan("");
    if (context.index == give_up_at_) {
      report.diverged = true;
      report.reason = "the solve broke down";
    }
    return report;
  }
  std::string describe() const override { return "moves along"; }

 private:
  int give_up_at_ = 0, poison_at_ = 0;
};

/// Writes what it sees into a string.
class TestObserver final : public Observer {
 public:
  void declare(DataTable&) override {}
  void begin(const Simulation& simulation) override { seen += "b" + std::to_string(simulation.steps()); }
  void afterStep(const Simulation& simulation, const StepContext& context) override {
    seen += " " + std::to_string(context.index);
    EXPECT_EQ(simulation.steps(), context.index);
    EXPECT_EQ(simulation.time(), context.t_end);
  }
  void end(const Simulation&) override { seen += " e"; }
  std::string describe() const override { return "remembers"; }
  std::string seen;
};

class SimulationTest : public testing::Test {
 protected:
  SimulationTest() {
    factory_.add<TestState>("TestState", "a state");
    factory_.add<TestMass>("TestMass", "unit masses");
    factory_.add<TestIntegrator>("TestIntegrator", "an integrator");
    factory_.add<TestObserver>("TestObserver", "an observer");
  }
  Scene scene(const std::string& xml) {
    Diagnostics diagnostics;
    SceneDescription description;
    description.root = readXml(xml, "test.xml", {}, diagnostics);
    description.file = "test.xml";
    return instantiate(std::move(description), factory_, modules_, std::move(diagnostics));
  }
  std::string errorOf(const std::string& xml) {
    return test::problemsIn([&] { Simulation simulation(scene(xml)); });
  }

  Factory factory_;
  Modules modules_{factory_};
};

const char* const two_bodies = R"(<Node name="root" dt="0.1">
  <Node name="a"><TestIntegrator/><TestState name="dofs" position="0 0 0  1 0 0"/><TestMass/></Node>
  <Node name="b"><TestIntegrator name="mover"/><TestState name="dofs" position="0 0 0  1 0 0"/><TestMass/></Node>
  <TestObserver name="watch"/>
</Node>)";

std::string with(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

const TestObserver& watcher(const Simulation& simulation) {
  return dynamic_cast<const TestObserver&>(*simulation.observers().at(0));
}

TEST_F(SimulationTest, RefusesAnIntegratorBelowAnother) {
  const std::string error = errorOf(R"(<Node name="root"><TestIntegrator name="outer"/>
    <Node name="child"><TestIntegrator name="inner"/><TestState position="0 0 0"/></Node></Node>)");
  EXPECT_TRUE(has(error, "/child/inner")) << error;
  EXPECT_TRUE(has(error, "below the integrator /outer")) << error;
  EXPECT_TRUE(has(error, "test.xml:2")) << error;
}

TEST_F(SimulationTest, RefusesABodyThatNothingMoves) {
  const std::string error = errorOf(R"(<Node name="root"><Node name="a"><TestIntegrator/>
    <TestState position="0 0 0"/><TestMass/></Node>
    <Node name="b"><TestState name="dofs" position="0 0 0"/><TestMass name="mass"/></Node></Node>)");
  EXPECT_TRUE(has(error, "/b/mass acts on this state, but no integrator moves it")) << error;
}

TEST_F(SimulationTest, NotesAMarkerThatNothingMoves) {
  const Simulation simulation(scene(R"(<Node name="root"><Node name="a"><TestIntegrator/>
    <TestState position="0 0 0"/><TestMass/></Node>
    <Node name="b"><TestState name="marker" position="0 0 0"/></Node></Node>)"));
  EXPECT_TRUE(has(simulation.scene().diagnostics.text(), "/b/marker")) << simulation.scene().diagnostics.text();
  EXPECT_EQ(simulation.states().size(), 1u);
}

TEST_F(SimulationTest, WarnsWhenNothingMovesAtAll) {
  Simulation simulation(scene(R"(<Node name="root" dt="0.5"><TestState position="0 0 0"/></Node>)"));
  EXPECT_TRUE(has(simulation.scene().diagnostics.text(), "no integrator: nothing moves"));
  EXPECT_FALSE(simulation.step().diverged);
  EXPECT_EQ(simulation.time(), 0.5);
}

TEST_F(SimulationTest, StepsAllSystemsAndMergesTheirReports) {
  Simulation simulation(scene(two_bodies));
  const StepReport report = simulation.step();
  EXPECT_FALSE(report.diverged);
  EXPECT_TRUE(report.reason.empty());
  EXPECT_EQ(report.linear_iterations, 6);
  EXPECT_EQ(report.linear_residual, 0.25);
  for (const State* state : simulation.states()) {
    EXPECT_NEAR(state->x()[1].x(), 1 + 0.1 * 0.1, 1e-15);
    EXPECT_NEAR(state->v()[1].z(), 0.9 * 0.3, 1e-15);
  }
}

TEST_F(SimulationTest, TimeDoesNotDrift) {
  Simulation simulation(scene(two_bodies));
  for (int i = 0; i < 1000; ++i) simulation.step();
  EXPECT_EQ(simulation.time(), 1000 * 0.1);
  EXPECT_EQ(simulation.steps(), 1000);
}

TEST_F(SimulationTest, ObserversSeeTheStartEveryStepAndTheEnd) {
  Simulation simulation(scene(two_bodies));
  const TestObserver& observer = watcher(simulation);
  simulation.begin();
  simulation.begin();
  simulation.step();
  simulation.step();
  simulation.end();
  simulation.end();
  EXPECT_EQ(observer.seen, "b0 1 2 e");
}

/// The next step diverges, says when and where, and leaves the states as they were.
void expectUndone(Simulation& simulation, const std::string& when, const std::string& where) {
  const std::uint64_t good = simulation.stateHash();
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.diverged);
  EXPECT_TRUE(has(report.reason, when)) << report.reason;
  EXPECT_TRUE(has(report.reason, where)) << report.reason;
  EXPECT_EQ(simulation.stateHash(), good);
}

TEST_F(SimulationTest, ADivergedStepIsUndoneInEverySystem) {
  Simulation simulation(scene(with(two_bodies, "name=\"mover\"", "name=\"mover\" giveUpAt=\"3\"")));
  simulation.step();
  simulation.step();
  expectUndone(simulation, "step 3 ", "/b/mover: the solve broke down");
  EXPECT_EQ(simulation.steps(), 2);
  EXPECT_EQ(simulation.time(), 2 * 0.1);
  simulation.end();
  EXPECT_EQ(watcher(simulation).seen, "b0 1 2 e");
}

TEST_F(SimulationTest, ANumberThatIsNotFiniteIsADivergenceThatNamesItsNode) {
  Simulation simulation(scene(with(two_bodies, "name=\"mover\"", "name=\"mover\" poisonAt=\"2\"")));
  simulation.step();
  expectUndone(simulation, "step 2 ", "node 1 of /b/dofs");
}

TEST_F(SimulationTest, ResetRepeatsTheRunBitForBit) {
  Simulation simulation(scene(two_bodies));
  const std::uint64_t start = simulation.stateHash();
  for (int i = 0; i < 5; ++i) simulation.step();
  const std::uint64_t after = simulation.stateHash();
  EXPECT_NE(after, start);
  simulation.reset();
  EXPECT_EQ(simulation.stateHash(), start);
  EXPECT_EQ(simulation.time(), 0);
  EXPECT_EQ(simulation.steps(), 0);
  for (int i = 0; i < 5; ++i) simulation.step();
  EXPECT_EQ(simulation.stateHash(), after);
  EXPECT_EQ(watcher(simulation).seen, "b0 1 2 3 4 5 eb0 1 2 3 4 5");
}

TEST_F(SimulationTest, TheHashSeesEveryBit) {
  Simulation simulation(scene(two_bodies));
  const std::uint64_t before = simulation.stateHash();
  System& system = *simulation.systems()[1];
  const double old = system.x[0].z();
  system.x[0].z() = -0.0;
  EXPECT_NE(simulation.stateHash(), before);
  system.x[0].z() = old;
  EXPECT_EQ(simulation.stateHash(), before);
  system.v[1].y() = std::nextafter(double(system.v[1].y()), 1.0);
  EXPECT_NE(simulation.stateHash(), before);
}

TEST_F(SimulationTest, ExplainNamesWhatRuns) {
  const Simulation simulation(scene(two_bodies));
  std::string text;
  for (const std::string& line : planOf(simulation).lines()) text += line + "\n";
  for (const char* part : {"/a/dofs", "/b/mover", "moves along", "/watch", "remembers"})
    EXPECT_TRUE(has(text, part)) << text;
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma
