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
    if (archive.isReading()) first.factors.reset();
  }
  SolveReport solveAll(SystemMatrix& matrix, std::span<const ConstRows> b, std::span<const Rows> x, const SolveTerms& terms) override {
    SolveReport report{.stop = SolveStop::zero_right_side};
    double size = 0;  // not finite where one is not
    for (const ConstRows& each : b) size += norm(each);
    if (!std::isfinite(size)) {
      report.stop = SolveStop::not_finite;
      return report;
    }
    First& first = first_.of(matrix);
    const BlockMatrix& a = matrix.assemble();
    if (first.values.size() != a.values().size()) {
      first.values.assign(a.values().begin(), a.values().end());
      first.factors.reset();
    }
    if (size == 0) {
      for (const Rows& each : x) clear(each);
      return report;
    }
    report = {.iterations = int(b.size()), .factored = !first.factors};
    if (!first.factors && !factorFirst(matrix, first, terms.stop)) {
      report.stop = terms.stop.isStopAsked() ? SolveStop::stopped : SolveStop::not_definite;
      return report;
    }
    first.factors->applyAll(b, x);
    for (const Rows& each : x)
      if (!std::isfinite(norm(each))) clear(each), report.stop = SolveStop::not_finite;  // the first matrix was not
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
    std::unique_ptr<Factorisation> factors;
  };
  bool factorFirst(SystemMatrix& matrix, First& first, StopToken stop) const {
    BlockMatrix former = matrix.pattern();
    if (former.values().size() != first.values.size()) return false;
    former.values() = first.values;
    auto factors = makeFactorisation(matrix.symmetric());
    Index row = -1;
    if (!factors->analyse(former, stop)) return false;
    factors->load(former);
    if (factors->factor(row, stop) != SolveStop::converged) return false;
    first.factors = std::move(factors);
    return true;
  }
  PerMatrix<First> first_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(precomputed_linear_solver) {
  factory.add<stroma::PrecomputedLinearSolver>("PrecomputedLinearSolver", "direct solver: the factors of the first matrix for all");
}
