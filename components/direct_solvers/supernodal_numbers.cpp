// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/supernodal_numbers.h"

#include <algorithm>
#include <numeric>

#include "components/direct_solvers/small_panels.h"
#include "framework/algebra/blas.h"
#include "framework/algebra/parallel.h"

namespace stroma {
namespace {

constexpr double plus_one = 1, minus_one = -1, zero_factor = 0;
/// A call of BLAS with more operations than this, a tenth of a second or so, is made in portions.
constexpr double most_operations = 4e9;
constexpr int widest_diagonal = 2048, diagonal_portion = 512;
/// Factors of fewer operations are made by one thread, in a tenth of a second.
constexpr double few_operations = 3e9;
/// Columns and rows of a supernode that a thread takes at once.
constexpr int piece_columns = 96, piece_rows = 256;

/// How many of `count` columns or rows to take at once, `each` operations for one.
int portionOf(int count, double each) {
  if (each * count <= most_operations) return count;
  return std::min(count, std::max(64, int(most_operations / each)));
}

}  // namespace

std::unique_ptr<SupernodalNumbers::Work> SupernodalNumbers::Works::take(int columns) {
  std::unique_ptr<Work> work;
  {
    const std::lock_guard lock(access_);
    if (!free_.empty()) work = std::move(free_.back()), free_.pop_back();
  }
  if (!work) work = std::make_unique<Work>();
  if (work->place.size() < std::size_t(columns)) work->place.resize(std::size_t(columns));
  return work;
}

void SupernodalNumbers::Works::giveBack(std::unique_ptr<Work> work) {
  const std::lock_guard lock(access_);
  free_.push_back(std::move(work));
}

SupernodalEnd SupernodalNumbers::factor(const LowerTriangle& matrix, double* values, StopToken stop) {
  values_ = values, stop_ = stop;
  std::unique_ptr<Work> work = works_.take(pattern_.columns);
  SupernodalEnd end;
  if (plan_.flops < few_operations) {
    std::vector<int> all(std::size_t(pattern_.count));
    std::iota(all.begin(), all.end(), 0);
    end = factorList(matrix, all, *work);
  } else {
    end = factorParts(matrix);
    for (std::size_t k = 0; k < plan_.tree.top.size() && !end.stopped && end.bad_column < 0; ++k)
      end = factorInPieces(matrix, plan_.tree.top[k], *work);
  }
  works_.giveBack(std::move(work));
  return end;
}

/// One after the other.
SupernodalEnd SupernodalNumbers::factorList(const LowerTriangle& matrix, const std::vector<int>& supernodes,
                                            Work& work) {
  for (const int s : supernodes) {
    begin(matrix, s, work);
    for (const auto* u = plan_.begin(s); u != plan_.end(s); ++u)
      if (stop_.isStopAsked() || !updateColumns(*u, s, 0, pattern_.columnsOf(s), work.place, work)) return {true, -1};
    int info = 0;
    const int columns = pattern_.columnsOf(s), height = pattern_.heightOf(s);
    if (double(columns) * columns * height <= most_small_operations) {
      info = small_panels::factor(values_ + pattern_.offset[s], columns, height);
      if (info > 0) return {false, pattern_.first[s] + info - 1};
      continue;
    }
    if (stop_.isStopAsked() || !factorDiagonal(s, info)) return {true, -1};
    if (info > 0) return {false, pattern_.first[s] + info - 1};
    if (!solveBelow(s)) return {true, -1};
  }
  return {};
}

/// The first column without a pivot is that of the sequential loop: every part ends at its own first one.
SupernodalEnd SupernodalNumbers::factorParts(const LowerTriangle& matrix) {
  std::vector<SupernodalEnd> ends(plan_.tree.parts.size());
  parallelFor(int(plan_.tree.parts.size()), [&](int k) {
    std::unique_ptr<Work> work = works_.take(pattern_.columns);
    ends[std::size_t(k)] = factorList(matrix, plan_.tree.parts[std::size_t(k)], *work);
    works_.giveBack(std::move(work));
  });
  SupernodalEnd whole;
  for (const SupernodalEnd& end : ends) {
    whole.stopped = whole.stopped || end.stopped;
    if (end.bad_column >= 0 && (whole.bad_column < 0 || end.bad_column < whole.bad_column))
      whole.bad_column = end.bad_column;
  }
  return whole;
}

SupernodalEnd SupernodalNumbers::factorInPieces(const LowerTriangle& matrix, int s, Work& work) {
  if (stop_.isStopAsked()) return {true, -1};
  begin(matrix, s, work);
  const int columns = pattern_.columnsOf(s), pieces = (columns + piece_columns - 1) / piece_columns;
  parallelFor(pieces, [&](int k) {
    std::unique_ptr<Work> own = works_.take(0);
    const int first = k * piece_columns, last = std::min(columns, first + piece_columns);
    for (const auto* u = plan_.begin(s); u != plan_.end(s); ++u)
      if (stop_.isStopAsked() || !updateColumns(*u, s, first, last, work.place, *own)) break;
    works_.giveBack(std::move(own));
  });
  if (stop_.isStopAsked()) return {true, -1};
  const int info = factorPanel(s);
  if (info > 0) return {false, pattern_.first[s] + info - 1};
  return {stop_.isStopAsked(), -1};
}

/// The columns of A as those of the supernode, and the places of its rows.
void SupernodalNumbers::begin(const LowerTriangle& matrix, int s, Work& work) {
  const int first = pattern_.first[s], last = pattern_.first[s + 1], height = pattern_.heightOf(s);
  const int* rows = pattern_.rowsOf(s);
  double* block = values_ + pattern_.offset[s];
  std::fill_n(block, std::size_t(last - first) * std::size_t(height), 0.0);
  for (int i = 0; i < height; ++i) work.place[std::size_t(rows[i])] = i;
  for (int k = first; k < last; ++k, block += height)
    for (int p = matrix.start[k]; p < matrix.start[k + 1]; ++p)
      block[work.place[std::size_t(matrix.rows[p])]] = matrix.values[p];
}

/// L_s -= L_d L_C^T, C the rows of d that are columns `first` to `last` of s. False: stopped.
bool SupernodalNumbers::updateColumns(const SupernodalPlan::Update& u, int s, int first, int last,
                                      const std::vector<int>& place, Work& work) {
  const int inner = pattern_.columnsOf(u.from), stride = pattern_.heightOf(u.from);
  const int* const all = pattern_.rowsOf(u.from);
  const int* const begin_rows = all + u.done;
  const int* const own = std::lower_bound(begin_rows, begin_rows + u.wide, pattern_.first[s] + first);
  const int wide = int(std::lower_bound(own, begin_rows + u.wide, pattern_.first[s] + last) - own);
  if (wide == 0) return true;
  const int done = int(own - all), height = stride - done, rest = height - wide;
  const double* from = values_ + pattern_.offset[u.from] + done;
  if (work.update.size() < std::size_t(wide) * std::size_t(height))
    work.update.resize(std::size_t(wide) * std::size_t(height));
  const bool is_small = double(inner) * wide * height <= most_small_operations;
  if (is_small) small_panels::update(from, stride, inner, wide, height, work.update.data());
  const int portion = portionOf(wide, 2.0 * height * inner);
  for (int j = is_small ? wide : 0; j < wide; j += portion) {
    if (j > 0 && stop_.isStopAsked()) return false;
    const int count = std::min(portion, wide - j), below = wide - j - count + rest;
    double* to = work.update.data() + std::size_t(j) * std::size_t(height) + j;
    dsyrk_("L", "N", &count, &inner, &plus_one, from + j, &stride, &zero_factor, to, &height);
    if (below > 0)
      dgemm_("N", "C", &below, &count, &inner, &plus_one, from + j + count, &stride, from + j, &stride, &zero_factor,
             to + count, &height);
  }
  const std::size_t s_height = std::size_t(pattern_.heightOf(s));
  work.relative.resize(std::max(work.relative.size(), std::size_t(height)));
  int* const relative = work.relative.data();
  for (int i = 0; i < height; ++i) relative[i] = place[std::size_t(own[i])];
  for (int j = 0; j < wide; ++j) {
    double* __restrict to = values_ + pattern_.offset[s] + std::size_t(relative[j]) * s_height;
    const double* __restrict column = work.update.data() + std::size_t(j) * std::size_t(height);
    if (is_small)
      for (int i = j; i < height; ++i) to[relative[i]] += column[i];
    else
      for (int i = j; i < height; ++i) to[relative[i]] -= column[i];
  }
  return true;
}

/// All columns of a supernode on which nothing has to act any more, by blocks of them. Returns what LAPACK does.
int SupernodalNumbers::factorPanel(int s) {
  const int columns = pattern_.columnsOf(s), height = pattern_.heightOf(s);
  double* const block = values_ + pattern_.offset[s];
  for (int j = 0; j < columns; j += piece_columns) {
    if (stop_.isStopAsked()) return 0;
    const int count = std::min(piece_columns, columns - j), below = height - j - count;
    double* const corner = block + std::size_t(j) * std::size_t(height) + j;
    int info = 0;
    dpotrf_("L", &count, corner, &height, &info);
    if (info > 0) return info + j;
    parallelFor((below + piece_rows - 1) / piece_rows, [&](int k) {
      const int rows = std::min(piece_rows, below - k * piece_rows);
      dtrsm_("R", "L", "C", "N", &rows, &count, &plus_one, corner, &height, corner + count + k * piece_rows, &height);
    });
    const int behind = columns - j - count;
    parallelFor((behind + piece_columns - 1) / piece_columns, [&](int k) {
      const int first = k * piece_columns, wide = std::min(piece_columns, behind - first);
      const int rest = below - first - wide;
      const double* own = corner + count + first;
      double* to = corner + std::size_t(count + first) * std::size_t(height) + count + first;
      dsyrk_("L", "N", &wide, &count, &minus_one, own, &height, &plus_one, to, &height);
      if (rest > 0)
        dgemm_("N", "C", &rest, &wide, &count, &minus_one, own + wide, &height, own, &height, &plus_one, to + wide,
               &height);
    });
  }
  return 0;
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
