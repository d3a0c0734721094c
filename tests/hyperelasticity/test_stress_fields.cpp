// SPDX-License-Identifier: LGPL-2.1-or-later
// The fields of stresses of hyperelastic cells: against the slope of the energy, and the pressure of a mean dilatation against
// the forces.
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "tests/hyperelasticity/law_cases.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

Mat3 tensorAt(const std::vector<double>& values, std::size_t cell) {
  const double* v = &values[6 * cell];
  Mat3 m;
  m << v[0], v[3], v[5], v[3], v[1], v[4], v[5], v[4], v[2];
  return m;
}

std::string hexahedraOf(const LawCase& law, const std::string& dilatation) {
  std::string scene = hexahedraScene("", false);
  const auto at = scene.find("<HexahedronFEMForceField");
  return scene.replace(at, scene.find("/>", at) + 2 - at,
                       "<HexahedronHyperelasticityFEMForceField " + law.attributes + " dilatation='" + dilatation + "'/>");
}

double volumeOf(const CellKind& kind, const std::vector<Vec3>& corners) {
  double sum = 0;
  for (const auto& point : kind.rule(2).points) {
    std::array<LocalPoint, most_cell_nodes> slopes;
    kind.gradients(point.xi, slopes.data());
    Mat3 edges = Mat3::Zero();
    for (std::size_t a = 0; a < corners.size(); ++a) edges += corners[a] * Vec3(slopes[a].data()).transpose();
    sum += point.weight * edges.determinant();
  }
  return sum;
}

/// sigma : A = dU/ds / V of x -> (1 + s A) x, all cells alike.
TEST(HyperelasticStressFields, AreTheSlopeOfTheEnergy) {
  for (const LawCase& law : lawCases())
    for (const std::string dilatation : {"local", "mean"}) {
      if (dilatation == "mean" && law.name == "StVenantKirchhoff") continue;
      SCOPED_TRACE(law.name + " " + dilatation);
      FieldUnderTest t(hexahedraOf(law, dilatation), "HexahedronHyperelasticityFEMForceField");
      t.deform(0);
      std::vector<double> stress, principal, ratio;
      t.field().cellField("stress", t.x, stress);
      t.field().cellField("principalStress", t.x, principal);
      double volume = 0;
      for (const Hexahedron& cell : topologyOf(t.field().state())->mesh().hexahedra) {
        std::vector<Vec3> corners;
        for (const Index node : cell) corners.emplace_back(t.x[node]);
        volume += volumeOf(cell_kinds::hexahedron, corners);
      }
      const auto energyAt = [&](const Mat3& a) {
        Vector moved(t.x.count());
        for (Index i = 0; i < t.x.count(); ++i) moved[i] = Vec3(t.x[i]) + a * Vec3(t.x[i]);
        return t.field().energy(moved);
      };
      Mat3 expected;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          Mat3 a = Mat3::Zero();
          a(i, j) = 1e-5;
          expected(i, j) = (energyAt(a) - energyAt(-a)) / (2e-5 * volume);
        }
      const Vec3 values = Eigen::SelfAdjointEigenSolver<Mat3>((expected + expected.transpose()) / 2).eigenvalues();
      ASSERT_GT(stress.size(), 0u);
      for (std::size_t e = 0; e < stress.size() / 6; ++e) {
        EXPECT_LT((tensorAt(stress, e) - expected).norm(), 1e-6 * expected.norm()) << e;
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(principal[3 * e + k], values[Eigen::Index(2 - k)], 1e-6 * expected.norm());
      }
    }
}

/// -sum f.x = sum_e V_e tr(sigma_e): of J^-2/3 C the deviator has no trace, and the pressure of a cell is that of its volume,
/// whatever its points do.
TEST(HyperelasticStressFields, ThePressureOfAMeanDilatationMakesTheForces) {
  LawCase stiff;
  stiff.attributes = "materialName=\"MooneyRivlin\" ParameterSet=\"300 200 500000\"";
  FieldUnderTest t(hexahedraOf(stiff, "mean"), "HexahedronHyperelasticityFEMForceField");
  t.deform(0.05);
  std::vector<double> stress;
  t.field().cellField("stress", t.x, stress);
  double expected = 0, magnitude = 0;
  std::size_t e = 0;
  for (const Hexahedron& cell : topologyOf(t.field().state())->mesh().hexahedra) {
    std::vector<Vec3> corners;
    for (const Index node : cell) corners.emplace_back(t.x[node]);
    const double part = volumeOf(cell_kinds::hexahedron, corners) * tensorAt(stress, e++).trace();
    expected += part;
    magnitude += std::abs(part);
  }
  double sum = 0;
  const Vector f = t.force();
  for (Index i = 0; i < f.count(); ++i) sum -= f[i].dot(t.x[i]);
  ASSERT_GT(magnitude, 0);
  EXPECT_NEAR(sum, expected, 1e-9 * magnitude);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
