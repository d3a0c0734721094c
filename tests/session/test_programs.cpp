// SPDX-License-Identifier: LGPL-2.1-or-later
// What a program does with a scene besides reading XML and stepping: descriptions, previews, shared simulations, states that
// it writes.
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <stdexcept>
#include <vector>

#include "tools/session/action_file.h"
#include "tools/session/preview.h"
#include "tools/session/session.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string two_stones =
    "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -10 0\"><EulerImplicitSolver name=\"euler\"/><CGLinearSolver "
    "iterations=\"20\" tolerance=\"1e-12\"/><MechanicalObject name=\"dofs\" position=\"0 0 0  1 0 0\"/><UniformMass "
    "name=\"mass\" totalMass=\"2\"/><FixedProjectiveConstraint indices=\"0\"/></Node>";

bool isAt(ConstRows rows, Index row, const Vec3& place) { return Vec3(rows[row]) == place; }

TEST(StatesFromOutside, HeldNodesStayAndOthersGetTheirBits) {
  Session session;
  Simulation& simulation = session.loadText(two_stones, "stones.xml");
  const State& state = *simulation.states()[0];
  Vector x(2), v(2);
  x[0] = Vec3(5, 5, 5), x[1] = Vec3(0.1, 0.2, 0.3);
  v[0] = v[1] = Vec3(1, 2, 3);
  EXPECT_EQ(simulation.setState(state, x, ConstRows()), 1);
  EXPECT_TRUE(isAt(state.x(), 0, Vec3(0, 0, 0)));
  EXPECT_TRUE(isAt(state.x(), 1, Vec3(0.1, 0.2, 0.3)));
  EXPECT_TRUE(isAt(state.v(), 1, Vec3(0, 0, 0)));
  EXPECT_EQ(simulation.setState(state, ConstRows(), v), 1);
  EXPECT_TRUE(isAt(state.v(), 0, Vec3(0, 0, 0)));
  EXPECT_TRUE(isAt(state.v(), 1, Vec3(1, 2, 3)));
  EXPECT_TRUE(simulation.watch().isWorkedOn());
}

TEST(StatesFromOutside, WhatCannotBeIsRefusedAndNothingChanges) {
  Session session;
  Simulation& simulation = session.loadText(two_stones, "stones.xml");
  const State& state = *simulation.states()[0];
  const std::uint64_t before = simulation.stateHash();
  Vector few(1), bad(2);
  bad[1] = Vec3(0, std::numeric_limits<double>::quiet_NaN(), 0);
  EXPECT_THROW(simulation.setState(state, few, ConstRows()), ComponentError);
  EXPECT_THROW(simulation.setState(state, ConstRows(), bad), ComponentError);
  EXPECT_EQ(simulation.stateHash(), before);
}

/// Sets a state where nothing may be set.
class Meddler final : public Observer {
 public:
  void declare(DataTable&) override {}
  void afterStep(const Simulation& simulation, const StepContext&) override {
    Vector x(2);
    refused = simulation.isStepping();
    try {
      const_cast<Simulation&>(simulation).setState(*simulation.states()[0], x, ConstRows());
    } catch (const ComponentError&) {
      ++count;
    }
  }
  std::string describe() const override { return "meddles"; }
  bool refused = false;
  int count = 0;
};

TEST(StatesFromOutside, NotInTheMiddleOfAStep) {
  Session session;
  Simulation& simulation = session.loadText(two_stones, "stones.xml");
  Meddler meddler;
  simulation.addObserver(meddler);
  session.run({.steps = 2});
  simulation.removeObserver(meddler);
  EXPECT_TRUE(meddler.refused);
  EXPECT_EQ(meddler.count, 2);
  EXPECT_FALSE(simulation.isStepping());
}

TEST(StatesFromOutside, NoRecordRepeatsThem) {
  Session session;
  Simulation& simulation = session.loadText(two_stones, "stones.xml");
  Vector x(2);
  x[1] = Vec3(1, 1, 1);
  simulation.setState(*simulation.states()[0], x, ConstRows());
  simulation.setState(*simulation.states()[0], x, ConstRows());
  ASSERT_EQ(simulation.events().size(), 1u) << "one for a step, so that a record does not grow with them";
  EXPECT_THROW(simulation.check(simulation.events()[0]), ComponentError);
  EXPECT_THROW(printActions({"stones.xml", simulation.events()}), std::runtime_error);
}

TEST(Session, SharesItsSimulation) {
  std::shared_ptr<Simulation> kept;
  {
    Session session;
    session.loadText(two_stones, "stones.xml");
    session.run({.steps = 3});
    kept = session.shared();
    session.loadText(two_stones, "stones.xml");
    EXPECT_NE(kept, session.shared());
  }
  EXPECT_EQ(kept->steps(), 3);
  EXPECT_LT(kept->states()[0]->x()[1].y(), 0);
}

TEST(Session, LoadsADescriptionWithValuesThatAreNoText) {
  Session session;
  session.loadText(two_stones, "stones.xml");
  SceneDescription description = session.simulation().scene().description;
  std::vector<double> numbers{0, 0, 0, 0, 7, 0};
  for (ComponentDescription& component : description.root.components)
    for (AttributeDescription& attribute : component.attributes)
      if (attribute.name == "position") attribute.value.clear(), attribute.typed = std::make_shared<Data>("the array", &numbers);
  Simulation& simulation = session.load(description);
  EXPECT_TRUE(isAt(simulation.states()[0]->x(), 1, Vec3(0, 7, 0)));
  numbers.pop_back();
  EXPECT_THROW(session.load(description), SceneError);
}

TEST(Session, TellsWhatComesBeforeAStep) {
  Session session;
  session.loadText(two_stones, "stones.xml");
  std::vector<long> seen;
  RunLimits limits;
  limits.steps = 3;
  limits.before_step = [&seen](Simulation& simulation) {
    seen.push_back(simulation.steps());
    if (simulation.steps() == 2) throw std::logic_error("enough");
  };
  EXPECT_THROW(session.run(limits), std::logic_error);
  EXPECT_EQ(seen, (std::vector<long>{0, 1, 2}));
  EXPECT_EQ(session.simulation().steps(), 2);
}

TEST(Preview, ComponentsAreReadyOneByOne) {
  Session session;
  Diagnostics diagnostics;
  SceneDescription description;
  description.file = "part.xml";
  description.root = readXml("<Node><RegularGridTopology name=\"grid\" n=\"2 2 2\" min=\"0 0 0\" max=\"1 1 1\"/><NoSuchThing/>"
                             "<MechanicalObject name=\"dofs\"/><BoxROI name=\"low\" box=\"-1 -1 -1 2 0.5 2\"/></Node>",
                             "part.xml", {}, diagnostics);
  Preview preview(description, session.factory(), session.modules());
  Component* region = preview.find("/low");
  ASSERT_NE(region, nullptr);
  EXPECT_FALSE(region->isReady());
  EXPECT_TRUE(preview.ready(*region));
  EXPECT_EQ(region->data().find("indices")->print(), "0 1 4 5");
  EXPECT_TRUE(preview.problems().hasErrors()) << "of what is not there";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
