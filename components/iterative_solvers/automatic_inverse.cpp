// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/automatic_inverse.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace stroma {
namespace {

constexpr double new_solve = 0.25;  // its part in moving means

/// What the rate of a solve's first part has to be multiplied with, for that of all of it.
double ofSlowStart(double part) { return 0.6 + 0.4 * std::clamp(part, 0.0, 1.0); }

}  // namespace

// ---- in a solve ----

/// Early iterations gain less than later ones.
bool AutomaticInverse::isSlow(int iterations, double residual) {
  constexpr double as_expected = 1.5;
  constexpr int most_by_factors = 60;
  const double all = std::log10(start_ / target_), known = now_.rates[at(now_.way)];
  if (known > 0 && iterations < as_expected * known * all) return false;
  if (now_.way == Way::factors && iterations < most_by_factors) return false;
  if (now_.way == Way::multigrid && !multigrid_.isFresh())  // the next matrix would get a new hierarchy in any case
    return leaves_ = renews_ = iterations - known * all > multigrid_.iterationsWorth();
  const double gained = std::max(0.25, std::log10(start_ / residual));
  const double rate = iterations / gained * ofSlowStart(gained / all);
  const double later = known > 0 ? known + new_solve * (rate - known) : rate;
  if (!findCheaper(later, std::max(0.0, all - gained))) return false;
  const double present = std::max(1.0, rate * decades()) * iteration(now_.way), gain = present - solve(now_.next);
  const bool may_be_multigrid = now_.way == Way::block_jacobi && present > worth_changing * solve(Way::multigrid);
  // a way that begins cheaply is not waited with because another one is better
  const double before = std::min(setup(now_.next), setup(may_be_multigrid ? Way::multigrid : now_.next));
  const double repaid = gain * std::max(0.0, all - gained) / decades();  // by this solve alone
  // the residual need not fall in each iteration: what has served before is waited for, until that has cost as much as the change
  const double trial = known > 0 ? 1 : 0.25, more = iterations - known * all;
  leaves_ = more * iteration(now_.way) >= trial * before || repaid >= worth_changing * before;
  if (!leaves_) now_.next = now_.way;
  return leaves_;
}

/// A solve of a matrix that is not definite says nothing of later ones.
void AutomaticInverse::solved(const SolveReport& report) {
  if (report.iterations == 0 || !report.usable() || by_blocks_) return;
  if (now_.way != Way::block_jacobi) now_.refusals = 0;
  SolveReport part = report;
  const double from = std::exchange(start_, std::max(report.relative_residual, 1e-16));
  part.relative_residual = start_ / from;
  const double wanted = -std::log10(target_ / from), reached = -std::log10(part.relative_residual);
  const double gained = leaves_ ? std::max(0.25, reached) : std::clamp(reached, 0.5, std::max(0.5, wanted));
  if (!renews_) noteRate(isDirect() ? 0 : report.iterations, gained, reached / std::max(0.1, wanted));
  constexpr int most_refinements = 20;  // of a direct solve
  const bool is_refined = isDirect() && report.iterations > most_refinements;
  if (is_refined || (now_.way == Way::factors && (factored_ || report.factored))) now_.fresh_rate = report.iterations / gained;
  if (now_.way == Way::multigrid) multigrid_.solved(part), ++(renews_ ? now_.renewals : now_.multigrid_solves);
  if (renews_)  // what more than a hierarchy that is not aged would have taken
    now_.wasted += std::max(0.0, report.iterations - now_.rates[at(now_.way)] * gained) * iteration(now_.way);
  if (now_.way == Way::factors) factors_->solved(part, 1);
  if (leaves_ || rows_ < few_nodes || !may_change_) return;
  const double decades = std::min(-std::log10(start_), -std::log10(target_));
  // loose and strict solves take turns in Newton's method: a mean of few would choose at the moment that flatters a way most
  const double share = std::clamp(1.0 / now_.solves, 1.0 / 16, 0.25);
  now_.decades = now_.decades == 0 ? decades : now_.decades + (decades - now_.decades) * share;
  factored_ = factored_ || report.factored;
  const double by_factors = direct() + (is_refined ? report.iterations * iteration(Way::factors) : 0);
  const double cost = (isDirect() ? by_factors : report.iterations * iteration(now_.way)) + turning(now_.way);
  if (now_.way == Way::factors && report.stop == SolveStop::iteration_limit) return void(now_.given_up += cost);
  judge(cost + std::exchange(now_.given_up, 0));
}

/// Loose solves take more iterations for a decade than those that go on: the mean is that of iterations over that of decades.
/// What is left before it has reached `part` of its decades would have become quicker.
void AutomaticInverse::noteRate(double iterations, double gained, double part) {
  double& rate = now_.rates[at(now_.way)];
  double& spent = now_.spent[at(now_.way)];
  double& decades = now_.gained[at(now_.way)];
  const bool was_guess = now_.way == Way::block_jacobi && now_.jacobi_is_guess;
  if (now_.way == Way::block_jacobi) now_.jacobi_is_guess = leaves_ && (rate == 0 || was_guess);
  if (was_guess && !leaves_ && !now_.lessons.isEmpty()) rate = 0;
  if (rate == 0 || leaves_) {
    rate = std::max(rate, iterations / gained * (leaves_ ? ofSlowStart(part) : 1));
    decades = gained, spent = rate * gained;
    return;
  }
  spent += new_solve * (iterations - spent), decades += new_solve * (gained - decades);
  rate = spent / decades;
}

/// What the next solve should take.
void AutomaticInverse::judge(double cost) {
  constexpr int enough_solves = 3;
  const Way way = now_.way;
  if (!isFactored(way)) findCheaper(now_.rates[at(way)], 0);
  if (way == Way::block_jacobi || now_.next != way) return;
  if (isFactored(way)) {
    const bool is_first = now_.factored_solves++ == 0;
    if (factored_ && !is_first) cost += now_.factor_costs.factor + (now_.has_new_pattern ? now_.factor_costs.order : 0);
    now_.has_new_pattern = false;
    if (way == Way::factors) now_.with_factors += cost, ++now_.factor_solves;
    if (is_first) return;
    const double gain = solve(way) - worth_changing * solveByOwn();
    const bool was_at_once = now_.at_once;
    if (way == Way::factors && now_.factor_solves >= enough_solves && !isConstant() && gain > 0) takeFactorsOfEach(gain);
    if (now_.next != way || now_.at_once != was_at_once) return;
  }
  const Way other = bestOfOthers();
  const double other_cost = other == Way::direct ? solveByOwn() : solve(other);
  now_.lost = std::max(0.0, now_.lost + cost - other_cost);
  const double to_lose = other == Way::block_jacobi ? setup(way) : setup(other);
  if (now_.lost <= to_lose || solve(way) <= other_cost) return;
  if (other == Way::direct) return takeFactorsOfEach(solve(way) - other_cost);
  if (now_.changes >= most_changes) return;
  now_.next = other;
}

/// Where several solves share a matrix, or rows turn, the direct solver saves more than it takes to make room for its numbers.
void AutomaticInverse::takeFactorsOfEach(double gain) {
  const double saved = byFresh() - solve(Way::direct);
  if (perMatrix() < several && (now_.changes >= most_changes || saved * horizon() < setup(Way::direct))) {
    now_.at_once = true, now_.lost = 0;
    return;
  }
  if (perMatrix() < several) gain = saved;
  if (now_.changes < most_changes && gain * horizon() > setup(Way::direct)) now_.next = Way::direct;
}

/// Of the ways that are known, and of factors of each matrix where there are former ones.
AutomaticInverse::Way AutomaticInverse::bestOfOthers() const {
  const auto cost = [this](Way way) { return (way == Way::direct ? solveByOwn() : solve(way)) * horizon() + setup(way); };
  Way best = Way::block_jacobi;
  if (!isFactored(now_.way)) return best;
  if (now_.rates[at(Way::multigrid)] > 0 && cost(Way::multigrid) < cost(best)) best = Way::multigrid;
  return now_.way == Way::factors && !now_.at_once && cost(Way::direct) < cost(best) ? Way::direct : best;
}

/// Had they never to be renewed.
bool AutomaticInverse::mightFactorsPay() const {
  const double best = byFactors(iteration(Way::factors), 0) + turning(Way::factors);
  const double present = solve(now_.way);
  return mayBe(Way::factors) && now_.factor_costs.order > 0 && present > worth_by_drifts * best &&
         (present - best) * horizon() > setup(Way::factors);
}

/// How long former factors would serve shows in how far matrices drift, without factors: after one matrix, three and eight, and
/// again whenever there have been twice as many. Each time costs a product and what turns of nodes do.
void AutomaticInverse::keepSolve(ConstRows b, ConstRows x) {
  if (leaves_ || by_blocks_ || !may_change_ || is_constant_ || rows_ < few_nodes || now_.changes >= most_changes) return;
  if (now_.way == Way::factors || now_.factor_solves > 0 || !now_.former.isEmpty() || now_.matrices < now_.next_former) return;
  if (isRefused() || !mayBe(Way::factors)) return;
  estimateFactors();
  if (!mightFactorsPay()) return;
  countFactors();
  if (!mightFactorsPay()) return;
  now_.former.keep(*matrix_, now_.matrices, b, x);
}

void AutomaticInverse::followDrifts(SystemMatrix& matrix) {
  constexpr int last_age = 8;
  if (now_.former.isEmpty()) return;
  const int age = now_.former.age(now_.matrices);
  if (now_.way == Way::factors || age > last_age) return now_.former.clear();
  if (age != 1 && age != 3 && age != last_age) return;
  now_.drifts.note(age, now_.former.drift(matrix));
  if (age == last_age) now_.former.clear(), now_.next_former = 2 * now_.matrices;
}

int AutomaticInverse::patience() const {
  constexpr int usual = 100, most_times = 3;
  if (by_blocks_) return int(most_times * std::max<double>(usual, now_.rates[at(Way::block_jacobi)] * decades()));
  if (now_.way != Way::factors) return ApproximateInverse::patience();
  // what new factors would take is no reason to make them
  const double fresh = now_.fresh_rate * std::log10(std::max(1.0, start_ / target_));
  return int(std::min(factors_->patience() + fresh, double(std::numeric_limits<int>::max())));
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
  now_.product = matrix.productCost();
  if (!is_new) return;
  if (now_.matrices == 1) chooseByLessons();
  followDrifts(matrix);
  if (!now_.drifts.isKnown() || now_.next != now_.way || now_.factor_solves > 0) return;
  if (!isDirect()) return void(findCheaper(now_.rates[at(now_.way)], 0));
  const double by_factors = solve(Way::factors), by_direct = solve(Way::direct);
  if (by_direct > worth_by_drifts * by_factors && (by_direct - by_factors) * horizon() > setup(Way::factors))
    now_.next = Way::factors;
}

/// For the first solve on a changed mesh. A rate that was only guessed is found out where little is to be gained.
void AutomaticInverse::chooseByLessons() {
  if (!may_change_ || rows_ < few_nodes || now_.way != Way::block_jacobi || now_.lessons.isEmpty()) return;
  is_guess_ = now_.jacobi_is_guess;
  findCheaper(now_.rates[at(Way::block_jacobi)], decades());
  is_guess_ = false;
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
    if (has_hierarchy && now_.blocks != multigrid_.hierarchy()->fine.a.blocks()) notePattern();
    return has_hierarchy;
  }
  WarpedFactor& former = factors();
  if (now_.at_once) former.factorNext();
  if (!former.follow(matrix, report, stop)) return false;
  factored_ = report.factored;
  if (!factored_) return true;
  const Factorisation::Cost cost = former.cost();
  now_.factor_costs.factor = 1e9 * cost.factor + assembly();
  now_.factor_costs.application = 1e9 * cost.apply + FactorCosts::turning * rows_;
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
  now_.at_once = false;
  now_.lost = 0;
  ++now_.changes;
  multigrid_.reset();
  if (factors_ && way == Way::direct) factors_->handOver(*matrix_);
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
