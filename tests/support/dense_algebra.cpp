// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tests/support/dense_algebra.h"

#include <stdexcept>

#include "tests/support/optimised_algebra.h"

namespace stroma::test {
namespace {

void requireSquare(const Eigen::MatrixXd& a) {
  if (a.rows() != a.cols()) throw std::runtime_error("the matrix is not square");
}

}  // namespace

Eigen::VectorXd denseSolution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  requireSquare(a);
  if (a.rows() != b.size()) throw std::runtime_error("the right side has another size than the matrix");
  Eigen::VectorXd x(b.size());
  optimised::solve(a.rows(), a.data(), b.data(), x.data());
  return x;
}

Eigen::VectorXd leastSquares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  if (a.rows() != b.size()) throw std::runtime_error("the right side has another size than the matrix");
  Eigen::VectorXd x(a.cols());
  optimised::leastSquares(a.rows(), a.cols(), a.data(), b.data(), x.data());
  return x;
}

Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& columns) {
  requireSquare(columns);
  Eigen::MatrixXd out(columns.rows(), columns.cols());
  optimised::orthonormal(columns.rows(), columns.data(), out.data());
  return out;
}

Spectrum spectrum(const Eigen::MatrixXd& a) {
  requireSquare(a);
  Spectrum found{Eigen::VectorXd(a.rows()), Eigen::MatrixXd(a.rows(), a.rows())};
  optimised::spectrum(a.rows(), a.data(), found.values.data(), found.vectors.data());
  return found;
}

Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& a) {
  requireSquare(a);
  Eigen::VectorXd values(a.rows());
  optimised::spectrum(a.rows(), a.data(), values.data(), nullptr);
  return values;
}

Mat3 kabschRotation(const Mat3& a) {
  Mat3 rotation;
  optimised::kabschRotation(a.data(), rotation.data());
  return rotation;
}

}  // namespace stroma::test
