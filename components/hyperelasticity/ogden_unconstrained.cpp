// SPDX-License-Identifier: LGPL-2.1-or-later
// Ogden's law in the principal stretches themselves, without an isochoric part, for bodies that change their volume:
//   W = sum_k c_k/m_k^2 (lambda_1^m_k + lambda_2^m_k + lambda_3^m_k - 3 - m_k ln J) + cp/2 (J - 1)^2
// any number of terms: ParameterSet = c1 m1 (c2 m2 ...) cp. At small strains Lame's constants are mu = sum of c_k/2 and
// lambda = cp. Infinite at J = 0. The names are those of FEBio's "Ogden unconstrained".
#include <fmt/format.h>

#include "components/hyperelasticity/ogden_terms.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

struct OgdenUnconstrained : OgdenSum<false> {
  template <class T>
  struct Parameters {
    T list, count, cp;
  };
  static Parameters<double> read(Values values) { return {listOf(values), countOf(values), values.back()}; }
  static auto volumetric(const auto& J, const auto& p) {
    const auto change = J - 1.;
    return 0.5 * p.cp * (change * change);
  }
};

HyperelasticLaw withTerms(std::size_t terms) {
  HyperelasticLaw law =
      withOgdenTerms(lawOf<OgdenUnconstrained>("OgdenUnconstrained",
                                               "sum c_k/m_k^2 (sum_i lambda_i^m_k - 3 - m_k ln J) + cp/2 (J - 1)^2"),
                     terms, "c", "m");
  const std::size_t cp = law.parameters.size();
  law.parameters.push_back({"cp", "Pa", "Lame's first constant, of small strains"});
  law.volume = VolumePart::half_square, law.volume_parameter = cp;
  law.infinite_at_zero = true;
  law.check = [of_terms = law.check](Values p) -> std::string {
    if (const std::string problem = of_terms(p); !problem.empty()) return problem;
    double mu = 0;
    for (std::size_t k = 0; k + 1 < p.size(); k += 2) mu += p[k] / 2;
    if (p.back() + 2. / 3 * mu > 0) return {};
    return fmt::format("cp = {} of OgdenUnconstrained leaves no bulk modulus cp + 2/3 mu above 0, mu = {}", p.back(),
                       mu);
  };
  if (terms > 1) return law;
  law.from_lame = [](const Lame& lame, std::vector<double>& values) -> std::string {
    if (std::isnan(values[1])) return "OgdenUnconstrained needs m1 besides youngModulus";
    if (std::isnan(values[0])) values[0] = 2 * lame.mu;
    if (std::isnan(values[2])) values[2] = lame.lambda;
    return {};
  };
  return law;
}

}  // namespace

STROMA_COMPONENT(ogden_unconstrained) {
  HyperelasticLaw law = withTerms(1);
  law.with_terms = withTerms;
  offerHyperelasticLaw(law);
}
