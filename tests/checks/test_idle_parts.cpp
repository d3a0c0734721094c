// SPDX-License-Identifier: LGPL-2.1-or-later
// What takes no part in a motion is said: bodies of which all is held, cells without a law.
#include "tools/checks/idle_parts.h"

#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string told(const std::string& text) {
  Simulation simulation = simulationFromText(text);
  warnOfIdleParts(simulation, simulation.diagnostics());
  return simulation.scene().diagnostics.text();
}

std::string heldAt(const std::string& constraint) {
  return R"(<Node name="root" gravity="0 0 0"><EulerImplicitSolver/><CGLinearSolver/>
    <RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/><UniformMass totalMass="1"/>
    <HexahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>)" +
         constraint + "</Node>";
}

TEST(IdleParts, ABodyOfWhichEveryNodeIsHeldIsSaid) {
  const std::string sentence = "/dofs: every node is held by constraints";
  expectContains(told(heldAt("<FixedProjectiveConstraint indices='0-7'/>")), sentence);
  expectContains(told(heldAt("<FixedProjectiveConstraint fixAll='true'/>")), sentence);
  for (const char* free :
       {"", "<FixedProjectiveConstraint indices='0-6'/>",
        "<PartialFixedProjectiveConstraint indices='0-7' fixedDirections='1 1 0'/>",
        "<LinearMovementProjectiveConstraint indices='0-7' keyTimes='0 1' movements='0 0 0 1 0 0'/>"})
    EXPECT_EQ(told(heldAt(free)).find(sentence), std::string::npos) << free;
}

/// A hexahedron, and a pyramid of two tetrahedra on its upper face.
std::string mixed(const std::string& fields) {
  return R"(<Node name="root" gravity="0 0 0"><EulerImplicitSolver/><CGLinearSolver/>
    <MeshTopology name="mesh" position="0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1 0.5 0.5 2"
      hexahedra="0 1 2 3 4 5 6 7" tetrahedra="4 5 6 8 4 6 7 8"/><MechanicalObject name="dofs"/><UniformMass totalMass="1"/>)" +
         fields + "</Node>";
}

TEST(IdleParts, CellsWithoutALawInAMixedMeshAreSaid) {
  const std::string tetrahedra = "<TetrahedronFEMForceField youngModulus='1000' poissonRatio='0.3'/>",
                    hexahedra = "<HexahedronFEMForceField youngModulus='1000' poissonRatio='0.3'/>";
  expectContains(told(mixed(tetrahedra)), "/mesh: 1 of 1 hexahedra have no law");
  expectContains(told(mixed(hexahedra)), "/mesh: 2 of 2 tetrahedra have no law");
  EXPECT_EQ(told(mixed(tetrahedra + hexahedra)).find("no law"), std::string::npos);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
