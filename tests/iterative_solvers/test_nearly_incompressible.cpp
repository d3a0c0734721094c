// SPDX-License-Identifier: LGPL-2.1-or-later
// Poisson's ratio up to 0.4999 and the linear solvers. The condition number of a step's matrix grows with K/mu and with
// the mesh, and the iterations of conjugate gradients with its root. Exact factors do not know Poisson's ratio; former
// factors turned with the body hardly do when they are renewed once they stop paying: PCGLinearSolver with
// WarpPreconditioner is the iterative solver for nearly incompressible bodies.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace {

constexpr const char* conjugate_gradients =
    "<CGLinearSolver iterations='5000' tolerance='1e-8' preconditioner='block_jacobi'/>";
constexpr const char* warped =
    "<PCGLinearSolver iterations='5000' tolerance='1e-8' preconditioner='@warp'/>"
    "<WarpPreconditioner name='warp' linearSolver='@factors' refresh='estimate'/><SparseLDLSolver name='factors'/>";

/// A beam that bends under its weight (its locked forms less); `cells` over its height.
std::string beam(int cells, const std::string& poisson, const std::string& dilatation, const std::string& solver) {
  return fmt::format(
      "<Node name='root' dt='0.01' gravity='0 0 -9.81'><EulerImplicitSolver/>{}"
      "<RegularGridTopology name='grid' n='{} {} {}' min='0 0 0' max='0.16 0.04 0.04'/><MechanicalObject/>"
      "<DiagonalMass massDensity='1000'/><HexahedronFEMForceField method='polar' youngModulus='2e4' "
      "poissonRatio='{}' dilatation='{}'/><BoxROI name='held' box='-1 -1 -1 0.001 1 1'/>"
      "<FixedProjectiveConstraint indices='@held.indices'/></Node>",
      solver, 4 * cells + 1, cells + 1, cells + 1, poisson, dilatation);
}

/// Of thirty steps: the most iterations of one, and all factorisations.
struct Effort {
  int iterations = 0, factorisations = 0;
};
Effort effortOf(const std::string& scene) {
  Simulation simulation = simulationFromText(scene);
  Effort most;
  for (int step = 0; step < 30; ++step) {
    const StepReport report = simulation.step();
    EXPECT_TRUE(report.linear_converged) << scene;
    most.iterations = std::max(most.iterations, report.linear_iterations);
    most.factorisations += report.factorisations;
  }
  const State& state = *simulation.systems()[0]->states()[0];
  EXPECT_LT(state.x()[state.size() - 1].z(), 0.03) << "the beam has not bent";
  return most;
}

TEST(NearlyIncompressible, TurnedFactorsNeedABoundedNumberOfIterations) {
  for (const std::string dilatation : {"local", "mean"}) {
    int most_warped = 0, least_plain = 1 << 30, most_plain = 0;
    for (int cells : {2, 4})
      for (const std::string poisson : {"0.3", "0.49", "0.499", "0.4999"}) {
        const Effort turned = effortOf(beam(cells, poisson, dilatation, warped));
        const int plain = effortOf(beam(cells, poisson, dilatation, conjugate_gradients)).iterations;
        fmt::print(
            "{} cells, nu {:6}, {:5} dilatation: turned factors {:2} iterations ({} factorisations in 30 steps), "
            "block Jacobi {:4}\n",
            cells, poisson, dilatation, turned.iterations, turned.factorisations, plain);
        most_warped = std::max(most_warped, turned.iterations);
        least_plain = std::min(least_plain, plain), most_plain = std::max(most_plain, plain);
        EXPECT_LT(turned.factorisations, 30);
      }
    EXPECT_LE(most_warped, 40) << dilatation;
    EXPECT_GT(most_plain, 5 * least_plain) << "the bodies are too easy to tell anything";
  }
}

}  // namespace
}  // namespace stroma::test
