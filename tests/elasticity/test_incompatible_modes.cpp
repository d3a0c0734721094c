// SPDX-License-Identifier: LGPL-2.1-or-later
// Hexahedra with incompatible modes: how few of them bend right. Contract, patch and momentum tests have them among all variants.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>

#include <cmath>

#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A straight beam of cells along x, clamped at x = 0, that a load at its end bends across z.
struct Beam {
  std::array<int, 3> cells;
  Vec3 size;             ///< [m]
  double poisson = 0.3;
  double skew = 0;       ///< by how much cross sections lean [m]
  std::string attributes = "method=\"small\" incompatibleModes=\"true\"";
  double load = 1;    ///< [N]
  double corner = 0;  ///< by how far the last node is moved along x [m]
};
constexpr double young = 1e6;

std::string sceneOf(const Beam& beam) {
  std::string position, cells, held, ends;
  const auto& n = beam.cells;
  int count = 0;
  for (int k = 0; k <= n[2]; ++k)
    for (int j = 0; j <= n[1]; ++j)
      for (int i = 0; i <= n[0]; ++i, ++count) {
        Vec3 p = Vec3(double(i) / n[0], double(j) / n[1], double(k) / n[2]).cwiseProduct(beam.size);
        if (i > 0 && i < n[0]) p.x() += beam.skew * (k % 2 == 0 ? 1 : -1);
        if (i == n[0] && j == n[1] && k == n[2]) p.x() += beam.corner;
        position += fmt::format("{:.17g} {:.17g} {:.17g} ", p.x(), p.y(), p.z());
        if (i == 0) held += fmt::format("{} ", count);
        if (i == n[0]) ends += fmt::format("{} ", count);
        if (i == n[0] || j == n[1] || k == n[2]) continue;
        const int row = n[0] + 1, layer = row * (n[1] + 1);
        for (const int c : {0, 1, row + 1, row, layer, layer + 1, layer + row + 1, layer + row}) cells += fmt::format("{} ", count + c);
      }
  return fmt::format(
      "<Node name=\"root\" dt=\"1\" gravity=\"0 0 0\"><Node name=\"body\"><StaticSolver/><SparseLDLSolver/><HexahedronSetTopologyContainer "
      "position=\"{}\" hexahedra=\"{}\"/><MechanicalObject/><UniformMass totalMass=\"1\"/><HexahedronFEMForceField name=\"fem\" "
      "youngModulus=\"{}\" poissonRatio=\"{}\" {}/><FixedProjectiveConstraint indices=\"{}\"/><ConstantForceField indices=\"{}\" "
      "totalForce=\"0 0 {}\"/></Node></Node>",
      position, cells, young, beam.poisson, beam.attributes, held, ends, beam.load);
}
double endOf(const Beam& beam) {
  FieldUnderTest t(sceneOf(beam), "HexahedronFEMForceField");
  const StepReport report = t.simulation().step();
  EXPECT_FALSE(report.failed() || report.unsolved) << report.reason;
  const State& state = t.field().state();
  double end = 0, count = 0;
  for (Index i = 0; i < state.size(); ++i)
    if (state.rest_position[std::size_t(i)].x() > beam.size.x() * (1 - 1e-9)) {
      end += state.x()[i].z() - state.rest_position[std::size_t(i)].z();
      ++count;
    }
  return end / count;
}
/// The deflection of the end over Timoshenko's.
double deflection(const Beam& beam) {
  const double l = beam.size.x(), b = beam.size.y(), h = beam.size.z(), nu = beam.poisson;
  const double shear = young / (2 * (1 + nu)), coefficient = 10 * (1 + nu) / (12 + 11 * nu);  // Cowper's
  return endOf(beam) / (beam.load * (4 * l * l * l / (young * b * h * h * h) + l / (coefficient * shear * b * h)));
}

TEST(IncompatibleModes, OneCellOverTheHeightBendsRight) {
  for (const int aspect : {1, 2, 4}) {
    const Beam beam{.cells = {16 / aspect, 1, 1}, .size = Vec3(16, 1, 1)};
    const double steps = aspect * aspect / 1024.;  // the curvature is one number per cell: 1 / (4 n^2) with n of them
    EXPECT_NEAR(deflection(beam), 1 - steps, 0.03) << aspect;
    Beam plain = beam;
    plain.attributes = "method=\"small\"";
    EXPECT_LT(deflection(plain), 0.75) << aspect;
  }
}

TEST(IncompatibleModes, NothingLocksNearIncompressibility) {
  for (const double skew : {0., 0.05})  // boxes, and cells of any shape
    EXPECT_NEAR(deflection({.cells = {16, 2, 2}, .size = Vec3(16, 2, 2), .poisson = 0.499, .skew = skew}), 1, 0.08) << skew;
}

/// The elastica: P l^2 = 3 E I bends the end by 0.60325 l.
TEST(IncompatibleModes, OneCellOverTheHeightBendsFar) {
  Beam beam{.cells = {40, 1, 1}, .size = Vec3(1, 0.02, 0.02), .poisson = 0};
  beam.load = 3 * young * std::pow(0.02, 4) / 12;
  for (const std::string method : {"polar", "svd"}) {
    beam.attributes = "method=\"" + method + "\" tangent=\"exact\" incompatibleModes=\"true\"";
    EXPECT_NEAR(endOf(beam), 0.60325, 0.0006) << method;
  }
  beam.attributes = "method=\"svd\" tangent=\"exact\"";
  EXPECT_LT(endOf(beam), 0.5);
}

/// The product of boxes is written out, that of other cells comes from their Gauss points: almost a box has both.
TEST(IncompatibleModes, BoxesAreThoseOfAnyShape) {
  for (const std::string method : {"small", "svd"})
    for (const double poisson : {-0.3, 0., 0.3, 0.49}) {
      Beam beam{.cells = {3, 2, 2}, .size = Vec3(0.5, 0.3, 0.1), .poisson = poisson};
      beam.attributes = "method=\"" + method + "\" incompatibleModes=\"true\"";
      FieldUnderTest box(sceneOf(beam), "HexahedronFEMForceField");
      beam.skew = 1e-10;
      FieldUnderTest other(sceneOf(beam), "HexahedronFEMForceField");
      for (FieldUnderTest* t : {&box, &other}) t->deform(0.05);
      EXPECT_LT(relativeDifference(box.force(), other.force()), 1e-7) << method << " " << poisson;
      EXPECT_LT(relativeDifference(box.product(box.direction), other.product(box.direction)), 1e-7) << method << " " << poisson;
      EXPECT_GT(relativeDifference(box.force(), other.force()), 0) << "these are the same kernels";
    }
}

/// K of a cell has six motions without a force, and no negative one.
TEST(IncompatibleModes, ACellHasSixMotionsWithoutAForce) {
  const auto expectSix = [](const Beam& beam) {
    FieldUnderTest t(sceneOf(beam), "HexahedronFEMForceField");
    const Index n = 3 * t.x.count();
    Eigen::MatrixXd dense(n, n);
    for (Index column = 0; column < n; ++column) {
      Vector unit(t.x.count());
      unit[column / 3][column % 3] = 1;
      const Vector df = t.product(unit);
      for (Index row = 0; row < n; ++row) dense(row, column) = -df[row / 3][row % 3];
    }
    const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(dense).eigenvalues();
    EXPECT_LT(std::abs(values[0]) + std::abs(values[5]), 1e-12 * values[n - 1]) << beam.skew << " " << beam.poisson;
    EXPECT_GT(values[6], 1e-3 * values[n - 1]) << beam.skew << " " << beam.poisson;
  };
  for (const double poisson : {0.3, 0.45}) {  // nine modes and twelve
    expectSix({.cells = {1, 1, 1}, .size = Vec3(1, 1, 1), .poisson = poisson});
    for (const double skew : {0., 0.2}) expectSix({.cells = {2, 1, 1}, .size = Vec3(2, 1, 1), .poisson = poisson, .skew = skew});
  }
}

/// Boxes beside cells of other shapes keep kernels of their own. Such a body is the same as one whose cells are all almost boxes.
TEST(IncompatibleModes, BoxesBesideOtherCellsKeepTheirKernels) {
  for (const std::string attributes :
       {"method=\"small\"", "method=\"large\"", "method=\"polar\" polarOf=\"edges\"", "method=\"svd\" dilatation=\"mean\"",
        "method=\"green\"", "method=\"polar\" tangent=\"exact\"", "method=\"small\" incompatibleModes=\"true\"",
        "method=\"svd\" incompatibleModes=\"true\" dilatation=\"mean\"", "method=\"svd\" incompatibleModes=\"true\" tangent=\"exact\""}) {
    SCOPED_TRACE(attributes);
    Beam beam{.cells = {5, 3, 2}, .size = Vec3(0.5, 0.3, 0.1), .attributes = attributes};
    const auto costOf = [](FieldUnderTest& t) { return t.field().cost().product; };
    FieldUnderTest boxes(sceneOf(beam), "HexahedronFEMForceField");
    beam.corner = 0.03;
    FieldUnderTest mixed(sceneOf(beam), "HexahedronFEMForceField");
    beam.skew = 1e-10;
    FieldUnderTest others(sceneOf(beam), "HexahedronFEMForceField");
    for (FieldUnderTest* t : {&mixed, &others}) t->deform(0.05);
    EXPECT_LT(relativeDifference(mixed.force(), others.force()), 1e-7);
    EXPECT_LT(relativeDifference(mixed.product(mixed.direction), others.product(mixed.direction)), 1e-7);
    EXPECT_NEAR(mixed.field().energy(mixed.x), others.field().energy(others.x), 1e-7 * others.field().energy(others.x));
    expectMatrixOfProducts(mixed);
    EXPECT_LE(costOf(mixed), costOf(boxes) + 0.2 * (costOf(others) - costOf(boxes))) << "one cell of 30 slows all";
    for (FieldUnderTest* t : {&mixed, &others}) t->simulation().setAttribute("/body/fem", "youngModulus", "3e6");
    EXPECT_LT(relativeDifference(mixed.force(), others.force()), 1e-7) << "another modulus";
  }
}

/// Another modulus while the scene runs: the matrices of all cells are others.
TEST(IncompatibleModes, AMaterialThatChangesIsSeen) {
  for (const double skew : {0., 0.1}) {
    Beam beam{.cells = {3, 1, 1}, .size = Vec3(3, 1, 1), .poisson = 0.2, .skew = skew};
    FieldUnderTest changed(sceneOf(beam), "HexahedronFEMForceField");
    changed.deform(0.05);
    const Vector before = changed.force();
    changed.simulation().setAttribute("/body/fem", "poissonRatio", "0.45");
    beam.poisson = 0.45;
    FieldUnderTest fresh(sceneOf(beam), "HexahedronFEMForceField");
    fresh.deform(0.05);
    EXPECT_GT(relativeDifference(before, changed.force()), 0.01);
    EXPECT_LT(relativeDifference(fresh.force(), changed.force()), 1e-14);
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
