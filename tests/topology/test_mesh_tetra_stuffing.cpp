// SPDX-License-Identifier: LGPL-2.1-or-later
// Lattices of tetrahedra in a surface: cells of one size, or cut along the surface; no gaps between them.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "framework/mesh/topology.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Of an octahedron with corners at a distance of 1.
Scene stuffed(const std::string& attributes) {
  return sceneFromText(
      "<Node name='root'><MeshTetraStuffing name='e' inputPoints='1 0 0  -1 0 0  0 1 0  0 -1 0  0 0 1  0 0 -1' inputTriangles='0 2 4  "
      "2 1 4  1 3 4  3 0 4  2 0 5  1 2 5  3 1 5  0 3 5' " + attributes +
      "/><TetrahedronSetTopologyContainer name='mesh' position='@e.outputPoints' tetrahedra='@e.outputTetrahedra'/></Node>");
}
const Mesh& meshOf(const Scene& scene) { return dynamic_cast<const Topology&>(*scene.root->components().back()).mesh(); }

double volumeOf(const Mesh& mesh, const Tetrahedron& cell) {
  const auto at = [&](std::size_t i) -> const Vec3& { return mesh.position[std::size_t(cell[i])]; };
  return (at(1) - at(0)).dot((at(2) - at(0)).cross(at(3) - at(0))) / 6;
}

/// Sides that belong to one cell enclose the volume of all; none belongs to three.
void expectNoGaps(const Mesh& mesh, double all) {
  std::map<std::array<Index, 3>, std::pair<int, double>> sides;
  for (const Tetrahedron& cell : mesh.tetrahedra)
    for (const auto& side : {std::array{0, 2, 1}, std::array{0, 1, 3}, std::array{1, 2, 3}, std::array{0, 3, 2}}) {
      std::array<Index, 3> nodes;
      for (std::size_t i = 0; i < 3; ++i) nodes[i] = cell[std::size_t(side[i])];
      const auto at = [&](std::size_t i) -> const Vec3& { return mesh.position[std::size_t(nodes[i])]; };
      const double volume = at(0).dot(at(1).cross(at(2))) / 6;
      std::sort(nodes.begin(), nodes.end());
      auto& [count, cone] = sides[nodes];
      ++count, cone += volume;
    }
  double enclosed = 0;
  for (const auto& [nodes, side] : sides) {
    EXPECT_LE(side.first, 2);
    if (side.first == 1) enclosed += side.second;
  }
  EXPECT_NEAR(enclosed, all, 1e-12);
}

TEST(MeshTetraStuffing, CellsOfOneSizeCoverTheSurface) {
  const Scene scene = stuffed("size='0.24'");
  const Mesh& mesh = meshOf(scene);
  double all = 0;
  for (const Tetrahedron& cell : mesh.tetrahedra) {
    EXPECT_NEAR(volumeOf(mesh, cell), 0.24 * 0.24 * 0.24 / 12, 1e-15);
    all += volumeOf(mesh, cell);
    const auto is_inside = [&](Index node) { return mesh.position[std::size_t(node)].lpNorm<1>() < 1; };
    EXPECT_TRUE(std::any_of(cell.begin(), cell.end(), is_inside));
  }
  EXPECT_GT(all, 4 / 3.);
  expectNoGaps(mesh, all);
}

TEST(MeshTetraStuffing, CellsThatAreCutLieInTheSurface) {
  for (const std::string snap : {"", "snapPoints='true'"})
    for (const double size : {0.23, 0.11}) {
      const Scene scene = stuffed(fmt::format("size='{}' splitTetrahedra='true' {}", size, snap));
      const Mesh& mesh = meshOf(scene);
      double all = 0;
      for (const Tetrahedron& cell : mesh.tetrahedra) {
        EXPECT_GT(volumeOf(mesh, cell), 0);
        all += volumeOf(mesh, cell);
      }
      for (const Vec3& p : mesh.position) EXPECT_LT(p.lpNorm<1>(), 1 + 1e-12);
      EXPECT_LT(all, 4 / 3.);
      EXPECT_GT(all, 4 / 3. * (1 - 1.5 * size * size)) << "what is cut off at edges and corners";
      expectNoGaps(mesh, all);
    }
}

TEST(MeshTetraStuffing, SaysWhatIsMissing) {
  const auto said = [](const std::string& attributes) {
    return problemsOf("<Node name='root'><MeshTetraStuffing name='e' " + attributes + "/></Node>");
  };
  expectContains(said(""), "there is no surface to fill");
  expectContains(said("inputPoints='0 0 0' inputTriangles='0 1 2'"), "a triangle names node 1 of 1");
  expectContains(said("inputPoints='0 0 0  1 0 0  0 1 0' inputTriangles='0 1 2' size='0'"), "size is zero");
  const std::string body = "inputPoints='0 0 0  1 0 0  0 1 0  0 0 1' inputTriangles='0 2 1  0 1 3  1 2 3  2 0 3' ";
  expectContains(said(body + "vbbox='5 5 5  6 6 6'"), "no node of the lattice lies in the surface");
  expectContains(said(body + "size='1e-4'"), "the lattice has");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
