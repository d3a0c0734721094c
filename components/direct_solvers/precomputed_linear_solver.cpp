// SPDX-License-Identifier: LGPL-2.1-or-later
// PrecomputedLinearSolver: factors the first matrix that it gets and solves all later systems with these factors.
//
//   x = A_0^-1 b
//
// It is exact as long as the matrix does not change: constant stiffness, mass and time step. Elsewhere it is the solution of
// another problem, as a fixed approximation of Newton's matrix is: an implicit step with it is still of first order in time, and
// less damped or less stable than with the matrix of the moment. A body that turns has turned away from its matrix; use
// WarpPreconditioner there. A matrix of another pattern is factored anew.
//
// Source: the name is SOFA's, which computes the inverse itself and keeps it in a file.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <PrecomputedLinearSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include <cmath>

#include "components/direct_solvers/cholesky_factor.h"
#include "components/direct_solvers/symmetric_part_factor.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class PrecomputedLinearSolver final : public DirectSolver {
 public:
  bool needsSymmetric() const override { return false; }
  void reset() override {
    first_.forEach([](First& first) { first = {}; });
  }
  void serializeFor(SystemMatrix& matrix, Archive& archive) override {
    First& first = first_.of(matrix);
    archive.list("first_values", first.values);
    if (archive.isReading()) first.factors = nullptr;
  }
  SolveReport solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms) override {
    SolveReport report;
    const double norm_b = norm(b);
    if (!std::isfinite(norm_b)) {
      report.stop = SolveStop::not_finite;
      return report;
    }
    First& first = first_.of(matrix);
    const BlockMatrix& a = matrix.assemble();
    if (first.values.size() != a.values().size()) {
      first.values.assign(a.values().begin(), a.values().end());
      first.factors = nullptr;
    }
    if (norm_b == 0) {
      clear(x);
      report.stop = SolveStop::zero_right_side;
      return report;
    }
    report.iterations = 1;
    report.factored = first.factors == nullptr;
    if (!first.factors) first.factors = factorValues(matrix, first.values, terms.stop);
    if (!first.factors) {
      report.stop = terms.stop.isStopAsked() ? SolveStop::stopped : SolveStop::not_definite;
      return report;
    }
    first.factors->apply(b, x);
    if (!std::isfinite(norm(x))) {  // the first matrix was not
      clear(x);
      report.stop = SolveStop::not_finite;
    }
    return report;
  }

 protected:
  std::unique_ptr<Factorisation> makeFactorisation(bool symmetric) const override {
    if (symmetric) return CholeskyFactor::make();
    return std::make_unique<SymmetricPartFactor>();
  }

 private:
  struct First {
    std::vector<double> values;  ///< of the first matrix, shape (blocks, 9); empty before it
    Factorisation* factors = nullptr;
  };
  PerMatrix<First> first_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(precomputed_linear_solver) {
  factory.add<stroma::PrecomputedLinearSolver>("PrecomputedLinearSolver", "direct solver: the factors of the first matrix for all");
}
