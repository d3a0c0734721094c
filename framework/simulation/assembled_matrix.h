// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/simulation/constraint_set.h"
#include "framework/simulation/mapped_matrix.h"
#include "framework/simulation/mapping_chain.h"

namespace stroma {

/// The factors of the terms of a system's matrix. Rayleigh factors multiply each mass's and force field's own. A part of
/// `stiffness` may be damping, in which force fields with the trait `undamped` have no share.
struct MatrixFactors {
  double mass = 0, stiffness = 0, damping = 0, rayleigh_mass = 0, rayleigh_stiffness = 0, part_of_damping = 0;
  bool operator==(const MatrixFactors&) const = default;
  double of(const ForceField& field) const {
    const double left_out = part_of_damping != 0 && field.traits().undamped ? part_of_damping : 0;
    return stiffness - left_out + rayleigh_stiffness * field.rayleigh_stiffness;
  }
  double of(const Mass& mass_term) const { return mass + rayleigh_mass * mass_term.rayleigh_mass; }
};

/// The terms of a system's matrix added up in 3x3 blocks, constraints eliminated. The pattern is made when it is first
/// asked for, and again after force fields have changed it (ForceField::patternRevision()).
class AssembledMatrix {
 public:
  AssembledMatrix(const Actors& actors, const MappingChain& mappings, const ConstraintSet& constraints);
  /// The matrix with its pattern; values are those of the last assemble().
  const BlockMatrix& pattern();
  bool hasPattern() const { return matrix_.rows() > 0; }
  /// Grows when the pattern may have changed: force fields say so, or the terms are others.
  long patternRevision() const { return actors_.patternRevision() + terms_revision_; }
  /// What the terms are made of is another: the pattern too may be.
  void termsChanged() { ++terms_revision_; }
  /// The terms that do not change have other values.
  void forgetConstantPart() { constant_part_.clear(); }
  /// Forgets the pattern and its memory, but for the number of its blocks.
  void dropPattern() { matrix_ = {}, mapped_.release(); }
  /// Blocks of the pattern; -1: not known for the present one.
  Index blocks() const { return revision_ == patternRevision() ? block_count_ : -1; }
  const BlockMatrix& matrix() const { return matrix_; }
  /// Nanoseconds that J^T K J adds to an assembly once its blocks are known; 0 without mappings.
  double reductionCost() const { return mapped_.cost(); }

  /// Values of the matrix with these factors at the state of the last force.
  const BlockMatrix& assemble(const MatrixFactors& factors);

 private:
  void makePattern();
  void addConstantParts(const MatrixFactors& factors, BlockMatrix& matrix);
  void addChangingParts(const MatrixFactors& factors, BlockMatrix& matrix) const;
  void addConstantTerms(const MatrixFactors& factors, BlockMatrix& matrix) const;
  void eliminateProjectors();

  const Actors& actors_;
  const MappingChain& mappings_;
  const ConstraintSet& constraints_;
  BlockMatrix matrix_;
  MappedMatrix mapped_;  ///< only with mappings
  Index block_count_ = -1;
  /// patternRevision() of the pattern or, where that was dropped, of its number of blocks.
  long revision_ = -1;
  long terms_revision_ = 0;
  /// Values of the terms that do not change, shape (blocks, 9), with the factors they were added with; empty: none kept.
  std::vector<double> constant_part_;
  MatrixFactors constant_factors_;
};

}  // namespace stroma
