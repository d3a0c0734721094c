// SPDX-License-Identifier: LGPL-2.1-or-later
// What an elastic field says of its cells: the worst, those beyond its law, and the fields of cells.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "components/elasticity/elastic_force_field.h"
#include "components/elasticity/incompatible_modes.h"

namespace stroma {

// ---- what cells can have ----

std::unique_ptr<ElasticElements> ElasticForceField::newElements() const {
  std::unique_ptr<ElasticElements> elements = make_elements_();
  if (auto* const hexahedra = dynamic_cast<HasIncompatibleModes*>(elements.get()); hexahedra && incompatible_)
    hexahedra->useIncompatibleModes(LameOf(constants_));
  return elements;
}

void ElasticForceField::checkIncompatibleModes() const {
  const auto refuse = [](const std::string& problem, const std::string& instead) {
    throw ComponentError(problem, instead + ", or incompatibleModes=\"false\"");
  };
  if (!dynamic_cast<const HasIncompatibleModes*>(elements_.get()))
    refuse(fmt::format("a {} has no incompatible modes", kind_word_), "hexahedra");
  if (variant_.method == ElasticMethod::green)
    refuse("method green has no incompatible modes: they are condensed out of linear cells", "method small, large, polar or svd");
  if (update_b_)
    refuse("incompatible modes are condensed out of cells at rest: B cannot be updated", "updateStiffnessMatrix=\"false\"");
  if (polar_of_ != PolarOf::gradient)
    refuse("incompatible modes turn with the gradient of a cell", "polarOf=\"gradient\"");
}

ConstRows ElasticForceField::ownRows(ConstRows x) const {
  return {x.data + std::size_t(state().firstRow()) * row_doubles, state().size()};
}

std::string ElasticForceField::worstElement(ConstRows x) const {
  double worst = std::numeric_limits<double>::infinity();
  std::size_t at = 0;
  const std::size_t count = std::size_t(elements_->count(*mesh_));
  for (std::size_t cell = 0; cell < count; ++cell) {
    const double j = elements_->jacobian(cell, ownRows(x));
    if (!(j >= worst)) worst = j, at = cell;  // a NaN is the worst
    if (worst != worst) break;
  }
  return fmt::format("{}: J = {:.3g}", elements_->describe(at), worst);
}

/// The limit is generous: at 0.5 a linear law is off by a half for most tissues.
std::string ElasticForceField::doubt(ConstRows x) const {
  constexpr double limit = 0.5;
  const std::size_t count = std::size_t(elements_->count(*mesh_));
  std::size_t beyond = 0, at = 0;
  double worst = 0;
  for (std::size_t cell = 0; cell < count; ++cell) {
    const double strain = elements_->strainBeyond(limit, cell, ownRows(x));
    beyond += strain > 0;
    if (strain > worst) worst = strain, at = cell;
  }
  if (beyond == 0) return {};
  return fmt::format(
      "{} of {} elements are strained beyond {:.0f} %, outside the range of a law that is linear in the strain; the worst is {}: "
      "{:.0f} %. Use a hyperelastic force field for such strains",
      beyond, count, 100 * limit, elements_->describe(at), 100 * worst);
}

// ---- fields ----

std::vector<std::string> ElasticForceField::cellFields() const {
  return {"vonMises", "J", "strain", "stress", "principalStress", "principalStrain"};
}

ForceField::CellFieldShape ElasticForceField::cellFieldShape(const std::string& name) const {
  const bool tensor = name == "strain" || name == "stress", principal = name.starts_with("principal");
  return {&elements_->kind(), std::size_t(tensor ? 6 : principal ? 3 : 1)};
}

std::vector<double> ElasticForceField::meanChanges(ConstRows x) const {
  if (!variant_.mean_dilatation) return {};
  const std::size_t count = std::size_t(elements_->count(*mesh_));
  std::vector<double> changes(count), volumes(count);
  for (std::size_t cell = 0; cell < count; ++cell) {
    const auto add = [change = &changes[cell], all = &volumes[cell]](const Mat3& strain, const Mat3&, double volume) {
      *change += volume * strain.trace();
      *all += volume;
    };
    elements_->forEachPoint(cell, x, std::ref(add));
  }
  if (elements_->kind().type != CellType::tetrahedron) {  // the mean over the cell
    for (std::size_t cell = 0; cell < count; ++cell) changes[cell] /= volumes[cell];
    return changes;
  }
  // theta_a of nodal_dilatation.h: of each node, for each bulk modulus around it
  std::map<std::pair<Index, double>, std::pair<double, double>> nodes;
  const auto sums = [&](std::size_t cell, Index node) -> auto& { return nodes[{node, lame(cell).bulk()}]; };
  for (std::size_t cell = 0; cell < count; ++cell)
    for (const Index node : mesh_->tetrahedra[cell]) {
      sums(cell, node).first += changes[cell];
      sums(cell, node).second += volumes[cell];
    }
  for (std::size_t cell = 0; cell < count; ++cell) {
    changes[cell] = 0;
    for (const Index node : mesh_->tetrahedra[cell])
      changes[cell] += sums(cell, node).first / sums(cell, node).second / 4;
  }
  return changes;
}

Mat3 ElasticForceField::stress(std::size_t cell, ConstRows x, double change) const {
  const Lame law = lame(cell);
  Mat3 sum = Mat3::Zero();
  double whole = 0;
  const auto add = [&](const Mat3& strain, const Mat3& carrier, double volume) {
    Mat3 own = 2 * law.mu * strain;
    const double trace = strain.trace();
    own.diagonal().array() += std::isnan(change) ? law.lambda * trace : law.bulk() * change - 2. / 3 * law.mu * trace;
    const double j = carrier.determinant();  // a flat cell has no area for its force: that of a cell of a millionth
    sum += volume / (std::abs(j) < 1e-6 ? 1e-6 : j) * carrier * own * carrier.transpose();
    whole += volume;
  };
  elements_->forEachPoint(cell, x, std::ref(add));
  return sum / whole;
}

void ElasticForceField::cellField(const std::string& name, ConstRows x, std::vector<double>& out) const {
  const std::size_t count = std::size_t(elements_->count(*mesh_)), width = cellFieldShape(name).width;
  const ConstRows own = ownRows(x);
  const bool of_strain = name == "strain" || name == "principalStrain";
  // a pressure that is carried by a rotation has no part in von Mises' stress
  const bool of_shear = name == "vonMises" && variant_.method != ElasticMethod::green;
  std::vector<double> changes = of_strain || of_shear || name == "J" ? std::vector<double>() : meanChanges(own);
  if (changes.empty()) changes.assign(count, std::numeric_limits<double>::quiet_NaN());
  out.resize(width * count);
  for (std::size_t cell = 0; cell < count; ++cell) {
    double* to = out.data() + width * cell;
    if (name == "J") {
      *to = elements_->jacobian(cell, own);
      continue;
    }
    const Mat3 tensor = of_strain ? elements_->strain(cell, own) : stress(cell, own, changes[cell]);
    if (width == 6) {
      const double v[6] = {tensor(0, 0), tensor(1, 1), tensor(2, 2), tensor(0, 1), tensor(1, 2), tensor(2, 0)};
      std::copy(v, v + 6, to);
    } else if (width == 3) {
      const Vec3 values = tensor.selfadjointView<Eigen::Lower>().eigenvalues();
      std::reverse_copy(values.data(), values.data() + 3, to);
    } else {
      *to = std::sqrt(1.5) * (tensor - tensor.trace() / 3 * Mat3::Identity()).norm();
    }
  }
}

}  // namespace stroma
