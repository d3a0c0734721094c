// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/scene/types.h"

namespace stroma {

/// Implemented by force fields that act on nodes which are known beforehand, so that who looks for loads need not look
/// at all nodes.
class LocalLoad {
 public:
  virtual ~LocalLoad() = default;
  /// Appends every row of the system that the force can act on, at all times; after compile(). Repetitions are allowed.
  virtual void addLoadedRows(std::vector<Index>& rows) const = 0;
  /// True for a force that is not linear in x, but only because it turns and grows with the surface that a fixed stress
  /// acts on. Linear elasticity, which knows no difference between the present shape and that at rest, takes it for the
  /// dead load of the rest shape.
  virtual bool isDeadLoadToFirstOrder() const { return false; }
};

}  // namespace stroma
