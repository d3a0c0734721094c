// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/hyperelasticity/hyperelastic_law.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "components/hyperelasticity/hyperelastic_volume.h"
#include "components/hyperelasticity/point_kernels.h"

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

PointKernels& pointKernels() {
  static PointKernels kernels;
  return kernels;
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

HyperelasticLaw inLameConstants(HyperelasticLaw law) {
  law.parameters.insert(law.parameters.begin(),
                        {{"mu", "Pa", "shear modulus", true}, {"lambda", "Pa", "Lame's first constant"}});
  law.from_lame = [](const Lame& lame, std::vector<double>& values) -> std::string {
    if (std::isnan(values[0])) values[0] = lame.mu;
    if (std::isnan(values[1])) values[1] = lame.lambda;
    return {};
  };
  law.check = [](Values values) -> std::string {
    if (values[1] + 2. / 3 * values[0] > 0) return {};
    return fmt::format("mu = {} and lambda = {} have no bulk modulus lambda + 2/3 mu above 0", values[0], values[1]);
  };
  return law;
}
HyperelasticLaw withBulkModulus(HyperelasticLaw law,
                                std::function<std::string(double mu, std::vector<double>&)> from_shear) {
  const std::size_t k0 = law.parameters.size();
  law.volume = VolumePart::half_log_squared, law.volume_parameter = k0;
  law.parameters.push_back({"k0", "Pa", "bulk modulus", true});
  law.infinite_at_zero = true;
  if (!from_shear) return law;
  law.from_lame = [from_shear = std::move(from_shear), k0](const Lame& lame, std::vector<double>& values) {
    const std::string missing = from_shear(lame.mu, values);
    if (missing.empty() && std::isnan(values[k0])) values[k0] = lame.bulk();
    return missing;
  };
  return law;
}

}  // namespace stroma::hyperelastic
