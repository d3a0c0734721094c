// SPDX-License-Identifier: LGPL-2.1-or-later
// A Mooney-Rivlin matrix with one family of crimped fibres, for ligaments and tendons:
//   W = c1 (J^-2/3 I1 - 3) + c2 (J^-4/3 I2 - 3) + F(l) + k0/2 (ln J)^2,   l = J^-1/3 sqrt(a C a)
//   l F'(l) = 0                          l <= 1
//             c3 (exp(c4 (l - 1)) - 1)   1 < l < lam_max: the fibres straighten
//             c5 l + c6                  l >= lam_max, c6 so that the force does not jump
// with a the fibre of AnisotropyDirections. At small strains mu = 2 (c1 + c2) across the fibre and the bulk modulus is
// k0. Infinite at J = 0. Names and order are those of FEBio's "trans iso Mooney-Rivlin". Source: J. A. Weiss, B. N.
// Maker, S. Govindjee, "Finite element implementation of incompressible, transversely isotropic hyperelasticity",
// Computer Methods in Applied Mechanics and Engineering 135 (1996) 107-128.
#include <fmt/format.h>

#include "components/hyperelasticity/hyperelastic_kernels.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

/// J, I1, I2 and I4 = a C a, a the first axis of the frame of F. I4 meets J alone in the energy.
struct FirstSecondAndFibre {
  static constexpr bool anisotropic = true;
  template <class T>
  struct Point : FirstAndSecond::Point<T> {
    T i4;
    template <class Parameters>
    Point(const M3<T>& deformation, const Parameters& parameters)
        : FirstAndSecond::Point<T>(deformation, parameters), i4(stroma::dot(deformation.c0, deformation.c0)) {}
    auto invariants() const { return std::tie(this->j, this->i1, this->i2, i4); }
  };
  template <class T>
  static M3<T> stress(const Point<T>& p, const auto& w) {
    M3<T> stress = FirstAndSecond::stress(p, w);
    stress.c0 = fma(T(2. * w.d), p.f.c0, stress.c0);
    return stress;
  }
  template <class T>
  static M3<T> differential(const Point<T>& p, const auto& w, const M3<T>& df) {
    static_assert(!NotZero<decltype(w.bd + w.cd)>);
    const T half_di4 = stroma::dot(p.f.c0, df.c0), di4 = half_di4 + half_di4, dj = dot(p.cof, df);
    const T dfibre = w.ad * dj + w.dd * di4, dvolume = w.ad * di4;
    M3<T> out = FirstAndSecond::differential(p, w, df) + p.cof * dvolume;
    out.c0 = out.c0 + (df.c0 * (2. * w.d) + p.f.c0 * (2. * dfibre));
    return out;
  }
  template <class T>
  static void gradients(const Point<T>& p, S3<T> (&a)[3]) {
    FirstAndSecond::gradients(p, a);
    a[2].xx = T(1.);
  }
  template <class T>
  static void curvature(const auto& p, const auto& w, Elasticity<T>& d) {
    FirstAndSecond::curvature(p, w, d);
  }
};

/// l held between 1 and lam_max: where fibres straighten.
template <class T>
T straightening(T l, const auto& p) {
  const T stretched = maximum(l, T(1.));
  return select(stretched < p.lam_max, stretched, p.lam_max);
}

/// Ei(x), x > 0.
template <class T>
T exponentialIntegral(T x) {
  alignas(64) double values[sizeof(T) / sizeof(double)];
  std::memcpy(values, &x, sizeof values);
  for (double& value : values) value = std::expint(value);
  std::memcpy(&x, values, sizeof values);
  return x;
}

/// F, of the logarithm of l: c3 (exp(-c4) (Ei(c4 l) - Ei(c4)) - ln l) where fibres straighten.
template <Number T>
T fibreEnergy(const T& log_l, const auto& p) {
  const T l = exp(log_l), bent = straightening(l, p), growth = exp(p.c4 * (bent - T(1.)));
  const T integral = exp(-p.c4) * (exponentialIntegral(T(p.c4 * bent)) - exponentialIntegral(T(p.c4)));
  const T c6 = p.c3 * (growth - T(1.)) - p.c5 * bent;
  const T straight = p.c5 * (l - bent) + c6 * (log_l - log(bent));
  return p.c3 * (integral - log(bent)) + select(l > p.lam_max, straight, T(0.));
}
/// The same with the derivatives by ln l; the value of a jet is not read. The second one jumps at l = 1, where a fibre
/// at rest is: within round-off it is that of a straightening fibre, as in squaredPositivePart().
template <AJet X>
auto fibreEnergy(const X& log_l, const auto& p) {
  using T = std::remove_cvref_t<decltype(log_l.value)>;
  const T l = exp(log_l.value), bent = straightening(l, p), growth = exp(p.c4 * (bent - T(1.)));
  const T round_off(1e-10);
  const auto is_straight = l > p.lam_max - round_off;
  const T force = p.c3 * (growth - T(1.)) + select(is_straight, T(p.c5 * (l - bent)), T(0.));
  const T toe = select(l > T(1.) - round_off, T(p.c3 * p.c4 * l * growth), T(0.));
  return chain(log_l, T(0.), force, T(select(is_straight, T(p.c5 * l), toe)));
}

struct TransverselyIsotropicMooneyRivlin {
  using Set = FirstSecondAndFibre;
  template <class T>
  struct Parameters {
    T c1, c2, c3, c4, c5, lam_max, k0;
  };
  static auto energy(const auto& J, const auto& I1, const auto& I2, const auto& I4, const auto& p) {
    const auto L = log(J);
    const auto scale = exp((-2. / 3) * L);
    return p.c1 * (scale * I1 - 3.) + p.c2 * (scale * scale * I2 - 3.) + fibreEnergy(0.5 * log(I4) + (-1. / 3) * L, p) +
           0.5 * p.k0 * (L * L);
  }
};

std::string check(Values p) {
  if (!(p[0] + p[1] > 0))
    return "c1 + c2 of TransverselyIsotropicMooneyRivlin is not above 0: the shear modulus is twice that";
  if (!(p[5] >= 1))
    return fmt::format("lam_max = {} of TransverselyIsotropicMooneyRivlin is below 1, where fibres begin to resist",
                       p[5]);
  if (!(p[3] * p[5] < 700))
    return fmt::format(
        "c4 = {} and lam_max = {} of TransverselyIsotropicMooneyRivlin make exp(c4 lam_max) exceed what "
        "a number holds",
        p[3], p[5]);
  return {};
}

}  // namespace

STROMA_COMPONENT(transversely_isotropic_mooney_rivlin) {
  HyperelasticLaw law = withBulkModulus(
      lawOf<TransverselyIsotropicMooneyRivlin>(
          "TransverselyIsotropicMooneyRivlin", "MooneyRivlin + F(l), l F' = c3 (exp(c4 (l - 1)) - 1), then c5 l + c6",
          {{"c1", "Pa", "factor of the first invariant"},
           {"c2", "Pa", "factor of the second invariant"},
           {"c3", "Pa", "factor of the exponential of fibres that straighten", true},
           {"c4", "-", "exponent of fibres that straighten", true},
           {"c5", "Pa", "modulus of straight fibres", true},
           {"lam_max", "-", "stretch at which fibres are straight, 1 or more"}}),
      nullptr);
  law.directions = 1;
  law.check = check;
  offerHyperelasticLaw(law);
}
