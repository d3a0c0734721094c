// SPDX-License-Identifier: LGPL-2.1-or-later
// The matrix of a linear solve: its products, its assembled form and the choice between the two.
#include "framework/simulation/mechanical_matrix.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "framework/algebra/parallel.h"
#include "framework/scene/archive.h"
#include "framework/scene/spans.h"
#include "framework/simulation/held_size.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/system.h"

namespace stroma {

namespace {

/// out = 0, by all threads where that is long.
void clearShared(Rows out) {
  constexpr Index piece = 16384;
  parallelFor(int((out.count + piece - 1) / piece), [&](int k) { clear(out.segment(k * piece, std::min(piece, out.count - k * piece))); });
}

/// What acts on mapped states is left out: it reaches other rows than its own.
void sumDiagonals(const Actors& actors, const MatrixFactors& factors, std::vector<double>& blocks) {
  blocks.assign(std::size_t(actors.all_rows) * 9, 0.0);
  for (const Mass* mass : actors.masses)
    if (const double factor = factors.of(*mass); factor != 0) mass->addDiagonal(factor, blocks);
  for (const ForceField* field : actors.stiff_fields)
    if (const double factor = factors.of(*field); factor != 0) field->addStiffnessDiagonal(factor, blocks);
  if (factors.damping != 0)
    for (const ForceField* field : actors.damped_fields) field->addDampingDiagonal(factors.damping, blocks);
}

/// See held_size.h; beside what the rows of relations have on the diagonal without constraints: the same number whether
/// something has been assembled or not.
double heldBeside(const Actors& actors, const MatrixFactors& factors, const LinearRelations& relations, std::vector<double>& blocks) {
  sumDiagonals(actors, factors, blocks);
  double sum = 0;
  for (const LinearRelations::Term& term : relations.terms) sum += diagonalSize(blockAt(blocks, term.row));
  return heldSize(sum / double(relations.terms.size()));
}

/// Whether J^T K J is about as sparse as K: each node follows a few others. A mapping that is not linear and adds no geometric stiffness
/// to a matrix is not asked for its Jacobian, which it may have to make product by product.
bool areLocal(const Actors& actors) {
  constexpr int most_blocks = 64;
  std::vector<JacobianBlock> jacobian;
  for (const Mapping* mapping : actors.mappings) {
    if (!mapping->isLinear()) {
      BlockPattern pattern(actors.all_rows);
      mapping->addGeometricPattern(pattern);
      bool is_empty = true;
      for (Index row = 0; row < pattern.rows() && is_empty; ++row) is_empty = pattern.columns(row).empty();
      if (is_empty) return false;
    }
    jacobian.clear();
    mapping->addJacobian(jacobian);
    std::vector<int> blocks(std::size_t(actors.all_rows), 0);
    for (const JacobianBlock& block : jacobian)
      if (++blocks[std::size_t(block.child)] > most_blocks) return false;
  }
  return true;
}

}  // namespace

MechanicalMatrix::MechanicalMatrix(const System& system)
    : system_(system),
      actors_(system.actors()),
      mappings_(system.mappingChain()),
      constraints_(system.constraints()),
      assembled_(actors_, mappings_, constraints_) {}

MechanicalMatrix& MechanicalMatrix::withFactors(const MatrixFactors& factors) {
  if (factors != factors_) ++factors_revision_;
  factors_ = factors;
  return *this;
}

void MechanicalMatrix::valuesChanged() {
  assembled_.forgetConstantPart();
  ++factors_revision_;
}

void MechanicalMatrix::termsChanged() {
  assembled_.termsChanged();
  ++factors_revision_;
}

void MechanicalMatrix::serialize(Archive& archive) {
  // those of a step without a result: the next step sets its own whatever they were
  const double sum = factors_.mass + factors_.stiffness + factors_.damping + factors_.rayleigh_mass;
  if (!std::isfinite(sum + factors_.rayleigh_stiffness + factors_.part_of_damping)) factors_ = {};
  archive.value("mass", factors_.mass);
  archive.value("stiffness", factors_.stiffness);
  archive.value("damping", factors_.damping);
  archive.value("rayleigh_mass", factors_.rayleigh_mass);
  archive.value("rayleigh_stiffness", factors_.rayleigh_stiffness);
  archive.value("part_of_damping", factors_.part_of_damping);
}

Index MechanicalMatrix::rows() const { return actors_.independent_rows; }
ConstRows MechanicalMatrix::positions() const { return system_.independent(system_.x); }
bool MechanicalMatrix::hasTurns() const {
  bool turns = false;  // frames that others carry have no rows here
  for (Index row = 0; system_.motion().turns() && !turns && row < rows(); ++row) turns = system_.motion().kindOf(row) == RowKind::turn;
  return turns;
}
bool MechanicalMatrix::isOfLooseNodes() const {
  bool loose = constraints_.groups().empty() && constraints_.relations().empty();
  for (Index row = 0; loose && row < rows(); ++row) loose = system_.motion().kindOf(row) == RowKind::place;
  return loose;
}
std::string MechanicalMatrix::describeRow(Index row) const { return actors_.describeRow(row); }

// Each part only grows, so that no two states of the matrix have one sum.
long MechanicalMatrix::valuesRevision() const {
  return factors_revision_ + constraints_.revision() + system_.derivativesRevision() + actors_.patternRevision();
}

bool MechanicalMatrix::symmetric() const {
  const auto is_symmetric = [](const ForceField* field) { return field->traits().symmetric; };
  return std::ranges::all_of(actors_.stiff_fields, is_symmetric) && std::ranges::all_of(actors_.damped_fields, is_symmetric);
}

/// P p = p to round-off. Where nothing that is held changes it always is.
static bool isFree(const ConstraintSet& constraints, ConstRows p) {
  constexpr double round_off = 1e-12;
  if (!constraints.change() && constraints.revision() <= 1) return true;
  const auto differ = [](const Vec3& a, const Vec3& b) {
    return (a - b).lpNorm<Eigen::Infinity>() > round_off * a.lpNorm<Eigen::Infinity>();
  };
  for (const NodeProjector& held : constraints.projectors())
    if (const Vec3 whole = p[held.row]; differ(whole, held.projector * whole)) return false;
  const NodeGroups& groups = constraints.groups();
  for (Index group = 0; group < groups.count(); ++group)
    for (const Index* row = groups.begin(group) + 1; row < groups.end(group); ++row)
      if (differ(p[*groups.begin(group)], p[*row])) return false;
  return true;
}

// Preconditioners by blocks of the diagonal keep to held nodes and groups but not to relations: with them the product
// is P A P p + s (I - P) p, with the size s of the numbers in A. Solutions and hierarchies that a solver has kept from before
// something was held do not keep to that: then the product is P A P p, and the part (I - P) p means nothing.
void MechanicalMatrix::multiply(ConstRows p, Rows out) const {
  const bool has_relations = !constraints_.relations().empty();
  if (!has_relations && isFree(constraints_, p)) return multiplyFree(p, out);
  if (free_part_.count() != rows() + 1) free_part_.resize(rows() + 1);
  const Rows free = free_part_.head(rows());
  copy(p, free);
  constraints_.project(free);
  if (!has_relations) return multiplyFree(free, out);
  const auto size = free_part_[rows()];  // the last row keeps s, and for which values it holds
  if (const double values = double(valuesRevision() + 1); size[1] != values)
    free_part_[rows()] = Vec3(heldBeside(actors_, factors_, constraints_.relations().relations(), diagonals_), values, 0);
  multiplyFree(free, out);
  axpy(size[0], p, out);
  axpy(-size[0], free, out);
}

void MechanicalMatrix::multiplyFree(ConstRows p, Rows out) const {
  const PhaseTimer timer(system_.times.product);
  ++system_.counts.products;
  assert(out.count == rows());
  const ConstRows p_all = mappings_.beginProduct(p);
  const bool maps = p_all.data != p.data;
  const Mass* const first = actors_.masses.empty() || maps ? nullptr : actors_.masses.front();
  const bool is_set = first && factors_.of(*first) != 0 && first->setsProducts(out.count);
  if (is_set)
    heard("product", first)->setProduct(p_all, factors_.of(*first), out);
  else
    clearShared(out);
  const Rows all = maps ? mappings_.beginSum(out) : out;
  for (const Mass* mass : actors_.masses)
    if (const double factor = factors_.of(*mass); factor != 0 && !(is_set && mass == first))
      heard("product", mass)->addProduct(p_all, factor, all);
  for (const ForceField* field : actors_.stiff_fields)
    if (const double factor = factors_.of(*field); factor != 0) heard("product", field)->addStiffnessProduct(p_all, factor, all);
  if (factors_.damping != 0)
    for (const ForceField* field : actors_.damped_fields) heard("product", field)->addDampingProduct(p_all, factors_.damping, all);
  if (maps) mappings_.finishProduct(p_all, factors_.stiffness, all, out);
  constraints_.project(out);
}

void MechanicalMatrix::diagonalBlocks(std::vector<double>& blocks) const {
  const std::size_t count = std::size_t(rows());
  if (assembled_revision_ == valuesRevision()) {
    const BlockMatrix& matrix = assembled_.matrix();
    blocks.resize(count * 9);
    for (std::size_t row = 0; row < count; ++row)
      std::copy_n(matrix.values().data() + std::size_t(matrix.diagonal()[row]) * 9, 9, blocks.data() + 9 * row);
    return;
  }
  sumDiagonals(actors_, factors_, blocks);
  blocks.resize(count * 9);
  for (const NodeProjector& held : constraints_.projectors()) {
    auto block = blockAt(blocks, held.row);
    const double size = heldSize(diagonalSize(block));
    block = (held.projector * block * held.projector + size * (Mat3::Identity() - held.projector)).eval();
  }
  constraints_.groups().completeDiagonal(constraints_.projectors(), blocks);
  constraints_.relations().eliminateDiagonal(blocks);
}

const BlockMatrix& MechanicalMatrix::assemble() {
  assembled_.pattern();
  if (assembled_revision_ == valuesRevision()) return assembled_.matrix();
  const PhaseTimer timer(system_.times.assembly);
  const Span span("assemble", &system_.integrator());
  ++system_.counts.assemblies;
  assembled_revision_ = valuesRevision();
  return assembled_.assemble(factors_);
}

double MechanicalMatrix::productCost() const {
  double sum = 0;
  for (const ForceField* field : actors_.stiff_fields) {
    const double product = field->cost().product;
    if (product <= 0) return 0;
    sum += product;
  }
  return sum;
}

/// That of stiffnesses that never change is shared by all steps and counts as nothing.
double MechanicalMatrix::assemblyCost() const {
  double sum = 0;
  for (const ForceField* field : actors_.stiff_fields) sum += field->traits().constant_stiffness ? 0 : field->cost().assembly;
  return productCost() > 0 ? sum : -1;
}

// Matrix-free: products x (sum of the fields' products). Assembled: the assemblies plus the block products. With mappings an assembly
// also makes J^T K J, and products cost somewhat more than is said here. A new pattern is only made if fewer blocks would pay.
bool MechanicalMatrix::prefersAssembled(int expected_products) const {
  const double product = productCost(), assembly = assemblyCost();
  if (assembly < 0 || expected_products * product <= assembly) return false;
  const bool is_halved = symmetric();
  const auto pays = [&](Index blocks, double more) {
    return BlockMatrix::pays(expected_products, product, assembly + more, double(blocks), is_halved);
  };
  const bool is_new = assembled_.blocks() < 0;
  if (is_new && (!areLocal(actors_) || !pays(assembled_.fewestBlocks(), 0))) return false;
  if (is_new) assembled_.pattern();
  const bool is_cheaper = pays(assembled_.blocks(), assembled_.reductionCost());
  if (is_new && !is_cheaper) assembled_.dropPattern();  // its memory is not needed after all
  return is_cheaper;
}

}  // namespace stroma
