// SPDX-License-Identifier: LGPL-2.1-or-later
// Arruda-Boyce, five terms of the series of eight-chain cells, with N = 8 links' locking stretch:
//   W = mu sum_{n = 1..5} C_n (J^-2n/3 I1^n - 3^n) + k0/2 (ln J)^2,
//   C = 1/2, 1/(20 N), 11/(1050 N^2), 19/(7000 N^3), 519/(673750 N^4)
// At small strains the shear modulus is 1.085137 mu, the bulk modulus k0. Infinite at J = 0.
#include "components/hyperelasticity/hyperelastic_kernels.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

constexpr double N = 8;
constexpr double C[5] = {1. / 2, 1 / (20 * N), 11 / (1050 * N * N), 19 / (7000 * N * N * N),
                         519 / (673750 * N * N * N * N)};

struct ArrudaBoyce : IsochoricAndBulk<ArrudaBoyce, First> {
  template <class T>
  struct Parameters {
    T mu, k0;
  };
  /// mu sum C_n (i^n - 3^n)
  static auto isochoric(const auto& i, const auto& p) {
    constexpr double at_rest = 3 * (C[0] + 3 * (C[1] + 3 * (C[2] + 3 * (C[3] + 3 * C[4]))));
    return p.mu * (i * ((i * ((i * ((i * (C[4] * i + C[3])) + C[2])) + C[1])) + C[0]) - at_rest);
  }
};

/// The shear modulus of small strains over mu: 2 sum n C_n 3^(n-1).
constexpr double shear_factor = 2 * (C[0] + 3 * (2 * C[1] + 3 * (3 * C[2] + 3 * (4 * C[3] + 3 * 5 * C[4]))));

}  // namespace

STROMA_COMPONENT(arruda_boyce) {
  offerHyperelasticLaw(
      withBulkModulus(lawOf<ArrudaBoyce>("ArrudaBoyce", "mu sum C_n (J^-2n/3 I1^n - 3^n) + k0/2 (ln J)^2, n = 1..5",
                                         {{"mu", "Pa", "shear modulus", true}}),
                      [](double mu, std::vector<double>& values) -> std::string {
                        if (std::isnan(values[0])) values[0] = mu / shear_factor;
                        return {};
                      }));
}
