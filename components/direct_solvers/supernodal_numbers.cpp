// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/supernodal_numbers.h"

#include <algorithm>

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

constexpr double plus_one = 1, minus_one = -1, zero_factor = 0;
/// A call of BLAS with more operations than this, a tenth of a second or so, is made in portions.
constexpr double most_operations = 4e9;
constexpr int widest_diagonal = 2048, diagonal_portion = 512;

/// How many of `count` columns or rows to take at once, `each` operations for one.
int portionOf(int count, double each) {
  if (each * count <= most_operations) return count;
  return std::min(count, std::max(64, int(most_operations / each)));
}

}  // namespace

SupernodalEnd SupernodalNumbers::factor(const LowerTriangle& matrix, const SupernodalPattern& pattern, double* values,
                                        StopToken stop) {
  pattern_ = pattern, values_ = values, stop_ = stop;
  place_.resize(std::size_t(pattern.columns)), supernode_.resize(std::size_t(pattern.columns));
  list_.assign(std::size_t(pattern.count), -1);
  next_.resize(std::size_t(pattern.count)), done_.resize(std::size_t(pattern.count));
  if (update_.size() < std::size_t(pattern.largest_update)) update_.resize(std::size_t(pattern.largest_update));
  for (int s = 0; s < pattern.count; ++s)
    std::fill(supernode_.begin() + pattern.first[s], supernode_.begin() + pattern.first[s + 1], s);
  for (int s = 0; s < pattern.count; ++s) {
    begin(matrix, s);
    for (int d = list_[s], following = -1; d >= 0; d = following) {
      following = next_[d];
      if (stop.isStopAsked() || !updateBy(d, s)) return {true, -1};
    }
    int info = 0;
    if (stop.isStopAsked() || !factorDiagonal(s, info)) return {true, -1};
    if (info > 0) return {false, pattern.first[s] + info - 1};
    if (!solveBelow(s)) return {true, -1};
    waitFor(s, pattern.first[s + 1] - pattern.first[s]);
  }
  return {};
}

/// The columns of A as those of the supernode, and the places of its rows.
void SupernodalNumbers::begin(const LowerTriangle& matrix, int s) {
  const int first = pattern_.first[s], last = pattern_.first[s + 1];
  const int height = pattern_.start[s + 1] - pattern_.start[s];
  const int* rows = pattern_.rows + pattern_.start[s];
  double* block = values_ + pattern_.offset[s];
  std::fill_n(block, std::size_t(last - first) * std::size_t(height), 0.0);
  for (int i = 0; i < height; ++i) place_[rows[i]] = i;
  for (int k = first; k < last; ++k, block += height)
    for (int p = matrix.start[k]; p < matrix.start[k + 1]; ++p) block[place_[matrix.rows[p]]] = matrix.values[p];
}

/// Supernode d has acted with `done` of its rows: it waits in the list of the supernode that its next row is a column of.
void SupernodalNumbers::waitFor(int d, int done) {
  done_[d] = done;
  if (done == pattern_.start[d + 1] - pattern_.start[d]) return;
  int& head = list_[supernode_[pattern_.rows[pattern_.start[d] + done]]];
  next_[d] = head;
  head = d;
}

/// L_s -= L_d L_C^T, C the rows of d that are columns of s. False: stopped.
bool SupernodalNumbers::updateBy(int d, int s) {
  const int inner = pattern_.first[d + 1] - pattern_.first[d], stride = pattern_.start[d + 1] - pattern_.start[d];
  const int done = done_[d], *rows = pattern_.rows + pattern_.start[d] + done;
  const int height = stride - done, end = pattern_.first[s + 1];
  const int wide = int(std::lower_bound(rows, rows + height, end) - rows), rest = height - wide;
  const double* from = values_ + pattern_.offset[d] + done;
  const int portion = portionOf(wide, 2.0 * height * inner);
  for (int j = 0; j < wide; j += portion) {
    if (j > 0 && stop_.isStopAsked()) return false;
    const int count = std::min(portion, wide - j), below = wide - j - count + rest;
    double* to = update_.data() + std::size_t(j) * std::size_t(height) + j;
    dsyrk_("L", "N", &count, &inner, &plus_one, from + j, &stride, &zero_factor, to, &height);
    if (below > 0)
      dgemm_("N", "C", &below, &count, &inner, &plus_one, from + j + count, &stride, from + j, &stride, &zero_factor,
             to + count, &height);
  }
  const int s_height = pattern_.start[s + 1] - pattern_.start[s];
  relative_.resize(std::max(relative_.size(), std::size_t(height)));
  for (int i = 0; i < height; ++i) relative_[i] = place_[rows[i]];
  for (int j = 0; j < wide; ++j) {
    double* __restrict to = values_ + pattern_.offset[s] + std::size_t(relative_[j]) * std::size_t(s_height);
    const double* __restrict column = update_.data() + std::size_t(j) * std::size_t(height);
    for (int i = j; i < height; ++i) to[relative_[i]] -= column[i];
  }
  waitFor(d, done + wide);
  return true;
}

/// The triangle on the diagonal; a very wide one by block columns. `info` as LAPACK has it. False: stopped.
bool SupernodalNumbers::factorDiagonal(int s, int& info) {
  const int columns = pattern_.first[s + 1] - pattern_.first[s], height = pattern_.start[s + 1] - pattern_.start[s];
  double* block = values_ + pattern_.offset[s];
  if (columns <= widest_diagonal) {
    dpotrf_("L", &columns, block, &height, &info);
    return true;
  }
  for (int j = 0; j < columns; j += diagonal_portion) {
    if (stop_.isStopAsked()) return false;
    const int count = std::min(diagonal_portion, columns - j), below = columns - j - count;
    double* corner = block + std::size_t(j) * std::size_t(height) + j;
    dpotrf_("L", &count, corner, &height, &info);
    if (info > 0) info += j;
    if (info > 0 || below == 0) return true;
    dtrsm_("R", "L", "C", "N", &below, &count, &plus_one, corner, &height, corner + count, &height);
    dsyrk_("L", "N", &below, &count, &minus_one, corner + count, &height, &plus_one,
           corner + std::size_t(count) * std::size_t(height) + count, &height);
  }
  return true;
}

/// The rows below the triangle. False: stopped.
bool SupernodalNumbers::solveBelow(int s) {
  const int columns = pattern_.first[s + 1] - pattern_.first[s], height = pattern_.start[s + 1] - pattern_.start[s];
  const int below = height - columns;
  double* block = values_ + pattern_.offset[s];
  const int portion = portionOf(below, double(columns) * columns);
  for (int i = 0; i < below; i += portion) {
    if (i > 0 && stop_.isStopAsked()) return false;
    const int count = std::min(portion, below - i);
    dtrsm_("R", "L", "C", "N", &count, &columns, &plus_one, block, &height, block + columns + i, &height);
  }
  return true;
}

}  // namespace stroma
