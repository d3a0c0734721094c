// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/algebra/block_matrix.h"

#include <immintrin.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "framework/algebra/parallel.h"

namespace stroma {
namespace {

/// Rows first to last - 1 of y = A x or, where it adds, y += factor A x.
struct Product {
  const Index *start, *columns;
  const double *values, *x;
  double* y;
  double factor;
  bool adds;
  void store(Index row, double a, double b, double c) const {
    double* q = y + std::size_t(row) * row_doubles;
    if (adds)
      q[0] += factor * a, q[1] += factor * b, q[2] += factor * c;
    else
      q[0] = a, q[1] = b, q[2] = c, q[3] = 0;
  }
};

void multiplyRows(const Product& of, Index first, Index last) {
  for (Index i = first; i < last; ++i) {
    double a = 0, b = 0, c = 0;
    for (Index s = of.start[i]; s < of.start[i + 1]; ++s) {
      const double* m = of.values + std::size_t(s) * 9;
      const double* p = of.x + std::size_t(of.columns[s]) * row_doubles;
      a += m[0] * p[0] + m[1] * p[1] + m[2] * p[2];
      b += m[3] * p[0] + m[4] * p[1] + m[5] * p[2];
      c += m[6] * p[0] + m[7] * p[1] + m[8] * p[2];
    }
    of.store(i, a, b, c);
  }
}

/// The rows of a block are read as fours, whose last lane is left out in the end; the third from one number before it, so that nothing
/// beyond the last block is read. Blocks go in turn into two sums, as one would wait for its own additions.
[[gnu::target("avx2,fma")]] void multiplyRowsByFours(const Product& of, Index first, Index last) {
  const __m256d zero = _mm256_setzero_pd();
  for (Index i = first; i < last; ++i) {
    __m256d sum[2][3] = {{zero, zero, zero}, {zero, zero, zero}};
    for (Index s = of.start[i], end = of.start[i + 1]; s < end; s += 2) {
#pragma GCC unroll 2
      for (Index k = 0; k < 2; ++k) {
        if (s + k == end) break;
        const double* m = of.values + std::size_t(s + k) * 9;
        const __m256d p = _mm256_loadu_pd(of.x + std::size_t(of.columns[s + k]) * row_doubles);
        sum[k][0] = _mm256_fmadd_pd(_mm256_loadu_pd(m), p, sum[k][0]);
        sum[k][1] = _mm256_fmadd_pd(_mm256_loadu_pd(m + 3), p, sum[k][1]);
        sum[k][2] = _mm256_fmadd_pd(_mm256_permute4x64_pd(_mm256_loadu_pd(m + 5), 0x39), p, sum[k][2]);
      }
    }
    const __m256d a = sum[0][0] + sum[1][0], b = sum[0][1] + sum[1][1], c = sum[0][2] + sum[1][2];
    of.store(i, a[0] + a[1] + a[2], b[0] + b[1] + b[2], c[0] + c[1] + c[2]);
  }
}

/// Rows do not see each other: threads share them in pieces.
void multiplyAll(const Product& of, Index rows) {
  constexpr Index piece = 4096;
  const bool has_fours = BlockMatrix::hasFours();
  parallelFor(int((rows + piece - 1) / piece), [&](int k) {
    const Index first = Index(k) * piece, last = std::min(rows, first + piece);
    has_fours ? multiplyRowsByFours(of, first, last) : multiplyRows(of, first, last);
  });
}

}  // namespace

bool BlockMatrix::hasFours() {
  static const bool has_fours = [] {  // STROMA_LEVEL lowers what modules are opened for, and this
    const char* level = std::getenv("STROMA_LEVEL");
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && !(level && std::string_view(level) == "x86-64-v2");
  }();
  return has_fours;
}

/// From the caches, or from memory, beside other work: measured of 0.2 to 190 MB, in patterns of hexahedra and tetrahedra, to a tenth.
double BlockMatrix::productCost(double blocks, bool is_halved) {
  const double megabytes = (is_halved ? 43e-6 : 76e-6) * blocks;
  if (is_halved) return blocks * (0.9 + 1.3 * std::clamp((megabytes - 10) / 14, 0., 1.));
  return blocks * (1.05 + 2.4 * std::clamp((megabytes - 9) / 30, 0., 1.));
}

bool BlockMatrix::pays(double products, double each, double assembly, double blocks, bool is_halved) {
  constexpr double halving = 2.5;  // products
  const double own = productCost(blocks, is_halved);
  return products * (each - own) > assembly + (is_halved && assembly > 0 ? halving * own : 0);
}

void BlockMatrix::multiply(ConstRows x, Rows y) const {
  multiplyAll({row_start_.data(), columns_.data(), values_.data(), x.data, y.data, 1, false}, rows());
}

void BlockMatrix::multiplyAdd(double factor, ConstRows x, Rows y) const {
  multiplyAll({row_start_.data(), columns_.data(), values_.data(), x.data, y.data, factor, true}, rows());
}

// A node of a mesh has some fifteen neighbours, each in several elements: to look is quicker than to sort them all later.
void BlockPattern::addBlock(Index row, Index column) {
  std::vector<Index>& columns = columns_[row];
  if (columns.empty()) columns.reserve(16);
  if (columns.size() > 64 || std::find(columns.begin(), columns.end(), column) == columns.end()) columns.push_back(column);
}

void BlockPattern::addClique(const Index* rows, int count) {
  for (int i = 0; i < count * count; ++i) addBlock(rows[i / count], rows[i % count]);
}

BlockMatrix::BlockMatrix(BlockPattern&& pattern) : row_start_(std::size_t(pattern.rows()) + 1, 0), diagonal_(pattern.rows()) {
  constexpr Index piece = 4096;
  parallelFor(int(pattern.rows() / piece) + 1, [&](int k) {
    for (Index i = Index(k) * piece; i < std::min(pattern.rows(), (Index(k) + 1) * piece); ++i) {
      std::vector<Index>& row = pattern.columns_[i];
      pattern.addBlock(i, i);
      std::sort(row.begin(), row.end());
      row.erase(std::unique(row.begin(), row.end()), row.end());
    }
  });
  std::size_t total = 0;
  for (const std::vector<Index>& row : pattern.columns_) total += row.size();
  if (total > std::size_t(std::numeric_limits<Index>::max()))
    throw std::length_error("the assembled matrix would have " + std::to_string(total) +
                            " blocks of 3x3, more than a 32-bit index counts; use a matrix-free solver");
  columns_.reserve(total);
  for (Index i = 0; i < pattern.rows(); ++i) {
    const std::vector<Index> row = std::move(pattern.columns_[i]);
    diagonal_[i] = row_start_[i] + Index(std::lower_bound(row.begin(), row.end(), i) - row.begin());
    columns_.insert(columns_.end(), row.begin(), row.end());
    row_start_[i + 1] = Index(columns_.size());
  }
  values_.assign(total * 9, 0.0);
}

Index BlockMatrix::slot(Index row, Index column) const {
  const auto first = columns_.begin() + row_start_[row];
  const auto last = columns_.begin() + row_start_[row + 1];
  const auto at = std::lower_bound(first, last, column);
  return at != last && *at == column ? Index(at - columns_.begin()) : -1;
}

void BlockMatrix::clear() { std::fill(values_.begin(), values_.end(), 0.0); }

}  // namespace stroma
