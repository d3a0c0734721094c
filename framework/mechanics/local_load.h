// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/scene/types.h"

namespace stroma {

/// Implemented by force fields that act on nodes known in advance, so that a search for loads need not visit
/// all nodes.
class LocalLoad {
 public:
  virtual ~LocalLoad() = default;
  /// Appends every row of the system that the force can act on, at all times; after compile(). Repetitions are allowed.
  virtual void addLoadedRows(std::vector<Index>& rows) const = 0;
  /// True for a force that is nonlinear in x only because it follows the surface that a fixed stress acts on.
  /// Linear elasticity, which does not distinguish the current shape from the rest shape, takes it as the
  /// dead load of the rest shape.
  virtual bool isDeadLoadToFirstOrder() const { return false; }
};

}  // namespace stroma
