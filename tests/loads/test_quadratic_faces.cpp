// SPDX-License-Identifier: LGPL-2.1-or-later
// Pressure and traction on faces of six nodes: work and balance on a body with curved edges, consistent loads.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "framework/mesh/cell_kind.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string scene(const QuadraticBlock& block, const std::string& load) {
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/>" +
         block.topology() + "<MechanicalObject/><UniformMass totalMass=\"1\"/><" + load + "/></Node>";
}
QuadraticBlock curved() {
  QuadraticBlock block = QuadraticBlock::box({2, 1, 2}, [](const Vec3& p) { return Vec3(2 * p.x(), p.y(), p.z()); });
  return block.crumple(0.06);
}
double volumeOf(const QuadraticBlock& block, ConstRows x) {
  double volume = 0;
  for (const QuadraticTetrahedron& cell : block.cells) {
    std::array<Vec3, 10> p;
    for (std::size_t a = 0; a < 10; ++a) p[a] = x[cell[a]];
    volume += cell_kinds::quadratic_tetrahedron.size(p.data());
  }
  return volume;
}

TEST(QuadraticFaces, APressureDoesPdVAndBalances) {
  const QuadraticBlock block = curved();
  FieldUnderTest t(scene(block, "SurfacePressureForceField pressure='7'"), "SurfacePressureForceField");
  for (unsigned seed : {1u, 2u}) {
    t.deform(0.05, seed);
    EXPECT_NEAR(t.field().energy(t.x), -7 * volumeOf(block, t.x), 1e-12);
    const Momentum momentum = momentumOf(t.x, t.force());
    EXPECT_LT(momentum.force, 1e-14);
    EXPECT_LT(momentum.torque, 1e-14);
    const double h = 1e-5;
    Vector a(t.x.count()), b(t.x.count());
    copy(t.x, a), copy(t.x, b);
    axpy(h, t.direction, a), axpy(-h, t.direction, b);
    EXPECT_NEAR(dot(t.force(), t.direction), 7 * (volumeOf(block, a) - volumeOf(block, b)) / (2 * h), 1e-8);
    EXPECT_LT(relativeDifference(t.product(t.direction), t.differenceOfForces(1e-5)), 1e-8);
    expectMatrixOfProducts(t);
    expectSymmetricProducts(t);
  }
}

/// One flat face: nothing at the corners, a third of the load at each middle.
TEST(QuadraticFaces, AFlatFaceHasItsLoadAtTheMiddles) {
  const QuadraticBlock block = QuadraticBlock::raised({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}});
  for (const std::string load : {"SurfacePressureForceField pressure='-6' min='-1 -1 -1e-9' max='3 3 1e-9'",
                                 "SurfaceTractionForceField traction='0 0 6' min='-1 -1 -1e-9' max='3 3 1e-9'"}) {
    FieldUnderTest t(scene(block, load), load.substr(0, load.find(' ')));
    const Vector f = t.force();
    for (Index n = 0; n < 10; ++n) {
      const bool middle = n >= 4 && block.position[std::size_t(n)].z() == 0;
      EXPECT_LT((Vec3(f[n]) - Vec3(0, 0, middle ? 2 : 0)).norm(), 1e-14) << n;
    }
  }
}

TEST(QuadraticFaces, TractionsHaveTheirDerivative) {
  const QuadraticBlock block = curved();
  for (const std::string area : {"current", "rest"}) {
    FieldUnderTest t(scene(block, "SurfaceTractionForceField traction='1 2 -3' tangent='exact' area='" + area + "'"),
                     "SurfaceTractionForceField");
    t.deform(0.05);
    Vec3 sum = Vec3::Zero();
    const Vector f = t.force();
    for (Index i = 0; i < f.count(); ++i) sum += f[i];
    EXPECT_GT(sum.dot(Vec3(1, 2, -3)) / 14, 6) << "at least the area of the box's six sides";
    if (area == "rest") continue;
    EXPECT_LT(relativeDifference(t.product(t.direction), t.differenceOfForces(1e-5)), 1e-8);
    expectMatrixOfProducts(t);
  }
}

/// Listed faces, by the indices that a selection gives.
TEST(QuadraticFaces, AreListedByTheirIndices) {
  const QuadraticBlock block = QuadraticBlock::raised({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}});
  const std::string text =
      "<Node name=\"root\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/>" +
      block.topology("quadraticTriangles=\"0 2 1 6 5 4  0 1 3 4 8 7\"") +
      "<MechanicalObject/><UniformMass totalMass=\"1\"/><BoxROI name=\"floor\" box=\"-1 -1 -1e-9 3 3 1e-9\" "
      "computeQuadraticTriangles=\"true\"/><SurfacePressureForceField pressure=\"6\" "
      "quadraticTriangleIndices=\"@floor.quadraticTriangleIndices\"/></Node>";
  FieldUnderTest t(text, "SurfacePressureForceField");
  Vec3 sum = Vec3::Zero();
  const Vector f = t.force();
  for (Index i = 0; i < f.count(); ++i) sum += f[i];
  EXPECT_LT((sum - Vec3(0, 0, -6)).norm(), 1e-14) << "the outward normal is -z, and a pressure of 1 on an area of 1";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
