// SPDX-License-Identifier: LGPL-2.1-or-later
// SVDLinearSolver: a direct solver by the singular values of the dense matrix, for small systems of any rank. Singular
// values below minSingularValue times the largest are left out, which gives the shortest least-squares solution of a
// singular system.
//
// A body that is far lighter than others has singular values as small as those of a singular matrix. So S A S is taken apart, and
// x = S (S A S)^+ S b. S is 1 but for rows and columns whose largest number is below the root of minSingularValue times the
// largest of all: there it brings that number to the size of the others, by a power of two.
//
// The numbers are factored again only when the matrix may have changed. The residual of each solve is measured, and the
// solve refined where it is above 1e-10 |b|.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <SVDLinearSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include <algorithm>
#include <cmath>
#include <vector>

#include "components/direct_solvers/dense_factor.h"
#include "components/direct_solvers/interruptible_factor.h"
#include "framework/scene/factory.h"

/// LAPACK's divide and conquer: A = U diag(s) V^T, all matrices by columns; the tuned library is faster and compiles in no
/// time, where a template of the decomposition takes the compiler most of a minute.
extern "C" void dgesdd_(const char* job, const int* rows, const int* columns, double* a, const int* lda, double* s,
                        double* u, const int* ldu, double* vt, const int* ldvt, double* work, const int* lwork,
                        int* iwork, int* info);

namespace stroma {
namespace {

class SingularValues final : public DenseFactor {
 public:
  explicit SingularValues(double smallest) : smallest_(smallest) {}
  SolveStop factor(Index&, StopToken) override {
    if (!dense_.allFinite()) return SolveStop::breakdown;
    const int n = int(dense_.rows());
    scaleLightRows();
    values_.resize(n);
    left_.resize(n, n);
    right_transposed_.resize(n, n);
    std::vector<int> integers(8 * std::size_t(n));
    double best = 0;
    int info = 0;
    const int ask = -1;  // first for the size of the work space
    decompose(n, &best, ask, integers.data(), info);
    std::vector<double> work(std::max<std::size_t>(1, std::size_t(best)));
    decompose(n, work.data(), int(work.size()), integers.data(), info);
    if (info != 0) return SolveStop::breakdown;
    rank_ = 0;
    while (rank_ < n && values_[rank_] > smallest_ * values_[0]) ++rank_;
    return SolveStop::converged;
  }
  void apply(ConstRows b, Rows x) override {
    gather(b, all_);
    all_.array() *= scale_.array();
    part_.noalias() = left_.leftCols(rank_).transpose() * all_;
    part_.array() /= values_.head(rank_).array();
    all_.noalias() = right_transposed_.topRows(rank_).transpose() * part_;
    all_.array() *= scale_.array();
    scatter(all_, x);
  }
  double condition() const { return values_[0] / values_[values_.size() - 1]; }

 private:
  void scaleLightRows() {
    const Eigen::VectorXd size =
        dense_.cwiseAbs().rowwise().maxCoeff().cwiseMax(dense_.cwiseAbs().colwise().maxCoeff().transpose());
    const double most = size.maxCoeff();
    scale_.setOnes(size.size());
    for (Eigen::Index i = 0; i < size.size(); ++i)
      if (size[i] > 0 && size[i] < std::sqrt(smallest_) * most) scale_[i] = std::ldexp(1.0, std::ilogb(most / size[i]) / 2);
    dense_ = scale_.asDiagonal() * dense_ * scale_.asDiagonal();
  }
  /// Overwrites dense_ unless only the size of `work` is asked for.
  void decompose(int n, double* work, int size, int* integers, int& info) {
    dgesdd_("A", &n, &n, dense_.data(), &n, values_.data(), left_.data(), &n, right_transposed_.data(), &n, work, &size,
            integers, &info);
  }

  double smallest_;
  int rank_ = 0;
  Eigen::VectorXd values_, all_, part_;  ///< singular values, falling; of all unknowns; of those in the rank
  Eigen::VectorXd scale_;                ///< S, shape (unknowns)
  Eigen::MatrixXd left_, right_transposed_;
};

class SVDLinearSolver final : public DirectSolver {
 public:
  bool needsSymmetric() const override { return false; }
  Index mostRows() const override { return SingularValues::most_rows; }
  void declare(DataTable& table) override {
    DirectSolver::declare(table);
    table.add("minSingularValue", smallest_)
        .help("singular values below this times the largest count as zero")
        .unit("-")
        .min(0)
        .max(1);
    table.add("conditionNumber", condition_)
        .help("the largest over the smallest singular value of S A S, of the matrix that was factored last")
        .unit("-")
        .output();
    table.addVisualOnly("verbose");
  }

 private:
  std::unique_ptr<Factorisation> makeFactorisation(bool) const override {
    return std::make_unique<InterruptibleFactor<SingularValues>>(
        [smallest = smallest_] { return std::make_unique<SingularValues>(smallest); });
  }
  void noteFactored(const Factorisation& factors) override {
    condition_ = static_cast<const InterruptibleFactor<SingularValues>&>(factors).inner().condition();
  }
  /// That is what the name promises: the residual may be as large as b.
  bool givesLeastSquares() const override { return true; }

  double smallest_ = 1e-12, condition_ = 0;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(svd_linear_solver) {
  factory.add<stroma::SVDLinearSolver>("SVDLinearSolver",
                                       "direct solver: dense singular values, small systems of any rank");
}
