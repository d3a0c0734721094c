// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/direct_solver.h"

namespace stroma {

/// P A Q = L U with partial pivoting, columns in COLAMD's order: any regular matrix, symmetric or not.
class LUFactor : public Factorisation {
 public:
  static std::unique_ptr<LUFactor> make();
  /// Numbers in the factors.
  virtual double entries() const = 0;
};

}  // namespace stroma
