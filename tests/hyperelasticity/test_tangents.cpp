// SPDX-License-Identifier: LGPL-2.1-or-later
// The two replaced tangents: what they are where elements are compressed, and that they are the exact one elsewhere.
#include <Eigen/Eigenvalues>

#include "tests/hyperelasticity/law_cases.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string one_cell =
    "<Node name=\"root\" dt=\"0.01\"><EulerImplicitSolver/><CGLinearSolver/>"
    "<TetrahedronSetTopologyContainer position=\"0 0 0 1 0 0 0 1 0 0 0 1\" tetrahedra=\"0 1 2 3\"/>"
    "<MechanicalObject/><UniformMass totalMass=\"1\"/><TetrahedronHyperelasticityFEMForceField ";

Eigen::MatrixXd dense(FieldUnderTest& t, const Mat3& f) {
  t.rest();
  for (Index i = 0; i < t.x.count(); ++i) t.x[i] = f * Vec3(t.x[i]);
  const BlockMatrix k = t.matrix();
  const Index n = t.x.count();
  Eigen::MatrixXd out(3 * n, 3 * n);
  for (Index a = 0; a < n; ++a)
    for (Index b = 0; b < n; ++b)
      for (int i = 0; i < 9; ++i)
        out(3 * a + i / 3, 3 * b + i % 3) = k.values()[std::size_t(k.slot(a, b)) * 9 + std::size_t(i)];
  return out;
}
Mat3 someShape(double j) {
  Mat3 f;
  f << 1.1, 0.2, -0.1, 0.05, 0.9, 0.3, 0.1, -0.2, 1.2;
  f.row(0) *= j / f.determinant();
  return f;
}
double largestEigenvalue(const Eigen::MatrixXd& k) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues().maxCoeff();
}

/// K' - K = -V b psi_JJ ((dJ_i . dJ_j) Id - dJ_i (x) dJ_j), with psi_JJ = lambda + mu of StableNeoHookean.
TEST(HyperelasticTangents, RegularisationFollowsItsFormula) {
  const std::string law = "materialName=\"StableNeoHookean\" ParameterSet=\"1000 4000\"";
  FieldUnderTest exact(one_cell + law + "/></Node>", tetrahedral);
  FieldUnderTest regular(one_cell + law + " matrixRegularization=\"true\"/></Node>", tetrahedral);
  for (double j : {1.4, 1.01, 0.6, 0.1, -0.5}) {
    const Mat3 f = someShape(j), cof = j * f.inverse().transpose();
    Eigen::Matrix<double, 3, 4> g;
    g << -1, 1, 0, 0, -1, 0, 1, 0, -1, 0, 0, 1;
    const Eigen::Matrix<double, 3, 4> dj = cof * g;
    const double b = std::min(1., std::max(0., 1 - j));
    Eigen::MatrixXd expected(12, 12);
    for (int a = 0; a < 4; ++a)
      for (int c = 0; c < 4; ++c)
        expected.block<3, 3>(3 * a, 3 * c) =
            -b * 5000. / 6 * (dj.col(a).dot(dj.col(c)) * Mat3::Identity() - dj.col(a) * dj.col(c).transpose());
    const Eigen::MatrixXd difference = dense(regular, f) - dense(exact, f);
    EXPECT_LT((difference - expected).norm(), 1e-11 * 5000) << j;
    EXPECT_EQ(difference.norm() > 1, j < 1 && b > 0.05) << j;
  }
}

TEST(HyperelasticTangents, TheProjectedOneIsNeverUnstable) {
  for (const LawCase& law : lawCases()) {
    SCOPED_TRACE(law.name);
    FieldUnderTest exact(one_cell + law.attributes + "/></Node>", tetrahedral);
    FieldUnderTest projected(one_cell + law.attributes + " projectedTangent=\"true\"/></Node>", tetrahedral);
    std::vector<double> volumes{0.5, 0.2};
    if (law.finite) volumes.push_back(-0.3);
    bool unstable = false;
    for (double j : volumes) {
      const Eigen::MatrixXd k = dense(exact, someShape(j)), p = dense(projected, someShape(j));
      unstable = unstable || largestEigenvalue(k) > 1e-6 * k.norm();
      EXPECT_LT(largestEigenvalue(p), 1e-12 * p.norm()) << j;
    }
    EXPECT_TRUE(unstable) << "nothing to project was tested";
    // without compression nothing is unstable
    const Mat3 rest = Mat3::Identity();
    EXPECT_LT((dense(exact, rest) - dense(projected, rest)).norm(), 1e-10 * dense(exact, rest).norm());
  }
}

/// Symmetric, and products, diagonal and matrix agree, in every form on a mesh.
TEST(HyperelasticTangents, ProductsAreOfTheMatrix) {
  for (const LawCase& law : lawCases())
    for (const std::string form : {"matrixRegularization", "projectedTangent"}) {
      SCOPED_TRACE(law.name + " " + form);
      if (form == "matrixRegularization" && law.name == "StVenantKirchhoff") continue;  // it has no J
      FieldUnderTest t(lawScene(law.attributes + " " + form + "=\"true\""), tetrahedral);
      t.deform(0.04);
      for (Index i = 0; i < t.x.count(); ++i) t.x[i] = 0.9 * Vec3(t.x[i]);
      expectMatrixOfProducts(t);
      expectSymmetricProducts(t);
      FieldUnderTest exact(lawScene(law.attributes), tetrahedral);
      copy(t.x, exact.x);
      EXPECT_LT(relativeDifference(t.force(), exact.force()), 1e-14) << "forces are the same";
    }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
