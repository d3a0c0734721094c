// SPDX-License-Identifier: LGPL-2.1-or-later
// A body is where it would be alone, however heavy others are: Newton's method ends where each of them is in balance.
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A block that is held at one end.
std::string block(const std::string& name, const std::string& grid, double mass, double young, const std::string& method) {
  return fmt::format("<Node name=\"{0}\"><RegularGridTopology {1}/><MechanicalObject name=\"dofs\"/><UniformMass totalMass=\"{2:g}\"/>"
                     "<HexahedronFEMForceField youngModulus=\"{3:g}\" poissonRatio=\"0.3\" method=\"{4}\"/>"
                     "<FixedProjectiveConstraint indices=\"0 9 18 27\"/></Node>",
                     name, grid, mass, young, method);
}

/// The places of a soft beam after some steps, beside a frame of a ton or alone; its forces are in proportion to `scale`.
std::vector<Vec3> beam(const std::string& integrator, double scale, bool beside_heavy) {
  const std::string solver = "<SparseLDLSolver/>";
  std::string bodies = block("beam", "n=\"9 2 2\" min=\"0 0 0\" max=\"1 0.1 0.1\"", scale, 1e5 * scale, "polar");
  if (beside_heavy) bodies += block("frame", "n=\"9 2 2\" min=\"5 0 0\" max=\"6 1 1\"", 1e3, 1e9, "small");
  const std::string root = "<Node name=\"root\" dt=\"0.05\" gravity=\"0 -10 0\">";
  Simulation simulation = simulationFromText(root + integrator + solver + bodies + "</Node>");
  for (int i = 0; i < 3; ++i) {
    const StepReport report = simulation.step();
    EXPECT_FALSE(report.diverged) << report.reason;
    EXPECT_TRUE(report.newton_converged) << report.reason;
  }
  std::vector<Vec3> places;
  const State& state = *simulation.states()[0];
  for (Index i = 0; i < state.size(); ++i) places.push_back(state.x()[i]);
  return places;
}

TEST(LightBodies, AreInBalanceBesideHeavyOnes) {
  for (const std::string integrator : {"<StaticSolver/>", "<EulerImplicitSolver newtonIterations=\"30\"/>",
                                       "<TrapezoidalRuleSolver newtonIterations=\"30\"/>", "<BDFOdeSolver newtonIterations=\"30\"/>",
                                       "<NewmarkImplicitSolver newtonIterations=\"30\"/>"})
    for (const double scale : {1e-3, 1e-6, 1e-9, 1e-12}) {
      SCOPED_TRACE(fmt::format("{} {}", integrator, scale));
      const std::vector<Vec3> alone = beam(integrator, scale, false), beside = beam(integrator, scale, true);
      ASSERT_EQ(alone.size(), beside.size());
      double off = 0, way = 0;
      for (std::size_t i = 0; i < alone.size(); ++i)
        off = std::max(off, (alone[i] - beside[i]).norm()), way = std::max(way, std::abs(alone[i].y()));
      EXPECT_LT(off, 1e-3 * way);
    }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
