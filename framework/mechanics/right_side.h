// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/vector.h"

namespace stroma {

/// A role beside a constraint's: its nodes may be free in the matrix of a step. Its projectors are then identities, the integrator
/// projects the right side of its one linear solve, and prescribe() places the result.
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
