// SPDX-License-Identifier: LGPL-2.1-or-later
// Eigen by another name: of equal functions a linker keeps the first ones, which are those of the tests, without optimisation.
#define Eigen EigenOptimised  // NOLINT: the name of a library, whose headers have no other way to get one of their own
#include "tests/support/optimised_algebra.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace stroma::test::optimised {
namespace {

using Matrix = Eigen::Map<const Eigen::MatrixXd>;
using Column = Eigen::Map<const Eigen::VectorXd>;
using Result = Eigen::Map<Eigen::MatrixXd>;

}  // namespace

void solve(long size, const double* a, const double* b, double* x) {
  Result(x, size, 1) = Matrix(a, size, size).partialPivLu().solve(Column(b, size));
}

void leastSquares(long rows, long columns, const double* a, const double* b, double* x) {
  Result(x, columns, 1) = Matrix(a, rows, columns).completeOrthogonalDecomposition().solve(Column(b, rows));
}

void orthonormal(long size, const double* columns, double* out) {
  Result(out, size, size) = Matrix(columns, size, size).householderQr().householderQ();
}

void spectrum(long size, const double* a, double* values, double* vectors) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(Matrix(a, size, size),
                                                              vectors ? Eigen::ComputeEigenvectors : Eigen::EigenvaluesOnly);
  Result(values, size, 1) = solver.eigenvalues();
  if (vectors) Result(vectors, size, size) = solver.eigenvectors();
}

void kabschRotation(const double* a, double* rotation) {
  using Mat3 = Eigen::Matrix3d;
  const Eigen::JacobiSVD<Mat3, Eigen::FullPivHouseholderQRPreconditioner> svd(
      Eigen::Map<const Mat3>(a), Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d sign(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  Eigen::Map<Mat3>{rotation} = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace stroma::test::optimised
