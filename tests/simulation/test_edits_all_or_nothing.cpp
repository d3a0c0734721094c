// SPDX-License-Identifier: LGPL-2.1-or-later
// An edit, or a restored checkpoint, that cannot be taken leaves the simulation as it was.
#include "framework/scene/archive.h"
#include "framework/scene/live_edit.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Does nothing, and throws where it is told to.
class Troubled final : public ForceField {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("trouble", trouble_)
        .recompiled()
        .help("none, init, compile, length, unsymmetric, foreign, lasting, strange");
  }
  void init() override {
    ForceField::init();
    if (trouble_ == "init") throw ComponentError("trouble in init()");
    if (trouble_ == "length") throw std::length_error("too long a list");
    if (trouble_ == "foreign") throw 5;
    spoilt_ = spoilt_ || trouble_ == "lasting";
    if (spoilt_) throw std::logic_error("spoilt");
    strange_ = strange_ || trouble_ == "strange";
    if (strange_) throw 6;
  }
  void compile() override {
    if (trouble_ == "compile") throw std::logic_error("trouble in compile()");
  }
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.linear = traits.constant_stiffness = traits.exact_tangent = true;
    traits.has_stiffness = trouble_ == "unsymmetric";
    traits.symmetric = !traits.has_stiffness;
    return traits;
  }
  double energy(ConstRows) const override { return 0; }
  void addForce(ConstRows, ConstRows, Rows) override {}
  void addStiffnessProduct(ConstRows, double, Rows) const override {}
  void addPattern(BlockPattern&) const override {}
  void addStiffness(double, BlockMatrix&) const override {}
  void addStiffnessDiagonal(double, std::vector<double>&) const override {}

 private:
  std::string trouble_ = "none";
  bool spoilt_ = false, strange_ = false;
};

/// x += dt v; cannot be compiled where more than `most` nodes are held and, if it is `touchy`, never again after that.
class Drift final : public Integrator {
 public:
  void declare(DataTable& table) override {
    table.add("most", most_).help("held nodes");
    table.add("touchy", touchy_).help("one refusal is for ever");
  }
  void compile(System& system) override {
    if (offended_) throw std::logic_error("offended");
    if (system.constraints().projectors().size() <= std::size_t(most_)) return;
    offended_ = touchy_;
    throw std::logic_error("too many are held");
  }
  StepReport step(System& system, const StepContext& context) override {
    axpy(context.dt, system.v, system.x);
    return {};
  }
  std::string describe() const override { return "drifts"; }

 private:
  int most_ = 2;
  bool touchy_ = false, offended_ = false;
};

/// out = max(in, also) + 1; knows how often it was made.
class Relay final : public Component {
 public:
  void declare(DataTable& table) override {
    table.add("in", in_).recompiled().help("a number");
    table.add("also", also_).recompiled().help("a number");
    table.add("out", out_).help("one more").output();
  }
  void init() override { out_ = std::max(in_, also_) + 1, ++made; }
  std::string roleText() const override { return "relay"; }
  int made = 0;

 private:
  int in_ = 0, also_ = 0, out_ = 0;
};

/// Remembers as many numbers as `count` says; cannot be read once it is `stubborn`.
class Counter final : public Component {
 public:
  void declare(DataTable& table) override { table.add("count", count_).recompiled().help("numbers"); }
  void init() override { numbers_.assign(std::size_t(count_), 0.0); }
  void serialize(Archive& archive) override {
    if (stubborn && archive.isReading()) throw std::logic_error("stubborn");
    archive.rows("numbers", numbers_.data(), numbers_.size());
  }
  std::string roleText() const override { return "counter"; }
  bool stubborn = false;

 private:
  int count_ = 2;
  std::vector<double> numbers_;
};

const bool registered =
    (factory().add<Troubled>("TestTroubled", "test"), factory().add<Drift>("TestDrift", "test"),
     factory().add<Relay>("TestRelay", "test"), factory().add<Counter>("TestCounter", "test"), true);

const std::string body = R"(<Node name="root" dt="0.01" gravity="0 -10 0"><EulerImplicitSolver name="euler"/>
    <CGLinearSolver iterations="50" tolerance="1e-12"/>
    <MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0.1 0"/><UniformMass name="mass" totalMass="3"/>
    <SpringForceField name="springs" springsIndices1="0 1" springsIndices2="1 2" lengths="1" stiffness="500"/>
    <FixedProjectiveConstraint name="held" indices="0"/><TestTroubled name="troubled"/></Node>)";

void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) ASSERT_FALSE(simulation.step().diverged);
}

/// What setAttribute() throws.
std::string refusal(Simulation& simulation, const std::string& path, const std::string& attribute,
                    const std::string& text) {
  try {
    simulation.setAttribute(path, attribute, text);
  } catch (const ComponentError& error) {
    return error.what();
  } catch (int number) {
    return "the number " + std::to_string(number);
  }
  return "nothing was thrown";
}

Data& attribute(Simulation& simulation, const std::string& path, const std::string& name) {
  return *findComponent(simulation.root(), path)->data().find(name);
}

TEST(EditsAllOrNothing, WhateverIsThrownTheOldValueAndPlanStayAndTheSentenceSaysSo) {
  for (const auto& [trouble, sentence] :
       {std::pair{"init", "trouble in init(); /troubled.trouble keeps its old value"},
        std::pair{"compile", "/troubled.trouble cannot change: trouble in compile(); /troubled.trouble keeps"},
        std::pair{"length", "/troubled.trouble cannot change: too long a list; /troubled.trouble keeps"},
        std::pair{"unsymmetric", "solves symmetric systems only"}, std::pair{"foreign", "the number 5"}}) {
    SCOPED_TRACE(trouble);
    Simulation simulation = simulationFromText(body), same = simulationFromText(body);
    run(simulation, 3), run(same, 3);
    expectContains(refusal(simulation, "/troubled", "trouble", trouble), sentence);
    EXPECT_EQ(attribute(simulation, "/troubled", "trouble").print(), "none");
    EXPECT_FALSE(attribute(simulation, "/troubled", "trouble").isSet());
    // what is said later reaches a reader, and not a list that has gone
    testing::internal::CaptureStderr();
    simulation.systems()[0]->integrator().warn("after the edit");
    findComponent(simulation.root(), "/troubled")->warn("after the edit too");
    const std::string told = testing::internal::GetCapturedStderr();
    expectContains(told, "after the edit\n");
    expectContains(told, "after the edit too");
    run(simulation, 3), run(same, 3);
    EXPECT_EQ(simulation.stateHash(), same.stateHash());
  }
}

TEST(EditsAllOrNothing, WhatCannotBePutBackEitherIsSaid) {
  Simulation simulation = simulationFromText(body);
  expectContains(refusal(simulation, "/troubled", "trouble", "lasting"),
                 "/troubled.trouble could neither be changed (spoilt) nor be put back (spoilt)");
  Simulation another = simulationFromText(body);
  expectContains(refusal(another, "/troubled", "trouble", "strange"),
                 "/troubled.trouble could neither be changed (an error without a sentence) nor be put back");
}

const std::string drifting = R"(<Node name="root" dt="0.01"><TestDrift name="drift" touchy="false"/>
    <MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0" velocity="0 0 0  1 2 3  4 5 6"/>
    <UniformMass totalMass="3"/><FixedProjectiveConstraint name="held" indices="0"/></Node>)";

TEST(EditsAllOrNothing, NodesKeepTheirVelocityAlsoWhereTheEditCannotBePutBack) {
  std::string touchy = drifting;
  touchy.replace(touchy.find("false"), 5, "true");
  Simulation simulation = simulationFromText(touchy);
  run(simulation, 2);
  const auto before = simulation.stateHash();
  expectContains(refusal(simulation, "/held", "indices", "0 1 2"),
                 "could neither be changed (too many are held) nor be put back (offended)");
  EXPECT_EQ(simulation.stateHash(), before);
}

TEST(EditsAllOrNothing, WhatIsRememberedInAnotherSizeIsNamedAsSuch) {
  Simulation simulation = simulationFromText(R"(<Node name="root"><TestCounter name="counter"/></Node>)");
  const std::string sentence = refusal(simulation, "/counter", "count", "3");
  expectContains(sentence, "/counter remembers the steps so far in another size than it would now have");
  expectContains(sentence, "/counter.count keeps its old value");
  EXPECT_EQ(sentence.find("checkpoint"), std::string::npos) << sentence;
  EXPECT_EQ(attribute(simulation, "/counter", "count").print(), "2");
}

TEST(EditsAllOrNothing, AListenerGivesWayToTheOneBefore) {
  Simulation simulation = simulationFromText(body);
  Component& component = *findComponent(simulation.root(), "/troubled");
  Diagnostics outer_messages, inner_messages;
  const LiveEdit::Listener outer(component, outer_messages);
  {
    const LiveEdit::Listener inner(component, inner_messages);
    component.warn("to the inner one");
  }
  component.warn("to the outer one");
  expectContains(inner_messages.text(), "to the inner one");
  expectContains(outer_messages.text(), "to the outer one");
}

TEST(EditsAllOrNothing, NodesThatWouldHaveBeenHeldKeepTheirVelocity) {
  Simulation simulation = simulationFromText(drifting);
  run(simulation, 2);
  const auto before = simulation.stateHash();
  expectContains(refusal(simulation, "/held", "indices", "0 1 2"), "too many are held");
  EXPECT_EQ(simulation.stateHash(), before);
  simulation.setAttribute("/held", "indices", "0 1");
  EXPECT_EQ(Vec3(simulation.systems()[0]->v[1]), Vec3(Vec3::Zero()));
}

/// Two ways from a to d: whoever is made before both of those that it reads has an old number.
const std::string diamond =
    R"(<Node name="root"><TestRelay name="a" in="1"/><TestRelay name="d" in="@b.out" also="@c.out"/>
    <TestRelay name="b" in="@a.out"/><TestRelay name="c" in="@long.out"/><TestRelay name="long" in="@a.out"/></Node>)";

TEST(EditsAllOrNothing, EachFollowerIsMadeOnceAndAfterAllThatItReads) {
  Simulation simulation = simulationFromText(diamond);
  EXPECT_EQ(attribute(simulation, "/d", "out").print(), "5");
  simulation.setAttribute("/a", "in", "11");
  EXPECT_EQ(attribute(simulation, "/d", "out").print(), "15");
  for (const char* path : {"/a", "/b", "/c", "/d", "/long"})
    EXPECT_EQ(dynamic_cast<Relay*>(findComponent(simulation.root(), path))->made, 2) << path;
}

TEST(EditsAllOrNothing, EditsOfWhatFollowsALinkAreRestoredInTheirOrder) {
  Simulation simulation = simulationFromText(diamond), other = simulationFromText(diamond);
  simulation.setAttribute("/a", "in", "11");
  simulation.setAttribute("/b", "in", "50");
  simulation.setAttribute("/a", "in", "21");  // b follows a again
  EXPECT_EQ(attribute(simulation, "/b", "in").print(), "22");
  other.restore(simulation.checkpoint());
  EXPECT_EQ(attribute(other, "/b", "in").print(), "22");
  EXPECT_EQ(attribute(other, "/d", "out").print(), attribute(simulation, "/d", "out").print());
  // and back to the scene as it was loaded
  other.restore(simulationFromText(diamond).checkpoint());
  EXPECT_EQ(attribute(other, "/d", "out").print(), "5");
  EXPECT_EQ(attribute(other, "/a", "in").origin(), DataOrigin::written);
  EXPECT_EQ(attribute(other, "/b", "in").origin(), DataOrigin::linked);
}

TEST(EditsAllOrNothing, ARestoreThatCannotBeGivenUpIsSaid) {
  Simulation simulation = simulationFromText(R"(<Node name="root"><TestCounter name="counter"/></Node>)");
  Archive checkpoint = simulation.checkpoint();
  dynamic_cast<Counter&>(*findComponent(simulation.root(), "/counter")).stubborn = true;
  try {
    simulation.restore(std::move(checkpoint));
    ADD_FAILURE() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    expectContains(error.what(), "could neither be taken (stubborn) nor be given up (stubborn)");
  }
}

TEST(EditsAllOrNothing, ARestoreThatFailsLeavesTheRunWhereItWas) {
  // the same components with one state more: its edits can be made, its state cannot be taken
  std::string larger = body;
  larger.insert(larger.rfind("</Node>"),
                "<Node name=\"more\"><MechanicalObject name=\"dofs\" position=\"0 0 0\"/><UniformMass/></Node>");
  Simulation source = simulationFromText(larger);
  run(source, 2);
  source.setAttribute("/springs", "damping", "3");
  source.setAttribute("/springs", "stiffness", "900 800");
  source.setAttribute("/", "dt", "0.002");
  run(source, 2);

  Simulation simulation = simulationFromText(body), same = simulationFromText(body);
  for (Simulation* each : {&simulation, &same}) {
    run(*each, 3);
    each->setAttribute("/springs", "stiffness", "700");
    each->addInput({.state = "/dofs", .nodes = {2}, .force = Vec3(1, 2, 3)});
    run(*each, 3);
  }
  const PhaseTimes times = simulation.systems()[0]->times;
  const PhaseCounts counts = simulation.systems()[0]->counts;
  EXPECT_GT(counts.forces, 0);
  EXPECT_THROW(simulation.restore(source.checkpoint()), std::runtime_error);
  EXPECT_EQ(simulation.systems()[0]->times.total, times.total);
  EXPECT_EQ(simulation.systems()[0]->times.force, times.force);
  EXPECT_EQ(simulation.systems()[0]->counts.forces, counts.forces);
  EXPECT_EQ(simulation.steps(), 6);
  EXPECT_EQ(simulation.time(), same.time());
  EXPECT_EQ(simulation.dt(), 0.01);
  EXPECT_EQ(simulation.stateHash(), same.stateHash());
  EXPECT_EQ(simulation.events().size(), 2u);
  for (const char* name : {"stiffness", "damping"}) {
    EXPECT_EQ(attribute(simulation, "/springs", name).print(), attribute(same, "/springs", name).print());
    EXPECT_EQ(attribute(simulation, "/springs", name).origin(), attribute(same, "/springs", name).origin()) << name;
  }
  run(simulation, 5), run(same, 5);
  EXPECT_EQ(simulation.stateHash(), same.stateHash());
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
