// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/direct_solvers/interruptible_factor.h"

namespace stroma {

/// A direct solver that is its factorisation, without attributes of its own.
template <class Factor, bool needs_symmetric>
class FactorSolver final : public DirectSolver {
 public:
  bool needsSymmetric() const override { return needs_symmetric; }
  Index mostRows() const override {
    if constexpr (requires { Factor::most_rows; }) return Factor::most_rows;
    return DirectSolver::mostRows();
  }

 private:
  std::unique_ptr<Factorisation> makeFactorisation(bool) const override {
    return std::make_unique<InterruptibleFactor<Factor>>([] { return std::make_unique<Factor>(); });
  }
};

}  // namespace stroma
