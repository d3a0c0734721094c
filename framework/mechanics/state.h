// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cassert>

#include "framework/algebra/vector.h"
#include "framework/scene/component.h"

namespace stroma {

/// The role of a MechanicalObject: the nodes of a body. After compilation its current x and v are rows
/// [firstRow(), firstRow() + size()) of its System's vectors; before, they are the initial values below.
class State : public Component {
 public:
  std::string roleText() const override { return "mechanical state"; }

  Index size() const { return Index(rest_position.size()); }
  Index firstRow() const { return first_row_; }
  Rows x() const { return {x_.data + std::size_t(first_row_) * row_doubles, size()}; }
  Rows v() const { return {v_.data + std::size_t(first_row_) * row_doubles, size()}; }
  /// The net force of the last evaluation [N], for observers that called requestForce() in their init(): implicit steps
  /// that nobody asks have it only together with other terms, and what stands here is then that of no instant.
  ConstRows f() const {
    assert(force_requested_ && "requestForce() comes before the first step");
    return {f_.data + std::size_t(first_row_) * row_doubles, size()};
  }
  void requestForce() { force_requested_ = true; }
  bool forceRequested() const { return force_requested_; }
  bool isBound() const { return x_.data != nullptr; }
  /// Called by System: the whole vectors and where this state starts in them.
  void bind(Index first_row, Rows x, Rows v, ConstRows f) { first_row_ = first_row, x_ = x, v_ = v, f_ = f; }

  std::vector<Vec3> rest_position;  ///< [m], shape (size); does not change
  std::vector<Vec3> position;       ///< [m], initial positions, shape (size)
  std::vector<Vec3> velocity;       ///< [m/s], initial velocities, shape (size)

 private:
  /// Of this state in the vectors below.
  Index first_row_ = 0;
  /// The whole vectors of the system, which owns them; null until it is made.
  Rows x_, v_;
  ConstRows f_;
  bool force_requested_ = false;
};

}  // namespace stroma
