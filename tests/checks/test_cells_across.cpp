// SPDX-License-Identifier: LGPL-2.1-or-later
// How many cells lie over the thickness of a body, and what is said of too few.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cmath>

#include "tests/support/meshes.h"
#include "tests/support/scene_text.h"
#include "tools/checks/cells_across.h"
#include "tools/checks/mesh_error.h"

namespace stroma::test {
namespace {

/// nx x ny x nz cubes with an edge of one.
Mesh beam(int nx, int ny, int nz) {
  Mesh mesh = gridMesh(nx, ny, nz);
  Vec3 high = Vec3::Zero();
  for (const Vec3& p : mesh.position) high = high.cwiseMax(p);
  for (Vec3& p : mesh.position) p = p.cwiseQuotient(high).cwiseProduct(Vec3(nx, ny, nz));
  return mesh;
}

TEST(CellsAcross, ABeamOfHexahedraIsCounted) {
  for (const int n : {1, 2, 4}) {
    const Mesh mesh = beam(10 * n, n, n);
    const Slenderness body = slenderness(mesh.hexahedra, mesh.position);
    EXPECT_NEAR(body.extent, 10 * n, 1e-12);
    EXPECT_NEAR(body.thickness, n, 1e-12);
    EXPECT_EQ(body.cells, n);
    EXPECT_TRUE(body.isSlender());
    EXPECT_NE(tooCoarseForBending(body, true), "") << n;
  }
}

TEST(CellsAcross, ABeamOfTetrahedraIsCountedByTheCubesThatTheyFill) {
  for (const int n : {2, 4}) {
    const Mesh mesh = tetrahedronMesh(10 * n, n, n, HexahedronCut::six, 0);
    const Slenderness body = slenderness(mesh.tetrahedra, mesh.position);
    EXPECT_TRUE(body.isSlender());
    EXPECT_NEAR(body.cells, n, 0.25 * n);
    EXPECT_NE(tooCoarseForBending(body, false), "") << n;
  }
}

/// A box with a channel along it: walls of three cells, which are what bends, among lines of nine.
TEST(CellsAcross, WallsOfAHollowBodyAreWhatIsCounted) {
  Mesh mesh = beam(40, 9, 9);
  std::erase_if(mesh.hexahedra, [&mesh](const Hexahedron& cell) {
    Vec3 centre = Vec3::Zero();
    for (const Index n : cell) centre += mesh.position[std::size_t(n)] / 8;
    return centre.x() > 3 && centre.x() < 37 && (centre - Vec3(centre.x(), 4.5, 4.5)).cwiseAbs().maxCoeff() < 1.5;
  });
  const Slenderness body = slenderness(mesh.hexahedra, mesh.position);
  EXPECT_TRUE(body.isSlender());
  EXPECT_EQ(body.cells, 3);
  EXPECT_NEAR(body.thickness, 3, 1e-12);
  EXPECT_NE(tooCoarseForBending(body, true), "");
}

/// A slice in plane strain has one cell across, along which nothing moves; a beam in it bends in its plane.
TEST(CellsAcross, WhatIsHeldAcrossDoesNotBendThere) {
  const Mesh plate = beam(40, 20, 1), strip = beam(80, 8, 1);
  EXPECT_NE(tooCoarseForBending(slenderness(plate.hexahedra, plate.position), true), "");
  EXPECT_EQ(tooCoarseForBending(slenderness(plate.hexahedra, plate.position, Vec3::UnitZ()), true), "");
  const Slenderness body = slenderness(strip.hexahedra, strip.position, Vec3::UnitZ());
  EXPECT_TRUE(body.isSlender());
  EXPECT_EQ(body.cells, 8);
}

TEST(CellsAcross, StoutBodiesAndFineMeshesAreNotBlamed) {
  const Mesh cube = beam(3, 3, 3), fine = beam(40, 8, 8);
  EXPECT_FALSE(slenderness(cube.hexahedra, cube.position).isSlender());
  EXPECT_EQ(tooCoarseForBending(slenderness(cube.hexahedra, cube.position), true), "");
  EXPECT_EQ(slenderness(fine.hexahedra, fine.position).cells, 8);
  EXPECT_EQ(tooCoarseForBending(slenderness(fine.hexahedra, fine.position), true), "");
  EXPECT_EQ(tooCoarseForBending(slenderness(std::vector<Tetrahedron>{}, {}), false), "");
}

std::string notesOf(const std::string& scene) {
  const Simulation simulation = simulationFromText(scene);
  Diagnostics diagnostics;
  noteCoarseCells(simulation, diagnostics);
  return diagnostics.text();
}

/// A beam of 40 x 1 x 1 without lateral contraction under a small shear at its end, two hexahedra over its height and cells of length a:
/// 1 + a^2/2 times too stiff in bending (their straight edges shear), however many lie over the height. Both notes say so: the one of
/// the mesh beforehand, and that of the shape by the jumps of its strain.
TEST(CellsAcross, HexahedraThatAreLongAreStiffByTheirLength) {
  for (const int along : {80, 40, 20, 10}) {
    const std::string scene = fmt::format(
        R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/>
  <RegularGridTopology n="{} 3 3" min="0 0 0" max="40 1 1"/><MechanicalObject/>
  <HexahedronFEMForceField name="fem" method="small" youngModulus="1000" poissonRatio="0"/>
  <BoxROI name="wall" box="-1 -1 -1 1e-6 2 2"/><BoxROI name="end" box="39.999 -1 -1 50 2 2"/>
  <FixedProjectiveConstraint indices="@wall.indices"/>
  <SurfaceTractionForceField min="39.9 -1 -1" max="50 2 2" traction="0 0 -1e-6"/></Node>)",
        along + 1);
    Simulation simulation = simulationFromText(scene);
    const StepReport report = simulation.step();
    ASSERT_TRUE(!report.failed() && !report.unsolved) << report.reason;
    const System& system = *simulation.systems()[0];
    const double exact = 1e-6 * 64000 / (3 * 1000. / 12) + 1e-6 * 40 / (500 * 5. / 6), length = 40. / along;
    const double withheld = 1 - (1 - system.x[system.allRows() - 1].z()) / exact, expected = 1 - 1 / (1 + length * length / 2);
    EXPECT_NEAR(withheld, expected, 0.01) << along;
    const std::string said = notesOf(scene), start = "where it is some ";
    ASSERT_NE(said.find(start), std::string::npos) << said;
    EXPECT_NEAR(std::stod(said.substr(said.find(start) + start.size())) / 100, withheld, 0.01) << said;
    const auto error = meshErrorOf(*system.forceFields()[0], system.x);
    ASSERT_TRUE(error);
    EXPECT_NEAR(error->share(), withheld, 0.03) << along;

    expectContains(said, "incompatibleModes=\"true\"");
    std::string freed = scene;
    freed.insert(freed.find("method="), "incompatibleModes=\"true\" ");
    Simulation bent = simulationFromText(freed);
    ASSERT_FALSE(bent.step().failed());
    EXPECT_NEAR((1 - bent.systems()[0]->x[system.allRows() - 1].z()) / exact, 1, 0.01) << along;
    EXPECT_EQ(notesOf(freed), "");
    EXPECT_FALSE(meshErrorOf(*bent.systems()[0]->forceFields()[0], bent.systems()[0]->x)) << "corners do not say how it is strained";
  }
}

/// How a beam of 60 x 2 x 1 without lateral contraction is cut into cells: by ends that lean by the tangent `lean`, in turns to and fro or
/// all the same way, seen from the side or from above; or bent to half a ring.
struct Cut {
  int cells;
  double lean;
  bool to_and_fro = true, from_above = false, ring = false;
};
/// A couple (two forces along the beam at each end) bends it. The nodes of one end are held along the beam only.
std::string bentBeam(const Cut& cut, bool modes) {
  std::string position, hexahedra, held, upper, lower;
  const int n = cut.cells;
  for (int i = 0; i <= n; ++i)
    for (int node = 0; node < 4; ++node) {
      const double y = node % 2 * 2 - 1, z = node / 2 - 0.5, along = 60. * i / n, angle = along / 60 * 3.14159265358979;
      const double way = i == 0 || i == n ? 0 : cut.to_and_fro && i % 2 ? -1 : 1, radius = 60 / 3.14159265358979 + z;
      const Vec3 straight(along + way * cut.lean * (cut.from_above ? y : z), y, z);
      const Vec3 at = cut.ring ? Vec3(radius * std::sin(angle), y, radius * std::cos(angle)) : straight;
      position += fmt::format("{:.17g} {:.17g} {:.17g} ", at.x(), at.y(), at.z());
      if (i == 0) held += fmt::format("{} ", node);
      if (i == n) (node / 2 ? upper : lower) += fmt::format("{} ", 4 * i + node);
    }
  for (int i = 0; i < n; ++i)
    for (const int c : {0, 4, 5, 1, 2, 6, 7, 3}) hexahedra += fmt::format("{} ", 4 * i + c);
  return fmt::format(
      R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/><MeshTopology position="{}" hexahedra="{}"/>
  <MechanicalObject/><HexahedronFEMForceField method="small" youngModulus="1000" poissonRatio="0" incompatibleModes="{}"/>
  <PartialFixedProjectiveConstraint indices="{}" fixedDirections="1 0 0"/><FixedProjectiveConstraint indices="0"/>
  <PartialFixedProjectiveConstraint indices="1" fixedDirections="1 0 1"/>
  <ConstantForceField indices="{}" totalForce="0.001 0 0"/><ConstantForceField indices="{}" totalForce="-0.001 0 0"/></Node>)",
      position, hexahedra, modes, held, upper, lower);
}
/// The deflection at the end over that of the same with boxes that bend.
double shareOf(const Cut& cut, bool modes) {
  const auto drop = [](const std::string& scene) {
    Simulation simulation = simulationFromText(scene);
    const StepReport report = simulation.step();
    EXPECT_TRUE(!report.failed() && !report.unsolved) << report.reason;
    const System& system = *simulation.systems()[0];
    const Index end = system.allRows() - 1;
    return system.forceFields()[0]->state().rest_position[std::size_t(end)].z() - system.x[end].z();
  };
  Cut boxes = cut;
  boxes.lean = 0;
  return drop(bentBeam(cut, modes)) / drop(bentBeam(boxes, true));
}
/// The share that a note says is withheld, 0 where there is none.
double withheldBy(const std::string& note) {
  const std::size_t end = note.find(" % too stiff");
  return end == std::string::npos ? 0 : std::stod(note.substr(note.rfind(' ', end - 1))) / 100;
}

TEST(CellsAcross, EndFacesThatLeanToAndFroAreStiffWithModesToo) {
  for (const bool from_above : {false, true})
    for (const double lean : {0.05, 0.1, 0.2}) {
      const Cut cut{.cells = 24, .lean = lean, .from_above = from_above};
      for (const bool modes : {false, true}) {
        const std::string note = notesOf(bentBeam(cut, modes));
        EXPECT_NEAR(withheldBy(note), 1 - shareOf(cut, modes), 0.04) << lean << " " << from_above << " " << modes << " " << note;
      }
    }
}

TEST(CellsAcross, EndFacesThatLeanAlikeBendWithModes) {
  const Cut parallel{.cells = 24, .lean = 0.5, .to_and_fro = false};
  EXPECT_GT(shareOf(parallel, true), 0.97);
  EXPECT_EQ(notesOf(bentBeam(parallel, true)), "");
  expectContains(notesOf(bentBeam(parallel, false)), "too stiff");
  EXPECT_EQ(notesOf(bentBeam({.cells = 24, .lean = 0, .ring = true}, true)), "");
}

/// A bar of 4 x 1 x 1 with `cells` over its height, drawn down at its end.
std::string bar(int cells, bool hexahedra, double ratio, const std::string& dilatation) {
  const std::string kind = hexahedra ? "Hexahedron" : "Tetrahedron",
                    tetrahedra = hexahedra ? ""
                                           : R"(<TetrahedronSetTopologyContainer name="tets"/><Hexa2TetraTopologicalMapping input="@../grid"
  output="@tets" swapping="true"/>)";
  return fmt::format(
      R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/><RegularGridTopology name="grid" n="{} {} {}" min="0 0 0"
  max="4 1 1"/><Node name="b">{}<MechanicalObject/><UniformMass totalMass="1"/><{}FEMForceField method="small" youngModulus="1000"
  poissonRatio="{}" dilatation="{}"/><BoxROI name="wall" box="-1 -1 -1 1e-6 2 2"/><BoxROI name="end" box="3.999 -1 -1 5 2 2"/>
  <FixedProjectiveConstraint indices="@wall.indices"/><ConstantForceField indices="@end.indices" totalForce="0 0 -0.001"/></Node></Node>)",
      4 * cells + 1, cells + 1, cells + 1, tetrahedra, kind, ratio, dilatation);
}

double deflection(const std::string& scene) {
  Simulation simulation = simulationFromText(scene);
  const StepReport report = simulation.step();
  EXPECT_TRUE(!report.failed() && !report.unsolved) << report.reason;
  const System& system = *simulation.systems()[0];
  return 1 - system.x[system.allRows() - 1].z();
}

/// Where Poisson's ratio is near that at which dilatation="auto" changes, the note says by how much the answer does: within a third of
/// what it is, or of tetrahedra at most, whose jump depends on how they lie.
TEST(CellsAcross, TheJumpOfAnOpenDilatationIsTold) {
  for (const bool hexahedra : {true, false})
    for (const int cells : {1, 2, 4}) {
      const std::string start = std::string("with dilatation=\"auto\" it bends by ") + (hexahedra ? "some " : "up to ");
      const double from = hexahedra ? 0.4 : 0.45;
      const std::string said = notesOf(bar(cells, hexahedra, from - 0.02, "auto"));
      ASSERT_NE(said.find(start), std::string::npos) << cells << said;
      const double told = std::stod(said.substr(said.find(start) + start.size())) / 100;
      const double jump = deflection(bar(cells, hexahedra, from, "mean")) / deflection(bar(cells, hexahedra, from, "local")) - 1;
      std::printf("%d %s over the height: told %.0f %%, %.1f %%\n", cells, hexahedra ? "hexahedra" : "tetrahedra", 100 * told, 100 * jump);
      EXPECT_GT(jump, 0.05);
      EXPECT_LT(jump, 1.35 * told);
      if (hexahedra) EXPECT_GT(jump, 0.65 * told);
      EXPECT_EQ(notesOf(bar(cells, hexahedra, from - 0.02, "mean")).find(start), std::string::npos);
      EXPECT_EQ(notesOf(bar(cells, hexahedra, from - 0.1, "auto")).find(start), std::string::npos);
    }
}

}  // namespace
}  // namespace stroma::test
