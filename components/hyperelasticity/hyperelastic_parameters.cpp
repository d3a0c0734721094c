// SPDX-License-Identifier: LGPL-2.1-or-later
// The law of a hyperelastic force field and its parameters, from the attributes of a scene.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "components/hyperelasticity/hyperelastic_force_field.h"
#include "framework/scene/names.h"

namespace stroma {

using hyperelastic::HyperelasticLaw;
using hyperelastic::hyperelasticLaws;

namespace {

constexpr double not_given = std::numeric_limits<double>::quiet_NaN();

struct Doubt {
  std::string sentence, expected;
};

/// Parameters that a law takes and a tissue hardly has: most come from another order, or from another book.
std::vector<Doubt> doubtsAbout(const HyperelasticLaw& law, const std::vector<double>& values) {
  std::vector<Doubt> doubts;
  const auto [shear, bulk] = law.moduliAtRest(values);
  const double poisson = (3 * bulk - 2 * shear) / (2 * (3 * bulk + shear));
  if (poisson < -1e-9)
    doubts.push_back({fmt::format("these parameters of {} give a shear modulus of {:.3g} Pa and a bulk modulus of {:.3g} Pa, a "
                                  "Poisson's ratio of {:.2g}",
                                  law.name, shear, bulk, poisson),
                      law.expectation() + ", in this order"});
  for (std::size_t i = 0; i + 1 < values.size(); i += 2)  // the pairs of Ogden's laws
    if (law.parameters[i].name.starts_with("mu") && law.parameters[i + 1].name.starts_with("alpha") && values[i] < 0)
      doubts.push_back({fmt::format("{} = {:g} of {} is negative: its term pulls away from the rest shape, and the body may be "
                                    "unstable. The energy here has {}/{}^2; of a law with {}/{} the product of both is meant",
                                    law.parameters[i].name, values[i], law.name, law.parameters[i].name,
                                    law.parameters[i + 1].name, law.parameters[i].name, law.parameters[i + 1].name),
                        "mu_k above 0, whatever the sign of alpha_k"});
  return doubts;
}

/// The law decides between units: numbers may have been written in one that is not its own.
void settleUnits(const HyperelasticLaw& law, DataTable& data) {
  for (const hyperelastic::ParameterInfo& parameter : law.parameters) {
    Data* const attribute = data.find(parameter.name);
    if (attribute && !attribute->settleUnit(parameter.unit))
      throw ComponentError(fmt::format("{} of {} is {}", parameter.name, law.name,
                                       parameter.unit == "-" ? "a pure number" : "in " + parameter.unit),
                           parameter.unit == "-" ? "numbers without unit" : "numbers in Pa");
  }
}

double at(const std::vector<double>& values, std::size_t cell) { return values.size() == 1 ? values[0] : values[cell]; }

}  // namespace

std::vector<std::string> HyperelasticForceField::givenNames() const {
  std::vector<std::string> given;
  for (const auto& [name, values] : named_)
    if (!values.empty()) given.push_back(name);
  return given;
}

/// How often the parameters of a term are given: by position, or by the highest number in a name; at least 1. A
/// ParameterSet that no number of terms fits gives a law that it does not fit.
HyperelasticLaw HyperelasticForceField::withTerms(const HyperelasticLaw& law) const {
  std::size_t terms = 1;
  if (!parameter_set_.empty()) {
    const std::size_t one = law.parameters.size(), each = law.with_terms(2).parameters.size() - one;
    if (parameter_set_.size() > one) terms += (parameter_set_.size() - one) / each;
  } else {
    const std::vector<std::string> given = givenNames();
    const auto all = [&](const HyperelasticLaw& candidate) {
      return std::all_of(given.begin(), given.end(), [&](const auto& name) { return candidate.takes(name); });
    };
    while (terms < HyperelasticLaw::named_terms && !all(law.with_terms(terms))) ++terms;
  }
  return law.with_terms(terms);
}

// The law with this name that the given parameters fit: more terms, more parameters.
void HyperelasticForceField::chooseLaw() {
  std::vector<const HyperelasticLaw*> candidates;
  std::vector<std::string> names;
  for (const HyperelasticLaw& law : hyperelasticLaws()) {
    names.push_back(law.name);
    if (law.name == material_name_) candidates.push_back(&law);
  }
  if (candidates.empty())
    throw ComponentError(fmt::format("there is no law '{}'", material_name_),
                         fmt::format("{}", fmt::join(std::set<std::string>(names.begin(), names.end()), ", ")),
                         nearest(material_name_, names));
  std::vector<std::string> expected;
  expected.reserve(candidates.size());
  for (const HyperelasticLaw* law : candidates) expected.push_back(law->expectation());
  const std::vector<std::string> given = givenNames();
  if (!parameter_set_.empty() && (!given.empty() || !young_modulus_.empty() || !poisson_ratio_.empty()))
    throw ComponentError("parameters are given by position and by name", "ParameterSet or names");
  for (const HyperelasticLaw* candidate : candidates) {
    const HyperelasticLaw law = candidate->with_terms ? withTerms(*candidate) : *candidate;
    const auto takes = [&](const std::string& name) { return law.takes(name); };
    const bool fits = parameter_set_.empty() ? std::all_of(given.begin(), given.end(), takes)
                                             : parameter_set_.size() == law.parameters.size();
    if (fits) {
      law_ = law;
      return;
    }
  }
  if (!parameter_set_.empty())
    throw ComponentError(fmt::format("ParameterSet of {} has {} values", material_name_, parameter_set_.size()),
                         fmt::format("{}", fmt::join(expected, ", or ")));
  throw ComponentError(fmt::format("{} does not take {}", material_name_, fmt::join(given, ", ")),
                       fmt::format("{}", fmt::join(expected, ", or ")));
}

/// Set `set` of parameters from names and from E and nu.
void HyperelasticForceField::fillNamed(std::size_t set, std::vector<double>& values) const {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto& given = named_.at(law_.parameters[i].name);
    values[i] = given.empty() ? not_given : at(given, set);
  }
  const bool complete = std::none_of(values.begin(), values.end(), [](double v) { return std::isnan(v); });
  if (young_modulus_.empty() != poisson_ratio_.empty())
    throw ComponentError("youngModulus and poissonRatio make sense together", "both");
  if (!young_modulus_.empty()) {
    if (!law_.from_lame)
      throw ComponentError(fmt::format("{} cannot be given by youngModulus and poissonRatio", law_.name),
                           law_.expectation());
    if (complete)
      throw ComponentError(fmt::format("{} has all its parameters in addition to youngModulus", law_.name),
                           "one or the other");
    const Lame lame = Lame::from(at(young_modulus_, set), at(poisson_ratio_, set));
    const std::string missing = law_.from_lame(lame, values);
    if (!missing.empty()) throw ComponentError(missing, law_.expectation());
    checkModuli(lame, values);
  }
  std::vector<std::string> absent;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::isnan(values[i])) absent.push_back(law_.parameters[i].name);
  if (!absent.empty())
    throw ComponentError(fmt::format("{} needs {}", law_.name, fmt::join(absent, ", ")),
                         law_.expectation() + (law_.from_lame ? ", or youngModulus and poissonRatio" : ""));
}

/// Refuses parameters that contradict E and nu, beyond the figures that people write.
void HyperelasticForceField::checkModuli(const Lame& lame, hyperelastic::Values values) const {
  const auto [shear, bulk] = law_.moduliAtRest(values);
  const auto agree = [](double a, double b) { return std::abs(a - b) <= 1e-3 * std::abs(b); };
  if (agree(shear, lame.mu) && agree(bulk, lame.bulk())) return;
  throw ComponentError(
      fmt::format("youngModulus and poissonRatio mean a shear modulus of {:.6g} Pa and a bulk modulus of {:.6g} Pa; "
                  "with {} of {} they are {:.6g} and {:.6g}",
                  lame.mu, lame.bulk(), fmt::join(givenNames(), ", "), law_.name, shear, bulk),
      "consistent parameters, or youngModulus and poissonRatio instead of them");
}

void HyperelasticForceField::readParameters() {
  const std::size_t count = law_.parameters.size();
  settleUnits(law_, data());
  std::size_t sets = 1;
  const auto check = [&](const std::string& name, const std::vector<double>& values) {
    if (values.size() <= 1) return;
    if (values.size() != cellCount())
      throw ComponentError(fmt::format("{} has {} values", name, values.size()),
                           fmt::format("1, or {} (one per cell)", cellCount()));
    sets = cellCount();
  };
  check("youngModulus", young_modulus_), check("poissonRatio", poisson_ratio_);
  for (const auto& [name, values] : named_) check(name, values);
  values_.clear();
  for (std::size_t set = 0; set < sets; ++set) {
    std::vector<double> values = parameter_set_;
    if (values.empty()) values.resize(count), fillNamed(set, values);
    for (std::size_t i = 0; i < count; ++i)
      if (law_.parameters[i].positive && !(values[i] > 0))
        throw ComponentError(fmt::format("{} of {} is {}", law_.parameters[i].name, law_.name, values[i]),
                             "a value above 0");
    const std::string problem = law_.check ? law_.check(values) : "";
    if (!problem.empty()) throw ComponentError(problem, law_.expectation());
    const double shear = std::abs(law_.moduliAtRest(values).shear);
    constexpr double smallest = 1e-100, largest = 1e100;  // squares of forces must be numbers too
    if (shear != 0 && !(shear >= smallest && shear <= largest))
      throw ComponentError(fmt::format("{} has a shear modulus of {:.3g} Pa at small strains", law_.name, shear),
                           fmt::format("one of {:g} to {:g} Pa", smallest, largest));
    if (set == 0)
      for (const Doubt& doubt : doubtsAbout(law_, values)) warn(doubt.sentence, doubt.expected);
    values_.insert(values_.end(), values.begin(), values.end());
  }
}

}  // namespace stroma
