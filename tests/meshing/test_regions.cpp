// SPDX-License-Identifier: LGPL-2.1-or-later
// Meshes with labels: their surfaces, their quality, the match of volumes and their files, which Gmsh's library reads.
#include "tools/mesh/regions.h"

#include <gmsh.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "components/topology/gmsh_reader.h"
#include "framework/mesh/mesh.h"
#include "tools/mesh/enclosed_volume.h"
#include "tools/mesh/labelled_files.h"

namespace stroma::test {
namespace {

/// A ball of n^3 cubes, six tetrahedra each: a cube mapped onto the ball of `radius`, label 2 inside of half of it.
LabelledMesh ball(int n, double radius) {
  LabelledMesh mesh;
  const auto node = [n](int x, int y, int z) { return Index(x + (n + 1) * (y + (n + 1) * z)); };
  for (int z = 0; z <= n; ++z)
    for (int y = 0; y <= n; ++y)
      for (int x = 0; x <= n; ++x) {
        const Vec3 p = 2 * Vec3(x, y, z) / n - Vec3::Ones();
        const double length = p.norm();
        mesh.position.push_back(length > 0 ? Vec3(radius * p.cwiseAbs().maxCoeff() / length * p) : p);
      }
  constexpr int order[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        for (int k = 0; k < 6; ++k) {
          std::array<int, 3> at{x, y, z};
          Tetrahedron t;
          t[0] = node(x, y, z);
          for (std::size_t i = 0; i < 3; ++i) ++at[order[k][i]], t[i + 1] = node(at[0], at[1], at[2]);
          if (k >= 3) std::swap(t[2], t[3]);
          mesh.tetrahedra.push_back(t);
          const auto inner = [n](int i) { return 4 * i >= n && 4 * i < 3 * n; };
          mesh.labels.push_back(inner(x) && inner(y) && inner(z) ? 2 : 1);
        }
  return mesh;
}

TEST(Regions, DihedralAnglesOfKnownTetrahedra) {
  const Vec3 o = Vec3::Zero(), x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  const auto regular = dihedralAngles({1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1});
  EXPECT_NEAR(regular[0], std::acos(1. / 3) * 180 / M_PI, 1e-12);
  EXPECT_NEAR(regular[1], regular[0], 1e-12);
  const auto corner = dihedralAngles(o, x, y, z);
  EXPECT_NEAR(corner[0], std::acos(std::sqrt(1. / 3)) * 180 / M_PI, 1e-12);
  EXPECT_NEAR(corner[1], 90, 1e-12);
}

TEST(Regions, SurfacesPartsAndLeaks) {
  const LabelledMesh mesh = ball(8, 1);
  const MeshQuality quality = qualityOf(mesh);
  ASSERT_EQ(quality.regions.size(), 2u);
  double volume = 0;
  for (const RegionReport& region : quality.regions) {
    EXPECT_TRUE(region.watertight());
    EXPECT_EQ(region.parts, 1);
    volume += region.volume;
  }
  Mesh plain;
  plain.position = mesh.position, plain.tetrahedra = mesh.tetrahedra;
  EXPECT_NEAR(volume, plain.report().volume, 1e-12);
  EXPECT_EQ(quality.regions[1].tetrahedra, 4 * 4 * 4 * 6);
  EXPECT_EQ(quality.regions[1].nodes, 5 * 5 * 5);
  // 12 triangles a square of the outer (8 x 8 x 6 faces of cubes) and the inner surface, turned outward
  double enclosed = 0;
  long outer = 0, inner = 0;
  for (const RegionTriangle& t : regionTriangles(mesh)) {
    ASSERT_EQ(t.inside, 1);
    (t.outside == 0 ? outer : inner) += 1;
    const auto at = [&](std::size_t i) { return mesh.position[t.nodes[i]]; };
    enclosed += at(0).dot(at(1).cross(at(2))) / 6;
  }
  EXPECT_EQ(outer, 8 * 8 * 6 * 2);
  EXPECT_EQ(inner, 4 * 4 * 6 * 2);
  EXPECT_NEAR(enclosed, quality.regions[0].volume, 1e-12);

  // two tetrahedra of a label that share an edge only: four triangles meet there
  LabelledMesh bow;
  bow.position = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
  bow.tetrahedra = {{0, 2, 3, 1}, {0, 4, 5, 1}};
  bow.labels = {5, 5};
  EXPECT_EQ(qualityOf(bow).regions.at(0).parts, 2);
  EXPECT_TRUE(qualityOf(bow).regions.at(0).watertight());
  EXPECT_FALSE(qualityOf(bow).regions.at(0).manifold());
  EXPECT_EQ(qualityOf(bow).regions.at(0).branching_edges, 1);
  EXPECT_LT((qualityOf(bow).regions.at(0).place - Vec3(0, 0, 0.5)).norm(), 1e-12);
  // three cells at one face: two of them overlap
  LabelledMesh fan;
  fan.position = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}, {0, 0, 2}};
  fan.tetrahedra = {{0, 1, 2, 3}, {0, 2, 1, 4}, {0, 1, 2, 5}};
  fan.labels = {5, 5, 5};
  EXPECT_FALSE(qualityOf(fan).regions.at(0).manifold());
}

TEST(Regions, WhatASurfaceEnclosesDoesNotDependOnHowItsTrianglesAreTurned) {
  const std::vector<Vec3> corner{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  std::vector<Vec3> position;
  std::vector<Triangle> triangles;
  const auto add = [&](const Vec3& at, double size, bool inward) {
    const Index first = Index(position.size());
    for (const Vec3& c : corner) position.push_back(at + size * c);
    for (const auto& [a, b, c] : std::vector<Triangle>{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}})
      triangles.push_back({first + a, first + (inward ? c : b), first + (inward ? b : c)});
  };
  add({10, 10, 10}, 1, false), add({20, 0, 0}, 1, true);  // two bodies, one inside out
  EXPECT_NEAR(enclosedBy(position, triangles)->volume, 2. / 6, 1e-12);
  EXPECT_NEAR(enclosedBy(position, triangles)->area, 3 + std::sqrt(3.), 1e-12);
  add({10.1, 10.1, 10.1}, 0.3, false);  // a hollow, turned outward
  EXPECT_NEAR(enclosedBy(position, triangles)->volume, (2 - 0.027) / 6, 1e-12);
  add({10.11, 10.11, 10.11}, 0.1, true);  // a body in the hollow
  EXPECT_NEAR(enclosedBy(position, triangles)->volume, (2 - 0.027 + 0.001) / 6, 1e-12);
  std::swap(triangles[2][0], triangles[2][1]);  // one triangle turned over
  EXPECT_NEAR(enclosedBy(position, triangles)->volume, (2 - 0.027 + 0.001) / 6, 1e-12);
  EXPECT_EQ(enclosedBy(position, triangles)->shells, 4);
  triangles.pop_back();
  EXPECT_FALSE(enclosedBy(position, triangles));
}

TEST(Regions, VolumesAreMatchedByMovingBoundaries) {
  LabelledMesh mesh = ball(8, 1);
  const LabelledMesh before = mesh;
  const double inner = qualityOf(mesh).regions[1].volume;
  const std::map<int, double> wanted{{1, 4. / 3 * M_PI - 1.05 * inner}, {2, 1.05 * inner}};
  EXPECT_LT(matchVolumes(mesh, wanted, 5).error, 1e-6);
  const MeshQuality quality = qualityOf(mesh);
  EXPECT_NEAR(quality.regions[0].volume, wanted.at(1), 1e-5);
  EXPECT_NEAR(quality.regions[1].volume, wanted.at(2), 1e-5);
  EXPECT_GE(quality.smallest_angle, std::min(5., qualityOf(before).smallest_angle) - 1e-6);
  std::vector<char> on_surface(mesh.position.size(), 0);
  for (const RegionTriangle& t : regionTriangles(before))
    for (const Index n : t.nodes) on_surface[n] = 1;
  long moved = 0;
  for (std::size_t n = 0; n < mesh.position.size(); ++n) {
    const double way = (mesh.position[n] - before.position[n]).norm();
    moved += way > 0;
    EXPECT_TRUE(on_surface[n] || way == 0) << n;
  }
  EXPECT_GT(moved, 300);
  // what cannot be reached is returned as an error, and no cell is turned over for it
  const VolumeMatch far = matchVolumes(mesh, {{1, 20.}, {2, 0.001}}, 5);
  EXPECT_GT(far.error, 0.1);
  EXPECT_GT(far.at_reach, 0);  // and it says why
  EXPECT_GE(qualityOf(mesh).smallest_angle, std::min(5., qualityOf(before).smallest_angle) - 1e-6);
}

/// The corners are those of the first order.
TEST(Regions, FilesOfTheSecondOrderHaveANodeOnEachEdge) {
  const LabelledMesh mesh = ball(4, 1);
  for (const bool format_22 : {false, true}) {
    const GmshFile first = parseGmsh(gmshText(mesh, {}, format_22), "first.msh"),
                   file = parseGmsh(gmshText(mesh, {}, format_22, 2), "second.msh");
    EXPECT_EQ(file.mesh.firstError(), "");
    ASSERT_EQ(file.mesh.quadratic_tetrahedra.size(), mesh.tetrahedra.size());
    ASSERT_EQ(file.mesh.quadratic_triangles.size(), first.mesh.triangles.size());
    EXPECT_EQ(file.mesh.position.size(), mesh.position.size() + first.mesh.allEdges().size());
    EXPECT_EQ(file.groups.quadratic_tetrahedra, first.groups.tetrahedra);
    const auto& p = file.mesh.position;
    const auto expectRaised = [&](const auto& cell, const auto& corners, const auto& middles) {
      for (std::size_t a = 0; a < corners.size(); ++a) EXPECT_EQ(cell[a], corners[a]);
      for (std::size_t e = 0; e < middles.size(); ++e)
        EXPECT_LT((p[cell[corners.size() + e]] -
                   (p[corners[std::size_t(middles[e][0])]] + p[corners[std::size_t(middles[e][1])]]) / 2)
                      .norm(),
                  1e-7);
    };
    for (std::size_t c = 0; c < mesh.tetrahedra.size(); ++c)
      expectRaised(file.mesh.quadratic_tetrahedra[c], first.mesh.tetrahedra[c], cell_tables::tetrahedron_middles);
    for (std::size_t t = 0; t < first.mesh.triangles.size(); ++t)
      expectRaised(file.mesh.quadratic_triangles[t], first.mesh.triangles[t], cell_tables::triangle_middles);
    EXPECT_NEAR(file.mesh.report().volume, first.mesh.report().volume, 1e-6 * first.mesh.report().volume);
  }
  EXPECT_NE(vtuText(mesh, 2).find("\n24\n"), std::string::npos);
}

TEST(Regions, FilesKeepCellsLabelsAndNamesInOurReaderAndInGmshs) {
  const LabelledMesh mesh = ball(4, 1);
  gmsh::initialize();
  gmsh::option::setNumber("General.Terminal", 0);
  for (const bool format_22 : {false, true}) {
    const std::string text = gmshText(mesh, {{1, "soft"}}, format_22);
    const GmshFile file = parseGmsh(text, "ball.msh");
    EXPECT_EQ(file.version, format_22 ? 2.2 : 4.1);
    std::vector<std::pair<Tetrahedron, int>> expected, found;
    for (std::size_t c = 0; c < mesh.labels.size(); ++c) expected.emplace_back(mesh.tetrahedra[c], mesh.labels[c]);
    for (std::size_t c = 0; c < file.mesh.tetrahedra.size(); ++c)
      found.emplace_back(file.mesh.tetrahedra[c], file.groups.tetrahedra[c]);
    std::sort(expected.begin(), expected.end()), std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
    ASSERT_EQ(file.mesh.position.size(), mesh.position.size());
    for (std::size_t n = 0; n < mesh.position.size(); ++n)
      EXPECT_LT((file.mesh.position[n] - mesh.position[n]).norm(), 1e-8);
    EXPECT_EQ(file.group_names.at({3, 1}), "soft");
    EXPECT_EQ(file.group_names.at({3, 2}), "label_2");
    EXPECT_EQ(file.group_names.at({2, 1}), "soft.outside");
    EXPECT_EQ(file.group_names.at({2, 2}), "soft.label_2");
    EXPECT_EQ(file.mesh.triangles.size(), regionTriangles(mesh).size());

    gmsh::clear();
    const auto path = std::filesystem::temp_directory_path() / ("regions" + std::to_string(::getpid()) + ".msh");
    std::ofstream(path) << text;
    gmsh::open(path.string());
    std::filesystem::remove(path);
    std::vector<int> types;
    std::vector<std::vector<std::size_t>> elements, nodes;
    gmsh::model::mesh::getElements(types, elements, nodes, 3);
    ASSERT_EQ(elements.size(), 1u);
    EXPECT_EQ(elements[0].size(), mesh.tetrahedra.size());
    std::string name;
    gmsh::model::getPhysicalName(2, 2, name);
    EXPECT_EQ(name, "soft.label_2");
    std::vector<int> entities;
    gmsh::model::getEntitiesForPhysicalGroup(3, 2, entities);
    ASSERT_EQ(entities.size(), 1u);
    gmsh::model::mesh::getElements(types, elements, nodes, 3, entities[0]);
    EXPECT_EQ(elements.at(0).size(), 2u * 2 * 2 * 6);
  }
  gmsh::finalize();
}

}  // namespace
}  // namespace stroma::test
