// SPDX-License-Identifier: LGPL-2.1-or-later
// AutomaticLinearSolver: A x = b by factors or by conjugate gradients with multigrid, whichever costs less. It is what an
// integrator of statics gets when its scene names no linear solver. A matrix that is not symmetric gets GMRES (Saad, Schultz
// 1986) instead of conjugate gradients, with multigrid of its symmetric part: what is not symmetric in a tangent is small where
// strains are. Both go on while light rows are left, see CGLinearSolver. Bodies that are nearly incompressible by a mean dilatation
// get GMRES for displacements and pressures together where that costs less than factors (mixed_solve.h). If that fails, `choice` says so,
// its iterations count, and displacements alone are solved for from then on.
//
// Costs are estimated from counts (solver_costs.h), for a core of 115 Gflop/s in single precision: no clock is read, and each run
// chooses the same on every machine and with every number of threads. Where forces are not linear, they are those of six solves, which
// multigrid makes loosely. Factors then serve later matrices too, turned with the body (WarpPreconditioner), where iterations with them
// are estimated to cost less than factors of each. Bodies below 500 nodes are always factored, each matrix. A solve by multigrid that
// goes on for longer than factors would have taken (a Poisson's ratio near 1/2 with cells that lock, badly shaped cells) is ended, and
// the matrix is factored from then on, if factors fit into half of the memory. So it is where solves of Newton's method have taken so
// many iterations that factors would have paid. With multigrid a symmetric solve begins at the combination of the last four solutions
// that is nearest in energy (former_solutions.h), where that leaves less than half of the residual. `choice` says what was chosen and
// why. See SparseLDLSolver, MultigridPreconditioner and PCGLinearSolver for the methods.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <StaticSolver/>
//   <AutomaticLinearSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/>
//   <UniformMass totalMass="1"/>
//   <TetrahedronFEMForceField youngModulus="5000" poissonRatio="0.3" method="small"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "components/iterative_solvers/equilibrium_memory.h"
#include "components/iterative_solvers/krylov_solver.h"
#include "components/iterative_solvers/scene_volumes.h"
#include "framework/algebra/solver_choice.h"
#include "framework/scene/factory.h"
#include "framework/scene/usual_component.h"

namespace stroma {
namespace {

class AutomaticLinearSolver final : public KrylovSolver, public FactorUser, public SolverChoice {
 public:
  void declare(DataTable& table) override;
  void init() override;
  void reset() override {
    kept_.forEach([](Kept& kept) { kept.reset(); });
    if (own_factors_) own_factors_->reset();
  }
  bool usesFactorOf(const Component& solver) const override { return direct_ == &solver; }
  bool needsSymmetric() const override { return direct_ && direct_->needsSymmetric(); }
  SolveReport solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms) override;
  void serializeFor(SystemMatrix& matrix, Archive& archive) override;
  void keepFor(SystemMatrix& matrix) override;
  void takeBackFor(SystemMatrix& matrix) override;
  void choose(SystemMatrix& matrix) override {
    isInScene() ? void(keptFor(matrix)) : void(estimates_ = estimateSolves(matrix, amg::hardlySmooths(matrix.assemble())));
  }
  std::string choice() const override { return choice_; }

 private:
  using Way = EquilibriumChoice::Way;
  using Kept = EquilibriumMemory;
  bool isInScene() const { return path().front() == '/'; }  ///< one of makeUsual() has no node
  Kept& keptFor(SystemMatrix& matrix);
  /// That of the scene; else one that is made when it is first wanted: its module is not opened for multigrid.
  DirectSolver& factors() {
    if (direct_) return *direct_;
    own_factors_ = makeUsual(Part::solver_of_equilibria);
    own_factors_->init();
    return *(direct_ = &dynamic_cast<DirectSolver&>(*own_factors_));
  }
  void chooseFor(SystemMatrix& matrix, Kept& kept);
  /// Of the matrix solved last, and of all.
  void tellChoice(const Kept& kept);
  SolveReport iterate(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms, Kept& kept);
  SolveReport conjugateGradients(const SystemMatrix& matrix, ConstRows b, Rows x, int most, Kept& kept, double& began);
  SolveReport minimalResiduals(const SystemMatrix& matrix, ConstRows b, Rows x, int most, Kept& kept);
  bool iterateWithFactors(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms, Kept& kept, SolveReport& report);
  SolveReport solveByFactors(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms, Kept& kept);
  SolveReport solveDisplacements(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms, Kept& kept);
  bool solveMixed(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms, Kept& kept, SolveReport& report);
  WarpedFactor& turned(Kept& kept) {
    if (!kept.turned) kept.turned = std::make_unique<WarpedFactor>(factors());
    return *kept.turned;
  }
  void changeToFactors(Kept& kept);
  /// Between steps, see MixedSolve::reset().
  bool forgetsPressures(const Kept& kept) const { return kept.mixed && matrixDependsOnState(node().root()); }

  Link<DirectSolver> factors_{"direct solver"};
  DirectSolver* direct_ = nullptr;          ///< null: none in the scene, and not needed so far
  std::unique_ptr<Component> own_factors_;  ///< what direct_ is where the scene has none
  std::string choice_;
  std::vector<double> estimates_;
  int changes_ = 0;
  int most_expected_ = 0;  ///< iterations of a solve to the tolerance
  PerMatrix<Kept> kept_;
};

void AutomaticLinearSolver::declare(DataTable& table) {
  KrylovSolver::declare(table);
  table.addLink("directSolver", factors_)
      .help("what factors; without it, the direct solver of the same node, or one of its own once factors are wanted");
  table.add("choice", choice_).help("what was chosen, and why").output();
  table.add("estimates", estimates_).help("what parts of solves are estimated to take, for programs").unit("s").output();
  table.add("changes", changes_).help("how often a choice proved wrong and was changed").unit("-").output();
}

void AutomaticLinearSolver::init() {
  expected_iterations_ = 15;
  KrylovSolver::init();
  most_expected_ = expected_iterations_;
  const auto factors = [](const auto& one) { return dynamic_cast<const DirectSolver*>(one.get()) != nullptr; };
  if (!factors_.path.empty() || (isInScene() && std::ranges::any_of(node().components(), factors)))
    direct_ = &factorSource(*this, factors_);
}

AutomaticLinearSolver::Kept& AutomaticLinearSolver::keptFor(SystemMatrix& matrix) {
  Kept& kept = kept_.of(matrix);
  if (kept.now.way == Way::open) chooseFor(matrix, kept);
  return kept;
}

void AutomaticLinearSolver::chooseFor(SystemMatrix& matrix, Kept& kept) {
  kept.symmetric = matrix.symmetric();
  const Index most = direct_ ? direct_->mostRows() : std::numeric_limits<Index>::max();
  kept.now = chooseFirst(matrix, node().root(), most, kept.costs, kept.reason);
  if (kept.now.way == Way::factors) factors();
  tellChoice(kept);
}

void AutomaticLinearSolver::tellChoice(const Kept& kept) {
  if (kept.now.hasPressures())
    choice_ = "GMRES for displacements and pressures: " + kept.reason;
  else if (kept.now.way == Way::factors)
    choice_ = kept.now.ofFactors(direct_->type(), kept.reason);
  else
    choice_ = fmt::format("{} with multigrid: {}", kept.symmetric ? "conjugate gradients" : "GMRES", kept.reason);
  choice_ += kept.now.ofPressures();
  changes_ = 0;
  kept_.forEach([this](const Kept& each) { changes_ += each.now.isChanged(); });
}

SolveReport AutomaticLinearSolver::iterate(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms,
                                           Kept& kept) {
  SolveTerms own = terms;
  if (kept.now.is_strict) own.relative_residual = std::min(terms.relative_residual, EquilibriumChoice::strict);
  const bool is_loose = terms.relative_residual > tolerance();
  expected_iterations_ = std::min(kept.now.expectedIterations(relativeTarget(own), is_loose, most_expected_), iterations_);
  SolveReport report;
  if (!begin(matrix, b, x, own, report)) return report;
  if (!kept.inverse.follow(matrix, report, terms.stop)) {
    report.relative_residual = 1;
    return report;
  }
  const int most = std::min(iterations_, kept.patience());
  double began = 1;
  report = kept.symmetric ? conjugateGradients(matrix, b, x, most, kept, began) : minimalResiduals(matrix, b, x, most, kept);
  if (report.stop != SolveStop::stopped) kept.inverse.solved(report, began), kept.now.noteRate(report, began);
  kept.now.noteDefinite(report);
  return report;
}

/// `began` becomes what is left where it begins. Where rows turn, r.B r measures that, B the multigrid.
SolveReport AutomaticLinearSolver::conjugateGradients(const SystemMatrix& matrix, ConstRows b, Rows x, int most, Kept& kept,
                                                      double& began) {
  const auto multiply = [&](ConstRows p, Rows out) { product(matrix, p, out); };
  const auto precondition = [&](ConstRows r, Rows z) { kept.inverse.apply(r, z); };
  const auto note = [&](double residual) { record(residual / norm_b_); };
  kept.work.resize(b.count);
  began = kept.former.begin(multiply, b, norm_b_, kept.work, x);
  const bool has_begun = began < 1;  // kept.work.r is what is left
  bool by_inverse = matrix.hasTurns();
  if (by_inverse) {
    precondition(b, kept.work.z.rows());
    const double square = cg::inner(b, kept.work.z);
    by_inverse = square > 0 && std::isfinite(square);
    if (by_inverse) norm_b_ = std::sqrt(square);
    if (by_inverse && has_begun) {
      precondition(kept.work.r, kept.work.z.rows());
      began = std::sqrt(std::abs(cg::inner(kept.work.r, kept.work.z))) / norm_b_;
    }
  }
  const cg::Limits limits{most, target(), terms_.stop, by_inverse};
  SolveReport report = kept.light.conjugateGradients(matrix, multiply, precondition, note, limits, relativeTarget(terms_), b, kept.work, x,
                                                     has_begun, by_inverse);
  if (report.stop == SolveStop::converged) kept.former.solved(x);
  report.relative_residual /= norm_b_;
  return report;
}

SolveReport AutomaticLinearSolver::minimalResiduals(const SystemMatrix& matrix, ConstRows b, Rows x, int most, Kept& kept) {
  const auto multiply = [&](ConstRows p, Rows out) { product(matrix, p, out); };
  const auto precondition = [&](ConstRows r, Rows z) { kept.inverse.apply(r, z); };
  const auto note = [&](double residual) { record(residual / norm_b_); };
  SolveReport report = kept.scaled.solve(matrix, multiply, precondition, note, kept.light, {most, 0, terms_.stop}, relativeTarget(terms_),
                                         b, x, norm_b_);
  report.relative_residual /= norm_b_;
  return report;
}

/// By conjugate gradients with factors of a former matrix, for as many iterations as they have saved so far; else, or where that fails,
/// with factors of this very matrix and to their accuracy. A decade of the residual costs less by former factors than an iteration
/// of Newton's method does: solves are not as loose as by multigrid. False: factors of each matrix are to do it.
bool AutomaticLinearSolver::iterateWithFactors(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms, Kept& kept,
                                               SolveReport& report) {
  constexpr int few_iterations = 8, least_trial = 3;
  expected_iterations_ = few_iterations;
  SolveTerms own = terms;
  own.relative_residual = std::min(terms.relative_residual, EquilibriumChoice::by_former);
  if (!begin(matrix, b, x, own, report)) return true;
  WarpedFactor& inverse = turned(kept);
  FormerFactorAccount& account = kept.now.account;
  const auto multiply = [&](ConstRows p, Rows out) { product(matrix, p, out); };
  const auto precondition = [&](ConstRows r, Rows z) { inverse.apply(r, z); };
  const auto note = [&](double residual) { record(residual / norm_b_); };
  kept.work.resize(b.count);
  const bool is_another = !inverse.isOf(matrix);
  const int most = is_another ? account.mostIterations(inverse.prices()) : iterations_;
  if (most < least_trial) inverse.factorNext();
  bool factored = false;
  for (;;) {
    const int before = report.iterations;
    SolveReport prepared;
    const bool is_ready = inverse.follow(matrix, prepared, terms.stop), is_fresh = inverse.isFresh();
    factored = factored || prepared.factored;
    if (is_ready && is_fresh) {
      report = inverse.solveFresh(b, x, terms, own.relative_residual);
    } else if (is_ready) {
      const cg::Limits limits{std::min({iterations_, most, inverse.patience()}), target(), terms.stop};
      report = cg::preconditioned(multiply, precondition, note, limits, b, kept.work, x);
      report.relative_residual /= norm_b_;
      if (report.stop != SolveStop::stopped) inverse.solved(report, 1);
      EquilibriumChoice::acceptEnough(relativeTarget(terms), report);
    } else {
      report = prepared, report.relative_residual = 1, report.iterations = 0;
    }
    is_fresh ? account.addFactors(prepared.factored, inverse.prices()) : account.addFormer(report.iterations, inverse.prices());
    report.iterations += before, report.factored = factored;
    const bool is_over = isOver(report.stop);
    if (is_over || is_fresh || !inverse.giveUp()) {
      if (is_another) account.endMatrix(inverse.prices());
      kept.now.is_indefinite = !is_ready && is_fresh && report.stop == SolveStop::not_definite;
      if (kept.now.is_indefinite) tellChoice(kept);
      return is_over || kept.now.is_indefinite;
    }
    clear(x);
  }
}

/// What iterations get nowhere with is left to factors of that very matrix, and so are all after one that is not definite.
SolveReport AutomaticLinearSolver::solveByFactors(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms, Kept& kept) {
  SolveReport report;
  if (kept.now.triesFormer() && matrix.symmetric()) {
    if (iterateWithFactors(matrix, b, x, terms, kept, report)) return report;
    ++kept.now.refusals;
    clear(x);
  }
  SolveReport again = factors().solve(matrix, b, x, terms);
  again.iterations += report.iterations, again.factored = again.factored || report.factored;
  return again;
}

/// False: displacements alone are to be solved for, then and later. x is zero, and the report has what was lost.
bool AutomaticLinearSolver::solveMixed(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms, Kept& kept,
                                       SolveReport& report) {
  expected_iterations_ = 2 * most_expected_;
  if (!begin(matrix, b, x, terms, report)) return true;
  if (!kept.mixed) kept.mixed = std::make_unique<MixedSolve>();
  report = kept.mixed->solve({.matrix = matrix,
                              .b = b,
                              .product = [&](ConstRows p, Rows out) { product(matrix, p, out); },
                              .terms = [&] { return stiffVolumesOf(matrix, node().root()); },
                              .note = [&](double residual) { record(residual / norm_b_); },
                              .factors = factors(),
                              .light = kept.light},
                             iterations_, relativeTarget(terms), terms.stop, x);
  if (report.stop == SolveStop::converged && !(dot(b, x) > 0)) report.stop = SolveStop::not_definite;
  if (report.stop == SolveStop::converged || report.stop == SolveStop::stopped) return true;
  if (report.stop == SolveStop::stagnated && isAtRoundOff(matrix, b, x, report.relative_residual)) return true;
  kept.now.givePressuresUp(report);
  kept.mixed = nullptr, clear(x);
  tellChoice(kept);
  return false;
}

void AutomaticLinearSolver::changeToFactors(Kept& kept) {
  kept.now.way = Way::factors, kept.inverse.reset(), kept.former.reset();
  factors();
  tellChoice(kept);
}

SolveReport AutomaticLinearSolver::solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms) {
  Kept& kept = keptFor(matrix);
  const bool has_pressures = kept.now.hasPressures() && matrix.symmetric() && matrix.key().shift == 0;
  if (has_pressures && refutesPressures(matrix, node().root(), kept.now)) tellChoice(kept);
  SolveReport lost;
  if (has_pressures && kept.now.hasPressures() && solveMixed(matrix, b, x, terms, kept, lost)) return lost;
  SolveReport report = solveDisplacements(matrix, b, x, terms, kept);
  report.iterations += lost.iterations;
  return report;
}

SolveReport AutomaticLinearSolver::solveDisplacements(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms, Kept& kept) {
  if (std::exchange(kept.now.is_close, false) && amg::hardlySmooths(matrix.assemble())) {
    kept.now.is_rough = true, changeToFactors(kept);
  }
  if (kept.now.way == Way::factors) return solveByFactors(matrix, b, x, terms, kept);
  if (const bool now = matrix.symmetric(); now != kept.symmetric) kept.symmetric = now, tellChoice(kept);
  const auto isHopeless = [&](const SolveReport& solve) {
    if (solve.stop == SolveStop::iteration_limit) return solve.iterations == kept.patience();
    if (solve.stop != SolveStop::stagnated) return false;
    kept.work.resize(b.count);
    // where rows turn, the solve has measured in other terms
    return !isAtRoundOff(matrix, b, x, std::sqrt(residual(matrix, b, x, kept.work.r, kept.work.q)) / norm(b));
  };
  const int made = kept.inverse.made();
  SolveReport report = iterate(matrix, b, x, terms, kept);
  bool is_hopeless = isHopeless(report);
  if (is_hopeless && kept.inverse.giveUp()) {  // the hierarchy was that of another matrix
    const int before = report.iterations;
    report = iterate(matrix, b, x, terms, kept);
    is_hopeless = isHopeless(report);
    report.iterations += before;
  }
  if (!is_hopeless) {
    const amg::Hierarchy* hierarchy = kept.inverse.hierarchy();
    const bool has_patches = hierarchy && hierarchy->hasPatches();
    if (kept.now.isDear(kept.costs, report.iterations, has_patches, kept.inverse.made() > made)) changeToFactors(kept);
    return report;
  }
  kept.now.lost_iterations = report.iterations, kept.now.left = report.relative_residual;
  changeToFactors(kept);
  clear(x);
  SolveReport again = solveByFactors(matrix, b, x, terms, kept);
  again.iterations += report.iterations;
  return again;
}

void AutomaticLinearSolver::serializeFor(SystemMatrix& matrix, Archive& archive) {
  Kept& kept = keptFor(matrix);
  kept.now.serialize(archive);
  kept.costs.serialize(archive);
  archive.value("reason_of_choice", kept.reason);
  bool is_turned = kept.now.way == Way::factors && kept.turned;
  archive.value("has_turned", is_turned);
  if (kept.now.way == Way::factors)
    factors().serializeFor(matrix, archive);
  else
    kept.inverse.serialize(matrix, archive, !archive.isReading() && !matrixDependsOnState(node().root()));
  if (is_turned) turned(kept).serialize(matrix, archive);
  kept.former.serialize(archive);
  if (kept.now.hasPressures() && !matrixDependsOnState(node().root())) kept.serializePlaces(archive);
  if (archive.isReading()) tellChoice(kept);
}

void AutomaticLinearSolver::keepFor(SystemMatrix& matrix) {
  Kept& kept = keptFor(matrix);
  kept.keep(matrix, forgetsPressures(kept));
  if (direct_) direct_->keepFor(matrix);
}

void AutomaticLinearSolver::takeBackFor(SystemMatrix& matrix) {
  Kept& kept = keptFor(matrix);
  kept.takeBack(matrix, forgetsPressures(kept));
  if (direct_) direct_->takeBackFor(matrix);
  tellChoice(kept);
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(automatic_linear_solver) {
  factory.add<stroma::AutomaticLinearSolver>("AutomaticLinearSolver",
                                             "factors or conjugate gradients with multigrid, whichever costs less");
}
