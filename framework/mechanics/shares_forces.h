// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/vector.h"

namespace stroma {
/// What a LagrangianConstraint knows of the forces of its rows: some say the same as others, and no force is the only one.
class SharesForces {
 public:
  virtual ~SharesForces() = default;
  /// Where the search begins [N], and by what rows that say the same yield to a force, in comparison; 0: this one says it alone.
  virtual void expectForces(std::span<double> forces, std::span<double> yields) const = 0;
};
}  // namespace stroma
