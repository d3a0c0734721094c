// SPDX-License-Identifier: LGPL-2.1-or-later
// AutomaticLinearSolver: A x = b by factors or by conjugate gradients with multigrid, whichever costs less. It is what an
// integrator of statics gets when its scene names no linear solver. A matrix that is not symmetric gets GMRES (Saad, Schultz
// 1986) instead of conjugate gradients, with multigrid of its symmetric part: what is not symmetric in a tangent is small where
// strains are.
//
// With w h nodes in a cross-section and l / w the slenderness of a body of n nodes, its factors take
//
//   135 (w h)^3 l / w flops   and   81 (w h)^2 l / w numbers,
//
// the laws of nested dissection with factors from cubes, and in flat bodies 1 + 2.4 (1 - h / w) and 1 + 0.7 ln(w / h) times
// as much. A hierarchy and its iterations take a time in proportion to the blocks and rows of the matrix. l, w and h come from
// the second moments of the nodes. Both times are estimated from counts, for a core of 115 Gflop/s in single precision: no clock
// is read, and each run chooses the same on every machine and with every number of threads. Where forces are not linear, both
// are those of six solves, which multigrid makes loosely.
// Bodies of less than 500 nodes are always factored.
//
// A solve by multigrid that goes on for longer than factors would have taken (a Poisson's ratio near 1/2 with cells that
// lock, badly shaped cells) is ended, and the matrix is factored from then on, if factors fit into half of the memory.
// With multigrid a symmetric solve begins at the combination of the last four solutions that is nearest in energy
// (former_solutions.h), where that leaves less than half of the residual: steps of a body that swings take half of the iterations.
// `choice` says what was chosen and why. See SparseLDLSolver, MultigridPreconditioner and PCGLinearSolver for what the methods
// do.
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

#include "components/iterative_solvers/former_solutions.h"
#include "components/iterative_solvers/gmres.h"
#include "components/iterative_solvers/krylov_solver.h"
#include "components/iterative_solvers/multigrid.h"
#include "components/iterative_solvers/preconditioned_conjugate_gradients.h"
#include "components/iterative_solvers/row_scales.h"
#include "components/iterative_solvers/solver_costs.h"
#include "components/iterative_solvers/warped_factor.h"
#include "framework/algebra/solver_choice.h"
#include "framework/scene/factory.h"
#include "framework/scene/usual_component.h"

namespace stroma {
namespace {

constexpr Index always_factored = 500;  // nodes
constexpr int usual_solves = 6;          // by Newton's method

/// Whether the laws of factors might choose wrongly.
bool isClose(const SolverCosts& by_law) {
  constexpr double too_high = 5, too_low = 2;
  return by_law.multigrid < too_low * by_law.direct && by_law.direct < too_high * by_law.multigrid;
}

/// The |b - A x| / |b| that round-off leaves, whatever solves: that of D x, D the diagonal blocks.
double roundOff(const SystemMatrix& matrix, ConstRows b, ConstRows x) {
  std::vector<double> blocks;
  matrix.diagonalBlocks(blocks);
  double sum = 0;
  for (Index row = 0; row < x.count; ++row)
    sum += (Eigen::Map<const Mat3>(blocks.data() + 9 * std::size_t(row)).transpose() * x[row]).squaredNorm();
  return std::numeric_limits<double>::epsilon() * std::sqrt(sum) / norm(b);
}

class AutomaticLinearSolver final : public KrylovSolver, public FactorUser, public SolverChoice {
 public:
  void declare(DataTable& table) override;
  void init() override;
  void reset() override {
    kept_.forEach([](Kept& kept) { kept.inverse.reset(), kept.former.reset(), kept.now = {}; });
    if (own_factors_) own_factors_->reset();
  }
  bool usesFactorOf(const Component& solver) const override { return direct_ == &solver; }
  bool needsSymmetric() const override { return direct_ && direct_->needsSymmetric(); }
  SolveReport solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms) override;
  void serializeFor(SystemMatrix& matrix, Archive& archive) override;
  void keepFor(SystemMatrix& matrix) override;
  void takeBackFor(SystemMatrix& matrix) override;
  void choose(SystemMatrix& matrix) override { keptFor(matrix); }
  std::string choice() const override { return choice_; }

 private:
  enum class Way : int { open, factors, multigrid };
  struct Memory {
    Way way = Way::open;
    int patience = 0;
    bool is_close = false;    ///< factors cost less where diagonal blocks hardly smooth, which the first solve finds out
    bool is_rough = false;    ///< they do
    int lost_iterations = 0;  ///< by multigrid, when it was given up
    double left = 0;          ///< the relative residual then
  };
  /// For each matrix.
  struct Kept {
    Memory now, before_step;
    std::string reason;      ///< of the first choice, in words
    bool symmetric = true;   ///< the matrix solved last
    Multigrid inverse;
    cg::Directions work;
    cg::FormerSolutions former;
    gmres::Space space;  ///< of matrices that are not symmetric
    RowScales scales;
    Vector unscaled, right_side;  ///< where there are scales
  };
  Kept& keptFor(SystemMatrix& matrix);
  bool hasFactorsInScene() const;
  /// That of the scene; else one that is made when it is first wanted: its module is not opened for multigrid.
  DirectSolver& factors() {
    if (!direct_) {
      own_factors_ = makeUsual(Part::solver_of_equilibria);
      direct_ = &dynamic_cast<DirectSolver&>(*own_factors_);
    }
    return *direct_;
  }
  void chooseFor(SystemMatrix& matrix, Kept& kept);
  /// Of the matrix solved last, and of all.
  void tellChoice(const Kept& kept);
  static int patienceOf(const Kept& kept) {
    const amg::Hierarchy* hierarchy = kept.inverse.hierarchy();
    return hierarchy && hierarchy->hasPatches() ? kept.now.patience / 2 : kept.now.patience;
  }
  SolveReport iterate(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms, Kept& kept);
  SolveReport conjugateGradients(const SystemMatrix& matrix, ConstRows b, Rows x, int most, Kept& kept, double& began);
  SolveReport minimalResiduals(const SystemMatrix& matrix, ConstRows b, Rows x, int most, Kept& kept);

  Link<DirectSolver> factors_{"direct solver"};
  DirectSolver* direct_ = nullptr;          ///< null: none in the scene, and not needed so far
  std::unique_ptr<Component> own_factors_;  ///< what direct_ is where the scene has none
  std::string choice_;
  int changes_ = 0;
  int most_expected_ = 0;  ///< iterations of a solve to the tolerance
  PerMatrix<Kept> kept_;
};

void AutomaticLinearSolver::declare(DataTable& table) {
  KrylovSolver::declare(table);
  table.addLink("directSolver", factors_)
      .help("what factors; without it, the direct solver of the same node, or one of its own once factors are wanted");
  table.add("choice", choice_).help("what was chosen, and why").output();
  table.add("changes", changes_).help("how often a choice proved wrong and was changed").unit("-").output();
}

void AutomaticLinearSolver::init() {
  expected_iterations_ = 15;
  KrylovSolver::init();
  most_expected_ = expected_iterations_;
  if (hasFactorsInScene()) direct_ = &factorSource(*this, factors_);
}

bool AutomaticLinearSolver::hasFactorsInScene() const {
  const auto& components = node().components();
  return !factors_.path.empty() || std::any_of(components.begin(), components.end(), [](const auto& component) {
    return dynamic_cast<const DirectSolver*>(component.get()) != nullptr;
  });
}

AutomaticLinearSolver::Kept& AutomaticLinearSolver::keptFor(SystemMatrix& matrix) {
  Kept& kept = kept_.of(matrix);
  if (kept.now.way == Way::open) chooseFor(matrix, kept);
  return kept;
}

void AutomaticLinearSolver::chooseFor(SystemMatrix& matrix, Kept& kept) {
  const Index rows = matrix.rows();
  kept.now = {.way = Way::factors};
  kept.symmetric = matrix.symmetric();
  kept.reason = fmt::format("{} nodes are few", rows);
  if (rows >= always_factored && (!direct_ || rows <= direct_->mostRows())) {
    const Extents extents = extentsOf(rows, matrix.positions());
    const int solves = matrixDependsOnState(node().root()) ? usual_solves : 1;
    const auto costsOf = [&](const FactorCounts& counts) {
      return solverCosts(matrix.pattern(), counts, matrix.productCost(), solves);
    };
    SolverCosts costs = costsOf(factorCountsOf(extents));
    if (isClose(costs)) costs = costsOf(fewer(countFactors(matrix.pattern()), factorCountsOf(extents)));
    kept.reason =
        fmt::format("{} nodes, {:.0f} x {:.0f} x {:.0f}, estimated {:.2g} s with factors of {:.2g} GB, {:.2g} s with multigrid",
                    rows, extents.length, extents.width, extents.height, costs.direct, 8e-9 * costs.factor_entries,
                    costs.multigrid);
    if (costs.multigrid < costs.direct)
      kept.now = {.way = Way::multigrid,
                  .patience = costs.patience(),
                  .is_close = costs.direct < IterationCosts::with_patches * costs.multigrid};
  }
  if (kept.now.way == Way::factors) factors();
  tellChoice(kept);
}

void AutomaticLinearSolver::tellChoice(const Kept& kept) {
  if (kept.now.lost_iterations > 0)
    choice_ = fmt::format("{} factors, after {} iterations with multigrid left a residual of {:.2g}", direct_->type(),
                          kept.now.lost_iterations, kept.now.left);
  else if (kept.now.way == Way::factors)
    choice_ = fmt::format("{} factors: {}{}", direct_->type(), kept.reason,
                          kept.now.is_rough ? ", but diagonal blocks hardly smooth" : "");
  else
    choice_ = fmt::format("{} with multigrid: {}", kept.symmetric ? "conjugate gradients" : "GMRES", kept.reason);
  changes_ = 0;
  kept_.forEach([this](const Kept& each) { changes_ += each.now.lost_iterations > 0; });
}

SolveReport AutomaticLinearSolver::iterate(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms,
                                           Kept& kept) {
  constexpr int few_iterations = 8;  // of a loose solve
  expected_iterations_ = terms.relative_residual > tolerance() ? std::min(few_iterations, most_expected_) : most_expected_;
  SolveReport report;
  if (!begin(matrix, b, x, terms, report)) return report;
  SolveReport prepared;
  if (!kept.inverse.follow(matrix, prepared, terms.stop)) {
    prepared.relative_residual = 1;
    return prepared;
  }
  const int most = std::min(iterations_, patienceOf(kept));
  double began = 1;
  report = kept.symmetric ? conjugateGradients(matrix, b, x, most, kept, began) : minimalResiduals(matrix, b, x, most, kept);
  if (report.stop != SolveStop::stopped) kept.inverse.solved(report, began);
  return report;
}

/// `began` becomes the |r| / |b| of where it begins. Where rows turn, r.B r measures what is left, B the multigrid.
SolveReport AutomaticLinearSolver::conjugateGradients(const SystemMatrix& matrix, ConstRows b, Rows x, int most, Kept& kept,
                                                      double& began) {
  const auto multiply = [&](ConstRows p, Rows out) { product(matrix, p, out); };
  const auto precondition = [&](ConstRows r, Rows z) { kept.inverse.apply(r, z); };
  const auto note = [&](double residual) { record(residual / norm_b_); };
  kept.work.resize(b.count);
  began = kept.former.begin(multiply, b, norm_b_, kept.work, x);
  bool by_inverse = matrix.hasTurns();
  if (by_inverse) {
    precondition(b, kept.work.z.rows());
    const double square = cg::inner(b, kept.work.z);
    by_inverse = square > 0 && std::isfinite(square);
    if (by_inverse) norm_b_ = std::sqrt(square);
  }
  const cg::Limits limits{most, target(), terms_.stop, by_inverse};
  SolveReport report = cg::preconditioned(multiply, precondition, note, limits, b, kept.work, x, began < 1);
  if (report.stop == SolveStop::converged) kept.former.solved(x);
  report.relative_residual /= norm_b_;
  return report;
}

/// Where rows turn, of S A x = S b with the scales S of the rows.
SolveReport AutomaticLinearSolver::minimalResiduals(const SystemMatrix& matrix, ConstRows b, Rows x, int most, Kept& kept) {
  kept.scales.take(matrix);
  const bool is_scaled = !kept.scales.empty();
  if (is_scaled)
    for (Vector* vector : {&kept.unscaled, &kept.right_side})
      if (vector->count() != b.count) vector->resize(b.count);
  const auto multiply = [&](ConstRows p, Rows out) {
    product(matrix, p, out);
    kept.scales.multiply(out);
  };
  const auto precondition = [&](ConstRows r, Rows z) {
    if (!is_scaled) return kept.inverse.apply(r, z);
    copy(r, kept.unscaled);
    kept.scales.divide(kept.unscaled);
    kept.inverse.apply(kept.unscaled, z);
  };
  ConstRows right_side = b;
  if (is_scaled) {
    copy(b, kept.right_side);
    kept.scales.multiply(kept.right_side);
    right_side = kept.right_side;
    norm_b_ = norm(right_side);
  }
  const auto note = [&](double residual) { record(residual / norm_b_); };
  kept.space.resize(b.count);
  SolveReport report = gmres::solve(multiply, precondition, note, {most, target(), terms_.stop}, right_side, kept.space, x);
  report.relative_residual /= norm_b_;
  return report;
}

SolveReport AutomaticLinearSolver::solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms) {
  Kept& kept = keptFor(matrix);
  if (std::exchange(kept.now.is_close, false) && amg::hardlySmooths(matrix.assemble())) {
    kept.now = {.way = Way::factors, .is_rough = true};
    factors();
    tellChoice(kept);
  }
  if (kept.now.way == Way::factors) return factors().solve(matrix, b, x, terms);
  if (const bool now = matrix.symmetric(); now != kept.symmetric) {
    kept.symmetric = now;
    tellChoice(kept);
  }
  constexpr double little = 1e-6;
  const auto isHopeless = [&](const SolveReport& solve) {
    if (solve.stop == SolveStop::iteration_limit) return solve.iterations == patienceOf(kept);
    // factors would leave as much, or half of it
    return solve.stop == SolveStop::stagnated && solve.relative_residual > std::max(little, 2 * roundOff(matrix, b, x));
  };
  SolveReport report = iterate(matrix, b, x, terms, kept);
  bool is_hopeless = isHopeless(report);
  if (is_hopeless && kept.inverse.giveUp()) {  // the hierarchy was that of another matrix
    const int before = report.iterations;
    report = iterate(matrix, b, x, terms, kept);
    is_hopeless = isHopeless(report);
    report.iterations += before;
  }
  if (!is_hopeless) return report;
  kept.now = {.way = Way::factors, .lost_iterations = report.iterations, .left = report.relative_residual};
  kept.inverse.reset(), kept.former.reset();
  factors();
  tellChoice(kept);
  clear(x);
  SolveReport again = direct_->solve(matrix, b, x, terms);
  again.iterations += report.iterations;
  return again;
}

void AutomaticLinearSolver::serializeFor(SystemMatrix& matrix, Archive& archive) {
  Kept& kept = keptFor(matrix);
  archive.value("way", kept.now.way);
  archive.value("patience", kept.now.patience);
  archive.value("is_close", kept.now.is_close);
  archive.value("is_rough", kept.now.is_rough);
  archive.value("lost_iterations", kept.now.lost_iterations);
  archive.value("left", kept.now.left);
  kept.inverse.serialize(matrix, archive, !archive.isReading() && !matrixDependsOnState(node().root()));
  kept.former.serialize(archive);
  if (kept.now.way == Way::factors) factors().serializeFor(matrix, archive);
  if (archive.isReading()) tellChoice(kept);
}

void AutomaticLinearSolver::keepFor(SystemMatrix& matrix) {
  Kept& kept = keptFor(matrix);
  kept.before_step = kept.now;
  kept.inverse.keep(matrix), kept.former.keep();
  if (direct_) direct_->keepFor(matrix);
}

void AutomaticLinearSolver::takeBackFor(SystemMatrix& matrix) {
  Kept& kept = keptFor(matrix);
  kept.now = kept.before_step;
  kept.inverse.takeBack(matrix), kept.former.takeBack();
  if (direct_) direct_->takeBackFor(matrix);
  tellChoice(kept);
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(automatic_linear_solver) {
  factory.add<stroma::AutomaticLinearSolver>("AutomaticLinearSolver",
                                             "factors or conjugate gradients with multigrid, whichever costs less");
}
