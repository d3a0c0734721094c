// SPDX-License-Identifier: LGPL-2.1-or-later
// What a sparse grid says of its cells: their volume is not that of the surface; cells with copies; quads of a sphere.
#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "framework/mesh/topology.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A box of 8 x 1 x 1 in a grid of its own.
std::string told(const std::string& attributes, const std::string& triangles) {
  return sceneFromText(fmt::format(R"(<Node name="root"><SparseGridTopology name="grid" {} triangles="{}"
      position="0 0 0 8 0 0 8 1 0 0 1 0 0 0 1 8 0 1 8 1 1 0 1 1"/></Node>)",
                                   attributes, triangles))
      .diagnostics.text();
}

TEST(SparseGrid, SaysThatItsCellsHaveAnotherVolume) {
  const std::string box = "0 2 1 0 3 2 4 5 6 4 6 7 0 1 5 0 5 4 1 2 6 1 6 5 2 3 7 2 7 6 3 0 4 3 4 7";
  // 1 % more on each side: 8.16 x 1.02 x 1.02, of which 64 x 8 x 8 cells less 62 x 6 x 6 are on the border
  const double all = 8.16 * 1.02 * 1.02 / 8, weighted = all * (1 - 0.5 * (1 - 62. * 36 / (64 * 64)));
  const std::string said = told("n='65 9 9'", box);
  expectContains(said, fmt::format("its cells have {:.0f} % of the volume of the surface, and with cellFactors {:.0f} %", 100 * all,
                                   100 * weighted));
  expectContains(said, "nbVirtualFinerLevels");
  EXPECT_EQ(told("n='9 2 2' min='0 0 0' max='8 1 1' fillWeighted='false'", box).find("of the volume"), std::string::npos)
      << "cells that are the box";
  EXPECT_EQ(told("n='9 2 2' min='0 0 0' max='8 1 1'", box.substr(0, box.size() - 12)).find("of the volume"), std::string::npos)
      << "an open surface has none";
}

// ---- cells with copies ----

/// Two boxes of 4 x 0.4 x 1 side by side in y, with 0.2 between them, as triangles. With another `gap` they are as much wider.
std::string twoFingers(const std::string& attributes, const std::string& type = "SparseGridRamificationTopology", double gap = 0.2) {
  const std::string box = "0 2 1 0 3 2 4 5 6 4 6 7 0 1 5 0 5 4 1 2 6 1 6 5 2 3 7 2 7 6 3 0 4 3 4 7";
  std::string positions, triangles = box;
  const double width = (1 - gap) / 2;
  for (const double low : {0., 1 - width})
    positions += fmt::format("0 {0} 0 4 {0} 0 4 {1} 0 0 {1} 0 0 {0} 1 4 {0} 1 4 {1} 1 0 {1} 1 ", low, low + width);
  std::istringstream words(box);
  for (int node = 0; words >> node;) triangles += fmt::format(" {}", node + 8);
  return fmt::format(R"(<Node name="root"><{} name="grid" n="5 2 2" min="0 0 0" max="4 1 1" position="{}" triangles="{}" {}/>
      </Node>)",
                     type, positions, triangles, attributes);
}

/// Of four cells in a row each has a copy for each finger: two rows that share nothing.
TEST(SparseGridRamification, FingersInOneCellAreApart) {
  const Scene scene = sceneFromText(twoFingers("nbVirtualFinerLevels='4'"));
  const auto& mesh = dynamic_cast<const Topology&>(*scene.root->components().front()).mesh();
  ASSERT_EQ(mesh.hexahedra.size(), 8u);
  ASSERT_EQ(mesh.position.size(), 40u) << "twice 5 x 2 x 2";
  std::vector<int> part(mesh.position.size(), -1);  // of the nodes: the finger
  for (std::size_t cell = 0; cell < 8; ++cell)
    for (const Index node : mesh.hexahedra[cell]) part[std::size_t(node)] = -2;
  EXPECT_EQ(std::count(part.begin(), part.end(), -2), 40) << "all nodes are in use";
  // flooding from the first cell reaches four of them
  std::vector<bool> reached(8, false);
  reached[0] = true;
  for (int round = 0; round < 8; ++round)
    for (std::size_t a = 0; a < 8; ++a)
      for (std::size_t b = 0; b < 8; ++b)
        for (const Index i : mesh.hexahedra[a])
          for (const Index j : mesh.hexahedra[b])
            if (reached[a] && i == j) reached[b] = true;
  EXPECT_EQ(std::count(reached.begin(), reached.end(), true), 4);
  // neighbours in a row share a side of four nodes
  for (std::size_t a = 0; a < 8; ++a) {
    int shared = 0;
    for (std::size_t b = 0; b < 8; ++b)
      for (const Index i : mesh.hexahedra[a])
        for (const Index j : mesh.hexahedra[b]) shared += a != b && i == j;
    EXPECT_TRUE(shared == 4 || shared == 8) << shared;
  }
}

TEST(SparseGridRamification, WithoutFinerLevelsItIsTheSparseGrid) {
  const Scene split = sceneFromText(twoFingers("")), whole = sceneFromText(twoFingers("", "SparseGridTopology"));
  const auto& one = dynamic_cast<const Topology&>(*split.root->components().front()).mesh();
  const auto& other = dynamic_cast<const Topology&>(*whole.root->components().front()).mesh();
  EXPECT_EQ(one.hexahedra, other.hexahedra);
  EXPECT_EQ(one.position, other.position);
}

/// Fingers so near that they share cells of the finest level: apart by their triangles alone.
TEST(SparseGridRamification, ByTheFinestCellsNearFingersAreOne) {
  const auto nodes = [](const char* finest) {
    const Scene scene = sceneFromText(twoFingers(fmt::format("nbVirtualFinerLevels='3' finestConnectivity='{}'", finest),
                                                 "SparseGridRamificationTopology", 0.1));
    return dynamic_cast<const Topology&>(*scene.root->components().front()).mesh().position.size();
  };
  EXPECT_EQ(nodes("true"), 40u);
  EXPECT_EQ(nodes("false"), 20u);
}

// ---- parts of cells ----

/// A box of which each side lies in the outermost of 4 x 4 x 4 fine cells: these are half full, and the eight in the middle full. Of the
/// eight parts of the cell each has one of the full ones.
TEST(SparseGrid, CountsWhatItsPartsHold) {
  const std::string box = "0 2 1 0 3 2 4 5 6 4 6 7 0 1 5 0 5 4 1 2 6 1 6 5 2 3 7 2 7 6 3 0 4 3 4 7";
  const auto factors = [&](int levels) {
    const Scene scene = sceneFromText(fmt::format(R"(<Node name="root"><SparseGridTopology name="e" n="2 2 2" min="0 0 0" max="2 2 2"
        nbVirtualFinerLevels="2" partLevels="{}" triangles="{}" position="0.3 0.3 0.3 1.7 0.3 0.3 1.7 1.7 0.3 0.3 1.7 0.3
        0.3 0.3 1.7 1.7 0.3 1.7 1.7 1.7 1.7 0.3 1.7 1.7"/></Node>)", levels, box));
    return *std::get<std::vector<double>*>(findComponent(*scene.root, "/e")->data().find("partFactors")->pointer());
  };
  EXPECT_EQ(factors(0), std::vector<double>{(8 + 0.5 * 56) / 64});
  EXPECT_EQ(factors(1), std::vector<double>(8, (1 + 0.5 * 7) / 8));
  const std::vector<double> finest = factors(2);
  ASSERT_EQ(finest.size(), 64u);
  for (int p = 0; p < 64; ++p) {
    const auto inner = [](int i) { return i == 1 || i == 2; };
    EXPECT_EQ(finest[std::size_t(p)], inner(p % 4) && inner(p / 4 % 4) && inner(p / 16) ? 1 : 0.5) << p;
  }
  expectContains(problemsOf("<Node name='root'><SparseGridTopology n='2 2 2' partLevels='1' position='0 0 0' triangles='0 0 0'/></Node>"),
                 "partLevels is 1");
  const auto told = [](const std::string& size) {
    return problemsOf("<Node name='root'><SparseGridTopology " + size +
                      " position='0 0 0  1 0 0  0 1 0  0 0 1' triangles='0 2 1  0 1 3'/></Node>");
  };
  expectContains(told("n='2 2 2' nbVirtualFinerLevels='6' partLevels='5'"), "partLevels");
  expectContains(told("n='300 300 300'"), "too many cells: 2.7e+07");
  expectContains(told("n='20 20 20' nbVirtualFinerLevels='5'"), "too many cells of nbVirtualFinerLevels=\"5\": 2.62e+08");
  const std::string parts = told("n='20 20 20' nbVirtualFinerLevels='4' partLevels='4'");
  expectContains(parts, "too many parts of cells of partLevels=\"4\": 3.28e+07");
  expectContains(parts, "at most 1e+07");
}

// ---- balls ----

/// Platonic solids of circumradius R, cut into layers: nodes on spheres, cells that fill it, and the volume of the solid at degree 1.
TEST(GenerateSphere, ABallOfLayers) {
  struct Solid {
    const char* name;
    std::size_t faces;
    double volume;  // over R^3
  };
  const double five = std::sqrt(5.);
  for (const Solid& solid : {Solid{"tetrahedron", 4, 8 / (9 * std::sqrt(3.))}, Solid{"octahedron", 8, 4. / 3},
                             Solid{"icosahedron", 20, 2. / 3 * std::sqrt(10 + 2 * five)}})
    for (const std::size_t n : {1u, 2u, 4u}) {
      const Scene scene = sceneFromText(
          fmt::format(R"(<Node name="root"><GenerateSphere name="e" radius="2" origin="1 2 3" platonicSolid="{}" tessellationDegree="{}"/>
            <TetrahedronSetTopologyContainer position="@e.position" tetrahedra="@e.tetrahedra"/>
            <TriangleSetTopologyContainer position="@e.output_TrianglesPosition" triangles="@e.triangles"/></Node>)",
                      solid.name, n));
      const auto& ball = dynamic_cast<const Topology&>(*scene.root->components()[1]).mesh();
      const auto& shell = dynamic_cast<const Topology&>(*scene.root->components()[2]).mesh();
      const Vec3 centre(1, 2, 3);
      ASSERT_EQ(ball.tetrahedra.size(), solid.faces * n * n * n);
      ASSERT_EQ(shell.triangles.size(), solid.faces * n * n);
      ASSERT_EQ(shell.position.size(), 2 + solid.faces * n * n / 2) << "a closed surface";
      double volume = 0, enclosed = 0;
      for (const Tetrahedron& t : ball.tetrahedra) {
        const auto edge = [&](std::size_t c) { return Vec3(ball.position[std::size_t(t[c])] - ball.position[std::size_t(t[0])]); };
        const double each = edge(1).dot(edge(2).cross(edge(3))) / 6;
        ASSERT_GT(each, 0);
        volume += each;
      }
      for (const Triangle& t : shell.triangles) {
        const auto at = [&](std::size_t c) { return Vec3(shell.position[std::size_t(t[c])] - centre); };
        enclosed += at(0).dot(at(1).cross(at(2))) / 6;
      }
      EXPECT_NEAR(volume, enclosed, 1e-12 * volume);
      EXPECT_LT(volume, 8 * 4 * 3.14159265358979 / 3);
      if (n == 1) {
        EXPECT_NEAR(volume, 8 * solid.volume, 1e-12) << solid.name;
      }
      for (const Vec3& p : shell.position) ASSERT_NEAR((p - centre).norm(), 2, 1e-14);
    }
}

// ---- spheres ----

TEST(SphereQuad, ItsNodesLieOnTheSphere) {
  const Scene scene = sceneFromText(
      R"(<Node name="root"><SphereQuadTopology nx="5" ny="4" nz="6" center="1 2 3" radius="0.7"/></Node>)");
  const auto& mesh = dynamic_cast<const Topology&>(*scene.root->components().front()).mesh();
  ASSERT_EQ(mesh.position.size(), 5u * 4 * 6 - 3 * 2 * 4);
  double volume = 0;
  for (const Vec3& p : mesh.position) ASSERT_NEAR((p - Vec3(1, 2, 3)).norm(), 0.7, 1e-14);
  for (const Quad& q : mesh.quads)
    for (const auto& [b, c] : {std::pair(1, 2), std::pair(2, 3)})
      volume += (mesh.position[std::size_t(q[0])] - Vec3(1, 2, 3))
                    .dot((mesh.position[std::size_t(q[std::size_t(b)])] - Vec3(1, 2, 3))
                             .cross(mesh.position[std::size_t(q[std::size_t(c)])] - Vec3(1, 2, 3))) / 6;
  const double ball = 4 * 3.14159265358979 / 3 * 0.343;
  EXPECT_LT(volume, ball);
  EXPECT_GT(volume, 0.7 * ball) << "outwards, and closed";
}

// ---- several surfaces ----

/// Boxes of 2 x 2 along a row of eight cells: one from 0.5 to 5.5, the other from 2.5 to 7.5, in 8 x 3 x 3 cells of size 1. Factors
/// of cells inside are taken, those on borders halved with what was there.
std::vector<double> rowOfTwo(const std::string& more, const std::string& data,
                             const std::string& size = "n='9 4 4' max='8 3 3'") {
  const std::string attributes = size + " " + more;
  const std::string box = "0 2 1 0 3 2 4 5 6 4 6 7 0 1 5 0 5 4 1 2 6 1 6 5 2 3 7 2 7 6 3 0 4 3 4 7";
  std::string surfaces;
  for (const auto& [number, low] : {std::pair(1, 0.5), std::pair(2, 2.5)})
    surfaces += fmt::format(" triangles{0}='{1}' position{0}='{2} 0.5 0.5 {3} 0.5 0.5 {3} 2.5 0.5 {2} 2.5 0.5 {2} 0.5 2.5 {3} 0.5 2.5 "
                            "{3} 2.5 2.5 {2} 2.5 2.5'", number, box, low, low + 5);
  const Scene scene = sceneFromText(fmt::format(
      "<Node name='root'><SparseGridMultipleTopology {} min='0 0 0' stiffnessCoefs='2 8' massCoefs='1 3' {}/></Node>", attributes,
      surfaces));
  std::istringstream words(scene.root->components().front()->data().find(data)->print());
  std::vector<double> numbers;
  for (double number = 0; words >> number;) numbers.push_back(number);
  return numbers;
}

TEST(SparseGridMultiple, FactorsAreOfTheLastInsideAndHalvedOnBorders) {
  const std::vector<double> sides = {1, 1, 4.5, 4.5, 4.5, 4.5, 4, 4}, inner = {2, 5, 8, 8, 8, 8};
  const auto whole = [](const std::vector<double>& side, double first, double last, const std::vector<double>& middle) {
    std::vector<double> all;  // cells on borders in the order of the grid, then those inside
    for (int row = 0; row < 9; ++row)
      if (row == 4)
        all.push_back(first), all.push_back(last);
      else
        all.insert(all.end(), side.begin(), side.end());
    all.insert(all.end(), middle.begin(), middle.end());
    return all;
  };
  EXPECT_EQ(rowOfTwo("", "cellFactors"), whole(sides, 1, 4, inner));
  EXPECT_EQ(rowOfTwo("", "massFactors"), whole({0.5, 0.5, 1.75, 1.75, 1.75, 1.75, 1.5, 1.5}, 0.5, 1.5, {1, 2, 3, 3, 3, 3}));
  EXPECT_EQ(rowOfTwo("erasePreviousCoef='true'", "cellFactors"), whole({2, 2, 8, 8, 8, 8, 8, 8}, 2, 8, {2, 8, 8, 8, 8, 8}));
  const std::vector<double> filled = rowOfTwo("fillWeighted='false'", "cellFactors");
  ASSERT_EQ(filled.size(), 72u);
  for (std::size_t cell = 0; cell < 72; ++cell) EXPECT_EQ(filled[cell], cell % 8 < 2 ? 2 : 8) << cell;
}

/// With cells of twice the size: means of eight.
TEST(SparseGridMultiple, CoarseCellsHaveMeans) {
  const std::vector<double> fine = rowOfTwo("fillWeighted='false'", "massFactors");
  const std::vector<double> coarse = rowOfTwo("fillWeighted='false' nbVirtualFinerLevels='1'", "massFactors", "n='5 3 3' max='8 4 4'");
  double sum_fine = 0, sum_coarse = 0;
  for (const double factor : fine) sum_fine += factor;
  for (const double factor : coarse) sum_coarse += 8 * factor;
  EXPECT_NEAR(sum_fine, sum_coarse, 1e-12 * sum_fine) << "the same cells, and empty ones";
}

TEST(SparseGridMultiple, SaysWhatBelongsToNoSurface) {
  expectContains(problemsOf("<Node name='root'><SparseGridMultipleTopology position='0 0 0'/></Node>"), "position belongs to no surface");
  expectContains(problemsOf("<Node name='root'><SparseGridMultipleTopology position1='0 0 0' triangles1='0 1 2'/></Node>"),
                 "a face of surface 1 names node 1 of 1");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
