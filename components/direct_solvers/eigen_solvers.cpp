// SPDX-License-Identifier: LGPL-2.1-or-later
// EigenSimplicialLDLT, EigenSimplicialLLT, EigenSparseLU, EigenSparseQR (and by SOFA's other names SparseCholeskySolver
// and SparseLUSolver): direct solvers, A x = b by the factorisation in the name, as Eigen computes it.
//
//   EigenSimplicialLLT    P A P^T = L L^T, column by column; A symmetric and positive definite, else it says so
//   EigenSimplicialLDLT   P A P^T = L D L^T without pivoting: also for many indefinite symmetric matrices, but a small
//                         pivot can spoil all digits; the residual shows it, and the report then says breakdown
//   EigenSparseLU         P A Q = L U with partial pivoting: any regular matrix, symmetric or not
//   EigenSparseQR         A Q = Q_h R by Householder reflections, columns in COLAMD's order: a rank below full is
//                         found and reported; slow and large
//   CholeskySolver        dense L L^T, SVDLinearSolver: dense singular value decomposition; both for small systems.
//                         SVDLinearSolver leaves out singular values below minSingularValue times the largest and so
//                         gives the shortest least-squares solution of a singular system.
//
// The pattern is ordered (AMD for the first two, COLAMD for the next two) and analysed once; numbers are factored again
// only when the matrix may have changed. The residual of each solve is measured, and one step of iterative refinement
// made when it is above 1e-10 |b|. SparseLDLSolver is many times as fast on meshes of more than a few hundred nodes.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <EigenSimplicialLDLT/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#include <Eigen/SparseQR>
#include <cmath>
#include <type_traits>

#include "components/direct_solvers/sparse_copy.h"
#include "framework/algebra/direct_solver.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

using Sparse = SparseCopy::Matrix;
using LLT = Eigen::SimplicialLLT<Sparse>;
using LDLT = Eigen::SimplicialLDLT<Sparse>;
using LU = Eigen::SparseLU<Sparse>;
using QR = Eigen::SparseQR<Sparse, Eigen::COLAMDOrdering<int>>;

template <class Factorisation>
class EigenSparseSolver final : public DirectSolver {
 public:
  static constexpr bool is_symmetric = std::is_same_v<Factorisation, LLT> || std::is_same_v<Factorisation, LDLT>;
  bool needsSymmetric() const override { return is_symmetric; }

  void applyFactors(ConstRows b, Rows x) override {
    gather(b, right_);
    solution_ = factorisation_.solve(right_);
    scatter(solution_, x);
  }
  /// At a nanosecond for each multiply-add; the factor's entries are counted as ten times those of the matrix.
  Cost cost() const override {
    const double entries = 10. * double(copy_.matrix.nonZeros()), rows = double(copy_.matrix.rows());
    return {1e-9 * entries * entries / rows, 2e-9 * entries};
  }

 protected:
  void analyse(const BlockMatrix& matrix, bool) override {
    copy_.layOut(matrix);
    factorisation_.analyzePattern(copy_.matrix);
  }
  SolveStop factorValues(const BlockMatrix& matrix, Index&) override {
    copy_.fill(matrix);
    factorisation_.factorize(copy_.matrix);
    if (factorisation_.info() != Eigen::Success)
      return std::is_same_v<Factorisation, LLT> ? SolveStop::not_definite : SolveStop::breakdown;
    if constexpr (std::is_same_v<Factorisation, QR>)
      if (factorisation_.rank() < copy_.matrix.cols()) return SolveStop::breakdown;
    return SolveStop::converged;
  }

 private:
  SparseCopy copy_;
  Factorisation factorisation_;
  Eigen::VectorXd right_, solution_;
};

/// The whole matrix with its zeros: for small systems.
class DenseSolver : public DirectSolver {
 public:
  bool needsSymmetric() const override { return false; }
  void init() override {}
  Cost cost() const override {
    const double n = double(dense_.rows());
    return {1e-10 * n * n * n, 1e-9 * n * n};
  }

 protected:
  /// More unknowns than this need more memory than a desk has.
  static constexpr Index most_rows = 4000;
  void analyse(const BlockMatrix& matrix, bool) override {
    if (matrix.rows() > most_rows)
      throw ComponentError(std::to_string(matrix.rows()) + " nodes are too many for a dense matrix",
                           "at most " + std::to_string(most_rows) + " nodes", "SparseLDLSolver");
    dense_.setZero(3 * matrix.rows(), 3 * matrix.rows());
  }
  void fill(const BlockMatrix& matrix) {
    for (Index i = 0; i < matrix.rows(); ++i)
      for (Index s = matrix.rowStart()[i]; s < matrix.rowStart()[i + 1]; ++s)
        dense_.block<3, 3>(3 * i, 3 * matrix.columns()[s]) =
            Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix.values().data() + 9 * std::size_t(s));
  }
  Eigen::MatrixXd dense_;
  Eigen::VectorXd right_, solution_;
};

class CholeskySolver final : public DenseSolver {
 public:
  bool needsSymmetric() const override { return true; }
  void applyFactors(ConstRows b, Rows x) override {
    gather(b, solution_);
    llt_.solveInPlace(solution_);
    scatter(solution_, x);
  }

 private:
  SolveStop factorValues(const BlockMatrix& matrix, Index&) override {
    fill(matrix);
    llt_.compute(dense_);
    return llt_.info() == Eigen::Success ? SolveStop::converged : SolveStop::not_definite;
  }
  Eigen::LLT<Eigen::MatrixXd> llt_;
};

class SVDLinearSolver final : public DenseSolver {
 public:
  void declare(DataTable& table) override {
    DenseSolver::declare(table);
    table.add("minSingularValue", smallest_)
        .help("singular values below this times the largest count as zero")
        .unit("-")
        .min(0)
        .max(1);
    table.add("conditionNumber", condition_).help("the largest over the smallest singular value").unit("-").output();
    table.addVisualOnly("verbose");
  }
  void applyFactors(ConstRows b, Rows x) override {
    gather(b, right_);
    solution_ = svd_.solve(right_);
    scatter(solution_, x);
  }
  /// The least-squares solution is what the name promises: its residual may be as large as b.
  SolveReport solve(SystemMatrix& matrix, ConstRows b, Rows x) override {
    SolveReport report = DirectSolver::solve(matrix, b, x);
    if (report.stop == SolveStop::breakdown) applyFactors(b, x);
    return report;
  }

 private:
  SolveStop factorValues(const BlockMatrix& matrix, Index&) override {
    fill(matrix);
    svd_.setThreshold(smallest_);
    svd_.compute(dense_, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const auto& values = svd_.singularValues();
    condition_ = values[0] / values[values.size() - 1];
    return svd_.info() == Eigen::Success ? SolveStop::converged : SolveStop::breakdown;
  }
  double smallest_ = 1e-12, condition_ = 0;
  Eigen::BDCSVD<Eigen::MatrixXd> svd_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(eigen_solvers) {
  using namespace stroma;
  factory.add<EigenSparseSolver<LLT>>("EigenSimplicialLLT", "direct solver: sparse L L^T, positive definite matrices");
  factory.add<EigenSparseSolver<LLT>>("SparseCholeskySolver", "EigenSimplicialLLT by another of SOFA's names");
  factory.add<EigenSparseSolver<LDLT>>("EigenSimplicialLDLT", "direct solver: sparse L D L^T, symmetric matrices");
  factory.add<EigenSparseSolver<LU>>("EigenSparseLU", "direct solver: sparse L U with pivoting, any regular matrix");
  factory.add<EigenSparseSolver<LU>>("SparseLUSolver", "EigenSparseLU by another of SOFA's names");
  factory.add<EigenSparseSolver<QR>>("EigenSparseQR", "direct solver: sparse Q R, finds a rank below full");
  factory.add<CholeskySolver>("CholeskySolver", "direct solver: dense L L^T, small positive definite systems");
  factory.add<SVDLinearSolver>("SVDLinearSolver", "direct solver: dense singular values, small systems of any rank");
}
