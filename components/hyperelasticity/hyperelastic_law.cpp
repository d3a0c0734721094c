// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/hyperelasticity/hyperelastic_law.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "components/hyperelasticity/hyperelastic_volume.h"

namespace stroma::hyperelastic {
namespace {
std::vector<HyperelasticLaw>& offeredLaws() {
  static std::vector<HyperelasticLaw> laws;
  return laws;
}
}  // namespace

std::string HyperelasticLaw::expectation() const {
  std::vector<std::string> words;
  words.reserve(parameters.size());
  for (const ParameterInfo& p : parameters)
    words.push_back(p.unit == "-" ? p.name : fmt::format("{} [{}]", p.name, p.unit));
  if (!with_terms) return fmt::format("{} values: {}", parameters.size(), fmt::join(words, ", "));
  return fmt::format("{}, {}, {} values and so on: {} of each term, then {}", parameters.size(),
                     with_terms(2).parameters.size(), with_terms(3).parameters.size(),
                     fmt::join(words.begin(), words.end() - 1, ", "), words.back());
}

std::vector<ParameterInfo> HyperelasticLaw::namedParameters() const {
  return with_terms ? with_terms(named_terms).parameters : parameters;
}
bool HyperelasticLaw::takes(const std::string& parameter) const {
  const std::vector<ParameterInfo> named = namedParameters();
  return std::any_of(named.begin(), named.end(), [&](const ParameterInfo& p) { return p.name == parameter; });
}

// dP of the shear e2 (x) e3 + e3 (x) e2 is 2 mu times it, of the dilation Id 3 K times it; neither stretches the fibre
// e1 at constant volume.
HyperelasticLaw::Moduli HyperelasticLaw::moduliAtRest(Values values) const {
  const Mat3 unit = Mat3::Identity();
  Mat3 shear = Mat3::Zero();
  shear(1, 2) = shear(2, 1) = 1;
  return {differential(values, unit, shear)(1, 2) / 2, differential(values, unit, unit).trace() / 9};
}

MeanVolumeKernels& meanVolumeKernels() {
  static MeanVolumeKernels kernels;
  return kernels;
}

const std::vector<HyperelasticLaw>& hyperelasticLaws() { return offeredLaws(); }

void offerHyperelasticLaw(HyperelasticLaw law) {
  auto& laws = offeredLaws();
  const bool is_known = std::any_of(laws.begin(), laws.end(), [&](const HyperelasticLaw& other) {
    return other.name == law.name && other.parameters.size() == law.parameters.size();
  });
  if (!is_known) laws.push_back(std::move(law));
}

std::string lameParameters(const Lame& lame, std::vector<double>& values) {
  if (std::isnan(values[0])) values[0] = lame.mu;
  if (std::isnan(values[1])) values[1] = lame.lambda;
  return {};
}
std::string checkLame(Values values) {
  if (values[1] + 2. / 3 * values[0] > 0) return {};
  return fmt::format("mu = {} and lambda = {} have no bulk modulus lambda + 2/3 mu above 0", values[0], values[1]);
}

}  // namespace stroma::hyperelastic
