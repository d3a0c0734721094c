// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/algebra/linear_solver.h"
#include "framework/simulation/assembled_matrix.h"
#include "framework/simulation/phase_times.h"

namespace stroma {

class System;

/// The matrix of a linear solve on a system,
///   A = P (sum (m + m_r rayleighMass) M + sum (k + k_r rayleighStiffness) K + sum c C) P + (I - P)
/// with the factors m, m_r, k, k_r, c in the order of masses, force fields and velocity-dependent fields, and K and C of
/// the last force. Available as products, and assembled if a solver asks for it.
class MechanicalMatrix final : public SystemMatrix {
 public:
  explicit MechanicalMatrix(const System& system);
  /// This matrix with these factors, which stay until others are set.
  MechanicalMatrix& withFactors(const MatrixFactors& factors);
  void valuesChanged();  ///< of terms treated as constant, in the same pattern
  void termsChanged();   ///< invalidates everything that was kept
  void serialize(Archive& archive);  ///< see Component::serialize()

  Index rows() const override;
  void multiply(ConstRows p, Rows out) const override;
  const BlockMatrix& assemble() override;
  const BlockMatrix& pattern() override { return assembled_.pattern(); }
  void diagonalBlocks(std::vector<double>& blocks) const override;
  MatrixKey key() const override { return {identity().get(), assembled_.patternRevision(), valuesRevision()}; }
  bool symmetric() const override;
  bool prefersAssembled(int expected_products) const override;
  double productCost() const override;
  double assemblyCost() const override;
  ConstRows positions() const override;
  bool isOfLooseNodes() const override;
  bool hasTurns() const override;
  std::string describeRow(Index row) const override;

  /// Blocks of the stored matrix; -1: none so far.
  Index keptBlocks() const { return assembled_.hasPattern() ? assembled_.blocks() : -1; }

 private:
  long valuesRevision() const;
  void multiplyFree(ConstRows p, Rows out) const;

  const System& system_;
  const Actors& actors_;
  const MappingChain& mappings_;
  const ConstraintSet& constraints_;
  MatrixFactors factors_;
  long factors_revision_ = 0;
  mutable AssembledMatrix assembled_;  ///< created on demand, also to determine its size
  long assembled_revision_ = -1;
  mutable Vector free_part_;               ///< work space, only with relations
  mutable std::vector<double> diagonals_;  ///< the same
};

}  // namespace stroma
