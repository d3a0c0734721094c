// SPDX-License-Identifier: LGPL-2.1-or-later
// What a run is warned of at its end though every step succeeded: strains beyond a linear law, energy from nowhere,
// velocities that ring, meshes that have folded, shapes of rest with too much energy, forces that are a step late.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "tests/support/scene_fixture.h"
#include "tools/checks/result_doubts.h"

namespace stroma::test {
namespace {

std::string doubtsText(const Simulation& simulation) {
  std::string all;
  for (const std::string& sentence : doubtsOf(simulation)) all += sentence + "\n";
  return all;
}
bool says(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

/// One cell of 0.1 m, whole or cut in five.
Simulation cell(const std::string& field) {
  const bool cut = says(field, "Tetrahedron");
  return simulationFromText(fmt::format(
      R"(<Node name="root" dt="0.01" gravity="0 0 0"><MeshTopology name="mesh" position="0 0 0 0.1 0 0 0.1 0.1 0 0 0.1 0
  0 0 0.1 0.1 0 0.1 0.1 0.1 0.1 0 0.1 0.1" hexahedra="0 1 2 3 4 5 6 7"/><Node name="body"><EulerImplicitSolver/>
  <SparseLDLSolver/>{}<MechanicalObject/><UniformMass totalMass="1"/><{} name="fem" youngModulus="1000"
  poissonRatio="0.3"/></Node></Node>)",
      cut ? "<TetrahedronSetTopologyContainer name='cells'/><Hexa2TetraTopologicalMapping input='@../mesh' "
            "output='@cells' cutting='five'/>"
          : "<HexahedronSetTopologyContainer name='cells' src='@../mesh'/>",
      field));
}

TEST(Doubts, StrainsBeyondALinearLawAreNamed) {
  for (const std::string kind : {"Tetrahedron", "Hexahedron"})
    for (const std::string method : {"small", "large", "polar", "svd", "green"}) {
      SCOPED_TRACE(kind + " " + method);
      Simulation simulation = cell(kind + "FEMForceField method=\"" + method + "\"");
      Vector& x = simulation.systems()[0]->x;
      for (Index i = 0; i < x.count(); ++i) x[i].x() *= 1.4;
      EXPECT_EQ(doubtsText(simulation), "");
      for (Index i = 0; i < x.count(); ++i) x[i].x() *= 1.6 / 1.4;
      const std::string text = doubtsText(simulation);
      for (const std::string word : {"/body/fem at t = 0 s", "strained beyond 50 %", "hedron ", ": 60 %"})
        EXPECT_TRUE(says(text, word)) << word << " in " << text;
      for (Index i = 0; i < x.count(); ++i) x[i].x() *= 0.4 / 1.6;
      EXPECT_TRUE(says(doubtsText(simulation), "strained beyond 50 %"));
    }
  // the law of large strains is asked for none
  Simulation simulation = cell("HexahedronHyperelasticityFEMForceField materialName=\"NeoHookean\"");
  Vector& x = simulation.systems()[0]->x;
  for (Index i = 0; i < x.count(); ++i) x[i].x() *= 1.6;
  EXPECT_EQ(doubtsText(simulation), "");
}

/// An hourglass has no strain in the mean of the cell.
TEST(Doubts, StrainsAreThoseOfThePointsOfAHexahedron) {
  Simulation simulation = cell("HexahedronFEMForceField method=\"polar\"");
  Vector& x = simulation.systems()[0]->x;
  const int signs[] = {1, -1, 1, -1, 1, -1, 1, -1};
  for (Index i = 0; i < 8; ++i) x[i].x() += 0.1 * signs[i] * 0.45;
  const std::string text = doubtsText(simulation);
  EXPECT_TRUE(says(text, "1 of 1 elements are strained beyond 50 %")) << text;
}

/// A mass on a stiff spring: linearised steps far above its period gain energy; a small step and a step that damps do
/// not, nor does a mass that falls.
TEST(Doubts, EnergyFromNowhereIsNamed) {
  const auto pendulum = [](const std::string& integrator, double dt, const std::string& gravity) {
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="{}" gravity="{}"><{}/><SparseLDLSolver/><MechanicalObject position="0 0 0 1 0 0  2 0 0"
  velocity="0 0 0  0 2 0  0 -3 1"/><UniformMass totalMass="0.3"/><FixedProjectiveConstraint indices="0"/>
  <SpringForceField springsIndices1="0 1" springsIndices2="1 2" lengths="1 1" stiffness="1000" damping="0"/></Node>)",
        dt, gravity, integrator));
    for (int step = 0; step < 200; ++step) EXPECT_FALSE(simulation.step().diverged);
    return doubtsText(simulation);
  };
  for (const std::string integrator :
       {"NewmarkImplicitSolver newtonIterations=\"1\"", "TrapezoidalRuleSolver newtonIterations=\"1\"",
        "EulerImplicitSolver trapezoidalScheme=\"true\" newtonIterations=\"1\""}) {
    const std::string gained = pendulum(integrator, 0.2, "0 0 0");
    EXPECT_TRUE(says(gained, " has gained ")) << integrator << ": " << gained;
    EXPECT_FALSE(says(pendulum(integrator, 0.001, "0 0 0"), "has gained"));
    EXPECT_FALSE(says(pendulum(integrator, 0.001, "0 0 -9.81"), "has gained"));
  }
  EXPECT_FALSE(says(pendulum("EulerImplicitSolver", 0.2, "0 0 0"), "has gained"));
}

/// A stiff bar far above its periods: rules that damp nothing turn its velocities around at each step, those that damp
/// do not, and neither does a step that follows the motion.
TEST(Doubts, VelocitiesThatRingAreNamed) {
  const auto bar = [](const std::string& integrator, double dt) {
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="{}" gravity="0 0 0"><{}/><SparseLDLSolver/><MechanicalObject position="0 0 0 1 0 0  2 0 0"
  velocity="0 0 0  0.01 0 0  -0.01 0 0"/><UniformMass totalMass="0.3"/><FixedProjectiveConstraint indices="0"/>
  <SpringForceField springsIndices1="0 1" springsIndices2="1 2" lengths="1 1" stiffness="1000" damping="0"/></Node>)",
        dt, integrator));
    for (int step = 0; step < 40; ++step) EXPECT_FALSE(simulation.step().diverged);
    return doubtsText(simulation);
  };
  for (const std::string integrator : {"NewmarkImplicitSolver", "TrapezoidalRuleSolver", "VariationalSymplecticSolver",
                                       "EulerImplicitSolver trapezoidalScheme=\"true\""}) {
    const std::string rings = bar(integrator, 1);
    EXPECT_TRUE(says(rings, "velocities change sign from step to step, or every other step. dt = 1 is far"))
        << integrator << ": " << rings;
    EXPECT_EQ(bar(integrator, 0.001), "") << integrator;
  }
  for (const std::string integrator : {"EulerImplicitSolver", "BDFOdeSolver order=\"2\""})
    EXPECT_EQ(bar(integrator, 1), "") << integrator;
}

/// What rings with the round-off of a body at rest is no doubt.
TEST(Doubts, ABodyThatHasSettledIsNotInDoubt) {
  for (const std::string rule : {"NewmarkImplicitSolver", "TrapezoidalRuleSolver", "VariationalSymplecticSolver"}) {
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="0.02" gravity="0 0 -9.81"><RegularGridTopology name="grid" n="3 3 4" min="0 0 0"
  max="0.1 0.1 0.2"/><Node name="body"><{} rayleighMass="8" rayleighStiffness="0.02"/><SparseLDLSolver/>
  <HexahedronSetTopologyContainer name="cells" src="@../grid"/><MechanicalObject/><UniformMass totalMass="1"/>
  <HexahedronFEMForceField youngModulus="20000" poissonRatio="0.3" method="small"/>
  <FixedProjectiveConstraint indices="0 1 2 3 4 5 6 7 8"/></Node></Node>)",
        rule));
    for (int step = 0; step < 3000; ++step) ASSERT_FALSE(simulation.step().diverged);
    EXPECT_EQ(doubtsText(simulation), "") << rule;
  }
}

/// A block between glued plates, pressed to 30 % of its height. Statics have a result for a law that is finite at J = 0, and
/// cells at the edges of the plates may be inside out in it: that is said, with the cause where it is the mean dilatation.
TEST(Doubts, CellsThatAPressTurnsInsideOutAreNamed) {
  const auto pressed = [](const std::string& material) {
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/>
  <RegularGridTopology name="grid" n="7 7 7" min="0 0 0" max="0.1 0.1 0.1"/><MechanicalObject/>
  <HexahedronHyperelasticityFEMForceField name="fem" youngModulus="1e5" poissonRatio="0.45" {}/>
  <BoxROI name="low" box="-1 -1 -0.001 1 1 0.001"/><BoxROI name="high" box="-1 -1 0.099 1 1 1"/>
  <FixedProjectiveConstraint indices="@low.indices"/>
  <LinearMovementProjectiveConstraint indices="@high.indices" keyTimes="0 7" movements="0 0 0 0 0 -0.07" outside="hold"/>
  </Node>)",
        material));
    for (int step = 0; step < 7; ++step) EXPECT_TRUE(simulation.step().newton_converged) << step;
    return doubtsText(simulation);
  };
  const std::string mean = pressed(R"(materialName="StableNeoHookean" dilatation="mean")");
  for (const std::string word : {"/fem at t = 7 s", "of 216 elements are inverted or flat", "J = -",
                                 "StableNeoHookean lets single points turn inside out", "dilatation=\"local\" resists"})
    EXPECT_TRUE(says(mean, word)) << word << " in " << mean;
  const std::string local = pressed(R"(materialName="StableNeoHookean" dilatation="local")");
  EXPECT_TRUE(says(local, "elements are inverted or flat")) << local;
  EXPECT_FALSE(says(local, "dilatation")) << local;
  // ln J keeps the points, not the corners
  const std::string log = pressed(R"(materialName="NeoHookean" dilatation="mean")");
  EXPECT_TRUE(says(log, "hexahedra are inverted at a corner")) << log;
}

/// W = mu/2 (I1 - 3) + (lambda + mu)/2 (J - a)^2 of a bar of length s with free sides: J = a - mu/((lambda + mu) s), with Poisson's
/// ratio 0 2 - 1/s. Half its length leaves no width: the solve converges to a line.
TEST(Doubts, ABarWithoutAWidthIsNamed) {
  const auto pressed = [](double share) {
    return simulationFromText(fmt::format(
        R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/>
  <RegularGridTopology name="grid" n="2 2 2" min="0 0 0" max="0.1 0.1 0.1"/><MechanicalObject/>
  <HexahedronHyperelasticityFEMForceField name="fem" materialName="StableNeoHookean" mu="5000" lambda="0"/>
  <PartialFixedProjectiveConstraint indices="0 2 4 6" fixedDirections="1 0 0"/>
  <PartialFixedProjectiveConstraint indices="0 1 4 5" fixedDirections="0 1 0"/>
  <PartialFixedProjectiveConstraint indices="0 1 2 3" fixedDirections="0 0 1"/>
  <PartialLinearMovementProjectiveConstraint indices="4 5 6 7" movedDirections="0 0 1" keyTimes="0 1" movements="0 0 0 0 0 {}"
   outside="hold"/></Node>)",
        0.1 * (share - 1)));
  };
  Simulation thin = pressed(0.55);
  ASSERT_TRUE(thin.step().newton_converged);
  const double width = thin.systems()[0]->x[7].x() / 0.1;
  EXPECT_NEAR(width * width * 0.55, 2 - 1 / 0.55, 1e-7);
  EXPECT_EQ(doubtsText(thin), "");
  Simulation none = pressed(0.5);
  const StepReport report = none.step();
  ASSERT_TRUE(report.newton_converged) << report.reason;
  EXPECT_TRUE(says(doubtsText(none), "1 of 1 elements are inverted or flat")) << doubtsText(none);
}

/// Springs know lengths alone: the mirrored block is at rest.
TEST(Doubts, MeshesThatSpringsLetFoldAreNamed) {
  Simulation block = simulationFromText(
      R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver/><SparseLDLSolver/>
  <RegularGridTopology name="grid" n="3 3 3" min="0 0 0" max="1 1 1"/><MechanicalObject/><UniformMass totalMass="1"/>
  <MeshSpringForceField stiffness="100"/></Node>)");
  Vector& x = block.systems()[0]->x;
  EXPECT_EQ(doubtsText(block), "");
  for (Index i = 0; i < x.count(); ++i) x[i].y() *= -1;
  EXPECT_TRUE(says(doubtsText(block), "/grid at t = 0: 8 of 8 hexahedra are inverted at a corner"))
      << doubtsText(block);
}

/// A truss of two bars, 2 m wide and 0.3 m high, that starts below its supports, under a gravity that points up: through once,
/// and at rest there in E(z) = k (sqrt(1 + z^2) - L)^2 - m g z.
struct Truss {
  double gravity, stiffness = 1e4, mass = 0.3, length = std::sqrt(1.09);
  double energy(double z) const {
    const double stretch = std::sqrt(1 + z * z) - length;
    return stiffness * stretch * stretch - mass * gravity * z;
  }
  double force(double z) const {
    const double now = std::sqrt(1 + z * z);
    return -2 * stiffness * (now - length) * z / now + mass * gravity;
  }
  /// Where forces balance between two heights, by bisection.
  double rest(double low, double high) const {
    for (int i = 0; i < 200; ++i) (force(low) * force((low + high) / 2) > 0 ? low : high) = (low + high) / 2;
    return low;
  }
  std::string doubts(const std::string& integrator, double start, int steps) const {
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="0.01" gravity="0 0 {}"><{}/><SparseLDLSolver/><MechanicalObject
  position="-1 0 0  0 0 {}  1 0 0" rest_position="-1 0 0  0 0 0.3  1 0 0"/><UniformMass vertexMass="{}"/>
  <FixedProjectiveConstraint indices="0 2"/><SpringForceField name="bars" springsIndices1="0 1" springsIndices2="1 2"
  lengths="{} {}" stiffness="{}" damping="0"/></Node>)",
        gravity, integrator, start, mass, length, length, stiffness));
    for (int step = 0; step < steps; ++step) EXPECT_FALSE(simulation.step().diverged);
    return doubtsText(simulation);
  }
};

TEST(Doubts, AShapeWithMoreEnergyThanThatOfRestIsNamed) {
  const Truss up{10};
  const double excess = up.energy(up.rest(-0.5, -0.1)) - up.energy(0.3);
  EXPECT_NEAR(excess, 2 * 0.3 * 10 * 0.3, 0.01);  // m g times twice the height
  for (const std::string integrator : {"StaticSolver", "EulerImplicitSolver rayleighMass=\"20\""}) {
    const std::string text = up.doubts(integrator, -0.3, 300);
    EXPECT_TRUE(says(text, fmt::format("at rest with {:.3g} more than the rest shape under the same loads", excess)))
        << text;
    EXPECT_TRUE(says(text, "snapped to another equilibrium. Most of the energy is the energy of gravity")) << text;
    // the same shape is where gravity pulls it, and the shape of rest where nothing does
    EXPECT_EQ(Truss{-10}.doubts(integrator, -0.3, 300), "") << integrator;
    EXPECT_EQ(up.doubts(integrator, 0.3, 300), "") << integrator;
  }
  // on its way, and where it turns around
  for (int steps = 1; steps < 60; ++steps)
    EXPECT_FALSE(says(up.doubts("TrapezoidalRuleSolver", -0.35, steps), "at rest")) << steps;
}

/// Three nodes in line whose springs, and soft ones to their places, balance in another order.
TEST(Doubts, ARopeThatHasFoldedAgainstItsSupportIsNamed) {
  Simulation rope = simulationFromText(
      R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver rayleighMass="20"/><SparseLDLSolver/><MechanicalObject
  position="2 0 0  1 0 0  0 0 0" rest_position="0 0 0  1 0 0  2 0 0"/><UniformMass totalMass="1"/><SpringForceField
  name="rope" springsIndices1="0 1" springsIndices2="1 2" lengths="1 1" stiffness="100" damping="0"/>
  <RestShapeSpringsForceField name="support" stiffness="10"/></Node>)");
  for (int step = 0; step < 500; ++step) EXPECT_FALSE(rope.step().diverged);
  // turned round: the ends pull by 10 (2 - u) against 100 u of their springs
  const double u = 20. / 110, excess = 10 * (2 - u) * (2 - u) + 100 * u * u;
  const std::string text = doubtsText(rope);
  EXPECT_TRUE(says(text, fmt::format("at rest with {:.3g} more than the rest shape under the same loads", excess))) << text;
  EXPECT_TRUE(says(text, "Most of the energy is in /support")) << text;
}

/// A beam that two opposite pressures at its end have bent by more than 109 degrees: the couple follows, and held as it is now
/// it would do less work on the straight way back than the beam has taken. It is where it should be.
TEST(Doubts, ABeamThatAFollowingCoupleBendsIsNotInDoubt) {
  constexpr int nodes = 9;
  constexpr double angle = 2.3, radius = 1 / angle;
  std::string bent;
  for (const double z : {-0.05, 0., 0.05})
    for (const double y : {0., 0.1})
      for (int i = 0; i < nodes; ++i) {
        const double turn = angle * i / (nodes - 1);
        bent += fmt::format("{} {} {} ", std::sin(turn) * (radius - z), y, radius - std::cos(turn) * (radius - z));
      }
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="0.05" gravity="0 0 0"><EulerImplicitSolver rayleighMass="20" newtonIterations="20"/><SparseLDLSolver/>
  <RegularGridTopology name="grid" n="{} 2 3" min="0 0 -0.05" max="1 0.1 0.05"/><MechanicalObject position="{}"
  rest_position="@grid.position"/><MeshMatrixMass massDensity="1000"/><HexahedronHyperelasticityFEMForceField
  materialName="StVenantKirchhoff" ParameterSet="5e5 0"/><BoxROI name="wall" box="-0.001 -1 -1 0.001 1 1"/>
  <FixedProjectiveConstraint indices="@wall.indices"/><SurfacePressureForceField min="0.999 -1 -0.051" max="2 1 0.001"
  pressure="1.8e5"/><SurfacePressureForceField min="0.999 -1 -0.001" max="2 1 0.051" pressure="-1.8e5"/></Node>)",
      nodes, bent));
  for (int step = 0; step < 400; ++step) {
    const StepReport report = simulation.step();
    ASSERT_TRUE(!report.diverged && report.newton_converged) << "it would lie still where nothing is solved: " << report.reason;
  }
  const State& state = *simulation.states().front();
  EXPECT_LT(Vec3(state.v()[nodes - 1]).norm(), 1e-8) << "it lies still";
  const Vec3 end = Vec3(state.x()[nodes - 1]) - Vec3(state.x()[nodes - 2]);
  EXPECT_GT(std::atan2(end.z(), end.x()), 109 * std::numbers::pi / 180) << "else the test tests nothing";
  const std::string text = doubtsText(simulation);
  EXPECT_FALSE(says(text, "at rest with")) << text;
}

/// Cloth of 6 x 6 nodes that is held by an edge, and falls from the plane of the edge: it hangs in its shape, folded in two or
/// crumpled, with less energy than it has in the plane.
TEST(Doubts, ClothThatFoldsRightlyIsNotInDoubt) {
  const auto cloth = [](const std::function<Vec3(int, int)>& place) {
    Simulation simulation = simulationFromText(
        R"(<Node name="root" dt="0.02" gravity="0 0 -9.81"><RegularGridTopology name="grid" n="6 6 1" min="0 0 0"
  max="0.5 0.5 0"/><EulerImplicitSolver newtonIterations="10" rayleighMass="5"/><SparseLDLSolver/><MechanicalObject/>
  <UniformMass totalMass="0.2"/><MeshSpringForceField linesStiffness="500" linesDamping="1"/>
  <FixedProjectiveConstraint indices="0 1 2 3 4 5"/></Node>)");
    Vector& x = simulation.systems()[0]->x;
    for (Index n = 0; n < 36; ++n) x[n] = place(n % 6, n / 6);
    for (int step = 0; step < 3000; ++step) EXPECT_FALSE(simulation.step().diverged);
    EXPECT_LT(Vec3(x[33]).z(), -0.05);
    return doubtsText(simulation);
  };
  const auto flat = [](int i, int j) { return Vec3(0.1 * i, 0.1 * j, 0); };
  const auto folded = [](int i, int j) { return Vec3(0.1 * i, 0.02 * (j % 2), j < 3 ? -0.1 * j : -0.1 * (5 - j)); };
  const auto crumpled = [](int i, int j) {
    return Vec3(0.1 * i, j == 0 ? 0 : 0.02 * std::sin(7. * i * j), j == 0 ? 0 : -0.05 * std::abs(j % 4 - 2));
  };
  for (const auto& start : std::vector<std::function<Vec3(int, int)>>{flat, folded, crumpled}) EXPECT_EQ(cloth(start), "");
}

TEST(Doubts, LateForcesUnderASecondOrderRuleAreNamed) {
  const auto sponge = [](const std::string& integrator, const std::string& coupling) {
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="0.01" gravity="0 0 -9.81"><RegularGridTopology name="grid" n="2 2 2" min="0 0 0" max="1 1 1"/>
  <Node name="body">{}<SparseLDLSolver/><TetrahedronSetTopologyContainer name="cells"/>
  <Hexa2TetraTopologicalMapping input="@../grid" output="@cells"/><MechanicalObject/><UniformMass totalMass="1"/>
  <TetrahedronHyperelasticityFEMForceField materialName="NeoHookean" youngModulus="1000" poissonRatio="0.3"/>
  <TetrahedronPorousForceField fluidFraction="0.5" bulkModulus="100" limitModulus="400" permeability="1e-4"
  coupling="{}"/></Node></Node>)",
        integrator, coupling));
    EXPECT_FALSE(simulation.step().diverged);
    return doubtsText(simulation);
  };
  // known before the first step already
  Simulation early = simulationFromText(
      R"(<Node name="root" dt="0.01" gravity="0 0 -9.81"><RegularGridTopology name="grid" n="2 2 2" min="0 0 0" max="1 1 1"/>
  <Node name="body"><NewmarkImplicitSolver/><SparseLDLSolver/><TetrahedronSetTopologyContainer name="cells"/>
  <Hexa2TetraTopologicalMapping input="@../grid" output="@cells"/><MechanicalObject/><UniformMass totalMass="1000"/>
  <TetrahedronHyperelasticityFEMForceField materialName="NeoHookean" youngModulus="1000" poissonRatio="0.3"/>
  <TetrahedronPorousForceField fluidFraction="0.5" bulkModulus="100" limitModulus="400" permeability="1e-4"
  coupling="semi_implicit"/></Node></Node>)");
  Diagnostics told;
  warnOfLaggedForces(early, told);
  ASSERT_EQ(told.problems().size(), 1u);
  EXPECT_TRUE(says(told.problems()[0].text(), "lags by one step"));
  EXPECT_EQ(doubtsText(early), "");
  for (const std::string rule : {"<BDFOdeSolver order='2'/>", "<NewmarkImplicitSolver/>", "<TrapezoidalRuleSolver/>"}) {
    EXPECT_TRUE(says(sponge(rule, "semi_implicit"), "lags by one step")) << rule;
    EXPECT_EQ(sponge(rule, "implicit"), "") << rule;
  }
  for (const std::string rule : {"<BDFOdeSolver order='1'/>", "<EulerImplicitSolver/>"})
    EXPECT_EQ(sponge(rule, "semi_implicit"), "") << rule;
}

}  // namespace
}  // namespace stroma::test
