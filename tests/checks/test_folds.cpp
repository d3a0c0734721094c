// SPDX-License-Identifier: LGPL-2.1-or-later
// Deformed meshes that have folded over themselves, and such that only look strange.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "framework/mesh/cell_kind.h"
#include "framework/mesh/simplex_size.h"
#include "tests/support/meshes.h"
#include "tools/checks/folds.h"

namespace stroma::test {
namespace {

bool says(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

std::vector<Vec3> moved(std::vector<Vec3> p, const Mat3& by) {
  for (Vec3& x : p) x = by * x + Vec3(1, 2, 3);
  return p;
}

/// At rest, and with the middles of edges mirrored at the centre: det dx/dxi is 27 times itself at corners and -1 times at the centre.
std::pair<std::vector<Vec3>, std::vector<Vec3>> twistedQuadraticCell() {
  const std::vector<Vec3> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  std::vector<Vec3> straight = corners;
  for (const auto& [a, b] : std::vector<std::pair<int, int>>{{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}})
    straight.push_back((corners[std::size_t(a)] + corners[std::size_t(b)]) / 2);
  const Vec3 centre(0.25, 0.25, 0.25);
  std::vector<Vec3> twisted = straight;
  for (std::size_t i = 4; i < twisted.size(); ++i) twisted[i] = 2 * centre - straight[i];
  return {straight, twisted};
}

TEST(Folds, TurnedAndStretchedMeshesHaveNone) {
  const Mat3 turn = Eigen::AngleAxisd(2.9, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  const Mat3 map = turn * Vec3(3, 0.2, 1).asDiagonal();
  for (const HexahedronCut cut : {HexahedronCut::five, HexahedronCut::six, HexahedronCut::ten}) {
    Mesh mesh = tetrahedronMesh(3, 2, 2, cut);
    if (cut == HexahedronCut::ten) mesh.overlap = 2;
    EXPECT_EQ(foldsOf(mesh, mesh.position, moved(mesh.position, map)), "");
  }
  const Mesh grid = gridMesh(3, 2, 2);
  EXPECT_EQ(foldsOf(grid, grid.position, moved(grid.position, map)), "");
}

TEST(Folds, CellsInsideOutAreCounted) {
  for (const bool cut : {false, true}) {
    const Mesh mesh = cut ? tetrahedronMesh(3, 3, 3, HexahedronCut::six) : gridMesh(3, 3, 3);
    std::vector<Vec3> now = mesh.position;
    now[0] = Vec3(1.4, 1.4, 1.4);  // a corner of the body, through the only hexahedron it has
    const std::string text = foldsOf(mesh, mesh.position, now);
    EXPECT_TRUE(says(text, cut ? " of 162 tetrahedra are inverted; the first is tetrahedron "
                               : "1 of 27 hexahedra are inverted at a corner; the first is hexahedron 0 (nodes 0 "))
        << text;
    // all of it
    const std::string mirrored = foldsOf(mesh, mesh.position, moved(mesh.position, Vec3(-1, 1, 1).asDiagonal()));
    EXPECT_TRUE(says(mirrored, cut ? "162 of 162" : "27 of 27")) << mirrored;
  }
}

/// Four corners of a quadratic tetrahedron and the places between them are upright, and its centre is inside out.
TEST(Folds, QuadraticCellsAreLookedAtBetweenTheirCorners) {
  const auto [straight, twisted] = twistedQuadraticCell();
  Mesh mesh;
  mesh.position = straight;
  mesh.quadratic_tetrahedra = {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}};
  const Mat3 turn = Eigen::AngleAxisd(2.9, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  EXPECT_EQ(foldsOf(mesh, straight, moved(straight, turn * Vec3(3, 0.2, 1).asDiagonal())), "");
  EXPECT_TRUE(says(foldsOf(mesh, straight, twisted), "1 of 1 quadraticTetrahedra are inverted at a node or the centre"))
      << foldsOf(mesh, straight, twisted);
  EXPECT_EQ(insideOutCells(mesh, straight, twisted).first, 1u);
}

/// Of a surface: a triangle that lies folded on its neighbour is cloth, one without a height is none.
TEST(Folds, FacesThatAreCrushedToALineAreCounted) {
  Mesh mesh;
  mesh.position = {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}};
  std::vector<Vec3> now = mesh.position;
  now[3] = now[2];
  EXPECT_EQ(foldsOf(mesh, mesh.position, now), "");
  now[3] = Vec3(0.5, -0.03, 0);
  EXPECT_EQ(foldsOf(mesh, mesh.position, now), "");
  now[3] = Vec3(0.5, -0.01, 0);
  EXPECT_TRUE(says(foldsOf(mesh, mesh.position, now),
                   "1 of 2 triangles are crushed to less than 2 % of their area at rest; the first is triangle 1 (nodes 1 0 3)"));
}

/// The corner has gone a little beyond the plane of its neighbours: the volume of the cell is positive still.
TEST(Folds, AHexahedronIsLookedAtByCorners) {
  const Mesh mesh = gridMesh(1, 1, 1);
  std::vector<Vec3> now = mesh.position;
  now[0] = Vec3::Constant(0.4);
  const std::array<Vec3, 8> corners{now[0], now[1], now[3], now[2], now[4], now[5], now[7], now[6]};
  EXPECT_GT(cell_kinds::hexahedron.size(corners.data()), 0);
  EXPECT_TRUE(says(foldsOf(mesh, mesh.position, now), "1 of 1 hexahedra"));
  now[0] = Vec3::Constant(0.3);
  EXPECT_EQ(foldsOf(mesh, mesh.position, now), "");
}

/// Sixteen tetrahedra around a node, between two poles: at rest their ring goes round once, then twice. Each is upright
/// all the time.
TEST(Folds, UprightCellsThatGoRoundTwiceOverlap) {
  constexpr int sides = 8;
  Mesh mesh;
  mesh.position = {Vec3(0, 0, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)};
  std::vector<Vec3> now = mesh.position;
  for (int k = 0; k < sides; ++k) {
    const double angle = 2 * std::numbers::pi * k / sides;
    mesh.position.push_back(Vec3(std::cos(angle), std::sin(angle), 0));
    now.push_back(Vec3(std::cos(2 * angle), std::sin(2 * angle), 0));
    const Index here = Index(3 + k), next = Index(3 + (k + 1) % sides);
    mesh.tetrahedra.push_back({0, here, next, 1});
    mesh.tetrahedra.push_back({0, next, here, 2});
  }
  EXPECT_EQ(foldsOf(mesh, mesh.position, mesh.position), "");
  for (const Tetrahedron& t : mesh.tetrahedra)
    EXPECT_GT(tetrahedronVolume(now[t[0]], now[t[1]], now[t[2]], now[t[3]]), 0);
  const std::string text = foldsOf(mesh, mesh.position, now);
  EXPECT_TRUE(says(text, "the cells around 1 of 11 nodes fill the space more than once; the first is node 0")) << text;
}

}  // namespace
}  // namespace stroma::test
