// SPDX-License-Identifier: LGPL-2.1-or-later
// The matrix of a linear solve, A = P (m M + k K + c C) P + (I - P): its products, its assembled form and the choice
// between the two.
#include <algorithm>
#include <cassert>
#include <cstring>

#include "framework/simulation/system.h"

namespace stroma {

namespace {

/// Nanoseconds a block of an assembled product out of cache: 76 bytes at the read bandwidth of one core.
constexpr double block_product_nanoseconds = 2.9;

using Block = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

Block blockAt(std::vector<double>& values, Index slot) { return Block(values.data() + std::size_t(slot) * 9); }

}  // namespace

// ---- mass ----

template <class Factor>
void System::addMassProducts(ConstRows p, Rows out, Factor factor) const {
  if (mappings_.empty()) {
    for (const Mass* mass : masses_)
      if (factor(*mass) != 0) mass->addProduct(p, factor(*mass), out);
    return;
  }
  const ConstRows p_all = onAllRows(p, mapped_p_, false);
  clear(mapped_f_);
  for (const Mass* mass : masses_)
    if (factor(*mass) != 0) mass->addProduct(p_all, factor(*mass), mapped_f_);
  pullBack(mapped_f_);
  axpy(1, ConstRows{mapped_f_.rows().data, independent_rows_}, Rows{out.data, independent_rows_});
}

void System::addMassProduct(ConstRows p, double factor, Rows out) const {
  addMassProducts(p, out, [factor](const Mass&) { return factor; });
}

void System::addRayleighMassProduct(ConstRows p, double rayleigh, double factor, Rows out) const {
  addMassProducts(p, out, [=](const Mass& mass) { return (rayleigh + mass.rayleigh_mass) * factor; });
}

bool System::massIsDiagonal() const {
  const auto on_mapped = [this](const Mass* mass) { return mass->state().firstRow() >= independent_rows_; };
  return std::all_of(masses_.begin(), masses_.end(),
                     [&on_mapped](const Mass* mass) { return mass->isDiagonal() && !on_mapped(mass); });
}

// ---- products ----

SystemMatrix& System::matrix(const MatrixFactors& factors) {
  if (factors != factors_) ++revision_;
  factors_ = factors;
  return *this;
}

void System::addStiffnessProduct(ConstRows p, double k, double k_rayleigh, Rows out) const {
  const PhaseTimer timer(times.product);
  const ConstRows p_all = onAllRows(p, mapped_p_, false);
  const Rows all = mappings_.empty() ? out : mapped_f_.rows();
  if (!mappings_.empty()) clear(all);
  for (const ForceField* field : stiff_fields_)
    if (const double factor = k + k_rayleigh * field->rayleigh_stiffness; factor != 0)
      field->addStiffnessProduct(p_all, factor, all);
  if (mappings_.empty()) return;
  pullBackProduct(p_all, k, all);
  axpy(1, ConstRows{all.data, independent_rows_}, Rows{out.data, independent_rows_});
}

void System::multiply(ConstRows p, Rows out) const {
  const PhaseTimer timer(times.product);
  ++counts.products;
  assert(out.count == independent_rows_);
  const ConstRows p_all = onAllRows(p, mapped_p_, false);
  const Rows all = mappings_.empty() ? out : mapped_f_.rows();
  clear(all);
  for (const Mass* mass : masses_)
    if (const double factor = massFactor(*mass); factor != 0) mass->addProduct(p_all, factor, all);
  for (const ForceField* field : stiff_fields_)
    if (const double factor = stiffnessFactor(*field); factor != 0) field->addStiffnessProduct(p_all, factor, all);
  if (factors_.damping != 0)
    for (const ForceField* field : damped_fields_) field->addDampingProduct(p_all, factors_.damping, all);
  if (!mappings_.empty()) {
    pullBackProduct(p_all, factors_.stiffness, all);
    copy(ConstRows{all.data, independent_rows_}, out);
  }
  project(out);
}

void System::diagonalBlocks(std::vector<double>& blocks) const {
  if (assembled_revision_ == revision_) {
    blocks.resize(std::size_t(independent_rows_) * 9);
    for (std::size_t row = 0; row < std::size_t(independent_rows_); ++row)
      std::copy_n(matrix_.values().data() + std::size_t(matrix_.diagonal()[row]) * 9, 9, blocks.data() + 9 * row);
    return;
  }
  // what acts on mapped states is left out: it reaches other rows than its own
  blocks.assign(std::size_t(all_rows_) * 9, 0.0);
  for (const Mass* mass : masses_)
    if (const double factor = massFactor(*mass); factor != 0) mass->addDiagonal(factor, blocks);
  for (const ForceField* field : stiff_fields_)
    if (const double factor = stiffnessFactor(*field); factor != 0) field->addStiffnessDiagonal(factor, blocks);
  if (factors_.damping != 0)
    for (const ForceField* field : damped_fields_) field->addDampingDiagonal(factors_.damping, blocks);
  blocks.resize(std::size_t(independent_rows_) * 9);
  for (const NodeProjector& held : projectors_) {
    Block block = blockAt(blocks, held.row);
    block = (held.projector * block * held.projector + Mat3::Identity() - held.projector).eval();
  }
  groups_.completeDiagonal(projectors_, blocks);
}

bool System::symmetric() const {
  const auto is_symmetric = [](const ForceField* field) { return field->traits().symmetric; };
  return std::all_of(stiff_fields_.begin(), stiff_fields_.end(), is_symmetric) &&
         std::all_of(damped_fields_.begin(), damped_fields_.end(), is_symmetric);
}

// ---- the assembled matrix ----

void System::preparePattern() const {
  if (pattern_ready_) return;
  BlockPattern pattern(mappings_.empty() ? independent_rows_ : all_rows_);
  for (const Mass* mass : masses_) mass->addPattern(pattern);
  for (const ForceField* field : force_fields_)
    if (const ForceTraits traits = field->traits(); traits.has_stiffness || traits.velocity_dependent)
      field->addPattern(pattern);
  for (const Mapping* mapping : mappings_)
    if (!mapping->isLinear()) mapping->addGeometricPattern(pattern);
  if (mappings_.empty()) {
    matrix_ = BlockMatrix(std::move(pattern));
  } else {
    mapped_matrix_.prepare(std::move(pattern), mappings_, independent_rows_);
    matrix_ = mapped_matrix_.reducedPattern();
  }
  std::vector<Tie> ties;  // those of all times: the pattern never changes
  for (const ProjectiveConstraint* constraint : constraints_) constraint->addTies(ties);
  if (NodeGroups all; all.set(ties, independent_rows_)) matrix_ = all.withFill(matrix_);
  block_count_ = matrix_.blocks();
  const BlockMatrix& target = mappings_.empty() ? matrix_ : mapped_matrix_.full();
  for (Mass* mass : masses_) mass->prepareAssembly(target);
  for (ForceField* field : force_fields_) field->prepareAssembly(target);
  pattern_ready_ = true;
}

const BlockMatrix& System::assemble() {
  preparePattern();
  if (assembled_revision_ == revision_) return matrix_;
  const PhaseTimer timer(times.assembly);
  ++counts.assemblies;
  BlockMatrix& target = mappings_.empty() ? matrix_ : mapped_matrix_.full();
  addConstantParts(target);
  addChangingParts(target);
  if (!mappings_.empty()) {
    if (!mappings_linear_) mapped_matrix_.updateJacobian(mappings_);
    mapped_matrix_.reduce(matrix_);
  }
  eliminateConstraints();
  assembled_revision_ = revision_;
  return matrix_;
}

void System::addChangingParts(BlockMatrix& matrix) {
  for (const ForceField* field : stiff_fields_)
    if (const double factor = stiffnessFactor(*field); factor != 0 && !field->traits().constant_stiffness)
      field->addStiffness(factor, matrix);
  if (factors_.damping != 0)
    for (const ForceField* field : damped_fields_) field->addDamping(factors_.damping, matrix);
  for (const Mapping* mapping : mappings_)
    if (!mapping->isLinear()) mapping->addGeometricStiffness(last_force_, factors_.stiffness, matrix);
}

// Masses and constant stiffnesses are assembled again only when a factor changed. Without a constant stiffness and
// with diagonal masses, adding them anew costs less than keeping their sum.
void System::addConstantParts(BlockMatrix& matrix) {
  const auto addAll = [this, &matrix] {
    matrix.clear();
    for (const Mass* mass : masses_)
      if (const double factor = massFactor(*mass); factor != 0) mass->addTo(factor, matrix);
    for (const ForceField* field : stiff_fields_)
      if (const double factor = stiffnessFactor(*field); factor != 0 && field->traits().constant_stiffness)
        field->addStiffness(factor, matrix);
  };
  const bool worth_keeping =
      stiffness_varies_ &&
      (!massIsDiagonal() || std::any_of(stiff_fields_.begin(), stiff_fields_.end(),
                                        [](const auto* field) { return field->traits().constant_stiffness; }));
  if (!worth_keeping) return addAll();
  if (!constant_part_ready_ || factors_ != constant_factors_) {
    addAll();
    constant_part_ = matrix.values();
    constant_factors_ = factors_;
    constant_part_ready_ = true;
    return;
  }
  std::copy(constant_part_.begin(), constant_part_.end(), matrix.values().begin());
}

// Block (i, j) becomes P_i A_ij P_j, and I - P_i is added on the diagonal.
void System::eliminateConstraints() {
  groups_.average(matrix_);
  eliminateProjectors();
  groups_.complete(projectors_, matrix_);
}

void System::eliminateProjectors() {
  if (projectors_.empty()) return;
  const auto& start = matrix_.rowStart();
  const auto& columns = matrix_.columns();
  for (Index row = 0; row < independent_rows_; ++row) {
    const Index left = projector_of_row_[row];
    for (Index slot = start[row]; slot < start[row + 1]; ++slot) {
      const Index right = projector_of_row_[columns[slot]];
      if (left < 0 && right < 0) continue;
      Block block = blockAt(matrix_.values(), slot);
      if (left >= 0) block = (projectors_[left].projector * block).eval();
      if (right >= 0) block = (block * projectors_[right].projector).eval();
    }
  }
  for (const NodeProjector& held : projectors_)
    matrix_.add(matrix_.diagonal()[held.row], Mat3::Identity() - held.projector);
}

// Matrix-free: products x (sum of the fields' products). Assembled: the assemblies plus the block products. An
// assembly of stiffnesses that never change is shared by all steps and counts as nothing.
bool System::prefersAssembled(int expected_products) const {
  if (!mappings_.empty() || stiff_fields_.empty()) return false;
  double product = 0, assembly = 0;
  for (const ForceField* field : stiff_fields_) {
    const ForceField::Cost cost = field->cost();
    if (cost.product <= 0) return false;  // nothing is known about its costs
    product += cost.product;
    if (!field->traits().constant_stiffness) assembly += cost.assembly;
  }
  if (expected_products * product <= assembly) return false;
  if (block_count_ < 0) {
    preparePattern();
    if (expected_products * product <= assembly + expected_products * block_product_nanoseconds * block_count_) {
      matrix_ = BlockMatrix();  // its memory is not needed after all
      pattern_ready_ = false;
    }
  }
  return expected_products * product > assembly + expected_products * block_product_nanoseconds * block_count_;
}

}  // namespace stroma
