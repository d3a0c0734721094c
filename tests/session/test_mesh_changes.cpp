// SPDX-License-Identifier: LGPL-2.1-or-later
// Meshes that change while a scene runs. References: SOFA's rule of numbers by hand; the scene without the cells, started from the
// state that the run has then; and bodies that the change does not touch, which must move as if it had not been.
#include <fmt/format.h>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/mass.h"
#include "tests/session/seen_runs.h"
#include "tests/support/folder_fixture.h"
#include "tools/session/mesh_edit.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

// ---- numbers ----

Mesh twoTetrahedraApart() {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) mesh.position.emplace_back(i, i % 3, i % 2);
  mesh.tetrahedra = {{1, 3, 5, 7}, {0, 2, 4, 6}};
  mesh.triangles = {{1, 3, 5}, {0, 2, 4}, {3, 5, 7}};
  return mesh;
}

TEST(MeshEdit, TheLastTakesTheNumberThatGoesTheLargestFirst) {
  const Mesh mesh = twoTetrahedraApart();
  MeshEdit edit(mesh);
  MeshChange change;
  change.kind = &cell_kinds::tetrahedron, change.removed = {0};
  edit.make(change);
  // points 7, 5, 3, 1 go: 6 takes 5, then (of 0 1 2 3 4 6) 6 takes 3, then (of 0 1 2 6 4) 4 takes 1
  EXPECT_EQ(edit.points().of, (std::vector<Index>{0, 4, 2, 6}));
  EXPECT_EQ(edit.mesh().tetrahedra, (std::vector<Tetrahedron>{{0, 2, 1, 3}}));
  EXPECT_EQ(edit.mesh().triangles, (std::vector<Triangle>{{0, 2, 1}}))
      << "a face of what went goes, that of what stays stays";
  EXPECT_EQ(edit.cells().triangles.of, (std::vector<Index>{1}));
  EXPECT_EQ(edit.mesh().position[3], mesh.position[6]);
  EXPECT_EQ(edit.points().now(), (std::vector<Index>{0, -1, 2, -1, 1, -1, 3, -1}));
}

TEST(MeshEdit, PointsMayStayAndPointsAndCellsCome) {
  const Mesh mesh = twoTetrahedraApart();
  MeshEdit edit(mesh);
  MeshChange change;
  change.kind = &cell_kinds::tetrahedron, change.removed = {0, 0}, change.keeps_points = true;
  edit.make(change);
  EXPECT_TRUE(edit.points().areTheSame());
  EXPECT_EQ(edit.loosePoints(), (std::vector<Index>{1, 3, 5, 7}));
  MeshChange more;
  more.points = {{{0, 0.5}, {2, 0.5}}};
  more.kind = &cell_kinds::tetrahedron, more.added = {{1, 3, 5, 8}};
  edit.make(more);
  EXPECT_EQ(edit.mesh().position.back(), (mesh.position[0] + mesh.position[2]) / 2);
  EXPECT_EQ(edit.loosePoints(), (std::vector<Index>{7}));
  EXPECT_EQ(edit.cells().tetrahedra.of, (std::vector<Index>{1, -1}));
}

TEST(MeshEdit, RefusesWhatIsNotThereAndWhatIsStillNeeded) {
  MeshEdit edit(twoTetrahedraApart());
  MeshChange change;
  change.kind = &cell_kinds::tetrahedron, change.removed = {2};
  EXPECT_THROW(edit.make(change), ComponentError);
  change.kind = &cell_kinds::point, change.removed = {3};
  EXPECT_THROW(edit.make(change), ComponentError);
}

// ---- runs ----

Seen ran(const std::string& text, long steps, const std::string& state = "/dofs") {
  Session session;
  session.loadText(text, "scene.xml");
  return runFor(session, steps, state);
}

std::string scene(const std::string& content,
                  const std::string& solvers = "<EulerImplicitSolver rayleighStiffness=\"0.01\"/><SparseLDLSolver/>") {
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"1 -9.81 2\">" + solvers + content + "</Node>";
}

const std::string hexes =
    "<MeshMatrixMass massDensity=\"1000\"/><HexahedronFEMForceField youngModulus=\"20000\" "
    "poissonRatio=\"0.4\"/><BoxROI name=\"end\" "
    "box=\"-1 -1 -1 0.001 1 1\"/><FixedProjectiveConstraint indices=\"@end.indices\"/>";

TEST(MeshChanges, WhatIsLeftOfABarMovesAsTheSceneWithoutTheCells) {
  const std::string bar =
      "<RegularGridTopology name=\"grid\" n=\"5 2 3\" min=\"0 0 0\" max=\"0.4 0.1 0.2\"/><MechanicalObject "
      "name=\"dofs\"/>";
  const std::string knife =
      "<TopologicalChangeProcessor useDataInputs=\"true\" timeToRemove=\"0.035\" hexahedraToRemove=\"3 7\"/>";
  const Seen at_change = ran(scene(bar + hexes), 4), cut = ran(scene(bar + hexes + knife), 20);
  ASSERT_EQ(cut.report.end, RunEnd::done) << cut.report.reason;
  EXPECT_EQ(at_change.x.size(), 30u);
  EXPECT_EQ(cut.x.size(), 24u);

  Session session;
  Simulation& short_bar =
      session.loadText(scene("<RegularGridTopology n=\"4 2 3\" min=\"0 0 0\" max=\"0.3 0.1 0.2\"/><MechanicalObject "
                             "name=\"dofs\"/>" +
                             hexes),
                       "short.xml");
  const State& state = *short_bar.states()[0];
  Vector x(state.size()), v(state.size());
  for (Index i = 0; i < state.size(); ++i)
    for (std::size_t j = 0; j < at_change.rest.size(); ++j)
      if ((at_change.rest[j] - state.rest_position[std::size_t(i)]).norm() < 1e-12)
        x[i] = at_change.x[j], v[i] = at_change.v[j];
  short_bar.setState(state, x, v);
  EXPECT_LT(farthest(runFor(session, 16, "/dofs"), cut), 1e-11);
}

/// Two bodies in one mesh that share nothing: a tetrahedron that goes, and a strip that stays.
std::string twoBodies(const std::string& fields, const std::string& solvers, const std::string& more) {
  return scene(
      "<TetrahedronSetTopologyContainer name=\"mesh\" position=\"5 0 0  0 0 0  6 0 0  1 0 0  5 1 0  0 1 0  5 0 1  0 0 "
      "1  1 1 1\" "
      "tetrahedra=\"0 2 4 6  1 3 5 7  3 8 5 7\"/><MechanicalObject name=\"dofs\"/><DiagonalMass massDensity=\"100\"/>"
      "<FixedProjectiveConstraint indices=\"1 5 0 4\"/>" +
          fields + more,
      solvers);
}

TEST(MeshChanges, WhatIsNotTouchedKeepsEveryMemory) {
  const std::string gone =
      "<TopologicalChangeProcessor useDataInputs=\"true\" timeToRemove=\"0.055\" tetrahedraToRemove=\"0\"/>";
  const std::string elastic = "<TetrahedronFEMForceField youngModulus=\"10000\" poissonRatio=\"0.3\"/>";
  const std::string plastic =
      elastic +
      "<PlasticStrainForceField youngModulus=\"10000\" poissonRatio=\"0.3\" plasticYieldThreshold=\"0.001\" "
      "plasticMaxThreshold=\"0.2\" plasticCreep=\"0.1\"/>";
  const std::string viscous =
      "<MJEDTetrahedralForceField materialName=\"StVenantKirchhoff\" ParameterSet=\"4000 6000\" viscous=\"true\" "
      "ParameterAlpha=\"0.5\" ParameterTau=\"0.05\"/>";
  const std::string of_cells =
      "<TetrahedronFEMForceField youngModulus=\"5000 10000 20000\" poissonRatio=\"0.3\"/><ConstantForceField "
      "indices=\"6 8 3\" forces=\"9 9 9  3 0 0  0 4 0\"/>";
  const std::string direct = "<SparseLDLSolver/>";
  for (const auto& [solvers, fields] : std::vector<std::pair<std::string, std::string>>{
           {"<EulerImplicitSolver/>" + direct, elastic},
           {"<EulerImplicitSolver rayleighStiffness=\"0.01\"/>" + direct, plastic},
           {"<EulerImplicitSolver/>" + direct, of_cells},
           {"<BDFOdeSolver order=\"2\"/>" + direct, elastic},
           {"<NewmarkImplicitSolver/>" + direct, elastic},
           {"<TrapezoidalRuleSolver/>" + direct, viscous},
           {"<CentralDifferenceSolver/>", elastic},
           {"<RungeKutta4Solver/>", viscous}}) {
    const Seen whole = ran(twoBodies(fields, solvers, ""), 15), cut = ran(twoBodies(fields, solvers, gone), 15);
    ASSERT_EQ(cut.report.end, RunEnd::done) << solvers << cut.report.reason;
    ASSERT_EQ(cut.x.size(), 5u) << solvers;
    double largest = 0, moved = 0;
    for (std::size_t i = 0; i < cut.x.size(); ++i)
      for (std::size_t j = 0; j < whole.x.size(); ++j)
        if (whole.rest[j] == cut.rest[i]) {
          largest = std::max({largest, (whole.x[j] - cut.x[i]).norm(), 0.1 * (whole.v[j] - cut.v[i]).norm()});
          moved = std::max(moved, (whole.x[j] - whole.rest[j]).norm());
        }
    EXPECT_LT(largest, 1e-12) << solvers << fields;
    EXPECT_GT(moved, 1e-3) << solvers;
  }
}

double massOf(const Simulation& simulation) {
  std::vector<Mass*> masses;
  simulation.root().collect(masses);
  double sum = 0;
  for (const double mass : masses[0]->rowSums()) sum += mass;
  return sum;
}

TEST(MeshChanges, TheMassOfWhatGoesGoesAndResetBringsItBack) {
  Session session;
  Simulation& simulation = session.loadText(
      scene("<RegularGridTopology n=\"3 2 2\" min=\"0 0 0\" max=\"0.2 0.1 0.1\"/><MechanicalObject name=\"dofs\"/>" +
            hexes + "<CarvingRegion name=\"knife\" box=\"0.1 0 0 0.3 1 1\" begin=\"0.02\"/>"),
      "scene.xml");
  const std::uint64_t start = simulation.stateHash();
  EXPECT_NEAR(massOf(simulation), 2, 1e-12);
  const Seen first = runFor(session, 6, "/dofs");
  EXPECT_EQ(first.report.end, RunEnd::done) << first.report.reason;
  EXPECT_NEAR(massOf(simulation), 1, 1e-12);
  EXPECT_EQ(first.x.size(), 8u);
  const std::uint64_t hash = simulation.stateHash();
  EXPECT_TRUE(simulation.hasChangedMeshes());
  simulation.reset();
  EXPECT_EQ(simulation.stateHash(), start);
  EXPECT_NEAR(massOf(simulation), 2, 1e-12);
  EXPECT_FALSE(simulation.hasChangedMeshes());
  runFor(session, 6, "/dofs");
  EXPECT_EQ(simulation.stateHash(), hash);
}

TEST(MeshChanges, AMassAndALoadGivenAsAWholeKeepTheirShares) {
  const std::string bar =
      "<RegularGridTopology n=\"3 2 2\" min=\"0 0 0\" max=\"0.3 0.1 0.1\"/><MechanicalObject name=\"dofs\"/>";
  const std::string knife = "<CarvingRegion box=\"0.16 0 0 0.3 1 1\" begin=\"0.02\"/>";
  for (const auto& [mass, left] :
       std::vector<std::pair<std::string, double>>{{"<UniformMass totalMass=\"6\"/>", 4.},
                                                   {"<DiagonalMass totalMass=\"6\"/>", 3.},
                                                   {"<MeshMatrixMass totalMass=\"6\"/>", 3.}}) {
    Session session;
    session.loadText(scene(bar + mass + "<ConstantForceField totalForce=\"0 12 0\"/>" + knife), "scene.xml");
    const Seen told = runFor(session, 5, "/dofs");
    ASSERT_EQ(told.report.end, RunEnd::done) << told.report.reason;
    EXPECT_NEAR(massOf(session.simulation()), left, 1e-12) << mass;
    const Data& force = *findComponent(session.simulation().root(), "/ConstantForceField")->data().find("totalForce");
    EXPECT_NEAR(std::get<std::vector<double>*>(force.pointer())->at(1), 8, 1e-12);
  }
}

TEST(MeshChanges, PointsThatStayKeepTheirNumbersAndAreHeld) {
  const std::string bar =
      "<RegularGridTopology n=\"3 2 2\" min=\"0 0 0\" max=\"0.2 0.1 0.1\"/><MechanicalObject name=\"dofs\"/>" + hexes;
  const std::string knife = "<CarvingRegion box=\"0.1 0 0 0.3 1 1\" begin=\"0.02\" ";
  const Seen stay = ran(scene(bar + knife + "keepsPoints=\"true\"/>"), 10), go = ran(scene(bar + knife + "/>"), 10);
  ASSERT_EQ(stay.report.end, RunEnd::done) << stay.report.reason;
  ASSERT_EQ(stay.x.size(), 12u);
  double largest = 0;
  for (std::size_t i = 0; i < go.x.size(); ++i)
    for (std::size_t j = 0; j < stay.x.size(); ++j)
      if ((go.rest[i] - stay.rest[j]).norm() < 1e-12) largest = std::max(largest, (go.x[i] - stay.x[j]).norm());
  EXPECT_LT(largest, 1e-12);
  for (std::size_t j = 0; j < stay.x.size(); ++j)
    if (stay.rest[j].x() > 0.15) EXPECT_EQ(stay.v[j].norm(), 0) << j;
}

TEST(MeshChanges, SurfacesAndWhatFollowsThemFollow) {
  Session session;
  Simulation& simulation = session.loadText(
      scene("<RegularGridTopology n=\"4 2 2\" min=\"0 0 0\" max=\"0.3 0.1 0.1\"/><MechanicalObject name=\"dofs\"/>" +
            hexes +
            "<TopologicalChangeProcessor useDataInputs=\"true\" timeToRemove=\"0.015\" hexahedraToRemove=\"2\"/><Node "
            "name=\"skin\">"
            "<QuadSetTopologyContainer name=\"quads\"/><Hexa2QuadTopologicalMapping input=\"@../RegularGridTopology\" "
            "output=\"@quads\"/>"
            "<MechanicalObject name=\"dofs\"/><IdentityMapping/></Node>"
            "<Node name=\"probe\"><MechanicalObject name=\"dofs\" position=\"0.15 0.05 "
            "0.05\"/><BarycentricMapping/></Node>"),
      "scene.xml");
  const Seen body = runFor(session, 4, "/dofs"), skin = runFor(session, 0, "/skin/dofs"),
             probe = runFor(session, 0, "/probe/dofs");
  ASSERT_EQ(body.report.end, RunEnd::done) << body.report.reason;
  EXPECT_EQ(body.x.size(), 12u);
  EXPECT_EQ(skin.x, body.x);
  const auto* quads = dynamic_cast<const Topology*>(findComponent(simulation.root(), "/skin/quads"));
  EXPECT_EQ(quads->mesh().quads.size(), 10u) << "of two cubes in a row";
  Vec3 middle = Vec3::Zero();
  for (std::size_t i = 0; i < body.x.size(); ++i)
    if (body.rest[i].x() > 0.05) middle += body.x[i] / 8;
  EXPECT_LT((probe.x[0] - middle).norm(), 1e-12);
}

/// A bar whose lateral faces of one side are loaded, cut so that one of them goes: what is loaded is what is left of them.
/// The sum of the loads by areas, whether points go or stay.
TEST(MeshChanges, NumbersOfFacesFollow) {
  const std::string loads[] = {"<SurfaceTractionForceField name=\"load\" traction=\"0 0 10\" quadIndices=\"FACES\" area=\"rest\"/>",
                               "<SurfacePressureForceField name=\"load\" pressure=\"10\" quadIndices=\"FACES\"/>"};
  for (const std::string& load : loads)
    for (const char* keeps : {"false", "true"}) {
      // quads of the side z = 0.1, as their numbers in the boundary
      Session session;
      std::string positions, hexahedra, quads;
      for (int k = 0; k < 2; ++k)
        for (int j = 0; j < 2; ++j)
          for (int i = 0; i < 5; ++i) positions += fmt::format("{} {} {}  ", 0.1 * i, 0.1 * j, 0.1 * k);
      for (int i = 0; i < 4; ++i) {
        hexahedra += fmt::format("{} {} {} {} {} {} {} {}  ", i, i + 1, i + 6, i + 5, i + 10, i + 11, i + 16, i + 15);
        quads += fmt::format("{} {} {} {}  {} {} {} {}  ", i + 10, i + 11, i + 16, i + 15, i, i + 5, i + 6, i + 1);
      }
      std::string text = load;
      text.replace(text.find("FACES"), 5, "0 2 4 6");
      session.loadText("<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><EulerExplicitSolver/>"
                       "<MeshTopology name=\"mesh\" position=\"" +
                           positions + "\" hexahedra=\"" + hexahedra + "\" quads=\"" + quads +
                           "\"/><MechanicalObject name=\"dofs\"/><DiagonalMass massDensity=\"1000\"/>" + text +
                           "<CarvingRegion box=\"0.15 -9 -9 0.25 9 9\" begin=\"0.005\" end=\"0.015\" keepsPoints=\"" + keeps +
                           "\"/></Node>",
                       "scene.xml");
      const Seen seen = runFor(session, 3, "/dofs");
      ASSERT_EQ(seen.report.end, RunEnd::done) << seen.report.reason;
      const System& system = *session.simulation().systems()[0];
      Vector f(system.allRows());
      clear(f);
      system.forceFields()[0]->addForce(system.x, system.v, f);
      Vec3 sum = Vec3::Zero();
      for (Index i = 0; i < f.count(); ++i) sum += f[i];
      const Data& faces = *system.forceFields()[0]->data().find("quadIndices");
      const std::size_t left = std::get<std::vector<int>*>(faces.pointer())->size();
      EXPECT_LT(left, 4u) << load;
      EXPECT_NEAR(sum.z(), 10 * 0.01 * double(left), 1e-4) << load << keeps;
      for (Index i = 0; i < f.count(); ++i)
        if (f[i].norm() > 0) EXPECT_NEAR(seen.rest[std::size_t(i)].z(), 0.1, 1e-12) << load << keeps;
    }
}

class ChangeFiles : public FolderTest {};

TEST_F(ChangeFiles, BringCellsAndPoints) {
  const std::string path =
      write("changes.txt",
            "T= 0.025\nADD= PointInTriangle 1\n0 0.25 0.25\n# a comment\nADD= Triangles 2\n0 1 4 1 2 4\n"
            "T= 0.045\nREMOVE= 1\n0\n");
  const std::string sheet =
      "<TriangleSetTopologyContainer position=\"0 0 0 1 0 0 0 1 0 1 1 0\" triangles=\"0 1 2 1 3 2\"/><MechanicalObject "
      "name=\"dofs\" velocity=\"1 0 0  0 1 0  0 0 2  0 0 0\"/><UniformMass vertexMass=\"1\"/>";
  const std::string file = "<TopologicalChangeProcessor filename=\"" + path + "\"/>";
  const std::string free = "<EulerExplicitSolver/>";
  const Seen four = ran(scene(sheet + file, free), 4);
  ASSERT_EQ(four.report.end, RunEnd::done) << four.report.reason;
  ASSERT_EQ(four.x.size(), 5u);
  const Vec3 v = Vec3(0.25, 0.25, 1) + 0.04 * Vec3(1, -9.81, 2);
  EXPECT_LT((four.v[4] - v).norm(), 1e-13) << "it moves as its shares of the corners";
  EXPECT_LT((four.x[4] - (four.x[0] / 4 + four.x[1] / 4 + four.x[2] / 2)).norm(), 1e-13);
  const Seen six = ran(scene(sheet + file, free), 6);
  EXPECT_EQ(six.x.size(), 5u) << "the new cells need all points of the one that went";
}

// ---- what cannot be ----

std::string endOf(const std::string& more, long steps = 5) {
  const Seen told = ran(
      scene("<RegularGridTopology n=\"3 2 2\" min=\"0 0 0\" max=\"0.2 0.1 0.1\"/><MechanicalObject name=\"dofs\"/>" +
            hexes + more),
      steps);
  EXPECT_EQ(told.report.end, RunEnd::mesh_refused);
  return told.report.reason;
}

TEST_F(ChangeFiles, WhatCannotFollowEndsTheRunWithASentence) {
  const std::string knife =
      "<TopologicalChangeProcessor name=\"knife\" useDataInputs=\"true\" timeToRemove=\"0.015\" hexahedraToRemove=\"";
  expectContains(endOf(knife + "7\"/>"), "there is no hexahedron 7: there are 2");
  expectContains(endOf(knife + "0 1\"/>"), "changed scene is not valid");
  expectContains(endOf(knife + "1\"/><Monitor indices=\"2 3\" ExportPositions=\"true\" fileName=\"" + file("watched") + "\"/>"),
                 "names a point that goes");
  expectContains(endOf(knife + "1\"/><Node><MechanicalObject/><SubsetMapping indices=\"0 3\"/></Node>"),
                 "numbers points");
  expectContains(endOf(knife + "1\"/><CableConstraint indices=\"1 2\" pullPoint=\"-0.1 0 0\" valueType=\"force\" value=\"1\"/>"),
                 "names a point that goes");
  expectContains(endOf(knife + "1\"/><Node><QuadSetTopologyContainer name=\"q\"/><Hexa2QuadTopologicalMapping "
                               "input=\"@../RegularGridTopology\" output=\"@q\"/><QuadPressureForceField pressure=\"0 1 0\" "
                               "quadList=\"0\"/></Node>"),
                 "numbers cells of a mesh that is made of the one that changes");

  Session session;
  session.loadText(
      scene("<RegularGridTopology n=\"3 2 2\" min=\"0 0 0\" max=\"0.2 0.1 0.1\"/><MechanicalObject name=\"dofs\"/>" +
            hexes + knife + "1\"/>"),
      "scene.xml");
  const RunReport report = session.run({.steps = 5});
  EXPECT_EQ(report.end, RunEnd::diverged);
  EXPECT_EQ(session.simulation().steps(), 2);
  expectContains(report.reason, "does not follow");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
