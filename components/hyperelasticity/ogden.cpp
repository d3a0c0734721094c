// SPDX-License-Identifier: LGPL-2.1-or-later
// Ogden: W = sum_k mu_k/alpha_k^2 (l1^alpha_k + l2^alpha_k + l3^alpha_k - 3) + k0/2 (ln J)^2, l_i = J^-1/3 lambda_i the
// isochoric principal stretches, any number of terms: ParameterSet = mu1 alpha1 (mu2 alpha2 ...) k0. At small strains
// the shear modulus is the sum of mu_k/2, the bulk modulus k0. Infinite at J = 0. These are FEBio's mu_k (its c_k). Books that
// write mu_k/alpha_k (Ogden, Holzapfel) have other ones: theirs times alpha_k, whose signs agree, are the mu_k of here.
#include "components/hyperelasticity/ogden_terms.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

struct Ogden : OgdenSum<true> {
  template <class T>
  struct Parameters {
    T list, count, k0;
  };
  static Parameters<double> read(Values values) { return {listOf(values), countOf(values), values.back()}; }
  static auto volumetric(const auto& J, const auto& p) {
    const auto L = log(J);
    return 0.5 * p.k0 * (L * L);
  }
};

std::string fromShear(double mu, std::vector<double>& values) {
  if (std::isnan(values[1])) return "Ogden needs alpha1 besides youngModulus";
  if (std::isnan(values[0])) values[0] = 2 * mu;
  return {};
}

HyperelasticLaw withTerms(std::size_t terms) {
  return withBulkModulus(
      withOgdenTerms(lawOf<Ogden>("Ogden", "sum mu_k/alpha_k^2 (sum_i (J^-1/3 lambda_i)^alpha_k - 3) + k0/2 (ln J)^2"),
                     terms, "mu", "alpha"),
      terms == 1 ? fromShear : nullptr);
}

}  // namespace

STROMA_COMPONENT(ogden) {
  HyperelasticLaw law = withTerms(1);
  law.with_terms = withTerms;
  offerHyperelasticLaw(law);
}
