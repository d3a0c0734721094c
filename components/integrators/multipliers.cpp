// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/multipliers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace stroma {

using Kind = LagrangianRows::Kind;

void Multipliers::compile(System& system) {
  system_ = &system;
  if (empty()) return;
  for (Vector* vector : {&start_, &work_}) vector->resize(system.allRows());
  for (Vector* vector : {&right_side_, &whole_, &before_, &free_}) vector->resize(system.independentRows());
}

void Multipliers::begin() {
  if (!empty()) copy(system_->mappingChain().positions(system_->x), start_);
}

void Multipliers::findConditions() {
  std::swap(rows_, old_rows_);
  rows_.clear();
  const ConstRows x = system_->mappingChain().positions(system_->x);
  for (const LagrangianConstraint* constraint : system_->actors().lagrangian_constraints)
    constraint->addConditions(x, start_, rows_);
  g_.resize(Eigen::Index(rows_.rows().size()));
  for (std::size_t i = 0; i < rows_.rows().size(); ++i) g_[Eigen::Index(i)] = rows_.rows()[i].value;
}

bool Multipliers::haveGradientsChanged() const {
  if (!system_->mappingChain().isLinear()) return true;  // what mapped points follow turns
  const auto &now = rows_.rows(), &before = old_rows_.rows();
  if (now.size() != before.size()) return true;
  for (std::size_t i = 0; i < now.size(); ++i) {
    const auto a = rows_.entriesOf(now[i]), b = old_rows_.entriesOf(before[i]);
    if (!std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& p, const auto& q) { return p.row == q.row && p.gradient == q.gradient; }))
      return true;
  }
  return false;
}

/// A^-1 J^T and W.
bool Multipliers::respond(LinearSolver& solver, SystemMatrix& matrix, double displacement, StopToken stop,
                          StepReport& report) {
  const auto& rows = rows_.rows();
  const MappingChain& chain = system_->mappingChain();
  const auto count = Eigen::Index(rows.size());
  responses_.resize(std::max(responses_.size(), rows.size()));
  w_.resize(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    Vector& response = responses_[std::size_t(i)];
    if (response.count() != system_->independentRows()) response.resize(system_->independentRows());
    clear(work_);
    for (const auto& [row, gradient] : rows_.entriesOf(rows[std::size_t(i)])) work_[row] += gradient;
    chain.pullBack(work_);
    copy(system_->independent(work_), right_side_);
    system_->constraints().project(right_side_);
    clear(response);
    const SolveReport solve = solver.solve(matrix, right_side_, response, {.stop = stop});
    report.linear_iterations += solve.iterations;
    report.factorisations += solve.factored;
    report.stopped = report.stopped || solve.stop == SolveStop::stopped;
    if (report.stopped) return false;
    if (!solve.usable() || solve.stop == SolveStop::breakdown) {
      report.diverged = true;
      report.reason = fmt::format("the linear solver {} {} for a force of constraint", solver.path(), describe(solve.stop));
      return false;
    }
    system_->constraints().project(response);
    const ConstRows along = chain.direction(response);
    for (Eigen::Index j = 0; j < count; ++j) {
      double sum = 0;
      for (const auto& [row, gradient] : rows_.entriesOf(rows[std::size_t(j)])) sum += gradient.dot(along[row]);
      w_(j, i) = displacement * sum;
    }
  }
  return true;
}

/// The impulse_ with which g_ + W (impulse_ - reference_) holds.
void Multipliers::solveImpulses(double weight) {
  std::vector<int> equal, other;
  for (int i = 0; i < int(rows_.rows().size()); ++i) {
    const auto& row = rows_.rows()[std::size_t(i)];
    if (row.kind == Kind::given) {
      impulse_[i] = weight * row.factor;
      g_ += (impulse_[i] - reference_[i]) * w_.col(i);
    } else {
      (row.kind == Kind::equal ? equal : other).push_back(i);
    }
  }
  Eigen::MatrixXd w = w_(other, other);
  Eigen::VectorXd g = g_(other);
  Eigen::MatrixXd eliminated;
  Eigen::VectorXd offset;
  if (!equal.empty()) {
    // rows that say the same twice leave a matrix without an inverse: the shortest solution then
    const Eigen::MatrixXd inner = w_(equal, equal);
    const Eigen::LDLT<Eigen::MatrixXd> factors(inner);
    const Eigen::VectorXd pivots = factors.vectorD().cwiseAbs();
    const bool regular = factors.info() == Eigen::Success && pivots.minCoeff() > 1e-12 * pivots.maxCoeff();
    const Eigen::MatrixXd coupling = w_(equal, other);
    const Eigen::VectorXd values = g_(equal);
    if (regular) {
      eliminated = factors.solve(coupling), offset = factors.solve(values);
    } else {
      Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> general;
      general.setThreshold(1e-12);
      general.compute(inner);
      eliminated = general.solve(coupling), offset = general.solve(values);
    }
    const Eigen::MatrixXd back = w_(other, equal);
    w -= back * eliminated;
    g -= back * offset;
  }
  sweep(w, g, other);
  if (equal.empty()) return;
  const Eigen::VectorXd moved = impulse_ - reference_;
  const Eigen::VectorXd change = -offset - eliminated * Eigen::VectorXd(moved(other));
  for (std::size_t i = 0; i < equal.size(); ++i) impulse_[equal[i]] = reference_[equal[i]] + change[Eigen::Index(i)];
}

/// Projected Gauss and Seidel for `rows` of impulse_, of which none is equal. The step along the tangents is one over the
/// largest eigenvalue of their block, so that where nothing changes any more Coulomb's law holds.
void Multipliers::sweep(const Eigen::MatrixXd& w, const Eigen::VectorXd& g, const std::vector<int>& rows) {
  const int count = int(rows.size());
  if (count == 0) return;
  const Eigen::VectorXd start = impulse_ - reference_;
  Eigen::VectorXd residual = g + w * Eigen::VectorXd(start(rows));
  const double least = 1e-14 * w.diagonal().cwiseAbs().maxCoeff();
  const auto change = [&](int i, double by) {
    impulse_[rows[std::size_t(i)]] += by;
    residual += by * w.col(i);
    return std::abs(by) * w(i, i);
  };
  for (; sweeps_left_ > 0; --sweeps_left_) {
    double moved = 0, largest = g.cwiseAbs().maxCoeff();
    for (int i = 0; i < count;) {
      const int push = i++;
      if (w(push, push) > least) {
        const double old = impulse_[rows[std::size_t(push)]];
        moved = std::max(moved, change(push, std::max(0.0, old - residual[push] / w(push, push)) - old));
      }
      const int first = i;
      while (i < count && rows_.rows()[std::size_t(rows[std::size_t(i)])].kind == Kind::rub) ++i;
      const int tangents = i - first;
      if (tangents == 0) continue;
      const double bound = rows_.rows()[std::size_t(rows[std::size_t(first)])].factor * impulse_[rows[std::size_t(push)]];
      const Eigen::MatrixXd block = w.block(first, first, tangents, tangents);
      const double rate = block.cwiseAbs().rowwise().sum().maxCoeff();
      if (!(rate > least)) continue;
      Eigen::VectorXd wanted(tangents);
      for (int k = 0; k < tangents; ++k) wanted[k] = impulse_[rows[std::size_t(first + k)]] - residual[first + k] / rate;
      if (const double length = wanted.norm(); length > bound) wanted *= bound / length;
      for (int k = 0; k < tangents; ++k)
        moved = std::max(moved, change(first + k, wanted[k] - impulse_[rows[std::size_t(first + k)]]));
    }
    unsettled_ = largest > 0 ? moved / largest : moved;
    // numbers that are not finite have no place to go to
    if (moved <= 1e-13 * largest || !std::isfinite(moved)) return;
  }
}

/// How far conditions are from holding [m].
double Multipliers::violation() const {
  double worst = 0;
  for (std::size_t i = 0; i < rows_.rows().size(); ++i) {
    const double g = g_[Eigen::Index(i)];
    if (const Kind kind = rows_.rows()[i].kind; kind == Kind::equal || kind == Kind::push)
      worst = std::max(worst, kind == Kind::equal ? std::abs(g) : -g);
  }
  return worst;
}

void Multipliers::give(double weight) {
  forces_.assign(impulse_.data(), impulse_.data() + impulse_.size());
  for (double& force : forces_) force /= weight;
  std::size_t from = 0;
  LagrangianRows own;
  for (LagrangianConstraint* constraint : system_->actors().lagrangian_constraints) {
    own.clear();
    constraint->addConditions(system_->mappingChain().positions(system_->x), start_, own);
    constraint->takeForces({forces_.data() + from, own.rows().size()});
    from += own.rows().size();
  }
}

/// With the impulses as they are: x and v from those without forces of constraint.
void Multipliers::apply(double displacement, Rows change) {
  System& s = *system_;
  copy(whole_, before_);
  if (!keeps_direction_) clear(whole_);
  for (Eigen::Index i = 0; i < impulse_.size(); ++i)
    if (const double p = impulse_[i] - reference_[i]; p != 0) axpy(p, responses_[std::size_t(i)], whole_);
  for (const Rows velocity : {s.independent(s.v), change}) axpy(1, whole_, velocity), axpy(-1, before_, velocity);
  copy(free_, s.independent(s.x));
  s.motion().advance(displacement, whole_, s.independent(s.x));
}

void Multipliers::correct(LinearSolver& solver, SystemMatrix& matrix, double displacement, double weight, Rows change,
                          StopToken stop, StepReport& report) {
  constexpr int most_rounds = 100, most_sweeps = 20000;
  constexpr double close = 1e-13;  // of the place
  System& s = *system_;
  copy(s.independent(s.x), free_);
  clear(whole_);
  impulse_.resize(0);
  keeps_direction_ = false;
  sweeps_left_ = most_sweeps, unsettled_ = 0;
  double step = 0;
  for (int round = 0; round < most_rounds; ++round) {
    findConditions();
    if (rows_.rows().empty()) return give(weight);
    if (round == 0) impulse_ = Eigen::VectorXd::Zero(g_.size());
    if ((round == 0 || haveGradientsChanged()) && !respond(solver, matrix, displacement, stop, report)) return;
    reference_ = keeps_direction_ ? impulse_ : Eigen::VectorXd(Eigen::VectorXd::Zero(g_.size()));
    if (!keeps_direction_) {
      const ConstRows along = s.mappingChain().direction(whole_);
      for (Eigen::Index i = 0; i < g_.size(); ++i)
        for (const auto& [row, gradient] : rows_.entriesOf(rows_.rows()[std::size_t(i)]))
          g_[i] -= displacement * gradient.dot(along[row]);
    }
    solveImpulses(weight);
    apply(displacement, change);
    const double last = step;
    step = displacement * distance(whole_, before_);
    if (step <= close * (largest(s.independent(s.x)) + displacement * largest(change))) break;
    if (!std::isfinite(step)) break;
    // forces that turn much in a step would swing: what has been found keeps its direction then
    keeps_direction_ = keeps_direction_ || (round > 3 && step > 0.7 * last);
  }
  findConditions();
  give(weight);
  const double size = largest(s.independent(s.x)), allowed = 1e-9 * size + 1e-300;
  constexpr double settled = 1e-6;  // of the largest condition
  if (!(unsettled_ <= settled)) {
    report.constraints_converged = false;
    report.constraint_reason = fmt::format("forces of contact still change by {:.3g} of the conditions after {} sweeps",
                                           unsettled_, most_sweeps - sweeps_left_);
    return;
  }
  if (violation() <= allowed) return;
  report.constraints_converged = false;
  report.constraint_reason = fmt::format("a condition of the Lagrangian constraints is off by {:.3g}", violation());
}

}  // namespace stroma
