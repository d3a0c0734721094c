// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes that name no linear solver, and whether displacements and pressures are solved for together: against factors, in the plan, and
// in a run that is taken up again.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "framework/algebra/direct_solver.h"
#include "framework/algebra/solver_choice.h"
#include "framework/simulation/system.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace {

constexpr const char* hexahedra = "<HexahedronFEMForceField dilatation='mean' youngModulus='100' poissonRatio='{1}' method='{0}'/>";
constexpr const char* tetrahedra =
    "<TetrahedronSetTopologyContainer name='cells'/><Hexa2TetraTopologicalMapping input='@grid' output='@cells'/>"
    "<TetrahedronFEMForceField topology='@cells' dilatation='mean' youngModulus='100' poissonRatio='{1}' method='{0}'/>";
constexpr const char* rubber =
    "<HexahedronHyperelasticityFEMForceField dilatation='mean' materialName='{0}' youngModulus='100' poissonRatio='{1}'/>";

struct Cube {
  const char* field;
  const char* method;
  int cells;
  const char* poisson = "0.4999";
  double weight = 1;
  const char* integrator = "<StaticSolver/>";

  std::string scene(const std::string& solver) const {
    return fmt::format(
        "<Node name='root' dt='0.01' gravity='{0} 0 {1}'>{2}{3}<RegularGridTopology name='grid' n='{4} {4} {4}' min='0 0 0' max='1 1 1'/>"
        "<MechanicalObject/><MeshMatrixMass massDensity='1' topology='@grid'/>{5}<BoxROI name='wall' box='-1 -1 -1 2 2 1e-6'/>"
        "<FixedProjectiveConstraint indices='@wall.indices'/></Node>",
        -0.1 * weight, -weight, integrator, solver, cells + 1, fmt::format(fmt::runtime(field), method, poisson));
  }
};

LinearSolver& solverOf(Simulation& simulation) { return *simulation.systems()[0]->linearSolver(); }
std::string choiceOf(Simulation& simulation) { return dynamic_cast<SolverChoice&>(solverOf(simulation)).choice(); }
bool isByPressures(const std::string& choice) { return choice.starts_with("GMRES for displacements and pressures"); }
/// Before a step, as `stroma explain` does.
std::string planned(Simulation& simulation) {
  dynamic_cast<SolverChoice&>(solverOf(simulation)).choose(simulation.systems()[0]->matrix());
  return choiceOf(simulation);
}
Vector displacement(const Simulation& simulation) {
  const State& state = *simulation.systems()[0]->states()[0];
  Vector u(state.size());
  for (Index i = 0; i < u.count(); ++i) u[i] = state.x()[i] - state.rest_position[i];
  return u;
}

/// Linear ones to the tolerance of the solve, others to that of Newton's method.
TEST(PressuresInScenes, StaticsAreThoseOfFactors) {
  for (const Cube& cube : {Cube{hexahedra, "small", 20}, Cube{tetrahedra, "small", 18}, Cube{hexahedra, "svd", 22, "0.4999", 3},
                           Cube{hexahedra, "polar", 22, "0.4999", 3}, Cube{rubber, "StableNeoHookean", 22, "0.4999", 3},
                           Cube{rubber, "NeoHookean", 22, "0.4999", 3}}) {
    SCOPED_TRACE(cube.method);
    Simulation chosen = simulationFromText(cube.scene("")), exact = simulationFromText(cube.scene("<SparseLDLSolver/>"));
    const StepReport report = chosen.step();
    exact.step();
    EXPECT_TRUE(report.linear_converged);
    EXPECT_TRUE(isByPressures(choiceOf(chosen))) << choiceOf(chosen);
    const Vector u = displacement(chosen), reference = displacement(exact);
    fmt::print("{} {}^3: {} Newton iterations, {} of GMRES, {:.2g} apart\n", cube.method, cube.cells, report.newton_iterations,
               report.linear_iterations, distance(u, reference) / norm(reference));
    EXPECT_LE(distance(u, reference), 1e-6 * norm(reference));
    EXPECT_GT(norm(reference), 0);
    EXPECT_LE(report.linear_iterations, 35 * report.newton_iterations);
    EXPECT_EQ(report.factorisations, 0) << "the matrix of the pressures is not that of the step: no stability is judged by it";
  }
}

/// With a solver of the scene for the matrix of the pressures, which counts.
TEST(PressuresInScenes, OneMatrixOfPressuresServesAllIterationsOfNewton) {
  const Cube cube{hexahedra, "svd", 22, "0.4999", 3};
  Simulation simulation = simulationFromText(cube.scene("<AutomaticLinearSolver/><SparseLDLSolver name='factors'/>"));
  const StepReport report = simulation.step();
  EXPECT_GT(report.newton_iterations, 5);
  EXPECT_TRUE(isByPressures(choiceOf(simulation))) << choiceOf(simulation);
  std::vector<DirectSolver*> direct;
  simulation.scene().root->collect(direct);
  ASSERT_EQ(direct.size(), 1);
  EXPECT_EQ(direct[0]->data().find("factorisations")->print(), "1");
}

TEST(PressuresInScenes, ThePlanNamesThem) {
  Simulation stiff = simulationFromText(Cube{hexahedra, "small", 20}.scene(""));
  EXPECT_TRUE(isByPressures(planned(stiff))) << planned(stiff);
  EXPECT_NE(planned(stiff).find("with pressures"), std::string::npos) << planned(stiff);
}

/// Compressible bodies, and small ones.
TEST(PressuresInScenes, OtherBodiesHaveNone) {
  for (const Cube& cube :
       {Cube{hexahedra, "small", 20, "0.45"}, Cube{tetrahedra, "svd", 18, "0.45"}, Cube{rubber, "StableNeoHookean", 20, "0.45"}}) {
    Simulation simulation = simulationFromText(cube.scene(""));
    EXPECT_EQ(planned(simulation).find("pressures"), std::string::npos) << cube.method << ": " << planned(simulation);
  }
  Simulation few = simulationFromText(Cube{hexahedra, "small", 8}.scene(""));
  EXPECT_FALSE(isByPressures(planned(few))) << planned(few);
}

/// The matrix of a step has a mass, which is no term of the force fields.
TEST(PressuresInScenes, AStepInTimeRefutesThem) {
  Cube cube{hexahedra, "small", 20};
  cube.integrator = "<EulerImplicitSolver/>";
  Simulation simulation = simulationFromText(cube.scene("<AutomaticLinearSolver/>"));
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.linear_converged);
  EXPECT_FALSE(isByPressures(choiceOf(simulation))) << choiceOf(simulation);
}

/// Two steps of a body whose load grows; the second one by itself from a checkpoint.
TEST(PressuresInScenes, ARunThatIsTakenUpAgainHasTheSameBits) {
  for (const Cube& cube : {Cube{hexahedra, "small", 20}, Cube{hexahedra, "svd", 22, "0.4999", 3}}) {
    SCOPED_TRACE(cube.method);
    const auto grow = [&](Simulation& simulation) {
      simulation.setAttribute("/", "gravity", fmt::format("{} 0 {}", -0.15 * cube.weight, -1.5 * cube.weight));
    };
    Simulation whole = simulationFromText(cube.scene(""));
    whole.step();
    const Archive written = whole.checkpoint();
    Simulation resumed = simulationFromText(cube.scene(""));
    resumed.restore(written.readable());
    grow(whole), grow(resumed);
    whole.step(), resumed.step();
    EXPECT_TRUE(isByPressures(choiceOf(whole))) << choiceOf(whole);
    EXPECT_EQ(choiceOf(whole), choiceOf(resumed));
    const Vector u = displacement(whole), again = displacement(resumed);
    EXPECT_EQ(std::memcmp(u.rows().data, again.rows().data, u.rows().doubles() * sizeof(double)), 0);
  }
}

}  // namespace
}  // namespace stroma::test
