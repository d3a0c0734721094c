// SPDX-License-Identifier: LGPL-2.1-or-later
// Ogden's sum, of any number of terms, in the isochoric principal stretches or in the stretches themselves:
//   sum_k m_k/e_k^2 (sum_i (J^-1/3 lambda_i)^e_k - 3)   or   sum_k m_k/e_k^2 (sum_i lambda_i^e_k - 3 - e_k ln J)
// ParameterSet = m1 e1 (m2 e2 ...) and one more.
#pragma once
#include <bit>

#include "components/hyperelasticity/hyperelastic_kernels.h"

namespace stroma::hyperelastic {

template <class T>
struct OgdenTerm {
  T factor, exponent;
};

/// The terms of a cell, where the field keeps its parameters: kernels carry the address only, whatever their number.
template <class T>
class OgdenTerms {
 public:
  OgdenTerms(T list, T count) {
    alignas(64) double address[lanes], counts[lanes];
    std::memcpy(address, &list, sizeof address);
    std::memcpy(counts, &count, sizeof counts);
    for (int l = 0; l < lanes; ++l) first_[l] = std::bit_cast<const double*>(address[l]);
    count_ = int(counts[0]);
  }
  int count() const { return count_; }
  /// Term k of all lanes.
  OgdenTerm<T> at(int k) const {
    alignas(64) double mu[lanes], alpha[lanes];
    for (int l = 0; l < lanes; ++l) mu[l] = first_[l][2 * k], alpha[l] = first_[l][2 * k + 1];
    OgdenTerm<T> term;
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

/// Parameters of a law of Ogden begin with `list`, the bits of the address of m1 e1 m2 ..., and `count`, the number of
/// terms, the same for all cells.
template <bool isochoric>
struct OgdenSum {
  using Set = PrincipalStretches;

  static double listOf(Values values) { return std::bit_cast<double>(values.data()); }
  static double countOf(Values values) { return double(values.size() / 2); }

  template <class T>
  static void addEnergy(const PrincipalStretches::Point<T>& p, const auto& parameters, T& sum) {
    const OgdenTerms<T> terms(parameters.list, parameters.count);
    for (int k = 0; k < terms.count(); ++k) {
      const auto term = terms.at(k);
      const T half = T(0.5) * term.exponent, mean = isochoric ? T(1. / 3) * p.log_j : T(0.);
      T powers(-3.);
      for (int i = 0; i < 3; ++i) powers += exp(half * p.log_c[i] - term.exponent * mean);
      if constexpr (!isochoric) powers -= term.exponent * p.log_j;
      sum += term.factor * powers;
    }
  }

  template <class T>
  static void addDerivatives(const PrincipalStretches::Point<T>& p, const auto& parameters, SpectralDerivatives<T>& w) {
    const T inverse_j = T(1.) / p.j, inverse_c[3] = {exp(-p.log_c[0]), exp(-p.log_c[1]), exp(-p.log_c[2])};
    const DividedDifference<T> pair[3] = {{p.log_c[0], p.log_c[1]}, {p.log_c[1], p.log_c[2]}, {p.log_c[2], p.log_c[0]}};
    const OgdenTerms<T> terms(parameters.list, parameters.count);
    for (int k = 0; k < terms.count(); ++k) {
      const auto term = terms.at(k);
      T f = term.factor, df(0.), ddf(0.);
      if constexpr (isochoric) {
        f = term.factor * exp(T(-1. / 3) * term.exponent * p.log_j);
        df = T(-1. / 3) * term.exponent * f * inverse_j;
        ddf = df * inverse_j * fma(T(-1. / 3), term.exponent, T(-1.));
      }
      const T half = T(0.5) * term.exponent, beta = half - T(1.);
      T sum(0.);
      for (int i = 0; i < 3; ++i) {
        const T power = exp(half * p.log_c[i]), slope = half * power * inverse_c[i];
        sum += power;
        w.s[i] += T(2.) * f * slope;
        w.normal[i] += T(2.) * f * beta * slope * inverse_c[i];
        w.coupling[i] += T(2.) * df * slope;
        w.shear[i] += T(2.) * f * half * pair[i].of(beta);
      }
      if constexpr (isochoric) {
        w.volume += df * sum, w.volume2 += ddf * sum;
      } else {  // by the logarithm, which a turned element has not: 1/J would be finite there
        const T slope = term.factor * term.exponent * exp(-p.log_j);
        w.volume -= slope, w.volume2 += slope * exp(-p.log_j);
      }
    }
  }
};

/// The law with `terms` pairs of parameters, `factor`k [Pa] and `exponent`k, to which it adds its others.
inline HyperelasticLaw withOgdenTerms(HyperelasticLaw law, std::size_t terms, const std::string& factor,
                                      const std::string& exponent) {
  for (std::size_t k = 1; k <= terms; ++k) {
    law.parameters.push_back({factor + std::to_string(k), "Pa", "modulus of a term"});
    law.parameters.push_back({exponent + std::to_string(k), "-", "exponent of a term"});
  }
  law.check = [name = law.name, exponent](Values p) -> std::string {
    double sum = 0;
    for (std::size_t k = 0; k + 1 < p.size(); k += 2) {
      if (p[k + 1] == 0) return exponent + std::to_string(k / 2 + 1) + " of " + name + " is 0";
      sum += p[k] / 2;
    }
    return sum > 0 ? ""
                   : "the moduli of " + name +
                         " have a sum that is not above 0: the shear modulus is half of it. The energy here has mu_k/alpha_k^2: "
                         "of a law with mu_k/alpha_k the mu_k of here are the products mu_k alpha_k";
  };
  return law;
}

}  // namespace stroma::hyperelastic
