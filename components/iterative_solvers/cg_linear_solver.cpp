// SPDX-License-Identifier: LGPL-2.1-or-later
// CGLinearSolver: conjugate gradients for A x = b with A symmetric and positive definite (Hestenes and Stiefel 1952).
//
//   q = A p,  alpha = r.z / p.q,  x += alpha p,  r -= alpha q,  z = D^-1 r,  beta = r.z / (r.z)_before,  p = z + beta p
//
// z = r without a preconditioner; with block_jacobi, D holds the 3x3 diagonal blocks of A. Where `preconditioner` is not
// written, a scene that writes `iterations`, as SOFA's do, has none, and every other one has block_jacobi. The product
// A p is matrix-free (each force field multiplies from its elements) or uses the assembled matrix: `template`
// GraphScattered forces the first, CompressedRowSparseMatrix the second, and auto takes the cheaper one for
// `iterations` products by the cost that the force fields state.
//
// It stops when |r| <= tolerance |b| and max |D^-1 r| <= max(tolerance, 1e-3) max |x|, without which bodies that are far lighter than
// others would stay where they are (there, none goes on with block_jacobi); after `iterations` products (a scene that must keep a
// frame rate writes them; the run says how far the residual was then from the tolerance, and a strict run takes that for a doubt);
// when b = 0; when a number is not finite; and when the matrix shows itself to be singular or not definite, |p.A p| <= threshold^2 |p|
// |A p| or p.A p < 0: x then keeps the last iterate, the best one in the energy of A. SOFA compares p.A p itself with `threshold`, a
// test whose outcome depends on the units of the scene and which can stop a well-posed solve at its first iteration (nothing then
// moves). Here it is the cosine between p and A p, which no units enter; with the default it passes for every matrix of condition
// number below 4e20. All other iterates are those of SOFA's solver. SOFA's test is there too: with absoluteThreshold t above zero,
// iteration k ends when |r| <= tolerance |b| or, before x moves, when |p.A p| <= t; in the first solve of a run neither ends the first
// iteration. Scenes in SOFA's dialect have it, and then a matrix that is not symmetric is taken as it is. Where some rows are turns,
// of rigid frames, r holds forces and torques, and |r| would depend on the unit of length: there it is the root of r.D^-1 r, and |b|
// likewise, but for SOFA's test. With `bodies` the rows below each of these nodes have alpha, beta and ends of their own, as where
// SOFA gives each body a solver. Nothing may tie them in the matrix: the first solve refuses what does.
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
#include <limits>

#include "components/iterative_solvers/bodies_apart.h"
#include "components/iterative_solvers/conjugate_gradients.h"
#include "components/iterative_solvers/krylov_solver.h"
#include "components/iterative_solvers/light_rows.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

enum class CGPreconditioner { automatic, none, block_jacobi };

class CGLinearSolver final : public KrylovSolver {
 public:
  void declare(DataTable& table) override;
  void init() override;
  SolveReport solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms) override;
  /// SOFA's takes what comes, which a pressure on a surface with a free rim makes a little unsymmetric.
  bool needsSymmetric() const override { return !data().find("absoluteThreshold")->isSet(); }
  void serializeFor(SystemMatrix& matrix, Archive& archive) override {
    if (warm_start_) archive.rows("previous", keptFor(matrix, matrix.rows()).previous);
    if (absolute_threshold_ > 0 || !bodies_.empty()) archive.value("has_solved", keptFor(matrix, matrix.rows()).has_solved);
  }
  void keepFor(SystemMatrix& matrix) override {
    Kept& kept = keptFor(matrix, matrix.rows());
    kept.had_solved = kept.has_solved;
    if (warm_start_) copy(kept.previous, kept.before_step);
  }
  void takeBackFor(SystemMatrix& matrix) override {
    Kept& kept = keptFor(matrix, matrix.rows());
    kept.has_solved = kept.had_solved;
    if (warm_start_) copy(kept.before_step, kept.previous);
  }
  void reset() override {
    kept_.forEach([](Kept& kept) { kept.previous.resize(kept.previous.count()), kept.has_solved = false; });
  }

 private:
  /// The rows of a body, and where its own iterations are.
  struct Part {
    std::vector<std::pair<Index, Index>> rows;  ///< first and count
    double enough = 0, residual = 0, before = 0;
    bool ended = false;
    double inner(ConstRows a, ConstRows b) const;
    bool begin(bool must_go_on, ConstRows r, Rows p);
    bool go(double threshold, ConstRows p, ConstRows q, Rows r, Rows x);
  };
  /// For each matrix: work space, the last solution and the inverses of the diagonal blocks.
  struct Kept {
    Vector r, p, q, z, previous;
    Vector before_step;  ///< `previous` then
    std::vector<double> blocks;
    cg::BlockJacobi jacobi;
    MatrixKey jacobi_key;
    Index bad_block = -1;
    bool is_scaled = false;  ///< residuals of the solve are measured by the blocks
    LightRows light;
    std::vector<Part> parts;  ///< with `bodies`
    bool has_solved = false;  ///< since the start of the run
    bool had_solved = false;  ///< before the step
  };
  Kept& keptFor(const SystemMatrix& matrix, Index rows);
  void prepare(const SystemMatrix& matrix, Kept& kept);
  SolveReport iterate(const SystemMatrix& matrix, Kept& kept, Rows x, double residual);
  SolveReport iterateAbsolutely(const SystemMatrix& matrix, Kept& kept, Rows x, double residual);
  void findParts(SystemMatrix& matrix, Kept& kept) const;
  SolveReport iterateApart(const SystemMatrix& matrix, Kept& kept, ConstRows b, Rows x);

  double threshold_ = 1e-5, absolute_threshold_ = 0;
  bool warm_start_ = false;
  std::vector<std::string> bodies_;
  CGPreconditioner preconditioner_ = CGPreconditioner::automatic;
  bool precondition_ = false;
  PerMatrix<Kept> kept_;
};

void CGLinearSolver::declare(DataTable& table) {
  KrylovSolver::declare(table);
  table.add("threshold", threshold_)
      .atOnce()
      .help("stop as broken down when |p.A p| <= threshold^2 |p| |A p| (relative, unlike SOFA's)")
      .unit("-")
      .min(0)
      .max(1e-2);
  table.add("absoluteThreshold", absolute_threshold_)
      .help("above zero: stop when |p.A p| is not above it, as SOFA does; it depends on the units of the scene")
      .unit("J")
      .min(0);
  table.add("bodies", bodies_)
      .help("paths of nodes below which rows are solved for apart from all others, with ends as of absoluteThreshold; nothing may tie "
            "them in the matrix");
  table.add("warmStart", warm_start_).help("start from the solution of the previous solve");
  table.addChoice("preconditioner", preconditioner_, {"auto", "none", "block_jacobi"})
      .help(
          "none has SOFA's iterates; block_jacobi divides by the 3x3 diagonal blocks; auto is none where the scene "
          "writes iterations, else block_jacobi");
}

void CGLinearSolver::init() {
  KrylovSolver::init();
  if (absolute_threshold_ > 0 && preconditioner_ == CGPreconditioner::block_jacobi)
    throw ComponentError("absoluteThreshold is a test of plain conjugate gradients", "preconditioner=\"none\"");
  precondition_ = preconditioner_ == CGPreconditioner::block_jacobi ||
                  (preconditioner_ == CGPreconditioner::automatic && !data().find("iterations")->isSet());
  if (!bodies_.empty() && precondition_)
    throw ComponentError("bodies are solved for apart by plain conjugate gradients", "preconditioner=\"none\"");
  checkBodies(node().root(), bodies_);
}

CGLinearSolver::Kept& CGLinearSolver::keptFor(const SystemMatrix& matrix, Index rows) {
  Kept& kept = kept_.of(matrix);
  if (kept.r.count() == rows) return kept;
  for (Vector* vector : {&kept.r, &kept.p, &kept.q}) vector->resize(rows);
  if (precondition_ || matrix.hasTurns()) kept.z.resize(rows);
  if (warm_start_) kept.previous.resize(rows), kept.before_step.resize(rows);
  kept.jacobi_key = {};
  kept.parts.clear();
  return kept;
}

void CGLinearSolver::prepare(const SystemMatrix& matrix, Kept& kept) {
  const bool may_scale = bodies_.empty() && absolute_threshold_ == 0 && matrix.hasTurns();
  kept.is_scaled = may_scale && kept.bad_block < 0;
  if (!(precondition_ || may_scale) || kept.jacobi_key == matrix.key()) return;
  matrix.diagonalBlocks(kept.blocks);
  kept.bad_block = kept.jacobi.factor(kept.blocks);
  kept.jacobi_key = matrix.key();
  kept.is_scaled = may_scale && kept.bad_block < 0;
  if (kept.bad_block < 0) kept.light.know(kept.jacobi_key, kept.blocks, kept.jacobi);
}

SolveReport CGLinearSolver::iterate(const SystemMatrix& matrix, Kept& kept, Rows x, double residual) {
  Vector &r = kept.r, &p = kept.p, &q = kept.q, &z = kept.z;
  SolveReport report;
  const cg::BlockJacobi* blocks = precondition_ ? &kept.jacobi : nullptr;
  double rho = blocks ? blocks->apply(r, z) : kept.is_scaled ? cg::inner(r, r) : residual;
  copy(precondition_ ? z.rows() : r.rows(), p);
  const double enough = target();
  constexpr double none = std::numeric_limits<double>::infinity();
  // between turns and torques the cosine has a unit
  const double of_other_units = 1e-12;
  double smallest_cosine = threshold_ * threshold_ * (kept.is_scaled ? of_other_units : 1);
  for (;;) {
    product(matrix, p, q);
    ++report.iterations;
    const cg::Curvature curve = cg::curvature(p, q);
    if (!std::isfinite(curve.pq)) {
      report.stop = SolveStop::not_finite;
      break;
    }
    if (curve.pq <= smallest_cosine * std::sqrt(curve.pp) * std::sqrt(curve.qq)) {
      const bool negative = curve.pq < -1e-14 * std::sqrt(curve.pp) * std::sqrt(curve.qq);
      report.stop = negative ? SolveStop::not_definite : SolveStop::breakdown;
      break;
    }
    double alpha = rho / curve.pq;
    const double square = cg::reduceResidual(alpha, q, r);
    const double in_blocks = kept.is_scaled ? kept.jacobi.apply(r, z) : 0;
    residual = kept.is_scaled ? in_blocks : square;
    record(std::sqrt(residual) / norm_b_);
    if (!std::isfinite(residual)) {
      report.stop = SolveStop::not_finite;
      break;
    }
    const bool converged = std::sqrt(residual) <= enough;
    if (!converged && isStopAsked()) {
      report.stop = SolveStop::stopped;
      break;
    }
    double rho_before = rho;
    if (converged || report.iterations == iterations_) {
      axpy(alpha, p, x);
      const bool goes_on = converged && kept.light.areLeft(matrix, enough / norm_b_, r, x);
      const bool is_stopped = goes_on && isStopAsked();
      report.stop = is_stopped ? SolveStop::stopped : converged && !goes_on ? SolveStop::converged : SolveStop::iteration_limit;
      if (!goes_on || is_stopped || report.iterations == iterations_) break;
      alpha = 0, smallest_cosine = threshold_ * threshold_ * of_other_units;  // and between bodies of other masses
      if (!blocks) {  // anew, by the blocks
        if (z.count() != r.count()) z.resize(r.count());
        blocks = &kept.light.inverse(), rho_before = none;
      }
    }
    rho = !blocks ? square : kept.is_scaled ? in_blocks : blocks->apply(r, z);
    cg::advance(alpha, rho / rho_before, blocks ? z.rows() : r.rows(), p, x);
  }
  report.relative_residual = std::sqrt(residual) / norm_b_;
  return report;
}

/// SOFA's loop, with its ends in its order.
SolveReport CGLinearSolver::iterateAbsolutely(const SystemMatrix& matrix, Kept& kept, Rows x, double residual) {
  Vector &r = kept.r, &p = kept.p, &q = kept.q;
  SolveReport report;
  const bool is_first_solve = !kept.has_solved;
  kept.has_solved = true;
  double rho_before = 0;
  report.stop = SolveStop::iteration_limit;
  for (int k = 1; k <= iterations_; ++k) {
    const bool must_go_on = is_first_solve && k == 1;
    report.stop = SolveStop::converged;
    if (std::sqrt(residual) <= target() && !must_go_on) break;
    report.stop = isStopAsked() ? SolveStop::stopped : SolveStop::not_finite;
    if (isStopAsked() || !std::isfinite(residual)) break;
    if (k == 1)
      copy(r, p);
    else
      scale(residual / rho_before, p), axpy(1, r, p);
    product(matrix, p, q);
    report.iterations = k;
    const double curve = dot(p, q);
    report.stop = SolveStop::iteration_limit;
    if (std::abs(curve) <= absolute_threshold_ && !must_go_on) break;
    if (curve == 0) break;
    const double alpha = residual / curve;
    axpy(alpha, p, x);
    rho_before = residual;
    residual = cg::reduceResidual(alpha, q, r);
    record(std::sqrt(residual) / norm_b_);
  }
  report.relative_residual = std::sqrt(residual) / norm_b_;
  return report;
}

/// Rows of states below none of `bodies` are a part of their own. Refuses what ties parts in the matrix.
void CGLinearSolver::findParts(SystemMatrix& matrix, Kept& kept) const {
  kept.parts.assign(bodies_.size() + 1, {});
  std::vector<std::size_t> part_of;
  for (Index row = 0; row < kept.r.count(); ++row) {
    const std::string text = matrix.describeRow(row);  // "node 3 of /body/dofs"
    const std::string_view path = std::string_view(text).substr(std::min(text.size(), text.find('/')));
    std::size_t part = 0;
    while (part < bodies_.size() && !path.starts_with(bodies_[part] + "/")) ++part;
    part_of.push_back(part);
    auto& rows = kept.parts[part].rows;
    if (rows.empty() || rows.back().first + rows.back().second != row) rows.push_back({row, 0});
    ++rows.back().second;
  }
  std::erase_if(kept.parts, [](const Part& part) { return part.rows.empty(); });
  refuseTies(matrix, part_of, where().text() + ": " + path());
}

double CGLinearSolver::Part::inner(ConstRows a, ConstRows b) const {
  double sum = 0;
  for (const auto& [first, count] : rows) sum += dot(a.segment(first, count), b.segment(first, count));
  return sum;
}

/// p = r + beta p, or 0 where it ends; false: it ends.
bool CGLinearSolver::Part::begin(bool must_go_on, ConstRows r, Rows p) {
  ended = ended || (std::sqrt(residual) <= enough && !must_go_on) || !std::isfinite(residual);
  for (const auto& [first, count] : rows) {
    const Rows own = p.segment(first, count);
    ended ? clear(own) : xpay(r.segment(first, count), before == 0 ? 0 : residual / before, own);
  }
  return !ended;
}

/// False: it ends before x moves.
bool CGLinearSolver::Part::go(double threshold, ConstRows p, ConstRows q, Rows r, Rows x) {
  const double curve = inner(p, q);
  ended = std::abs(curve) <= threshold || curve == 0;
  if (ended) return false;
  for (const auto& [first, count] : rows) {
    axpy(residual / curve, p.segment(first, count), x.segment(first, count));
    axpy(-residual / curve, q.segment(first, count), r.segment(first, count));
  }
  before = residual, residual = inner(r, r);
  return true;
}

/// iterateAbsolutely() of each part, with their products at once.
SolveReport CGLinearSolver::iterateApart(const SystemMatrix& matrix, Kept& kept, ConstRows b, Rows x) {
  Vector &r = kept.r, &p = kept.p, &q = kept.q;
  const bool is_first_solve = !kept.has_solved;
  kept.has_solved = true;
  for (Part& part : kept.parts) {
    part.enough = target() / norm_b_ * std::sqrt(part.inner(b, b));
    part.residual = part.inner(r, r), part.before = 0;
    part.ended = part.residual == 0;
  }
  clear(p);
  SolveReport report;
  bool is_limited = false;
  for (int k = 1; k <= iterations_ && !isStopAsked(); ++k) {
    const bool must_go_on = is_first_solve && k == 1;
    bool goes_on = false;
    for (Part& part : kept.parts) goes_on = part.begin(must_go_on, r, p) || goes_on;
    if (!goes_on) break;
    product(matrix, p, q);
    report.iterations = k;
    for (Part& part : kept.parts)
      if (!part.ended) is_limited = !part.go(must_go_on ? 0 : absolute_threshold_, p, q, r, x) || is_limited;
    record(norm(r) / norm_b_);
  }
  for (const Part& part : kept.parts) is_limited = is_limited || !part.ended;
  report.relative_residual = norm(r) / norm_b_;
  report.stop = isStopAsked()                                ? SolveStop::stopped
                : !std::isfinite(report.relative_residual) ? SolveStop::not_finite
                : is_limited                                 ? SolveStop::iteration_limit
                                                             : SolveStop::converged;
  return report;
}

SolveReport CGLinearSolver::solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms) {
  SolveReport report;
  if (!begin(matrix, b, x, terms, report)) return report;
  Kept& kept = keptFor(matrix, b.count);
  prepare(matrix, kept);
  if (kept.bad_block >= 0 && precondition_) {
    report.stop = SolveStop::not_definite;
    report.row = kept.bad_block;
    report.relative_residual = 1;
    return report;
  }
  if (warm_start_) copy(kept.previous, x);
  double residual = KrylovSolver::residual(matrix, b, x, kept.r, kept.q);
  if (kept.is_scaled) {
    const double square = kept.jacobi.apply(b, kept.z);
    kept.is_scaled = square > 0 && std::isfinite(square);  // of numbers near the smallest there is no square
    if (kept.is_scaled) norm_b_ = std::sqrt(square);
  }
  if (kept.is_scaled) residual = kept.jacobi.apply(kept.r, kept.z);
  if (!bodies_.empty()) {
    if (kept.parts.empty()) findParts(matrix, kept);
    report = iterateApart(matrix, kept, b, x);
  } else if (absolute_threshold_ > 0 && !precondition_) {
    report = iterateAbsolutely(matrix, kept, x, residual);
  } else if (std::sqrt(residual) <= target() && !kept.light.areLeft(matrix, target() / norm_b_, kept.r, x)) {
    report.relative_residual = std::sqrt(residual) / norm_b_;
  } else {
    report = iterate(matrix, kept, x, residual);
  }
  if (warm_start_ && report.stop != SolveStop::not_finite && report.stop != SolveStop::stopped) copy(x, kept.previous);
  return report;
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(cg_linear_solver) {
  factory.add<stroma::CGLinearSolver>("CGLinearSolver", "conjugate gradients, matrix-free or assembled");
}
