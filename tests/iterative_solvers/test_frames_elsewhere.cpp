// SPDX-License-Identifier: LGPL-2.1-or-later
// Two branches of a scene, each with its own integrator. How a solver by products measures its residuals is a matter of the rows that it
// solves for: a rigid frame in the other branch has no say.
#include <fmt/format.h>

#include <vector>

#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr int soft_rows = 96;

/// Places of the soft body after some steps, beside a body of this template.
std::vector<Vec3> placesBeside(const std::string& solver, const std::string& other) {
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="0.01" gravity="0 0 -9.81">
  <Node name="soft"><EulerImplicitSolver/><{}/><RegularGridTopology n="4 4 6" min="0 0 0" max="0.1 0.1 0.3"/><MechanicalObject/>
    <UniformMass totalMass="1"/><HexahedronFEMForceField youngModulus="1e5" poissonRatio="0.45"/>
    <FixedProjectiveConstraint indices="0 1 2"/></Node>
  <Node name="other"><EulerImplicitSolver/><SparseLDLSolver/>{}<UniformMass totalMass="1"/></Node></Node>)",
      solver, other));
  for (int step = 0; step < 20; ++step) {
    const StepReport report = simulation.step();
    EXPECT_FALSE(report.failed()) << report.reason;
  }
  for (const auto& system : simulation.systems())
    if (const ConstRows x = system->x; x.count == soft_rows) {
      std::vector<Vec3> places;
      for (Index i = 0; i < x.count; ++i) places.emplace_back(x[i]);
      return places;
    }
  return {};
}

TEST(FramesElsewhere, ChangeNoBitOfASoftBody) {
  for (const std::string solver : {"CGLinearSolver tolerance=\"1e-4\"", "CGLinearSolver preconditioner=\"none\"", "PCGLinearSolver",
                                   "PCGLinearSolver preconditioner=\"ssor\" tolerance=\"1e-4\""}) {
    const std::vector<Vec3> expected = placesBeside(solver, "<MechanicalObject position=\"1 0 0\"/>");
    const std::vector<Vec3> found = placesBeside(solver, "<MechanicalObject template=\"Rigid3\" position=\"1 0 0 0 0 0 1\"/>");
    ASSERT_EQ(found.size(), std::size_t(soft_rows)) << solver;
    EXPECT_EQ(found, expected) << solver;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
