// SPDX-License-Identifier: LGPL-2.1-or-later
// The fields of stresses and principal values of linear elements: homogeneous deformations against the formulas of the laws, and
// the forces that the stresses of tetrahedra must make.
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "framework/mechanics/state_topology.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double young = 3000, poisson = 0.4;  // of elasticBodies()
constexpr double mu = young / (2 * (1 + poisson)), lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));

std::vector<double> fieldOf(FieldUnderTest& t, const std::string& name) {
  std::vector<double> values;
  t.field().cellField(name, t.x, values);
  return values;
}

Mat3 tensorOf(const double* v) {
  Mat3 m;
  m << v[0], v[3], v[5], v[3], v[1], v[4], v[5], v[4], v[2];
  return m;
}

Mat3 hooke(const Mat3& strain) { return lambda * strain.trace() * Mat3::Identity() + 2 * mu * strain; }

/// Cauchy's stress of F = R U.
Mat3 expectedStress(const std::string& method, const Mat3& r, const Mat3& u) {
  const Mat3 f = r * u;
  if (method == "small") return hooke((f + f.transpose()) / 2 - Mat3::Identity());
  if (method == "green") return f * hooke((f.transpose() * f - Mat3::Identity()) / 2) * f.transpose() / f.determinant();
  return r * hooke(u - Mat3::Identity()) * r.transpose();
}

TEST(StressFields, HomogeneousDeformationsHaveTheStressOfTheLaw) {
  const Mat3 r = Eigen::AngleAxisd(2, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  Mat3 u;
  u << 1.2, 0.05, 0.02, 0.05, 0.9, -0.04, 0.02, -0.04, 1.1;
  for (const ElasticBody& body : elasticBodies())
    for (const std::string method : {"small", "polar", "svd", "green"})
      for (const std::string dilatation : {"local", "mean"}) {
        if (dilatation == "mean" && method == "green" && body.tetrahedra) continue;
        SCOPED_TRACE(body.name + " " + method + " " + dilatation);
        FieldUnderTest t(body.scene("method=\"" + method + "\" dilatation=\"" + dilatation + "\""), body.type);
        for (Index i = 0; i < t.x.count(); ++i) t.x[i] = r * u * Vec3(t.x[i]) + Vec3(3, -2, 1);
        const Mat3 expected = expectedStress(method, r, u);
        const Vec3 principal = Eigen::SelfAdjointEigenSolver<Mat3>(expected).eigenvalues();
        const std::vector<double> stress = fieldOf(t, "stress"), principals = fieldOf(t, "principalStress");
        const std::vector<double> strain = fieldOf(t, "strain"), strains = fieldOf(t, "principalStrain");
        ASSERT_GT(stress.size(), 0u);
        ASSERT_EQ(stress.size(), 2 * principals.size());
        EXPECT_EQ(t.field().cellFieldShape("stress").width, 6u);
        EXPECT_EQ(t.field().cellFieldShape("principalStress").width, 3u);
        const double tolerance = 1e-9 * expected.norm();
        for (std::size_t e = 0; e < stress.size() / 6; ++e) {
          EXPECT_LT((tensorOf(&stress[6 * e]) - expected).norm(), tolerance) << e;
          for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(principals[3 * e + k], principal[Eigen::Index(2 - k)], tolerance);
          const Vec3 own = Eigen::SelfAdjointEigenSolver<Mat3>(tensorOf(&strain[6 * e])).eigenvalues();
          for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(strains[3 * e + k], own[Eigen::Index(2 - k)], 1e-12);
        }
      }
}

/// Where dilatation is mean the pressures of points are others than their own: they have no part in it, whatever the deformation.
TEST(StressFields, VonMisesIsThatOfTheStress) {
  for (const ElasticBody& body : elasticBodies())
    for (const std::string method : {"small", "polar", "svd", "green"})
      for (const std::string dilatation : {"local", "mean"}) {
        if (dilatation == "mean" && method == "green" && body.tetrahedra) continue;
        SCOPED_TRACE(body.name + " " + method + " " + dilatation);
        FieldUnderTest t(body.scene("method=\"" + method + "\" dilatation=\"" + dilatation + "\""), body.type);
        t.deform(0.05);
        const std::vector<double> stress = fieldOf(t, "stress"), ours = fieldOf(t, "vonMises");
        ASSERT_GT(ours.size(), 0u);
        ASSERT_EQ(stress.size(), 6 * ours.size());
        for (std::size_t e = 0; e < ours.size(); ++e) {
          const Mat3 s = tensorOf(&stress[6 * e]);
          EXPECT_NEAR(ours[e], std::sqrt(1.5) * (s - s.trace() / 3 * Mat3::Identity()).norm(), 1e-9 * s.norm()) << e;
        }
      }
}

/// f_i = -sum_e V_e sigma_e g_i of method small, whose stresses act on the shape at rest; with a mean dilatation the pressure is
/// that of the nodes, which is far from that of the cell's own volume where the body is nearly incompressible.
TEST(StressFields, StressesOfTetrahedraMakeTheirForces) {
  for (const std::string dilatation : {"local", "mean"}) {
    SCOPED_TRACE(dilatation);
    std::string scene = tetrahedraScene("method=\"small\" dilatation=\"" + dilatation + "\"");
    const std::string ratio = "poissonRatio=\"0.4\"";
    scene.replace(scene.find(ratio), ratio.size(), "poissonRatio=\"0.499\"");
    FieldUnderTest t(scene, "TetrahedronFEMForceField");
    t.deform(0.05);
    const std::vector<double> stress = fieldOf(t, "stress");
    const State& state = t.field().state();
    Vector expected(t.x.count());
    std::size_t e = 0;
    for (const Tetrahedron& nodes : topologyOf(state)->mesh().tetrahedra) {
      Mat3 edges;
      for (int k = 0; k < 3; ++k) edges.col(k) = state.rest_position[nodes[k + 1]] - state.rest_position[nodes[0]];
      const Mat3 pull = tensorOf(&stress[6 * e++]) * edges.inverse().transpose() * std::abs(edges.determinant()) / 6;
      for (int k = 0; k < 3; ++k) {
        expected[nodes[k + 1]] -= pull.col(k);
        expected[nodes[0]] += pull.col(k);
      }
    }
    EXPECT_LT(relativeDifference(t.force(), expected), 1e-10);
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
