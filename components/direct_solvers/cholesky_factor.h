// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "framework/algebra/direct_solver.h"

namespace stroma {

/// In what precision factors are made. What is solved with those in single precision is refined to that of double.
enum class FactorPrecision { automatic, in_double, in_single };

/// What later solves with a matrix depend on.
struct FactorMemory {
  std::int64_t values = 0;  ///< of the matrix, mixed to one number
  bool is_double = false;   ///< the factors of these
  int waiting = 0;          ///< so many matrices more are factored in double precision
  int penalty = 0;          ///< so many were, the last time
  double lost = 0;          ///< seconds that iterations with these values have taken longer than factors in double precision
  double saved = 0;         ///< seconds that single precision has saved with the matrices before, less what it lost
};

class SupernodalAnalysis;

/// What a solver and its factors say to each other.
struct FactorRecord {
  FactorMemory* memory = nullptr;  ///< of the matrix of the call under way; null: each factor has its own
  bool is_single = false;          ///< the last factorisation
  int given_up = 0;                ///< factorisations in single precision that were made again in double
  long solves = 0;                 ///< with factors in single precision
  long applications = 0;           ///< of the factors in these solves
  std::weak_ptr<const SupernodalAnalysis> analysis;  ///< the last one: a matrix of its pattern takes its order
};

/// P A P^T = L L^T on supernodes, by CHOLMOD's analysis: of a symmetric positive definite matrix, whose upper triangle is read.
class CholeskyFactor : public Factorisation {
 public:
  static std::unique_ptr<CholeskyFactor> make(FactorPrecision precision = FactorPrecision::in_double,
                                              std::shared_ptr<FactorRecord> record = nullptr);
  virtual const std::string& ordering() const = 0;
  virtual double flops() const = 0;    ///< of a factorisation
  virtual double entries() const = 0;  ///< numbers in the factor
};

}  // namespace stroma
