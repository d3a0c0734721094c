// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/supernodal_factor.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>

#include "framework/algebra/parallel.h"

// of OpenBLAS; absent from other libraries
extern "C" __attribute__((weak)) void openblas_set_num_threads(int);
extern "C" __attribute__((weak)) int openblas_get_num_threads();

extern "C" {
void strsv_(const char* uplo, const char* trans, const char* diag, const int* n, const float* a, const int* lda,
            float* x, const int* incx);
void sgemv_(const char* trans, const int* m, const int* n, const float* alpha, const float* a, const int* lda,
            const float* x, const int* incx, const float* beta, float* y, const int* incy);
void dtrsv_(const char* uplo, const char* trans, const char* diag, const int* n, const double* a, const int* lda, double* x,
            const int* incx);
void dgemv_(const char* trans, const int* m, const int* n, const double* alpha, const double* a, const int* lda, const double* x,
            const int* incx, const double* beta, double* y, const int* incy);
}

namespace stroma {
namespace {

// Three things make a factorisation several times as fast as a plain call:
// - the nodes are ordered, not the unknowns (a ninth of the pattern), and the matrix is handed over already permuted, so
//   that CHOLMOD neither permutes nor copies it again at each factorisation;
// - CHOLMOD's OpenMP regions, too short for their threads, are switched off around the call;
// - each call of the BLAS runs on one thread: OpenBLAS sums in another order on two, and no result may depend on their
//   number. Threads share the supernodes and their pieces instead.
// The numbers are made by a loop of our own (supernodal_numbers.h): CHOLMOD's does not stop when it is asked to.

/// OpenBLAS takes 128 MB of address space for each thread at its first call. Where there is none left (ulimit -v) it tries
/// again for ever, so that somebody has to look before.
bool hasRoomForBlas() {
  static std::atomic<int> known = 0;  // threads that had it
  const int wanted = threads();
  if (known.load() >= wanted) return true;
  std::vector<void*> rooms;  // one by one, as OpenBLAS asks: a kernel refuses what is larger than the machine at once
  while (int(rooms.size()) < wanted) {
    rooms.push_back(std::malloc(std::size_t(130) << 20));
    if (!rooms.back()) break;
  }
  const bool has_room = rooms.back() != nullptr;
  for (void* room : rooms) std::free(room);
  if (has_room) known = wanted;
  return has_room;
}

}  // namespace

void SupernodalFactor::release() { analysis_.reset(); }

void SupernodalFactor::releaseNumbers() {
  rough_values_ = Array<float>();
  side_works_.release();
  if (analysis_ && analysis_->factor->xtype != CHOLMOD_PATTERN)
    cholmod_change_factor(CHOLMOD_PATTERN, 1, 1, 1, 1, analysis_->factor, &analysis_->common);
}

bool SupernodalFactor::analyse(const BlockMatrix& matrix, StopToken stop) {
  if (analysis_ && analysis_->isOf(matrix)) return true;
  std::shared_ptr<SupernodalAnalysis> analysis = SupernodalAnalysis::of(matrix, stop);
  if (analysis)
    take(std::move(analysis));
  else
    release();
  return analysis_ != nullptr;
}

void SupernodalFactor::take(std::shared_ptr<SupernodalAnalysis> analysis) {
  release();
  analysis_ = std::move(analysis);
  numbers_.setPattern(analysis_->supernodes());
  parent_.clear();
}

void SupernodalFactor::load(const BlockMatrix& matrix) {
  const double* __restrict values = matrix.values().data();
  double* __restrict out = static_cast<double*>(analysis_->lower->x);
  const std::vector<int>& source = analysis_->source;
  for (std::size_t i = 0; i < source.size(); ++i) out[i] = values[source[i]];
  rough_values_.clear();
}

SolveStop SupernodalFactor::factor(Index& row, StopToken stop) {
  const NoRegions no_regions;
  if (openblas_set_num_threads && openblas_get_num_threads() != 1) openblas_set_num_threads(1);
  analysis_->check(hasRoomForBlas(), "take the buffers that the BLAS works in, 128 MB for each thread: out of memory");
  cholmod_factor& factor = *analysis_->factor;
  const cholmod_sparse& lower = *analysis_->lower;
  if (factor.xtype == CHOLMOD_PATTERN) {  // makes room for the numbers
    cholmod_change_factor(CHOLMOD_REAL, 1, 1, 1, 1, &factor, &analysis_->common);
    analysis_->check(factor.xtype == CHOLMOD_REAL, "allocate the factor");
  }
  const auto* values = static_cast<const double*>(lower.x);
  const SupernodalEnd end =
      numbers_.factor({static_cast<const int*>(lower.p), static_cast<const int*>(lower.i), values},
                      static_cast<double*>(factor.x), stop);
  factor.minor = end.bad_column < 0 ? factor.n : std::size_t(end.bad_column);
  if (end.stopped) return SolveStop::stopped;
  if (end.bad_column < 0) return SolveStop::converged;
  row = analysis_->unknown[std::size_t(end.bad_column)] / 3;
  return SolveStop::not_definite;
}

namespace {

constexpr int one_step = 1;
void solveTriangle(const char* transposed, int n, const double* a, int stride, double* x) {
  dtrsv_("L", transposed, "N", &n, a, &stride, x, &one_step);
}
void solveTriangle(const char* transposed, int n, const float* a, int stride, float* x) {
  strsv_("L", transposed, "N", &n, a, &stride, x, &one_step);
}
/// y = factor A x + keep y
void multiply(const char* transposed, int rows, int columns, double factor, const double* a, int stride, const double* x,
              double keep, double* y) {
  dgemv_(transposed, &rows, &columns, &factor, a, &stride, x, &one_step, &keep, y, &one_step);
}
void multiply(const char* transposed, int rows, int columns, float factor, const float* a, int stride, const float* x, float keep,
              float* y) {
  sgemv_(transposed, &rows, &columns, &factor, a, &stride, x, &one_step, &keep, y, &one_step);
}
/// Panels of so many numbers take less time than two calls of BLAS.
constexpr int most_small_numbers = 512;

/// L y = b in place of a panel; `below` gets what its rows below take away from others.
template <class Number>
void solveForward(const Number* panel, int columns, int height, Number* own, Number* below) {
  if (columns * height > most_small_numbers) {
    solveTriangle("N", columns, panel, height, own);
    if (height > columns) multiply("N", height - columns, columns, Number(1), panel + columns, height, own, Number(0), below);
    return;
  }
  std::fill_n(below, height - columns, Number(0));
  for (int j = 0; j < columns; ++j, panel += height) {
    const Number solved = own[j] /= panel[j];
    for (int i = j + 1; i < columns; ++i) own[i] -= solved * panel[i];
    for (int i = columns; i < height; ++i) below[i - columns] += solved * panel[i];
  }
}
/// L^T x = y, less what `below` of x takes away.
template <class Number>
void solveBackward(const Number* panel, int columns, int height, Number* own, const Number* below) {
  if (columns * height > most_small_numbers) {
    if (height > columns) multiply("T", height - columns, columns, Number(-1), panel + columns, height, below, Number(1), own);
    solveTriangle("T", columns, panel, height, own);
    return;
  }
  for (int j = columns; j-- > 0;) {
    const Number* const column = panel + j * height;
    Number sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int i = columns; i < height; ++i) sum += column[i] * below[i - columns];
    for (int i = j + 1; i < columns; ++i) sum += column[i] * own[i];
    own[j] = (own[j] - sum) / column[j];
  }
}

/// L y = b, L^T x = y in place; a supernode's columns share their rows, the first of which are the columns' own.
template <class Number>
void solveBoth(const SupernodalPattern& pattern, const Number* values, Number* x, Number* gathered) {
  for (int s = 0; s < pattern.count; ++s) {
    const int columns = pattern.columnsOf(s), height = pattern.heightOf(s);
    solveForward(values + pattern.offset[s], columns, height, x + pattern.first[s], gathered);
    const int* const to = pattern.rowsOf(s) + columns;
    for (int i = 0; i < height - columns; ++i) x[to[i]] -= gathered[i];
  }
  for (int s = pattern.count - 1; s >= 0; --s) {
    const int columns = pattern.columnsOf(s), height = pattern.heightOf(s);
    const int* const from = pattern.rowsOf(s) + columns;
    for (int i = 0; i < height - columns; ++i) gathered[i] = x[from[i]];
    solveBackward(values + pattern.offset[s], columns, height, x + pattern.first[s], gathered);
  }
}

}  // namespace

void SupernodalFactor::apply(ConstRows b, Rows x) {
  const std::size_t count = analysis_->unknown.size();
  right_.resize(count), gathered_right_.resize(count);
  for (std::size_t k = 0; k < count; ++k) right_[k] = b.data[place(k)];
  solveBoth(analysis_->supernodes(), static_cast<const double*>(analysis_->factor->x), right_.data(), gathered_right_.data());
  for (std::size_t k = 0; k < count; ++k) x.data[place(k)] = right_[k];
}

void SupernodalFactor::applyAll(std::span<const ConstRows> b, std::span<const Rows> x) {
  if (b.size() < few_sides) return Factorisation::applyAll(b, x);
  const SupernodalPattern pattern = analysis_->supernodes();
  if (parent_.empty()) parent_ = parentsOf(pattern);
  const auto* const values = static_cast<const double*>(analysis_->factor->x);
  const auto panelOf = [&](int s) {
    const int columns = pattern.columnsOf(s), height = pattern.heightOf(s);
    const double* const panel = values + pattern.offset[s];
    return SidePanel<double>{pattern.first[s], columns, height - columns, panel, panel + columns, height, height,
                             pattern.rowsOf(s) + columns, false};
  };
  forSideBlocks<double>(int(b.size()), [&](int first, int count) {
    auto work = side_works_.take();
    const auto numberOf = [&](int side, int k) { return b[std::size_t(first + side)].data[place(std::size_t(k))]; };
    solveSides(pattern, parent_, panelOf, count, numberOf, *work);
    for (std::size_t k = 0; k < analysis_->unknown.size(); ++k)
      for (int side = 0; side < count; ++side)
        x[std::size_t(first + side)].data[place(k)] = work->x[k * sides<double> + std::size_t(side)];
    side_works_.giveBack(std::move(work));
  });
}

void SupernodalFactor::applyRoughly(ConstRows b, Rows x) {
  const cholmod_factor& factor = *analysis_->factor;
  const double* values = static_cast<const double*>(factor.x);
  const std::size_t unknowns = analysis_->unknown.size();
  if (rough_values_.empty()) rough_values_.assign(values, values + factor.xsize);
  rough_.resize(unknowns), gathered_.resize(unknowns);
  // as single precision has a smaller range
  const double scale = std::max(std::numeric_limits<double>::min(), largest(b));
  for (std::size_t k = 0; k < unknowns; ++k) rough_[k] = float(b.data[place(k)] / scale);
  solveBoth(analysis_->supernodes(), rough_values_.data(), rough_.data(), gathered_.data());
  for (std::size_t k = 0; k < unknowns; ++k) x.data[place(k)] = scale * double(rough_[k]);
}

}  // namespace stroma
