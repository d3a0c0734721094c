// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tests/support/dense_algebra.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace stroma::test {

Eigen::VectorXd denseSolution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) { return a.partialPivLu().solve(b); }

Eigen::VectorXd leastSquares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.completeOrthogonalDecomposition().solve(b);
}

Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& columns) { return columns.householderQr().householderQ(); }

Spectrum spectrum(const Eigen::MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& a) { return spectrum(a).values; }

Mat3 kabschRotation(const Mat3& a) {
  const Eigen::JacobiSVD<Mat3, Eigen::FullPivHouseholderQRPreconditioner> svd(
      a, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vec3 sign(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace stroma::test
