// SPDX-License-Identifier: LGPL-2.1-or-later
// Sleep of bodies at rest: the sleeping run against the waking one, which is computed in every step, and what wakes it.
#include <fmt/format.h>

#include "framework/mechanics/force_field.h"
#include "framework/scene/factory.h"
#include "tests/support/scene_fixture.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double tolerance = 1e-5;  ///< the sleepDistance of these scenes [m]

/// A force on the first node that somebody else decides: stands for a neighbour in another system, whose force is a step late.
class NeighbourForceField final : public ForceField {
 public:
  static inline double force = 0;
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.has_stiffness = false, traits.lagged = true;
    return traits;
  }
  double energy(ConstRows) const override { return 0; }
  void addForce(ConstRows, ConstRows, Rows f) override { f[state().firstRow() + state().size() - 1].x() += force; }
  void addStiffnessProduct(ConstRows, double, Rows) const override {}
  void addPattern(BlockPattern&) const override {}
  void addStiffness(double, BlockMatrix&) const override {}
  void addStiffnessDiagonal(double, std::vector<double>&) const override {}
};

/// A soft block of 0.1 m that settles on its base within half a second.
std::string block(const std::string& sleep, const std::string& more = {}) {
  return R"(<Node name="root" dt="0.01" gravity="0 0 -9.81"><EulerImplicitSolver name="solver" rayleighStiffness="0.03" )" + sleep +
         R"(/><SparseLDLSolver/>
  <RegularGridTopology name="grid" n="3 3 4" min="0 0 0" max="0.1 0.1 0.1"/>
  <MechanicalObject name="dofs"/><DiagonalMass massDensity="1000"/>
  <HexahedronFEMForceField name="fem" method="large" youngModulus="20000" poissonRatio="0.3"/>
  <BoxROI name="base" box="-1 -1 -1  1 1 0.001"/><FixedProjectiveConstraint indices="@base.indices"/>)" + more + "</Node>";
}
const std::string sleeping = R"(sleepDistance="1e-5" sleepTime="0.5")";

long stepsAsleep(const Simulation& simulation) {
  return std::stol(findComponent(simulation.root(), "/solver")->data().find("stepsAsleep")->print());
}

/// One simulation that may sleep beside one that never does; both get whatever happens.
struct Pair {
  explicit Pair(const std::string& more = {})
      : tired(simulationFromText(block(sleeping, more))), awake(simulationFromText(block("", more))) {}

  /// The farthest that the two are apart after any of the steps [m].
  double run(int steps) {
    double most = 0;
    for (int n = 0; n < steps; ++n) {
      EXPECT_FALSE(tired.step().failed());
      EXPECT_FALSE(awake.step().failed());
      for (Index i = 0; i < awake.systems()[0]->allRows(); ++i)
        most = std::max(most, (tired.systems()[0]->x[i] - awake.systems()[0]->x[i]).norm());
    }
    return most;
  }
  void runUntilItSleeps() {
    EXPECT_LE(run(300), tolerance);
    EXPECT_GT(stepsAsleep(tired), 50);
    const long before = stepsAsleep(tired);
    EXPECT_LE(run(10), tolerance);
    EXPECT_EQ(stepsAsleep(tired), before + 10);
  }
  /// It is awake in the next step, moves as the other one, and sleeps again in the end.
  void expectThatItWakes(double way) {
    const long before = stepsAsleep(tired);
    const Vec3 place = tired.systems()[0]->x[tired.systems()[0]->allRows() - 1];
    EXPECT_LE(run(1), tolerance);
    EXPECT_EQ(stepsAsleep(tired), before) << "the change is seen in its step";
    EXPECT_LE(run(400), tolerance);
    EXPECT_GT((tired.systems()[0]->x[tired.systems()[0]->allRows() - 1] - place).norm(), way) << "the test moves the body";
    EXPECT_GT(stepsAsleep(tired), before + 100);
  }

  Simulation tired, awake;
};

TEST(Sleep, ABodyAtRestIsNotComputedAndStaysWithinTheDistance) {
  Pair pair;
  pair.runUntilItSleeps();
  const System& system = *pair.tired.systems()[0];
  const long forces = system.counts.forces;
  const std::uint64_t bits = pair.tired.stateHash();
  EXPECT_LE(pair.run(300), tolerance);
  EXPECT_EQ(system.counts.forces, forces);
  EXPECT_EQ(pair.tired.stateHash(), bits);
  for (Index i = 0; i < system.allRows(); ++i) EXPECT_EQ(system.v[i].norm(), 0);
}

TEST(Sleep, NobodySleepsWhoWasNotToldTo) {
  Simulation simulation = simulationFromText(block(""));
  for (int n = 0; n < 400; ++n) simulation.step();
  EXPECT_EQ(stepsAsleep(simulation), 0);
}

TEST(Sleep, ALoadOverTimeWakesIt) {
  // rests until t = 4 s
  Pair pair(R"(<LinearForceField points="35" times="0 4 4.5 60" forces="0 0 0  0 0 0  0.05 0 0  0.05 0 0"/>)");
  EXPECT_LE(pair.run(400), tolerance);
  EXPECT_GT(stepsAsleep(pair.tired), 100);
  pair.expectThatItWakes(1e-4);
}

TEST(Sleep, APrescribedMotionWakesIt) {
  Pair pair(R"(<LinearMovementProjectiveConstraint indices="33 34 35" keyTimes="0 4 4.5 60" outside="hold"
               movements="0 0 0  0 0 0  0.005 0 0  0.005 0 0"/>)");
  EXPECT_LE(pair.run(400), tolerance);
  EXPECT_GT(stepsAsleep(pair.tired), 100);
  pair.expectThatItWakes(1e-3);
}

TEST(Sleep, AConstraintThatEndsWakesIt) {
  Pair pair(R"(<FixedProjectiveConstraint indices="33 34 35" endTime="3.995"/>)");
  EXPECT_LE(pair.run(400), tolerance);
  EXPECT_GT(stepsAsleep(pair.tired), 100);
  pair.expectThatItWakes(1e-4);
}

TEST(Sleep, AnInputWakesItAndSoDoesAnother) {
  Pair pair;
  pair.runUntilItSleeps();
  Input input;
  input.state = "/dofs", input.nodes = {35}, input.force = Vec3(0.05, 0, 0);
  const long number = pair.tired.addInput(input), other = pair.awake.addInput(input);
  pair.expectThatItWakes(1e-4);
  input.force = Vec3(0, 0.05, 0);  // no derivative is another one
  pair.tired.changeInput(number, input), pair.awake.changeInput(other, input);
  pair.expectThatItWakes(1e-4);
  pair.tired.removeInput(number), pair.awake.removeInput(other);
  pair.expectThatItWakes(1e-4);
}

TEST(Sleep, AnAttributeWakesIt) {
  Pair pair;
  pair.runUntilItSleeps();
  for (Simulation* simulation : {&pair.tired, &pair.awake}) simulation->setAttribute("/fem", "youngModulus", "10000");
  pair.expectThatItWakes(1e-4);
  for (Simulation* simulation : {&pair.tired, &pair.awake}) simulation->setAttribute("/", "gravity", "0 -9.81 0");
  pair.expectThatItWakes(1e-4);
}

TEST(Sleep, APlaceFromOutsideWakesIt) {
  Pair pair;
  pair.runUntilItSleeps();
  for (Simulation* simulation : {&pair.tired, &pair.awake}) {
    Vector x = Vector(36);
    copy(simulation->systems()[0]->x, x);
    x[35].x() += 0.002;
    simulation->setState(*simulation->states()[0], x, {});
  }
  pair.expectThatItWakes(1e-4);
}

TEST(Sleep, ANeighbourWakesIt) {
  NeighbourForceField::force = 0;
  Pair pair("<NeighbourForceField/>");
  pair.runUntilItSleeps();
  NeighbourForceField::force = 0.05;
  pair.expectThatItWakes(1e-4);
}

TEST(Sleep, ACheckpointHasIt) {
  Simulation whole = simulationFromText(block(sleeping)), parted = simulationFromText(block(sleeping));
  for (int n = 0; n < 310; ++n) whole.step(), parted.step();
  ASSERT_GT(stepsAsleep(whole), 50);
  Simulation other = simulationFromText(block(sleeping));
  other.restore(parted.checkpoint().readable());
  for (int n = 0; n < 10; ++n) whole.step(), other.step();
  EXPECT_EQ(stepsAsleep(other), stepsAsleep(whole));
  EXPECT_EQ(other.stateHash(), whole.stateHash());
  Input input;
  input.state = "/dofs", input.nodes = {35}, input.force = Vec3(0.05, 0, 0);
  whole.addInput(input), other.addInput(input);
  for (int n = 0; n < 50; ++n) whole.step(), other.step();
  EXPECT_EQ(other.stateHash(), whole.stateHash());
  whole.reset();
  EXPECT_EQ(stepsAsleep(whole), 0);
  for (int n = 0; n < 310; ++n) whole.step();
  EXPECT_EQ(whole.stateHash(), parted.stateHash());
}

TEST(Sleep, WhatIsNotOfForcesAloneIsRefused) {
  const std::string frame = R"(<Node name="root"><EulerImplicitSolver sleepDistance="1e-5"/><SparseLDLSolver/>
    <MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1"/><UniformMass totalMass="1" inertia="1 1 1"/></Node>)";
  expectContains(problemsOf(frame), "frames, whose turning has no distance");
  // it would not see a tool come
  const std::string touched = R"(<Node name="root"><EulerImplicitSolver sleepDistance="1e-5"/><SparseLDLSolver/>
    <RegularGridTopology name="grid" n="3 3 3" min="0 0 0" max="1 1 1"/><MechanicalObject/><UniformMass totalMass="1"/>
    <HexahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/><BarrierContact planes="0 0 1 -1"/></Node>)";
  expectContains(problemsOf(touched), "surfaces that meet, of /BarrierContact");
  const Simulation simulation = simulationFromText(block(sleeping));
  expectContains(simulation.systems()[0]->integrator().describe(), "not computed once all nodes have lain");
}

const bool is_registered = [] {
  factory().add<NeighbourForceField>("NeighbourForceField", "a force that somebody else decides");
  return true;
}();

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
