// SPDX-License-Identifier: LGPL-2.1-or-later
// PCGLinearSolver: preconditioned conjugate gradients for A x = b with A symmetric and positive definite (Hestenes and
// Stiefel 1952; in this form Shewchuk 1994, after whom SOFA called it before).
//
//   q = A p,  alpha = r.z / p.q,  x += alpha p,  r -= alpha q,  z = B r,  beta = r.z / (r.z)_before,  p = z + beta p
//
// B ~ A^-1 is the preconditioner, a word or a link to a component:
//
//   auto                 the default: block_jacobi, and multigrid, warped or a direct solver once that is estimated to cost
//                        less, with what comes before its first solve. Estimates are from counts of iterations and the
//                        size of the matrix, so that each run does the same. A solve that gets on slowly changes within;
//                        what does not pay is given up. Bodies below 100 nodes, and scenes that write `iterations` or
//                        template GraphScattered, stay with block_jacobi. `choice` says what preconditions, and why
//                        Products are by the elements until the iterations that solves take pay for a matrix
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
// It stops when |r| <= tolerance |b| and max |D^-1 r| <= max(tolerance, 1e-3) max |x| with D the 3x3 diagonal blocks (bodies far lighter
// than others would stay where they are: see CGLinearSolver), after `iterations` products, when b = 0, when a number is not finite, and
// when the matrix shows itself to be singular or not definite; x then keeps the last iterate. Where |r| of the recurrence is
// small enough, b - A x itself is computed, and the iteration goes on from there if round-off kept it larger.
// With endsBySquares it stops as SOFA's does, when r.B r <= tolerance b.b, which depends on the units of the scene and, without a
// preconditioner, is |r| <= sqrt(tolerance) |b|.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <PCGLinearSolver iterations="100" tolerance="1e-9" preconditioner="incomplete_cholesky"/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include <optional>

#include "components/iterative_solvers/automatic_inverse.h"
#include "components/iterative_solvers/incomplete_cholesky.h"
#include "components/iterative_solvers/krylov_solver.h"
#include "components/iterative_solvers/light_rows.h"
#include "components/iterative_solvers/preconditioned_conjugate_gradients.h"
#include "components/iterative_solvers/warped_factor.h"
#include "framework/scene/factory.h"
#include "framework/scene/usual_component.h"

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
    is_constant_.reset();
    kept_.forEach([](Kept& kept) {
      if (kept.inverse) kept.inverse->reset();
    });
    if (own_factors_) own_factors_->reset();
    tellFirstChoice();
  }
  void serializeFor(SystemMatrix& matrix, Archive& archive) override;
  void keepFor(SystemMatrix& matrix) override;
  void takeBackFor(SystemMatrix& matrix) override;
  SolveReport solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms) override;
  SolveReport solveAll(SystemMatrix& matrix, std::span<const ConstRows> b, std::span<const Rows> x, const SolveTerms& terms) override;
  SolveReport solveDirectly(SystemMatrix& matrix, ConstRows b, Rows x, AutomaticInverse& automatic, cg::Directions& work);
  void refine(SystemMatrix& matrix, ConstRows b, Rows x, cg::Directions& work, SolveReport& report);
  Index mostRows() const override;
  bool usesFactorOf(const Component&) const override { return use_ && link_.path == "warped"; }

 private:
  /// For each matrix: work space and preconditioner.
  struct Kept {
    std::unique_ptr<ApproximateInverse> inverse;  ///< null: none
    cg::Directions work;
    LightRows light;
  };
  SolveReport iterate(SystemMatrix& matrix, ConstRows b, Rows x, Kept& kept);
  SolveReport iterateBySquares(const SystemMatrix& matrix, ConstRows b, Rows x, Kept& kept);
  std::unique_ptr<ApproximateInverse> makeInverse() const;
  DirectSolver& ownFactors() const;
  /// Of preconditioner auto; the text is made when it changes.
  void tellChoice(const AutomaticInverse& inverse);
  void tellFirstChoice();
  Kept& keptFor(const SystemMatrix& matrix) {
    return kept_.of(matrix, [this] { return std::make_unique<Kept>(Kept{makeInverse(), {}, {}}); });
  }

  bool use_ = true, may_change_ = true;
  bool ends_by_squares_ = false;
  std::optional<bool> is_constant_;  ///< nothing in the scene changes a matrix; asked in the first solve
  MatrixKey constant_;               ///< asked again where another one is solved: an edit may have changed what it is made of
  std::string choice_;
  int changes_ = 0;  ///< of the matrix solved last
  int reason_ = 0;   ///< that choice_ tells
  Link<Preconditioner> link_{"preconditioner"};
  Link<DirectSolver> factors_{"direct solver"};
  double shift_ = 0;
  int factorisations_ = 0;

  DirectSolver* factor_source_ = nullptr;  ///< of warped
  mutable std::unique_ptr<Component> own_factors_;  ///< of auto; null: not needed so far
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
  table.add("endsBySquares", ends_by_squares_)
      .help("stop when r.B r <= tolerance b.b, as SOFA does; B is the preconditioner, and the test depends on the units of the scene");
  table.add("choice", choice_).help("of preconditioner auto: what preconditions, and why").output();
  table.add("changes", changes_).help("how often preconditioner auto changed its choice").unit("-").output();
  table.add("shift", shift_)
      .help("multiple of the diagonal that incomplete_cholesky had to add in the last solve")
      .unit("-")
      .output();
  table.add("factorisations", factorisations_)
      .help("how often warped or auto factored so far, for all matrices")
      .unit("-")
      .output();
}

void PCGLinearSolver::init() {
  if (use_ && link_.path == "multigrid") expected_iterations_ = 15;
  KrylovSolver::init();
  if (use_) link_.get();  // ready before the first solve
  if (ends_by_squares_ && use_ && link_.path == "auto")
    throw ComponentError("endsBySquares needs a preconditioner that does not change", "preconditioner=\"none\" or another word or a link");
  may_change_ = !data().find("iterations")->isSet() && data().find("template")->print() != "GraphScattered";
  tellFirstChoice();
  if (use_ && link_.path == "warped") factor_source_ = &factorSource(*this, factors_);
}

Index PCGLinearSolver::mostRows() const {
  if (factor_source_) return factor_source_->mostRows();
  return use_ && link_.target() ? link_.get()->mostRows() : KrylovSolver::mostRows();
}

/// Made when preconditioner auto first wants factors: their module is not opened before.
DirectSolver& PCGLinearSolver::ownFactors() const {
  if (!own_factors_) {
    own_factors_ = makeUsual(Part::solver_of_equilibria);
    own_factors_->init();
  }
  return dynamic_cast<DirectSolver&>(*own_factors_);
}

std::unique_ptr<ApproximateInverse> PCGLinearSolver::makeInverse() const {
  if (!use_) return nullptr;
  if (const Preconditioner* linked = link_.get()) return linked->makeInverse();
  const std::string& word = link_.path;
  if (word == "auto")
    return std::make_unique<AutomaticInverse>(may_change_, [this]() -> DirectSolver& { return ownFactors(); });
  if (word == "jacobi") return std::make_unique<Jacobi>();
  if (word == "block_jacobi") return std::make_unique<BlockJacobiInverse>();
  if (word == "ssor") return std::make_unique<Ssor>();
  if (word == "incomplete_cholesky") return std::make_unique<IncompleteCholesky>();
  if (word == "warped") return std::make_unique<WarpedFactor>(*factor_source_);
  if (word == "multigrid") return std::make_unique<Multigrid>();
  return nullptr;
}

void PCGLinearSolver::serializeFor(SystemMatrix& matrix, Archive& archive) {
  ApproximateInverse* const inverse = keptFor(matrix).inverse.get();
  if (!inverse) return;
  inverse->serialize(matrix, archive);
  if (auto* automatic = dynamic_cast<AutomaticInverse*>(inverse)) {
    if (automatic->isDirect()) ownFactors().serializeFor(matrix, archive);
    if (archive.isReading()) tellChoice(*automatic);
  }
}

void PCGLinearSolver::keepFor(SystemMatrix& matrix) {
  if (ApproximateInverse* inverse = keptFor(matrix).inverse.get()) inverse->keep(matrix);
  if (own_factors_) ownFactors().keepFor(matrix);
}

void PCGLinearSolver::takeBackFor(SystemMatrix& matrix) {
  if (ApproximateInverse* inverse = keptFor(matrix).inverse.get()) inverse->takeBack(matrix);
  if (own_factors_) ownFactors().takeBackFor(matrix);
}

void PCGLinearSolver::tellFirstChoice() {
  changes_ = reason_ = 0;
  if (use_ && link_.path == "auto") choice_ = AutomaticInverse(may_change_).choice();
}

void PCGLinearSolver::tellChoice(const AutomaticInverse& inverse) {
  if (inverse.reason() == reason_) return;
  reason_ = inverse.reason();
  changes_ = inverse.changes();
  choice_ = inverse.choice();
}

SolveReport PCGLinearSolver::solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms) {
  SolveReport report;
  Kept& kept = keptFor(matrix);
  std::unique_ptr<ApproximateInverse>& inverse = kept.inverse;
  cg::Directions& work = kept.work;
  auto* const automatic = dynamic_cast<AutomaticInverse*>(inverse.get());
  if (automatic && may_change_) expected_iterations_ = automatic->expectedIterations(relativeTarget(terms));
  if (!begin(matrix, b, x, terms, report)) return report;
  work.resize(b.count);
  if (automatic) {
    if (!is_constant_ || (*is_constant_ && constant_ != matrix.key())) {
      is_constant_ = !matrixDependsOnState(node().root());
      constant_ = matrix.key();
    }
    automatic->begin(productCost(matrix), target() / norm_b_, *is_constant_);
  }
  constexpr int most_renewals = 8;
  bool factored = false;
  for (int k = 0; k <= most_renewals; ++k) {
    SolveReport prepared;
    const int before = report.iterations;
    const bool is_ready = !inverse || inverse->follow(matrix, prepared, terms.stop);
    if (!is_ready)
      prepared.relative_residual = k == 0 ? 1 : report.relative_residual, prepared.iterations = 0, report = prepared;
    else if (automatic && automatic->isDirect())
      report = solveDirectly(matrix, b, x, *automatic, work);
    else
      report = ends_by_squares_ ? iterateBySquares(matrix, b, x, kept) : iterate(matrix, b, x, kept);
    report.iterations += before;
    factorisations_ += prepared.factored || report.factored;
    factored = factored || prepared.factored || report.factored;
    if (!is_ready || !inverse || report.stop != SolveStop::iteration_limit || !inverse->giveUp()) break;
  }
  shift_ = inverse ? inverse->shift() : 0;
  if (automatic) {
    if (report.usable()) automatic->keepSolve(b, x);
    tellChoice(*automatic);
  }
  report.factored = factored;
  return report;
}

/// Once a direct solver serves, right sides go through its factors together, which reads these once for many of them.
SolveReport PCGLinearSolver::solveAll(SystemMatrix& matrix, std::span<const ConstRows> b, std::span<const Rows> x,
                                      const SolveTerms& terms) {
  auto* const automatic = dynamic_cast<AutomaticInverse*>(keptFor(matrix).inverse.get());
  if (!automatic || b.size() < 2) return LinearSolver::solveAll(matrix, b, x, terms);
  struct OneAgain {  // also where a solve throws
    AutomaticInverse& inverse;
    ~OneAgain() { inverse.expectSides(1); }
  } const one_again{*automatic};
  automatic->expectSides(b.size());
  SolveReport all{.stop = SolveStop::zero_right_side};
  bool goes_on = true, together = true;
  for (std::size_t done = 0; goes_on && done < b.size();) {
    const std::size_t left = b.size() - done;
    if (together && done > 0 && left > 1 && automatic->staysDirect()) {
      const SolveReport rest = ownFactors().solveAll(matrix, b.subspan(done), x.subspan(done), terms);
      factorisations_ += rest.factored;
      together = !rest.usable() || rest.stop == SolveStop::breakdown || rest.relative_residual <= relativeTarget(terms);
      if (together) {
        automatic->noteSides(left);
        goes_on = all.add(rest), done = b.size();
      }
    } else {
      goes_on = all.add(solve(matrix, b[done], x[done], terms)), ++done;
    }
  }
  return all;
}

SolveReport PCGLinearSolver::solveDirectly(SystemMatrix& matrix, ConstRows b, Rows x, AutomaticInverse& automatic,
                                           cg::Directions& work) {
  SolveReport report = ownFactors().solve(matrix, b, x, terms_);
  if (report.stop == SolveStop::not_definite || report.stop == SolveStop::breakdown) {
    automatic.noteRefusal();
  } else if (report.usable()) {
    if (report.relative_residual * norm_b_ > 1.1 * target()) refine(matrix, b, x, work, report);
    automatic.solved(report);
  }
  return report;
}

/// Goes on from the x of a direct solve to the tolerance, by conjugate gradients with its factors.
void PCGLinearSolver::refine(SystemMatrix& matrix, ConstRows b, Rows x, cg::Directions& work, SolveReport& report) {
  constexpr int most = 20;
  SolveReport kept;
  Factorisation* const factors = ownFactors().factor(matrix, kept, terms_.stop);
  if (!factors) return;
  const auto multiply = [&](ConstRows p, Rows out) { product(matrix, p, out); };
  const auto precondition = [&](ConstRows r, Rows z) { factors->apply(r, z); };
  const auto note = [&](double residual) { record(residual / norm_b_); };
  const cg::Limits limits{most, std::max(target(), 1e-16 * norm_b_), terms_.stop};
  const SolveReport further = cg::preconditioned(multiply, precondition, note, limits, b, work, x);
  const bool ends_so = further.stop == SolveStop::converged || !further.usable();
  report.stop = ends_so ? further.stop : SolveStop::stagnated;
  report.relative_residual = further.relative_residual / norm_b_;
  report.iterations += further.iterations;
}

/// SOFA's loop, with its end.
SolveReport PCGLinearSolver::iterateBySquares(const SystemMatrix& matrix, ConstRows b, Rows x, Kept& kept) {
  auto& [r, p, q, z] = kept.work;
  ApproximateInverse* const inverse = kept.inverse.get();
  const auto precondition = [&](Rows out) { inverse ? inverse->apply(r, out) : copy(r, out); };
  SolveReport report;
  residual(matrix, b, x, r, q);
  precondition(p);
  const double enough = tolerance() * norm_b_ * norm_b_;
  double rho = dot(r, p), square = norm_b_ * norm_b_;
  while (report.iterations < iterations_ && rho > enough && !isStopAsked()) {
    product(matrix, p, q);
    ++report.iterations;
    const double alpha = rho / dot(p, q);
    axpy(alpha, p, x);
    square = cg::reduceResidual(alpha, q, r);
    record(std::sqrt(square) / norm_b_);
    precondition(z);
    const double before = rho;
    rho = dot(r, z);
    if (!std::isfinite(alpha) || !std::isfinite(rho)) break;
    scale(rho / before, p), axpy(1, z, p);
  }
  report.stop = !std::isfinite(rho)  ? SolveStop::not_finite
                : isStopAsked()      ? SolveStop::stopped
                : rho <= enough      ? SolveStop::converged
                                     : SolveStop::iteration_limit;
  report.relative_residual = std::sqrt(square) / norm_b_;
  if (inverse && report.stop != SolveStop::stopped) inverse->solved(report);
  return report;
}

/// From x on, with at most so many products, or as many as the inverse has patience for.
SolveReport PCGLinearSolver::iterate(SystemMatrix& matrix, ConstRows b, Rows x, Kept& kept) {
  ApproximateInverse* const inverse = kept.inverse.get();
  cg::Directions& work = kept.work;
  const cg::BlockJacobi* blocks = nullptr;  // what serves light rows where nothing else preconditions
  const auto multiply = [&](ConstRows p, Rows out) { product(matrix, p, out); };
  const auto precondition = [&](ConstRows r, Rows z) {
    inverse ? inverse->apply(r, z) : blocks ? void(blocks->apply(r, z)) : copy(r, z);
  };
  const int most = inverse ? std::min(iterations_, inverse->patience()) : iterations_;
  const double norm_of_forces = norm_b_;  // the measure of what may follow, a direct solve or another inverse
  bool by_inverse = inverse && matrix.hasTurns();
  if (by_inverse) {
    precondition(b, work.z.rows());
    const double square = cg::inner(b, work.z);
    by_inverse = square > 0 && std::isfinite(square);
    if (by_inverse) norm_b_ = std::sqrt(square);
  }
  auto* const automatic = dynamic_cast<AutomaticInverse*>(inverse);
  int iterations = 0, before = 0;
  cg::Limits* now = nullptr;
  const auto note = [&](double residual) {
    record(residual / norm_b_);
    ++iterations;
    if (!automatic || residual <= target()) return;
    if (assemblesLate(matrix, iterations)) automatic->noteProduct(productCost(matrix));
    if (automatic->isLost(iterations, residual / norm_b_)) now->iterations = iterations - before;
  };
  const auto solve = [&](cg::Limits limits) {
    now = &limits, before = iterations;
    const bool is_first = iterations == 0;
    if (!is_first) blocks = &kept.light.inverse();
    return cg::preconditioned(multiply, precondition, note, limits, b, work, x, !is_first, is_first && by_inverse);
  };
  if (const BlockJacobiInverse* known = inverse ? inverse->blockJacobi() : nullptr)
    kept.light.know(known->key(), known->blocks(), known->inverse());
  const auto left = [&] { return work.r.rows(); };
  SolveReport report = kept.light.solveAll(matrix, {most, target(), terms_.stop, by_inverse}, relativeTarget(terms_), solve, left, x);
  report.relative_residual /= norm_b_;
  norm_b_ = norm_of_forces;
  if (automatic && automatic->isSecondTry() && report.stop == SolveStop::iteration_limit) report.stop = SolveStop::not_definite;
  if (inverse && report.stop != SolveStop::stopped) inverse->solved(report);
  return report;
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(pcg_linear_solver) {
  factory.add<stroma::PCGLinearSolver>("PCGLinearSolver", "conjugate gradients with a choice of preconditioners");
}
