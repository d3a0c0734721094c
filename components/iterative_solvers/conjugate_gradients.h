// SPDX-License-Identifier: LGPL-2.1-or-later
// The vector loops of conjugate gradients, fused so that each vector is read as seldom as the method allows: an
// iteration reads or writes 10 vectors (11 with x updated beside r). Inline for the reason given in vector.h.
#pragma once
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "framework/algebra/parallel.h"
#include "framework/algebra/vector.h"

namespace stroma::cg {

// ---- pieces of long vectors, which threads share: how many there are depends on the rows alone. What is done with one is never
// inlined: with another number of threads the compiler's other copy would round otherwise ----

constexpr int most_pieces = 64;
inline int piecesOf(Index rows) { return std::clamp(int(rows / 16384), 1, most_pieces); }
/// body(piece, first row, rows)
template <class Body>
void forPieces(Index rows, Body&& body) {
  const int pieces = piecesOf(rows);
  const auto begin = [&](int k) { return k == pieces ? rows : Index(std::int64_t(rows) * k / pieces) / 2 * 2; };
  parallelFor(pieces, [&](int k) { body(k, begin(k), begin(k + 1) - begin(k)); });
}
/// The sum of part(first row, rows), a struct or a number.
template <class Value, class Part>
Value sumOfPieces(Index rows, Part&& part) {
  std::array<Value, most_pieces> parts;
  forPieces(rows, [&](int k, Index first, Index size) { parts[std::size_t(k)] = part(first, size); });
  for (int k = 1; k < piecesOf(rows); ++k) parts[0] += parts[std::size_t(k)];
  return parts[0];
}

/// out = a
inline void copyShared(ConstRows a, Rows out) {
  forPieces(a.count, [&](int, Index first, Index size) { copy(a.segment(first, size), out.segment(first, size)); });
}

/// a.b
[[gnu::noinline]] inline double innerOfPiece(ConstRows a, ConstRows b) { return dot(a, b); }
inline double inner(ConstRows a, ConstRows b) {
  return sumOfPieces<double>(a.count, [&](Index first, Index size) {
    return innerOfPiece(a.segment(first, size), b.segment(first, size));
  });
}

// The sums run over the two halves of a piece at once: one chain of additions waits four cycles for each register,
// more than the loads take. Halves start on a cache line.
inline std::size_t halfOf(ConstRows a) { return a.doubles() / 16 * 8; }

/// p.q, p.p and q.q in one pass (2 reads).
struct Curvature {
  double pq = 0, pp = 0, qq = 0;
  void operator+=(const Curvature& other) { pq += other.pq, pp += other.pp, qq += other.qq; }
};
[[gnu::noinline]] inline Curvature curvatureOfPiece(ConstRows p, ConstRows q) {
  const std::size_t half = halfOf(p);
  const double* __restrict p0 = p.data;
  const double* __restrict q0 = q.data;
  const double* __restrict p1 = p.data + half;
  const double* __restrict q1 = q.data + half;
  double pq0 = 0, pp0 = 0, qq0 = 0, pq1 = 0, pp1 = 0, qq1 = 0;
#pragma omp simd reduction(+ : pq0, pp0, qq0, pq1, pp1, qq1)
  for (std::size_t i = 0; i < half; ++i) {
    pq0 += p0[i] * q0[i];
    pp0 += p0[i] * p0[i];
    qq0 += q0[i] * q0[i];
    pq1 += p1[i] * q1[i];
    pp1 += p1[i] * p1[i];
    qq1 += q1[i] * q1[i];
  }
  for (std::size_t i = 2 * half; i < p.doubles(); ++i) {
    pq0 += p0[i] * q0[i];
    pp0 += p0[i] * p0[i];
    qq0 += q0[i] * q0[i];
  }
  return {pq0 + pq1, pp0 + pp1, qq0 + qq1};
}
inline Curvature curvature(ConstRows p, ConstRows q) {
  return sumOfPieces<Curvature>(p.count, [&](Index first, Index size) {
    return curvatureOfPiece(p.segment(first, size), q.segment(first, size));
  });
}

/// r -= alpha q; returns r.r (2 reads, 1 write).
[[gnu::noinline]] inline double reducePiece(double alpha, ConstRows q, Rows r) {
  const std::size_t half = halfOf(r);
  const double* __restrict q0 = q.data;
  const double* __restrict q1 = q.data + half;
  double* r0 = r.data;
  double* r1 = r.data + half;
  double sum0 = 0, sum1 = 0;
#pragma omp simd reduction(+ : sum0, sum1)
  for (std::size_t i = 0; i < half; ++i) {
    const double a = r0[i] - alpha * q0[i], b = r1[i] - alpha * q1[i];
    r0[i] = a;
    r1[i] = b;
    sum0 += a * a;
    sum1 += b * b;
  }
  for (std::size_t i = 2 * half; i < r.doubles(); ++i) {
    r0[i] -= alpha * q0[i];
    sum0 += r0[i] * r0[i];
  }
  return sum0 + sum1;
}
inline double reduceResidual(double alpha, ConstRows q, Rows r) {
  return sumOfPieces<double>(r.count, [&](Index first, Index size) {
    return reducePiece(alpha, q.segment(first, size), r.segment(first, size));
  });
}

/// x += alpha p, then p = z + beta p (3 reads, 2 writes): x lags behind r by one pass, so that p is read once for both.
[[gnu::noinline]] inline void advancePiece(double alpha, double beta, ConstRows z, Rows p, Rows x) {
  const double* __restrict pz = z.data;
  double* __restrict pp = p.data;
  double* __restrict px = x.data;
#pragma omp simd
  for (std::size_t i = 0; i < p.doubles(); ++i) {
    px[i] += alpha * pp[i];
    pp[i] = pz[i] + beta * pp[i];
  }
}
inline void advance(double alpha, double beta, ConstRows z, Rows p, Rows x) {
  forPieces(p.count, [&](int, Index first, Index size) {
    advancePiece(alpha, beta, z.segment(first, size), p.segment(first, size), x.segment(first, size));
  });
}

/// Inverses of the 3x3 diagonal blocks as three columns of four doubles per row, so that a row's product is three
/// multiply-adds on whole rows.
class BlockJacobi {
 public:
  /// `blocks` has shape (rows, 9). Returns the first row whose block is not positive definite, or -1.
  Index factor(const std::vector<double>& blocks) {
    const Index rows = Index(blocks.size() / 9);
    columns_.resize(std::size_t(rows) * 12);
    for (Index row = 0; row < rows; ++row) {
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(blocks.data() + std::size_t(row) * 9);
      const Mat3 a = block;
      const double minor = a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0), determinant = a.determinant();
      if (!(a(0, 0) > 0 && minor > 0 && determinant > 0)) return row;
      const Mat3 inverse = a.inverse();
      double* out = columns_.data() + std::size_t(row) * 12;
      for (int c = 0; c < 3; ++c)
        for (int l = 0; l < 4; ++l) out[4 * c + l] = l < 3 ? inverse(l, c) : 0;
    }
    return -1;
  }
  /// The largest |entry| of D^-1.
  double largest() const {
    double most = 0;
    for (const double entry : columns_) most = std::max(most, std::abs(entry));
    return most;
  }
  /// z = D^-1 r; returns r.z.
  double apply(ConstRows r, Rows z) const {
    return sumOfPieces<double>(r.count, [&](Index first, Index size) { return applyTo(first, first + size, r, z); });
  }

 private:
  typedef double Four __attribute__((vector_size(32), aligned(8), may_alias));  ///< else the compiler takes numbers one by one
  [[gnu::noinline]] double applyTo(Index begin, Index end, ConstRows r, Rows z) const {
    const auto four = [](const double* from) -> const Four& { return *reinterpret_cast<const Four*>(from); };
    Four sum = {};
    for (Index row = begin; row < end; ++row) {
      const double* d = columns_.data() + std::size_t(row) * 12;
      const double* p = r.data + std::size_t(row) * row_doubles;
      const Four value = four(d) * p[0] + four(d + 4) * p[1] + four(d + 8) * p[2];
      *reinterpret_cast<Four*>(z.data + std::size_t(row) * row_doubles) = value;
      sum += value * four(p);
    }
    return sum[0] + sum[1] + sum[2] + sum[3];
  }
  std::vector<double> columns_;  ///< shape (rows, 3, 4)
};

}  // namespace stroma::cg
