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

void SupernodalFactor::release() {
  for (cholmod_dense** dense : {&right_, &solution_, &work_y_, &work_e_})
    if (*dense) cholmod_free_dense(dense, &analysis_->common);
  analysis_.reset();
}

void SupernodalFactor::releaseNumbers() {
  rough_values_ = Array<float>();
  if (analysis_ && analysis_->factor->xtype != CHOLMOD_PATTERN)
    cholmod_change_factor(CHOLMOD_PATTERN, 1, 1, 1, 1, analysis_->factor, &analysis_->common);
}

bool SupernodalFactor::analyse(const BlockMatrix& matrix, StopToken stop) {
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
  const std::size_t count = analysis_->unknown.size();
  right_ = cholmod_allocate_dense(count, 1, count, CHOLMOD_REAL, &analysis_->common);
  analysis_->check(right_, "allocate a vector");
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

void SupernodalFactor::apply(ConstRows b, Rows x) {
  const NoRegions no_regions;
  double* right = static_cast<double*>(right_->x);
  const std::size_t count = analysis_->unknown.size();
  for (std::size_t k = 0; k < count; ++k) right[k] = b.data[place(k)];
  analysis_->check(cholmod_solve2(CHOLMOD_A, analysis_->factor, right_, nullptr, &solution_, nullptr, &work_y_, &work_e_,
                                  &analysis_->common),
                   "solve");
  const double* solution = static_cast<const double*>(solution_->x);
  for (std::size_t k = 0; k < count; ++k) x.data[place(k)] = solution[k];
}

// L y = b, L^T x = y; a supernode's columns share their rows, the first of which are the columns' own.
void SupernodalFactor::applyRoughly(ConstRows b, Rows x) {
  const cholmod_factor& factor = *analysis_->factor;
  const double* values = static_cast<const double*>(factor.x);
  const std::size_t unknowns = analysis_->unknown.size();
  if (rough_values_.empty()) rough_values_.assign(values, values + factor.xsize);
  rough_.resize(unknowns), gathered_.resize(unknowns);
  // as single precision has a smaller range
  const double scale = std::max(std::numeric_limits<double>::min(), largest(b));
  for (std::size_t k = 0; k < unknowns; ++k) rough_[k] = float(b.data[place(k)] / scale);

  const int *first = static_cast<int*>(factor.super), *start = static_cast<int*>(factor.pi);
  const int *offset = static_cast<int*>(factor.px), *rows = static_cast<int*>(factor.s), one = 1;
  const float plus = 1, minus = -1, zero = 0;
  const int count = int(factor.nsuper);
  for (int s = 0; s < count; ++s) {
    const int columns = first[s + 1] - first[s], height = start[s + 1] - start[s], below = height - columns;
    const float* block = rough_values_.data() + offset[s];
    float* own = rough_.data() + first[s];
    strsv_("L", "N", "N", &columns, block, &height, own, &one);
    if (below == 0) continue;
    sgemv_("N", &below, &columns, &plus, block + columns, &height, own, &one, &zero, gathered_.data(), &one);
    const int* to = rows + start[s] + columns;
    for (int i = 0; i < below; ++i) rough_[to[i]] -= gathered_[i];
  }
  for (int s = count - 1; s >= 0; --s) {
    const int columns = first[s + 1] - first[s], height = start[s + 1] - start[s], below = height - columns;
    const float* block = rough_values_.data() + offset[s];
    float* own = rough_.data() + first[s];
    const int* from = rows + start[s] + columns;
    for (int i = 0; i < below; ++i) gathered_[i] = rough_[from[i]];
    if (below > 0)
      sgemv_("T", &below, &columns, &minus, block + columns, &height, gathered_.data(), &one, &plus, own, &one);
    strsv_("L", "T", "N", &columns, block, &height, own, &one);
  }
  for (std::size_t k = 0; k < unknowns; ++k) x.data[place(k)] = scale * double(rough_[k]);
}

}  // namespace stroma
