// SPDX-License-Identifier: LGPL-2.1-or-later
// Rods of rigid frames, written in units from a nanometre to a million kilometres. Residuals are forces and torques, whose sizes go
// apart with the unit of length: what solvers by products find must not.
#include <fmt/format.h>

#include <algorithm>

#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A cantilever of ten beams, one unit of `size` long, after a step under a force or a torque at its end.
std::vector<Vec3> bent(const std::string& integrator, const std::string& solver, double size, bool torque) {
  const double radius = 0.05 * size, young = 1e6, force = 1e-3 * young * radius * radius * radius * radius / (size * size);
  std::string frames, edges;
  for (int i = 0; i <= 10; ++i) frames += fmt::format("{:.17g} 0 0 0 0 0 1  ", size * i / 10);
  for (int i = 0; i < 10; ++i) edges += fmt::format("{} {}  ", i, i + 1);
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="1" gravity="0 0 0"><{} name="integrator"/><{}/><MeshTopology edges="{}"/><MechanicalObject
  template="Rigid3" position="{}"/><UniformMass totalMass="{:.17g}"/><BeamFEMForceField radius="{:.17g}" youngModulus="{}"
  poissonRatio="0.3"/><FixedProjectiveConstraint indices="0"/><ConstantForceField indices="10" forces="0 {:.17g} 0 0 {:.17g} 0"/></Node>)",
      integrator, solver, edges, frames, 1e-12 * young * size, radius, young, torque ? 0 : force, torque ? force * size : 0));
  const StepReport report = simulation.step();
  EXPECT_TRUE(!report.failed() && report.newton_converged) << size << " " << solver << " " << report.reason;
  std::vector<Vec3> way;
  const ConstRows x = simulation.systems()[0]->x;
  for (Index i = 0; i < x.count; ++i)
    way.push_back(i % 2 == 1 ? Vec3(x[i]) : Vec3((x[i] - Vec3(size * (i / 2) / 10, 0, 0)) / size));
  return way;
}

double largestOf(const std::vector<Vec3>& ways, std::size_t first) {
  double most = 0;
  for (std::size_t i = first; i < ways.size(); i += 2) most = std::max(most, ways[i].norm());
  return most;
}

TEST(FramesInAnyUnit, SolversByProductsFindWhatFactorsDo) {
  for (const double size : {1e-9, 1e-6, 1., 1e6, 1e9})
    for (const bool torque : {false, true}) {
      const std::vector<Vec3> expected = bent("EulerImplicitSolver", "SparseLDLSolver", size, torque);
      for (const std::string solver : {"CGLinearSolver", "CGLinearSolver preconditioner=\"none\"", "PCGLinearSolver",
                                       "PCGLinearSolver preconditioner=\"block_jacobi\""}) {
        std::vector<Vec3> off = bent("EulerImplicitSolver", solver, size, torque);
        for (std::size_t i = 0; i < off.size(); ++i) off[i] -= expected[i];
        for (const std::size_t kind : {0, 1})  // places, turns
          EXPECT_LT(largestOf(off, kind), 1e-5 * largestOf(expected, kind)) << size << " " << torque << solver << kind;
      }
    }
}

/// A torque is no sign of a body that nothing holds, however large its number is beside those of forces.
TEST(FramesInAnyUnit, StaticsFindTheSameShape) {
  for (const bool torque : {false, true}) {
    const std::vector<Vec3> expected = bent("StaticSolver", "SparseLDLSolver", 1, torque);
    for (const double size : {1e3, 1e6, 1e9}) {
      std::vector<Vec3> off = bent("StaticSolver", "SparseLDLSolver", size, torque);
      for (std::size_t i = 0; i < off.size(); ++i) off[i] -= expected[i];
      for (const std::size_t kind : {0, 1}) EXPECT_LT(largestOf(off, kind), 1e-9 * largestOf(expected, kind)) << size << torque << kind;
    }
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
