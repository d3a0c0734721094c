// SPDX-License-Identifier: LGPL-2.1-or-later
// Bodies with an integrator each that something couples: they move in one system, as the merged body or as closed forms
// say, in time and in statics. Of integrators that are not alike the first moves all; statics beside motions are refused.
#include <fmt/format.h>

#include "tests/constraints/attached_bodies.h"
#include "tools/checks/result_doubts.h"
#include "tools/plan/plan.h"

namespace stroma::test {
namespace {

/// A scene around bodies that bring their own integrators.
std::string scene(const std::string& content, const std::string& gravity = "0 -9.81 0", double dt = 0.01) {
  return fmt::format(R"(<Node name="root" dt="{}" gravity="{}">{}</Node>)", dt, gravity, content);
}

/// A body of points in a node of its own.
std::string pointBody(const std::string& name, const std::string& integrator, const std::string& positions,
                      const std::string& masses, const std::string& more = "") {
  return fmt::format(
      R"(<Node name="{}">{}<MechanicalObject name="dofs" position="{}"/><DiagonalMass vertexMass="{}"/>{}</Node>)",
      name, integrator, positions, masses, more);
}

std::string attachment(const std::string& first, const std::string& second, const std::string& more = "") {
  std::string of_first, of_second;
  for (int jk = 0; jk < 9; ++jk) of_first += fmt::format("{} ", 2 + 3 * jk), of_second += fmt::format("{} ", 3 * jk);
  return fmt::format(
      "<AttachProjectiveConstraint name='{0}_{1}' object1='@{0}/dofs' object2='@{1}/dofs' indices1='{2}' "
      "indices2='{3}' "
      "{4}/>",
      first, second, of_first, of_second, more);
}

/// Every integrator that moves bodies coupled by ties, with a linear solver.
const std::vector<std::string> integrators = {
    "<EulerImplicitSolver/><CGLinearSolver iterations='400' tolerance='1e-13'/>",
    "<EulerImplicitSolver/><SparseLDLSolver/>",
    "<EulerImplicitSolver newtonIterations='20' newtonTolerance='1e-12'/><SparseLDLSolver/>",
    "<NewmarkImplicitSolver/><SparseLDLSolver/>",
    "<BDFOdeSolver/><NewtonRaphsonSolver maxNbIterationsNewton='30' relativeInitialStoppingThreshold='1e-12'/>"
    "<SparseLDLSolver/>",
    "<TrapezoidalRuleSolver/><SparseLDLSolver/>",
    "<NewtonCotesSolver/><SparseLDLSolver/>",
    "<VariationalSymplecticSolver steps='30' newtonError='1e-12'/><SparseLDLSolver/>",
    "<EulerExplicitSolver/>",
    "<RungeKutta2Solver/>",
    "<RungeKutta4Solver/>",
    "<CentralDifferenceSolver/>",
    "<StaticSolver newton_iterations='40'/><SparseLDLSolver/>",
};

std::string typeOf(const std::string& integrator) { return integrator.substr(1, integrator.find_first_of(" /") - 1); }

class CoupledBodies : public ::testing::TestWithParam<std::string> {};

/// Two bodies, and three, against one mesh.
TEST_P(CoupledBodies, MoveAsTheMergedBody) {
  const std::string& integrator = GetParam();
  const int steps = typeOf(integrator) == "StaticSolver" ? 1 : 30;
  for (const int bodies : {2, 3}) {
    SCOPED_TRACE(bodies);
    std::string content =
        block("a", 2, 0, integrator + held("wall")) + block("b", 2, 2, integrator) + attachment("a", "b");
    if (bodies == 3) content += block("c", 2, 4, integrator) + attachment("b", "c");
    Simulation apart = simulationFromText(scene(content));
    Simulation whole = simulationFromText(scene(block("whole", 2 * bodies, 0, integrator + held("wall"))));
    ASSERT_EQ(apart.systems().size(), 1u);
    for (int step = 0; step < steps; ++step) {
      const StepReport report = apart.step();
      ASSERT_FALSE(report.diverged || report.unsolved) << report.reason;
      ASSERT_FALSE(whole.step().diverged);
    }
    const System &coupled = *apart.systems().at(0), &merged = *whole.systems().at(0);
    double moved = 0, largest = 0;
    for (int body = 0; body < bodies; ++body)
      for (int jk = 0; jk < 9; ++jk)
        for (int i = 0; i < 3; ++i) {
          const Index in_coupled = 27 * body + i + 3 * jk, in_merged = i + 2 * body + (2 * bodies + 1) * jk;
          largest = std::max(largest, (coupled.x[in_coupled] - merged.x[in_merged]).norm());
          moved =
              std::max(moved, (merged.x[in_merged] - whole.states()[0]->rest_position[std::size_t(in_merged)]).norm());
        }
    EXPECT_LT(largest, 1e-7 * moved);
    EXPECT_GT(moved, 0.05) << "something happened";
  }
}

/// A spring between two bodies against the same between two nodes of one.
TEST_P(CoupledBodies, ASpringBetweenThemIsThatOfOneBody) {
  const std::string& integrator = GetParam();
  const std::string anchor = "<RestShapeSpringsForceField points='0' stiffness='400'/>";
  const auto spring = [](const std::string& ends, int second) {
    return fmt::format("<SpringForceField {} springsIndices1='0' springsIndices2='{}' lengths='1' stiffness='300' damping='0'/>",
                       ends, second);
  };
  Simulation apart = simulationFromText(scene(pointBody("a", integrator, "0 0 0", "1", anchor) +
                                              pointBody("b", integrator, "0.1 -1.2 0", "3") +
                                              spring("object1='@a/dofs' object2='@b/dofs'", 0)));
  Simulation whole =
      simulationFromText(scene(pointBody("a", integrator, "0 0 0 0.1 -1.2 0", "1 3", anchor + spring("", 1))));
  ASSERT_EQ(apart.systems().size(), 1u);
  for (int step = 0; step < (typeOf(integrator) == "StaticSolver" ? 1 : 30); ++step) {
    const StepReport report = apart.step();
    ASSERT_FALSE(report.diverged || report.unsolved) << report.reason;
    ASSERT_FALSE(whole.step().diverged);
  }
  const System &coupled = *apart.systems().at(0), &merged = *whole.systems().at(0);
  for (const Index i : {0, 1}) EXPECT_LT((coupled.x[i] - merged.x[i]).norm(), 1e-9);
  EXPECT_GT((coupled.x[1] - Vec3(0.1, -1.2, 0)).norm(), 0.01) << "something happened";
}

INSTANTIATE_TEST_SUITE_P(Integrators, CoupledBodies, ::testing::ValuesIn(integrators),
                         [](const auto& tested) { return fmt::format("{}{}", typeOf(tested.param), tested.index); });

/// Two bodies of a node each on a spring.
std::string onASpring(const std::string& first, const std::string& second) {
  return scene("\n" + pointBody("a", first, "0 0 0", "1") + "\n" + pointBody("b", second, "1 0 0", "2") +
               "\n<SpringForceField name='spring' object1='@a/dofs' object2='@b/dofs' springsIndices1='0' "
               "springsIndices2='0' lengths='1' damping='0'/>");
}

TEST(Couplings, OfIntegratorsThatAreNotAlikeTheFirstMovesAllAndThatIsTold) {
  for (const std::string& first : integrators)
    for (const std::string& second : integrators) {
      if ((typeOf(first) == "StaticSolver") != (typeOf(second) == "StaticSolver")) {
        const std::string text = problemsOf(onASpring(first, second));
        expectContains(text, "the force field /spring couples /a/dofs and /b/dofs");
        expectContains(text, "cannot make a common step");
        continue;
      }
      Simulation simulation = simulationFromText(onASpring(first, second));
      ASSERT_EQ(simulation.systems().size(), 1u);
      EXPECT_EQ(simulation.systems()[0]->integrator().path(), "/a/" + typeOf(first));
      const std::string told = simulation.diagnostics().text();
      if (first == second) {
        EXPECT_EQ(told.find(" differ: "), std::string::npos) << told;
        continue;
      }
      expectContains(told, "/a/" + typeOf(first) + " (test.xml:2");
      expectContains(told, "/b/" + typeOf(second) + " (test.xml:3");
      expectContains(told, "/a/" + typeOf(first) + " moves all of them");
    }
}

TEST(Couplings, WhomTheFirstIntegratorMovesIsToldOfEachInAChain) {
  const std::string plain = "<EulerImplicitSolver/><SparseLDLSolver/>";
  const auto spring = [](const std::string& a, const std::string& b) {
    return "\n<SpringForceField name='" + a + b + "' object1='@" + a + "/dofs' object2='@" + b +
           "/dofs' springsIndices1='0' springsIndices2='0' lengths='1' damping='0'/>";
  };
  Simulation simulation = simulationFromText(
      scene(pointBody("a", "<EulerImplicitSolver trapezoidalScheme='1'/><SparseLDLSolver/>", "0 0 0", "1") +
            pointBody("b", plain, "1 0 0", "2") + pointBody("c", plain, "2 0 0", "2") + spring("a", "b") + spring("b", "c")));
  ASSERT_EQ(simulation.systems().size(), 1u);
  const std::string told = simulation.diagnostics().text();
  expectContains(told, "/b/EulerImplicitSolver");
  expectContains(told, "/c/EulerImplicitSolver");
}

TEST(Couplings, BodiesThatAreDampedOtherwiseAreRefused) {
  const std::string solver = "<SparseLDLSolver/>";
  const auto problem = [](const std::string& a, const std::string& b) { return problemsOf(onASpring(a, b)); };
  for (const std::string damping : {"rayleighMass", "rayleighStiffness", "vdamping"}) {
    const std::string text = problem("<EulerImplicitSolver " + damping + "='0.1'/>" + solver, "<EulerImplicitSolver/>" + solver);
    expectContains(text, "/a/EulerImplicitSolver has " + damping + R"(="0.1" and /b/EulerImplicitSolver "0")");
    expectContains(text, damping + " would apply to both");
  }
  const std::string damped = "ImplicitSolver rayleighMass='0.1'/>" + solver;
  EXPECT_EQ(problem("<Euler" + damped, "<Newmark" + damped), "");
  EXPECT_EQ(problem("<EulerImplicitSolver rayleighMass='0'/>" + solver, "<EulerImplicitSolver/>" + solver), "")
      << "a default that is written is the default";
  Simulation simulation = simulationFromText(onASpring("<EulerImplicitSolver/><CGLinearSolver iterations='50'/>",
                                                       "<EulerImplicitSolver/><CGLinearSolver iterations='60'/>"));
  expectContains(simulation.diagnostics().text(), R"(/a/CGLinearSolver has iterations="50" and /b/CGLinearSolver "60")");
}

TEST(Couplings, ExplainTellsWhatMovesTogetherAndWhy) {
  const std::string integrator = "<EulerImplicitSolver name='solver'/><SparseLDLSolver/>";
  const Simulation simulation = simulationFromText(scene(block("a", 2, 0, integrator) + block("b", 2, 2, integrator) +
                                                         attachment("a", "b") + block("far", 2, 9, integrator)));
  ASSERT_EQ(simulation.systems().size(), 2u);
  std::string text;
  for (const std::string& line : planOf(simulation).lines()) text += line + "\n";
  expectContains(text, "system of /a/solver: 54 nodes");
  expectContains(text, "linear solver /b/SparseLDLSolver: skipped, /a/SparseLDLSolver solves for this system");
  expectContains(text, "integrator /b/solver: skipped, its bodies belong to this system because /a_b couples them");
  expectContains(text, "constraint /a_b");
  expectContains(text, "system of /far/solver: 27 nodes");
}

TEST(Couplings, AttributesOfCoupledIntegratorsDoNotChangeAlone) {
  const std::string integrator = "<EulerImplicitSolver name='solver'/><SparseLDLSolver/>";
  Simulation simulation =
      simulationFromText(scene(block("a", 2, 0, integrator) + block("b", 2, 2, integrator) + attachment("a", "b")));
  try {
    simulation.setAttribute("/b/solver", "rayleighMass", "1");
    ADD_FAILURE() << "accepted";
  } catch (const ComponentError& error) {
    expectContains(error.what(), "/a_b couples the bodies of /b/solver and /a/solver");
  }
  // and neither do those of the one that moves both: the scene would be refused when it is loaded again
  EXPECT_THROW(simulation.setAttribute("/a/solver", "rayleighMass", "1000"), ComponentError);
}

/// What the first integrator says holds for all bodies: both fall, and damped both fall slower.
TEST(Couplings, TheFirstIntegratorMovesAllBodies) {
  const auto fall = [](const std::string& damping) {
    const std::string integrator = "<EulerImplicitSolver " + damping + "/><SparseLDLSolver/>";
    Simulation simulation =
        simulationFromText(scene(block("a", 2, 0, integrator) + block("b", 2, 2, integrator) + attachment("a", "b")));
    for (int step = 0; step < 2; ++step) simulation.step();
    return simulation.systems()[0]->v[30].norm();
  };
  EXPECT_LT(fall("rayleighMass='1000'"), 0.5 * fall(""));
}

// ---- closed forms ----

/// Two masses on a spring: the trapezoidal rule turns the phase by 2 atan(w h / 2) per step and damps nothing, whatever the second
/// body has of its own.
TEST(Couplings, TwoMassesOnASpring) {
  const std::string integrator = "<EulerImplicitSolver trapezoidalScheme='1'/><SparseLDLSolver/>";
  const double h = 0.02, k = 300, m1 = 1, m2 = 3, length = 1, start = 1.2;
  for (const std::string& second : {integrator, std::string("<RungeKutta4Solver/>")}) {
    Simulation simulation = simulationFromText(
        scene(pointBody("a", integrator, "0 0 0", "1") + pointBody("b", second, "1.2 0 0", "3") +
                  "<SpringForceField object1='@a/dofs' object2='@b/dofs' springsIndices1='0' springsIndices2='0' "
                  "lengths='1' stiffness='300' damping='0'/>",
              "0 0 0", h));
    const System& system = *simulation.systems().at(0);
    const double turn = 2 * std::atan(std::sqrt(k * (1 / m1 + 1 / m2)) * h / 2);
    for (int step = 1; step <= 200; ++step) {
      simulation.step();
      EXPECT_NEAR(system.x[1].x() - system.x[0].x(), length + (start - length) * std::cos(step * turn), 1e-10);
      EXPECT_NEAR(m1 * system.x[0].x() + m2 * system.x[1].x(), m2 * start, 1e-12) << "the centre of mass";
    }
  }
}

/// Springs of no length hang one below the other, each under the weight of all below it.
TEST(Couplings, ThreeBodiesHangInEquilibrium) {
  const std::string integrator = "<StaticSolver/><SparseLDLSolver/>", g = "0 -10 0";
  const auto spring = [](const std::string& first, int of_first, const std::string& second, double stiffness) {
    return fmt::format(
        "<SpringForceField object1='@{}/dofs' object2='@{}/dofs' springsIndices1='{}' springsIndices2='0' lengths='0' "
        "stiffness='{}'/>",
        first, second, of_first, stiffness);
  };
  Simulation simulation = simulationFromText(scene(
      pointBody("a", integrator, "0 0 0 0 -1 0", "1 1",
                "<FixedProjectiveConstraint indices='0'/><SpringForceField springsIndices1='0' springsIndices2='1' "
                "lengths='0' stiffness='100'/>") +
          pointBody("b", integrator, "0 -2 0", "2") + pointBody("c", integrator, "0 -3 0", "4") +
          spring("a", 1, "b", 200) + spring("b", 0, "c", 50),
      g));
  const StepReport report = simulation.step();
  ASSERT_FALSE(report.diverged || report.unsolved) << report.reason;
  const System& system = *simulation.systems().at(0);
  const double a = -(1 + 2 + 4) * 10. / 100, b = a - (2 + 4) * 10. / 200, c = b - 4 * 10. / 50;
  EXPECT_NEAR(system.x[1].y(), a, 1e-9);
  EXPECT_NEAR(system.x[2].y(), b, 1e-9);
  EXPECT_NEAR(system.x[3].y(), c, 1e-9);
}

/// u of the second body is twice that of the first.
TEST(Couplings, LinearRelationsBetweenBodies) {
  const std::string relation =
      "<LinearRelationProjectiveConstraint object1='@a/dofs' object2='@b/dofs' indices='0' coefficients='2' "
      "indices2='0' coefficients2='-1'/><ConstantForceField mstate='@b/dofs' indices='0' forces='6 0 0'/>";
  const double h = 0.1;
  for (const char* integrator : {"<EulerImplicitSolver/><SparseLDLSolver/>", "<EulerExplicitSolver/>"}) {
    Simulation simulation = simulationFromText(scene(
        pointBody("a", integrator, "0 0 0", "1") + pointBody("b", integrator, "5 0 0", "2") + relation, "0 0 0", h));
    simulation.step();
    const System& system = *simulation.systems().at(0);
    // (m_a + 4 m_b) dv_a = 2 h F
    EXPECT_NEAR(system.v[0].x(), 2 * h * 6 / (1 + 4 * 2), 1e-12) << integrator;
    EXPECT_NEAR(system.v[1].x(), 2 * system.v[0].x(), 1e-12);
  }
  const std::string integrator = "<StaticSolver/><SparseLDLSolver/>";
  const auto anchored = [](double stiffness) {
    return fmt::format("<RestShapeSpringsForceField points='0' stiffness='{}'/>", stiffness);
  };
  Simulation simulation =
      simulationFromText(scene(pointBody("a", integrator, "0 0 0", "1", anchored(100)) +
                                   pointBody("b", integrator, "5 0 0", "2", anchored(50)) + relation,
                               "0 0 0", h));
  ASSERT_FALSE(simulation.step().unsolved);
  // k_a u_a^2 / 2 + k_b (2 u_a)^2 / 2 - 2 F u_a is least
  EXPECT_NEAR(simulation.systems()[0]->x[0].x(), 2 * 6. / (100 + 4 * 50), 1e-10);
}

/// A skin that follows a body, with or without an integrator of its own: what acts on it acts on the body.
TEST(Couplings, MappingsBetweenBodies) {
  const double h = 0.1, stiffness = 50;
  const auto pulledSkin = [](const std::string& integrator) {
    return fmt::format(R"(<Node name="skin">{}<MechanicalObject name="dofs" position="1 0 0"/>
        <SubsetMapping input="@/a/dofs" output="@dofs" indices="1"/>
        <ConstantForceField indices="0" forces="8 0 0"/></Node>)",
                       integrator);
  };
  for (const std::string own : {"", "<StaticSolver/><SparseLDLSolver/>"}) {
    Simulation still = simulationFromText(
        scene(pointBody("a", "<StaticSolver/><SparseLDLSolver/>", "0 0 0 1 0 0", "2 4",
                        fmt::format("<RestShapeSpringsForceField points='0 1' stiffness='{}'/>", stiffness)) +
                  pulledSkin(own),
              "0 0 0", h));
    ASSERT_FALSE(still.step().unsolved);
    const System& system = *still.systems().at(0);
    for (const Index i : {1, 2}) EXPECT_NEAR(system.x[i].x(), 1 + 8 / stiffness, 1e-10);
  }
  for (const char* integrator : {"<EulerImplicitSolver/><SparseLDLSolver/>", "<EulerExplicitSolver/>"})
    for (const bool own : {false, true}) {
      Simulation simulation = simulationFromText(
          scene(pointBody("a", integrator, "0 0 0 1 0 0", "2 4") + pulledSkin(own ? integrator : ""), "0 0 0", h));
      ASSERT_EQ(simulation.systems().size(), 1u);
      simulation.step();
      const System& system = *simulation.systems().at(0);
      EXPECT_EQ(Vec3(system.v[0]), Vec3::Zero());
      EXPECT_NEAR(system.v[1].x(), h * 8 / 4, 1e-12);
      EXPECT_EQ(Vec3(system.x[1]), Vec3(system.x[2]));
    }
}

TEST(Couplings, WhatIsTiedToSomethingThatNothingMovesIsRefused) {
  const std::string marker = "<Node name='marker'><MechanicalObject name='dofs' position='0 0 0'/></Node>";
  const std::string body = pointBody("a", "<EulerExplicitSolver/>", "1 0 0", "1");
  const std::string spring =
      "<SpringForceField name='spring' object1='@{}/dofs' object2='@{}/dofs' springsIndices1='0' springsIndices2='0' "
      "lengths='1'/>";
  for (const auto& [first, second] : {std::pair("a", "marker"), std::pair("marker", "a")})
    expectContains(problemsOf(scene(marker + body + fmt::format(fmt::runtime(spring), first, second))),
                   "the force field /spring acts on /marker/dofs, which no integrator moves");
}

TEST(Couplings, SolversThatNoIntegratorUsesAreRefused) {
  expectContains(
      problemsOf(scene("<SparseLDLSolver name='solver'/>" + pointBody("a", "<EulerImplicitSolver/>", "1 0 0", "1"))),
      "no integrator uses the linear solver /solver: /a/EulerImplicitSolver uses the one in its own node");
  EXPECT_EQ(problemsOf(scene("<SparseLDLSolver name='solver'/>" +
                             pointBody("a", "<EulerImplicitSolver linearSolver='@/solver'/>", "1 0 0", "1"))),
            "");
}

// ---- statics of attached bodies ----

/// A column of two blocks of 1 m^2 on the floor, of cells that have no lateral strain: linear, and exact at its nodes.
struct Column {
  double lower = 2, upper = 3, young = 2e5, density = 1000, gravity = 10;
  std::string body(const std::string& name, double from, double height, const std::string& more) const {
    return fmt::format(R"(<Node name="{}"><RegularGridTopology name="grid" n="2 {} 2" min="0 {} 0" max="1 {} 1"/>
      <MechanicalObject name="dofs"/><DiagonalMass massDensity="{}"/>
      <HexahedronFEMForceField youngModulus="{}" poissonRatio="0" method="small"/>{}</Node>)",
                       name, int(height) + 1, from, from + height, density, young, more);
  }
  /// Nodes of a level of a body: x fastest, then y, then z.
  std::string level(int height, int j) const {
    const int layer = 2 * (height + 1);
    return fmt::format("{} {} {} {}", 2 * j, 2 * j + 1, layer + 2 * j, layer + 2 * j + 1);
  }
  std::string scene(const std::string& solver, const std::string& each, const std::string& attachment) const {
    return fmt::format(
        R"(<Node name="root" dt="1" gravity="0 {} 0">{}{}{}<AttachProjectiveConstraint name="glue"
        object1="@lower/dofs" object2="@upper/dofs"
        indices1="{}" indices2="{}" {}/></Node>)",
        -gravity, solver,
        body("lower", 0, lower, each + "<FixedProjectiveConstraint indices='" + level(int(lower), 0) + "'/>"),
        body("upper", lower, upper, each), level(int(lower), int(lower)), level(int(upper), 0), attachment);
  }
  double interface(const Simulation& simulation) const {
    return lower - simulation.systems().at(0)->x[2 * Index(lower)].y();
  }
};

TEST(AttachedStatics, TheInterfaceSinksUnderTheWholeWeight) {
  const Column column;
  const std::string solver = "<StaticSolver/><SparseLDLSolver/>";
  const double own = column.density * column.gravity / column.young * column.lower * column.lower / 2;
  const double whole = own + column.density * column.gravity / column.young * column.lower * column.upper;
  for (const char* attachment : {"", "twoWay='true'"})
    for (const bool one_integrator : {true, false}) {
      Simulation simulation =
          simulationFromText(column.scene(one_integrator ? solver : "", one_integrator ? "" : solver, attachment));
      const StepReport report = simulation.step();
      ASSERT_FALSE(report.diverged || report.unsolved) << report.reason;
      EXPECT_NEAR(column.interface(simulation), whole, 1e-8 * whole);
      EXPECT_TRUE(doubtsOf(simulation).empty());
    }
}

TEST(AttachedStatics, WhatOneWayLeavesOutIsSaid) {
  const Column column;
  const std::string statics = "<StaticSolver/><SparseLDLSolver/>";
  const double own = column.density * column.gravity / column.young * column.lower * column.lower / 2;
  Simulation simulation = simulationFromText(column.scene(statics, "", "twoWay='false'"));
  expectContains(simulation.scene().diagnostics.text(), "/lower/dofs is not affected by the nodes that follow it");
  ASSERT_FALSE(simulation.step().unsolved);
  EXPECT_NEAR(column.interface(simulation), own, 1e-8 * own);
  // 3 m^3 of 1000 kg/m^3 under 10 m/s^2
  ASSERT_EQ(doubtsOf(simulation).size(), 1u);
  expectContains(doubtsOf(simulation)[0], "/glue at t = 1 s: the following nodes pull with (");
  expectContains(doubtsOf(simulation)[0], "in sum 3e+04 N, which is not transmitted to the nodes that they follow");
  // in time, at rest: the same
  Simulation moving = simulationFromText(
      column.scene("<EulerImplicitSolver rayleighMass='5'/><SparseLDLSolver/>", "", "twoWay='false'"));
  for (int step = 0; step < 200; ++step) moving.step();
  ASSERT_EQ(doubtsOf(moving).size(), 1u);
  expectContains(doubtsOf(moving)[0], "in sum 3e+04 N");
  expectContains(simulationFromText(column.scene(statics, "", "")).scene().diagnostics.text(),
                 "twoWay is not given: both ends act on each other");
}

TEST(AttachedStatics, WhatIsNotHeldIsFoundInTheCoupledSystem) {
  const std::string integrator = "<StaticSolver/><SparseLDLSolver/>";
  const auto reason = [](const std::string& text) {
    Simulation simulation = simulationFromText(text);
    const StepReport report = simulation.step();
    EXPECT_TRUE(report.diverged);
    return report.reason;
  };
  const std::string two = block("a", 2, 0, integrator) + block("b", 2, 2, integrator) + attachment("a", "b");
  expectContains(reason(scene(two)), "with what is tied to it is not held in the direction (");
  const double weight = 10 * 16 * 9.81;
  expectContains(reason(scene(two)), fmt::format("sum to {:.3g} N", weight));
  // at one node it turns about that; its centre of mass is 1 m beside it
  const std::string hinge =
      block("a", 2, 0, integrator + held("wall")) + block("b", 2, 2, integrator) +
      "<AttachProjectiveConstraint object1='@a/dofs' object2='@b/dofs' indices1='14' indices2='12'/>";
  const std::string hinged = reason(scene(hinge));
  expectContains(hinged, "/b/dofs is not held against rotation about the axis (");
  expectContains(hinged, "through (2 1 1)");
  expectContains(hinged, fmt::format("torque of {:.3g} N m", weight / 2 * 1));
}

}  // namespace
}  // namespace stroma::test
