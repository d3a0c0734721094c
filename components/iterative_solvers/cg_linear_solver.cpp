// SPDX-License-Identifier: LGPL-2.1-or-later
// CGLinearSolver: conjugate gradients for A x = b with A symmetric and positive definite (Hestenes and Stiefel 1952).
//
//   q = A p,  alpha = r.z / p.q,  x += alpha p,  r -= alpha q,  z = D^-1 r,  beta = r.z / (r.z)_before,  p = z + beta p
//
// z = r without a preconditioner; with `preconditioner="block_jacobi"`, D holds the 3x3 diagonal blocks of A. The
// product A p is matrix-free (each force field multiplies from its elements) or uses the assembled matrix: `template`
// GraphScattered forces the first, CompressedRowSparseMatrix the second, and auto takes the cheaper one for
// `iterations` products by the cost that the force fields state.
//
// It stops when |r| <= tolerance |b|; after `iterations` products (an ordinary end in interactive scenes: the report
// says so and gives the residual reached); when b = 0; when a number is not finite; and when the matrix shows itself to
// be singular or not definite, |p.A p| <= threshold^2 |p| |A p| or p.A p < 0: x then keeps the last iterate, the best
// one in the energy of A. SOFA compares p.A p itself with `threshold`, a test whose outcome depends on the units of the
// scene and which can stop a well-posed solve at its first iteration (nothing then moves). Here it is the cosine
// between p and A p, which no units enter; with the default it passes for every matrix of condition number below 4e20.
// All other iterates are those of SOFA's solver.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-9" preconditioner="block_jacobi"/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include <cmath>

#include "components/iterative_solvers/conjugate_gradients.h"
#include "components/iterative_solvers/krylov_solver.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

enum class Preconditioner { none, block_jacobi };

class CGLinearSolver final : public KrylovSolver {
 public:
  void declare(DataTable& table) override;
  SolveReport solve(SystemMatrix& matrix, ConstRows b, Rows x) override;
  void reset() override { previous_.resize(previous_.count()); }

 private:
  void resize(Index rows) override;
  void prepare(const SystemMatrix& matrix);
  SolveReport iterate(const SystemMatrix& matrix, Rows x, double residual);

  double threshold_ = 1e-5;
  bool warm_start_ = false;
  Preconditioner preconditioner_ = Preconditioner::none;
  Vector r_, p_, q_, z_, previous_;
  std::vector<double> blocks_;
  cg::BlockJacobi jacobi_;
  MatrixKey jacobi_key_;
  Index bad_block_ = -1;
};

void CGLinearSolver::declare(DataTable& table) {
  KrylovSolver::declare(table);
  table.add("threshold", threshold_)
      .help("stop as broken down when |p.A p| <= threshold^2 |p| |A p| (relative, unlike SOFA's)")
      .unit("-")
      .min(0)
      .max(1e-2);
  table.add("warmStart", warm_start_).help("start from the solution of the previous solve");
  table.addChoice("preconditioner", preconditioner_, {"none", "block_jacobi"})
      .help("none reproduces SOFA's iterates; block_jacobi divides by the 3x3 diagonal blocks");
}

void CGLinearSolver::resize(Index rows) {
  for (Vector* vector : {&r_, &p_, &q_}) vector->resize(rows);
  if (preconditioner_ != Preconditioner::none) z_.resize(rows);
  if (warm_start_) previous_.resize(rows);
  jacobi_key_ = {};
}

void CGLinearSolver::prepare(const SystemMatrix& matrix) {
  if (preconditioner_ == Preconditioner::none || jacobi_key_ == matrix.key()) return;
  matrix.diagonalBlocks(blocks_);
  bad_block_ = jacobi_.factor(blocks_);
  jacobi_key_ = matrix.key();
}

SolveReport CGLinearSolver::iterate(const SystemMatrix& matrix, Rows x, double residual) {
  const bool precondition = preconditioner_ != Preconditioner::none;
  SolveReport report;
  double rho = precondition ? jacobi_.apply(r_, z_) : residual;
  copy(precondition ? z_.rows() : r_.rows(), p_);
  const double enough = target();
  for (;;) {
    product(matrix, p_, q_);
    ++report.iterations;
    const cg::Curvature curve = cg::curvature(p_, q_);
    if (!std::isfinite(curve.pq)) {
      report.stop = SolveStop::not_finite;
      break;
    }
    if (curve.pq <= threshold_ * threshold_ * std::sqrt(curve.pp) * std::sqrt(curve.qq)) {
      const bool negative = curve.pq < -1e-14 * std::sqrt(curve.pp) * std::sqrt(curve.qq);
      report.stop = negative ? SolveStop::not_definite : SolveStop::breakdown;
      break;
    }
    const double alpha = rho / curve.pq;
    residual = cg::reduceResidual(alpha, q_, r_);
    record(std::sqrt(residual) / norm_b_);
    if (!std::isfinite(residual)) {
      report.stop = SolveStop::not_finite;
      break;
    }
    const bool converged = std::sqrt(residual) <= enough;
    if (converged || report.iterations == iterations_) {
      axpy(alpha, p_, x);
      report.stop = converged ? SolveStop::converged : SolveStop::iteration_limit;
      break;
    }
    const double rho_before = rho;
    rho = precondition ? jacobi_.apply(r_, z_) : residual;
    cg::advance(alpha, rho / rho_before, precondition ? z_.rows() : r_.rows(), p_, x);
  }
  report.relative_residual = std::sqrt(residual) / norm_b_;
  return report;
}

SolveReport CGLinearSolver::solve(SystemMatrix& matrix, ConstRows b, Rows x) {
  SolveReport report;
  if (!begin(matrix, b, x, report)) return report;
  prepare(matrix);
  if (bad_block_ >= 0) {
    report.stop = SolveStop::not_definite;
    report.row = bad_block_;
    report.relative_residual = 1;
    return report;
  }
  if (warm_start_) copy(previous_, x);
  const double residual = KrylovSolver::residual(matrix, b, x, r_, q_);
  if (std::sqrt(residual) <= target()) {
    report.relative_residual = std::sqrt(residual) / norm_b_;
  } else {
    report = iterate(matrix, x, residual);
  }
  if (warm_start_ && report.stop != SolveStop::not_finite) copy(x, previous_);
  return report;
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(cg_linear_solver) {
  factory.add<stroma::CGLinearSolver>("CGLinearSolver", "conjugate gradients, matrix-free or assembled");
}
