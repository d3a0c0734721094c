// SPDX-License-Identifier: LGPL-2.1-or-later
// Newton's method on every law: quadratic convergence, the incompressible limit, a bar twisted by half a turn, a block
// pressed to 30 % of its height, and the report of an element that a law cannot pass through.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "components/hyperelasticity/hyperelastic_force_field.h"
#include "tests/hyperelasticity/law_cases.h"
#include "tests/support/newton_history.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A bar along x of n cells and of length n, held at its left end, or at both.
std::string bar(const std::string& law, const std::string& integrator, double mass, int n = 8, bool both = false,
                const std::string& constraints = "") {
  return fmt::format(
      R"(<Node name="root" dt="0.02" gravity="0 -9.81 0">{0}<SparseLDLSolver/>
  <RegularGridTopology name="grid" n="{1} 3 3" min="0 0 0" max="{2} 0.05 0.05"/>
  <MechanicalObject name="dofs"/><UniformMass totalMass="{3}"/>
  <BoxROI name="end" box="-0.001 -1 -1 0.001 1 1" position="@dofs.rest_position"/>
  <BoxROI name="other" box="{4} -1 -1 9 1 1" position="@dofs.rest_position"/>
  <FixedProjectiveConstraint indices="@end.indices"/>{5}
  <Node name="cells"><TetrahedronSetTopologyContainer name="tets"/>
    <Hexa2TetraTopologicalMapping input="@../grid" output="@tets" swapping="true"/>
    <TetrahedronHyperelasticityFEMForceField mstate="@../dofs" topology="@tets" {6}/></Node></Node>)",
      integrator, n + 1, 0.025 * n, mass, 0.025 * n - 0.001,
      both ? "<FixedProjectiveConstraint indices=\"@other.indices\"/>" : constraints, law);
}

const std::string statics = "<StaticSolver newton_iterations='60' relative_residual_tolerance_threshold='1e-12'/>";

TEST(HyperelasticNewton, StaticsConvergeQuadratically) {
  for (const LawCase& law : lawCases()) {
    SCOPED_TRACE(law.name);
    Simulation simulation = simulationFromText(bar(law.attributes, statics, 0.02));
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.newton_converged) << report.reason;
    expectQuadratic(residuals(simulation), law.name + " static");
    double lowest = 0;
    for (Index i = 0; i < simulation.systems()[0]->x.count(); ++i)
      lowest = std::min(lowest, simulation.systems()[0]->x[i][1]);
    EXPECT_LT(lowest, -0.01) << "nothing large was tested";
  }
}

TEST(HyperelasticNewton, ImplicitStepsConvergeQuadratically) {
  for (const LawCase& law : lawCases()) {
    SCOPED_TRACE(law.name);
    Simulation simulation = simulationFromText(
        bar(law.attributes, "<EulerImplicitSolver newtonIterations='30' newtonTolerance='1e-12'/>", 0.1));
    StepReport report;
    for (int step = 0; step < 4; ++step) {
      report = simulation.step();
      ASSERT_FALSE(report.diverged) << report.reason;
      EXPECT_TRUE(report.newton_converged) << report.reason;
    }
    EXPECT_LE(report.newton_iterations, 8);
    expectQuadratic(residuals(simulation), law.name + " step");
  }
}

TEST(HyperelasticNewton, BarTwistedByHalfATurn) {
  for (const LawCase& law : lawCases()) {
    SCOPED_TRACE(law.name);
    Simulation simulation = simulationFromText(bar(law.attributes, statics, 1e-9, 8, true));
    System& system = *simulation.systems()[0];
    const auto& rest = simulation.states()[0]->rest_position;
    for (std::size_t i = 0; i < rest.size(); ++i) {  // ends turned by half a turn, between them in proportion
      const double angle = std::numbers::pi * rest[i].x() / 0.2, y = rest[i].y() - 0.025, z = rest[i].z() - 0.025;
      system.x[Index(i)] = Vec3(rest[i].x(), 0.025 + std::cos(angle) * y - std::sin(angle) * z,
                                0.025 + std::sin(angle) * y + std::cos(angle) * z);
    }
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.newton_converged) << report.reason;
    expectQuadratic(residuals(simulation), law.name + " twisted");
    std::vector<double> j;
    system.forceFields()[0]->cellField("J", system.x, j);
    if (law.name != "StVenantKirchhoff") {  // which folds elements up: it has no energy against that
      EXPECT_GT(*std::min_element(j.begin(), j.end()), 0.2);
    }
  }
}

/// The upper face comes down to 30 % in 35 steps; faces glued. StVenantKirchhoff collapses under pressure by its law. With
/// the dilatation of the points: its mean alone does not resist that single points turn inside out.
TEST(HyperelasticNewton, BlockPressedToThirtyPercent) {
  for (const LawCase& law : lawCases()) {
    if (law.name == "StVenantKirchhoff") continue;
    SCOPED_TRACE(law.name);
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver newton_iterations="100"/><SparseLDLSolver/>
  <RegularGridTopology name="grid" n="4 4 4" min="0 0 0" max="0.1 0.1 0.1"/>
  <MechanicalObject name="dofs"/><UniformMass totalMass="1"/>
  <BoxROI name="low" box="-1 -1 -0.001 1 1 0.001" position="@dofs.rest_position"/>
  <BoxROI name="high" box="-1 -1 0.099 1 1 1" position="@dofs.rest_position"/>
  <FixedProjectiveConstraint indices="@low.indices"/>
  <LinearMovementProjectiveConstraint indices="@high.indices" keyTimes="0 35" movements="0 0 0 0 0 -0.07" outside="hold"/>
  <HexahedronHyperelasticityFEMForceField {} projectedTangent="true" dilatation="local"/></Node>)",
        law.attributes));
    StepReport report;
    int iterations = 0;
    for (int step = 0; step < 35; ++step) {
      report = simulation.step();
      ASSERT_FALSE(report.diverged) << step << ": " << report.reason;
      ASSERT_TRUE(report.newton_converged) << step << ": " << report.reason;
      iterations += report.newton_iterations;
    }
    const System& system = *simulation.systems()[0];
    std::vector<double> j;
    system.forceFields()[0]->cellField("J", system.x, j);
    std::printf("%-22s %d Newton iterations, smallest J %.2f\n", law.name.c_str(), iterations,
                *std::min_element(j.begin(), j.end()));
    EXPECT_GT(*std::min_element(j.begin(), j.end()), law.finite ? -0.1 : 0) << "corners of the glued faces";
    double highest = 0;
    for (Index i = 0; i < system.x.count(); ++i) highest = std::max(highest, system.x[i].z());
    EXPECT_NEAR(highest, 0.03, 0.02);
  }
}

/// A dead load draws a bar of rubber, nu = 0.4998, to nearly its double in one step. The iterates' volumes are off by less
/// than a percent, which is a pressure of a hundred times the stress: the tangent there has unstable directions.
TEST(HyperelasticNewton, RubberIsDrawnFarInOneStep) {
  for (const std::string dilatation : {"mean", "local"}) {
    SCOPED_TRACE(dilatation);
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/>
  <RegularGridTopology name="grid" n="9 5 5" min="0 0 0" max="0.1 0.01 0.01"/><MechanicalObject name="dofs"/>
  <HexahedronHyperelasticityFEMForceField materialName="MooneyRivlin" c1="5000" c2="2000" k0="3.5e7" dilatation="{}"/>
  <BoxROI name="x0" box="-1 -1 -1 1e-6 1 1"/><PartialFixedProjectiveConstraint indices="@x0.indices" fixedDirections="1 0 0"/>
  <BoxROI name="y0" box="-1 -1 -1 1 1e-6 1"/><PartialFixedProjectiveConstraint indices="@y0.indices" fixedDirections="0 1 0"/>
  <BoxROI name="z0" box="-1 -1 -1 1 1 1e-6"/><PartialFixedProjectiveConstraint indices="@z0.indices" fixedDirections="0 0 1"/>
  <SurfaceTractionForceField area="rest" traction="20000 0 0" min="0.0999 -1 -1" max="0.1001 1 1"/></Node>)",
        dilatation));
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.newton_converged) << report.reason;
    EXPECT_EQ(report.load_parts, 1);
    EXPECT_LT(report.newton_iterations, 60);
    double farthest = 0;
    const System& system = *simulation.systems()[0];
    for (Index i = 0; i < system.x.count(); ++i) farthest = std::max(farthest, system.x[i].x());
    // incompressible: 2 (l - l^-2) (c1 + c2 / l) = 20 kPa
    EXPECT_NEAR(farthest, 0.192568, 1e-4);
  }
}

/// A law with ln J names the element; one that is finite passes through and comes back.
TEST(HyperelasticNewton, InvertedElementsAreNamedOrRecover) {
  for (const LawCase& law : lawCases()) {
    SCOPED_TRACE(law.name);
    Simulation simulation = simulationFromText(
        "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><EulerImplicitSolver "
        "newtonIterations=\"20\"/><SparseLDLSolver/>"
        "<TetrahedronSetTopologyContainer position=\"0 0 0 1 0 0 0 1 0 0 0 1\" tetrahedra=\"0 1 2 3\"/>"
        "<MechanicalObject/><UniformMass totalMass=\"1\"/><FixedProjectiveConstraint indices=\"0 1 2\"/>"
        "<TetrahedronHyperelasticityFEMForceField name=\"fem\" projectedTangent=\"true\" " +
        law.attributes + "/></Node>");
    System& system = *simulation.systems()[0];
    system.x[3] = Vec3(0.1, 0.1, -0.4);
    StepReport report;
    for (int step = 0; step < 3000 && !report.diverged; ++step) report = simulation.step();
    if (law.finite) {
      ASSERT_FALSE(report.diverged) << report.reason;
      if (law.name != "StVenantKirchhoff") {  // which has a mirrored rest shape: W depends on C alone
        EXPECT_LT((Vec3(system.x[3]) - Vec3(0, 0, 1)).norm(), 1e-3);
      }
    } else {
      ASSERT_TRUE(report.diverged);
      EXPECT_NE(report.reason.find("tetrahedron 0 (nodes 0 1 2 3) had J = -0.4, where the energy of"),
                std::string::npos)
          << report.reason;
      EXPECT_NE(report.reason.find("step 1"), std::string::npos) << report.reason;
    }
  }
}

/// nu to 0.4999: a small load bends a bar of hyperelastic cells as it bends one of Hooke's, both with
/// the dilatation of each cell: the hyperelastic tetrahedron has no other.
TEST(HyperelasticNewton, IncompressibleLimitAtSmallStrains) {
  for (const std::string law : {"materialName=\"NeoHookean\"", "materialName=\"MooneyRivlin\" c2=\"200\"",
                                "materialName=\"ArrudaBoyce\"", "materialName=\"Ogden\" alpha1=\"4\""}) {
    const auto deflection = [&](const std::string& field, const std::string& attributes) {
      const std::string newton = "<StaticSolver newton_iterations='20' relative_residual_tolerance_threshold='1e-7'/>";
      std::string text = bar(attributes + " youngModulus=\"3000\" poissonRatio=\"0.4999\"", newton, 2e-4);
      const std::string old = "TetrahedronHyperelasticityFEMForceField";
      Simulation simulation = simulationFromText(text.replace(text.find(old), old.size(), field));
      EXPECT_TRUE(simulation.step().newton_converged);
      double lowest = 0;
      const System& system = *simulation.systems()[0];
      for (Index i = 0; i < system.x.count(); ++i) lowest = std::min(lowest, system.x[i].y());
      return lowest;
    };
    const double large = deflection("TetrahedronHyperelasticityFEMForceField", law);
    const double small = deflection("TetrahedronFEMForceField", "method=\"small\" dilatation=\"local\"");
    EXPECT_LT(small, -1e-5);
    EXPECT_NEAR(large, small, 5e-3 * std::abs(small)) << law;
  }
}

/// The same with hexahedra that keep their volume in the mean, which do not lock (those of Hooke's law are compared
/// with Lame's tube in tests/elasticity/test_dilatation.cpp); cells that keep it at every point do.
TEST(HyperelasticNewton, IncompressibleBeamsDoNotLock) {
  const auto deflection = [&](const std::string& field) {
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="1" gravity="0 -9.81 0"><StaticSolver newton_iterations="20"
  relative_residual_tolerance_threshold="1e-6"/><SparseLDLSolver/>
  <RegularGridTopology name="grid" n="17 5 5" min="0 0 0" max="0.2 0.05 0.05"/><MechanicalObject name="dofs"/>
  <UniformMass totalMass="2e-4"/><BoxROI name="end" box="-0.001 -1 -1 0.001 1 1" position="@dofs.rest_position"/>
  <FixedProjectiveConstraint indices="@end.indices"/>
  <{} youngModulus="3000" poissonRatio="0.4999"/></Node>)",
        field));
    const StepReport report = simulation.step();
    // round-off of the pressure, 1e4 times the other stresses, ends a locked body's iterations earlier
    EXPECT_LT(report.newton_residual, 1e-4) << report.reason;
    double lowest = 0;
    const System& system = *simulation.systems()[0];
    for (Index i = 0; i < system.x.count(); ++i)
      lowest = std::max(lowest, simulation.states()[0]->rest_position[i].y() - system.x[i].y());
    return lowest;
  };
  const double hooke = deflection("HexahedronFEMForceField method=\"small\" dilatation=\"mean\"");
  for (const std::string law : {"materialName=\"NeoHookean\"", "materialName=\"MooneyRivlin\" c2=\"200\"",
                                "materialName=\"ArrudaBoyce\"", "materialName=\"Ogden\" alpha1=\"4\""}) {
    const std::string type = "HexahedronHyperelasticityFEMForceField ";
    // I1 of NeoHookean is not isochoric: its part of the bulk modulus, 2e-4 of the whole, still acts at every point
    EXPECT_NEAR(deflection(type + law + " dilatation=\"mean\""), hooke, 0.02 * hooke) << law;
    EXPECT_LT(deflection(type + law + " dilatation=\"local\""), 0.5 * hooke) << law;
    EXPECT_EQ(deflection(type + law), deflection(type + law + " dilatation=\"mean\"")) << law << ": the default";
  }
}

/// A beam let go in its weight, in steps of a fiftieth and of a twentieth of its swing. With one linear solve per step the
/// trapezoidal rule exploded after 139 of the longer steps and Newmark's went two thirds of the way. Solved by Newton's method both are
/// the same rule. `deepest`: the lowest place of its end.
TEST(HyperelasticNewton, RulesOfSecondOrderMakeTheSolvesThatLongStepsNeed) {
  const auto deepest = [](const std::string& integrator, double dt) {
    Simulation s = simulationFromText(
        "<Node name=\"root\" dt=\"" + std::to_string(dt) + "\" gravity=\"0 0 -10\">" + integrator +
        "<SparseLDLSolver/><RegularGridTopology n=\"11 3 3\" min=\"0 0 0\" max=\"1 0.2 0.2\"/><MechanicalObject/>"
        "<UniformMass totalMass=\"0.4\"/><HexahedronHyperelasticityFEMForceField materialName=\"NeoHookean\" youngModulus=\"1e4\" "
        "poissonRatio=\"0.3\"/><BoxROI name=\"held\" box=\"-1 -1 -1 0.001 1 1\"/><FixedProjectiveConstraint "
        "indices=\"@held.indices\"/></Node>");
    double least = 1;
    while (s.time() < 10 - dt / 2) {
      const StepReport report = s.step();
      if (report.failed()) return -10.;
      least = std::min(least, s.systems()[0]->x[98].z());
    }
    return least;
  };
  const double swing = deepest("<TrapezoidalRuleSolver newtonIterations=\"30\"/>", 0.01);
  EXPECT_NEAR(deepest("<NewmarkImplicitSolver newtonIterations=\"30\"/>", 0.01), swing, 1e-6);
  for (const char* integrator : {"<TrapezoidalRuleSolver/>", "<NewmarkImplicitSolver/>"})
    for (const double dt : {0.02, 0.05}) {
      const double found = deepest(integrator, dt);
      std::printf("%s dt = %g: %.4f m, by Newton's method in steps of 0.01 s %.4f m\n", integrator, dt, found, swing);
      EXPECT_NEAR(found, swing, 0.02) << integrator << " " << dt;
    }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
