// SPDX-License-Identifier: LGPL-2.1-or-later
// Anderson acceleration of a fixed-point iteration z <- F(z) that oscillates or converges slowly. The next z is the
// combination sum a_i F(z_i) of the last iterates, with sum a_i = 1, that minimises |sum a_i (F(z_i) - z_i)|. Large
// coefficients are only safe if F is nearly linear. sum |a_i| is therefore bounded, and the bound grows as long as F(z) - z
// is reduced as predicted. A contraction by 0.992 takes some 250 iterations. If an iterate gets worse, it restarts from the best.
//
// Source: D. G. Anderson, "Iterative procedures for nonlinear integral equations", 1965, in the form of P. Pulay, 1980.
#pragma once
#include <Eigen/Dense>
#include <algorithm>
#include <array>

#include "framework/algebra/vector.h"

namespace stroma {

class Mixing {
 public:
  void restart() { count_ = 0, most_ = first_most, expected_ = 0; }
  /// Replaces `image` = F(z) by the next z. `beside`, if given, is another function of z that is combined in the same way.
  void next(ConstRows z, Rows image, Rows beside = {}) {
    const int last = count_++ % depth, known = std::min(count_, depth);
    Stored& now = stored_[std::size_t(last)];
    for (Vector* vector : {&now.way, &now.image})  // the first time alone
      if (vector->count() != z.count) vector->resize(z.count);
    if (now.beside.count() != beside.count) now.beside.resize(beside.count);
    copy(image, now.way), axpy(-1, z, now.way);
    copy(image, now.image), copy(beside, now.beside);
    for (int i = 0; i < known; ++i) products_(i, last) = products_(last, i) = dot(stored_[std::size_t(i)].way, now.way);
    const Few lengths = products_.diagonal().head(known).cwiseSqrt();
    int best = 0;
    if (!(lengths.minCoeff(&best) > 0)) return;
    constexpr double astray = 4, as_expected = 2, most_of_all = 1e6;
    if (lengths[last] > astray * lengths[best]) {
      copy(stored_[std::size_t(best)].image, image), copy(stored_[std::size_t(best)].beside, beside);
      return restart();
    }
    most_ = lengths[last] <= as_expected * expected_ ? std::min(10 * most_, most_of_all) : std::max(most_ / 2, first_most);
    // scaled by their lengths b_i = a_i |way_i|, with as much on the diagonal as round-off takes
    const Few inverse = lengths.cwiseInverse();
    FewByFew scaled = inverse.asDiagonal() * products_.topLeftCorner(known, known) * inverse.asDiagonal();
    scaled.diagonal().array() += 1e-13;
    const Few solved = scaled.ldlt().solve(inverse);
    Few weights = inverse.cwiseProduct(solved);
    weights /= weights.sum();
    if (!weights.allFinite()) return restart();
    if (const double sum = weights.cwiseAbs().sum(); sum > most_) weights *= most_ / sum, weights[last] += 1 - weights.sum();
    expected_ = std::sqrt(std::max(0.0, weights.dot(products_.topLeftCorner(known, known) * weights)));
    clear(image), clear(beside);
    for (int i = 0; i < known; ++i)
      axpy(weights[i], stored_[std::size_t(i)].image, image), axpy(weights[i], stored_[std::size_t(i)].beside, beside);
  }

 private:
  static constexpr int depth = 8;
  static constexpr double first_most = 10;
  using Few = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, depth, 1>;  // in place, as many as are known
  using FewByFew = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, depth, depth>;
  struct Stored {
    Vector way, image, beside;  ///< F(z) - z, F(z)
  };
  std::array<Stored, depth> stored_;
  Eigen::Matrix<double, depth, depth> products_;
  int count_ = 0;
  double most_ = first_most, expected_ = 0;  ///< of the sum of |a_i|; of |F(z) - z|
};

}  // namespace stroma
