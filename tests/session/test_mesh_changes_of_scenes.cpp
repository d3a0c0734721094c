// SPDX-License-Identifier: LGPL-2.1-or-later
// What follows a mesh that changes, and what must not. References: the scene that should result, written by hand and started
// from the state that the run has at the change; bodies that are not concerned; closed forms.
#include <fmt/format.h>

#include <functional>

#include "tests/session/changed_scenes.h"
#include "tests/support/folder_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

TEST(ChangedScenes, RegionsOnOneMeshTakeWhatLiesInEach) {
  const std::string at = " begin=\"0.02\" end=\"0.02\"/>";
  const std::string twice = "<CarvingRegion name=\"a\" box=\"0.1 -9 -9 0.9 9 9\"" + at +
                            "<CarvingRegion name=\"b\" box=\"0.2 -9 -9 0.8 9 9\"" + at;
  expectSame(bar(twice), shortBar("", hexes));
  const std::string apart = "<CarvingRegion name=\"a\" box=\"0.1 -9 -9 0.9 9 9\"" + at +
                            "<CarvingRegion name=\"b\" box=\"3.1 -9 -9 4.9 9 9\"" + at;
  expectSame(bar(apart), root("<RegularGridTopology n=\"3 2 2\" min=\"1 0 0\" max=\"3 1 1\"/><MechanicalObject name=\"s\"/>"
                              "<DiagonalMass massDensity=\"1\"/>" +
                              hexes));
  // a processor counts what the region has left: cell 0 is the last of the bar then
  const std::string both = "<CarvingRegion name=\"a\" box=\"0.1 -9 -9 0.9 9 9\"" + at +
                           "<TopologicalChangeProcessor useDataInputs=\"true\" timeToRemove=\"0.015\" hexahedraToRemove=\"0\"/>";
  expectSame(bar(both), root("<RegularGridTopology n=\"4 2 2\" min=\"1 0 0\" max=\"4 1 1\"/><MechanicalObject name=\"s\"/>"
                             "<DiagonalMass massDensity=\"1\"/>" +
                             hexes));
}

std::string bodyB(const std::string& more) {
  return "<Node name=\"B\"><RegularGridTopology name=\"g\" n=\"6 2 2\" min=\"0 0 0\" max=\"5 1 1\"/>"
         "<TetrahedronSetTopologyContainer name=\"t\"/><Hexa2TetraTopologicalMapping input=\"@g\" output=\"@t\"/>"
         "<MechanicalObject name=\"s\" topology=\"@t\" translation=\"0 5 0\"/><DiagonalMass totalMass=\"5\" topology=\"@t\"/>"
         "<TetrahedronFEMForceField youngModulus=\"3000\" poissonRatio=\"0.4\" topology=\"@t\"/>"
         "<ConstantForceField totalForce=\"0 60 0\"/>" +
         more + "</Node>";
}

TEST(ChangedScenes, ABodyWithAnEqualMeshIsLeftAlone) {
  for (const std::string& keeps : {std::string("true"), std::string("false")}) {
    const std::string a =
        "<Node name=\"A\"><RegularGridTopology name=\"g\" n=\"6 2 2\" min=\"0 0 0\" max=\"5 1 1\"/><MechanicalObject name=\"s\"/>"
        "<DiagonalMass totalMass=\"5\"/>" +
        hexes;
    const std::string region =
        "<CarvingRegion keepsPoints=\"" + keeps + "\" box=\"0.1 -9 -9 0.9 9 9\" begin=\"0.02\" end=\"0.02\"/>";
    Session cut, whole;
    cut.loadText(root(a + region + "</Node>" + bodyB("")), "cut.xml");
    whole.loadText(root(a + "</Node>" + bodyB("")), "whole.xml");
    const Seen left = runFor(cut, 12, "/B/s");
    ASSERT_EQ(left.report.end, RunEnd::done) << left.report.reason;
    EXPECT_LT(farthest(left, runFor(whole, 12, "/B/s")), 1e-11);
    EXPECT_TRUE(cut.simulation().hasChangedMeshes());
  }
}

std::string cutIntoTetrahedra(const std::string& grid, const std::string& cut, const std::string& more) {
  return root(grid + "<TetrahedronSetTopologyContainer name=\"t\"/><Hexa2TetraTopologicalMapping input=\"@g\" output=\"@t\" " +
              cut + "/><MechanicalObject name=\"s\" topology=\"@t\"/><MeshMatrixMass name=\"m\" massDensity=\"1\" topology=\"@t\"/>"
              "<TetrahedronFEMForceField youngModulus=\"3000\" poissonRatio=\"0.3\" topology=\"@t\"/>" +
              more);
}

TEST(ChangedScenes, CutsByTheNumberOfACellAreRefusedAndOthersFollow) {
  const std::string grid = "<RegularGridTopology name=\"g\" n=\"6 2 2\" min=\"0 0 0\" max=\"5 1 1\"/>",
                    left = "<RegularGridTopology name=\"g\" n=\"5 2 2\" min=\"1 0 0\" max=\"5 1 1\"/>";
  const std::string region = "<CarvingRegion topology=\"@g\" box=\"0.1 -9 -9 0.9 9 9\" begin=\"0.02\" end=\"0.02\"";
  for (const char* cut : {"cutting=\"five\"", "cutting=\"five1\"", "swapping=\"true\""})
    expectContains(reasonOf(cutIntoTetrahedra(grid, cut, region + "/>")), "would cut cells that stay another way");
  expectSame(cutIntoTetrahedra(grid, "", region + "/>"), cutIntoTetrahedra(left, "", ""));
}

TEST(ChangedScenes, PointsThatStayOfACutGridAreHeld) {
  const std::string grid = "<RegularGridTopology name=\"g\" n=\"6 2 2\" min=\"0 0 0\" max=\"5 1 1\"/>";
  const std::string region = "<CarvingRegion topology=\"@g\" box=\"0.1 -9 -9 0.9 9 9\" begin=\"0.02\" end=\"0.02\"";
  Session stay, go;
  stay.loadText(cutIntoTetrahedra(grid, "", region + " keepsPoints=\"true\"/>"), "stay.xml");
  go.loadText(cutIntoTetrahedra(grid, "", region + "/>"), "go.xml");
  const Seen held = runFor(stay, 10, "/s"), gone = runFor(go, 10, "/s");
  ASSERT_EQ(held.report.end, RunEnd::done) << held.report.reason;
  ASSERT_EQ(held.x.size(), 24u);
  Seen rest;
  for (std::size_t i = 0; i < held.x.size(); ++i) {
    if (held.rest[i].x() < 0.5) {
      EXPECT_EQ(held.v[i].norm(), 0) << i;
      continue;
    }
    rest.rest.push_back(held.rest[i]), rest.x.push_back(held.x[i]), rest.v.push_back(held.v[i]);
  }
  EXPECT_LT(farthest(gone, rest), 1e-11);
}

/// Four tetrahedra apart, the last of which goes at step 2.
std::string four(const std::string& field, int count = 4) {
  std::string places, cells;
  for (int k = 0; k < count; ++k) {
    places += fmt::format("{0} 0 0  {1} 0 0  {0} 1 0  {0} 0 1  ", 4 * k, 4 * k + 1);
    cells += fmt::format("{} {} {} {}  ", 4 * k, 4 * k + 1, 4 * k + 2, 4 * k + 3);
  }
  return root("<TetrahedronSetTopologyContainer name=\"t\" position=\"" + places + "\" tetrahedra=\"" + cells +
              "\"/><MechanicalObject name=\"s\"/><DiagonalMass massDensity=\"1000\"/><FixedProjectiveConstraint "
              "indices=\"0 1 3\"/>" +
              field);
}

TEST(ChangedScenes, ListsThatAreAsLongAsTheCellsAreManyStay) {
  const std::string fourth =
      "<TopologicalChangeProcessor useDataInputs=\"true\" timeToRemove=\"0.015\" tetrahedraToRemove=\"{}\"/>";
  const auto compare = [&](const std::string& field, int count) {
    Session cut, whole;
    cut.loadText(four(field + fmt::format(fmt::runtime(fourth), count - 1), count), "cut.xml");
    whole.loadText(four(field, count), "whole.xml");
    const Seen left = runFor(cut, 12, "/s"), all = runFor(whole, 12, "/s");
    ASSERT_EQ(left.report.end, RunEnd::done) << left.report.reason;
    ASSERT_EQ(left.x.size(), std::size_t(4 * count - 4));
    for (std::size_t i = 0; i < left.x.size(); ++i) EXPECT_LT((left.x[i] - all.x[i]).norm(), 1e-11) << field << i;
  };
  compare("<MJEDTetrahedralForceField materialName=\"StVenantKirchhoff\" ParameterSet=\"40000 60000\" viscous=\"true\" "
          "ParameterAlpha=\"0.2 0.2 0.2 0.3\" ParameterTau=\"0.02 0.05 0.1 0.2\"/>",
          4);
  compare("<MJEDTetrahedralForceField materialName=\"StVenantKirchhoff\" ParameterSet=\"40000 60000\"/>", 2);
  compare("<TetrahedronFEMForceField youngModulus=\"40000\" poissonRatio=\"0.3\"/><PlaneForceField normal=\"0 1 0\" d=\"-0.1\" "
          "stiffness=\"100\"/>",
          3);
  compare("<TetrahedronFEMForceField youngModulus=\"40000\" poissonRatio=\"0.3\"/><LinearForceField points=\"2\" "
          "times=\"0 1\" forces=\"0 0 0  0 1000 0\"/>",
          2);
  compare("<TetrahedronFEMForceField youngModulus=\"10000 20000 30000\" poissonRatio=\"0.3\"/>", 3);
}

TEST(ChangedScenes, NumbersOfNodesOfAnEngineAreNoNumbersOfANode) {
  Session session;
  session.loadText(root("<GridMeshCreator name=\"m\" resolution=\"3 3\"/><TriangleSetTopologyContainer src=\"@m\"/><MechanicalObject "
                        "name=\"s\"/><DiagonalMass massDensity=\"1\"/><TriangularFEMForceField youngModulus=\"30\" "
                        "poissonRatio=\"0.3\"/><TopologicalChangeProcessor useDataInputs=\"true\" timeToRemove=\"0.015\" "
                        "trianglesToRemove=\"0\"/>"),
                   "sheet.xml");
  const Seen seen = runFor(session, 4, "/s");
  EXPECT_EQ(seen.report.end, RunEnd::done) << seen.report.reason;
}

TEST(ChangedScenes, WhatNumbersNodesInOtherWaysIsRefused) {
  expectContains(reasonOf(bar(knife + "<OscillatorProjectiveConstraint name=\"o\" oscillators=\"18 0 1 1 0 1 0 1 0\"/>")),
                 "/o.oscillators numbers points");
  expectContains(reasonOf(bar(knife + "<PointsFromIndices name=\"p\" position=\"@s.rest_position\" indices=\"18\"/><Node "
                                      "name=\"c\"><MechanicalObject position=\"@../p.indices_position\"/>"
                                      "<BarycentricMapping/></Node>")),
                 "/p.indices may number points");
  const std::string free = "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><EulerExplicitSolver/>"
                           "<RegularGridTopology n=\"6 2 2\" min=\"0 0 0\" max=\"5 1 1\"/><MechanicalObject name=\"s\"/>"
                           "<UniformMass totalMass=\"24\"/>";
  expectContains(reasonOf(free + knife +
                          "<PositionBasedDynamicsProjectiveConstraint name=\"g\" stiffness=\"1\" "
                          "cluster=\"[0,1,6,7,12,13,18,19]\"/></Node>"),
                 "/g.cluster numbers points");
}

TEST(ChangedScenes, ValuesSetInTheRunAreAsIfTheyHadBeenWritten) {
  const std::string load = "<ConstantForceField name=\"c\" indices=\"0 6 12 18  5 11 17 23\" totalForce=\"0 {} 0\"/>";
  const std::string moduli = "<HexahedronFEMForceField name=\"h\" youngModulus=\"{}\" poissonRatio=\"0.4\"/>";
  const std::string of_cells = "3000 4000 5000 6000 7000";
  Session set, written;
  Simulation& simulation = set.loadText(
      bar(fmt::format(fmt::runtime(load), 10) + knife, fmt::format(fmt::runtime(moduli), "3000")), "set.xml");
  written.loadText(bar(fmt::format(fmt::runtime(load), 1000) + knife, fmt::format(fmt::runtime(moduli), of_cells)), "written.xml");
  simulation.setAttribute("/c", "totalForce", "0 1000 0");
  simulation.setAttribute("/h", "youngModulus", of_cells);
  const Seen one = runFor(set, 7, "/s"), other = runFor(written, 7, "/s");
  ASSERT_EQ(one.report.end, RunEnd::done) << one.report.reason;
  EXPECT_EQ(one.x.size(), 20u);
  EXPECT_LT(farthest(one, other), 1e-11);
  // reset() keeps the values, for the mesh that there was first
  simulation.reset();
  EXPECT_EQ(simulation.edits().size(), 2u);
  const Seen again = runFor(set, 7, "/s");
  ASSERT_EQ(again.report.end, RunEnd::done) << again.report.reason;
  EXPECT_LT(farthest(again, other), 1e-11);
  simulation.reset();
  simulation.takeEditsBack();
  EXPECT_EQ(findComponent(simulation.root(), "/h")->data().find("youngModulus")->print(), "3000");
}

TEST(ChangedScenes, AChangeThatFailsLeavesTheRunAsItWas) {
  Session session, whole, other;
  Simulation& simulation = session.loadText(bar(""), "scene.xml");
  whole.loadText(bar(""), "scene.xml");
  simulation.setAttribute("/h", "youngModulus", "4000");
  whole.simulation().setAttribute("/h", "youngModulus", "4000");
  runFor(session, 3, "/s"), runFor(whole, 3, "/s");
  const std::uint64_t hash = simulation.stateHash();
  Archive values = simulation.checkpoint().readable();  // not those of the shorter bar
  Session maker;
  Simulation& shorter = maker.loadText(shortBar("", hexes), "short.xml");
  EXPECT_ANY_THROW(simulation.become(std::make_unique<Simulation>(Scene(instantiate(shorter.scene().description, maker.factory(),
                                                                                    maker.modules()))),
                                     std::move(values)));
  EXPECT_EQ(simulation.stateHash(), hash);
  EXPECT_EQ(simulation.steps(), 3);
  EXPECT_EQ(simulation.edits().size(), 1u);
  EXPECT_FALSE(simulation.hasChangedMeshes());
  EXPECT_LT(farthest(runFor(session, 5, "/s"), runFor(whole, 5, "/s")), 1e-12);
  EXPECT_EQ(simulation.stateHash(), whole.simulation().stateHash());
}

class ChangedSceneFiles : public FolderTest {};

TEST_F(ChangedSceneFiles, APointThatGetsACellAgainIsFree) {
  const std::string file = write("held.txt", "T= 0.02\nREMOVE= 1\n2\nT= 0.04\nADD= Tetrahedra 1\n1 5 4 3\n");
  const std::string body =
      "<TetrahedronSetTopologyContainer name=\"t\" position=\"0 0 0  1 0 0  0 1 0  0 0 1  1 1 1  2 0 0\" "
      "tetrahedra=\"0 1 2 3  1 4 2 3  1 5 4 3\"/><MechanicalObject name=\"s\"/><DiagonalMass massDensity=\"1\"/>";
  Session session;
  session.loadText(root(body + "<TopologicalChangeProcessor filename=\"" + file + "\" keepsPoints=\"true\"/>"), "held.xml");
  const Seen seen = runFor(session, 10, "/s");
  ASSERT_EQ(seen.report.end, RunEnd::done) << seen.report.reason;
  ASSERT_EQ(seen.v.size(), 6u);
  EXPECT_NEAR(seen.v[1].y(), -10 * 0.10, 1e-9);
  EXPECT_NEAR(seen.v[5].y(), -10 * 0.06, 1e-9) << "it falls from t = 0.04 s on";
}

// ---- lists that go together, and what acts on nothing ----

std::string twoBars(const std::string& joint, const std::string& of_b = "") {
  const auto body = [](const char* name, int z, const std::string& more) {
    return fmt::format("<Node name=\"{}\"><RegularGridTopology n=\"6 2 2\" min=\"0 0 {}\" max=\"5 1 {}\"/><MechanicalObject "
                       "name=\"s\"/><DiagonalMass massDensity=\"1\"/>",
                       name, z, z + 1) +
           hexes + more + "</Node>";
  };
  return root(body("A", 0, knife) + body("B", 1, of_b) + joint);
}

/// Body B when the springs or attachments are those that are left, with the same bodies, and nothing else.
TEST(ChangedScenes, ListsThatGoTogetherFollow) {
  for (const std::string& joint :
       {std::string("<AttachProjectiveConstraint name=\"j\" object1=\"@A/s\" object2=\"@B/s\" indices1=\"12 13 15 23\" "
                    "indices2=\"0 1 3 11\"/>"),
        std::string("<SpringForceField name=\"j\" object1=\"@A/s\" object2=\"@B/s\" springsIndices1=\"12 13 15 23\" "
                    "springsIndices2=\"0 1 3 11\" lengths=\"0 0.1 0.2 0.3\" stiffness=\"100 200 300 400\" damping=\"1 2 3 4\"/>"),
        std::string("<SpringForceField name=\"j\" object1=\"@B/s\" object2=\"@A/s\" springsIndices1=\"0 1 3 11\" "
                    "springsIndices2=\"12 13 15 23\" lengths=\"0 0.1 0.2 0.3\" stiffness=\"100 200 300 400\" "
                    "damping=\"1 2 3 4\"/>")}) {
    Session session;
    session.loadText(twoBars(joint), "two.xml");
    const Seen seen = runFor(session, 6, "/A/s");
    ASSERT_EQ(seen.report.end, RunEnd::done) << seen.report.reason;
    const Component& j = *findComponent(session.simulation().root(), "/j");
    // nodes of A now: 0, 6, 12, 18 have gone; by their places
    const char* const of_a[] = {"indices1", "springsIndices1", "springsIndices2"};
    for (const char* name : of_a) {
      const Data* data = j.data().find(name);
      if (!data) continue;
      const auto& list = *std::get<std::vector<int>*>(data->pointer());
      ASSERT_EQ(list.size(), 3u) << name;
    }
    const bool turned = joint.find("object1=\"@B/s\"") != std::string::npos;
    const Data* mine = j.data().find(joint.starts_with("<Attach") ? "indices1" : turned ? "springsIndices2" : "springsIndices1");
    const Data* its = j.data().find(joint.starts_with("<Attach") ? "indices2" : turned ? "springsIndices1" : "springsIndices2");
    EXPECT_EQ(*std::get<std::vector<int>*>(its->pointer()), (std::vector<int>{1, 3, 11}));
    const Vec3 places[] = {{1, 0, 1}, {3, 0, 1}, {5, 1, 1}};
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(seen.rest[std::size_t((*std::get<std::vector<int>*>(mine->pointer()))[k])], places[k]) << k;
    if (const Data* lengths = j.data().find("lengths")) EXPECT_EQ(lengths->print(), "0.1 0.2 0.3");
    if (const Data* stiffness = j.data().find("springsIndices1") ? j.data().find("stiffness") : nullptr)
      EXPECT_EQ(stiffness->print(), "200 300 400");
  }
}

/// The first cell of A and the last one of B go at once. Of pairs of nodes at x = 0, 1, 3, 5 those at 1 and 3 are left.
TEST(ChangedScenes, WhatTiesTwoBodiesThatBothLosePointsFollowsBoth) {
  for (const char* joint :
       {"<AttachProjectiveConstraint name=\"j\" object1=\"@A/s\" object2=\"@B/s\" indices1=\"12 13 15 23\" indices2=\"0 1 3 11\"/>",
        "<SpringForceField name=\"j\" object1=\"@A/s\" object2=\"@B/s\" springsIndices1=\"12 13 15 23\" springsIndices2=\"0 1 3 11\" "
        "lengths=\"0 0.1 0.2 0.3\" stiffness=\"100 200 300 400\" damping=\"1 2 3 4\"/>",
        "<BilateralLagrangianConstraint name=\"j\" object1=\"@A/s\" object2=\"@B/s\" first_point=\"12 13 15 23\" "
        "second_point=\"0 1 3 11\"/>"}) {
    Session session;
    session.loadText(twoBars(joint, "<CarvingRegion box=\"4.1 -9 -9 4.9 9 9\" begin=\"0.02\" end=\"0.02\"/>"), "two.xml");
    const Seen a = runFor(session, 6, "/A/s");
    ASSERT_EQ(a.report.end, RunEnd::done) << a.report.reason;
    const auto& b = dynamic_cast<const State&>(*findComponent(session.simulation().root(), "/B/s"));
    EXPECT_EQ(b.nodes(), 20);
    const DataTable& data = findComponent(session.simulation().root(), "/j")->data();
    const auto list = [&data](const char* spring, const char* attach, const char* tie) {
      const Data* found = data.find(spring) ? data.find(spring) : data.find(attach) ? data.find(attach) : data.find(tie);
      return *std::get<std::vector<int>*>(found->pointer());
    };
    const std::vector<int> first = list("springsIndices1", "indices1", "first_point"),
                           second = list("springsIndices2", "indices2", "second_point");
    ASSERT_EQ(first.size(), 2u) << joint;
    ASSERT_EQ(second.size(), 2u) << joint;
    for (std::size_t k = 0; k < 2; ++k) {
      const Vec3 place(k == 0 ? 1 : 3, 0, 1);
      EXPECT_EQ(a.rest[std::size_t(first[k])], place) << joint;
      EXPECT_EQ(b.rest_position[std::size_t(second[k])], place) << joint;
    }
    if (data.find("springsIndices1")) EXPECT_EQ(data.find("stiffness")->print(), "200 300");
  }
}

/// Of 24 nodes: what 8 points remember is as long as a number of each node. Point 0 goes in the second one.
TEST(ChangedScenes, PointsHeldByForcesOfConstraintStayWhereTheyAreHeld) {
  const std::string held = "<FixedLagrangianConstraint name=\"l\" indices=\"";
  expectSame(bar(held + "4 5 10 11 16 17 22 23\"/>" + knife), shortBar(held + "3 4 8 9 13 14 18 19\"/>", hexes));
  expectSame(bar(held + "0 5 11 23\"/>" + knife), shortBar(held + "4 9 19\"/>", hexes));
  const std::string rod = "<DistanceLagrangianConstraint name=\"l\" first_point=\"";
  expectSame(bar(rod + "0 5 11\" second_point=\"3 2 6\" distances=\"3 3 5\"/>" + knife),
             shortBar(rod + "4\" second_point=\"1\" distances=\"3\"/>", hexes));
}

TEST(ChangedScenes, TiesLetGoOfPointsThatGo) {
  Session session;
  session.loadText(twoBars("<BilateralLagrangianConstraint name=\"j\" object1=\"@A/s\" object2=\"@B/s\" first_point=\"12 13 15 23\" "
                           "second_point=\"0 1 3 11\" rest_vector=\"0 0 0  0 0 0.1  0 0 0.2  0 0 0.3\"/>"),
                   "two.xml");
  const Seen seen = runFor(session, 6, "/A/s");
  ASSERT_EQ(seen.report.end, RunEnd::done) << seen.report.reason;
  const DataTable& data = findComponent(session.simulation().root(), "/j")->data();
  const auto& mine = *std::get<std::vector<int>*>(data.find("first_point")->pointer());
  EXPECT_EQ(*std::get<std::vector<int>*>(data.find("second_point")->pointer()), (std::vector<int>{1, 3, 11}));
  EXPECT_EQ(data.find("rest_vector")->print(), "0 0 0.1 0 0 0.2 0 0 0.3");
  ASSERT_EQ(mine.size(), 3u);
  EXPECT_EQ(seen.rest[std::size_t(mine[0])], Vec3(1, 0, 1));
}

TEST(ChangedScenes, WhatActsOnNothingIsLeftOut) {
  expectSame(bar("<BoxROI name=\"r\" box=\"-0.1 -1 -1 0.1 2 2\"/><ConstantForceField indices=\"@r.indices\" force=\"0 1 0\"/>"
                 "<ConstantForceField indices=\"0\" totalForce=\"0 0 1\"/><FixedProjectiveConstraint indices=\"0\"/>"
                 "<ConstantForceField indices=\"5\" force=\"1 0 0\"/>" +
                 knife),
             shortBar("<ConstantForceField indices=\"4\" force=\"1 0 0\"/>", hexes));
}

TEST(ChangedScenes, DensitiesOfCellsFollow) {
  const auto body = [](const std::string& grid, const std::string& densities, const std::string& more) {
    return root("<RegularGridTopology " + grid + "/><MechanicalObject name=\"s\"/><DiagonalMass massDensity=\"" + densities +
                "\"/>" + hexes + more);
  };
  expectSame(body("n=\"6 2 2\" min=\"0 0 0\" max=\"5 1 1\"", "1 2 3 4 5", knife),
             body("n=\"5 2 2\" min=\"1 0 0\" max=\"5 1 1\"", "2 3 4 5", ""));
}

TEST(ChangedScenes, AForceOnAnotherBodyIsNoHindrance) {
  Session session;
  Simulation& simulation = session.loadText(
      root("<Node name=\"A\"><RegularGridTopology n=\"6 2 2\" min=\"0 0 0\" max=\"5 1 1\"/><MechanicalObject name=\"s\"/>"
           "<DiagonalMass massDensity=\"1\"/>" +
           hexes + knife +
           "</Node><Node name=\"B\"><MechanicalObject name=\"s\" position=\"9 9 9\"/><UniformMass totalMass=\"2\"/></Node>"),
      "pulled.xml");
  Input input;
  input.state = "/B/s", input.nodes = {0}, input.force = Vec3(4, 0, 0);
  simulation.addInput(input);
  const Seen seen = runFor(session, 6, "/B/s");
  ASSERT_EQ(seen.report.end, RunEnd::done) << seen.report.reason;
  EXPECT_TRUE(simulation.hasChangedMeshes());
  EXPECT_NEAR(seen.v[0].x(), 4. / 2 * 0.06, 1e-12);
}

/// Node 0 goes at t = 0.02 and node 1, which the hand pulls too, is the first of the bar without that cell.
TEST(ChangedScenes, AForceFromOutsideActsOnWhatIsLeftOfItsNodes) {
  const std::string fields = "<HexahedronFEMForceField youngModulus=\"3000\" poissonRatio=\"0.4\"/>";
  Input pull;
  pull.state = "/s", pull.nodes = {0, 1}, pull.force = Vec3(3, 0, 0), pull.stiffness = 50, pull.damping = 2;
  pull.targets = {Vec3(0, 1, 0), Vec3(1, 2, 0)};
  Session session, other;
  Simulation& simulation = session.loadText(bar(knife, fields), "bar.xml");
  const long both = simulation.addInput(pull);
  pull.nodes = {0}, pull.targets = {Vec3(9, 9, 9)};
  const long gone = simulation.addInput(pull);
  const Seen before = runFor(session, 2, "/s"), after = runFor(session, 6, "/s");
  ASSERT_EQ(after.report.end, RunEnd::done) << after.report.reason;
  Simulation& reference = other.loadText(shortBar("", fields), "short.xml");
  const auto& state = dynamic_cast<const State&>(*findComponent(reference.root(), "/s"));
  Vector x(state.size()), v(state.size());
  for (Index i = 0; i < state.size(); ++i)
    for (std::size_t j = 0; j < before.rest.size(); ++j)
      if ((before.rest[j] - state.rest_position[std::size_t(i)]).norm() < 1e-12) x[i] = before.x[j], v[i] = before.v[j];
  reference.setState(state, x, v);
  pull.targets = {Vec3(1, 2, 0)};
  reference.addInput(pull);
  EXPECT_LT(farthest(after, runFor(other, 6, "/s")), 1e-9);
  EXPECT_NO_THROW(simulation.removeInput(both));
  EXPECT_THROW(simulation.removeInput(gone), ComponentError) << "nothing of it is left";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
