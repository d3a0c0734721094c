// SPDX-License-Identifier: LGPL-2.1-or-later
// Masses of quadratic tetrahedra against closed forms.
#include <Eigen/Geometry>
#include <cmath>

#include "framework/mesh/cell_kind.h"
#include "framework/mesh/simplex_size.h"
#include "tests/support/quadratic_block.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::vector<Tetrahedron> one_cell{{0, 1, 2, 3}};

std::string body(const QuadraticBlock& block, const std::string& mass) {
  return "<Node name=\"root\" gravity=\"0 -10 1\"><TestIntegrator/>" + block.topology() + "<MechanicalObject/><" +
         mass + "/></Node>";
}

/// V/420 times: 6 for a corner and itself, 1 for two corners, -4 for a corner and the middle of one of its edges, -6 for
/// a corner and another middle, 32 for a middle and itself, 16 for two of one corner, 8 for two opposite ones.
TEST(QuadraticMasses, OneStraightCellHasTheKnownMatrix) {
  const QuadraticBlock block =
      QuadraticBlock::raised({{0.1, 0, 0}, {1, 0.2, 0}, {0, 1, -0.3}, {0.2, 0.1, 1}}, one_cell);
  const auto& p = block.position;
  const double volume = tetrahedronVolume(p[0], p[1], p[2], p[3]);
  Simulation simulation(sceneFromText(body(block, "MeshMatrixMass massDensity='420'")));
  const BlockMatrix& matrix = simulation.systems()[0]->matrix().withFactors({.mass = 1, .stiffness = 0}).assemble();
  constexpr int ends[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  const auto expected = [&](int a, int b) {
    if (a > b) std::swap(a, b);
    if (b < 4) return a == b ? 6 : 1;
    const auto& [c, d] = ends[b - 4];
    if (a < 4) return a == c || a == d ? -4 : -6;
    if (a == b) return 32;
    const auto& [e, f] = ends[a - 4];
    return c == e || c == f || d == e || d == f ? 16 : 8;
  };
  for (int a = 0; a < 10; ++a)
    for (int b = 0; b < 10; ++b)
      EXPECT_NEAR(matrix.values()[std::size_t(matrix.slot(a, b)) * 9], volume * expected(a, b), 1e-13) << a << " " << b;
}

TEST(QuadraticMasses, LumpedOnesArePositiveAndSumToTheMass) {
  const QuadraticBlock block = QuadraticBlock::raised({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, one_cell);
  for (const std::string mass : {"DiagonalMass", "MeshMatrixMass lumping='true'"}) {
    Simulation simulation(sceneFromText(body(block, mass + " massDensity='6'")));
    const Mass& lumped = *simulation.systems()[0]->masses()[0];
    EXPECT_TRUE(lumped.isDiagonal());
    EXPECT_NEAR(lumped.totalMass(), 1, 1e-14);
    for (std::size_t n = 0; n < 10; ++n) EXPECT_NEAR(lumped.lumped()[n], n < 4 ? 1. / 36 : 4. / 27, 1e-14);
  }
}

/// A block with curved edges: the mass is that of its volume, a uniform motion has 1/2 m v^2, a turning one the energy
/// of the integral, and a body that falls free falls as a whole.
TEST(QuadraticMasses, ABlockHasTheEnergyOfARigidBody) {
  QuadraticBlock block =
      QuadraticBlock::box({2, 2, 2}, [](const Vec3& p) { return Vec3(0.4 * p.x(), 0.2 * p.y(), 0.1 * p.z()); });
  for (const double distance : {0., 0.005}) {
    block.crumple(distance);
    Simulation simulation(sceneFromText(body(block, "MeshMatrixMass massDensity='1000'")));
    System& system = *simulation.systems()[0];
    double volume = 0;
    for (const QuadraticTetrahedron& cell : block.cells) {
      std::array<Vec3, 10> x;
      for (std::size_t a = 0; a < 10; ++a) x[a] = block.position[std::size_t(cell[a])];
      volume += cell_kinds::quadratic_tetrahedron.size(x.data());
    }
    if (distance == 0) {
      EXPECT_NEAR(volume, 0.008, 1e-15);
    }
    EXPECT_NEAR(system.masses()[0]->totalMass(), 1000 * volume, 1e-11);
    for (Index i = 0; i < system.allRows(); ++i) system.v[i] = Vec3(1, 2, -2);
    EXPECT_NEAR(system.kineticEnergy(), 0.5 * 1000 * volume * 9, 1e-10);
    if (distance == 0) {
      for (Index i = 0; i < system.allRows(); ++i) system.v[i] = Vec3(0, 0, 3).cross(Vec3(system.x[i]));
      const double exact = 0.5 * 9 * 8 * (0.16 + 0.04) / 3;
      EXPECT_NEAR(system.kineticEnergy(), exact, 1e-13 * exact);
    }
    system.computeForce(system.x, system.v, system.f);
    Vector falling(system.allRows());
    for (Index i = 0; i < system.allRows(); ++i) falling[i] = Vec3(0, -10, 1);
    Vector weight(system.allRows());
    system.masses()[0]->addProduct(falling, 1, weight);
    for (Index i = 0; i < system.allRows(); ++i) EXPECT_LT((Vec3(system.f[i]) - Vec3(weight[i])).norm(), 1e-12);
    EXPECT_LT(system.masses()[0]->rowSums()[0], 0) << "a corner's weight is negative";
    EXPECT_GT(system.masses()[0]->lumped()[0], 0);
  }
}

TEST(FEMMass, OfBoxesIsTheConsistentMatrixAndKnowsNoQuadraticCells) {
  const auto box = [](const std::string& mass) {
    return simulationFromText("<Node name='root' gravity='0 -10 1'><TestIntegrator/><RegularGridTopology n='3 2 2' min='0 0 0' "
                              "max='2 3 1'/><MechanicalObject/>" +
                              mass + "</Node>");
  };
  Simulation consistent = box("<MeshMatrixMass massDensity='5'/>"),
             by_points = box("<NodalMassDensity property='5'/><FEMMass/>");
  System &a = *consistent.systems()[0], &b = *by_points.systems()[0];
  const BlockMatrix &expected = a.matrix().withFactors({.mass = 1, .stiffness = 0}).assemble(),
                    &matrix = b.matrix().withFactors({.mass = 1, .stiffness = 0}).assemble();
  ASSERT_EQ(matrix.values().size(), expected.values().size());
  for (std::size_t k = 0; k < matrix.values().size(); ++k) EXPECT_NEAR(matrix.values()[k], expected.values()[k], 1e-14);
  Vector v(12), product(12), by_matrix(12);
  for (Index i = 0; i < 12; ++i) v[i] = Vec3(std::sin(i), std::cos(3 * i), i);
  b.addMassProduct(v, 1, product);
  matrix.multiply(v, by_matrix);
  for (Index i = 0; i < 12; ++i) EXPECT_LT((product[i] - by_matrix[i]).norm(), 1e-13);
  double weight = 0;
  b.computeForce(b.x, b.v, b.f);
  for (Index i = 0; i < 12; ++i) weight += b.f[i][1];
  EXPECT_NEAR(weight, -10 * 5 * 6, 1e-12);
  const QuadraticBlock block = QuadraticBlock::raised({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, one_cell);
  expectContains(problemsOf(body(block, "FEMMass")), "no quadrature points of quadraticTetrahedra");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
