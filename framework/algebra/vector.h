// SPDX-License-Identifier: LGPL-2.1-or-later
// Vectors over the rows of a system. The three components of a row fill four doubles (x, y, z, 0), 32-byte aligned: an
// element loop loads and stores a node with one instruction, and no store straddles a cache line. The fourth number is
// zero at all times, so sums over all numbers are sums over the components. The one exception are rows of positions that
// hold an orientation, a quaternion of four numbers (RowKind::turn): velocities, increments and forces of such a row have
// three, as all others.
#pragma once
#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>

#include "framework/algebra/memory.h"
#include "framework/scene/types.h"

namespace stroma {

/// Numbers of a row: x, y, z and the zero.
constexpr int row_doubles = 4;

/// Read-only view of `count` rows.
struct ConstRows {
  const double* data = nullptr;
  Index count = 0;
  /// The three components of a row, without the fourth number.
  Eigen::Map<const Vec3> operator[](Index row) const {
    assert(row >= 0 && row < count);
    return Eigen::Map<const Vec3>(data + std::size_t(row) * row_doubles);
  }
  std::size_t doubles() const { return std::size_t(count) * row_doubles; }
  /// `size` rows from `first` on.
  ConstRows segment(Index first, Index size) const {
    assert(first >= 0 && first + size <= count);
    return {data + std::size_t(first) * row_doubles, size};
  }
  ConstRows head(Index size) const { return segment(0, size); }
};

/// Writable view of `count` rows.
struct Rows {
  double* data = nullptr;
  Index count = 0;
  Eigen::Map<Vec3> operator[](Index row) const {
    assert(row >= 0 && row < count);
    return Eigen::Map<Vec3>(data + std::size_t(row) * row_doubles);
  }
  operator ConstRows() const { return {data, count}; }
  std::size_t doubles() const { return std::size_t(count) * row_doubles; }
  Rows segment(Index first, Index size) const {
    assert(first >= 0 && first + size <= count);
    return {data + std::size_t(first) * row_doubles, size};
  }
  Rows head(Index size) const { return segment(0, size); }
};

/// Owns rows; 64-byte aligned, zero after resize().
class Vector {
 public:
  Vector() = default;
  explicit Vector(Index count) { resize(count); }
  /// Discards the old values; throws std::bad_alloc. All rows are zero, and so are the 64 bytes after the last one.
  void resize(Index count) {
    count_ = count;
    const std::size_t bytes = std::size_t(count) * row_doubles * sizeof(double) + 64;
    data_.reset(static_cast<double*>(allocateArray(bytes)));
    std::memset(data_.get(), 0, bytes);
  }
  Index count() const { return count_; }
  operator Rows() { return {data_.get(), count_}; }
  operator ConstRows() const { return {data_.get(), count_}; }
  Rows rows() { return *this; }
  ConstRows rows() const { return *this; }
  Rows head(Index size) { return rows().head(size); }
  ConstRows head(Index size) const { return rows().head(size); }
  Eigen::Map<Vec3> operator[](Index row) { return rows()[row]; }
  Eigen::Map<const Vec3> operator[](Index row) const { return rows()[row]; }

 private:
  struct Free {
    void operator()(double* pointer) const { std::free(pointer); }
  };
  std::unique_ptr<double[], Free> data_;
  Index count_ = 0;
};

// ---- vector operations: inline, so that a module compiled for wide registers gets wide loops ----

/// a = 0
inline void clear(Rows a) { std::memset(a.data, 0, a.doubles() * sizeof(double)); }
/// out = a; views of one length that do not overlap.
inline void copy(ConstRows a, Rows out) {
  assert(a.count == out.count);
  std::memcpy(out.data, a.data, a.doubles() * sizeof(double));
}
/// y += s x
inline void axpy(double s, ConstRows x, Rows y) {
  assert(x.count == y.count);
  const double* __restrict px = x.data;
  double* __restrict py = y.data;
#pragma omp simd
  for (std::size_t i = 0; i < x.doubles(); ++i) py[i] += s * px[i];
}
/// y = x + s y
inline void xpay(ConstRows x, double s, Rows y) {
  const double* __restrict px = x.data;
  double* __restrict py = y.data;
#pragma omp simd
  for (std::size_t i = 0; i < x.doubles(); ++i) py[i] = px[i] + s * py[i];
}
/// y = s y
inline void scale(double s, Rows y) {
  double* __restrict py = y.data;
#pragma omp simd
  for (std::size_t i = 0; i < y.doubles(); ++i) py[i] *= s;
}
/// Sum of products. The order of summation is fixed by the code, not by the number of threads.
inline double dot(ConstRows a, ConstRows b) {
  assert(a.count == b.count);
  const double* __restrict pa = a.data;
  const double* __restrict pb = b.data;
  double sum = 0;
#pragma omp simd reduction(+ : sum)
  for (std::size_t i = 0; i < a.doubles(); ++i) sum += pa[i] * pb[i];
  return sum;
}
/// The Euclidean norm over all components.
inline double norm(ConstRows a) { return std::sqrt(dot(a, a)); }
/// The largest absolute component, NaN if there is one: without its sign bit it has the largest bit pattern.
inline double largest(ConstRows a) {
  std::uint64_t most = 0;
#pragma omp simd reduction(max : most)
  for (std::size_t i = 0; i < a.doubles(); ++i) most = std::max(most, std::bit_cast<std::uint64_t>(a.data[i]) << 1);
  return std::bit_cast<double>(most >> 1);
}
/// |a - b|, summed row after row.
inline double distance(ConstRows a, ConstRows b) {
  assert(a.count == b.count);
  double sum = 0;
  for (Index i = 0; i < a.count; ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum);
}

}  // namespace stroma
