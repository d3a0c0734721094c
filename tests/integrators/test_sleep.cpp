// SPDX-License-Identifier: LGPL-2.1-or-later
// Sleep of bodies at rest: the sleeping run against the waking one, which is computed in every step, and what wakes it.
#include <fmt/format.h>

#include <cmath>

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

/// What moves the block.
struct Rule {
  std::string name, element;  ///< without what ends its tag
  double dt = 0.01;
  std::string damping{};  ///< a force field, where the integrator has none
};
void PrintTo(const Rule& rule, std::ostream* out) { *out << rule.name; }
const Rule euler{"EulerImplicitSolver", R"(<EulerImplicitSolver name="solver" rayleighStiffness="0.03" )"};

/// A soft block of 0.1 m that settles on its base within half a second.
std::string block(const std::string& sleep, const std::string& more = {}, const Rule& rule = euler) {
  return fmt::format(R"(<Node name="root" dt="{}" gravity="0 0 -9.81">)", rule.dt) + rule.element + sleep + "/>" + rule.damping +
         R"(<SparseLDLSolver/>
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
  explicit Pair(const std::string& more = {}, const Rule& rule = euler)
      : tired(simulationFromText(block(sleeping, more, rule))), awake(simulationFromText(block("", more, rule))) {}

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
  int stepsIn(double seconds) const { return int(std::lround(seconds / tired.dt())); }
  /// It is awake in the next step, moves as the other one, and sleeps again in the end.
  void expectThatItWakes(double way) {
    const long before = stepsAsleep(tired);
    const Vec3 place = tired.systems()[0]->x[tired.systems()[0]->allRows() - 1];
    EXPECT_LE(run(1), tolerance);
    EXPECT_EQ(stepsAsleep(tired), before) << "the change is seen in its step";
    EXPECT_LE(run(stepsIn(4)), tolerance);
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

// ---- the same of every integrator that has it ----

class SleepOf : public testing::TestWithParam<Rule> {};

TEST_P(SleepOf, ABodyAtRestIsNotComputedAndALoadAndAnInputWakeIt) {
  // rests until t = 4 s
  Pair pair(R"(<LinearForceField points="35" times="0 4 4.5 60" forces="0 0 0  0 0 0  0.05 0 0  0.05 0 0"/>)", GetParam());
  EXPECT_LE(pair.run(pair.stepsIn(3)), tolerance);
  EXPECT_GT(stepsAsleep(pair.tired), pair.stepsIn(0.5));
  const std::uint64_t bits = pair.tired.stateHash();
  const long before = stepsAsleep(pair.tired), forces = pair.tired.systems()[0]->counts.forces;
  EXPECT_LE(pair.run(pair.stepsIn(1)), tolerance);
  EXPECT_EQ(stepsAsleep(pair.tired), before + pair.stepsIn(1));
  EXPECT_EQ(pair.tired.stateHash(), bits);
  EXPECT_EQ(pair.tired.systems()[0]->counts.forces, forces + pair.stepsIn(1)) << "the load over time is looked at once per step";
  pair.expectThatItWakes(1e-4);
  Input input;
  input.state = "/dofs", input.nodes = {35}, input.force = Vec3(0, 0.05, 0);
  pair.tired.addInput(input), pair.awake.addInput(input);
  pair.expectThatItWakes(1e-4);
  if (const Data* energy = findComponent(pair.tired.root(), "/solver")->data().find("hamiltonianEnergy")) {
    const std::string other = findComponent(pair.awake.root(), "/solver")->data().find("hamiltonianEnergy")->print();
    EXPECT_NEAR(std::stod(energy->print()), std::stod(other), 1e-6);
  }
  expectContains(pair.tired.systems()[0]->integrator().describe(), fmt::format("{} steps so far", stepsAsleep(pair.tired)));
}

TEST_P(SleepOf, ACheckpointHasIt) {
  const auto scene = [] { return simulationFromText(block(sleeping, "", GetParam())); };
  Simulation whole = scene(), parted = scene(), other = scene();
  const int steps = int(std::lround(3 / whole.dt()));
  for (int n = 0; n < steps; ++n) whole.step(), parted.step();
  ASSERT_GT(stepsAsleep(whole), 10);
  other.restore(parted.checkpoint().readable());
  Input input;
  input.state = "/dofs", input.nodes = {35}, input.force = Vec3(0.05, 0, 0);
  whole.addInput(input), other.addInput(input);
  for (int n = 0; n < 20; ++n) whole.step(), other.step();
  EXPECT_EQ(stepsAsleep(other), stepsAsleep(whole));
  EXPECT_EQ(other.stateHash(), whole.stateHash());
  EXPECT_NE(other.stateHash(), parted.stateHash());
}

const std::string drag = R"(<UniformVelocityDampingForceField dampingCoefficient="1"/>)";
INSTANTIATE_TEST_SUITE_P(
    Integrators, SleepOf,
    testing::Values(Rule{"Newmark", R"(<NewmarkImplicitSolver name="solver" rayleighStiffness="0.03" )"},
                    Rule{"Trapezoid", R"(<TrapezoidalRuleSolver name="solver" rayleighStiffness="0.03" )"},
                    Rule{"Bdf1", R"(<BDFOdeSolver name="solver" rayleighStiffness="0.03" )"},
                    Rule{"Bdf2", R"(<BDFOdeSolver name="solver" order="2" rayleighStiffness="0.03" )"},
                    Rule{"Midpoint", R"(<VariationalSymplecticSolver name="solver" rayleighStiffness="0.03" )"},
                    Rule{"Variational", R"(<VariationalSymplecticSolver name="solver" explicitIntegration="true" )", 0.002, drag},
                    Rule{"Statics", R"(<StaticSolver name="solver" )"},
                    Rule{"ExplicitEuler", R"(<EulerExplicitSolver name="solver" )", 0.002, drag},
                    Rule{"RungeKutta2", R"(<RungeKutta2Solver name="solver" )", 0.0016, drag},
                    Rule{"RungeKutta4", R"(<RungeKutta4Solver name="solver" )", 0.002, drag},
                    Rule{"NewtonCotes", R"(<NewtonCotesSolver name="solver" )", 0.002, drag},
                    Rule{"CentralDifferences", R"(<CentralDifferenceSolver name="solver" rayleighMass="40" )", 0.002}),
    [](const auto& tested) { return tested.param.name; });

/// A beam whose steps of statics keep their starts, because two iterations find no equilibrium.
TEST(Sleep, WhatHasNoSolutionIsNotAtRest) {
  const auto steps = [](const std::string& gravity, int count) {
    Simulation simulation = simulationFromText(R"(<Node name="root" dt="1" gravity=")" + gravity + R"(">
      <StaticSolver name="solver" sleepDistance="1e-3" sleepTime="2"/><SparseLDLSolver/>
      <NewtonRaphsonSolver updateStateWhenDiverged="false" maxNbIterationsNewton="2"/>
      <RegularGridTopology name="grid" n="9 2 2" min="0 0 0" max="1 0.1 0.1"/><MechanicalObject/><UniformMass totalMass="10"/>
      <HexahedronFEMForceField youngModulus="1e5" poissonRatio="0.3" method="polar"/>
      <BoxROI name="box" box="-0.01 -1 -1 0.01 1 1"/><FixedProjectiveConstraint indices="@box.indices"/></Node>)");
    StepReport last;
    for (int n = 0; n < count; ++n) last = simulation.step();
    return std::pair(last, stepsAsleep(simulation));
  };
  const auto [last, asleep] = steps("0 -900 0", 12);
  EXPECT_TRUE(last.unsolved);
  EXPECT_EQ(asleep, 0);
  const auto [solved, rest] = steps("0 -1e-6 0", 12);
  EXPECT_FALSE(solved.unsolved) << solved.reason;
  EXPECT_GT(rest, 5);
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
