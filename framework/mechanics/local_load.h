// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/scene/types.h"

namespace stroma {

/// Implemented by force fields that act on a fixed set of nodes, so that a search for loads need not visit all nodes.
class LocalLoad {
 public:
  virtual ~LocalLoad() = default;
  /// Appends every row of the system that the force can ever act on; call after compile(). Duplicates are allowed.
  virtual void addLoadedRows(std::vector<Index>& rows) const = 0;
  /// True for a force that is nonlinear only because a fixed stress follows the current surface. Linear elasticity does
  /// not distinguish the current shape from the rest shape and treats it as the dead load of the rest shape.
  virtual bool isDeadLoadToFirstOrder() const { return false; }
};

}  // namespace stroma
