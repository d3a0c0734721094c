// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/algebra/direct_solver.h"

namespace stroma {

/// P A P^T = L L^T on supernodes, by CHOLMOD: of a symmetric positive definite matrix, whose upper triangle is read.
class CholeskyFactor : public Factorisation {
 public:
  static std::unique_ptr<CholeskyFactor> make();
  virtual const std::string& ordering() const = 0;
  virtual double flops() const = 0;    ///< of a factorisation
  virtual double entries() const = 0;  ///< numbers in the factor
};

}  // namespace stroma
