// SPDX-License-Identifier: LGPL-2.1-or-later
// The table of kinds of cells against Gmsh's library: numbers, order of nodes, shape functions and their gradients.
#include <gmsh.h>
#include <gtest/gtest.h>

#include "tests/support/cell_kind_names.h"

namespace stroma::test {
namespace {

class GmshCellKinds : public testing::TestWithParam<const CellKind*> {
 protected:
  static void SetUpTestSuite() { gmsh::initialize(); }
  static void TearDownTestSuite() { gmsh::finalize(); }
  const CellKind& kind_ = *GetParam();
};

TEST_P(GmshCellKinds, NodesAreGmshs) {
  std::string name;
  int dimension = -1, order = 0, nodes = 0, primary = 0;
  std::vector<double> places;
  gmsh::model::mesh::getElementProperties(kind_.gmsh.number, name, dimension, order, nodes, places, primary);
  EXPECT_EQ(dimension, kind_.dimension);
  ASSERT_EQ(nodes, kind_.nodes);
  for (int k = 0; k < nodes; ++k)
    for (int i = 0; i < dimension; ++i)
      EXPECT_EQ(places[std::size_t(k * dimension + i)], kind_.reference[kind_.gmsh.order[k]][i]) << k << " " << i;
}

TEST_P(GmshCellKinds, ShapesAndGradientsAreGmshs) {
  if (kind_.dimension == 0) return;  // Gmsh has no functions on points
  std::vector<double> at;
  for (const QuadraturePoint& point : kind_.rules.back().points) at.insert(at.end(), point.xi.begin(), point.xi.end());
  int components = 0, orientations = 0;
  std::vector<double> values, slopes;
  gmsh::model::mesh::getBasisFunctions(kind_.gmsh.number, at, "Lagrange", components, values, orientations);
  gmsh::model::mesh::getBasisFunctions(kind_.gmsh.number, at, "GradLagrange", components, slopes, orientations);
  std::size_t entry = 0;
  for (const QuadraturePoint& point : kind_.rules.back().points) {
    std::array<double, most_cell_nodes> n{};
    std::array<LocalPoint, most_cell_nodes> g{};
    kind_.shapes(point.xi, n.data());
    kind_.gradients(point.xi, g.data());
    for (int k = 0; k < kind_.nodes; ++k, ++entry) {
      EXPECT_NEAR(values[entry], n[kind_.gmsh.order[k]], 1e-15);
      for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(slopes[3 * entry + i], g[kind_.gmsh.order[k]][i], 1e-15);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, GmshCellKinds, testing::ValuesIn(cell_kinds::all),
                         [](const auto& kind) { return std::string(kind.param->singular); });

}  // namespace
}  // namespace stroma::test
