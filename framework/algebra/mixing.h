// SPDX-License-Identifier: LGPL-2.1-or-later
// A fixed point z = F(z) where z <- F(z) alone swings or is slow: the next z is the sum a_i F(z_i) over the last iterates with
// sum a_i = 1 whose sum a_i (F(z_i) - z_i) is the shortest. Directions that few nodes turn by are found in a few iterations.
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
  void restart() { count_ = 0; }
  /// `image`: F(z), which becomes the next z. `beside` goes with it, when there is something: it has been computed from z too.
  void next(ConstRows z, Rows image, Rows beside = {}) {
    Stored& now = stored_[std::size_t(count_++ % depth)];
    for (Vector* vector : {&now.way, &now.image})  // the first time alone
      if (vector->count() != z.count) vector->resize(z.count);
    if (now.beside.count() != beside.count) now.beside.resize(beside.count);
    copy(image, now.way);
    axpy(-1, z, now.way);
    copy(image, now.image), copy(beside, now.beside);
    const int known = std::min(count_, depth);
    for (int i = 0; i < known; ++i)
      for (int j = 0; j <= i; ++j)
        products_(i, j) = products_(j, i) = dot(stored_[std::size_t(i)].way, stored_[std::size_t(j)].way);
    const Few lengths = products_.diagonal().head(known).cwiseSqrt();
    if (!(lengths.minCoeff() > 0)) return;
    // scaled by their lengths b_i = a_i |way_i|, with as much on the diagonal as round-off takes
    const Few inverse = lengths.cwiseInverse();
    FewByFew scaled = inverse.asDiagonal() * products_.topLeftCorner(known, known) * inverse.asDiagonal();
    scaled.diagonal().array() += 1e-13;
    const Few solved = scaled.ldlt().solve(inverse);
    Few weights = inverse.cwiseProduct(solved);
    weights /= weights.sum();
    // large ones that cancel lead anywhere
    constexpr double largest_sum = 10;
    if (!(weights.cwiseAbs().sum() <= largest_sum)) return restart();
    clear(image), clear(beside);
    for (int i = 0; i < known; ++i)
      axpy(weights[i], stored_[std::size_t(i)].image, image), axpy(weights[i], stored_[std::size_t(i)].beside, beside);
  }

 private:
  static constexpr int depth = 8;
  using Few = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, depth, 1>;  // in place, as many as are known
  using FewByFew = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, depth, depth>;
  struct Stored {
    Vector way, image, beside;  ///< F(z) - z, F(z)
  };
  std::array<Stored, depth> stored_;
  Eigen::Matrix<double, depth, depth> products_;
  int count_ = 0;
};

}  // namespace stroma
