// SPDX-License-Identifier: LGPL-2.1-or-later
// The order of a partial Cholesky factor, by CHOLMOD: the eliminated nodes are ordered for little fill, those that are
// kept come last, so that the last columns of L are the dense factor of the Schur complement; nothing of the interior
// is ever inverted. Two orders are tried, nested dissection of the eliminated nodes (METIS) and minimum degree with the
// kept nodes held back (CAMD); the one with fewer operations is taken.
#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>
#include <stdexcept>

#include "components/condensation/cholmod_partial_cholesky.h"
#include "framework/algebra/ordering_lock.h"

namespace stroma {

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

double CholmodPartialCholesky::peakBytes() const {
  const double kept = double(keptUnknowns());
  return 8 * (double(start_.back()) + kept * kept) + 12.0 * double(lower_->nzmax);
}

}  // namespace stroma
