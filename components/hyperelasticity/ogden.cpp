// SPDX-License-Identifier: LGPL-2.1-or-later
// Ogden: W = sum_k mu_k/alpha_k^2 (l1^alpha_k + l2^alpha_k + l3^alpha_k - 3) + k0/2 (ln J)^2, l_i = J^-1/3 lambda_i the
// isochoric principal stretches, one to three terms: ParameterSet = mu1 alpha1 (mu2 alpha2 (mu3 alpha3)) k0. At small
// strains the shear modulus is the sum of mu_k/2, the bulk modulus k0. Infinite at J = 0.
#include "framework/fem/hyperelastic_kernels.h"
#include "framework/scene/factory.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

template <int terms>
struct Ogden {
  using Set = PrincipalStretches;
  static constexpr bool anisotropic = false;
  static constexpr int term_count = terms;
  template <class T>
  struct Parameters {
    struct {
      T mu, alpha;
    } term[terms];
    T k0;
  };
  template <class T>
  struct Term {
    T factor, exponent;
  };
  template <class T>
  static Term<T> term(const Parameters<T>& p, int k) {
    const T alpha = p.term[k].alpha;
    return {p.term[k].mu / (alpha * alpha), alpha};
  }
  static auto volumetric(const auto& J, const auto& p) {
    const auto L = log(J);
    return 0.5 * p.k0 * (L * L);
  }
};

template <int terms>
HyperelasticLaw ogden() {
  HyperelasticLaw law;
  law.name = "Ogden";
  law.formula = "sum mu_k/alpha_k^2 (sum_i (J^-1/3 lambda_i)^alpha_k - 3) + k0/2 (ln J)^2";
  for (int k = 1; k <= terms; ++k) {
    law.parameters.push_back({"mu" + std::to_string(k), "Pa", "modulus of a term"});
    law.parameters.push_back({"alpha" + std::to_string(k), "-", "exponent of a term"});
  }
  law.parameters.push_back({"k0", "Pa", "bulk modulus", true});
  law.infinite_at_zero = true;
  law.check = [](const double* p) -> std::string {
    double sum = 0;
    for (int k = 0; k < terms; ++k) {
      if (p[2 * k + 1] == 0) return "an exponent of Ogden is 0";
      sum += p[2 * k] / 2;
    }
    return sum > 0 ? "" : "the moduli of Ogden have a sum that is not above 0: the shear modulus is half of it";
  };
  if (terms == 1)
    law.from_lame = [](const Lame& lame, std::vector<double>& values) -> std::string {
      if (std::isnan(values[1])) return "Ogden needs alpha1 besides youngModulus";
      if (std::isnan(values[0])) values[0] = 2 * lame.mu;
      if (std::isnan(values[2])) values[2] = lame.lambda + 2. / 3 * lame.mu;
      return {};
    };
  return law;
}

}  // namespace

STROMA_COMPONENT(ogden) {
  offerHyperelasticLaw(lawOf<Ogden<1>>(ogden<1>()));
  offerHyperelasticLaw(lawOf<Ogden<2>>(ogden<2>()));
  offerHyperelasticLaw(lawOf<Ogden<3>>(ogden<3>()));
}
