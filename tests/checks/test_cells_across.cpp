// SPDX-License-Identifier: LGPL-2.1-or-later
// How many cells lie over the thickness of a body, and what is said of too few.
#include <gtest/gtest.h>

#include "tests/support/meshes.h"
#include "tools/checks/cells_across.h"

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

}  // namespace
}  // namespace stroma::test
