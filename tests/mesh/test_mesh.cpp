// SPDX-License-Identifier: LGPL-2.1-or-later
// Volumes and qualities against closed forms, derived tables against brute force, and the report.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <fstream>
#include <limits>
#include <map>
#include <set>

#include "components/topology/gmsh_reader.h"
#include "framework/mesh/cell_faces.h"
#include "framework/mesh/mesh_loader.h"
#include "framework/mesh/simplex_size.h"
#include "tests/support/meshes.h"
#include "tools/mesh_report/cell_quality.h"

namespace stroma::test {
namespace {

template <class Cell>
Cell sorted(Cell cell) {
  std::sort(cell.begin(), cell.end());
  return cell;
}

std::set<Edge> edgesByBruteForce(const Mesh& mesh) {
  std::set<Edge> edges;
  const auto add = [&edges](Index a, Index b) { edges.insert({std::min(a, b), std::max(a, b)}); };
  for (const auto& t : mesh.tetrahedra)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j) add(t[i], t[j]);
  for (const auto& h : mesh.hexahedra)  // corners that differ in one coordinate of the unit grid
    for (std::size_t i = 0; i < 8; ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (std::abs((mesh.position[h[i]] - mesh.position[h[j]]).norm() - 1) < 1e-9) add(h[i], h[j]);
  return edges;
}

TEST(Volume, TetrahedronAndHexahedron) {
  EXPECT_DOUBLE_EQ(tetrahedronVolume({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}), 1.0 / 6);
  EXPECT_DOUBLE_EQ(tetrahedronVolume({0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}), -1.0 / 6);
  std::array<Vec3, 8> box{Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(2, 3, 0), Vec3(0, 3, 0),
                          Vec3(0, 0, 5), Vec3(2, 0, 5), Vec3(2, 3, 5), Vec3(0, 3, 5)};
  EXPECT_NEAR(cell_kinds::hexahedron.size(box.data()), 30, 1e-12);
  // A frustum: the top face scaled by s about the axis has volume h (1 + s + s^2) / 3 times the base.
  const double s = 0.4;
  for (std::size_t i = 4; i < 8; ++i) box[i] = Vec3(1 + s * (box[i].x() - 1), 1.5 + s * (box[i].y() - 1.5), 5);
  EXPECT_NEAR(cell_kinds::hexahedron.size(box.data()), 6 * 5 * (1 + s + s * s) / 3, 1e-12);
}

TEST(Quality, RegularFlatAndInverted) {
  const Vec3 a(1, 1, 1), b(1, -1, -1), c(-1, 1, -1), d(-1, -1, 1);
  const auto quality = [](const std::array<Vec3, 4>& x) { return cellQuality(cell_kinds::tetrahedron, x.data()); };
  EXPECT_NEAR(std::abs(quality({a, b, c, d})), 1, 1e-12);
  EXPECT_NEAR(quality({a, b, c, d}), -quality({a, c, b, d}), 1e-15);
  EXPECT_EQ(quality({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0)}), 0);
  EXPECT_EQ(quality({a, a, a, a}), 0);
  const Mesh cube = gridMesh(1, 1, 1);
  std::array<Vec3, 8> corner;
  std::copy_n(cube.position.begin(), 8, corner.begin());
  std::swap(corner[2], corner[3]), std::swap(corner[6], corner[7]);
  EXPECT_NEAR(cellQuality(cell_kinds::hexahedron, corner.data()), 1, 1e-12);
  corner[6] = Vec3(0.1, 0.1, 0.1);  // a corner pushed through the cell
  EXPECT_LT(cellQuality(cell_kinds::hexahedron, corner.data()), 0);
}

TEST(Tables, AgreeWithBruteForceForTetrahedra) {
  const Mesh mesh = tetrahedronMesh(3, 4, 2, HexahedronCut::five);
  const std::set<Edge> edges = edgesByBruteForce(mesh);
  EXPECT_EQ(std::vector<Edge>(edges.begin(), edges.end()), mesh.allEdges());

  std::map<Triangle, int> cells_of_face;
  for (const auto& t : mesh.tetrahedra)
    for (const LocalFace& f : cell_kinds::tetrahedron.faces)
      ++cells_of_face[sorted(Triangle{t[f.nodes[0]], t[f.nodes[1]], t[f.nodes[2]]})];
  std::set<Triangle> all, boundary;
  for (const auto& [face, count] : cells_of_face) {
    ASSERT_LE(count, 2);
    all.insert(face);
    if (count == 1) boundary.insert(face);
  }
  std::set<Triangle> all_found, boundary_found;
  for (const Triangle& f : mesh.triangularFaces()) all_found.insert(sorted(f));
  for (const Triangle& f : mesh.boundaryTriangles()) boundary_found.insert(sorted(f));
  EXPECT_EQ(all_found, all);
  EXPECT_EQ(boundary_found, boundary);
  EXPECT_EQ(mesh.triangularFaces().size(), all.size());
  EXPECT_EQ(mesh.boundaryTriangles().size(), 2u * 2 * (3 * 4 + 4 * 2 + 2 * 3));
}

TEST(Tables, BoundaryTurnsOutward) {
  // Gauss: the flux of x/3 through an outward boundary is the volume; a single face turned inward would miss it.
  for (const HexahedronCut cut : {HexahedronCut::six, HexahedronCut::five}) {
    const Mesh mesh = tetrahedronMesh(3, 2, 2, cut);
    double flux = 0;
    for (const Triangle& f : mesh.boundaryTriangles()) {
      const Vec3 &a = mesh.position[f[0]], &b = mesh.position[f[1]], &c = mesh.position[f[2]];
      flux += a.dot(b.cross(c)) / 6;
    }
    EXPECT_NEAR(flux, mesh.report().volume, 1e-12);
    EXPECT_GT(flux, 8);
  }
  const Mesh grid = gridMesh(3, 2, 4);
  EXPECT_EQ(grid.boundaryQuads().size(), 2u * (6 + 8 + 12));
  for (const Quad& f : grid.boundaryQuads()) {
    const Vec3 &a = grid.position[f[0]], &b = grid.position[f[1]], &d = grid.position[f[3]];
    const Vec3 centre(1.5, 1, 2), normal = (b - a).cross(d - a);
    EXPECT_GT(normal.dot(a - centre), 0);
  }
}

TEST(Tables, EdgesAndNeighboursOfAGrid) {
  const Mesh grid = gridMesh(3, 2, 2);
  const std::set<Edge> edges = edgesByBruteForce(grid);
  EXPECT_EQ(std::vector<Edge>(edges.begin(), edges.end()), grid.allEdges());
  const Adjacency& around = grid.nodesAroundNode();
  ASSERT_EQ(around.size(), grid.nodes());
  for (Index n = 0; n < grid.nodes(); ++n) {
    std::vector<Index> expected;
    for (const auto& [a, b] : edges)
      if (a == n || b == n) expected.push_back(a == n ? b : a);
    std::sort(expected.begin(), expected.end());
    const std::vector<Index> found(around.values.begin() + around.start[n],
                                   around.values.begin() + around.start[n + 1]);
    EXPECT_EQ(found, expected) << n;
  }
}

TEST(Tables, AreBuiltWhenAskedForAndOnce) {
  const Mesh mesh = tetrahedronMesh(1, 1, 1, HexahedronCut::six);
  mesh.report();
  EXPECT_EQ(mesh.derivedTables(), 0);
  const void* first = &mesh.allEdges();
  EXPECT_EQ(mesh.derivedTables(), 1);
  mesh.nodesAroundNode();
  EXPECT_EQ(mesh.derivedTables(), 2);
  EXPECT_EQ(&mesh.allEdges(), first);
}

TEST(Subelements, FillTheListsWithoutRepeating) {
  Mesh mesh = tetrahedronMesh(2, 1, 1, HexahedronCut::five);
  const Triangle first = mesh.boundaryTriangles().front();
  mesh.triangles = {{first[2], first[1], first[0]}};  // the same face, turned over
  mesh.edges = {{first[1], first[0]}};
  const std::size_t faces = mesh.triangularFaces().size();
  const Mesh before = mesh;
  addSubelements(mesh);
  EXPECT_EQ(mesh.triangles.size(), faces);
  EXPECT_EQ(mesh.triangles.front(), before.triangles.front());
  EXPECT_EQ(mesh.edges.size(), before.allEdges().size());
  EXPECT_EQ(mesh.edges.front(), before.edges.front());
}

TEST(FirstError, SaysWhichCellAndNode) {
  Mesh mesh = gridMesh(1, 1, 1);
  EXPECT_EQ(mesh.firstError(), "");
  mesh.hexahedra[0][3] = 8;
  EXPECT_EQ(mesh.firstError(), "hexahedron 0 names node 8, but the mesh has 8 nodes (0 to 7)");
  mesh.hexahedra[0][3] = -2;
  EXPECT_NE(mesh.firstError().find("node -2"), std::string::npos);
  mesh.hexahedra[0][3] = 0;
  EXPECT_EQ(mesh.firstError(), "hexahedron 0 names node 0 twice");
  mesh.position[5].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(mesh.firstError().find("position of node 5 is not finite"), std::string::npos);
}

TEST(Report, CountsVolumeAndFaults) {
  Mesh mesh = tetrahedronMesh(2, 2, 2, HexahedronCut::ten, 0);
  mesh.overlap = 2;
  EXPECT_NEAR(mesh.report().volume, 8, 1e-12);
  EXPECT_NE(mesh.report().text().find("cells cover the body 2 times"), std::string::npos);
  std::swap(mesh.tetrahedra[7][0], mesh.tetrahedra[7][1]);
  mesh.position.push_back(Vec3(0, 0, 0));
  mesh.position.push_back(Vec3(1, 0, 0)), mesh.position.push_back(Vec3(0, 1, 0)),
      mesh.position.push_back(Vec3(1, 1, 0));
  mesh.tetrahedra.push_back({28, 29, 30, 27});
  mesh.position.push_back(Vec3(9, 9, 9));
  const MeshReport report = mesh.report();
  EXPECT_EQ(report.inverted, std::vector<Index>{7});
  EXPECT_EQ(report.flat, std::vector<Index>{80});
  EXPECT_EQ(report.unused_nodes, std::vector<Index>{31});
  EXPECT_EQ(report.worst_cell, 7);
  EXPECT_LT(report.worst_quality, 0);
  EXPECT_EQ(report.high, Vec3(9, 9, 9));
  const std::string text = report.text();
  EXPECT_NE(text.find("1 inverted cells (7)"), std::string::npos) << text;
  EXPECT_NE(text.find("1 unused nodes (31)"), std::string::npos) << text;
}

TEST(Report, OfTheBadMesh) {
  const std::string file = STROMA_SHARED_DATA "/meshes/6_tetra_bad.msh";
  std::ifstream probe(file);
  if (!probe) GTEST_SKIP() << file << " is absent";
  const Mesh mesh = readGmsh(file).mesh;
  const MeshReport report = mesh.report();
  EXPECT_EQ(report.nodes, 17);
  EXPECT_EQ(report.tetrahedra, 6);
  // Counted here from the coordinates alone.
  std::vector<Index> inverted;
  double volume = 0;
  for (std::size_t t = 0; t < 6; ++t) {
    const auto& c = mesh.tetrahedra[t];
    Eigen::Matrix4d m;
    for (int k = 0; k < 4; ++k) m.col(k) << 1, mesh.position[c[k]];
    const double v = m.determinant() / 6;
    volume += v;
    if (v < 0) inverted.push_back(Index(t));
  }
  EXPECT_EQ(report.inverted, inverted);
  EXPECT_NEAR(report.volume, volume, 1e-9 * std::abs(volume));
  EXPECT_TRUE(report.unused_nodes.empty());
}

TEST(Rotation, FollowsTheOrderXYZ) {
  const Mat3 r = rotationFromDegrees({90, 0, 90});
  EXPECT_TRUE((r * Vec3::UnitY()).isApprox(Vec3::UnitZ(), 1e-15));  // y to z about x; z stays about z
  EXPECT_TRUE((r * Vec3::UnitX()).isApprox(Vec3::UnitY(), 1e-15));
  EXPECT_NEAR(rotationFromDegrees({10, 20, 30}).determinant(), 1, 1e-14);
}

}  // namespace
}  // namespace stroma::test
