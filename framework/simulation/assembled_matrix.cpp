// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/assembled_matrix.h"

#include <algorithm>

#include "framework/scene/spans.h"
#include "framework/simulation/held_size.h"

namespace stroma {

AssembledMatrix::AssembledMatrix(const Actors& actors, const MappingChain& mappings, const ConstraintSet& constraints)
    : actors_(actors), mappings_(mappings), constraints_(constraints) {}

const BlockMatrix& AssembledMatrix::pattern() {
  if (!hasPattern() || revision_ != patternRevision()) makePattern();
  return matrix_;
}

void AssembledMatrix::addTerms(BlockPattern& pattern, bool with_changing) const {
  for (const Mass* mass : actors_.masses) mass->addPattern(pattern);
  for (const ForceField* field : actors_.force_fields)
    if (const ForceTraits traits = field->traits(); traits.has_stiffness || traits.velocity_dependent)
      if (with_changing || field->patternRevision() == 0) field->addPattern(pattern);
}

Index AssembledMatrix::fewestBlocks() {
  if (fewest_blocks_ >= 0) return fewest_blocks_;
  // at least those of the diagonal: with mappings no other is sure to remain, and a pattern that stays is made only once
  if (!mappings_.empty() || actors_.patternRevision() == 0) return actors_.independent_rows;
  BlockPattern pattern(actors_.independent_rows);
  addTerms(pattern, false);
  return fewest_blocks_ = BlockMatrix(std::move(pattern)).blocks();
}

void AssembledMatrix::makePattern() {
  BlockPattern pattern(mappings_.empty() ? actors_.independent_rows : actors_.all_rows);
  addTerms(pattern, true);
  for (const Mapping* mapping : actors_.mappings)
    if (!mapping->isLinear()) mapping->addGeometricPattern(pattern);
  if (mappings_.empty()) {
    matrix_ = BlockMatrix(std::move(pattern));
  } else {
    mapped_.prepare(std::move(pattern), actors_.mappings, actors_.independent_rows);
    matrix_ = mapped_.reducedPattern();
  }
  // of all times: ties and relations that come and go do not change the pattern
  if (const NodeGroups mixed = constraints_.mixedRows(); !mixed.empty()) matrix_ = mixed.withFill(matrix_);
  block_count_ = matrix_.blocks();
  const BlockMatrix& target = mappings_.empty() ? matrix_ : mapped_.full();
  for (Mass* mass : actors_.masses) mass->prepareAssembly(target);
  for (ForceField* field : actors_.force_fields) field->prepareAssembly(target);
  constant_part_.clear();
  revision_ = patternRevision();
}

const BlockMatrix& AssembledMatrix::assemble(const MatrixFactors& factors) {
  pattern();
  BlockMatrix& target = mappings_.empty() ? matrix_ : mapped_.full();
  addConstantParts(factors, target);
  addChangingParts(factors, target);
  if (!mappings_.empty()) {
    if (!mappings_.isLinear()) mapped_.updateJacobian(actors_.mappings);
    mapped_.reduce(matrix_);
  }
  constraints_.groups().average(matrix_);
  eliminateProjectors();
  constraints_.groups().complete(constraints_.projectors(), matrix_);
  constraints_.relations().eliminate(matrix_);
  return matrix_;
}

void AssembledMatrix::addConstantTerms(const MatrixFactors& factors, BlockMatrix& matrix) const {
  matrix.clear();
  for (const Mass* mass : actors_.masses)
    if (const double factor = factors.of(*mass); factor != 0) heard("assemble", mass)->addTo(factor, matrix);
  for (const ForceField* field : actors_.stiff_fields)
    if (const double factor = factors.of(*field); factor != 0 && field->traits().constant_stiffness)
      heard("assemble", field)->addStiffness(factor, matrix);
}

// Masses and constant stiffnesses are assembled again only when a factor changed. Without a constant stiffness and with
// diagonal masses, adding them again costs less than keeping their sum.
void AssembledMatrix::addConstantParts(const MatrixFactors& factors, BlockMatrix& matrix) {
  const auto is_constant = [](const ForceField* field) { return field->traits().constant_stiffness; };
  const bool worth_keeping =
      actors_.derivatives_vary && !actors_.massTurns() &&
      (!actors_.massIsDiagonal() || std::any_of(actors_.stiff_fields.begin(), actors_.stiff_fields.end(), is_constant));
  if (!worth_keeping) return addConstantTerms(factors, matrix);
  if (constant_part_.empty() || factors != constant_factors_) {
    addConstantTerms(factors, matrix);
    constant_part_ = matrix.values();
    constant_factors_ = factors;
    return;
  }
  std::copy(constant_part_.begin(), constant_part_.end(), matrix.values().begin());
}

void AssembledMatrix::addChangingParts(const MatrixFactors& factors, BlockMatrix& matrix) const {
  for (const ForceField* field : actors_.stiff_fields)
    if (const double factor = factors.of(*field); factor != 0 && !field->traits().constant_stiffness)
      heard("assemble", field)->addStiffness(factor, matrix);
  if (factors.damping != 0)
    for (const ForceField* field : actors_.damped_fields) field->addDamping(factors.damping, matrix);
  for (const Mapping* mapping : actors_.mappings)
    if (!mapping->isLinear()) mapping->addGeometricStiffness(mappings_.lastForce(), factors.stiffness, matrix);
}

// Block (i, j) becomes P_i A_ij P_j, and on the diagonal I - P_i is added, in the size of the block.
void AssembledMatrix::eliminateProjectors() {
  const std::vector<NodeProjector>& projectors = constraints_.projectors();
  if (projectors.empty()) return;
  const auto& start = matrix_.rowStart();
  const auto& columns = matrix_.columns();
  for (Index row = 0; row < actors_.independent_rows; ++row) {
    const Index left = constraints_.projectorOf(row);
    for (Index slot = start[std::size_t(row)]; slot < start[std::size_t(row) + 1]; ++slot) {
      const Index right = constraints_.projectorOf(columns[std::size_t(slot)]);
      if (left < 0 && right < 0) continue;
      auto block = blockAt(matrix_.values(), slot);
      const double size = heldSize(diagonalSize(block));
      if (left >= 0) block = (projectors[std::size_t(left)].projector * block).eval();
      if (right >= 0) block = (block * projectors[std::size_t(right)].projector).eval();
      if (columns[std::size_t(slot)] == row) block += size * (Mat3::Identity() - projectors[std::size_t(left)].projector);
    }
  }
}

}  // namespace stroma
