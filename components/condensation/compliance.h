// SPDX-License-Identifier: LGPL-2.1-or-later
// Dense symmetric matrices that are only multiplied: by few non-zero entries (ColumnPanels), or by full vectors
// (SymmetricPanels, half of the matrix, so half of the bytes that a product waits for). Numbers are kept in double or
// single precision; sums are in double. Inline for the reason given in vector.h.
#pragma once
#ifdef __AVX512F__
#include <immintrin.h>
#endif
#include <array>
#include <cstddef>
#include <vector>

#include "framework/algebra/parallel.h"
#include "framework/scene/types.h"

namespace stroma {

constexpr std::size_t lanes = 8;  ///< rows of a chunk
using Lanes __attribute__((vector_size(lanes * sizeof(double)))) = double;
using SingleLanes __attribute__((vector_size(lanes * sizeof(float)))) = float;

/// Chunks that hold `count` rows; vectors have 8 numbers per chunk, zero after the last row, 64-byte aligned.
constexpr std::size_t chunksOf(std::size_t count) { return (count + lanes - 1) / lanes; }

inline void loadLanes(const double* from, Lanes& to) { to = *reinterpret_cast<const Lanes*>(from); }
inline void loadLanes(const float* from, Lanes& to) {
#ifdef __AVX512F__
  to = _mm512_cvtps_pd(_mm256_load_ps(from));  // GCC 12 converts the two halves one after the other
#else
  to = __builtin_convertvector(*reinterpret_cast<const SingleLanes*>(from), Lanes);
#endif
}
inline void storeLanes(const Lanes& from, double* to) { *reinterpret_cast<Lanes*>(to) = from; }

/// A symmetric matrix of 3x3 blocks by columns: the three columns of a node are one stream, 3 x 8 numbers per chunk of
/// rows. 16 (8) bytes per unknown squared.
template <class Number>
struct ColumnPanels {
  const Number* data = nullptr;  ///< shape (nodes, chunks, 3, 8); 64-byte aligned
  std::size_t nodes = 0;

  std::size_t chunks() const { return chunksOf(3 * nodes); }
  std::size_t panelSize() const { return 3 * lanes * chunks(); }
  static std::size_t size(std::size_t node_count) { return node_count * 3 * lanes * chunksOf(3 * node_count); }
  /// Where entry (i, j) lies.
  std::size_t offset(std::size_t i, std::size_t j) const {
    return j / 3 * panelSize() + (3 * (i / lanes) + j % 3) * lanes + i % lanes;
  }
  double at(std::size_t i, std::size_t j) const { return double(data[offset(i, j)]); }

  /// u += sum over k < count of the columns of node loaded[k] times force[k].
  void addColumns(const Index* loaded, const std::array<double, 3>* force, std::size_t count, double* u) const {
    for (; count >= 4; count -= 4, loaded += 4, force += 4) addBatch<4>(loaded, force, u);
    if (count == 3) addBatch<3>(loaded, force, u);
    if (count == 2) addBatch<2>(loaded, force, u);
    if (count == 1) addBatch<1>(loaded, force, u);
  }

 private:
  template <int N>
  void addBatch(const Index* loaded, const std::array<double, 3>* force, double* u) const {
    const Number* panel[N];
    for (int k = 0; k < N; ++k) panel[k] = data + std::size_t(loaded[k]) * panelSize();
    const std::size_t count = chunks();
    for (std::size_t q = 0; q < count; ++q) {
      Lanes sum, column;
      loadLanes(u + q * lanes, sum);
      for (int k = 0; k < N; ++k)
        for (std::size_t c = 0; c < 3; ++c) {
          loadLanes(panel[k] + (3 * q + c) * lanes, column);
          sum += column * force[k][c];
        }
      storeLanes(sum, u + q * lanes);
    }
  }
};

/// The lower half of a symmetric matrix in panels of 8 columns: 8 x 8 tiles, column by column, from the diagonal down.
/// Tiles on the diagonal are full and hold half of their values. 4 (2) bytes per unknown squared.
template <class Number>
struct SymmetricPanels {
  const Number* data = nullptr;
  std::size_t rows = 0;

  static std::size_t size(std::size_t row_count) {
    return chunksOf(row_count) * (chunksOf(row_count) + 1) / 2 * lanes * lanes;
  }
  std::size_t panelStart(std::size_t p) const { return (p * chunksOf(rows) - p * (p - 1) / 2) * lanes * lanes; }
  /// Where entry (i, j) with i / 8 >= j / 8 lies.
  std::size_t offset(std::size_t i, std::size_t j) const {
    return panelStart(j / lanes) + ((i / lanes - j / lanes) * lanes + j % lanes) * lanes + i % lanes;
  }
  double at(std::size_t i, std::size_t j) const {
    if (i / lanes == j / lanes) return 2 * double(data[offset(i, j)]);
    return double(data[i > j ? offset(i, j) : offset(j, i)]);
  }

  /// Pieces of about equal work: their number depends on the size alone, so that threads do not change the sums.
  std::size_t pieces() const { return rows < 1024 ? 1 : 4; }
  /// y = A r. `work`: shape (pieces(), 8 chunks), 64-byte aligned, any content.
  void multiply(const double* r, double* y, double* work) const {
    const std::size_t chunks = chunksOf(rows), count = pieces(), length = chunks * lanes;
    parallelFor(int(count), [&](int piece) {
      double* out = count == 1 ? y : work + std::size_t(piece) * length;
      for (std::size_t i = 0; i < length; ++i) out[i] = 0;
      for (std::size_t p = firstPanel(std::size_t(piece)); p < firstPanel(std::size_t(piece) + 1); ++p)
        multiplyPanel(p, r, out);
    });
    if (count == 1) return;
    for (std::size_t i = 0; i < length; ++i) {
      double sum = 0;
      for (std::size_t piece = 0; piece < count; ++piece) sum += work[piece * length + i];
      y[i] = sum;
    }
  }

 private:
  /// The first panel with at least piece / pieces() of the tiles before it.
  std::size_t firstPanel(std::size_t piece) const {
    const std::size_t chunks = chunksOf(rows), total = panelStart(chunks);
    std::size_t p = 0;
    while (p < chunks && panelStart(p) * pieces() < total * piece) ++p;
    return p;
  }

  void multiplyPanel(std::size_t p, const double* r, double* y) const {
    const std::size_t chunks = chunksOf(rows);
    Lanes sums[lanes], right[lanes];
    for (std::size_t c = 0; c < lanes; ++c) {
      sums[c] = Lanes{};
      right[c] = Lanes{} + r[p * lanes + c];
    }
    const Number* tile = data + panelStart(p);
    for (std::size_t q = p; q < chunks; ++q, tile += lanes * lanes) {
      // four sums, so that a multiply-add need not wait for the one before
      Lanes rows_right, column, out[4] = {};
      loadLanes(r + q * lanes, rows_right);
      loadLanes(y + q * lanes, out[0]);
      for (std::size_t c = 0; c < lanes; ++c) {
        loadLanes(tile + c * lanes, column);
        out[c % 4] += column * right[c];
        sums[c] += column * rows_right;
      }
      storeLanes((out[0] + out[1]) + (out[2] + out[3]), y + q * lanes);
    }
    for (std::size_t c = 0; c < lanes; ++c) {
      double sum = 0;
      for (std::size_t i = 0; i < lanes; ++i) sum += sums[c][i];
      y[p * lanes + c] += sum;
    }
  }
};

}  // namespace stroma
