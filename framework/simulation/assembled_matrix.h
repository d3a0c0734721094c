// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/simulation/constraint_set.h"
#include "framework/simulation/mapped_matrix.h"
#include "framework/simulation/mapping_chain.h"

namespace stroma {

/// The factors of the terms of a system matrix. Rayleigh factors multiply the local ones of masses and force fields. Part of
/// `stiffness` may be damping, which excludes force fields with the trait `undamped`.
struct MatrixFactors {
  double mass = 0, stiffness = 0, damping = 0, rayleigh_mass = 0, rayleigh_stiffness = 0, part_of_damping = 0;
  bool operator==(const MatrixFactors&) const = default;
  double of(const ForceField& field) const {
    const double left_out = part_of_damping != 0 && field.traits().undamped ? part_of_damping : 0;
    return stiffness - left_out + rayleigh_stiffness * field.rayleigh_stiffness;
  }
  double of(const Mass& mass_term) const { return mass + rayleigh_mass * mass_term.rayleigh_mass; }
};

/// The terms of a system matrix summed in 3x3 blocks, with constraints eliminated. The pattern is built on first use, and
/// again after force fields have changed it (ForceField::patternRevision()).
class AssembledMatrix {
 public:
  AssembledMatrix(const Actors& actors, const MappingChain& mappings, const ConstraintSet& constraints);
  /// The matrix with its pattern; values are those of the last assemble().
  const BlockMatrix& pattern();
  bool hasPattern() const { return matrix_.rows() > 0; }
  /// Increases when the pattern may have changed: a force field has changed it, or the terms are different.
  long patternRevision() const { return actors_.patternRevision() + terms_revision_; }
  /// The terms are different, and so may be the pattern.
  void termsChanged() { ++terms_revision_, fewest_blocks_ = -1; }
  /// The constant terms have new values.
  void forgetConstantPart() { constant_part_.clear(); }
  /// Releases the pattern and its memory, but remembers its number of blocks.
  void dropPattern() { matrix_ = {}, mapped_.release(); }
  /// Blocks of the pattern; -1: unknown for the current one.
  Index blocks() const { return revision_ == patternRevision() ? block_count_ : -1; }
  /// No more than the pattern has now: without the terms that change it, which are counted once.
  Index fewestBlocks();
  const BlockMatrix& matrix() const { return matrix_; }
  /// Nanoseconds that J^T K J adds to an assembly once its blocks are known; 0 without mappings.
  double reductionCost() const { return mapped_.cost(); }

  /// Computes the matrix with these factors at the state of the last force.
  const BlockMatrix& assemble(const MatrixFactors& factors);

 private:
  void makePattern();
  void addTerms(BlockPattern& pattern, bool with_changing) const;
  void addConstantParts(const MatrixFactors& factors, BlockMatrix& matrix);
  void addChangingParts(const MatrixFactors& factors, BlockMatrix& matrix) const;
  void addConstantTerms(const MatrixFactors& factors, BlockMatrix& matrix) const;
  void eliminateProjectors();

  const Actors& actors_;
  const MappingChain& mappings_;
  const ConstraintSet& constraints_;
  BlockMatrix matrix_;
  MappedMatrix mapped_;  ///< only with mappings
  Index block_count_ = -1, fewest_blocks_ = -1;
  /// patternRevision() of the pattern or, if that was released, of its number of blocks.
  long revision_ = -1;
  long terms_revision_ = 0;
  /// Values of the constant terms, shape (blocks, 9), with the factors they were added with; empty: none kept.
  std::vector<double> constant_part_;
  MatrixFactors constant_factors_;
};

}  // namespace stroma
