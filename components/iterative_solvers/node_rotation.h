// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <Eigen/Geometry>
#include <cmath>

#include "framework/algebra/vector.h"

namespace stroma {

/// sum (x_j - x_i) (X_j - X_i)^T over the neighbours j of a node, X where they were: by columns of four numbers. `start` and `columns`
/// are those of a matrix by rows.
template <class Starts, class Columns>
Eigen::Array<double, 4, 3> spreadAround(const Starts& start, const Columns& columns, Index i, ConstRows x, ConstRows was) {
  static_assert(row_doubles == 4);
  const auto at = [](ConstRows rows, Index j) {
    return Eigen::Array4d(Eigen::Map<const Eigen::Array4d>(rows.data + std::size_t(j) * row_doubles));
  };
  const Eigen::Array4d now_i = at(x, i), was_i = at(was, i);
  Eigen::Array4d first = Eigen::Array4d::Zero(), second = first, third = first;
  for (Index s = start[std::size_t(i)]; s < start[std::size_t(i) + 1]; ++s) {
    const Index j = columns[std::size_t(s)];
    const Eigen::Array4d now = at(x, j) - now_i, before = at(was, j) - was_i;
    first += now * before[0];
    second += now * before[1];
    third += now * before[2];
  }
  Eigen::Array<double, 4, 3> sum;
  sum << first, second, third;
  return sum;
}

/// Turns the quaternions q of eight nodes to the rotations nearest to A (largest trace of R^T A), from the q given (Mueller, Bender,
/// Chentanez, Macklin 2016): works for any A, also one that inverts or has lost a rank. Ends with turns below `enough` [rad].
/// Quaternions have a column each of x, y, z, w; `a` has one for each entry, by columns.
/// Turns are without sines: q + w q/2 with the length 1 differs from the turn by w in third order, which the next one sees.
struct EightRotations {
  using Numbers = Eigen::Array<double, 8, 1>;
  Eigen::Array<double, 8, 9> a;
  Eigen::Array<double, 8, 4> q = identity();

  static Eigen::Array<double, 8, 4> identity() {
    Eigen::Array<double, 8, 4> q = Eigen::Array<double, 8, 4>::Zero();
    q.col(3) = 1;
    return q;
  }

  void follow(double enough) {
    for (int i = 0; i < 10; ++i)
      if (!(turnOnce() > enough * enough)) break;
    for (Eigen::Index i = 0; i < 8; ++i)
      if (!q.row(i).allFinite()) q.row(i) << 0, 0, 0, 1;
  }

 private:
  /// Returns the square of the largest turn.
  double turnOnce() {
    const Numbers x = q.col(0), y = q.col(1), z = q.col(2), w = q.col(3);
    const Numbers r00 = 1 - 2 * (y * y + z * z), r01 = 2 * (x * y - w * z), r02 = 2 * (x * z + w * y);
    const Numbers r10 = 2 * (x * y + w * z), r11 = 1 - 2 * (x * x + z * z), r12 = 2 * (y * z - w * x);
    const Numbers r20 = 2 * (x * z - w * y), r21 = 2 * (y * z + w * x), r22 = 1 - 2 * (x * x + y * y);
    const Numbers trace = r00 * a.col(0) + r10 * a.col(1) + r20 * a.col(2) + r01 * a.col(3) + r11 * a.col(4) + r21 * a.col(5) +
                          r02 * a.col(6) + r12 * a.col(7) + r22 * a.col(8);
    const Numbers scale = (trace.abs() + 1e-9 * a.square().rowwise().sum().sqrt()).max(1e-300).inverse();
    const Numbers u = scale * (r10 * a.col(2) - r20 * a.col(1) + r11 * a.col(5) - r21 * a.col(4) + r12 * a.col(8) - r22 * a.col(7));
    const Numbers v = scale * (r20 * a.col(0) - r00 * a.col(2) + r21 * a.col(3) - r01 * a.col(5) + r22 * a.col(6) - r02 * a.col(8));
    const Numbers s = scale * (r00 * a.col(1) - r10 * a.col(0) + r01 * a.col(4) - r11 * a.col(3) + r02 * a.col(7) - r12 * a.col(6));
    q.col(0) = x + 0.5 * (u * w + v * z - s * y);
    q.col(1) = y + 0.5 * (v * w + s * x - u * z);
    q.col(2) = z + 0.5 * (s * w + u * y - v * x);
    q.col(3) = w - 0.5 * (u * x + v * y + s * z);
    const Numbers length = q.square().rowwise().sum().sqrt().inverse();
    q.colwise() *= length;
    return (u * u + v * v + s * s).maxCoeff();
  }
};

}  // namespace stroma
