// SPDX-License-Identifier: LGPL-2.1-or-later
// What the automatic linear solver remembers of former meshes of a body.
#include <fmt/format.h>

#include "framework/algebra/linear_solver.h"
#include "framework/simulation/system.h"
#include "tests/session/seen_runs.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A stiff bar that loses cells at its free end every so many steps.
std::string bar(int every) {
  return fmt::format(R"(<Node name="root" dt="0.01" gravity="0 -9.81 0"><EulerImplicitSolver/>
  <RegularGridTopology name="grid" n="33 9 9" min="0 0 0" max="0.4 0.1 0.1"/>
  <MechanicalObject name="dofs"/><DiagonalMass massDensity="1000"/>
  <HexahedronFEMForceField method="svd" youngModulus="1e6" poissonRatio="0.4"/>
  <BoxROI name="end" box="-1 -1 -1 0.001 1 1"/><FixedProjectiveConstraint indices="@end.indices"/>
  <CarvingRegion box="0.39 -9 -9 9 9 9" velocity="-0.2 0 0" begin="{0}" every="{0}"/></Node>)", 0.01 * every);
}

struct Step {
  Index nodes = 0;
  int iterations = 0;
  bool has_changed = false;  ///< the choice, on this mesh
};

Step stepOf(Session& session) {
  session.followMeshChanges();
  const RunReport report = session.run({.steps = 1});
  EXPECT_EQ(report.end, RunEnd::done) << report.reason;
  const Simulation& simulation = session.simulation();
  const LinearSolver& solver = *simulation.systems()[0]->linearSolver();
  return {simulation.states()[0]->size(), report.last.linear_iterations, solver.data().find("changes")->print() != "0"};
}

TEST(SolversOfChangedMeshes, WhatTheNextCutWouldEndIsNotSetUp) {
  Session session;
  session.loadText(bar(2), "scene.xml");
  std::vector<Step> steps;
  for (int k = 0; k < 12; ++k) steps.push_back(stepOf(session));
  EXPECT_LT(steps[11].nodes, steps[5].nodes) << "the mesh goes on changing";
  for (std::size_t k = 6; k < steps.size(); ++k) EXPECT_FALSE(steps[k].has_changed) << k;
}

TEST(SolversOfChangedMeshes, WhatServedTheMeshBeforeServesFromTheFirstStepOn) {
  Session session;
  session.loadText(bar(14), "scene.xml");
  std::vector<Step> steps;
  for (int k = 0; k < 16; ++k) steps.push_back(stepOf(session));
  ASSERT_LT(steps[15].nodes, steps[0].nodes);
  EXPECT_TRUE(steps[13].has_changed) << "with many steps another way pays";
  const auto first = std::ranges::find_if(steps, [&](const Step& step) { return step.nodes < steps[0].nodes; });
  EXPECT_TRUE(first->has_changed);
  EXPECT_LT(2 * first->iterations, steps[0].iterations);
}

TEST(SolversOfChangedMeshes, AResumedRunHasTheSameBits) {
  for (const int every : {2, 5}) {
    Session whole, other;
    whole.loadText(bar(every), "scene.xml"), other.loadText(bar(every), "scene.xml");
    for (int k = 0; k < 6; ++k) stepOf(whole);
    other.restore(whole.checkpoint(), "it");
    for (int k = 0; k < 6; ++k) stepOf(whole), stepOf(other);
    EXPECT_EQ(whole.simulation().stateHash(), other.simulation().stateHash()) << every;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
