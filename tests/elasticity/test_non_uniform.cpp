// SPDX-License-Identifier: LGPL-2.1-or-later
// Hexahedra that are filled unevenly: energies of deformations that a cell has exactly are integrals over what is filled.
#include <fmt/format.h>

#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace {

std::string cell(const std::string& attributes, const std::string& type = "NonUniformHexahedronFEMForceField") {
  return "<Node name='root'><EulerImplicitSolver/><SparseLDLSolver/><RegularGridTopology n='3 2 2' min='0 0 0' max='2 1 1'/>"
         "<MechanicalObject/><UniformMass totalMass='1'/><" + type + " youngModulus='3000' poissonRatio='0.3' " + attributes + "/></Node>";
}

/// Factors of parts, x fastest, in the first of the two cells, and one for those of the other.
template <class Factor>
std::string factors(int n, Factor&& factor, double other = 1) {
  std::string text = "partFactors='";
  for (int e = 0; e < 2; ++e)
    for (int p = 0; p < n * n * n; ++p) text += fmt::format("{} ", e == 0 ? factor(p % n, p / n % n, p / n / n) : other);
  return text + "' ";
}

constexpr double mu = 3000 / 2.6, lambda = 3000 * 0.3 / (1.3 * 0.4);

/// Full cells of any number of parts are the hexahedra of HexahedronFEMForceField.
TEST(NonUniformHexahedra, FullCellsAreHexahedra) {
  for (const char* method : {"small", "large", "polar"})
    for (const int n : {1, 2, 4}) {
      const std::string chosen = fmt::format("method='{}' ", method);
      FieldUnderTest parts(cell(chosen + factors(n, [](int, int, int) { return 1.; })), "NonUniformHexahedronFEMForceField");
      FieldUnderTest whole(cell(chosen + "dilatation='local'", "HexahedronFEMForceField"), "HexahedronFEMForceField");
      parts.deform(0.1), whole.deform(0.1);
      EXPECT_LT(relativeDifference(parts.force(), whole.force()), 1e-12) << method << n;
      EXPECT_LT(relativeDifference(parts.product(parts.direction), whole.product(whole.direction)), 1e-12) << method << n;
    }
}

/// Parts that yield to each other as those of full cells do.
TEST(NonUniformHexahedra, FullCellsOfPartsThatYieldAreHexahedra) {
  for (const int n : {2, 4}) {
    const std::string full = factors(n, [](int, int, int) { return 1.; });
    FieldUnderTest parts(cell("method='polar' " + full, "HexahedronCompositeFEMForceField"), "HexahedronCompositeFEMForceField");
    FieldUnderTest whole(cell("method='polar' dilatation='local'", "HexahedronFEMForceField"), "HexahedronFEMForceField");
    parts.deform(0.1), whole.deform(0.1);
    EXPECT_LT(relativeDifference(parts.force(), whole.force()), 1e-12) << n;
  }
}

/// A cell of two layers across x, of moduli 1 and 0.1 without contraction, pulled along x: springs in a row, 2 / (1 + 10) of the
/// stiffness to 0.3 %, where parts that do not yield have the mean 0.55. Along the layers it is the mean.
TEST(NonUniformHexahedra, LayersOfPartsThatYieldAreSpringsInARow) {
  const auto pulled = [](const std::string& type, int axis) {
    std::string text = "partFactors='";
    for (int p = 0; p < 16; ++p) text += p % 2 == 0 ? "1 " : "0.1 ";
    FieldUnderTest t("<Node name='root'><EulerImplicitSolver/><SparseLDLSolver/><RegularGridTopology n='3 2 2' min='0 0 0' max='2 1 1'/>"
                     "<MechanicalObject/><UniformMass totalMass='1'/><" + type + " youngModulus='3000' poissonRatio='0' method='small' " +
                         text + "'/></Node>",
                     type);
    constexpr double e = 0.01;
    for (Index i = 0; i < t.x.count(); ++i) t.x[i][axis] += e * t.x[i][axis];
    return t.field().energy(t.x) / (2 * 3000 * e * e / 2);
  };
  EXPECT_NEAR(pulled("HexahedronCompositeFEMForceField", 0), 2 / 11., 1e-3) << "middles of faces follow their own corners alone";
  EXPECT_NEAR(pulled("NonUniformHexahedronFEMForceField", 0), 0.55, 1e-9);
  EXPECT_NEAR(pulled("HexahedronCompositeFEMForceField", 1), 0.55, 1e-9);
}

/// u_x = c y z in the first cell: E = mu/2 c^2 times the integral of y^2 + z^2 over what is filled. Where the upper half is empty
/// that is 1/6 + 1/24. The second cell is empty.
TEST(NonUniformHexahedra, EnergyIsThatOfWhatIsFilled) {
  for (const int n : {2, 4}) {
    const std::string lower_half = factors(n, [n](int, int, int k) { return k < n / 2 ? 1. : 0.; }, 0);
    FieldUnderTest t(cell("method='small' " + lower_half), "NonUniformHexahedronFEMForceField");
    constexpr double c = 0.01;
    for (Index i = 0; i < t.x.count(); ++i) t.x[i] += c * Vec3(t.x[i][1] * t.x[i][2], 0, 0);
    EXPECT_NEAR(t.field().energy(t.x), mu / 2 * c * c * (1 / 6. + 1 / 24.), 1e-12 * mu * c * c) << n;
  }
}

/// An even strain e along x: E = V/2 (lambda + 2 mu) e^2 times the mean factor of each cell.
TEST(NonUniformHexahedra, EvenStrainsCountTheMeanFactor) {
  FieldUnderTest t(cell("method='polar' " + factors(2, [](int i, int j, int k) { return 0.1 + i + 2 * j + 4 * k; })),
                   "NonUniformHexahedronFEMForceField");
  constexpr double e = 0.02;
  for (Index i = 0; i < t.x.count(); ++i) t.x[i] += e * Vec3(t.x[i][0], 0, 0);
  EXPECT_NEAR(t.field().energy(t.x), (lambda + 2 * mu) / 2 * e * e * (3.6 + 1), 1e-11);
}

TEST(NonUniformHexahedra, SaysWhatDoesNotFit) {
  expectContains(problemsOf(cell("partFactors='1 1 1'")), "partFactors has 3 values for 2 cells");
  const std::string fine = problemsOf(cell(factors(32, [](int, int, int) { return 1; })));  // matrices of 150 MB for each cell
  expectContains(fine, "partFactors has 65536 values for 2 cells");
  expectContains(fine, "512 or 4096 for each cell");
  expectContains(problemsOf("<Node name='root'><EulerImplicitSolver/><SparseLDLSolver/><MeshTopology position='0 0 0 1 0 0 1 1 0 0 1 0 "
                            "0 0 1 1 0 1 1 1 1 0 1 1' hexahedra='4 5 6 7 0 1 2 3'/><MechanicalObject/><UniformMass totalMass='1'/>"
                            "<NonUniformHexahedronFEMForceField youngModulus='1' poissonRatio='0.3'/></Node>"),
                 "inverted at rest");
}

}  // namespace
}  // namespace stroma::test
