// SPDX-License-Identifier: LGPL-2.1-or-later
// What a change of a mesh does not do again. Reference: the run whose files stay.
#include "tests/session/seen_runs.h"
#include "tests/support/folder_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

class CostOfChanges : public FolderTest {
 protected:
  /// A bar that loses a cell before the step at t = 0.02, and a body of two tetrahedra of a file.
  std::string scene(const std::string& loader) const {
    const std::string body = "<MechanicalObject name=\"s\"/><MeshMatrixMass massDensity=\"1000\"/>";
    return "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -10 0\"><EulerImplicitSolver/><SparseLDLSolver/>"
           "<Node name=\"a\"><RegularGridTopology n=\"3 2 2\" min=\"0 0 0\" max=\"2 1 1\"/>" + body +
           "<HexahedronFEMForceField method=\"svd\" youngModulus=\"1e5\" poissonRatio=\"0.3\"/>"
           "<CarvingRegion box=\"1 -9 -9 9 9 9\" begin=\"0.02\" end=\"0.02\"/></Node>"
           "<Node name=\"b\"><MeshGmshLoader name=\"loader\" filename=\"" + file("two.msh") + "\" " + loader + "/>"
           "<TetrahedronSetTopologyContainer src=\"@loader\"/>" + body +
           "<TetrahedronFEMForceField method=\"svd\" youngModulus=\"1e5\" poissonRatio=\"0.3\"/>"
           "<FixedProjectiveConstraint indices=\"0 2 3\"/></Node></Node>";
  }
  std::string mesh(double x) const {
    return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 " + std::to_string(x) +
           " 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n$Elements\n2\n1 4 2 1 1 1 2 3 4\n2 4 2 1 1 5 2 4 3\n$EndElements\n";
  }
};

TEST_F(CostOfChanges, NoFileIsReadAgain) {
  write("two.msh", mesh(1));
  Session kept, other;
  kept.loadText(scene("scale=\"2\""), "kept.xml"), other.loadText(scene("scale=\"2\""), "other.xml");
  const Seen whole = runFor(kept, 8, "/b/s");
  ASSERT_EQ(whole.report.end, RunEnd::done) << whole.report.reason;
  EXPECT_EQ(see(kept, "/a/s").x.size(), 8u) << "a cell of the bar went";
  EXPECT_NEAR(whole.rest[1][0], 2, 1e-15);
  write("two.msh", mesh(3));
  EXPECT_EQ(farthest(whole, runFor(other, 8, "/b/s")), 0) << "the file has become another one";
}

TEST_F(CostOfChanges, ASceneThatIsLoadedReadsItsFiles) {
  write("two.msh", mesh(1));
  Session session;
  session.loadText(scene(""), "one.xml");
  EXPECT_NEAR(runFor(session, 4, "/b/s").rest[1][0], 1, 1e-15);
  session.loadText(scene("scale=\"3\""), "three.xml");
  EXPECT_NEAR(runFor(session, 4, "/b/s").rest[1][0], 3, 1e-15);
  write("two.msh", mesh(2));
  session.loadText(scene(""), "one.xml");
  EXPECT_NEAR(runFor(session, 4, "/b/s").rest[1][0], 2, 1e-15);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
