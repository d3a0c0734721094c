// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/front_numbers.h"

#include <immintrin.h>

#include <algorithm>

#include "framework/algebra/parallel.h"
#include "framework/scene/modules.h"

namespace stroma {
namespace {

const FrontKernels& kernelsOfThisMachine() {
  const std::string level = instructionLevel();
  return level == "x86-64-v4" ? front_kernels_v4 : level == "x86-64-v3" ? front_kernels_v3 : front_kernels_v2;
}

constexpr int share_columns = front_columns, share_rows = 240;
/// Of a factor that are read at once in a solve, 10 microseconds.
constexpr int solved_numbers = 1 << 16;

/// body(0) ... body(count - 1): at once, or one after the other where others are at work on other parts.
template <class Body>
void forPieces(bool at_once, int count, Body&& body) {
  if (at_once)
    parallelFor(count, [&](int p) {
      const FlushTiny here;
      body(p);
    });
  else
    for (int p = 0; p < count; ++p) body(p);
}

}  // namespace

FlushTiny::FlushTiny() : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040); }
FlushTiny::~FlushTiny() { _mm_setcsr(before_); }

void FrontNumbers::setPattern(const SupernodalPattern& pattern, const int* lower_start, const int* lower_rows) {
  pattern_ = pattern, lower_start_ = lower_start, lower_rows_ = lower_rows;
  plan_ = frontPlanOf(pattern, lower_start, lower_rows);
  if (!kernels_) kernels_ = &kernelsOfThisMachine();
  values_.clear();
}

void FrontNumbers::release() {
  for (Array<float>* array : {&values_, &shared_, &vectors_}) *array = Array<float>();
  works_.release();
}

SupernodalEnd FrontNumbers::factor(const double* values, const std::vector<int>& source, const std::vector<double>& scale,
                                   StopToken stop) {
  values_.resize(plan_.values.back() + 64), shared_.resize(plan_.shared_size + 64);
  from_ = values, source_ = source.data(), scale_ = scale.data(), stop_ = stop;
  ends_.assign(plan_.tree.parts.size(), {});
  parallelFor(int(ends_.size()), [&](int k) { ends_[std::size_t(k)] = factorPart(plan_.tree.parts[std::size_t(k)]); });
  SupernodalEnd whole;
  for (const SupernodalEnd& end : ends_) {
    whole.stopped = whole.stopped || end.stopped;
    if (end.bad_column >= 0 && (whole.bad_column < 0 || end.bad_column < whole.bad_column)) whole.bad_column = end.bad_column;
  }
  for (std::size_t k = 0; k < plan_.tree.top.size() && !whole.stopped && whole.bad_column < 0; ++k)
    whole = factorInPieces(plan_.tree.top[k]);
  return whole;
}

FrontParts FrontNumbers::frontOf(int s, float* own) {
  FrontParts front;
  front.columns = pattern_.columnsOf(s), front.below = pattern_.heightOf(s) - front.columns;
  front.triangle_rows = FrontPlan::padded(front.columns), front.below_rows = FrontPlan::padded(front.below);
  front.triangle = values_.data() + plan_.values[std::size_t(s)];
  front.rest = front.triangle + std::size_t(front.triangle_rows) * std::size_t(front.columns);
  front.update = (plan_.shared[std::size_t(s)] ? shared_.data() : own) + plan_.update[std::size_t(s)];
  return front;
}

SidePanel<float> FrontNumbers::panelOf(int s) {
  const FrontParts front = frontOf(s, nullptr);
  return {pattern_.first[s],  front.columns,   front.below, front.triangle, front.rest, front.triangle_rows, front.below_rows,
          pattern_.rowsOf(s) + front.columns, true};
}

void FrontNumbers::load(int s, const FrontParts& front) {
  std::fill(front.triangle, values_.data() + plan_.values[std::size_t(s) + 1], 0.0f);
  const int first = pattern_.first[s], last = pattern_.first[s + 1];
  for (int k = first; k < last; ++k)
    for (int p = lower_start_[k]; p < lower_start_[k + 1]; ++p)
      front.triangle[plan_.entry[std::size_t(p)]] = float(from_[source_[p]] * scale_[k] * scale_[lower_rows_[p]]);
}

/// What the children of s leave of columns `first` to `last` of its front.
void FrontNumbers::add(int s, const FrontParts& front, float* own, int first, int last) {
  for (int k = plan_.child_start[std::size_t(s)]; k < plan_.child_start[std::size_t(s) + 1]; ++k) {
    const int child = plan_.children[std::size_t(k)];
    const FrontRun* const runs = plan_.runs.data();
    kernels_->add(frontOf(child, own), runs + plan_.run_start[std::size_t(child)], runs + plan_.run_start[std::size_t(child) + 1],
                  front, first, last);
  }
}

int FrontNumbers::factorPanel(const FrontParts& front) {
  for (int j = 0; j < front.columns; j += front_columns) {
    const int bad = factorBlock(front, j, false);
    if (bad >= 0) return bad;
    const int count = std::min(front_columns, front.columns - j), behind = front.columns - j - count;
    if (behind == 0) break;
    const float* const own = front.triangle + std::size_t(j) * std::size_t(front.triangle_rows) + j + count;
    const int at = j + count;
    kernels_->subtractLower(own, front.triangle_rows, behind, count, false,
                            front.triangle + std::size_t(at) * std::size_t(front.triangle_rows) + at, front.triangle_rows);
    kernels_->subtract(front.rest + std::size_t(j) * std::size_t(front.below_rows), front.below_rows, front.below, own,
                       front.triangle_rows, behind, count, false, front.rest + std::size_t(at) * std::size_t(front.below_rows),
                       front.below_rows);
  }
  return -1;
}

SupernodalEnd FrontNumbers::factorPart(const std::vector<int>& supernodes) {
  const FlushTiny flush;
  std::unique_ptr<Work> work = works_.take();
  if (work->updates.size() < plan_.part_size + 64) work->updates.resize(plan_.part_size + 64);
  float* const own = work->updates.data();
  SupernodalEnd end;
  for (const int s : supernodes) {
    if (stop_.isStopAsked()) {
      end.stopped = true;
      break;
    }
    const FrontParts front = frontOf(s, own);
    load(s, front);
    add(s, front, own, 0, front.columns);
    const int bad = factorPanel(front);
    if (bad >= 0) {
      end.bad_column = pattern_.first[s] + bad;
      break;
    }
    for (int j = 0; j < front.columns; j += front_columns)
      kernels_->subtractLower(front.rest + std::size_t(j) * std::size_t(front.below_rows), front.below_rows, front.below,
                              std::min(front_columns, front.columns - j), j == 0, front.update, front.below_rows);
    add(s, front, own, front.columns, front.columns + front.below);
  }
  works_.giveBack(std::move(work));
  return end;
}

SupernodalEnd FrontNumbers::factorInPieces(int s) {
  const FlushTiny flush;
  const FrontParts front = frontOf(s, nullptr);
  load(s, front);
  addInPieces(s, front, 0, front.columns);
  for (int j = 0; j < front.columns; j += front_columns) {
    if (stop_.isStopAsked()) return {true, -1};
    const int bad = factorBlock(front, j, true);
    if (bad >= 0) return {false, pattern_.first[s] + bad};
    subtractBlock(front, j);
  }
  addInPieces(s, front, front.columns, front.columns + front.below);
  return {};
}

void FrontNumbers::addInPieces(int s, const FrontParts& front, int first, int last) {
  parallelFor((last - first + share_columns - 1) / share_columns, [&](int p) {
    const FlushTiny here;
    add(s, front, nullptr, first + p * share_columns, std::min(last, first + (p + 1) * share_columns));
  });
}

/// Columns j and on, front_columns of them. Returns the first one without a positive pivot, or -1.
int FrontNumbers::factorBlock(const FrontParts& front, int j, bool in_pieces) {
  const int count = std::min(front_columns, front.columns - j), behind = front.columns - j - count;
  float* const corner = front.triangle + std::size_t(j) * std::size_t(front.triangle_rows) + j;
  float* const beside = front.rest + std::size_t(j) * std::size_t(front.below_rows);
  const int bad = kernels_->factor(corner, front.triangle_rows, count);
  if (bad >= 0) return j + bad;
  const int upper = (behind + share_rows - 1) / share_rows, lower = (front.below + share_rows - 1) / share_rows;
  forPieces(in_pieces, upper + lower, [&](int p) {
    const int row = (p < upper ? p : p - upper) * share_rows;
    if (p < upper)
      kernels_->solveRows(corner, front.triangle_rows, count, corner + count + row, front.triangle_rows,
                          std::min(share_rows, behind - row));
    else
      kernels_->solveRows(corner, front.triangle_rows, count, beside + row, front.below_rows,
                          std::min(share_rows, front.below - row));
  });
  return -1;
}

/// What the block of column j does to the columns behind it: to those of the triangle with what is below it, and to the update.
void FrontNumbers::subtractBlock(const FrontParts& front, int j) {
  const int count = std::min(front_columns, front.columns - j), behind = front.columns - j - count;
  const std::size_t ld = std::size_t(front.below_rows), ldt = std::size_t(front.triangle_rows);
  const float* const corner = front.triangle + std::size_t(j) * ldt + j;
  const float* const beside = front.rest + std::size_t(j) * ld;
  const int own_pieces = (behind + share_columns - 1) / share_columns, updates = (front.below + share_columns - 1) / share_columns;
  parallelFor(own_pieces + updates, [&](int p) {
    const FlushTiny here;
    const int first = (p < own_pieces ? p : p - own_pieces) * share_columns;
    const int wide = std::min(share_columns, (p < own_pieces ? behind : front.below) - first);
    const int under = (p < own_pieces ? behind : front.below) - first - wide;
    const int rows = p < own_pieces ? front.triangle_rows : front.below_rows;
    const float* const own = (p < own_pieces ? corner + count : beside) + first;
    const int at = j + count + first;
    float* const to = p < own_pieces ? front.triangle + std::size_t(at) * ldt + at : front.update + std::size_t(first) * ld + first;
    const bool is_fresh = p >= own_pieces && j == 0;
    kernels_->subtractLower(own, rows, wide, count, is_fresh, to, rows);
    if (under > 0) kernels_->subtract(own + wide, rows, under, own, rows, wide, count, is_fresh, to + wide, rows);
    if (p < own_pieces)
      kernels_->subtract(beside, front.below_rows, front.below, own, rows, wide, count, false, front.rest + std::size_t(at) * ld,
                         front.below_rows);
  });
}

// L y = b, L^T x = y; a supernode's columns share their rows, the first of which are the columns' own.
void FrontNumbers::subtractProduct(const float* a, int lda, int rows, int columns, const float* x, float* y, bool in_pieces) {
  const int piece = std::max(share_rows, solved_numbers / columns / front_rows * front_rows);
  forPieces(in_pieces, (rows + piece - 1) / piece, [&](int p) {
    kernels_->subtractProduct(a + p * piece, lda, std::min(piece, rows - p * piece), columns, x, y + p * piece);
  });
}
void FrontNumbers::subtractTransposed(const float* a, int lda, int rows, int columns, const float* x, float* y, bool in_pieces) {
  const int piece = std::max(front_rows, solved_numbers / rows / front_rows * front_rows);
  forPieces(in_pieces, (columns + piece - 1) / piece, [&](int p) {
    kernels_->subtractTransposed(a + std::size_t(p * piece) * std::size_t(lda), lda, rows, std::min(piece, columns - p * piece), x,
                                 y + p * piece);
  });
}

/// L y = b of a supernode: its columns of x, and what its children leave.
void FrontNumbers::forward(int s, const float* x, bool in_pieces) {
  const FrontParts front = frontOf(s, nullptr);
  float* const own = vectors_.data() + plan_.vector[std::size_t(s)];
  float* const rest = own + front.triangle_rows;
  std::copy_n(x + pattern_.first[s], front.columns, own);
  std::fill(own + front.columns, rest + front.below_rows, 0.0f);
  for (int k = plan_.child_start[std::size_t(s)]; k < plan_.child_start[std::size_t(s) + 1]; ++k) {
    const int child = plan_.children[std::size_t(k)];
    const float* const from = vectors_.data() + plan_.vector[std::size_t(child)] + FrontPlan::padded(pattern_.columnsOf(child));
    for (int r = plan_.run_start[std::size_t(child)]; r < plan_.run_start[std::size_t(child) + 1]; ++r) {
      const FrontRun run = plan_.runs[std::size_t(r)];
      float* const to = run.to < front.columns ? own + run.to : rest + run.to - front.columns;
      for (int i = 0; i < run.count; ++i) to[i] += from[run.from + i];
    }
  }
  for (int j = 0; j < front.columns; j += front_columns) {
    const int count = std::min(front_columns, front.columns - j), behind = front.columns - j - count;
    const float* const corner = front.triangle + std::size_t(j) * std::size_t(front.triangle_rows) + j;
    kernels_->solveForward(corner, front.triangle_rows, count, own + j);
    if (behind > 0) subtractProduct(corner + count, front.triangle_rows, behind, count, own + j, own + j + count, in_pieces);
  }
  if (front.below > 0) subtractProduct(front.rest, front.below_rows, front.below, front.columns, own, rest, in_pieces);
}

/// L^T x = y of a supernode, from the solution of its parent.
void FrontNumbers::backward(int s, float* x, bool in_pieces) {
  const FrontParts front = frontOf(s, nullptr);
  float* const own = vectors_.data() + plan_.vector[std::size_t(s)];
  float* const rest = own + front.triangle_rows;
  if (front.below > 0) {
    const int parent = plan_.parent[std::size_t(s)], columns = pattern_.columnsOf(parent);
    const float* const upper = vectors_.data() + plan_.vector[std::size_t(parent)];
    const float* const lower = upper + FrontPlan::padded(columns) - columns;
    for (int r = plan_.run_start[std::size_t(s)]; r < plan_.run_start[std::size_t(s) + 1]; ++r) {
      const FrontRun run = plan_.runs[std::size_t(r)];
      std::copy_n((run.to < columns ? upper : lower) + run.to, run.count, rest + run.from);
    }
    subtractTransposed(front.rest, front.below_rows, front.below, front.columns, rest, own, in_pieces);
  }
  for (int j = (front.columns - 1) / front_columns * front_columns; j >= 0; j -= front_columns) {
    const int count = std::min(front_columns, front.columns - j), behind = front.columns - j - count;
    const float* const corner = front.triangle + std::size_t(j) * std::size_t(front.triangle_rows) + j;
    if (behind > 0) subtractTransposed(corner + count, front.triangle_rows, behind, count, own + j + count, own + j, in_pieces);
    kernels_->solveBackward(corner, front.triangle_rows, count, own + j);
  }
  std::copy_n(own, front.columns, x + pattern_.first[s]);
}

void FrontNumbers::solve(float* x) {
  const FlushTiny flush;
  const TreeParts& tree = plan_.tree;
  vectors_.resize(plan_.vector.back() + 64);
  parallelFor(int(tree.parts.size()), [&](int k) {
    const FlushTiny here;
    for (const int s : tree.parts[std::size_t(k)]) forward(s, x, false);
  });
  for (const int s : tree.top) forward(s, x, true);
  for (std::size_t k = tree.top.size(); k-- > 0;) backward(tree.top[k], x, true);
  parallelFor(int(tree.parts.size()), [&](int k) {
    const FlushTiny here;
    const std::vector<int>& part = tree.parts[std::size_t(k)];
    for (std::size_t i = part.size(); i-- > 0;) backward(part[i], x, false);
  });
}

}  // namespace stroma
