// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/vector.h"

namespace stroma {

/// Besides a constraint whose nodes may be free in the matrix of a step: then its projectors are identities, an integrator projects
/// the right side of the one linear solve, and prescribe() places what comes of it.
class ProjectsRightSide {
 public:
  virtual ~ProjectsRightSide() = default;
  virtual bool leavesMatrix() const = 0;
  virtual void projectRightSide(Rows b) const = 0;  ///< shape (independentRows())
};

/// The role of an integrator that does.
class AsksRightSides {
 public:
  virtual ~AsksRightSides() = default;
};

}  // namespace stroma
