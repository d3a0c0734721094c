// SPDX-License-Identifier: LGPL-2.1-or-later
// Yeoh: W = sum_k c_k (J^-2/3 I1 - 3)^k + k0/2 (ln J)^2, one to six terms: ParameterSet = c1 (c2 ... c6) k0, as in
// FEBio; Yeoh's own law has three. At small strains mu = 2 c1 and the bulk modulus is k0. Infinite at J = 0. Source:
// O. H. Yeoh, "Some forms of the strain energy function for rubber", Rubber Chemistry and Technology 66 (1993) 754-771.
#include "components/hyperelasticity/hyperelastic_kernels.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

constexpr std::size_t most_terms = 6;

struct Yeoh : IsochoricAndBulk<Yeoh, First> {
  template <class T>
  struct Parameters {
    T c[most_terms];
    T k0;
  };
  static Parameters<double> read(Values values) {
    Parameters<double> p{};
    std::copy_n(values.begin(), values.size() - 1, p.c);
    p.k0 = values.back();
    return p;
  }
  static auto isochoric(const auto& I1, const auto& p) {
    const auto x = I1 - 3.;
    return x * (x * (x * (x * (x * (p.c[5] * x + p.c[4]) + p.c[3]) + p.c[2]) + p.c[1]) + p.c[0]);
  }
};

std::string fromShear(double mu, std::vector<double>& values) {
  if (std::isnan(values[0])) values[0] = mu / 2;
  return {};
}

/// More than most_terms give the law with most_terms, which their values do not fit.
HyperelasticLaw withTerms(std::size_t terms) {
  HyperelasticLaw law = lawOf<Yeoh>("Yeoh", "sum c_k (J^-2/3 I1 - 3)^k + k0/2 (ln J)^2, up to k = 6");
  for (std::size_t k = 1; k <= std::min(terms, most_terms); ++k)
    law.parameters.push_back({"c" + std::to_string(k), "Pa", "factor of a power of J^-2/3 I1 - 3", k == 1});
  return withBulkModulus(std::move(law), fromShear);
}

}  // namespace

STROMA_COMPONENT(yeoh) {
  HyperelasticLaw law = withTerms(1);
  law.with_terms = withTerms;
  offerHyperelasticLaw(law);
}
