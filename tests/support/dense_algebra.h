// SPDX-License-Identifier: LGPL-2.1-or-later
// Eigen's factorisations for tests, compiled once: each takes the compiler seconds in every file that names it.
#pragma once
#include <Eigen/Core>

#include "framework/scene/types.h"

namespace stroma::test {

/// x with A x = b for a square and regular A.
Eigen::VectorXd denseSolution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
/// The shortest x among those with the least |A x - b|.
Eigen::VectorXd leastSquares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
/// Orthonormal columns that span those of a square matrix.
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& columns);

/// Of a symmetric matrix: eigenvalues ascending, eigenvectors as columns.
struct Spectrum {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
Spectrum spectrum(const Eigen::MatrixXd& a);
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& a);

/// The rotation R with the largest tr(R^T A) (Kabsch).
Mat3 kabschRotation(const Mat3& a);

}  // namespace stroma::test
