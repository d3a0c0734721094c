// SPDX-License-Identifier: LGPL-2.1-or-later
// Lists of whole numbers where a mesh changes: of a kind that is known, or refused. References: scenes written by hand.
#include <set>

#include "framework/scene/modules.h"
#include "tests/session/changed_scenes.h"
#include "tools/session/list_kinds.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Components that make, show or change a mesh have lists of their own; those of the others follow it.
bool hasListsOfItsOwn(const Component& component) {
  const std::string role = component.roleText();
  return role.ends_with("engine") || role == "selection" || role == "collision model" || role == "mesh loader" || role == "topology" ||
         role == "topological mapping" || role == "mechanical state" || component.type() == "TopologicalChangeProcessor";
}

TEST(ListKinds, AreKnownOfEachListOfWholeNumbers) {
  Factory factory;
  Modules modules(factory);
  std::set<std::string> unknown;
  int known = 0;
  for (const auto& entry : modules.index()) {
    ASSERT_TRUE(modules.provide(std::string(entry.type))) << entry.type;
    const auto component = factory.make(std::string(entry.type));
    if (hasListsOfItsOwn(*component)) continue;
    for (const Data& data : component->data().all()) {
      if (data.isOutput() || !std::holds_alternative<std::vector<int>*>(data.pointer())) continue;
      if (kindOf(data.name()) == ListKind::unknown)
        unknown.insert(data.name());
      else
        ++known;
    }
  }
  EXPECT_GT(known, 60);
  EXPECT_EQ(unknown, (std::set<std::string>{"localRange", "pivot_points"})) << "those of these names are refused where a mesh changes";
}

TEST(ListKinds, NodesThatAConstraintNamesOneByOneFollow) {
  const std::string slider = "<SlidingLagrangianConstraint name=\"l\" object1=\"@s\" object2=\"@s\" ";
  expectSame(bar(knife + slider + "sliding_point=\"21\" axis_1=\"23\" axis_2=\"22\"/>"),
             shortBar(slider + "sliding_point=\"17\" axis_1=\"19\" axis_2=\"18\"/>", hexes));
  expectContains(reasonOf(bar(knife + slider + "axis_1=\"1\" axis_2=\"2\"/>")), "/l.sliding_point names a point that goes");
}

TEST(ListKinds, NumbersOfWhatIsNotKnownAreRefusedWherePointsStayToo) {
  const std::string stays = "<CarvingRegion keepsPoints=\"true\" box=\"0.1 -9 -9 0.9 9 9\" begin=\"0.02\" end=\"0.02\"/>";
  expectContains(reasonOf(bar(stays + "<PlaneForceField name=\"p\" localRange=\"0 3\" normal=\"0 1 0\" d=\"-1\" stiffness=\"1\"/>")),
                 "/p.localRange may number points or cells");
  const std::string split = "<MeshSplittingEngine name=\"e\" position=\"@s.rest_position\" hexahedra=\"@g.hexahedra\" nbInputs=\"1\" ";
  expectContains(reasonOf(bar(stays + split + "hexahedronIndices1=\"4\"/><Node name=\"c\"><MechanicalObject "
                                              "position=\"@../e.position1\"/><BarycentricMapping/></Node>")),
                 "/e.hexahedronIndices1 may number points or cells");
}

TEST(ListKinds, KeptNodesOfACondensedBodyFollow) {
  Session session;
  session.loadText("<Node name=\"root\" dt=\"0.01\" gravity=\"0 -10 0\"><CondensedDynamicSolver name=\"c\" surfaceIndices=\"3 0 23\"/>"
                   "<RegularGridTopology n=\"6 2 2\" min=\"0 0 0\" max=\"5 1 1\"/><MechanicalObject name=\"s\"/><DiagonalMass "
                   "massDensity=\"1\"/><HexahedronFEMForceField method=\"small\" youngModulus=\"3000\" poissonRatio=\"0.4\"/>"
                   "<FixedProjectiveConstraint indices=\"5 11 17 23\"/>" + knife + "</Node>",
                   "scene.xml");
  const Seen seen = runFor(session, 5, "/s");
  ASSERT_EQ(seen.report.end, RunEnd::done) << seen.report.reason;
  ASSERT_EQ(seen.x.size(), 20u);
  const Component* solver = findComponent(session.simulation().root(), "/c");
  ASSERT_TRUE(solver);
  const Data& kept = *solver->data().find("surfaceIndices");
  EXPECT_EQ(*std::get<std::vector<int>*>(kept.pointer()), (std::vector<int>{3, 18}))
      << "node 0 goes, and 23 takes the number of 18, which goes too";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
