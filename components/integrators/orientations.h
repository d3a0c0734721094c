// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "framework/mechanics/motion.h"

namespace stroma {

/// Extracts the orientations of a vector for loops that add several increments. Keep one object from step to step: it
/// allocates only once.
class Orientations {
 public:
  /// Extracts them from x, from row `first_row` on, leaving zeros on which rotation vectors accumulate like other increments.
  void take(const Motion& motion, Rows x, Index first_row = 0) {
    turning_ = &motion.turningRows(), first_ = 0;
    if (first_row > 0) first_ = countBelow(first_row);
    q_.resize(turning_->size() * row_doubles);
    for (std::size_t i = first_, count = countBelow(x.count); i < count; ++i) {
      double* const row = rowOf(i, x);
      std::copy_n(row, row_doubles, q_.data() + i * row_doubles);
      std::fill_n(row, row_doubles, 0.);
    }
  }
  /// Writes them back to x, rotated by the accumulated vectors; also to several vectors derived from one.
  void turn(Rows x) {
    const std::size_t count = countBelow(x.count);
    for (std::size_t first = first_; first < count; first += many) turnSome(first, std::min(many, count - first), x);
  }

 private:
  static constexpr std::size_t many = 64;

  std::size_t countBelow(Index row) const {
    return std::size_t(std::lower_bound(turning_->begin(), turning_->end(), row) - turning_->begin());
  }
  double* rowOf(std::size_t i, Rows x) const { return x.data + std::size_t((*turning_)[i]) * row_doubles; }

  /// q' = exp(r) q as in Motion::turnBy(), without trigonometry and square roots for small rotations, which most steps have.
  void turnSome(std::size_t first, std::size_t count, Rows x) {
    alignas(64) double r[3][many], q[4][many], plain[many];
    for (std::size_t i = 0; i < count; ++i) {
      const double *row = rowOf(first + i, x), *from = q_.data() + (first + i) * row_doubles;
      for (std::size_t k = 0; k < 3; ++k) r[k][i] = row[k];
      for (std::size_t k = 0; k < 4; ++k) q[k][i] = from[k];
    }
#pragma omp simd
    for (std::size_t i = 0; i < count; ++i) {
      const double s = r[0][i] * r[0][i] + r[1][i] * r[1][i] + r[2][i] * r[2][i], z = s / 4;
      // sin(|r|/2)/|r| and cos(|r|/2); the first omitted terms are below 1e-17
      const double factor = 0.5 - z * (1. / 12 - z * (1. / 240 - z * (1. / 10080 - z * (1. / 725760 - z / 79833600))));
      const double c =
          1 - z * (1. / 2 - z * (1. / 24 - z * (1. / 720 - z * (1. / 40320 - z * (1. / 3628800 - z / 479001600)))));
      const double a = factor * r[0][i], b = factor * r[1][i], d = factor * r[2][i];
      const double x0 = q[0][i], y0 = q[1][i], z0 = q[2][i], w0 = q[3][i];
      const double x1 = c * x0 + w0 * a + b * z0 - d * y0, y1 = c * y0 + w0 * b + d * x0 - a * z0;
      const double z1 = c * z0 + w0 * d + a * y0 - b * x0, w1 = c * w0 - a * x0 - b * y0 - d * z0;
      // round-off must not accumulate: 1/sqrt(1 + e) equals 1 - e/2 in double precision
      const double excess = x1 * x1 + y1 * y1 + z1 * z1 + w1 * w1 - 1;
      const double scale = 1 - 0.5 * excess;
      plain[i] = (s < 0.06) & (std::abs(excess) < 1e-8) ? 1 : 0;
      const bool moves = s > 0;
      q[0][i] = moves ? scale * x1 : x0, q[1][i] = moves ? scale * y1 : y0;
      q[2][i] = moves ? scale * z1 : z0, q[3][i] = moves ? scale * w1 : w0;
    }
    for (std::size_t i = 0; i < count; ++i) {
      double* const row = rowOf(first + i, x);
      if (plain[i] > 0) {
        for (std::size_t k = 0; k < 4; ++k) row[k] = q[k][i];
      } else {
        std::copy_n(q_.data() + (first + i) * row_doubles, row_doubles, row);
        Motion::turnBy(Vec3(r[0][i], r[1][i], r[2][i]), row);
      }
    }
  }

  const std::vector<Index>* turning_ = nullptr;
  std::size_t first_ = 0;  ///< of these, that is taken
  std::vector<double> q_;  ///< shape (turning rows, 4)
};

}  // namespace stroma
