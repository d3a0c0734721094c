// SPDX-License-Identifier: LGPL-2.1-or-later
// Ogden: W = sum_k mu_k/alpha_k^2 (l1^alpha_k + l2^alpha_k + l3^alpha_k - 3) + k0/2 (ln J)^2, l_i = J^-1/3 lambda_i the
// isochoric principal stretches, any number of terms: ParameterSet = mu1 alpha1 (mu2 alpha2 ...) k0. At small strains
// the shear modulus is the sum of mu_k/2, the bulk modulus k0. Infinite at J = 0.
#include <bit>

#include "components/hyperelasticity/hyperelastic_kernels.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

template <class T>
struct Term {
  T factor, exponent;
};

/// The terms of a cell, where the field keeps its parameters: kernels carry the address only, whatever their number.
template <class T>
class Terms {
 public:
  Terms(T list, T count) {
    alignas(64) double address[lanes], counts[lanes];
    std::memcpy(address, &list, sizeof address);
    std::memcpy(counts, &count, sizeof counts);
    for (int l = 0; l < lanes; ++l) first_[l] = std::bit_cast<const double*>(address[l]);
    count_ = int(counts[0]);
  }
  int count() const { return count_; }
  /// Term k of all lanes.
  Term<T> at(int k) const {
    alignas(64) double mu[lanes], alpha[lanes];
    for (int l = 0; l < lanes; ++l) mu[l] = first_[l][2 * k], alpha[l] = first_[l][2 * k + 1];
    Term<T> term;
    std::memcpy(&term.factor, mu, sizeof mu);
    std::memcpy(&term.exponent, alpha, sizeof alpha);
    term.factor = term.factor / (term.exponent * term.exponent);
    return term;
  }

 private:
  static constexpr int lanes = std::is_same_v<T, double> ? 1 : pack_lanes;
  const double* first_[lanes];
  int count_;
};

struct Ogden {
  using Set = PrincipalStretches;
  template <class T>
  struct Parameters {
    T list;   ///< the bits of the address of mu1 alpha1 mu2 ...
    T count;  ///< of terms, the same for all cells
    T k0;
  };
  static Parameters<double> read(Values values) {
    const std::size_t terms = values.size() / 2;
    return {std::bit_cast<double>(values.data()), double(terms), values.back()};
  }
  template <class T>
  static Terms<T> terms(const Parameters<T>& p) {
    return {p.list, p.count};
  }
  static auto volumetric(const auto& J, const auto& p) {
    const auto L = log(J);
    return 0.5 * p.k0 * (L * L);
  }
};

std::string check(Values p) {
  double sum = 0;
  for (std::size_t k = 0; k + 1 < p.size(); k += 2) {
    if (p[k + 1] == 0) return "alpha" + std::to_string(k / 2 + 1) + " of Ogden is 0";
    sum += p[k] / 2;
  }
  return sum > 0 ? "" : "the moduli of Ogden have a sum that is not above 0: the shear modulus is half of it";
}

std::string fromShear(double mu, std::vector<double>& values) {
  if (std::isnan(values[1])) return "Ogden needs alpha1 besides youngModulus";
  if (std::isnan(values[0])) values[0] = 2 * mu;
  return {};
}

HyperelasticLaw withTerms(std::size_t terms) {
  HyperelasticLaw law =
      lawOf<Ogden>("Ogden", "sum mu_k/alpha_k^2 (sum_i (J^-1/3 lambda_i)^alpha_k - 3) + k0/2 (ln J)^2");
  for (std::size_t k = 1; k <= terms; ++k) {
    law.parameters.push_back({"mu" + std::to_string(k), "Pa", "modulus of a term"});
    law.parameters.push_back({"alpha" + std::to_string(k), "-", "exponent of a term"});
  }
  law.check = check;
  return withBulkModulus(std::move(law), terms == 1 ? fromShear : nullptr);
}

}  // namespace

STROMA_COMPONENT(ogden) {
  HyperelasticLaw law = withTerms(1);
  law.with_terms = withTerms;
  offerHyperelasticLaw(law);
}
