// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/checks/beam_masses.h"

#include <fmt/format.h>

#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr const char* uniform = "<UniformMass name='mass' totalMass='9'/>";
constexpr const char* dynamics = "<EulerImplicitSolver/>";

std::string told(const std::string& mass, const std::string& integrator, const std::string& more = "") {
  std::string places, edges;
  for (int i = 0; i < 9; ++i) places += fmt::format("{} 0 0 0 0 0 1  ", i);
  for (int i = 0; i < 8; ++i) edges += fmt::format("{} {}  ", i, i + 1);
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" gravity="0 0 0">{}<SparseLDLSolver/><MeshTopology edges="{}"/>
      <MechanicalObject name="dofs" template="Rigid3" position="{}"/>{}
      <BeamFEMForceField name="beams" radius="0.1" youngModulus="1e6" poissonRatio="0.3"/>{}</Node>)",
      integrator, edges, places, mass, more));
  noteEqualMassesOfBeams(simulation, simulation.diagnostics());
  return simulation.scene().diagnostics.text();
}

TEST(BeamMasses, TheSameMassForAllNodesOfAChainIsTold) {
  const std::string text = told(uniform, dynamics);
  expectContains(text, "/beams: /mass gives free ends of beams as much mass as nodes between two beams");
  expectContains(text, "about 13 % too low");
  expectContains(text, "AdaptiveBeamForceFieldAndMass");
  expectContains(told(uniform, dynamics, "<FixedProjectiveConstraint indices='0'/>"), "about 5 % too low");
}

TEST(BeamMasses, NothingIsToldWhereNoFreeEndMoves) {
  const std::string sentence = "gives free ends";
  EXPECT_EQ(told(uniform, dynamics, "<FixedProjectiveConstraint indices='0 8'/>").find(sentence), std::string::npos);
  EXPECT_EQ(told(uniform, "<StaticSolver/>", "<FixedProjectiveConstraint indices='0'/>").find(sentence), std::string::npos);
  EXPECT_EQ(told("<UniformMass totalMass='9' turns='false'/>", dynamics).find(sentence), std::string::npos) << "as in SOFA's dialect";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
