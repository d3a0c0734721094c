// SPDX-License-Identifier: LGPL-2.1-or-later
// The numbers of a partial Cholesky factor, supernode by supernode from the left, by the same calls of BLAS as CHOLMOD's.
// CHOLMOD's own factorisation reports no progress, although it takes minutes for large bodies, and it mixes both parts in one
// factor: separating them needed the memory of two.
#include "components/condensation/partial_cholesky.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <numeric>

#include "components/condensation/cholmod_partial_cholesky.h"
#include "framework/algebra/blas.h"
#include "framework/algebra/parallel.h"

namespace stroma {
namespace {

/// A pivot below this times the diagonal entry it started from has no right digit.
constexpr double lost_pivot = 1e-13;

}  // namespace

// ---- the factor ----

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
    done = done + std::pow(double(height) / n, 3) - std::pow(double(height - count) / n, 3);
    progress(done);
  });
}

std::unique_ptr<PartialCholesky> makePartialCholesky() { return std::make_unique<CholmodPartialCholesky>(); }

}  // namespace stroma
