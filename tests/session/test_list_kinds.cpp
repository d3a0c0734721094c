// SPDX-License-Identifier: LGPL-2.1-or-later
// Lists of whole numbers where a mesh changes: of a kind that is known, or refused. References: scenes written by hand.
#include <set>

#include "framework/scene/modules.h"
#include "tests/session/changed_scenes.h"
#include "tests/support/folder_fixture.h"
#include "tools/session/list_kinds.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Components that make, show or change a mesh have lists of their own; those of the others follow it.
bool hasListsOfItsOwn(const Component& component) {
  const std::string role = component.roleText();
  return role.ends_with("engine") || role == "selection" || role == "collision model" || role == "mesh loader" || role == "topology" ||
         role == "topological mapping" || role == "mechanical state" || component.type() == "TopologicalChangeProcessor";
}

/// Of all other components what holds a Value and is written.
template <class Value, class Look>
void forEachOf(const Look& look) {
  Factory factory;
  Modules modules(factory);
  for (const auto& entry : modules.index()) {
    ASSERT_TRUE(modules.provide(std::string(entry.type))) << entry.type;
    const auto component = factory.make(std::string(entry.type));
    if (hasListsOfItsOwn(*component)) continue;
    for (const Data& data : component->data().all())
      if (!data.isOutput() && std::holds_alternative<Value*>(data.pointer())) look(component->type(), data);
  }
}

TEST(ListKinds, AreKnownOfEachListOfWholeNumbers) {
  std::set<std::string> unknown;
  int known = 0;
  forEachOf<std::vector<int>>([&](const std::string&, const Data& data) {
    if (kindOf(data.name()) == ListKind::unknown)
      unknown.insert(data.name());
    else
      ++known;
  });
  EXPECT_GT(known, 60);
  EXPECT_EQ(unknown, (std::set<std::string>{"cells", "localRange", "pivot_points"}))
      << "those of these names are refused where a mesh changes";
}

TEST(ListKinds, NodesThatAConstraintNamesOneByOneFollow) {
  const std::string slider = "<SlidingLagrangianConstraint name=\"l\" object1=\"@s\" object2=\"@s\" ";
  expectSame(bar(knife + slider + "sliding_point=\"21\" axis_1=\"23\" axis_2=\"22\"/>"),
             shortBar(slider + "sliding_point=\"17\" axis_1=\"19\" axis_2=\"18\"/>", hexes));
  expectContains(reasonOf(bar(knife + slider + "axis_1=\"1\" axis_2=\"2\"/>")), "/l.sliding_point names a point that goes");
}

/// Words of attributes that tell of nodes and number none, or number parts of joints that have no mesh.
const std::set<std::string> names_no_node = {"iterations", "numberInfluencedLines", "nbPointsOnEachCircle", "peak", "played",
                                             "articulationIndex", "parentIndex", "childIndex"};

TEST(ListKinds, AreKnownOfEachNumberOfANode) {
  std::set<std::string> unknown;
  int known = 0;
  forEachOf<int>([&](const std::string& type, const Data& data) {
    if (names_no_node.count(data.name())) return;
    const std::string& help = data.helpText();
    const bool is_told = help.find("node") != std::string::npos || help.find("frame") != std::string::npos ||
                         help.find("point") != std::string::npos || help.find("number of the state") != std::string::npos;
    if (namesOneNode(type, data.name()) || namesOneMapped(type, data.name()))
      ++known;
    else if (is_told)
      unknown.insert(type + "." + data.name());
  });
  EXPECT_GT(known, 12);
  EXPECT_EQ(unknown, std::set<std::string>{}) << "to be named in tools/session/list_kinds.cpp, or here where they number no node";
}

int numberNow(const Session& session, const std::string& path, const std::string& attribute) {
  return **std::get_if<int*>(&findComponent(session.simulation().root(), path)->data().find(attribute)->pointer());
}

TEST(ListKinds, TheNodeThatAPlateMovesWithFollows) {
  const auto plate = [](const std::string& node, const std::string& more = "") {
    return "<Node name=\"c\"><MechanicalObject name=\"p\" position=\"5 0.4 0\"/><UniformMass totalMass=\"1\"/>"
           "<RigidPlateForceField name=\"plate\" plate=\"@../s\" normal=\"0 -1 0\" stiffness=\"300\" " +
           node + "/>" + more + "</Node>";
  };
  expectSame(bar(knife + plate("plateNode=\"21\"")), shortBar(plate("plateNode=\"17\""), hexes), {}, "/c/p");
  expectContains(reasonOf(bar(knife + plate(""))), "/c/plate.plateNode names a point that goes");
}

class NodesOfChains : public FolderTest {
 protected:
  /// Four nodes in a row, of which the first goes at t = 0.02 with its edge, and the last takes its number.
  std::string chain(const std::string& of_state, const std::string& more) {
    const std::string file = write("cut.txt", "T= 0.02\nREMOVE= 1\n0\n");
    return root("<MeshTopology name=\"t\" position=\"0 0 0 1 0 0 2 0 0 3 0 0\" edges=\"0 1 1 2 2 3\"/><MechanicalObject name=\"s\" " +
                of_state + "/><UniformMass name=\"m\" totalMass=\"4\"/>" + more + "<TopologicalChangeProcessor filename=\"" + file +
                "\"/>");
  }
  static std::string frames() {
    return "template=\"Rigid3\" position=\"0 0 0 0 0 0 1  1 0 0 0 0 0 1  2 0 0 0 0 0 1  3 0 0 0 0 0 1\"";
  }
  static std::string numbers() { return "template=\"Vec1\" position=\"0 1 2 3\""; }
  /// What a number that was `before` is after the change.
  static int after(const std::string& scene, const std::string& path, const std::string& attribute) {
    Session session;
    session.loadText(scene, "scene.xml");
    const Seen seen = runFor(session, 4, "/s");
    EXPECT_EQ(seen.report.end, RunEnd::done) << seen.report.reason;
    EXPECT_TRUE(session.simulation().hasChangedMeshes());
    return numberNow(session, path, attribute);
  }
};

TEST_F(NodesOfChains, TheFrameOfAnEllipsoidFollows) {
  const auto ellipsoid = [](int frame) {
    return fmt::format("<Node name=\"c\"><MechanicalObject name=\"p\" position=\"9 9 9\"/><UniformMass/><InteractionEllipsoidForceField "
                       "name=\"e\" object1=\"@p\" object2=\"@../s\" object2_dof_index=\"{}\" center=\"0 0 0\" vradius=\"1 1 1\" "
                       "stiffness=\"1\"/></Node>",
                       frame);
  };
  EXPECT_EQ(after(chain(frames(), ellipsoid(3)), "/c/e", "object2_dof_index"), 0);
  EXPECT_EQ(after(chain(frames(), ellipsoid(2)), "/c/e", "object2_dof_index"), 2);
  expectContains(reasonOf(chain(frames(), ellipsoid(0))), "/c/e.object2_dof_index names a point that goes");
}

TEST_F(NodesOfChains, TheNumberThatAStopperBoundsFollows) {
  const auto stopper = [](int number) {
    return fmt::format("<StopperLagrangianConstraint name=\"l\" index=\"{}\" min=\"-9\" max=\"9\"/>", number);
  };
  EXPECT_EQ(after(chain(numbers(), stopper(3)), "/l", "index"), 0);
  expectContains(reasonOf(chain(numbers(), stopper(0))), "/l.index names a point that goes");
}

TEST_F(NodesOfChains, NumbersOfWhatIsMappedAreRefused) {
  const auto rider = [](const std::string& mapping) {
    return "<Node name=\"c\"><MechanicalObject name=\"p\" position=\"0 1 0\"/>" + mapping + "</Node>";
  };
  expectContains(reasonOf(chain(frames(), rider("<RigidMapping name=\"r\" index=\"2\"/>"))), "/c/r.index numbers points");
  expectContains(reasonOf(chain(frames(), rider("<RigidMapping name=\"r\"/>"))), "/c/r.index numbers points");
  expectContains(reasonOf(bar(knife + rider("<SubsetMapping name=\"r\" first=\"21\" last=\"21\"/>"))), "/c/r.first numbers points");
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
