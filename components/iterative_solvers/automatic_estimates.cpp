// SPDX-License-Identifier: LGPL-2.1-or-later
// What AutomaticInverse expects each way to cost, in nanoseconds.
#include <cmath>
#include <limits>

#include "components/iterative_solvers/automatic_inverse.h"

namespace stroma {
namespace {

// What is expected of ways that have not been tried.
constexpr double multigrid_start = 1.25;  // iterations, and so many more for a decade as are expected
constexpr double worth_a_guess = 1.3;
constexpr double usual_drift = 0.02;                         // from one matrix to the next
// Former factors may take this many times the iterations that the law of drifts predicts: in loose solves, and after drifts of 3 and
// more. Solves to six decades and more end faster after drifts up to 2.
constexpr double scatter_loose = 1.4, scatter_strict = 1;
constexpr double fresh_single = 5e-4, fresh_double = 1e-5;   // what factors of the very matrix leave, as a drift
constexpr double direct_applications = 2;                    // of these by a direct solver
constexpr double in_double = 3;                              // factorisations that it makes of what is solved with often
constexpr int most_served = 100;                             // matrices

}  // namespace

double AutomaticInverse::iteration(Way way) const {
  const double product = product_ > 0 ? product_ : IterationCosts::usual_product * rows_;
  const double others = product + IterationCosts::vectors(rows_);
  if (way == Way::block_jacobi) return others;
  return others + (way == Way::multigrid ? cycle() : now_.factor_costs.application);
}

int AutomaticInverse::expectedIterations(double target) const {
  constexpr double usual_rate = 12.5, most = 1e6;  // of block Jacobi: 100 to 1e-8
  constexpr int by_multigrid = 15, by_factors = 8;
  const Way way = now_.next;
  if (way == Way::direct) return 1;
  double rate = now_.rates[at(way)];
  if (rate == 0 && way != Way::block_jacobi) return way == Way::multigrid ? by_multigrid : by_factors;
  if (rate == 0) rate = usual_rate;
  const double to_target = -std::log10(std::clamp(target, 1e-16, 0.1));
  return int(std::clamp(std::ceil(rate * to_target * std::max(1.0, perMatrix())), 1.0, most));
}

double AutomaticInverse::cycle() const {
  const bool has_patches = multigrid_.hierarchy() && multigrid_.hierarchy()->hasPatches();
  const bool by_products = now_.product > 0 && now_.product < now_.blocks && !has_patches;
  if (!by_products) return IterationCosts::cycle(rows_, blocks());
  return IterationCosts::cycleByProducts(rows_, now_.product, multigrid_.hierarchy() ? multigrid_.isTurned() : !isConstant());
}

double AutomaticInverse::setup(Way way) const {
  if (way == Way::block_jacobi) return 0;
  const double matrix = assembly() + (now_.blocks > 0 ? 0 : IterationCosts::pattern(rows_, blocks()));
  if (way == Way::multigrid) return IterationCosts::hierarchy(rows_, blocks()) + matrix;
  const double again = way == Way::direct && isConstant() && now_.factor_costs.is_single ? in_double : 0;
  const double entries = now_.factor_costs.entries;
  const double room = IterationCosts::room(entries);
  // the order is kept, and a direct solver takes over the memory of former factors
  const double again_room = way == Way::direct && now_.way == Way::factors ? 0 : room - IterationCosts::room(0);
  return (now_.factored_solves > 0 ? again_room : room + now_.factor_costs.order) + (1 + again) * now_.factor_costs.factor;
}

/// Solves that a change should pay in: as many as there have been, as a run may end at any time, and at least those of a short one.
/// Where nothing changes the matrix each solve is one of a step. Not more than the mesh is expected to live, as long as those before it.
double AutomaticInverse::horizon() const {
  constexpr double short_run = 8;  // matrices
  const double each = is_constant_ && isConstant() ? 1 : perMatrix(), usual = short_run * each + now_.solves;
  const double left = now_.lessons.lifetime - now_.matrices;
  return left >= 0 && !now_.lessons.isEmpty() ? std::min(usual, left * each) : usual;
}

/// With an ordering where patterns change.
double AutomaticInverse::factorisation() const {
  const double patterns = double(std::max(0, now_.patterns - 1)) / std::max(1, now_.matrices);
  return now_.factor_costs.factor + patterns * now_.factor_costs.order;
}

/// A direct solve: each application of the factors has a product, and nothing is turned.
double AutomaticInverse::direct() const {
  const double each = iteration(Way::direct) - IterationCosts::vectors(rows_) - FactorCosts::turning * rows_;
  return (now_.factor_costs.is_single ? direct_applications : 1) * each;
}

/// Of the matrices after the first one, a solve's share.
double AutomaticInverse::turning(Way way) const {
  if (now_.matrices < 2 || isConstant() || way == Way::block_jacobi || way == Way::direct) return 0;
  return IterationCosts::turns(rows_, blocks()) / perMatrix();
}

/// The first step of integrators that look back two steps has a matrix of its own.
bool AutomaticInverse::isConstant() const {
  return is_constant_ ? now_.matrices <= 2 : now_.matrices == 1 && now_.solves > 1;
}

/// Of hierarchies that were made anew, and of what was done with the former ones in vain, a solve's share.
double AutomaticInverse::renewing() const {
  return (now_.wasted + IterationCosts::hierarchy(rows_, blocks()) * now_.renewals) / std::max(1, now_.multigrid_solves);
}

/// A solve by factors after such a drift, with the product that ends it.
double AutomaticInverse::byFactors(double each, double drift) const {
  const double own = now_.factor_costs.is_single ? fresh_single : fresh_double;
  const double strict = std::clamp((decades() - 2) / 4, 0.0, 1.0) * std::clamp(3 - drift, 0.0, 1.0);
  const double scatter = scatter_loose + strict * (scatter_strict - scatter_loose);
  const double rate = ratePerDecade(std::max(own, drift)) * (now_.drifts.isKnown() && drift > own ? scatter : 1);
  return std::ceil(std::max(0.5, rate * decades())) * each + iteration(Way::block_jacobi);
}

/// By factors that are renewed when that is cheapest; `renewal`: a solve's share of a factorisation, were it for each matrix.
double AutomaticInverse::solveByFormer(double each, double renewal) const {
  double best = std::numeric_limits<double>::max(), sum = renewal + byFactors(each, 0);
  for (int served = 1; served <= most_served; ++served) {
    best = std::min(best, sum / served);
    sum += byFactors(each, now_.drifts.isKnown() ? now_.drifts.after(served) : usual_drift * served);
  }
  return best;
}

/// So many iterations by block Jacobi, which assembles a matrix for them where that costs less. A way that multiplies by elements does
/// not hide that. The pattern that was counted last is enough here: contact changes it in every solve, and a new one costs as much as
/// several iterations.
double AutomaticInverse::byJacobi(double iterations) const {
  const double by_products = iterations * iteration(Way::block_jacobi);
  const double once = matrix_->assemblyCost();
  const bool assembles = once >= 0 && BlockMatrix::pays(iterations, matrix_->productCost(), once, double(blocks()), true);
  if (now_.blocks == 0 || !assembles) return by_products;
  const double product = BlockMatrix::productCost(blocks(), true);
  return std::min(by_products, assembly() / perMatrix() + iterations * (product + IterationCosts::vectors(rows_)));
}

/// One of the usual kind, with its share of what comes before.
double AutomaticInverse::solve(Way way) const {
  const double rate = now_.rates[at(way)], each = iteration(way);
  if (way == Way::block_jacobi) return byJacobi(std::max(1.0, rate * decades()));
  if (way == Way::multigrid)
    return (rate > 0 ? std::max(1.0, rate * decades()) : multigrid_start + now_.expected_rate * decades()) * each + turning(way) +
           renewing();
  const double factors = isConstant() ? 0 : factorisation() / perMatrix();
  if (way == Way::direct) return isUnlikeItsFactors() ? std::numeric_limits<double>::infinity() : direct() + factors;
  if (now_.factor_solves > 0) return now_.with_factors / now_.factor_solves;
  return solveByFormer(each, factors) + turning(way);
}

/// By conjugate gradients with factors of the very matrix. Where rows turn these measure the forces before and after, too.
double AutomaticInverse::byFresh() const {
  const double measures = matrix_->hasTurns() ? 2 * now_.factor_costs.application : 0;
  return factorisation() / perMatrix() + std::max(1.0, now_.fresh_rate * decades()) * iteration(Way::factors) + measures;
}

/// By factors of each matrix. Where those take many iterations too, what multiplies is not what was factored (terms that are not
/// assembled, a matrix that is not symmetric), and former ones serve as well.
double AutomaticInverse::solveByOwn() const {
  if (now_.way != Way::factors || perMatrix() >= several) return solve(Way::direct);
  if (isUnlikeItsFactors()) return std::numeric_limits<double>::infinity();
  return byFresh();
}

/// From below: a body of few tetrahedra has a third of the numbers of the laws.
void AutomaticInverse::estimateFactors() {
  constexpr double less = 3.5;
  if (now_.factor_costs.order > 0 || !mayBe(Way::factors)) return;
  FactorCounts counts = factorCountsOf(extentsOf(rows_, matrix_->positions()));
  now_.is_counted = false;
  counts = {counts.entries / less, counts.flops / (less * std::sqrt(less))};
  now_.factor_costs = factorCosts(rows_, blocks(), counts, true);
  now_.factor_costs.factor += assembly();
  now_.may_factor = factorsFit(now_.factor_costs.entries);
}

void AutomaticInverse::notePattern() {
  const BlockMatrix& pattern = matrix_->pattern();
  now_.blocks = pattern.blocks(), now_.expected_rate = expectedMultigridRate(pattern, matrix_->positions());
}

/// Takes the pattern of the matrix, and some milliseconds: for those whose factors might be worth their cost.
void AutomaticInverse::countFactors() {
  if (now_.is_counted || !mayBe(Way::factors)) return;
  now_.is_counted = true;
  notePattern();
  const BlockMatrix& pattern = matrix_->pattern();
  const Extents extents = extentsOf(rows_, matrix_->positions());
  const FactorCounts counts = fewest(pattern, dissected(blocks(), stroma::countFactors(pattern)), extents);
  now_.factor_costs = factorCosts(rows_, blocks(), counts);
  now_.factor_costs.factor += assembly();
  now_.may_factor = factorsFit(now_.factor_costs.entries);
}

/// The way that gains most where it costs less than the present one, for `left` decades now and for later solves.
AutomaticInverse::Way AutomaticInverse::cheapest(double present, double left) const {
  double best = 0;
  Way cheapest = now_.way;
  for (const Way way : {Way::block_jacobi, Way::multigrid, Way::factors, Way::direct}) {
    if (way == now_.way || !mayBe(way)) continue;
    if (way == Way::block_jacobi && now_.rates[at(way)] == 0) continue;
    // between solves factors are taken for what is known of drifts
    const bool is_known = now_.drifts.isKnown() || now_.factor_solves > 0 || isConstant();
    if (way == Way::factors && left == 0 && !is_known) continue;
    const double other = solve(way);
    // what a direct solver costs is known better
    if (way == Way::factors && !is_known && worth_a_guess * other > solve(Way::direct)) continue;
    if (present < (way == Way::factors && left == 0 ? worth_by_drifts : worth_changing) * other) continue;
    const double gain = (present - other) * (horizon() + left / decades()) - setup(way);
    if (is_guess_ && gain < setup(way)) continue;
    if (gain > best) best = gain, cheapest = way;
  }
  return cheapest;
}

/// Sets `next` where another way is estimated to cost less; the present way takes so many iterations for a decade.
bool AutomaticInverse::findCheaper(double rate, double left) {
  if (now_.changes >= most_changes || isRefused()) return false;
  const double again = now_.way == Way::multigrid ? renewing() : 0;
  const double iterations = std::max(1.0, rate * decades());
  const double each = now_.way == Way::block_jacobi ? byJacobi(iterations) : iterations * iteration(now_.way);
  const double present = each + turning(now_.way) + again;
  estimateFactors();
  Way way = cheapest(present, left);
  if (way == Way::multigrid && now_.blocks == 0 && now_.lessons.blocks_each == 0)
    notePattern(), way = cheapest(present, left);
  if (isFactored(way) && !now_.is_counted) countFactors(), way = cheapest(present, left);
  if (way == now_.way) return false;
  now_.next = way;
  return true;
}

}  // namespace stroma
