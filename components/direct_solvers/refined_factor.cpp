// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/refined_factor.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace stroma {
namespace {

/// Factors of fewer operations, a few milliseconds in double precision, are made in it; and so are those of slender bodies, with
/// few operations for each number: an application would take too much of what is saved.
constexpr double few_operations = 5e7, few_for_each_number = 180;
/// What a solve leaves at most of the right side, and of the solution in the norm of the energy.
constexpr double residual_left = 1e-11, error_left = 1e-11;
/// Of a factorisation, estimated for one core.
double secondsInSingle(const CholeskyFactor& of) { return Factorisation::Cost::of(of.entries(), of.flops(), true).factor; }
double secondsInDouble(const CholeskyFactor& of) { return Factorisation::Cost::of(of.entries(), of.flops(), false).factor; }
/// Seconds of an application for each number, for a solution as good as in double precision, and of a product for each block.
constexpr double application_single = 0.65e-9, application_double = 1.3e-9, product_block = 3e-9;
/// The same of one of many right sides.
constexpr double side_single = 0.07e-9, side_double = 0.14e-9;

/// Where `error` is left after k iterations, they would have to become twice as fast to end in `most`.
bool isHopeless(double error, int k, int most) { return k > 2 && error > std::pow(error_left, k / (2.0 * most)); }

/// Other values give another number, as good as always.
std::int64_t mixedBits(const std::vector<double>& values) {
  constexpr std::size_t lanes = 4;
  constexpr std::uint64_t factor = 0x9e3779b97f4a7c15u;
  const auto mix = [](std::uint64_t into, std::uint64_t bits) { return (std::rotl(into, 29) ^ bits) * factor; };
  std::uint64_t mixed[lanes] = {1, 2, 3, 4};
  std::size_t i = 0;
  for (; i + lanes <= values.size(); i += lanes)
    for (std::size_t l = 0; l < lanes; ++l) mixed[l] = mix(mixed[l], std::bit_cast<std::uint64_t>(values[i + l]));
  for (; i < values.size(); ++i) mixed[0] = mix(mixed[0], std::bit_cast<std::uint64_t>(values[i]));
  for (std::size_t l = 1; l < lanes; ++l) mixed[0] = mix(mixed[0], mixed[l]);
  return std::bit_cast<std::int64_t>(mixed[0]);
}

void clearAll(std::span<const Rows> x) {
  for (const Rows& each : x) clear(each);
}

}  // namespace

RefinedFactor::RefinedFactor(FactorPrecision precision, std::shared_ptr<FactorRecord> record)
    : wanted_(precision), record_(record ? std::move(record) : std::make_shared<FactorRecord>()) {}

/// A field that takes another tangent asks for a pattern anew, and mostly has the same one.
bool RefinedFactor::analyse(const BlockMatrix& matrix, StopToken stop) {
  if (analysis_ && analysis_->isOf(matrix)) {
    has_fronts_ = has_double_ = false;
    return true;
  }
  analysis_ = SupernodalAnalysis::of(matrix, stop, record_->analysis.lock().get());
  record_->analysis = analysis_;
  has_fronts_ = has_analysis_ = has_double_ = false;
  if (!analysis_) return false;
  uses_single_ = wanted_ == FactorPrecision::in_single ||
               (wanted_ == FactorPrecision::automatic && flops() >= std::max(few_operations, few_for_each_number * entries()));
  if (!uses_single_) return true;
  matrix_ = matrix;
  const cholmod_sparse& lower = *analysis_->lower;
  fronts_.setPattern(analysis_->supernodes(), static_cast<const int*>(lower.p), static_cast<const int*>(lower.i));
  scale_.resize(analysis_->unknown.size());
  place_.clear();
  for (const int unknown : analysis_->unknown) place_.push_back(std::size_t(unknown / 3 * row_doubles + unknown % 3));
  solution_.resize(analysis_->unknown.size());
  blocks_.release();
  return true;
}

void RefinedFactor::load(const BlockMatrix& matrix) {
  has_fronts_ = has_double_ = false;
  if (!uses_single_) return loadInDouble(matrix);
  std::copy(matrix.values().begin(), matrix.values().end(), matrix_.values().begin());
  loaded_ = mixedBits(matrix_.values());
  if (!record_->memory) own_ = {};
  remember();
}

/// That the loaded values are others than those of the last matrix. What is saved counts for some matrices only: a run whose solves have
/// become more is not to lose for long.
void RefinedFactor::remember() {
  constexpr double most_saved = 4;  // matrices
  FactorMemory& now = memory();
  if (loaded_ == now.values) return;
  if (!now.is_double && now.values != 0) {
    now.saved = std::clamp(now.saved + secondsSaved() - now.lost, 0.0, most_saved * secondsSaved());
    if (now.lost <= secondsSaved()) now.penalty = 0;
  }
  if (now.is_double) now.saved = 0;
  now.values = loaded_, now.lost = 0;
  now.is_double = now.waiting > 0;
  now.waiting = std::max(0, now.waiting - 1);
}

void RefinedFactor::loadInDouble(const BlockMatrix& matrix) {
  if (!has_analysis_) in_double_.take(analysis_);
  has_analysis_ = true;
  in_double_.load(matrix);
}

SolveStop RefinedFactor::factor(Index& row, StopToken stop) {
  if (!uses_single_) {
    record_->is_single = false;
    return in_double_.factor(row, stop);
  }
  stop_ = stop;
  if (!memory().is_double) {
    const SolveStop end = factorInSingle(stop);
    if (end != SolveStop::not_definite) return end;
    memory().is_double = true;
    const SolveStop again = factorInDouble(row, stop);
    if (again == SolveStop::converged) giveUp();
    return again;
  }
  return factorInDouble(row, stop);
}

// Numbers in one precision do not lie beside those in the other one, which many matrices do not need. Where nothing is remembered
// each matrix may need both.
SolveStop RefinedFactor::factorInSingle(StopToken stop) {
  if (record_->memory) {
    has_double_ = false;
    in_double_.releaseNumbers();
  }
  if (!scaleToUnitDiagonal()) return SolveStop::not_definite;
  const SupernodalEnd end = fronts_.factor(matrix_.values().data(), analysis_->source, scale_, stop);
  if (end.stopped) return SolveStop::stopped;
  has_fronts_ = record_->is_single = end.bad_column < 0;
  return has_fronts_ ? SolveStop::converged : SolveStop::not_definite;
}

SolveStop RefinedFactor::factorInDouble(Index& row, StopToken stop) {
  if (record_->memory) {
    has_fronts_ = false;
    fronts_.release();
  }
  loadInDouble(matrix_);
  const SolveStop end = in_double_.factor(row, stop);
  has_double_ = end == SolveStop::converged;
  record_->is_single = false;
  return end;
}

void RefinedFactor::giveUp() {
  memory().is_double = true;
  ++record_->given_up;
  waitLonger();
}

/// Twice as many matrices as the last time. What was given up cost about half of a factorisation in double precision: less than
/// two per cent of those that follow.
void RefinedFactor::waitLonger() {
  constexpr int least = 31, most = 1023;
  FactorMemory& now = memory();
  now.penalty = now.waiting = std::clamp(2 * now.penalty + 1, least, most);
}

/// By powers of two, which change no digit. False when a number on the diagonal is not positive.
bool RefinedFactor::scaleToUnitDiagonal() {
  for (std::size_t k = 0; k < scale_.size(); ++k) {
    const std::size_t node = std::size_t(analysis_->unknown[k] / 3), c = std::size_t(analysis_->unknown[k] % 3);
    const double value = matrix_.values()[9 * std::size_t(matrix_.diagonal()[node]) + 4 * c];
    if (!(value > 0)) return false;
    scale_[k] = std::ldexp(1.0, -(std::ilogb(value) / 2));
  }
  return true;
}

void RefinedFactor::applyOnce(ConstRows b, Rows x) {
  double size = std::numeric_limits<double>::min();  // single precision has a smaller range
  for (std::size_t k = 0; k < scale_.size(); ++k) size = std::max(size, std::abs(b.data[place_[k]] * scale_[k]));
  for (std::size_t k = 0; k < scale_.size(); ++k) solution_[k] = float(b.data[place_[k]] * scale_[k] / size);
  fronts_.solve(solution_.data());
  for (std::size_t k = 0; k < scale_.size(); ++k) x.data[place_[k]] = size * (scale_[k] * double(solution_[k]));
}

/// Until they have cost what factors in single precision save.
int RefinedFactor::mostApplications() const {
  return int(std::clamp(2 + secondsSaved() / secondsOfIteration(), 4.0, 60.0));
}

double RefinedFactor::secondsSaved() const { return secondsInDouble(*this) - secondsInSingle(*this); }

double RefinedFactor::secondsOfIteration() const {
  return application_single * entries() + product_block * matrix_.blocks();
}

double RefinedFactor::secondsOfSide(bool in_single) const {
  return (in_single ? side_single : side_double) * entries() + product_block * matrix_.blocks();
}

/// Of the residuals of the sides that are going, at once.
void RefinedFactor::applyTo(Block& block) {
  if (block.count == 1) return applyOnce(block.sides[0].residual, block.sides[0].step);
  block.sizes.clear();
  for (const int i : block.going) {
    const double* const from = block.sides[std::size_t(i)].residual.rows().data;
    double size = std::numeric_limits<double>::min();
    for (std::size_t k = 0; k < scale_.size(); ++k) size = std::max(size, std::abs(from[place_[k]] * scale_[k]));
    block.sizes.push_back(size);
  }
  const int count = int(block.going.size());
  const auto sideOf = [&](int side) -> Side& { return block.sides[std::size_t(block.going[std::size_t(side)])]; };
  fronts_.solveSides(
      count,
      [&](int side, int k) {
        return sideOf(side).residual.rows().data[place_[std::size_t(k)]] * scale_[std::size_t(k)] / block.sizes[std::size_t(side)];
      },
      block.work);
  for (int side = 0; side < count; ++side) {
    double* const to = sideOf(side).step.rows().data;
    for (std::size_t k = 0; k < scale_.size(); ++k)
      to[place_[k]] = block.sizes[std::size_t(side)] * (scale_[k] * double(block.work.x[k * sides<float> + std::size_t(side)]));
  }
}

/// Iteration k of conjugate gradients, with the form of beta for a preconditioner that is linear to round-off only. False when it
/// would take too many iterations, or A is not positive definite.
bool RefinedFactor::advance(Side& s, Rows x, int k, int most) {
  const double energy = dot(s.residual, s.step);
  s.iterations = k + 1, s.is_solved = energy == 0;
  if (!(energy > 0)) return s.is_solved;
  if (k > 0 && isHopeless(std::sqrt(energy / s.first), k, most)) return false;
  if (k == 0)
    s.first = energy, copy(s.step, s.direction);
  else
    xpay(s.step, -s.length * dot(s.step, s.product) / s.former, s.direction);
  matrix_.multiply(s.direction, s.product);
  const double curvature = dot(s.direction, s.product);
  if (!(curvature > 0)) return false;
  s.length = dot(s.direction, s.residual) / curvature;
  axpy(s.length, s.direction, x);
  axpy(-s.length, s.product, s.residual);
  // the error before this iteration, and after it if it shrinks as much as in the one before
  const double error = std::sqrt(energy / s.first), next = k == 0 ? 1 : error * std::sqrt(energy / s.former);
  if (norm(s.residual) <= residual_left * s.size && next <= error_left) s.is_solved = true;
  s.former = energy;
  return true;
}

/// Ends where one of them has no solution in this way.
void RefinedFactor::solveBlock(std::span<const ConstRows> b, std::span<const Rows> x, int most, StopToken stop, Block& block) {
  block.count = b.size();
  if (block.sides.size() < b.size()) block.sides.resize(b.size());
  block.going.clear();
  for (std::size_t i = 0; i < b.size(); ++i) {
    Side& side = block.sides[i];
    for (Vector* vector : {&side.residual, &side.step, &side.direction, &side.product})
      if (vector->count() != b[i].count) vector->resize(b[i].count);
    side.size = norm(b[i]), side.iterations = 0, side.is_solved = false;
    clear(x[i]), copy(b[i], side.residual);
    if (side.size > 0) block.going.push_back(int(i));
  }
  for (int k = 0; k < most && !block.going.empty(); ++k) {
    if (stop.isStopAsked()) return;
    applyTo(block);
    for (const int i : block.going)
      if (!advance(block.sides[std::size_t(i)], x[std::size_t(i)], k, most)) return;
    std::erase_if(block.going, [&](int i) { return block.sides[std::size_t(i)].is_solved; });
  }
}

/// False when some right side has no solution in this way.
bool RefinedFactor::solve(std::span<const ConstRows> b, std::span<const Rows> x, StopToken stop) {
  const int most = mostApplications(), wide = b.size() < few_sides ? 1 : sides<float>, blocks = (int(b.size()) + wide - 1) / wide;
  iterations_.assign(b.size(), 0);
  const auto solveAt = [&](int k) {
    const auto first = b.size() * std::size_t(k) / std::size_t(blocks), end = b.size() * std::size_t(k + 1) / std::size_t(blocks);
    auto block = blocks_.take();
    solveBlock(b.subspan(first, end - first), x.subspan(first, end - first), most, stop, *block);
    for (std::size_t i = first; i < end; ++i) {
      const Side& side = block->sides[i - first];
      iterations_[i] = side.is_solved || side.size == 0 ? side.iterations : -side.iterations - 1;
    }
    blocks_.giveBack(std::move(block));
  };
  if (wide == 1)
    for (int k = 0; k < blocks; ++k) solveAt(k);  // each with all threads
  else
    parallelFor(blocks, solveAt);
  bool are_good = true;
  for (const int made : iterations_) {
    const int iterations = made < 0 ? -made - 1 : made;
    are_good = are_good && made >= 0;
    if (made == 0) continue;
    ++record_->solves, record_->applications += iterations;
    if (made > 0)
      noteSolved(wide == 1 ? iterations * secondsOfIteration() - application_double * entries()
                           : iterations * secondsOfSide(true) - secondsOfSide(false));
  }
  return are_good;
}

/// `seconds`: longer than with factors in double precision.
void RefinedFactor::noteSolved(double seconds) {
  FactorMemory& now = memory();
  const double all_saved = secondsSaved() + now.saved;
  const bool paid = now.lost <= all_saved;
  now.lost += std::max(0.0, seconds);
  if (paid && now.lost > all_saved) waitLonger();
  now.is_double = now.lost > secondsInDouble(*this);  // from the next one on
}

/// So many that factors in double precision take less time are solved for with these at once.
void RefinedFactor::expectSides(std::size_t count) {
  constexpr double usual = 2.5;  // iterations
  const double seconds = double(count) * (usual * secondsOfSide(true) - secondsOfSide(false));
  if (count >= few_sides && seconds > secondsInDouble(*this)) noteSolved(seconds);
}

void RefinedFactor::applyAll(std::span<const ConstRows> b, std::span<const Rows> x) {
  if (!uses_single_) return in_double_.applyAll(b, x);
  const StopToken stop = std::exchange(stop_, {});  // later, its owner may have gone
  FactorMemory& now = memory();
  Index row = -1;
  remember();  // whoever factored them may have had no memory
  if (!record_->memory) now.is_double = true;  // of others' matrices nothing is remembered
  if (!now.is_double) expectSides(b.size());
  if (!now.is_double) {
    if ((has_fronts_ || factorInSingle(stop) == SolveStop::converged) && solve(b, x, stop)) return;
    if (stop.isStopAsked()) return clearAll(x);
    now.is_double = true;
    if (factorInDouble(row, stop) == SolveStop::converged) giveUp();
  } else if (!has_double_ && !stop.isStopAsked()) {
    factorInDouble(row, stop);
  }
  has_double_ ? in_double_.applyAll(b, x) : clearAll(x);
}

void RefinedFactor::applyRoughly(ConstRows b, Rows x) {
  if (has_fronts_)
    applyOnce(b, x);
  else
    in_double_.applyRoughly(b, x);
}

Factorisation::Cost RefinedFactor::cost() const {
  if (!uses_single_) return in_double_.cost();
  return Cost::of(entries(), flops(), true);
}

std::unique_ptr<CholeskyFactor> CholeskyFactor::make(FactorPrecision precision, std::shared_ptr<FactorRecord> record) {
  if (precision == FactorPrecision::in_double) return std::make_unique<SupernodalFactor>();
  return std::make_unique<RefinedFactor>(precision, std::move(record));
}

}  // namespace stroma
