// SPDX-License-Identifier: LGPL-2.1-or-later
// Rules of second order make as many linear solves as their order needs, where a scene does not say how many.
#include <fmt/format.h>

#include <cmath>

#include "tests/support/scene_fixture.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A cantilever that falls by a third of its length and swings for ever.
std::string cantilever(const std::string& integrator, const std::string& field, double dt) {
  const std::string cells = field.starts_with("Tetra")
                                ? R"(<TetrahedronSetTopologyContainer name="tets"/><Hexa2TetraTopologicalMapping input="@../grid"
  output="@tets" swapping="true"/>)"
                                : std::string();
  return fmt::format(
      R"(<Node name="root" dt="{}" gravity="0 0 -9.81"><{}/><SparseLDLSolver/><RegularGridTopology name="grid" n="6 2 2"
  min="0 0 0" max="0.1 0.02 0.02"/><Node name="b">{}<MechanicalObject/><DiagonalMass massDensity="1000"/><{}
  youngModulus="2e4" poissonRatio="0.3"/><BoxROI name="wall" box="-1 -1 -1 1e-6 1 1"/><FixedProjectiveConstraint
  indices="@wall.indices"/></Node></Node>)",
      dt, integrator, cells, field);
}

double energyOf(const Simulation& simulation) {
  const System& system = *simulation.systems()[0];
  return system.kineticEnergy() + system.potentialEnergy(system.x);
}

void advance(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.failed()) << report.reason;
    ASSERT_TRUE(report.newton_converged) << report.reason;
  }
}

/// Where it is after 0.16 s, near the lowest point of its first swing.
std::vector<Vec3> placeAfterAWhile(const std::string& integrator, const std::string& field, int steps) {
  Simulation simulation = simulationFromText(cantilever(integrator, field, 0.16 / steps));
  advance(simulation, steps);
  const ConstRows x = simulation.systems()[0]->x;
  std::vector<Vec3> place;
  for (Index i = 0; i < x.count; ++i) place.push_back(x[i]);
  return place;
}

double largestDifference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

double order(const std::string& integrator, const std::string& field, const std::vector<Vec3>& exact) {
  const double coarse = largestDifference(placeAfterAWhile(integrator, field, 160), exact);
  const double fine = largestDifference(placeAfterAWhile(integrator, field, 320), exact);
  return std::log2(coarse / fine);
}

std::string planOf(const std::string& integrator, const std::string& field) {
  return simulationFromText(cantilever(integrator, field, 0.01)).systems()[0]->integrator().describe();
}

const std::vector<std::string> cells{"TetrahedronFEMForceField", "HexahedronFEMForceField"};
const std::vector<std::string> rules{"EulerImplicitSolver trapezoidalScheme='true'", "TrapezoidalRuleSolver",
                                     "NewmarkImplicitSolver", "BDFOdeSolver order='2'"};

/// Against the classical Runge-Kutta method with steps a twentieth of theirs. One solve by the scene's word is of first order.
TEST(NeededSolves, RotatedElementsHaveTheOrderOfTheRule) {
  for (const std::string& cell : cells)
    for (const std::string method : {"polar", "large", "svd"}) {
      const std::string field = cell + " method='" + method + "'";
      const std::vector<Vec3> exact = placeAfterAWhile("RungeKutta4Solver", field, 8000);
      for (const std::string& rule : rules) {
        EXPECT_NEAR(order(rule, field, exact), 2, 0.25) << rule << ", " << field;
        EXPECT_NEAR(order(rule + " newtonIterations='1'", field, exact), 1, 0.1) << rule << ", " << field;
      }
    }
}

/// K(x0) in the damping of a hyperelastic body takes the order of a rule too.
TEST(NeededSolves, RayleighDampingOfAStiffnessThatChanges) {
  const std::string field = "TetrahedronHyperelasticityFEMForceField materialName='NeoHookean'";
  const std::string rule = "TrapezoidalRuleSolver rayleighStiffness='0.01'";
  const std::vector<Vec3> exact = placeAfterAWhile(rule + " newtonIterations='30' newtonTolerance='1e-12'", field, 2000);
  EXPECT_GT(order(rule, field, exact), 1.8);
  EXPECT_NEAR(order(rule + " newtonIterations='1'", field, exact), 1, 0.25);
}

/// Centres and axes of the frame of a scene after 0.4 s.
std::vector<Vec3> frameAfterAWhile(const std::string& rule, const std::string& beside, const std::string& on, int steps) {
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="{}" gravity="0 0 -9.81"><{}/><SparseLDLSolver/>{}<Node name="r"><MechanicalObject template="Rigid3"
  position="0 0 0 0 0 0 1" velocity="0 0 0 1 2 0.5"/><UniformMass totalMass="1" inertia="0.02 0.03 0.04"/>{}</Node></Node>)",
      0.4 / steps, rule, beside, on));
  advance(simulation, steps);
  std::vector<Vec3> place;
  for (const State* state : simulation.states())
    for (Index i = 0; state->hasFrames() && i < state->size(); ++i) place.push_back(state->x()[i]);
  return place;
}

/// A body turns freely beside a soft one, and a body turns on springs at its frame or at points that it carries.
TEST(NeededSolves, RigidBodiesHaveTheOrderOfTheRule) {
  const std::string soft = R"(<Node name="b"><RegularGridTopology n="3 2 2" min="0 0 0" max="0.1 0.02 0.02"/><MechanicalObject/>
  <DiagonalMass massDensity="1000"/><HexahedronFEMForceField method="polar" youngModulus="2e4" poissonRatio="0.3"/><BoxROI
  name="wall" box="-1 -1 -1 1e-6 1 1"/><FixedProjectiveConstraint indices="@wall.indices"/></Node>)";
  const std::string spring = "<RestShapeSpringsForceField stiffness='30'/>";
  const std::string points = "<Node name='p'><MechanicalObject position='0.3 0 0  0 0.3 0  0 0 0.3'/><RigidMapping/>" + spring + "</Node>";
  struct Scene {
    std::string beside, on;
  };
  for (const std::string& rule : rules)
    for (const Scene& scene : {Scene{soft, ""}, Scene{"", spring}, Scene{"", points}}) {
      const auto place = [&](const std::string& with, int steps) { return frameAfterAWhile(with, scene.beside, scene.on, steps); };
      // alone a free body needs no more than one solve, and Newton's tolerance would be one of the soft body's weight
      const std::string once = " newtonIterations='1'", to_the_end = " newtonIterations='30' newtonTolerance='1e-13'";
      const std::vector<Vec3> exact = scene.on.empty() ? frameAfterAWhile(rule + once, "", "", 2560) : place(rule + to_the_end, 2560);
      const double coarse = largestDifference(place(rule, 80), exact), fine = largestDifference(place(rule, 160), exact);
      EXPECT_NEAR(std::log2(coarse / fine), 2, 0.25) << rule << ": " << scene.beside << scene.on;
    }
}

/// Masses at points that a body carries, two and two across its centre, are a part of its inertia. Against the same body in one piece
/// by the classical Runge-Kutta method: its own inertia may be the same about all axes, or not, or turn alone.
TEST(NeededSolves, MassesThatABodyCarriesKeepTheOrderOfTheRule) {
  const auto scene = [](const std::string& rule, const std::string& inertia, const std::string& more, int steps) {
    return fmt::format(
        R"(<Node name="root" dt="{}" gravity="0 0 0"><{}/><SparseLDLSolver/><Node name="r"><MechanicalObject template="Rigid3"
  position="0 0 0 0 0 0 1" velocity="0 0 0 1 2 3"/><UniformMass totalMass="1" inertia="{}"/>{}</Node></Node>)",
        0.4 / steps, rule, inertia, more);
  };
  const std::string carried =
      "<Node name='p'><MechanicalObject position='0.3 0 0  -0.3 0 0  0 0.2 0  0 -0.2 0'/><RigidMapping/><UniformMass "
      "totalMass='0.8'/></Node>";  // 0.2 kg each: 0.016, 0.036 and 0.052 kg m^2
  const auto place = [](const std::string& text, int steps) {
    Simulation simulation = simulationFromText(text);
    advance(simulation, steps);
    return std::vector<Vec3>{simulation.states()[0]->x()[0], simulation.states()[0]->x()[1]};
  };
  const std::pair<const char*, const char*> inertias[] = {{"0.2 0.2 0.2", "0.216 0.236 0.252"}, {"0.1 0.2 0.3", "0.116 0.236 0.352"}};
  std::vector<std::string> all = rules;
  all.emplace_back("VariationalSymplecticSolver");
  all.emplace_back("TrapezoidalRuleSolver newtonIterations='30' newtonTolerance='1e-12'");
  for (const auto& [own, whole] : inertias) {
    const std::vector<Vec3> exact = place(scene("RungeKutta4Solver", whole, "", 800), 800);
    for (const std::string& rule : all) {
      const double coarse = largestDifference(place(scene(rule, own, carried, 100), 100), exact);
      const double fine = largestDifference(place(scene(rule, own, carried, 200), 200), exact);
      EXPECT_NEAR(std::log2(coarse / fine), 2, 0.2) << rule << ", " << own;
      EXPECT_LT(fine, 1e-4) << rule << ", " << own;
    }
    for (const std::string rule :
         {"EulerImplicitSolver", "BDFOdeSolver", "TrapezoidalRuleSolver newtonIterations='1'", "EulerExplicitSolver",
          "VariationalSymplecticSolver explicitIntegration='true'", "CentralDifferenceSolver"}) {
      const double coarse = largestDifference(place(scene(rule, own, carried, 100), 100), exact);
      const double fine = largestDifference(place(scene(rule, own, carried, 200), 200), exact);
      EXPECT_NEAR(std::log2(coarse / fine), 1, 0.15) << rule << ", " << own;
    }
  }
}

/// Two bodies at one place that forces of constraint join, against one with the sum of their inertias.
TEST(NeededSolves, BodiesThatAConstraintJoinsKeepTheOrderOfTheRule) {
  const auto body = [](const char* name, const char* inertia) {
    return fmt::format(R"(<Node name="{}"><MechanicalObject name="d" template="Rigid3" position="0 0 0 0 0 0 1" velocity="0 0 0 1 2 3"/>
  <UniformMass totalMass="1" inertia="{}"/></Node>)",
                       name, inertia);
  };
  const auto place = [](const std::string& rule, const std::string& bodies, int steps) {
    Simulation simulation = simulationFromText(
        fmt::format("<Node name='root' dt='{}' gravity='0 0 0'><{}/><SparseLDLSolver/>{}</Node>", 0.4 / steps, rule, bodies));
    advance(simulation, steps);
    return std::vector<Vec3>{simulation.states()[0]->x()[1]};
  };
  const std::vector<Vec3> exact = place("RungeKutta4Solver", body("a", "0.15 0.22 0.34"), 800);
  const std::string two = body("a", "0.1 0.2 0.3") + body("b", "0.05 0.02 0.04") +
                          "<BilateralLagrangianConstraint object1='@a/d' object2='@b/d' first_point='0' second_point='0'/>";
  for (const std::string rule : {"TrapezoidalRuleSolver", "EulerImplicitSolver trapezoidalScheme='true'", "BDFOdeSolver order='2'"}) {
    const double coarse = largestDifference(place(rule, two, 100), exact), fine = largestDifference(place(rule, two, 200), exact);
    EXPECT_NEAR(std::log2(coarse / fine), 2, 0.2) << rule;
  }
}

/// What round-off moves has gained nothing.
TEST(NeededSolves, ABodyAtRestIsNoDoubt) {
  std::string text = cantilever("TrapezoidalRuleSolver newtonIterations='1'", "HexahedronFEMForceField method='polar'", 0.004);
  text.replace(text.find("0 0 -9.81"), 9, "0 0 0");
  Simulation simulation = simulationFromText(text);
  advance(simulation, 40);
  EXPECT_EQ(simulation.systems()[0]->integrator().doubt(), "");
}

TEST(NeededSolves, ThePlanSaysHowManyAndWhy) {
  const std::string polar = "HexahedronFEMForceField name='fem' method='polar'";
  for (const std::string& rule : rules) {
    expectContains(planOf(rule, polar), "2 linear solves");
    expectContains(planOf(rule, polar), "/b/fem is not the exact derivative");
    for (const std::string exact : {"HexahedronFEMForceField method='small'", "HexahedronFEMForceField method='green'",
                                    "TetrahedronFEMForceField method='svd' tangent='exact'",
                                    "TetrahedronHyperelasticityFEMForceField materialName='NeoHookean'"})
      expectContains(planOf(rule, exact), exact.find("small") != std::string::npos || rule == "BDFOdeSolver order='2'"
                                              ? "linearised once"
                                              : "2 linear solves: with one the rule might, at large steps, gain energy");
    expectContains(planOf(rule + " newtonIterations='1'", polar), "linearised once");
    expectContains(planOf(rule + " newtonIterations='7'", polar), "up to 7 Newton iterations");
  }
  // of first order with any number
  for (const std::string rule : {"EulerImplicitSolver", "BDFOdeSolver", "NewmarkImplicitSolver gamma='0.7' beta='0.4'"})
    expectContains(planOf(rule, polar), "linearised once");
}

/// A body that swings undamped for 2500 steps has the energy that it began with, or less; with one solve by the scene's word it
/// gains so much that the run says so.
TEST(NeededSolves, AnUndampedSwingGainsNoEnergy) {
  for (const std::string& cell : cells)
    for (const std::string rule : {"TrapezoidalRuleSolver", "NewmarkImplicitSolver"}) {
      const std::string field = cell + " name='fem' method='polar'";
      Simulation simulation = simulationFromText(cantilever(rule, field, 0.004));
      const double start = energyOf(simulation), swing = 0.014;  // J, of its weight on the way down
      for (int part = 0; part < 25; ++part) {
        advance(simulation, 100);
        ASSERT_LT(energyOf(simulation) - start, 0.001 * swing) << rule << ", " << field << ", " << simulation.time();
        ASSERT_GT(energyOf(simulation) - start, -0.15 * swing) << rule << ", " << field << ", " << simulation.time();
      }
      EXPECT_EQ(simulation.systems()[0]->integrator().doubt(), "");

      Simulation once = simulationFromText(cantilever(rule + " newtonIterations='1'", field, 0.004));
      advance(once, 250);
      EXPECT_GT(energyOf(once) - start, 0.05 * swing) << "the test tests nothing";
      for (const std::string& word : {"/" + rule + " has gained ", std::string("newtonIterations=\"1\""), std::string("/b/fem")})
        expectContains(once.systems()[0]->integrator().doubt(), word);
    }
}

/// What lifts and drives a body may give it energy.
TEST(NeededSolves, WorkThatIsDoneIsNoDoubt) {
  std::string text = cantilever("TrapezoidalRuleSolver newtonIterations='1'", "HexahedronFEMForceField method='polar'", 0.004);
  text.replace(text.find("</Node></Node>"), 0,
               "<LinearForceField indices='23' times='0 0.1' forces='0 0 0  0 0 3'/>");
  Simulation simulation = simulationFromText(text);
  advance(simulation, 50);
  EXPECT_EQ(simulation.systems()[0]->integrator().doubt(), "");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
