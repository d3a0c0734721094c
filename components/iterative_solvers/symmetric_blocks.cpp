// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/symmetric_blocks.h"

#include <immintrin.h>

#include <algorithm>
#include <cstdint>

#include "framework/algebra/parallel.h"

namespace stroma {
namespace {

/// Rows first to last - 1 of y = A x, a piece.
struct HalvedProduct {
  const Index *start, *alone, *columns;
  const double *numbers, *last, *x;
  double* y;
};

void multiplyHalves(const HalvedProduct& of, Index first, Index end) {
  std::fill(of.y + std::size_t(first) * row_doubles, of.y + std::size_t(end) * row_doubles, 0.0);
  for (Index row = first; row < end; ++row) {
    const double* const p = of.x + std::size_t(row) * row_doubles;
    double a = 0, b = 0, c = 0;
    for (Index s = of.start[row]; s < of.start[row + 1]; ++s) {
      const double *const m = of.numbers + std::size_t(s) * 8, last = of.last[s];
      const std::size_t at = std::size_t(of.columns[s]) * row_doubles;
      const double* const q = of.x + at;
      a += m[0] * q[0] + m[1] * q[1] + m[2] * q[2];
      b += m[4] * q[0] + m[5] * q[1] + m[6] * q[2];
      c += m[3] * q[0] + m[7] * q[1] + last * q[2];
      if (s >= of.alone[row]) continue;
      double* const there = of.y + at;
      there[0] += m[0] * p[0] + m[4] * p[1] + m[3] * p[2];
      there[1] += m[1] * p[0] + m[5] * p[1] + m[7] * p[2];
      there[2] += m[2] * p[0] + m[6] * p[1] + last * p[2];
    }
    double* const own = of.y + std::size_t(row) * row_doubles;
    own[0] += a, own[1] += b, own[2] += c;
  }
}

/// The third row of a block; its fourth number is of no use, nor are those of the first two.
[[gnu::target("avx2,fma"), gnu::always_inline]] inline __m256d thirdRow(__m256d first, __m256d second, const double* last) {
  return _mm256_permute4x64_pd(_mm256_blend_pd(_mm256_unpackhi_pd(first, second), _mm256_broadcast_sd(last), 2), 0x1e);
}

/// What rows before have added to a row has any number in its fourth place, until it comes itself.
[[gnu::target("avx2,fma")]] void multiplyHalvesByFours(const HalvedProduct& of, Index first, Index end) {
  std::fill(of.y + std::size_t(first) * row_doubles, of.y + std::size_t(end) * row_doubles, 0.0);
  const Index* const columns = of.columns;
  Index s = of.start[first];
  const double *m = of.numbers + std::size_t(s) * 8, *last = of.last + s;
  for (Index row = first; row < end; ++row) {
    const double* const p = of.x + std::size_t(row) * row_doubles;
    const __m256d p0 = _mm256_broadcast_sd(p), p1 = _mm256_broadcast_sd(p + 1), p2 = _mm256_broadcast_sd(p + 2);
    __m256d a = _mm256_setzero_pd(), b = a, c = a;
    for (const Index alone = of.alone[row]; s < alone; ++s, m += 8, ++last) {
      const std::size_t at = std::size_t(columns[s]) * row_doubles;
      __m256d m0 = _mm256_load_pd(m), m1 = _mm256_load_pd(m + 4);
      asm("" : "+x"(m0), "+x"(m1));  // else the compiler loads them twice
      const __m256d m2 = thirdRow(m0, m1, last), q = _mm256_loadu_pd(of.x + at);
      a = _mm256_fmadd_pd(m0, q, a), b = _mm256_fmadd_pd(m1, q, b), c = _mm256_fmadd_pd(m2, q, c);
      const __m256d there = _mm256_fmadd_pd(m1, p1, _mm256_fmadd_pd(m0, p0, _mm256_loadu_pd(of.y + at)));
      _mm256_storeu_pd(of.y + at, _mm256_fmadd_pd(m2, p2, there));
    }
    for (const Index next = of.start[row + 1]; s < next; ++s, m += 8, ++last) {
      const __m256d m0 = _mm256_load_pd(m), m1 = _mm256_load_pd(m + 4);
      const __m256d q = _mm256_loadu_pd(of.x + std::size_t(columns[s]) * row_doubles);
      a = _mm256_fmadd_pd(m0, q, a), b = _mm256_fmadd_pd(m1, q, b), c = _mm256_fmadd_pd(thirdRow(m0, m1, last), q, c);
    }
    double* const own = of.y + std::size_t(row) * row_doubles;
    own[0] += a[0] + a[1] + a[2], own[1] += b[0] + b[1] + b[2], own[2] += c[0] + c[1] + c[2], own[3] = 0;
  }
}

}  // namespace

int SymmetricBlocks::piecesOf(Index rows) {
  constexpr Index least = 4096, usual = 32768;
  return std::max({1, std::min(int(rows / least), 16), std::min(int(rows / usual), 64)});
}

bool SymmetricBlocks::follow(const BlockMatrix& matrix, const MatrixKey& key) {
  if (key == key_) return is_symmetric_;
  const bool is_known = key.matrix == key_.matrix && key.pattern == key_.pattern && matrix.rows() + 1 == Index(start_.size());
  if (!is_known) is_symmetric_ = takePattern(matrix);
  if (is_symmetric_) takeValues(matrix);
  key_ = key;
  return is_symmetric_;
}

// Rows come in their order, and so do the mirrors of the blocks before the diagonal: of each row the next one is looked at.
bool SymmetricBlocks::takePattern(const BlockMatrix& matrix) {
  const Index rows = matrix.rows();
  const int pieces = piecesOf(rows);
  const Index* const columns = matrix.columns().data();
  first_.clear();
  for (int k = 0; k <= pieces; ++k) first_.push_back(Index(std::int64_t(rows) * k / pieces));
  start_.assign(1, 0);
  alone_.clear(), columns_.clear(), slots_.clear();
  std::vector<Index> mirror(matrix.rowStart().begin(), matrix.rowStart().end() - 1);
  const auto put = [&](Index slot) { columns_.push_back(columns[slot]), slots_.push_back(slot); };
  for (int k = 0; k < pieces; ++k)
    for (Index row = first_[k]; row < first_[k + 1]; ++row) {
      const Index diagonal = matrix.diagonal()[row], end = matrix.rowStart()[row + 1];
      if (mirror[row] != diagonal) return false;
      for (Index slot = diagonal + 1; slot < end; ++slot)
        if (const Index at = mirror[columns[slot]]++; columns[at] != row) return false;
      Index slot = diagonal + 1;
      for (; slot < end && columns[slot] < first_[k + 1]; ++slot) put(slot);
      alone_.push_back(blocks());
      put(diagonal);
      for (; slot < end; ++slot) put(slot);
      for (slot = matrix.rowStart()[row]; slot < diagonal && columns[slot] < first_[k]; ++slot) put(slot);
      start_.push_back(blocks());
    }
  return true;
}

void SymmetricBlocks::takeValues(const BlockMatrix& matrix) {
  numbers_.resize(std::size_t(blocks()) * 8);
  last_.resize(std::size_t(blocks()));
  parallelFor(int(first_.size()) - 1, [&](int k) {
    for (Index s = start_[first_[k]]; s < start_[first_[k + 1]]; ++s) {
      const double* const from = matrix.values().data() + std::size_t(slots_[s]) * 9;
      double* const to = numbers_.data() + std::size_t(s) * 8;
      constexpr int order[] = {0, 1, 2, 6, 3, 4, 5, 7};
#pragma GCC unroll 8
      for (int i = 0; i < 8; ++i) to[i] = from[order[i]];
      last_[s] = from[8];
    }
  });
}

void SymmetricBlocks::multiply(ConstRows x, Rows y) const {
  const HalvedProduct of{start_.data(), alone_.data(), columns_.data(), numbers_.data(), last_.data(), x.data, y.data};
  const bool by_fours = BlockMatrix::hasFours();
  parallelFor(int(first_.size()) - 1, [&](int k) {
    by_fours ? multiplyHalvesByFours(of, first_[k], first_[k + 1]) : multiplyHalves(of, first_[k], first_[k + 1]);
  });
}

}  // namespace stroma
