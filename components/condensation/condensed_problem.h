// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/condensation/condensed_integrator.h"

namespace stroma {

/// What the precomputation depends on.
struct CondensedIntegrator::Problem {
  System& system;
  BlockMatrix stiffness{};
  std::vector<double> shift{};             ///< of the diagonal [N/m]
  std::vector<double> mass{}, per_mass{};  ///< m_i [kg] and 1/dt^2 + alpha_i/2dt [1/s^2] of free nodes
  std::vector<double> force{};             ///< constant loads, shape (free, 3)
  std::vector<Index> order{};
  ContentKey key{};
};

}  // namespace stroma
