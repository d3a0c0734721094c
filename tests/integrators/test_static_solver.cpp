// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/ground_spring.h"
#include "tests/support/scene_fixture.h"

using namespace stroma;
using namespace stroma::test;

namespace {

Simulation statics(const std::string& attributes, const std::string& spring, const std::string& extra,
                   const std::string& solver = "<SparseLDLSolver/>") {
  registerGroundSpring(factory());
  return simulationFromText(fmt::format(
      R"(<Node name="root" dt="1" gravity="0 -10 0">
           <StaticSolver {}/> {}
           <MechanicalObject name="body" rest_position="0 0 0  1 0 0  2 0 0" velocity="1 1 1  1 1 1  1 1 1"/>
           <UniformMass vertexMass="0.5"/>
           <TestGroundSpring {}/> {}
         </Node>)",
      attributes, solver, spring, extra));
}

}  // namespace

TEST(StaticSolver, ALinearSpringUnderGravityTakesOneIterationAndOneFactorisation) {
  for (const char* solver : {"<SparseLDLSolver/>", "<CGLinearSolver tolerance='1e-14'/>"}) {
    Simulation simulation = statics("", "stiffness='20'", "", solver);
    const StepReport report = simulation.step();
    EXPECT_TRUE(report.newton_converged) << report.reason;
    EXPECT_EQ(report.newton_iterations, 1);
    for (int i = 0; i < 3; ++i) {
      EXPECT_LT((simulation.systems()[0]->x[i] - Vec3(i, -0.25, 0)).norm(), 1e-14);
      EXPECT_EQ(simulation.systems()[0]->v[i].norm(), 0);
    }
    const StepReport second = simulation.step();
    EXPECT_EQ(second.newton_iterations, 0);
    EXPECT_TRUE(second.newton_converged);
  }
}

/// 5 N on each node, and a threshold of 1 kN: the step is over before anything has moved.
TEST(StaticSolver, AThresholdAboveTheForcesIsADoubt) {
  Simulation loose = statics("absolute_residual_tolerance_threshold='1000'", "stiffness='20'", "");
  EXPECT_TRUE(loose.step().newton_converged);
  const std::string doubt = loose.systems()[0]->integrator().doubt();
  EXPECT_NE(doubt.find("a step is taken as solved at its start, with 100 % of the forces out of balance"), std::string::npos)
      << doubt;
  Simulation restored = statics("absolute_residual_tolerance_threshold='1000'", "stiffness='20'", "");
  restored.restore(loose.checkpoint().readable());
  EXPECT_EQ(restored.systems()[0]->integrator().doubt(), doubt) << "a run that goes on is no better";
  Simulation usual = statics("absolute_residual_tolerance_threshold='1e-9'", "stiffness='20'", "");
  for (int step = 0; step < 2; ++step) usual.step();
  EXPECT_EQ(usual.systems()[0]->integrator().doubt(), "") << "the second step has nothing to do";
  Simulation unloaded = simulationFromText(R"(<Node><StaticSolver absolute_residual_tolerance_threshold="1e-5"/><SparseLDLSolver/>
    <RegularGridTopology n="3 3 3" min="0.1 0.2 0.3" max="0.4 0.7 0.9"/><MechanicalObject/>
    <HexahedronFEMForceField youngModulus="1e6" poissonRatio="0.3" method="svd"/>
    <FixedProjectiveConstraint indices="0 1 2 3"/></Node>)");
  EXPECT_EQ(unloaded.step().newton_iterations, 0);
  EXPECT_EQ(unloaded.systems()[0]->integrator().doubt(), "") << "forces of round-off need no balance";
  const auto problem = [](const std::string& attributes) {
    return problemsOf("<Node><StaticSolver " + attributes + "/><CGLinearSolver tolerance='2'/></Node>");
  };
  expectContains(problem("relative_residual_tolerance_threshold='1'"), "1 is outside the range");
  expectContains(problem(""), "2 is outside the range of tolerance (expected a value in [0, 1))");
}

/// A block that is loaded, unloaded and held: where nothing acts its forces are round-off, and it is at rest. A load below that
/// has no answer.
TEST(StaticSolver, StepsWithoutLoadAreAtRest) {
  for (const char* law : {"NeoHookean", "Hencky", "Yeoh", "StVenantKirchhoff"}) {
    const auto block = [&](const char* force) {
      return simulationFromText(fmt::format(R"(<Node dt="0.1" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/>
        <RegularGridTopology n="5 3 3" min="0 0 0" max="0.1 0.02 0.02"/><MechanicalObject name="dofs"/>
        <HexahedronHyperelasticityFEMForceField materialName="{}" youngModulus="1e6" poissonRatio="0.3"/>
        <FixedProjectiveConstraint indices="0 5 10 15 20 25 30 35 40"/>
        <LinearForceField points="4" keyTimes="0 0.3 0.6 0.9 2" forces="0 0 0  0 0 0  0 0 {}  0 0 0  0 0 0"/></Node>)", law, force));
    };
    Simulation simulation = block("0.01");
    for (int step = 1; step <= 12; ++step) {
      const StepReport report = simulation.step();
      EXPECT_TRUE(report.newton_converged && !report.unsolved) << law << ", step " << step << ": " << report.reason;
      EXPECT_LE(report.load_parts, 1);
      const double z = simulation.states()[0]->x()[4].z();
      if (step > 3 && step < 9) {
        EXPECT_GT(z, 1e-6) << step;
      } else {
        EXPECT_LT(std::abs(z), 1e-12) << step;
      }
    }
    EXPECT_EQ(simulation.systems()[0]->integrator().doubt(), "");
    Simulation tiny = block("1e-17");
    for (int step = 1; step <= 3; ++step) EXPECT_TRUE(tiny.step().newton_converged) << law << ", step " << step;
    const StepReport loaded = tiny.step();
    EXPECT_TRUE(loaded.newton_converged || loaded.unsolved) << "a load is not taken for none";
    if (loaded.unsolved) expectContains(loaded.reason, "the loads are too small for this stiffness");
  }
}

TEST(StaticSolver, AHardeningSpringConvergesQuadratically) {
  Simulation simulation = statics("", "stiffness='1' cubic='100'", "");
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.newton_converged) << report.reason;
  // k d + c d^3 = 5
  const double d = -simulation.systems()[0]->x[1][1];
  EXPECT_NEAR(d + 100 * d * d * d, 5, 5e-8);
  const auto& graph =
      *std::get<std::vector<double>*>(simulation.systems()[0]->integrator().data().find("residualGraph")->pointer());
  ASSERT_GE(graph.size(), 4u);
  const double before = graph[graph.size() - 2] / graph[0], last = graph.back() / graph[0];
  EXPECT_LT(last, 100 * before * before);
}

TEST(StaticSolver, ADoubleWellIsLeftForAMinimum) {
  // at rest the tangent is negative definite: K is shifted, and the energy decides
  for (const char* solver : {"<SparseLDLSolver/>", "<CGLinearSolver tolerance='1e-10'/>"}) {
    Simulation simulation = statics("newton_iterations='100'", "stiffness='-50' cubic='100'", "", solver);
    const StepReport report = simulation.step();
    EXPECT_FALSE(report.diverged) << report.reason;
    EXPECT_TRUE(report.newton_converged) << report.reason;
    const double d = simulation.systems()[0]->x[1][1];
    EXPECT_NEAR(-(-50 * d + 100 * d * d * d), 5, 1e-6);
    EXPECT_LT(d, 0);                  // the well that gravity points to
    EXPECT_GT(-50 + 300 * d * d, 0);  // a minimum
  }
}

/// Beside a double well, whose K is shifted at rest, a node without load whose own K vanishes there: it takes part in
/// the shift.
TEST(StaticSolver, ANodeWithoutStiffnessIsShiftedWithTheOthers) {
  registerGroundSpring(factory());
  const auto node = [](const char* gravity, double stiffness) {
    return fmt::format(
        R"(<Node gravity="{}"><MechanicalObject position="0 0 0"/><UniformMass vertexMass="0.5"/>
             <TestGroundSpring stiffness="{}" cubic="100"/></Node>)",
        gravity, stiffness);
  };
  Simulation simulation = simulationFromText(R"(<Node name="root" dt="1"><StaticSolver/><SparseLDLSolver/>)" +
                                             node("0 -10 0", -50) + node("0 0 0", 0) + "</Node>");
  const StepReport report = simulation.step();
  ASSERT_TRUE(report.newton_converged && !report.diverged) << report.reason;
  const System& system = *simulation.systems()[0];
  EXPECT_NEAR(-(-50 * system.x[0][1] + 100 * std::pow(system.x[0][1], 3)), 5, 1e-6);
  EXPECT_EQ(Vec3(system.x[1]), Vec3::Zero());
}

TEST(StaticSolver, AFreeBodyEndsInASentence) {
  for (const char* solver : {"<SparseLDLSolver/>", "<CGLinearSolver/>"}) {
    Simulation simulation = statics("", "couple='100'", "", solver);
    const StepReport report = simulation.step();
    EXPECT_TRUE(report.diverged);
    EXPECT_NE(report.reason.find("not held"), std::string::npos) << report.reason;
    EXPECT_NE(report.reason.find("/body"), std::string::npos) << report.reason;
    EXPECT_EQ(simulation.systems()[0]->x[1], Vec3(1, 0, 0));
  }
}

TEST(StaticSolver, OneHeldNodeIsEnoughForAChain) {
  Simulation simulation = statics("", "couple='100'", "<FixedProjectiveConstraint indices='0'/>");
  const StepReport report = simulation.step();
  EXPECT_FALSE(report.diverged) << report.reason;
  EXPECT_TRUE(report.newton_converged);
  EXPECT_NEAR(simulation.systems()[0]->x[1][1], -0.10, 1e-12);
  EXPECT_NEAR(simulation.systems()[0]->x[2][1], -0.15, 1e-12);
}

TEST(StaticSolver, ABodyHeldInTwoDirectionsOnlyIsNotHeld) {
  Simulation simulation =
      statics("", "couple='100'", "<PartialFixedProjectiveConstraint indices='0 1 2' fixedDirections='1 0 1'/>");
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.diverged);
  EXPECT_NE(report.reason.find("not held"), std::string::npos) << report.reason;
}

namespace {

/// Two tetrahedra, held at these nodes.
Simulation twoBodies(const std::string& gravity, const std::string& held) {
  return simulationFromText(fmt::format(
      R"(<Node name="root" dt="1" gravity="{}"><StaticSolver/><SparseLDLSolver/>
           <MechanicalObject name="dofs" position="0 0 0  1 0 0  0 1 0  0 0 1   3 0 0  4 0 0  3 1 0  3 0 1"/>
           <MeshTopology position="@dofs.position" tetrahedra="0 1 2 3  4 5 6 7"/><UniformMass vertexMass="0.5"/>
           <TetrahedronFEMForceField youngModulus="5e9" poissonRatio="0.3" method="small"/>
           <FixedProjectiveConstraint name="held" indices="{}"/></Node>)",
      gravity, held));
}

void expectFree(const StepReport& report) {
  EXPECT_TRUE(report.diverged);
  EXPECT_NE(report.reason.find("the part of /dofs around node 4 (4 nodes) is not held against rotation"),
            std::string::npos)
      << report.reason;
}

}  // namespace

TEST(StaticSolver, ABodyThatAnEditSetsFreeIsNamedAlsoWhenAsManyNodesAreHeld) {
  // stiff, so that the body has kept its shape: a linear law resists the turns of another one
  Simulation simulation = twoBodies("0 -10 0", "0 1 2  4 5 6");
  ASSERT_FALSE(simulation.step().diverged);
  simulation.setAttribute("/held", "indices", "0 1 2 3  4 5");
  expectFree(simulation.step());
  simulation.setAttribute("/held", "indices", "0 1 3  4 5 7");
  EXPECT_FALSE(simulation.step().diverged);
}

TEST(StaticSolver, ABodyThatANewLoadTakesItsEquilibriumIsNamed) {
  Simulation simulation = twoBodies("0 0 0", "0 1 2 3  4 5");
  ASSERT_FALSE(simulation.step().diverged) << "nothing pushes";
  simulation.setAttribute("/", "gravity", "0 -10 0");
  expectFree(simulation.step());
}

TEST(StaticSolver, ABodyThatOnlyAnInputHeldIsNamedWhenItEnds) {
  Simulation simulation = twoBodies("0 -10 0", "0 1 2  4 5");
  const long number =
      simulation.addInput({.state = "/dofs", .nodes = {6}, .targets = {Vec3(3, 1, 0)}, .stiffness = 1e9});
  for (int step = 1; step <= 2; ++step) ASSERT_FALSE(simulation.step().diverged);
  simulation.removeInput(number);
  expectFree(simulation.step());
}

TEST(StaticSolver, ABodyThatAnInputPushesAwayIsNamed) {
  Simulation simulation = twoBodies("0 0 0", "0 1 2  4 5");
  ASSERT_FALSE(simulation.step().diverged) << "nothing pushes";
  simulation.addInput({.state = "/dofs", .nodes = {6}, .force = Vec3(0, 0, 1)});
  expectFree(simulation.step());
}

TEST(StaticSolver, LoadsThatCancelNeedNoSupport) {
  Simulation simulation =
      statics("", "couple='100'", "<ConstantForceField indices='0 1 2' forces='-3 5 0  0 5 0  3 5 0'/>",
              "<CGLinearSolver iterations='100' tolerance='1e-12'/>");
  const StepReport report = simulation.step();
  EXPECT_FALSE(report.diverged) << report.reason;
  EXPECT_TRUE(report.newton_converged) << report.reason;
  EXPECT_NEAR((simulation.systems()[0]->x[2] - simulation.systems()[0]->x[0]).norm(), 2.06, 1e-9);
}

TEST(StaticSolver, ReachingTheLimitIsSaid) {
  Simulation simulation = statics("newton_iterations='2'", "stiffness='1' cubic='1000'", "");
  const StepReport report = simulation.step();
  EXPECT_FALSE(report.diverged);
  EXPECT_FALSE(report.newton_converged);
  EXPECT_EQ(report.newton_iterations, 2);
  EXPECT_NE(report.reason.find("limit of 2"), std::string::npos) << report.reason;
}

/// A Newton iteration is one solve of a direct solver, in every part and also in those that failed.
TEST(StaticSolver, ADividedStepCountsAllOfItsParts) {
  Simulation simulation = statics("newton_iterations='6'", "stiffness='1' cubic='1e6'", "");
  const StepReport report = simulation.step();
  ASSERT_TRUE(report.newton_converged) << report.reason;
  ASSERT_GT(report.load_parts, 1);
  EXPECT_GT(report.newton_iterations, 6);
  EXPECT_EQ(report.newton_iterations, report.linear_iterations);
  EXPECT_EQ(report.newton_iterations, report.factorisations);
}

TEST(StaticSolver, AMissingLinearSolverIsMade) {
  registerGroundSpring(factory());
  Simulation simulation = statics("", "stiffness='20'", "", "");
  EXPECT_TRUE(simulation.step().newton_converged);
  EXPECT_NEAR(simulation.systems()[0]->x[1][1], -0.25, 1e-14);
}

namespace {

/// A cube between plates that come together by 18 % in one step, as scenes/benchmarks/compressed_cube.xml.
Simulation compressedCube(const std::string& attributes, const std::string& solvers) {
  return simulationFromText(fmt::format(
      R"(<Node name="root" dt="1" gravity="0 0 0">
           <StaticSolver relative_residual_tolerance_threshold="1e-8" {}/> {}
           <RegularGridTopology n="7 7 7" min="0 0 0" max="0.08 0.08 0.08"/>
           <MechanicalObject name="dofs"/>
           <UniformMass totalMass="0.5"/>
           <HexahedronFEMForceField youngModulus="5000" poissonRatio="0.45" method="green"/>
           <BoxROI name="below" box="-1 -1 -0.001  1 1 0.001" position="@dofs.rest_position"/>
           <BoxROI name="above" box="-1 -1 0.079  1 1 0.081" position="@dofs.rest_position"/>
           <FixedProjectiveConstraint indices="@below.indices"/>
           <LinearMovementProjectiveConstraint indices="@above.indices" keyTimes="0 1" movements="0 0 0  0 0 -0.0146"
                                               outside="hold"/>
         </Node>)",
      attributes, solvers));
}

}  // namespace

TEST(StaticSolver, LooseSolvesWithAFormerFactorFindTheEquilibriumOfPlainNewton) {
  Simulation plain = compressedCube("", "<SparseLDLSolver/>");
  Simulation loose =
      compressedCube("forcing_term='0.1'",
                     "<PCGLinearSolver iterations='200' tolerance='1e-9' preconditioner='warped'/><SparseLDLSolver/>");
  const StepReport exact = plain.step(), inexact = loose.step();
  for (const StepReport* report : {&exact, &inexact}) {
    ASSERT_TRUE(report->newton_converged && !report->diverged) << report->reason;
    EXPECT_LE(report->newton_residual, 1e-8);
  }
  EXPECT_EQ(exact.factorisations, exact.newton_iterations + 1) << "and one for the motion of the plate";
  EXPECT_LT(inexact.factorisations, exact.factorisations) << "a former factor serves while it pays";
  // early iterations are solved to a tenth, not to 1e-9, which takes ten times the iterations
  EXPECT_LE(inexact.linear_iterations, 8 * inexact.newton_iterations);
  // residuals of 1e-8 of the load: displacements agree to about that times how soft the softest mode is
  const Vector &a = plain.systems()[0]->x, &b = loose.systems()[0]->x;
  double apart = 0;
  for (Index i = 0; i < a.count(); ++i) apart = std::max(apart, (Vec3(a[i]) - Vec3(b[i])).norm());
  EXPECT_LT(apart, 1e-6 * 0.0146);
  EXPECT_GT(apart, 0) << "the same arithmetic twice compares nothing";
}

/// A straight column, clamped at its foot, bears E I pi^2 / (2 l)^2; beyond that it stands, but would not stay.
TEST(StaticSolver, AColumnBeyondItsBucklingLoadIsDoubted) {
  constexpr double young = 1e5, width = 0.01, height = 0.2;
  const double buckling = young * std::pow(width, 4) / 12 * std::pow(std::numbers::pi / (2 * height), 2);
  for (const double part : {0.5, 2.}) {
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/><RegularGridTopology n="3 3 21" min="0 0 0"
             max="0.01 0.01 0.2"/><MechanicalObject/><UniformMass totalMass="0.01"/><HexahedronHyperelasticityFEMForceField
             materialName="NeoHookean" youngModulus="{}" poissonRatio="0"/><BoxROI name="foot" box="-1 -1 -1 1 1 1e-6"/>
             <BoxROI name="top" box="-1 -1 0.1999 1 1 1"/><FixedProjectiveConstraint indices="@foot.indices"/>
             <ConstantForceField indices="@top.indices" totalForce="0 0 {:.17g}"/></Node>)",
        young, -part * buckling));
    for (int step = 0; step < 2; ++step) {  // the second one has nothing to do, and changes nothing of that
      EXPECT_TRUE(simulation.step().newton_converged);
      const std::string doubt = simulation.systems()[0]->integrator().doubt();
      EXPECT_EQ(doubt.find("may be unstable") != std::string::npos, part > 1) << part << " " << step << " " << doubt;
    }
  }
}

/// The stiffness of a pressure that turns with its face is kept symmetric: it is not the derivative of the forces, and has
/// unstable directions where a bar is pulled. What was unstable is told though the last step is not.
TEST(StaticSolver, OnlyEquilibriaThatAreUnstableAreDoubted) {
  const auto doubtOf = [](const std::string& load, int steps) {
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/><RegularGridTopology name="grid" n="3 3 21"
             min="0 0 0" max="0.01 0.01 0.2"/><MechanicalObject/><UniformMass totalMass="0.01"/>
             <HexahedronHyperelasticityFEMForceField materialName="NeoHookean" youngModulus="1e5" poissonRatio="0"/>
             <BoxROI name="foot" box="-1 -1 -1 1 1 1e-6"/><BoxROI name="top" box="-1 -1 0.1999 1 1 1"/>
             <FixedProjectiveConstraint indices="@foot.indices"/>{}</Node>)",
        load));
    for (int step = 0; step < steps; ++step) EXPECT_TRUE(simulation.step().newton_converged);
    return simulation.systems()[0]->integrator().doubt();
  };
  EXPECT_EQ(doubtOf(R"(<SurfacePressureForceField min="-1 -1 0.1999" max="1 1 1" pressure="1000"/>)", 1), "");
  EXPECT_EQ(doubtOf(R"(<SurfacePressureForceField min="-1 -1 0.1999" max="1 1 1" pressure="200"/>)", 1), "");
  const std::string unloaded = R"(<LinearForceField indices="@top.indices" times="0 1 2 3 4 5"
                                    forces="0 0 0 0 0 -1.1e-3 0 0 -1.1e-3 0 0 -1.1e-3 0 0 -1.1e-3 0 0 -1e-4"/>)";
  const std::string doubt = doubtOf(unloaded, 5);
  EXPECT_NE(doubt.find("the equilibrium of a step, at t = 1 s first, may be unstable"), std::string::npos) << doubt;
}

/// A tetrahedron of which one or two nodes are held: the axis goes through what is held, and has no round-off in it.
TEST(StaticSolver, ABodyHeldAtANodeOrALineTurnsAboutIt) {
  const auto reason = [](const std::string& held) {
    Simulation simulation = simulationFromText(
        R"(<Node name="root" dt="1" gravity="0 -10 0"><StaticSolver/><SparseLDLSolver/>
           <MechanicalObject name="dofs" position="0 0 0  1 0 0  0 1 0  0 0 1"/>
           <MeshTopology position="@dofs.position" tetrahedra="0 1 2 3"/><UniformMass vertexMass="0.5"/>
           <TetrahedronFEMForceField youngModulus="5e9" poissonRatio="0.3" method="small"/>
           <FixedProjectiveConstraint indices=")" +
        held + R"("/></Node>)");
    return simulation.step().reason;
  };
  // about the line from (0 0 0) to (0 0 1) only the weight of node 1 has a torque, 0.5 kg x 10 m/s^2 x 1 m
  const std::string line = reason("0 3");
  for (const std::string word : {"not held against rotation about the axis (0 0 -1)", "a torque of 5 N m"})
    EXPECT_NE(line.find(word), std::string::npos) << line;
  // about node 0 also that of node 3, about the x axis
  const std::string node = reason("0");
  for (const std::string word : {"not held against rotation about the axis (0.707 0 -0.707) through (0 0 0)", "a torque of 7.07 N m"})
    EXPECT_NE(node.find(word), std::string::npos) << node;
}

/// Corrections of what round-off leaves are not made. Deflections of linear bars are as the inverse of their stiffness.
TEST(StaticSolver, LinearForcesAreSolvedOnceWhereRoundOffIsLeft) {
  const auto sunk = [](double young, int most) {
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="1" gravity="0 -9.81 0"><StaticSolver/><RegularGridTopology name="grid" n="81 5 5" min="0 0 0"
             max="2.8 0.14 0.14"/><MechanicalObject/><UniformMass totalMass="55"/><BoxROI name="b" box="-0.001 -1 -1 0.001 1 1"/>
           <FixedProjectiveConstraint indices="@b.indices"/><Node name="cells"><TetrahedronSetTopologyContainer name="t"/>
             <Hexa2TetraTopologicalMapping input="@../grid" output="@t" cutting="five"/>
             <TetrahedronFEMForceField topology="@t" youngModulus="{}" poissonRatio="0.45" method="small"/></Node></Node>)",
        young));
    const StepReport report = simulation.step();
    EXPECT_TRUE(report.newton_converged && report.linear_converged) << report.reason;
    EXPECT_LE(report.newton_iterations, most) << young;
    const Index end = 80;
    return young * (simulation.states()[0]->rest_position[std::size_t(end)].y() - simulation.states()[0]->x()[end].y());
  };
  const double soft = sunk(1e6, 3);
  EXPECT_NEAR(sunk(1e11, 1), soft, 1e-5 * soft);
}
