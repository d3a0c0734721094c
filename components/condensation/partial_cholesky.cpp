// SPDX-License-Identifier: LGPL-2.1-or-later
// PartialCholesky by CHOLMOD's orders and supernodes: the eliminated nodes are ordered for little fill, those that are
// kept come last, so that the last columns of L are the dense factor of the Schur complement; nothing of the interior
// is ever inverted. Two orders are tried, nested dissection of the eliminated nodes (METIS) and minimum degree with the
// kept nodes held back (CAMD); the one with fewer operations is taken. It registers no component: the condensed solvers
// of the module use it.
//
// The numbers are computed here, supernode by supernode from the left, by the same calls of BLAS as CHOLMOD's. Its own
// factorisation says nothing until it is over, which takes minutes for large bodies, and it leaves a factor in which
// both parts lie mixed: taking it apart needed the memory of two.
#include "components/condensation/partial_cholesky.h"

#include <cholmod.h>
#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <numeric>
#include <stdexcept>

#include "framework/algebra/ordering_lock.h"
#include "framework/algebra/parallel.h"
#include "framework/scene/factory.h"

// of OpenBLAS; absent from other libraries
extern "C" __attribute__((weak)) void openblas_set_num_threads(int);
extern "C" __attribute__((weak)) int openblas_get_num_threads();

extern "C" {
void dtrsm_(const char* side, const char* uplo, const char* trans, const char* diag, const int* m, const int* n,
            const double* alpha, const double* a, const int* lda, double* b, const int* ldb);
void dsyrk_(const char* uplo, const char* trans, const int* n, const int* k, const double* alpha, const double* a,
            const int* lda, const double* beta, double* c, const int* ldc);
void dgemm_(const char* transa, const char* transb, const int* m, const int* n, const int* k, const double* alpha,
            const double* a, const int* lda, const double* b, const int* ldb, const double* beta, double* c,
            const int* ldc);
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
}

namespace stroma {
namespace {

/// A pivot below this times the diagonal entry it started from has no right digit.
constexpr double lost_pivot = 1e-13;

/// CHOLMOD 5 opens OpenMP regions in loops that are too short for them.
class NoRegions {
 public:
  NoRegions() : before_(omp_get_max_active_levels()) {
    omp_set_max_active_levels(0);
    // on two threads OpenBLAS sums in another order, and no result may depend on their number
    if (openblas_set_num_threads && openblas_get_num_threads() != 1) openblas_set_num_threads(1);
  }
  ~NoRegions() { omp_set_max_active_levels(before_); }

 private:
  int before_;
};

class CholmodPartialCholesky final : public PartialCholesky {
 public:
  CholmodPartialCholesky();
  ~CholmodPartialCholesky() override;
  std::vector<Index> analyse(const BlockMatrix& matrix, Index eliminated, bool as_they_are) override;
  double peakBytes() const override;
  double flops() const override { return flops_; }
  Index factor(const std::function<void(double)>& progress) override;
  SupernodalColumns eliminated() const override;
  Array<double>& kept() override { return kept_; }
  bool shift(const std::vector<double>& diagonal) override;
  void invert(const Sink& sink, const std::function<void(double)>& progress) override;

 private:
  void check(bool good, const char* what) const;
  cholmod_sparse* graph(const BlockMatrix& matrix, Index nodes);
  void tryOrder(cholmod_sparse* graph, std::vector<int> order, Index eliminated);
  void buildLower(const BlockMatrix& matrix);
  void layOut(const cholmod_factor& symbolic);
  Index eliminate(const std::function<void(double)>& progress);
  void takeColumns(Index first, Index count, double* block, Index height, const std::vector<Index>& place) const;
  void updateBy(Index s, Index done, Index columns, double* block, Index height, Index origin,
                const std::vector<Index>& place);
  void updateKept(Index s);
  Index factorKept(const std::function<void(double)>& progress);
  Index lostPivot() const;
  Index width(Index s) const { return first_[s + 1] - first_[s]; }
  double operationsOf(Index s) const;
  Index below(Index s) const { return Index(row_start_[s + 1] - row_start_[s]); }
  Index keptUnknowns() const { return Index(3 * (order_.size() - std::size_t(eliminated_))); }

  cholmod_common common_;
  cholmod_sparse* lower_ = nullptr;
  std::vector<Index> order_;
  std::vector<double> diagonal_;  ///< of the matrix, in the new order
  Index eliminated_ = 0;
  double flops_ = 0;
  std::vector<std::int32_t> first_, rows_;
  std::vector<std::int64_t> row_start_, start_;
  Array<double> values_, kept_;
  std::vector<Index> kept_place_;  ///< row in kept_ of an unknown
  Array<double> update_;           ///< what one supernode takes from some columns of another
};

CholmodPartialCholesky::CholmodPartialCholesky() {
  cholmod_start(&common_);
  common_.supernodal = CHOLMOD_SUPERNODAL;
  common_.nmethods = 1;
  common_.print = 0;
  common_.quick_return_if_not_posdef = 1;
}

CholmodPartialCholesky::~CholmodPartialCholesky() {
  cholmod_free_sparse(&lower_, &common_);
  cholmod_finish(&common_);
}

void CholmodPartialCholesky::check(bool good, const char* what) const {
  if (good && common_.status >= 0) return;
  throw std::runtime_error(std::string("the condensation could not ") + what +
                           (common_.status == CHOLMOD_OUT_OF_MEMORY ? ": out of memory" : ""));
}

// ---- the order ----

/// The upper triangle of the pattern among the first `nodes` block rows.
cholmod_sparse* CholmodPartialCholesky::graph(const BlockMatrix& matrix, Index nodes) {
  cholmod_sparse* result = cholmod_allocate_sparse(std::size_t(nodes), std::size_t(nodes), std::size_t(matrix.blocks()),
                                                   1, 1, -1, CHOLMOD_PATTERN, &common_);
  check(result, "allocate the graph");
  int entries = 0;
  int *start = static_cast<int*>(result->p), *rows = static_cast<int*>(result->i);
  for (Index i = 0; i < nodes; ++i) {
    start[i] = entries;
    for (Index s = matrix.diagonal()[i]; s < matrix.rowStart()[i + 1]; ++s)
      if (matrix.columns()[s] < nodes) rows[entries++] = matrix.columns()[s];
  }
  start[nodes] = entries;
  return result;
}

/// Keeps the postordered `order` when it costs less than the one before. What is kept is moved behind the rest, which
/// leaves the fill as it is: all ancestors of a kept node are kept.
void CholmodPartialCholesky::tryOrder(cholmod_sparse* nodes, std::vector<int> order, Index eliminated) {
  common_.method[0].ordering = CHOLMOD_GIVEN;
  common_.supernodal = CHOLMOD_SIMPLICIAL;
  common_.postorder = 1;
  cholmod_factor* trial = cholmod_analyze_p(nodes, order.data(), nullptr, 0, &common_);
  common_.supernodal = CHOLMOD_SUPERNODAL;
  if (trial && (order_.empty() || common_.fl < flops_)) {
    flops_ = common_.fl;
    const int* found = static_cast<int*>(trial->Perm);
    order_.clear();
    for (std::size_t k = 0; k < order.size(); ++k)
      if (found[k] < eliminated) order_.push_back(found[k]);
    for (Index i = eliminated; i < Index(order.size()); ++i) order_.push_back(i);
  }
  cholmod_free_factor(&trial, &common_);
}

std::vector<Index> CholmodPartialCholesky::analyse(const BlockMatrix& matrix, Index eliminated, bool as_they_are) {
  const NoRegions no_regions;
  eliminated_ = eliminated;
  order_.clear();
  std::vector<int> order(std::size_t(matrix.rows()));
  std::iota(order.begin(), order.end(), 0);
  cholmod_sparse* all = graph(matrix, matrix.rows());
  if (as_they_are) order_ = order;
  if (eliminated > 1 && !as_they_are) {
    cholmod_sparse* inside = graph(matrix, eliminated);
    std::vector<int> found = order;
    const auto dissect = [&] {
      const std::lock_guard lock(orderingLock());
      return cholmod_metis(inside, nullptr, 0, 1, found.data(), &common_);
    };
    if (dissect()) tryOrder(all, found, eliminated);
    cholmod_free_sparse(&inside, &common_);
    std::vector<int> member(order.size(), 1);
    std::fill(member.begin(), member.begin() + eliminated, 0);
    if (cholmod_camd(all, nullptr, 0, member.data(), found.data(), &common_)) tryOrder(all, found, eliminated);
  }
  if (order_.empty()) tryOrder(all, order, eliminated);
  cholmod_free_sparse(&all, &common_);
  check(!order_.empty(), "order the matrix");
  buildLower(matrix);
  common_.method[0].ordering = CHOLMOD_NATURAL;
  common_.postorder = 0;
  cholmod_factor* symbolic = cholmod_analyze(lower_, &common_);
  check(symbolic, "analyse the matrix");
  layOut(*symbolic);
  cholmod_free_factor(&symbolic, &common_);
  return order_;
}

/// The permuted lower triangle.
void CholmodPartialCholesky::buildLower(const BlockMatrix& matrix) {
  std::vector<Index> place(order_.size());
  for (std::size_t k = 0; k < order_.size(); ++k) place[order_[k]] = Index(k);
  const std::size_t unknowns = 3 * order_.size();
  lower_ = cholmod_allocate_sparse(unknowns, unknowns, std::size_t(matrix.blocks()) * 9 / 2 + 5 * unknowns, 1, 1, -1,
                                   CHOLMOD_REAL, &common_);
  check(lower_, "allocate the matrix");
  int *start = static_cast<int*>(lower_->p), *rows = static_cast<int*>(lower_->i), entries = 0;
  double* values = static_cast<double*>(lower_->x);
  diagonal_.resize(unknowns);
  std::vector<std::pair<Index, Index>> below;  // place, slot
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const std::size_t node = std::size_t(order_[k]);
    below.clear();
    for (Index s = matrix.rowStart()[node]; s < matrix.rowStart()[node + 1]; ++s)
      if (const Index at = place[matrix.columns()[s]]; at >= Index(k)) below.emplace_back(at, s);
    std::sort(below.begin(), below.end());
    for (int c = 0; c < 3; ++c) {
      start[3 * k + std::size_t(c)] = entries;
      for (const auto& [at, slot] : below)
        for (int r = at == Index(k) ? c : 0; r < 3; ++r) {
          rows[entries] = 3 * at + r;
          values[entries++] = matrix.values()[std::size_t(slot) * 9 + std::size_t(3 * c + r)];
        }
      diagonal_[3 * k + std::size_t(c)] = values[start[3 * k + std::size_t(c)]];
    }
  }
  start[unknowns] = entries;
}

/// A supernode may reach from the eliminated columns into the kept ones; its rows start with its own columns, so that
/// the first of them are a supernode by themselves.
void CholmodPartialCholesky::layOut(const cholmod_factor& symbolic) {
  const int *first = static_cast<int*>(symbolic.super), *start = static_cast<int*>(symbolic.pi);
  const int* rows = static_cast<int*>(symbolic.s);
  const int border = 3 * eliminated_;
  first_.clear(), rows_.clear();
  row_start_ = {0}, start_ = {0};
  for (std::size_t s = 0; s < symbolic.nsuper && first[s] < border; ++s) {
    const int columns = std::min(first[s + 1], border) - first[s], height = start[s + 1] - start[s];
    first_.push_back(first[s]);
    rows_.insert(rows_.end(), rows + start[s] + columns, rows + start[s] + height);
    row_start_.push_back(std::int64_t(rows_.size()));
    start_.push_back(start_.back() + std::int64_t(columns) * height);
  }
  first_.push_back(border);
  flops_ = std::pow(double(keptUnknowns()), 3) / 3;
  for (Index s = 0; s + 1 < Index(first_.size()); ++s) flops_ += operationsOf(s);
}

/// Squares of the heights of its columns.
double CholmodPartialCholesky::operationsOf(Index s) const {
  double sum = 0;
  for (Index c = 0; c < width(s); ++c) sum += std::pow(double(width(s) + below(s) - c), 2);
  return sum;
}

// ---- the factor ----

double CholmodPartialCholesky::peakBytes() const {
  const double kept = double(keptUnknowns());
  return 8 * (double(start_.back()) + kept * kept) + 12.0 * double(lower_->nzmax);
}

Index CholmodPartialCholesky::factor(const std::function<void(double)>& progress) {
  const NoRegions no_regions;
  const std::size_t n = std::size_t(keptUnknowns());
  values_.assign(start_.back(), 0.0);
  kept_.assign(n * n, 0.0);
  Index lost = eliminate(progress);
  cholmod_free_sparse(&lower_, &common_);
  if (lost < 0) lost = factorKept(progress);
  Array<double>().swap(update_);
  return lost < 0 ? lostPivot() : order_[std::size_t(lost / 3)];
}

/// L of the eliminated columns, and in kept_ the Schur complement. A supernode takes what it has to from those before
/// it that have a row among its columns: they wait in its list, and go on to that of the supernode with their next row.
/// Returns -1, or a column whose pivot is not positive.
Index CholmodPartialCholesky::eliminate(const std::function<void(double)>& progress) {
  const Index count = Index(first_.size()) - 1, border = 3 * eliminated_;
  std::vector<Index> place(3 * order_.size()), list(std::size_t(count), -1), next(list), done(std::size_t(count), 0);
  std::vector<Index> supernode(std::size_t(border), 0);
  for (Index s = 0; s < count; ++s) std::fill(supernode.begin() + first_[s], supernode.begin() + first_[s + 1], s);
  const auto waitFor = [&](Index d) {
    const Index at = done[d];
    if (at == below(d)) return;
    const Index row = rows_[row_start_[d] + at];
    if (row >= border) return;
    Index& head = list[supernode[row]];
    next[d] = head;
    head = d;
  };
  kept_place_.assign(place.size(), 0);
  std::iota(kept_place_.begin() + border, kept_place_.end(), 0);
  takeColumns(border, keptUnknowns(), kept_.data(), keptUnknowns(), kept_place_);
  double operations = 0;
  for (Index s = 0; s < count; ++s) {
    const Index first = first_[s], columns = width(s), rest = below(s), height = columns + rest;
    const std::int32_t* rows = rows_.data() + row_start_[s];
    double* block = values_.data() + start_[s];
    for (Index i = 0; i < columns; ++i) place[first + i] = i;
    for (Index i = 0; i < rest; ++i) place[rows[i]] = columns + i;
    takeColumns(first, columns, block, height, place);
    for (Index d = list[s], following = -1; d >= 0; d = following) {
      following = next[d];
      const std::int32_t* from = rows_.data() + row_start_[d];
      Index& at = done[d];
      const Index end = Index(std::lower_bound(from + at, from + below(d), first + columns) - from);
      updateBy(d, at, end - at, block, height, first, place);
      at = end;
      waitFor(d);
    }
    int info = 0;
    const double one = 1;
    dpotrf_("L", &columns, block, &height, &info);
    if (info > 0) return first + info - 1;
    if (rest > 0) dtrsm_("R", "L", "T", "N", &rest, &columns, &one, block, &height, block + columns, &height);
    waitFor(s);
    updateKept(s);
    operations += operationsOf(s);
    progress(operations / flops_);
  }
  return -1;
}

/// Adds columns of the matrix to `block`, whose rows are those of `place`.
void CholmodPartialCholesky::takeColumns(Index first, Index count, double* block, Index height,
                                         const std::vector<Index>& place) const {
  const int *start = static_cast<const int*>(lower_->p), *rows = static_cast<const int*>(lower_->i);
  const double* values = static_cast<const double*>(lower_->x);
  for (Index c = 0; c < count; ++c)
    for (int p = start[first + c]; p < start[first + c + 1]; ++p)
      block[std::size_t(c) * std::size_t(height) + std::size_t(place[rows[p]])] += values[p];
}

/// block -= L_R L_C^T, R the rows of supernode s from its row `done` on and C the first `columns` of them; column `j`
/// of the block is column origin + j of the matrix. In portions, which bounds the memory.
void CholmodPartialCholesky::updateBy(Index s, Index done, Index columns, double* block, Index height, Index origin,
                                      const std::vector<Index>& place) {
  constexpr Index portion = 128;
  const std::int32_t* rows = rows_.data() + row_start_[s];
  const Index inner = width(s), stride = inner + below(s);
  const double one = 1, zero = 0;
  for (Index j = done; j < done + columns; j += portion) {
    const Index wide = std::min(portion, done + columns - j), high = below(s) - j, rest = high - wide;
    if (update_.size() < std::size_t(wide) * std::size_t(high)) update_.resize(std::size_t(wide) * std::size_t(high));
    const double* from = values_.data() + start_[s] + inner + j;
    dsyrk_("L", "N", &wide, &inner, &one, from, &stride, &zero, update_.data(), &high);
    if (rest > 0)
      dgemm_("N", "T", &rest, &wide, &inner, &one, from + wide, &stride, from, &stride, &zero, update_.data() + wide,
             &high);
    for (Index c = 0; c < wide; ++c) {
      double* to = block + std::size_t(rows[j + c] - origin) * std::size_t(height);
      const double* column = update_.data() + std::size_t(c) * std::size_t(high);
      for (Index i = c; i < high; ++i) to[place[rows[j + i]]] -= column[i];
    }
  }
}

/// What the kept columns take from supernode s.
void CholmodPartialCholesky::updateKept(Index s) {
  const Index n = keptUnknowns(), border = 3 * eliminated_, inner = width(s), stride = inner + below(s);
  const std::int32_t* rows = rows_.data() + row_start_[s];
  const Index start = Index(std::lower_bound(rows, rows + below(s), border) - rows), count = below(s) - start;
  if (count == 0) return;
  if (rows[below(s) - 1] - rows[start] == count - 1) {  // neighbours: in place
    const double minus = -1, one = 1;
    dsyrk_("L", "N", &count, &inner, &minus, values_.data() + start_[s] + inner + start, &stride, &one,
           kept_.data() + std::size_t(rows[start] - border) * std::size_t(n + 1), &n);
    return;
  }
  updateBy(s, start, count, kept_.data(), n, border, kept_place_);
}

/// L_SS from the Schur complement, by columns of blocks. Returns as eliminate().
Index CholmodPartialCholesky::factorKept(const std::function<void(double)>& progress) {
  constexpr Index block = 256;
  const Index n = keptUnknowns();
  const double one = 1, minus = -1, dense = double(n) * n * n / 3;
  for (Index j = 0; j < n; j += block) {
    const Index columns = std::min(block, n - j), rest = n - j - columns;
    double* diagonal = kept_.data() + std::size_t(j) * std::size_t(n + 1);
    int info = 0;
    dpotrf_("L", &columns, diagonal, &n, &info);
    if (info > 0) return 3 * eliminated_ + j + info - 1;
    if (rest == 0) break;
    dtrsm_("R", "L", "T", "N", &rest, &columns, &one, diagonal, &n, diagonal + columns, &n);
    dsyrk_("L", "N", &rest, &columns, &minus, diagonal + columns, &n, &one,
           diagonal + std::size_t(columns) * std::size_t(n + 1), &n);
    progress(1 - dense * std::pow(double(rest) / n, 3) / flops_);
  }
  progress(1);
  return -1;
}

Index CholmodPartialCholesky::lostPivot() const {
  const auto lost = [this](std::size_t k, double pivot) { return !(pivot * pivot > lost_pivot * diagonal_[k]); };
  for (std::size_t s = 0; s + 1 < first_.size(); ++s) {
    const std::size_t width = std::size_t(first_[s + 1] - first_[s]);
    const std::size_t height = width + std::size_t(row_start_[s + 1] - row_start_[s]);
    for (std::size_t c = 0; c < width; ++c)
      if (lost(std::size_t(first_[s]) + c, values_[std::size_t(start_[s]) + c * (height + 1)]))
        return order_[(std::size_t(first_[s]) + c) / 3];
  }
  const std::size_t n = std::size_t(keptUnknowns()), border = std::size_t(3 * eliminated_);
  for (std::size_t k = 0; k < n; ++k)
    if (lost(border + k, kept_[k * (n + 1)])) return order_[(border + k) / 3];
  return -1;
}

SupernodalColumns CholmodPartialCholesky::eliminated() const {
  return {Index(first_.size()) - 1, first_.data(), row_start_.data(), start_.data(), rows_.data(), values_.data()};
}

// ---- the dense part ----

bool CholmodPartialCholesky::shift(const std::vector<double>& diagonal) {
  const NoRegions no_regions;
  const int n = keptUnknowns();
  const double one = 1, zero = 0;
  Array<double> sum(std::size_t(n) * std::size_t(n), 0.0);
  dsyrk_("L", "N", &n, &n, &one, kept_.data(), &n, &zero, sum.data(), &n);
  for (std::size_t i = 0; i < std::size_t(n); ++i) sum[i * std::size_t(n + 1)] += diagonal[i];
  int info = 0;
  dpotrf_("L", &n, sum.data(), &n, &info);
  kept_.swap(sum);
  return info == 0;
}

// Columns j ... of the inverse, from row j down, need only the trailing part of L_SS: with T that part,
// T T^T x = the first columns of I, whose solution is theirs.
void CholmodPartialCholesky::invert(const Sink& sink, const std::function<void(double)>& progress) {
  const NoRegions no_regions;
  constexpr Index block = 192;
  const Index n = keptUnknowns();
  std::mutex telling;
  std::atomic<double> done{0};
  parallelFor((n + block - 1) / block, [&](int piece) {
    const Index j = piece * block;
    const int count = std::min(block, n - j), height = n - j, stride = n;
    Array<double> x(std::size_t(count) * std::size_t(height), 0.0);
    for (Index c = 0; c < count; ++c) x[std::size_t(c) * std::size_t(height + 1)] = 1;
    const double* trailing = kept_.data() + std::size_t(j) * std::size_t(n + 1);
    const double one = 1;
    dtrsm_("L", "L", "N", "N", &height, &count, &one, trailing, &stride, x.data(), &height);
    dtrsm_("L", "L", "T", "N", &height, &count, &one, trailing, &stride, x.data(), &height);
    sink(j, count, x.data(), height);
    const std::lock_guard lock(telling);
    done = done + 3 * double(count) * height / n * height / n / n;
    progress(done);
  });
}

}  // namespace

std::unique_ptr<PartialCholesky> makePartialCholesky() { return std::make_unique<CholmodPartialCholesky>(); }

}  // namespace stroma

STROMA_COMPONENT(partial_cholesky) { (void)factory; }
