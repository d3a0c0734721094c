// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/mixed_solve.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace stroma {

class MixedSolve::Compressible final : public SystemMatrix {
 public:
  /// Both are to outlive it; `positions` of the nodes.
  void show(SystemMatrix& matrix, const PressureRows& volumes, ConstRows positions) {
    matrix_ = &matrix, volumes_ = &volumes, positions_ = positions;
  }
  /// Frees what assemble() has made.
  void forget() { values_ = {}; }
  MatrixKey key() const override {
    MatrixKey key = matrix_->key();
    key.matrix = identity().get();
    return key;
  }
  Index rows() const override { return matrix_->rows(); }
  void multiply(ConstRows p, Rows out) const override { values_.multiply(p, out); }
  const BlockMatrix& assemble() override {
    values_ = matrix_->assemble();
    volumes_->subtractFrom(values_);
    return values_;
  }
  const BlockMatrix& pattern() override { return matrix_->pattern(); }
  void diagonalBlocks(std::vector<double>& blocks) const override {
    matrix_->diagonalBlocks(blocks);
    volumes_->subtractFrom(blocks);
  }
  bool symmetric() const override { return true; }
  bool prefersAssembled(int) const override { return true; }
  double assemblyCost() const override { return matrix_->assemblyCost(); }
  ConstRows positions() const override { return positions_; }
  bool isOfLooseNodes() const override { return matrix_->isOfLooseNodes(); }
  std::string describeRow(Index row) const override { return matrix_->describeRow(row); }

 private:
  SystemMatrix* matrix_ = nullptr;
  const PressureRows* volumes_ = nullptr;
  ConstRows positions_;
  BlockMatrix values_;
};

MixedSolve::MixedSolve() : compressible_(std::make_unique<Compressible>()) {}
MixedSolve::~MixedSolve() = default;

void MixedSolve::reset() {
  key_ = {}, inverse_.reset(), volumes_.reset();
  factors_ = nullptr, has_positions_ = false;
}

bool MixedSolve::giveUp() {
  const bool is_old = inverse_.giveUp();
  if (is_old) reset();
  return is_old;
}

void MixedSolve::serialize(Archive& archive) {
  bool exists = factors_ || has_positions_;
  archive.value("has_pressures", exists);
  if (archive.isReading()) reset();
  if (!exists) return;
  archive.rows("pressure_positions", positions_);
  if (archive.isReading()) has_positions_ = true;
}

/// Brings everything up to date with the matrix. False: the report says why.
bool MixedSolve::follow(const Equations& of, SolveReport& report, StopToken stop) {
  if (factors_ && key_ == of.matrix.key()) return true;
  key_ = {}, nodes_ = of.matrix.rows();
  auto volumes = std::make_unique<PressureRows>(of.terms(), nodes_);
  if (volumes->count() == 0) {
    report.stop = SolveStop::breakdown;
    return false;
  }
  if (!volumes_ || !volumes_->isLike(*volumes)) inverse_.reset();
  volumes_ = std::move(volumes);
  ConstRows positions = of.matrix.positions();
  if (std::exchange(has_positions_, false) && positions_.count() == positions.count) positions = positions_;
  compressible_->show(of.matrix, *volumes_, positions);
  const int made = inverse_.made();
  const bool has_inverse = inverse_.follow(*compressible_, report, stop);
  compressible_->forget();
  std::vector<double> diagonal;
  if (!has_inverse || !takeDiagonal(diagonal, report)) return false;
  if (inverse_.made() != made) {
    if (positions.data != positions_.rows().data) positions_.resize(positions.count), copy(positions, positions_);
    if (!factor(diagonal, of.factors, report, stop)) return false;
  }
  allocate();
  key_ = of.matrix.key();
  return true;
}

/// D, and the weight that makes both parts of a residual forces.
bool MixedSolve::takeDiagonal(std::vector<double>& blocks, SolveReport& report) {
  compressible_->diagonalBlocks(blocks);
  if ((report.row = diagonal_.factor(blocks)) >= 0) {
    report.stop = SolveStop::not_definite;
    return false;
  }
  double stiffness = 0;
  for (const double number : blocks) stiffness += std::abs(number) / double(blocks.size());
  weight_ = stiffness / volumes_->meanGradient();
  return true;
}

bool MixedSolve::factor(const std::vector<double>& diagonal, DirectSolver& factors, SolveReport& report, StopToken stop) {
  std::vector<Mat3> inverse;
  for (std::size_t at = 0; at < diagonal.size(); at += 9) inverse.push_back(Eigen::Map<const Mat3>(diagonal.data() + at).inverse());
  x_ = volumes_->products(inverse);
  shown_x_.show(x_, true);
  return (factors_ = factors.factor(shown_x_, report, stop)) != nullptr;
}

void MixedSolve::allocate() {
  const Index rows = volumes_->rows(), all = nodes_ + rows;
  if (both_.count() != all) {
    basis_.clear(), steps_.clear();
    for (Vector* each : {&both_, &trial_}) each->resize(all);
  }
  for (Vector* each : {&forces_, &moved_})
    if (each->count() != nodes_) each->resize(nodes_);
  for (Vector* each : {&pressures_, &sums_})
    if (each->count() != rows) each->resize(rows);
}

/// p = T r; r is in pressures_, which changes.
void MixedSolve::applyInverseSchur(const Product& product, ConstRows r, Rows p) {
  factors_->applyRoughly(r, sums_);
  copy(sums_, pressures_);  // r is not read again
  clear(forces_);
  volumes_->addForces(1, pressures_, forces_);
  diagonal_.apply(forces_, moved_);
  product(moved_.rows(), forces_.rows());  // A = K - B^T E B
  volumes_->volumes(moved_, sums_);
  volumes_->multiplyByExcess(sums_);
  volumes_->addForces(-1, sums_, forces_);
  volumes_->multiplyByLaplacian(pressures_, moved_, sums_);
  volumes_->multiplyByExcess(sums_);
  volumes_->multiplyByLaplacian(sums_, moved_, pressures_);
  diagonal_.apply(forces_, moved_);
  volumes_->volumes(moved_, sums_);
  axpy(1, pressures_, sums_);
  factors_->applyRoughly(sums_, p);
}

/// out = (A u + B^T p, weight (B u - E^-1 p)), A = K - B^T E B
void MixedSolve::multiply(const Product& product, ConstRows in, Rows out) {
  const Index rows = volumes_->rows();
  const Rows above = out.head(nodes_), below = out.segment(nodes_, rows);
  product(in.head(nodes_), above);
  volumes_->volumes(in.head(nodes_), below);
  copy(in.segment(nodes_, rows), pressures_), copy(below, sums_);
  volumes_->multiplyByExcess(sums_);
  axpy(-1, sums_, pressures_);
  volumes_->addForces(1, pressures_, above);
  volumes_->divideByExcess(pressures_);
  copy(pressures_, below);
  scale(-weight_, below);
}

/// z = (V (r_u - B^T p), p), p = -T r_p
void MixedSolve::precondition(const Product& product, ConstRows r, Rows z) {
  const Rows p = z.segment(nodes_, volumes_->rows());
  copy(r.segment(nodes_, volumes_->rows()), pressures_);
  scale(-1 / weight_, pressures_);
  applyInverseSchur(product, pressures_, p);
  copy(r.head(nodes_), forces_);
  volumes_->addForces(-1, p, forces_);
  inverse_.apply(forces_, z.head(nodes_));
}

/// |b - K x|; b - K x is in forces_.
double MixedSolve::residualOf(const Equations& of, ConstRows x) {
  of.product(x, moved_.rows());
  copy(of.b, forces_);
  return std::sqrt(cg::reduceResidual(1, moved_, forces_));
}

/// One space: both_ becomes the best of it. |b - K u| of both_ is report.relative_residual, before and after. The space ends at the
/// target, when it is full, or when three checks in a row have not halved that residual. A reason: it cannot go on.
std::optional<SolveStop> MixedSolve::descend(const Equations& of, const cg::Limits& limits, SolveReport& report) {
  constexpr std::size_t restart = 60;
  constexpr int most_useless = 3;
  const double before = report.relative_residual, beta = norm(basis_[0]);
  scale(1 / beta, basis_[0]);
  gmres::Triangle triangle(beta);
  double check = beta * std::min(0.5, limits.residual / before), least = before;
  for (int useless = 0;;) {
    if (limits.stop.isStopAsked()) return SolveStop::stopped;
    const std::size_t j = triangle.size();
    Vector &step = vectorOf(steps_, j), &next = vectorOf(basis_, j + 1);
    precondition(of.product, basis_[j], step);
    multiply(of.product, step, next);
    ++report.iterations;
    std::vector<double> column;
    for (std::size_t i = 0; i <= j; ++i) {
      column.push_back(cg::inner(next, basis_[i]));
      axpy(-column[i], basis_[i], next);
    }
    const double length = norm(next);
    if (!std::isfinite(length)) return SolveStop::not_finite;
    if (!triangle.add(std::move(column), length)) return SolveStop::breakdown;
    if (length > 0) scale(1 / length, next);
    of.note(before * std::min(1.0, triangle.residual() / beta));
    const bool is_full = triangle.size() == restart || report.iterations >= limits.iterations || length == 0;
    if (!is_full && triangle.residual() > check) continue;
    copy(both_, trial_);
    const std::vector<double> y = triangle.solution();
    for (std::size_t i = 0; i < y.size(); ++i) axpy(y[i], steps_[i], trial_);
    const double left = residualOf(of, trial_.head(nodes_));
    useless = left > 0.5 * least ? useless + 1 : 0;
    least = std::min(least, left);
    if (left <= limits.residual || is_full || useless == most_useless) {
      std::swap(both_, trial_);
      report.relative_residual = left;
      return std::nullopt;
    }
    check = triangle.residual() * std::clamp(0.9 * limits.residual / left, 0.01, 0.5);
  }
}

/// From the x given to |b - K x| <= limits.residual, which the report has instead of the relative one.
SolveReport MixedSolve::iterate(const Equations& of, const cg::Limits& limits, Rows x) {
  constexpr double least_gain = 0.5;  // of a whole space
  SolveReport report;
  clear(both_);
  copy(x, both_.head(nodes_));
  vectorOf(basis_, 0);
  for (double before = std::numeric_limits<double>::infinity();;) {
    const double now = report.relative_residual = residualOf(of, both_.head(nodes_));
    if (!(now > limits.residual) || now > least_gain * before || report.iterations >= limits.iterations) {
      report.stop = !std::isfinite(now)                      ? SolveStop::not_finite
                    : now <= limits.residual                 ? SolveStop::converged
                    : report.iterations >= limits.iterations ? SolveStop::iteration_limit
                                                             : SolveStop::stagnated;
      break;
    }
    // with p = E B u the lower part of the residual is zero, and the upper one is that of K
    const Rows pressures = both_.rows().segment(nodes_, volumes_->rows());
    volumes_->volumes(both_.head(nodes_), pressures);
    volumes_->multiplyByExcess(pressures);
    clear(basis_[0]);
    copy(forces_, basis_[0].head(nodes_));
    before = now;
    if (const auto stop = descend(of, limits, report)) {
      report.stop = *stop;
      break;
    }
  }
  copy(both_.head(nodes_), x);
  return report;
}

SolveReport MixedSolve::solve(const Equations& of, int iterations, double tolerance, StopToken stop, Rows x) {
  const double norm_b = norm(of.b);
  const cg::Limits limits{std::min(iterations, most_iterations), tolerance * norm_b, stop};
  int done = 0;
  for (;;) {
    SolveReport report{.relative_residual = 1};
    const bool is_ready = follow(of, report, stop);
    if (is_ready) {
      const auto iterateTo = [&](const cg::Limits& now) { return iterate(of, now, x); };
      report = of.light.solveAll(of.matrix, limits, tolerance, iterateTo, [&] { return forces_.rows(); }, x);
      report.relative_residual /= norm_b;
    }
    report.iterations = done += report.iterations;
    report.factored = false;  // not K: whoever wants its factors for more would wait for them
    if (!is_ready || report.stop == SolveStop::stopped) return report;
    if (report.stop == SolveStop::converged || !giveUp()) {
      inverse_.solved(report);
      return report;
    }
    if (!std::isfinite(report.relative_residual)) clear(x);
  }
}

}  // namespace stroma
