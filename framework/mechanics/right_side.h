// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/vector.h"

namespace stroma {

/// A role of a constraint whose nodes may stay free in the matrix of a step: its projectors are then identities, the integrator
/// projects the right-hand side of the single linear solve, and prescribe() sets the resulting positions.
class ProjectsRightSide {
 public:
  virtual ~ProjectsRightSide() = default;
  virtual bool leavesMatrix() const = 0;
  virtual void projectRightSide(Rows b) const = 0;  ///< shape (independentRows())
};

/// The role of an integrator that supports this.
class AsksRightSides {
 public:
  virtual ~AsksRightSides() = default;
};

}  // namespace stroma
