// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cassert>

#include "framework/algebra/vector.h"
#include "framework/scene/component.h"

namespace stroma {

/// The kind of a row. A point has one row, a number one, a rigid frame two: its centre and its orientation.
enum class RowKind : unsigned char {
  place,  ///< a point in space [m]; increments add
  value,  ///< one number and three zeros; increments add
  turn    ///< a unit quaternion x y z w in positions; in all other vectors a rotation vector [rad], an angular velocity
          ///< [rad/s], a torque [N m], in fixed axes. Motion applies increments to it
};

/// The role of a MechanicalObject: the nodes of a body. After compilation its current x and v are rows
/// [firstRow(), firstRow() + size()) of its System's vectors; before, they are the initial values below.
class State : public Component {
 public:
  std::string roleText() const override { return "mechanical state"; }

  Index size() const { return Index(rest_position.size()); }  ///< rows
  /// The unit that a scene counts and indexes: points, frames (two rows), groups of two or six numbers.
  Index nodes() const { return size() / rows_per_node; }
  bool hasPointsOnly() const { return row_kinds.empty(); }
  bool hasFrames() const { return rows_per_node == 2 && kindOf(1) == RowKind::turn; }
  Index firstRow() const { return first_row_; }
  /// This state's rows of a vector of its system.
  Rows segment(Rows all) const { return all.segment(first_row_, size()); }
  ConstRows segment(ConstRows all) const { return all.segment(first_row_, size()); }
  Rows x() const { return segment(x_); }
  Rows v() const { return segment(v_); }
  /// The net force at the end of the step [N], for observers that called requestForce() in their init(). It needs an extra
  /// evaluation; without a request the value belongs to no particular time.
  ConstRows f() const {
    assert(force_requested_ && "requestForce() comes before the first step");
    return segment(f_);
  }
  void requestForce() { force_requested_ = true; }
  bool forceRequested() const { return force_requested_; }
  bool isBound() const { return x_.data != nullptr; }
  /// Called by System with the whole vectors and the first row of this state.
  void bind(Index first_row, Rows x, Rows v, ConstRows f) { first_row_ = first_row, x_ = x, v_ = v, f_ = f; }

  std::vector<Vec3> rest_position;  ///< [m], shape (size); does not change
  std::vector<Vec3> position;       ///< [m], initial positions, shape (size)
  std::vector<Vec3> velocity;       ///< [m/s], initial velocities, shape (size)
  /// Kinds of the rows, shape (size); empty: all are places. Set in init(). In the three vectors above an orientation is
  /// given by its rotation vector [rad] (frames.h).
  std::vector<RowKind> row_kinds;
  Index rows_per_node = 1;
  RowKind kindOf(Index row) const { return row_kinds.empty() ? RowKind::place : row_kinds[std::size_t(row)]; }

 private:
  /// The rows of this state in the vectors below.
  Index first_row_ = 0;
  /// The vectors of the whole system, which owns them; null until it exists.
  Rows x_, v_;
  ConstRows f_;
  bool force_requested_ = false;
};

}  // namespace stroma
