// SPDX-License-Identifier: LGPL-2.1-or-later
// Ten mistakes of ten kinds in one scene of real components: all are reported in one run, each where it stands, with
// what was expected or the nearest right name.
#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using PlantedMistakes = CommandTest;

TEST_F(PlantedMistakes, AllTenInOneRun) {
  write("ten.xml", R"(<Node name="root" dt="0.01" gravty="0 -9.81 0">
  <RequiredPlugin name="Sofa.Component.ODESolver"/>
  <RegularGridTopology name="grid" n="3 3 5" min="0 0 0" max="1 1 2"/>
  <Node name="body">
    <EulerImplicitSolvr name="odesolver"/>
    <CGLinearSolver iterations="25" tolerence="1e-5"/>
    <TetrahedronSetTopologyContainer name="tets"/>
    <Hexa2TetraTopologicalMapping input="@../grid" output="@tets"/>
    <MechanicalObject name="dofs"/>
    <UniformMass totalMass="one kilo"/>
    <TetrahedronFEMForceField name="fem" method="pollar" youngModulus="1000" poissonRatio="0.3"/>
    <FixedProjectiveConstraint indices="@emty.indices"/>
    <BoxROI name="empty" box="10 10 10 11 11 11"/>
    <BoxROI name="loopA" box="@loopB.box"/>
    <BoxROI name="loopB" box="@loopA.box"/>
  </Node>
  <Node name="other">
    <MeshGmshLoader name="loader" filename="no_such_liver.msh"/>
    <TetrahedronSetTopologyContainer src="@loader"/>
    <MechanicalObject/>
    <TetrahedronFEMForceField youngModulus="1000" poissonRatio="0.6"/>
  </Node>
</Node>
)");
  const Finished check = stroma("check ten.xml");
  EXPECT_EQ(check.code, 2);
  for (const char* line : {"ten.xml:1:29: error: /.gravty",                                  // attribute of Node
                           "ten.xml:5:5: error: /body/odesolver",                            // component
                           "ten.xml:6:37: error: /body/CGLinearSolver.tolerence",            // attribute
                           "ten.xml:10:18: error: /body/UniformMass.totalMass",              // type
                           "ten.xml:11:42: error: /body/fem.method",                         // word
                           "ten.xml:12:32: error: /body/FixedProjectiveConstraint.indices",  // broken link
                           "ten.xml:13:5: error: /body/empty: the selection is empty",       // empty selection
                           "ten.xml:15:5: error: /body/loopB: circular dependency between components",  // link cycle
                           "ten.xml:18:35: error: /other/loader.filename",                              // missing file
                           "ten.xml:21:51: error: /other/TetrahedronFEMForceField.poissonRatio",        // range
                           "did you mean 'gravity'", "did you mean 'EulerImplicitSolver'", "did you mean 'tolerance'",
                           "did you mean 'polar'", "in (-1, 0.5)", "10 errors"})
    EXPECT_NE(check.err.find(line), std::string::npos) << line << "\nis missing in\n" << check.err;
}

TEST_F(PlantedMistakes, BrokenFilesGetASentence) {
  std::string deep;
  for (int i = 0; i < 10000; ++i) deep += "<Node>";
  write("cut.xml", "<Node name=\"root\"><Node name=\"bo");
  write("deep.xml", deep);
  write("itself.xml", "<Node name=\"root\"><include href=\"itself.xml\"/></Node>");
  for (const char* file : {"cut.xml", "deep.xml", "itself.xml"}) {
    const Finished check = stroma("check " + std::string(file));
    EXPECT_EQ(check.code, 2) << file;
    EXPECT_NE(check.err.find(std::string(file) + ":"), std::string::npos) << check.err;
    EXPECT_NE(check.err.find("error: "), std::string::npos) << check.err;
    EXPECT_LT(check.err.size(), 2000u) << file;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
