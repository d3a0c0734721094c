// SPDX-License-Identifier: LGPL-2.1-or-later
// PCGLinearSolver: preconditioned conjugate gradients for A x = b with A symmetric and positive definite (Hestenes and
// Stiefel 1952; in this form Shewchuk 1994, after whom SOFA called it before).
//
//   q = A p,  alpha = r.z / p.q,  x += alpha p,  r -= alpha q,  z = B r,  beta = r.z / (r.z)_before,  p = z + beta p
//
// B ~ A^-1 is the preconditioner, a word or a link to a component:
//
//   auto                 the default: block_jacobi, and multigrid from the solve on before which that would have cost less by
//                        what a hierarchy costs. Both are counted in iterations, so that each run does the same; it goes
//                        back where multigrid does not help. Bodies below 2,500 nodes, and scenes that write `iterations`
//                        or template GraphScattered, stay with block_jacobi. `choice` says what preconditions, and why
//   none                 plain conjugate gradients
//   jacobi               the diagonal
//   block_jacobi         the 3x3 diagonal blocks of the nodes; costs next to nothing
//   ssor                 a forward and a backward sweep (omega = 1): about half the iterations, each twice the price
//   incomplete_cholesky  factors without fill, by blocks: about a third of the iterations; where a pivot fails, a
//                        multiple of the diagonal is added, which the attribute `shift` tells
//   warped               the factors that a direct solver of the same node made of a former matrix, turned with the
//                        body (see WarpPreconditioner): few iterations whatever the mesh or Poisson's ratio. They outlive
//                        pairs in contact that come and go
//   multigrid            a V-cycle over groups of nodes (see MultigridPreconditioner): few iterations whatever the size,
//                        without factors, which take memory and time beyond some 20,000 nodes
//
// It stops when |r| <= tolerance |b|, after `iterations` products, when b = 0, when a number is not finite, and when
// the matrix shows itself to be singular or not definite; x then keeps the last iterate. Where |r| of the recurrence is
// small enough, b - A x itself is computed, and the iteration goes on from there if round-off kept it larger.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <PCGLinearSolver iterations="100" tolerance="1e-9" preconditioner="incomplete_cholesky"/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include "components/iterative_solvers/automatic_inverse.h"
#include "components/iterative_solvers/incomplete_cholesky.h"
#include "components/iterative_solvers/krylov_solver.h"
#include "components/iterative_solvers/preconditioned_conjugate_gradients.h"
#include "components/iterative_solvers/warped_factor.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class PCGLinearSolver final : public KrylovSolver, public FactorUser {
 public:
  PCGLinearSolver() {
    link_.words = {"auto", "none", "jacobi", "block_jacobi", "ssor", "incomplete_cholesky", "warped", "multigrid"};
    link_.path = "auto";
  }
  void declare(DataTable& table) override;
  void init() override;
  void reset() override {
    kept_.forEach([](Kept& kept) {
      if (kept.inverse) kept.inverse->reset();
    });
  }
  void serializeFor(SystemMatrix& matrix, Archive& archive) override {
    if (ApproximateInverse* inverse = keptFor(matrix).inverse.get()) inverse->serialize(matrix, archive);
  }
  void keepFor(SystemMatrix& matrix) override {
    if (ApproximateInverse* inverse = keptFor(matrix).inverse.get()) inverse->keep(matrix);
  }
  void takeBackFor(SystemMatrix& matrix) override {
    if (ApproximateInverse* inverse = keptFor(matrix).inverse.get()) inverse->takeBack(matrix);
  }
  SolveReport solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms) override;
  SolveReport iterate(SystemMatrix& matrix, ConstRows b, Rows x, ApproximateInverse* inverse, cg::Directions& work, int most);
  Index mostRows() const override;
  bool usesFactorOf(const Component&) const override { return use_ && link_.path == "warped"; }

 private:
  /// For each matrix: work space and preconditioner.
  struct Kept {
    std::unique_ptr<ApproximateInverse> inverse;  ///< null: none
    cg::Directions work;
  };
  std::unique_ptr<ApproximateInverse> makeInverse() const;
  /// Of preconditioner auto; the text is made when it changes.
  void tellChoice(const AutomaticInverse& inverse);
  Kept& keptFor(const SystemMatrix& matrix) {
    return kept_.of(matrix, [this] { return std::make_unique<Kept>(Kept{makeInverse(), {}}); });
  }

  bool use_ = true, may_change_ = true;
  std::string choice_;
  int changes_ = 0;  ///< of the matrix solved last
  Link<Preconditioner> link_{"preconditioner"};
  Link<DirectSolver> factors_{"direct solver"};
  double shift_ = 0;
  int factorisations_ = 0;

  DirectSolver* factor_source_ = nullptr;  ///< of warped
  PerMatrix<Kept> kept_;
};

void PCGLinearSolver::declare(DataTable& table) {
  KrylovSolver::declare(table);
  table.add("use_precond", use_).help("false: plain conjugate gradients, whatever the preconditioner");
  table.addLink("preconditioner", link_)
      .alias("preconditioners")
      .help(
          "auto (the default), none, jacobi, block_jacobi, ssor, incomplete_cholesky, warped, multigrid, or a link to "
          "a preconditioner");
  table.add("choice", choice_).help("of preconditioner auto: what preconditions, and why").output();
  table.add("changes", changes_).help("how often preconditioner auto changed its choice").unit("-").output();
  table.add("shift", shift_)
      .help("multiple of the diagonal that incomplete_cholesky had to add in the last solve")
      .unit("-")
      .output();
  table.add("factorisations", factorisations_)
      .help("how often warped factored so far, for all matrices")
      .unit("-")
      .output();
}

void PCGLinearSolver::init() {
  if (use_ && link_.path == "multigrid") expected_iterations_ = 15;
  KrylovSolver::init();
  if (use_) link_.get();  // ready before the first solve
  may_change_ = !data().find("iterations")->isSet() && data().find("template")->print() != "GraphScattered";
  if (use_ && link_.path == "auto") choice_ = AutomaticInverse(may_change_).choice();
  if (use_ && link_.path == "warped") factor_source_ = &factorSource(*this, factors_);
}

Index PCGLinearSolver::mostRows() const {
  if (factor_source_) return factor_source_->mostRows();
  return use_ && link_.target() ? link_.get()->mostRows() : KrylovSolver::mostRows();
}

std::unique_ptr<ApproximateInverse> PCGLinearSolver::makeInverse() const {
  if (!use_) return nullptr;
  if (const Preconditioner* linked = link_.get()) return linked->makeInverse();
  const std::string& word = link_.path;
  if (word == "auto") return std::make_unique<AutomaticInverse>(may_change_);
  if (word == "jacobi") return std::make_unique<Jacobi>();
  if (word == "block_jacobi") return std::make_unique<BlockJacobiInverse>();
  if (word == "ssor") return std::make_unique<Ssor>();
  if (word == "incomplete_cholesky") return std::make_unique<IncompleteCholesky>();
  if (word == "warped") return std::make_unique<WarpedFactor>(*factor_source_);
  if (word == "multigrid") return std::make_unique<Multigrid>();
  return nullptr;
}

void PCGLinearSolver::tellChoice(const AutomaticInverse& inverse) {
  if (inverse.changes() == changes_) return;
  changes_ = inverse.changes();
  choice_ = inverse.choice();
}

SolveReport PCGLinearSolver::solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms) {
  SolveReport report;
  auto& [inverse, work] = keptFor(matrix);
  auto* const automatic = dynamic_cast<AutomaticInverse*>(inverse.get());
  if (automatic && may_change_) expected_iterations_ = automatic->expectedIterations();
  if (!begin(matrix, b, x, terms, report)) return report;
  work.resize(b.count);
  if (automatic) automatic->setProductCost(productCost(matrix));
  SolveReport prepared;
  if (inverse && !inverse->follow(matrix, prepared, terms.stop)) {
    prepared.relative_residual = 1;
    return prepared;
  }
  factorisations_ += prepared.factored;
  report = iterate(matrix, b, x, inverse.get(), work, iterations_);
  if (inverse && report.stop == SolveStop::iteration_limit && inverse->giveUp()) {
    const int before = report.iterations;
    SolveReport renewed;
    if (!inverse->follow(matrix, renewed, terms.stop)) {
      renewed.relative_residual = report.relative_residual, renewed.iterations = before;
      return renewed;
    }
    factorisations_ += renewed.factored;
    prepared.factored = prepared.factored || renewed.factored;
    report = iterate(matrix, b, x, inverse.get(), work, iterations_);
    report.iterations += before;
  }
  shift_ = inverse ? inverse->shift() : 0;
  if (automatic) tellChoice(*automatic);
  report.factored = prepared.factored;
  return report;
}

/// From x on, with at most so many products, or as many as the inverse has patience for.
SolveReport PCGLinearSolver::iterate(SystemMatrix& matrix, ConstRows b, Rows x, ApproximateInverse* inverse,
                                     cg::Directions& work, int most) {
  const auto multiply = [&](ConstRows p, Rows out) { product(matrix, p, out); };
  const auto precondition = [&](ConstRows r, Rows z) { inverse ? inverse->apply(r, z) : copy(r, z); };
  const auto note = [&](double residual) { record(residual / norm_b_); };
  if (inverse) most = std::min(most, inverse->patience());
  SolveReport report = cg::preconditioned(multiply, precondition, note, {most, target(), terms_.stop}, b, work, x);
  report.relative_residual /= norm_b_;
  if (inverse && report.stop != SolveStop::stopped) inverse->solved(report);
  return report;
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(pcg_linear_solver) {
  factory.add<stroma::PCGLinearSolver>("PCGLinearSolver", "conjugate gradients with a choice of preconditioners");
}
