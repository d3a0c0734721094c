// SPDX-License-Identifier: LGPL-2.1-or-later
// Cutting hexahedra: volumes, orientation, matching faces, symmetry, and the tables of the paper.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "framework/mesh/simplex_size.h"
#include "framework/scene/diagnostics.h"
#include "tests/support/meshes.h"

namespace stroma::test {
namespace {

using Set = std::set<std::array<int, 4>>;

double volumeOf(const Mesh& grid, const std::vector<Tetrahedron>& tetrahedra, double* smallest) {
  double sum = 0;
  *smallest = 1;
  for (const auto& t : tetrahedra) {
    const auto p = [&](std::size_t i) { return grid.position[t[i]]; };
    const double volume = tetrahedronVolume(p(0), p(1), p(2), p(3));
    *smallest = std::min(*smallest, volume);
    sum += volume;
  }
  return sum;
}

TEST(Cuts, FillTheBodyWithPositiveVolumes) {
  const Mesh grid = gridMesh(3, 4, 2);
  for (const auto cut :
       {HexahedronCut::six, HexahedronCut::five, HexahedronCut::five1, HexahedronCut::five2, HexahedronCut::ten})
    for (const bool mirrored : {false, true}) {
      if (mirrored && cut != HexahedronCut::six) continue;
      const auto tetrahedra = cutHexahedra(grid.hexahedra, cut, mirrored);
      EXPECT_EQ(tetrahedra.size(), grid.hexahedra.size() * std::size_t(tetrahedraPerHexahedron(cut)));
      double smallest = 0;
      const double volume = volumeOf(grid, tetrahedra, &smallest);
      EXPECT_NEAR(volume, cut == HexahedronCut::ten ? 48 : 24, 1e-12);
      EXPECT_NEAR(smallest, 1.0 / 6, 1e-15);
    }
}

TEST(Cuts, FacesMatchWhereTheyShould) {
  const Mesh grid = gridMesh(3, 3, 3);
  const auto mismatches = [&](HexahedronCut cut, bool mirrored = false) {
    return mismatchedFaces(grid.hexahedra, cutHexahedra(grid.hexahedra, cut, mirrored), tetrahedraPerHexahedron(cut));
  };
  EXPECT_EQ(mismatches(HexahedronCut::six), 0);
  EXPECT_EQ(mismatches(HexahedronCut::six, true), 0);
  EXPECT_EQ(mismatches(HexahedronCut::five), 0);
  EXPECT_EQ(mismatches(HexahedronCut::ten), 0);
  EXPECT_EQ(mismatches(HexahedronCut::five1), 3 * 2 * 9);  // every inner face
  EXPECT_EQ(mismatches(HexahedronCut::five2), 3 * 2 * 9);
}

TEST(Cuts, MatchingMeansNoInnerBoundary) {
  // The count above trusts the tables of faces; the boundary of the tetrahedra does not.
  const Mesh grid = gridMesh(3, 2, 4);
  for (const bool mirrored : {false, true}) {
    Mesh mesh;
    mesh.position = grid.position;
    mesh.tetrahedra = cutHexahedra(grid.hexahedra, HexahedronCut::six, mirrored);
    EXPECT_EQ(mesh.boundaryTriangles().size(), 2 * grid.boundaryQuads().size());
  }
  Mesh mesh;
  mesh.position = grid.position;
  mesh.tetrahedra = cutHexahedra(grid.hexahedra, HexahedronCut::five);
  EXPECT_EQ(mesh.boundaryTriangles().size(), 2 * grid.boundaryQuads().size());
}

TEST(Cuts, FollowThePapersTables) {
  // Appendix B, corners as binary numbers zyx.
  const Set first{{1, 4, 5, 7}, {0, 1, 2, 4}, {1, 2, 3, 7}, {2, 4, 6, 7}, {1, 2, 4, 7}};
  const Set second{{0, 1, 3, 5}, {0, 4, 5, 6}, {3, 5, 6, 7}, {0, 2, 3, 6}, {0, 3, 5, 6}};
  const Mesh grid = gridMesh(1, 1, 1);  // its node numbers are the binary numbers zyx
  const auto asSet = [](const std::vector<Tetrahedron>& tetrahedra) {
    Set set;
    for (auto t : tetrahedra) std::sort(t.begin(), t.end()), set.insert({t[0], t[1], t[2], t[3]});
    return set;
  };
  EXPECT_EQ(asSet(cutHexahedra(grid.hexahedra, HexahedronCut::five1)), first);
  EXPECT_EQ(asSet(cutHexahedra(grid.hexahedra, HexahedronCut::five2)), second);
  Set both = first;
  both.insert(second.begin(), second.end());
  EXPECT_EQ(asSet(cutHexahedra(grid.hexahedra, HexahedronCut::ten)), both);
}

TEST(Cuts, MirroredCutsHaveNoPreferredDiagonal) {
  // A grid of even size cut with mirrors is symmetric: reflecting it in x gives the same set of tetrahedra.
  const int n = 4;
  const Mesh grid = gridMesh(n, 2, 2);
  const auto tetrahedra = cutHexahedra(grid.hexahedra, HexahedronCut::six, true);
  const auto reflect = [&](Index node) { return Index(node - node % (n + 1) + n - node % (n + 1)); };
  std::set<Tetrahedron> as_is, reflected;
  for (auto t : tetrahedra) {
    Tetrahedron r{reflect(t[0]), reflect(t[1]), reflect(t[2]), reflect(t[3])};
    std::sort(t.begin(), t.end()), std::sort(r.begin(), r.end());
    as_is.insert(t), reflected.insert(r);
  }
  EXPECT_EQ(as_is, reflected);
  std::set<Tetrahedron> plain, plain_reflected;
  for (auto t : cutHexahedra(grid.hexahedra, HexahedronCut::six)) {
    Tetrahedron r{reflect(t[0]), reflect(t[1]), reflect(t[2]), reflect(t[3])};
    std::sort(t.begin(), t.end()), std::sort(r.begin(), r.end());
    plain.insert(t), plain_reflected.insert(r);
  }
  EXPECT_NE(plain, plain_reflected);
}

TEST(Cuts, AlternateInAMeshWithoutGrid) {
  // Corners of the second cell numbered another way round: still the same body, still matching.
  Mesh grid = gridMesh(2, 2, 2);
  for (std::size_t h = 1; h < grid.hexahedra.size(); h += 2) {
    const Hexahedron c = grid.hexahedra[h];
    grid.hexahedra[h] = {c[1], c[2], c[3], c[0], c[5], c[6], c[7], c[4]};  // a quarter turn about z
  }
  EXPECT_FALSE(gridPlaces(grid.hexahedra));
  const auto tetrahedra = cutHexahedra(grid.hexahedra, HexahedronCut::five);
  EXPECT_EQ(mismatchedFaces(grid.hexahedra, tetrahedra, 5), 0);
  EXPECT_THROW(cutHexahedra(grid.hexahedra, HexahedronCut::six, true), ComponentError);
}

/// `count` hexahedra in a closed ring around a hole: section i holds the nodes 4 i to 4 i + 3.
std::vector<Hexahedron> ring(Index count) {
  std::vector<Hexahedron> cells;
  for (Index i = 0; i < count; ++i) {
    const Index a = 4 * i, b = 4 * ((i + 1) % count);
    cells.push_back({a, b, b + 1, a + 1, a + 3, b + 3, b + 2, a + 2});
  }
  return cells;
}

TEST(Cuts, RefuseAnOddRing) {
  // The cut chooses every second corner along every line of edges: an odd number of edges around a hole does not close.
  EXPECT_THROW(cutHexahedra(ring(5), HexahedronCut::five), ComponentError);
  EXPECT_EQ(mismatchedFaces(ring(6), cutHexahedra(ring(6), HexahedronCut::five), 5), 0);
  EXPECT_EQ(cutHexahedra(ring(5), HexahedronCut::ten).size(), 50u);
}

TEST(GridPlaces, AreTheCellsCoordinates) {
  const auto places = gridPlaces(gridMesh(3, 2, 4).hexahedra);
  ASSERT_TRUE(places);
  for (int k = 0, h = 0; k < 4; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 3; ++i, ++h) EXPECT_EQ((*places)[h], (std::array<int, 3>{i, j, k}));
}

}  // namespace
}  // namespace stroma::test
