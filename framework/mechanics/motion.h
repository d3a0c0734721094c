// SPDX-License-Identifier: LGPL-2.1-or-later
// How the rows of positions move by increments: x of points and of numbers adds, orientations turn. The only place that
// knows it.
#pragma once
#include <vector>

#include "framework/mechanics/state.h"

namespace stroma {

/// The way from x to x + dx for a whole system. A row that turns is a unit quaternion q (x, y, z, w) in x and three
/// numbers everywhere else; by an increment with the rotation vector r (axis times angle [rad], in fixed axes)
///   q' = exp(r) q,   exp(r) = (sin(|r|/2) r/|r|, cos(|r|/2))
/// q and -q are one orientation: the one with w >= 0 is kept, so that x, y and z alone tell it.
/// Where nothing turns, each function is its plain loop.
class Motion {
 public:
  /// Of the rows of bound states.
  void compile(const std::vector<State*>& states);
  bool turns() const { return !turning_.empty(); }
  /// What row `row` of the system is made of.
  RowKind kindOf(Index row) const;

  /// x moves by s dx. Rows that `dx` has; x may have more.
  void advance(double s, ConstRows dx, Rows x) const {
    const Rows moving = x.head(dx.count);
    begin(moving);
    axpy(s, dx, moving);
    end(moving);
  }
  /// For loops that add several increments: begin() takes orientations out of x and leaves zeros, on which rotation
  /// vectors are added up as everything is; end() turns the orientations that were taken by what has come together. One
  /// begin() may serve the end() of several vectors.
  void begin(Rows x) const {
    if (turns()) takeOut(x);
  }
  void end(Rows x) const {
    if (turns()) turnBack(x);
  }
  /// x0 becomes the increment that leads from it to x1.
  void difference(ConstRows x1, Rows x0) const {
    if (turns()) return rotationsBetween(x1, x0);
    xpay(x1, -1, x0);
  }

 private:
  void takeOut(Rows x) const;
  void turnBack(Rows x) const;
  void rotationsBetween(ConstRows x1, Rows x0) const;

  std::vector<Index> turning_;     ///< ascending
  std::vector<RowKind> kinds_;     ///< shape (rows), empty where all rows are places
  mutable std::vector<double> q_;  ///< what begin() took, shape (turning rows, 4)
  mutable std::vector<Vec3> r_;    ///< work space of rotationsBetween(), shape (turning rows)
};

}  // namespace stroma
