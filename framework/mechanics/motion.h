// SPDX-License-Identifier: LGPL-2.1-or-later
// How increments change positions: points and numbers add, orientations rotate. This file is the only place that
// knows the difference.
#pragma once
#include <vector>

#include "framework/mechanics/state.h"

namespace stroma {

/// Computes x + dx for a whole system. An orientation is a unit quaternion q (x, y, z, w) in x and has three numbers in
/// every other vector. An increment with the rotation vector r (axis times angle [rad], in fixed axes) gives
///   q' = exp(r) q,   exp(r) = (sin(|r|/2) r/|r|, cos(|r|/2))
/// q and -q are the same orientation. The sign follows the motion from the initial position: a recording has no jumps.
/// Without orientations each function is a plain loop.
class Motion {
 public:
  /// From the rows of bound states.
  void compile(const std::vector<State*>& states);
  bool turns() const { return !turning_.empty(); }
  /// The kind of row `row` of the system.
  RowKind kindOf(Index row) const;

  /// Moves x by s dx, for the rows of `dx`; x may have more.
  void advance(double s, ConstRows dx, Rows x) const {
    walk(
        dx.count, [&](Index begin, Index end) { axpy(s, part(dx, begin, end), part(x, begin, end)); },
        [&](Index row) { turnBy(s * Vec3(dx[row]), x.data + std::size_t(row) * row_doubles); });
  }
  /// Replaces x0 by the increment that leads from it to x1.
  void difference(ConstRows x1, Rows x0) const {
    walk(
        x0.count, [&](Index begin, Index end) { xpay(part(x1, begin, end), -1, part(x0, begin, end)); },
        [&](Index row) { x0[row] = increment(x0, x1, row), x0.data[std::size_t(row) * row_doubles + 3] = 0; });
  }
  /// The increment that leads from row `row` of x0 to row `row` of x1, or to another row of the same kind.
  Vec3 increment(ConstRows x0, ConstRows x1, Index row) const { return increment(x0, x1, row, row); }
  Vec3 increment(ConstRows x0, ConstRows x1, Index row, Index to) const;
  /// Moves one row by dx.
  void advanceRow(const Vec3& dx, Rows x, Index row) const;
  /// The rows that are orientations, ascending.
  const std::vector<Index>& turningRows() const { return turning_; }
  /// Replaces the orientation q, four numbers, by exp(r) q.
  static void turnBy(const Vec3& r, double* q);

 private:
  /// Visits the first `count` rows: ranges of rows that add, and orientations one by one.
  template <class Range, class Turning>
  void walk(Index count, Range&& range, Turning&& turning) const {
    Index done = 0;
    for (const Index row : turning_) {
      if (row >= count) break;
      range(done, row);
      turning(row);
      done = row + 1;
    }
    range(done, count);
  }
  template <class View>
  static View part(View x, Index begin, Index end) {
    return {x.data + std::size_t(begin) * row_doubles, end - begin};
  }

  std::vector<Index> turning_;  ///< ascending
  std::vector<RowKind> kinds_;  ///< shape (rows), empty where all rows are places
};

}  // namespace stroma
