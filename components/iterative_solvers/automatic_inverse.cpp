// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/automatic_inverse.h"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace stroma {
namespace {

/// Back and forth, and then it stays.
constexpr int most_changes = 4;
/// A change has to gain this much, as estimates are no better.
constexpr double worth_changing = 1.15;

// What is expected of ways that have not been tried.
constexpr double multigrid_start = 1.25, multigrid_rate = 2;  // iterations, and more for a decade
constexpr double fresh_rate = 0.3;                           // by the factors of the very matrix, in single precision
constexpr double former_rate = 0.8;                          // and more by those of a former one, for each matrix since
constexpr double direct_applications = 2.5;                  // of factors in single precision
constexpr double to_open_factors = 3e6;                      // ns: a module

}  // namespace

// ---- estimates, in nanoseconds ----

double AutomaticInverse::iteration(Way way) const {
  const double product = product_ > 0 ? product_ : IterationCosts::usual_product * rows_;
  const double others = product + IterationCosts::vectors * rows_;
  if (way == Way::block_jacobi) return others;
  return others + (way == Way::multigrid ? IterationCosts::cycle(rows_, blocks()) : now_.factor_costs.application);
}

double AutomaticInverse::setup(Way way) const {
  if (way == Way::multigrid) return IterationCosts::hierarchy(rows_, blocks()) + IterationCosts::assembly(rows_);
  return isFactored(way) ? now_.factor_costs.order + now_.factor_costs.factor + to_open_factors : 0;
}

/// With an ordering where patterns change.
double AutomaticInverse::factorisation() const {
  const double patterns = double(std::max(0, now_.patterns - 1)) / std::max(1, now_.matrices);
  return now_.factor_costs.factor + patterns * now_.factor_costs.order;
}

/// In a direct solve.
double AutomaticInverse::applications() const { return now_.factor_costs.is_single ? direct_applications : 1; }

/// Of the matrices after the first one, a solve's share.
double AutomaticInverse::turning(Way way) const {
  if (now_.matrices < 2 || way == Way::block_jacobi || way == Way::direct) return 0;
  return (way == Way::multigrid ? IterationCosts::turn_hierarchy : IterationCosts::turn_factors) * rows_ / perMatrix();
}

/// Of hierarchies that were made anew, and of what was done with the former ones in vain, a solve's share.
double AutomaticInverse::renewing() const {
  return (now_.wasted + IterationCosts::hierarchy(rows_, blocks()) * now_.renewals) / std::max(1, now_.multigrid_solves);
}

/// By the factors of the very matrix.
double AutomaticInverse::byFresh(double each) const { return std::max(1.0, fresh_rate * decades()) * each; }

/// By factors that are renewed when that is cheapest: with F for a factorisation and s for an iteration more for each matrix since,
/// after sqrt(2 F / s) matrices, and then a solve costs sqrt(2 F s) more than by fresh factors.
double AutomaticInverse::solveByFormer(double each, double renewal) const {
  const double more = former_rate * decades() * each;
  const double served = std::max(1.0, std::sqrt(2 * renewal / more));
  return byFresh(each) + renewal / served + more * (served - 1) / 2;
}

/// One of the usual kind, with its share of what comes before.
double AutomaticInverse::solve(Way way) const {
  const double rate = now_.rates[at(way)], each = iteration(way);
  if (way == Way::block_jacobi) return std::max(1.0, rate * decades()) * each;
  if (way == Way::multigrid)
    return (rate > 0 ? std::max(1.0, rate * decades()) : multigrid_start + multigrid_rate * decades()) * each + turning(way) +
           renewing();
  // the first step of integrators that look back two steps has a matrix of its own
  const bool is_constant = is_constant_ ? now_.matrices <= 2 : now_.matrices == 1 && now_.solves > 1;
  const double factors = is_constant ? 0 : factorisation() / perMatrix();
  if (way == Way::direct) return applications() * each + factors;
  if (now_.factor_solves > 0) return now_.with_factors / now_.factor_solves;
  return solveByFormer(each, factors) + turning(way);
}

/// From below: a body of few tetrahedra has a third of the numbers of the laws.
void AutomaticInverse::estimateFactors() {
  constexpr double less = 3.5;
  if (now_.factor_costs.order > 0 || !mayBe(Way::factors)) return;
  FactorCounts counts = factorCountsOf(extentsOf(rows_, matrix_->positions()));
  now_.is_counted = false;
  counts = {counts.entries / less, counts.flops / (less * std::sqrt(less))};
  now_.factor_costs = factorCosts(rows_, counts, true);
  now_.may_factor = factorsFit(now_.factor_costs.entries);
}

/// Takes the pattern of the matrix, and some milliseconds: for those whose factors might be worth their cost.
void AutomaticInverse::countFactors() {
  if (now_.is_counted || !mayBe(Way::factors)) return;
  now_.is_counted = true;
  const FactorCounts by_law = factorCountsOf(extentsOf(rows_, matrix_->positions()));
  now_.factor_costs = factorCosts(rows_, fewer(stroma::countFactors(matrix_->pattern()), by_law));
  now_.may_factor = factorsFit(now_.factor_costs.entries);
}

/// The way that gains most where it costs less than the present one, for `left` decades now and for later solves.
AutomaticInverse::Way AutomaticInverse::cheapest(double present, double left) const {
  double best = 0;
  Way cheapest = now_.way;
  for (const Way way : {Way::block_jacobi, Way::multigrid, Way::factors, Way::direct}) {
    if (way == now_.way || !mayBe(way)) continue;
    if (way == Way::block_jacobi && now_.rates[at(way)] == 0) continue;
    const double other = solve(way);
    if (present < worth_changing * other) continue;
    const double gain = (present - other) * (horizon() + left / decades()) - setup(way);
    if (gain > best) best = gain, cheapest = way;
  }
  return cheapest;
}

/// Sets `next` where another way is estimated to cost less; the present way takes so many iterations for a decade.
bool AutomaticInverse::findCheaper(double rate, double left) {
  if (now_.changes >= most_changes || isRefused()) return false;
  const double again = now_.way == Way::multigrid ? renewing() : 0;
  const double present = std::max(1.0, rate * decades()) * iteration(now_.way) + turning(now_.way) + again;
  estimateFactors();
  Way way = cheapest(present, left);
  if (isFactored(way) && !now_.is_counted) countFactors(), way = cheapest(present, left);
  if (way == now_.way) return false;
  now_.next = way;
  return true;
}

// ---- in a solve ----

/// Early iterations gain less than later ones.
bool AutomaticInverse::isSlow(int iterations, double residual) {
  constexpr double as_expected = 1.5, trial = 0.25;
  constexpr int most_by_factors = 60;
  const double all = std::log10(start_ / target_), known = now_.rates[at(now_.way)];
  if (known > 0 && iterations < as_expected * known * all) return false;
  if (now_.way == Way::factors && iterations < most_by_factors) return false;
  if (now_.way == Way::multigrid && !multigrid_.isFresh())  // the next matrix would get a new hierarchy in any case
    return leaves_ = renews_ = iterations - known * all > Multigrid::iterations_worth;
  const double gained = std::max(0.25, std::log10(start_ / residual));
  const double rate = iterations / gained * (0.6 + 0.4 * std::min(1.0, gained / all));
  if (!findCheaper(rate, std::max(0.0, all - gained))) return false;
  const double gain = std::max(1.0, rate * decades()) * iteration(now_.way) - solve(now_.next), before = setup(now_.next);
  const double repaid = gain * std::max(0.0, all - gained) / decades();  // by this solve alone
  leaves_ = iterations * iteration(now_.way) >= trial * before || repaid >= worth_changing * before;
  if (!leaves_) now_.next = now_.way;
  return leaves_;
}

/// A solve of a matrix that is not definite says nothing of later ones.
void AutomaticInverse::solved(const SolveReport& report) {
  if (report.iterations == 0 || !report.usable() || by_blocks_) return;
  if (now_.way != Way::block_jacobi) now_.refusals = 0;
  SolveReport part = report;
  part.relative_residual = std::max(report.relative_residual, 1e-16) / start_;
  start_ = std::max(report.relative_residual, 1e-16);
  const double gained = std::max(leaves_ ? 0.25 : 0.5, -std::log10(part.relative_residual));
  const double rate = (isDirect() ? 0 : report.iterations) / gained * (leaves_ ? 0.7 : 1);
  if (double& mean = now_.rates[at(now_.way)]; !renews_)
    mean = mean == 0 ? rate : leaves_ ? std::max(mean, rate) : mean + (rate - mean) / 4;
  if (now_.way == Way::multigrid) multigrid_.solved(part), ++(renews_ ? now_.renewals : now_.multigrid_solves);
  if (renews_) now_.wasted += report.iterations * iteration(now_.way);
  if (now_.way == Way::factors) factors_->solved(part);
  if (leaves_ || rows_ < few_nodes || !may_change_) return;
  const double decades = std::min(-std::log10(start_), -std::log10(target_));
  now_.decades = now_.decades == 0 ? decades : now_.decades + (decades - now_.decades) / 4;
  factored_ = factored_ || report.factored;
  judge((report.iterations + (isDirect() ? applications() - 1 : 0)) * iteration(now_.way) + turning(now_.way));
}

/// What the next solve should take.
void AutomaticInverse::judge(double cost) {
  constexpr int enough_solves = 6;
  const Way way = now_.way;
  if (!isFactored(way)) {
    now_.spent += cost;
    if (!findCheaper(now_.rates[at(way)], 0) && tryFactors()) now_.next = Way::factors;
  }
  if (way == Way::block_jacobi || now_.next != way) return;
  if (isFactored(way)) {
    const bool is_first = now_.factored_solves++ == 0;
    if (factored_ && !is_first) cost += now_.factor_costs.factor + (now_.has_new_pattern ? now_.factor_costs.order : 0);
    now_.has_new_pattern = false;
    if (way == Way::factors) now_.with_factors += cost, ++now_.factor_solves;
    if (is_first) return;
    if (way == Way::factors && now_.factor_solves >= enough_solves && now_.changes < most_changes &&
        solve(way) > worth_changing * solve(Way::direct) &&
        now_.with_factors > now_.factor_solves * solve(Way::direct) + setup(Way::direct)) {  // which orders and factors again
      now_.next = Way::direct;
      return;
    }
  }
  const bool knows_multigrid = isFactored(way) && now_.rates[at(Way::multigrid)] > 0;
  const Way other = knows_multigrid && solve(Way::multigrid) < solve(Way::block_jacobi) ? Way::multigrid : Way::block_jacobi;
  now_.lost = std::max(0.0, now_.lost + cost - solve(other));
  const double to_lose = other == Way::multigrid ? setup(other) : std::max(setup(way), setup(other));
  if (now_.lost <= to_lose || now_.changes >= most_changes) return;
  now_.next = other;
  now_.may_factor = now_.may_factor && !isFactored(way);
}

/// How long former factors serve shows only where they are tried, in vain in two of three bodies (of those of solver_scenes.py). So
/// it is done once factors that never age would have gained three times what comes before them, had they been taken at first. Where
/// multigrid serves it is not done: what they might gain is less there than estimates are wrong by.
bool AutomaticInverse::tryFactors() {
  constexpr int often = 4, in_vain = 3;
  if (now_.way != Way::block_jacobi || now_.factored_solves > 0 || now_.changes >= most_changes || isRefused()) return false;
  if (!mayBe(Way::factors) || often * (now_.patterns - 1) > now_.matrices) return false;
  const auto isWorth = [&] {
    const double best = byFresh(iteration(Way::factors)) + turning(Way::factors);
    return solve(now_.way) > worth_changing * best && now_.spent - now_.solves * best > in_vain * setup(Way::factors);
  };
  if (!isWorth()) return false;
  countFactors();
  return mayBe(Way::factors) && isWorth();
}

int AutomaticInverse::patience() const {
  constexpr int usual = 100, most_times = 3;
  if (by_blocks_) return int(most_times * std::max<double>(usual, now_.rates[at(Way::block_jacobi)] * decades()));
  return now_.way == Way::factors ? factors_->patience() : ApproximateInverse::patience();
}

bool AutomaticInverse::giveUp() {
  if (std::exchange(renews_, false)) {
    leaves_ = false;
    return multigrid_.giveUp();
  }
  if (std::exchange(leaves_, false)) return now_.next != now_.way;
  return !by_blocks_ && now_.way == Way::factors && factors_->giveUp();
}

// ---- between solves ----

void AutomaticInverse::note(SystemMatrix& matrix) {
  const MatrixKey key = matrix.key();
  matrix_ = &matrix, rows_ = matrix.rows();
  leaves_ = renews_ = false;
  if (!has_begun_) return;
  has_begun_ = false;
  factored_ = by_blocks_ = false;
  ++now_.solves;
  const bool is_new = key != now_.key;
  const bool has_new_pattern = now_.patterns == 0 || key.pattern != now_.key.pattern;
  now_.has_new_pattern = has_new_pattern || (now_.has_new_pattern && isFactored(now_.way));
  now_.matrices += is_new;
  now_.patterns += is_new && has_new_pattern;
  now_.key = key;
}

bool AutomaticInverse::follow(SystemMatrix& matrix, SolveReport& report, StopToken stop) {
  note(matrix);
  if (isFactored(now_.next) && !canFactor()) now_.next = isFactored(now_.way) ? Way::block_jacobi : now_.way;
  if (now_.next != now_.way) {
    change(now_.next);
    if (now_.way == Way::multigrid) avoidMultigrid(matrix);
  }
  if (isDirect()) return true;
  if (now_.way == Way::block_jacobi) return blocks_.follow(matrix, report, stop);
  SolveReport refused;
  if (followBy(now_.way, matrix, refused, stop)) {
    report.factored = refused.factored;
    return true;
  }
  report = refused;
  return refuse(matrix, report, stop);
}

/// Factors, and blocks of the diagonal, are sure that the matrix is not definite. A coarse level of multigrid may be at its
/// round-off, where conjugate gradients come through.
bool AutomaticInverse::refuse(SystemMatrix& matrix, SolveReport& report, StopToken stop) {
  if (report.stop != SolveStop::not_definite && report.stop != SolveStop::breakdown) return false;
  by_blocks_ = now_.way == Way::multigrid && report.row < 0;
  noteRefusal();
  if (!by_blocks_) return false;
  report = {};
  return blocks_.follow(matrix, report, stop);
}

void AutomaticInverse::noteRefusal() {
  if (++now_.refusals == most_refusals) change(Way::block_jacobi);
}

/// Where it would need patches, its iterations are many and dear.
void AutomaticInverse::avoidMultigrid(SystemMatrix& matrix) {
  const auto areFar = [&] {
    const double factored = std::min(solve(Way::direct), solve(Way::factors));
    return !mayBe(Way::factors) || factored > IterationCosts::with_patches * solve(Way::multigrid);
  };
  estimateFactors();
  if (areFar()) return;
  countFactors();
  if (areFar() || !amg::hardlySmooths(matrix.assemble()) || !canFactor()) return;
  now_.way = now_.next = solve(Way::direct) < solve(Way::factors) ? Way::direct : Way::factors;
}

bool AutomaticInverse::followBy(Way way, SystemMatrix& matrix, SolveReport& report, StopToken stop) {
  if (way == Way::multigrid) {
    const bool had_one = multigrid_.hierarchy();
    const int made = multigrid_.made();
    const bool has_hierarchy = multigrid_.follow(matrix, report, stop);
    now_.renewals += had_one && multigrid_.made() > made;
    if (has_hierarchy) now_.blocks = multigrid_.hierarchy()->fine.a.blocks();
    return has_hierarchy;
  }
  WarpedFactor& former = factors();
  if (!former.follow(matrix, report, stop)) return false;
  factored_ = report.factored;
  if (!factored_) return true;
  const Factorisation::Cost cost = former.cost();
  now_.factor_costs.factor = 1e9 * cost.factor, now_.factor_costs.application = 1e9 * cost.apply;
  return true;
}

/// Whether there is a direct solver: it is made when it is first wanted.
bool AutomaticInverse::canFactor() {
  try {
    if (make_factors_) return (void)make_factors_(), true;
  } catch (const std::runtime_error&) {
    make_factors_ = {};
  }
  return false;
}

WarpedFactor& AutomaticInverse::factors() {
  if (!factors_) factors_ = std::make_unique<WarpedFactor>(make_factors_());
  return *factors_;
}

void AutomaticInverse::change(Way way) {
  now_.way = now_.next = way;
  now_.lost = 0;
  ++now_.changes;
  multigrid_.reset();
  if (factors_) factors_->reset();
}

void AutomaticInverse::reset() {
  blocks_.reset();
  multigrid_.reset();
  if (factors_) factors_->reset();
  now_ = kept_ = {};
}

void AutomaticInverse::keep(const SystemMatrix& matrix) {
  kept_ = now_;
  multigrid_.keep(matrix);
  if (factors_) factors_->keep(matrix);
}

void AutomaticInverse::takeBack(const SystemMatrix& matrix) {
  now_ = kept_;
  multigrid_.takeBack(matrix);
  if (factors_) factors_->takeBack(matrix);
}

}  // namespace stroma
