// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/cholesky_factor.h"

#include <SuiteSparse_config.h>
#include <cholmod.h>
#include <omp.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <mutex>
#include <numeric>
#include <stdexcept>

#include "components/direct_solvers/supernodal_numbers.h"
#include "framework/algebra/memory.h"
#include "framework/algebra/ordering_lock.h"
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
// - the nodes are ordered, not the unknowns (a ninth of the pattern), and the matrix is handed over already permuted,
// so
//   that CHOLMOD neither permutes nor copies it again at each factorisation;
// - CHOLMOD 5 opens OpenMP regions of four threads in loops that are too short for them (28 ms against 7 for 3,993
//   unknowns), so its regions are switched off around the call;
// - each call of the BLAS runs on one thread: OpenBLAS sums in another order on two, and no result may depend on their
//   number. Threads share the supernodes and their pieces instead.
// The numbers are made by a loop of our own (supernodal_numbers.h): CHOLMOD's does not stop when it is asked to.

/// Memory for CHOLMOD: a factor is written once and read a few times, so that small pages, each a fault, cost as much
/// as the factorisation (16^3 hexahedra: 140 MB, a third of the run).
void* allocateForCholmod(std::size_t bytes) {
  try {
    return allocateArray(bytes);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

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

/// Keeps CHOLMOD's short loops on one thread.
class NoRegions {
 public:
  NoRegions() : before_(omp_get_max_active_levels()) { omp_set_max_active_levels(0); }
  ~NoRegions() { omp_set_max_active_levels(before_); }

 private:
  int before_;
};

/// A supernodal factor of a symmetric block matrix, kept over many matrices of one pattern.
class SupernodalFactor final : public CholeskyFactor {
 public:
  SupernodalFactor();
  ~SupernodalFactor() override {
    release();
    cholmod_finish(&common_);
  }
  void analyse(const BlockMatrix& matrix) override;
  void load(const BlockMatrix& matrix) override;  ///< the upper triangle
  /// `row` is the one at which a pivot was not positive.
  SolveStop factor(Index& row, StopToken stop) override;
  void apply(ConstRows b, Rows x) override;
  /// In single precision, which reads half as much.
  void applyRoughly(ConstRows b, Rows x) override;
  const std::string& ordering() const override { return ordering_; }
  double flops() const override { return flops_; }
  double entries() const override { return entries_; }
  /// Fitted to 1,331 to 15,625 nodes of hexahedra on a core of 65 Gflop/s.
  Cost cost() const override { return {flops_ / 40e9 + 8e-9 * entries_, 1e-9 * entries_}; }

 private:
  void release();
  void check(bool good, const char* what) const;
  SupernodalPattern supernodes() const;
  cholmod_sparse* nodeGraph(const BlockMatrix& matrix);
  std::vector<int> orderUnknowns(const BlockMatrix& matrix);
  void buildLower(const BlockMatrix& matrix, const std::vector<int>& order);
  std::size_t place(std::size_t k) const { return std::size_t(unknown_[k] / 3 * row_doubles + unknown_[k] % 3); }

  cholmod_common common_;
  cholmod_sparse* lower_ = nullptr;  ///< permuted lower triangle
  cholmod_factor* factor_ = nullptr;
  SupernodalNumbers numbers_;
  cholmod_dense *right_ = nullptr, *solution_ = nullptr, *work_y_ = nullptr, *work_e_ = nullptr;
  Array<float> rough_values_;  ///< the factor in single precision; empty: none yet
  std::vector<float> rough_, gathered_;
  std::vector<int> source_;   ///< shape (entries of lower_): where each value lies in the block matrix
  std::vector<int> unknown_;  ///< shape (3 rows): the unknown at each place of the permuted order
  std::string ordering_;
  double flops_ = 0, entries_ = 0;  ///< of a factorisation, and in the factor
};

SupernodalFactor::SupernodalFactor() {
  [[maybe_unused]] static const bool once = [] {
    SuiteSparse_config.malloc_func = allocateForCholmod;
    return true;
  }();
  cholmod_start(&common_);
  common_.supernodal = CHOLMOD_SUPERNODAL;
  common_.nmethods = 1;
  common_.print = 0;
  common_.quick_return_if_not_posdef = 1;
}

void SupernodalFactor::release() {
  cholmod_free_sparse(&lower_, &common_);
  cholmod_free_factor(&factor_, &common_);
  for (cholmod_dense** dense : {&right_, &solution_, &work_y_, &work_e_}) cholmod_free_dense(dense, &common_);
}

void SupernodalFactor::check(bool good, const char* what) const {
  if (good && common_.status >= 0) return;
  const char* cause = common_.status == CHOLMOD_OUT_OF_MEMORY ? ": out of memory"
                      : common_.status == CHOLMOD_TOO_LARGE ? ": the factor has more entries than a 32-bit index counts"
                                                            : "";
  throw std::runtime_error(std::string("SparseLDLSolver could not ") + what + cause);
}

/// The permuted lower triangle: its column k holds unknown order[k], and the source of each value is noted.
void SupernodalFactor::buildLower(const BlockMatrix& matrix, const std::vector<int>& order) {
  const int count = 3 * matrix.rows();
  std::vector<int> place_of(order.size()), start(order.size() + 1, 0), rows;
  for (int k = 0; k < count; ++k) place_of[order[k]] = k;
  std::vector<std::pair<int, int>> column;  // row, source
  source_.clear();
  for (int k = 0; k < count; ++k) {
    const int block_row = order[k] / 3, component = order[k] % 3;
    column.clear();
    for (Index s = matrix.rowStart()[block_row]; s < matrix.rowStart()[block_row + 1]; ++s)
      for (int c = 0; c < 3; ++c) {
        const int row = place_of[std::size_t(3 * matrix.columns()[s] + c)];
        if (row < k) continue;
        // an entry is read from the upper triangle, whichever side of the permuted diagonal it lies on
        const int i = 3 * block_row + component, j = 3 * matrix.columns()[s] + c;
        const Index slot = i <= j ? s : matrix.slot(j / 3, i / 3);
        column.emplace_back(row, i <= j ? 9 * slot + 3 * component + c : 9 * slot + 3 * c + component);
      }
    std::sort(column.begin(), column.end());
    for (const auto& [row, from] : column) rows.push_back(row), source_.push_back(from);
    start[k + 1] = int(rows.size());
  }
  cholmod_free_sparse(&lower_, &common_);
  lower_ = cholmod_allocate_sparse(order.size(), order.size(), rows.size(), 1, 1, -1, CHOLMOD_REAL, &common_);
  check(lower_, "allocate the matrix");
  std::copy(start.begin(), start.end(), static_cast<int*>(lower_->p));
  std::copy(rows.begin(), rows.end(), static_cast<int*>(lower_->i));
}

cholmod_sparse* SupernodalFactor::nodeGraph(const BlockMatrix& matrix) {
  const std::size_t nodes = std::size_t(matrix.rows());
  cholmod_sparse* graph =
      cholmod_allocate_sparse(nodes, nodes, std::size_t(matrix.blocks()), 1, 1, -1, CHOLMOD_PATTERN, &common_);
  check(graph, "allocate the graph");
  int entries = 0;
  int* start = static_cast<int*>(graph->p);
  for (std::size_t i = 0; i < nodes; ++i) {
    start[i] = entries;
    for (Index s = matrix.diagonal()[i]; s < matrix.rowStart()[i + 1]; ++s)
      static_cast<int*>(graph->i)[entries++] = matrix.columns()[s];
  }
  start[nodes] = entries;
  return graph;
}

/// The order of the unknowns that costs the fewest flops, postordered. Orders are compared on the graph of the nodes:
/// a node's three unknowns have one pattern.
std::vector<int> SupernodalFactor::orderUnknowns(const BlockMatrix& matrix) {
  std::vector<int> node_order(std::size_t(matrix.rows())), best;
  const std::lock_guard lock(orderingLock());
  cholmod_sparse* graph = nodeGraph(matrix);
  common_.method[0].ordering = CHOLMOD_GIVEN;
  common_.supernodal = CHOLMOD_SIMPLICIAL;
  common_.postorder = 1;
  double flops = 0;
  for (const char* method : {"METIS", "AMD"}) {
    const bool good = *method == 'M' ? cholmod_metis(graph, nullptr, 0, 1, node_order.data(), &common_)
                                     : cholmod_amd(graph, nullptr, 0, node_order.data(), &common_);
    if (!good) continue;
    cholmod_factor* trial = cholmod_analyze_p(graph, node_order.data(), nullptr, 0, &common_);
    if (trial && (best.empty() || common_.fl < flops)) {
      const int* permutation = static_cast<int*>(trial->Perm);
      best.assign(permutation, permutation + node_order.size());
      flops = common_.fl;
      ordering_ = method;
    }
    cholmod_free_factor(&trial, &common_);
  }
  common_.supernodal = CHOLMOD_SUPERNODAL;
  cholmod_free_sparse(&graph, &common_);
  check(!best.empty(), "order the matrix");
  std::vector<int> order(best.size() * 3);
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = 3 * best[k / 3] + int(k % 3);
  return order;
}

void SupernodalFactor::analyse(const BlockMatrix& matrix) {
  const NoRegions no_regions;
  release();
  unknown_ = orderUnknowns(matrix);
  buildLower(matrix, unknown_);
  common_.method[0].ordering = CHOLMOD_NATURAL;
  common_.postorder = 0;
  factor_ = cholmod_analyze(lower_, &common_);
  check(factor_, "analyse the matrix");
  numbers_.setPattern(supernodes());
  flops_ = common_.fl, entries_ = common_.lnz;
  right_ = cholmod_allocate_dense(unknown_.size(), 1, unknown_.size(), CHOLMOD_REAL, &common_);
  check(right_, "allocate a vector");
}

void SupernodalFactor::load(const BlockMatrix& matrix) {
  const double* __restrict values = matrix.values().data();
  double* __restrict out = static_cast<double*>(lower_->x);
  for (std::size_t i = 0; i < source_.size(); ++i) out[i] = values[source_[i]];
  rough_values_.clear();
}

SolveStop SupernodalFactor::factor(Index& row, StopToken stop) {
  const NoRegions no_regions;
  if (openblas_set_num_threads && openblas_get_num_threads() != 1) openblas_set_num_threads(1);
  check(hasRoomForBlas(), "take the buffers that the BLAS works in, 128 MB for each thread: out of memory");
  if (factor_->xtype == CHOLMOD_PATTERN) {  // makes room for the numbers
    cholmod_change_factor(CHOLMOD_REAL, 1, 1, 1, 1, factor_, &common_);
    check(factor_->xtype == CHOLMOD_REAL, "allocate the factor");
  }
  const auto* values = static_cast<const double*>(lower_->x);
  const SupernodalEnd end =
      numbers_.factor({static_cast<const int*>(lower_->p), static_cast<const int*>(lower_->i), values},
                      static_cast<double*>(factor_->x), stop);
  factor_->minor = end.bad_column < 0 ? factor_->n : std::size_t(end.bad_column);
  if (end.stopped) return SolveStop::stopped;
  if (end.bad_column < 0) return SolveStop::converged;
  row = unknown_[std::size_t(end.bad_column)] / 3;
  return SolveStop::not_definite;
}

SupernodalPattern SupernodalFactor::supernodes() const {
  return {int(factor_->n),
          int(factor_->nsuper),
          static_cast<const int*>(factor_->super),
          static_cast<const int*>(factor_->pi),
          static_cast<const int*>(factor_->px),
          static_cast<const int*>(factor_->s)};
}

void SupernodalFactor::apply(ConstRows b, Rows x) {
  const NoRegions no_regions;
  double* right = static_cast<double*>(right_->x);
  for (std::size_t k = 0; k < unknown_.size(); ++k) right[k] = b.data[place(k)];
  check(cholmod_solve2(CHOLMOD_A, factor_, right_, nullptr, &solution_, nullptr, &work_y_, &work_e_, &common_),
        "solve");
  const double* solution = static_cast<const double*>(solution_->x);
  for (std::size_t k = 0; k < unknown_.size(); ++k) x.data[place(k)] = solution[k];
}

// L y = b, L^T x = y; a supernode's columns share their rows, the first of which are the columns' own.
void SupernodalFactor::applyRoughly(ConstRows b, Rows x) {
  const double* values = static_cast<const double*>(factor_->x);
  if (rough_values_.empty()) rough_values_.assign(values, values + factor_->xsize);
  rough_.resize(unknown_.size()), gathered_.resize(unknown_.size());
  // as single precision has a smaller range
  const double scale = std::max(std::numeric_limits<double>::min(), largest(b));
  for (std::size_t k = 0; k < unknown_.size(); ++k) rough_[k] = float(b.data[place(k)] / scale);

  const int *first = static_cast<int*>(factor_->super), *start = static_cast<int*>(factor_->pi);
  const int *offset = static_cast<int*>(factor_->px), *rows = static_cast<int*>(factor_->s), one = 1;
  const float plus = 1, minus = -1, zero = 0;
  const int count = int(factor_->nsuper);
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
  for (std::size_t k = 0; k < unknown_.size(); ++k) x.data[place(k)] = scale * double(rough_[k]);
}

}  // namespace

std::unique_ptr<CholeskyFactor> CholeskyFactor::make() { return std::make_unique<SupernodalFactor>(); }

}  // namespace stroma
