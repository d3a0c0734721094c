// SPDX-License-Identifier: LGPL-2.1-or-later
// The kernels' own mathematics of hexahedra and tetrahedra against the table of kinds of cells: corners, Gauss points,
// derivatives.
#include <gtest/gtest.h>

#include <random>

#include "framework/fem/hexahedron.h"
#include "framework/fem/tetrahedron.h"
#include "framework/fem/tetrahedron_fans.h"
#include "framework/mesh/cell_kind.h"

namespace stroma::test {
namespace {

/// The table's point that lies where the kernels' point p does: xi goes fastest there.
constexpr int node_of_point[8] = {0, 1, 3, 2, 4, 5, 7, 6};
constexpr auto gauss_points = cell_kinds::hexahedron.rule(2).points;

constexpr bool pointsAgree() {
  for (int p = 0; p < 8; ++p)
    for (int axis = 0; axis < 3; ++axis) {
      const double ours = p >> axis & 1 ? hexahedron::gauss : -hexahedron::gauss;
      const double difference = gauss_points[node_of_point[p]].xi[axis] - ours;
      if (difference > 1.2e-16 || difference < -1.2e-16) return false;  // 1/sqrt 3 rounded once, and rounded twice
    }
  return true;
}
static_assert(pointsAgree());
static_assert(gauss_points.size() == 8);

TEST(CellNumbering, ModesAndDerivativesAreThoseOfTheTable) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1, 1);
  V3<double> x[8];
  for (V3<double>& corner : x) corner = {number(random), number(random), number(random)};
  const auto now = hexahedron::atPoints(hexahedron::modesOf(x));
  for (int p = 0; p < 8; ++p) {
    std::array<LocalPoint, 8> slopes;
    cell_kinds::hexahedron.gradients(gauss_points[node_of_point[p]].xi, slopes.data());
    const hexahedron::Columns<double> columns(now, p);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      V3<double> sum{0, 0, 0};
      for (std::size_t a = 0; a < 8; ++a) sum = sum + x[a] * slopes[a][axis];
      EXPECT_NEAR(columns.d[axis].x / 8, sum.x, 1e-15);
      EXPECT_NEAR(columns.d[axis].y / 8, sum.y, 1e-15);
      EXPECT_NEAR(columns.d[axis].z / 8, sum.z, 1e-15);
    }
  }
}

TEST(CellNumbering, TetrahedraHaveTheTablesEdgesFromTheirFirstNode) {
  const V3<double> x[4] = {{1, 2, 3}, {4, 6, 8}, {0, 1, 7}, {5, 5, 5}};
  const tetrahedron::Edges<double> edges(x);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& [from, to] = cell_kinds::tetrahedron.edges[i];
    EXPECT_EQ(from, 0);
    EXPECT_EQ(edges.e[i].x, x[to].x - x[from].x);
    EXPECT_EQ(edges.e[i].z, x[to].z - x[from].z);
  }
}

TEST(CellNumbering, FansJoinFacesOfTheTable) {
  const std::vector<Tetrahedron> cells{{0, 1, 2, 3}, {1, 2, 3, 4}};
  const auto fans = tetrahedron::gatherFans(cells, 5);
  ASSERT_EQ(fans.size(), 1u);
  std::array<Index, 3> common{fans[0].nodes[0], fans[0].nodes[1], fans[0].nodes[3]};
  std::sort(common.begin(), common.end());
  bool is_face = false;
  for (const LocalFace& face : cell_kinds::tetrahedron.faces) {
    std::array<Index, 3> nodes{cells[0][face.nodes[0]], cells[0][face.nodes[1]], cells[0][face.nodes[2]]};
    std::sort(nodes.begin(), nodes.end());
    is_face = is_face || nodes == common;
  }
  EXPECT_TRUE(is_face);
}

}  // namespace
}  // namespace stroma::test
