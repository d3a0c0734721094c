// SPDX-License-Identifier: LGPL-2.1-or-later
// What an elastic field says of its cells: the worst, those beyond its law, and the fields of cells.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "components/elasticity/elastic_force_field.h"

namespace stroma {

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
      "{} of {} elements are strained beyond {:.0f} %, where a law that is linear in the strain says little; the worst "
      "is {}: {:.0f} %. A hyperelastic force field is made for such strains",
      beyond, count, 100 * limit, elements_->describe(at), 100 * worst);
}

void ElasticForceField::cellField(const std::string& name, ConstRows x, std::vector<double>& out) const {
  const std::size_t count = std::size_t(elements_->count(*mesh_));
  const ConstRows own = ownRows(x);
  out.resize(name == "strain" ? 6 * count : count);
  for (std::size_t cell = 0; cell < count; ++cell) {
    if (name == "J") {
      out[cell] = elements_->jacobian(cell, own);
      continue;
    }
    const Mat3 strain = elements_->strain(cell, own);
    if (name == "strain") {
      const double v[6] = {strain(0, 0), strain(1, 1), strain(2, 2), strain(0, 1), strain(1, 2), strain(2, 0)};
      std::copy(v, v + 6, out.begin() + std::ptrdiff_t(6 * cell));
    } else {
      const Mat3 deviator = 2 * lame(cell).mu * (strain - strain.trace() / 3 * Mat3::Identity());
      out[cell] = std::sqrt(1.5) * deviator.norm();
    }
  }
}

}  // namespace stroma
