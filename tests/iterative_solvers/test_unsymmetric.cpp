// SPDX-License-Identifier: LGPL-2.1-or-later
// Matrices that are not symmetric: GMRES against Eigen's factors, and what the automatic solver makes of them in a large body.
#include <gtest/gtest.h>

#include "components/iterative_solvers/gmres.h"
#include "framework/algebra/direct_solver.h"
#include "tests/support/dense_algebra.h"
#include "tests/support/elastic_block.h"
#include "tests/support/solver_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Adds W above the diagonal and -W^T below it, W random with entries up to `share` of the largest in the block; rows that
/// are held stay as they are.
void addSkewPart(StoredMatrix& matrix, double share) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> number(-share, share);
  BlockMatrix& a = matrix.values;
  using Block = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
  for (Index row = 0; row < a.rows(); ++row)
    for (Index s = a.rowStart()[row]; s < a.rowStart()[row + 1]; ++s) {
      const Index column = a.columns()[s];
      if (column <= row) continue;
      Block upper(a.values().data() + 9 * s), lower(a.values().data() + 9 * a.slot(column, row));
      const double size = upper.cwiseAbs().maxCoeff();
      Mat3 w;
      for (int k = 0; k < 9; ++k) w.data()[k] = size * number(generator);
      upper += w;
      lower -= w.transpose();
    }
  matrix.is_symmetric = false;
}

/// Without a preconditioner 120 unknowns take more products than one space holds.
TEST(Gmres, FindsTheSolutionOfFactorsAlsoAfterRestarts) {
  StoredMatrix matrix = randomMatrix(40, 4, 0.5, 3);
  addSkewPart(matrix, 0.3);
  Vector b(matrix.rows()), x(matrix.rows());
  for (Index i = 0; i < b.count(); ++i) b[i] = Vec3(1, i % 3, -i % 5);
  Eigen::VectorXd right(3 * b.count());
  for (Index i = 0; i < b.count(); ++i) right.segment<3>(3 * i) = b[i];
  const Eigen::VectorXd exact = denseSolution(matrix.dense(), right);
  gmres::Space space;
  space.resize(b.count());
  std::vector<double> residuals;
  const auto product = [&](ConstRows p, Rows out) { matrix.multiply(p, out); };
  const auto none = [](ConstRows r, Rows z) { copy(r, z); };
  const auto note = [&](double residual) { residuals.push_back(residual); };
  const SolveReport report = gmres::solve(product, none, note, {5000, 1e-11 * norm(b), {}}, b, space, x);
  EXPECT_EQ(report.stop, SolveStop::converged) << describe(report.stop);
  EXPECT_GT(report.iterations, int(gmres::restart)) << "one space is enough: restarts are not tested";
  EXPECT_EQ(int(residuals.size()), report.iterations);
  for (std::size_t k = 1; k < gmres::restart; ++k) EXPECT_LE(residuals[k], residuals[k - 1] * (1 + 1e-12)) << k;
  for (Index i = 0; i < b.count(); ++i)
    for (int l = 0; l < 3; ++l) EXPECT_NEAR(x[i][l], exact[3 * i + l], 1e-8 * exact.cwiseAbs().maxCoeff());

  Vector few(b.count());
  const SolveReport cut = gmres::solve(product, none, note, {5, 0, {}}, b, space, few);
  EXPECT_EQ(cut.stop, SolveStop::iteration_limit);
  EXPECT_EQ(cut.iterations, 5);
}

/// 4,096 nodes are solved by products, with the solution that the matrix has; few are factored as before.
TEST(AutomaticLinearSolver, SolvesALargeUnsymmetricMatrixByProducts) {
  for (const Index cells : {5, 15}) {
    ElasticBlock block;
    block.cells = {cells, cells, cells};
    StoredMatrix matrix = block.matrix();
    for (Index k = 0; k <= cells; ++k)
      for (Index j = 0; j <= cells; ++j)
        for (Index i = 0; i <= cells; ++i) matrix.nodes.push_back(Vec3(i, j, k));
    addSkewPart(matrix, 0.2);
    Vector b(matrix.rows()), x, r(matrix.rows());
    for (Index i = (cells + 1) * (cells + 1); i < b.count(); ++i) b[i] = Vec3(0.1, 0, -1);
    SolverInScene solver("<AutomaticLinearSolver/><SparseLDLSolver name='factors'/>");
    const SolveReport report = solver.solve(matrix, b, x);
    EXPECT_EQ(report.stop, SolveStop::converged) << describe(report.stop);
    matrix.multiply(x, r);
    EXPECT_LE(distance(r, b), 1.2e-8 * norm(b));
    const std::string choice = solver.solver->data().find("choice")->print();
    std::vector<DirectSolver*> factors;
    solver.scene.root->collect(factors);
    const std::string factorisations = factors.at(0)->data().find("factorisations")->print();
    const bool is_large = cells == 15;
    EXPECT_NE(choice.find(is_large ? "GMRES with multigrid: 4096 nodes" : "factors: 216 nodes are few"), std::string::npos)
        << choice;
    EXPECT_EQ(factorisations, is_large ? "0" : "1");
    if (is_large) EXPECT_LT(report.iterations, 60);
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
