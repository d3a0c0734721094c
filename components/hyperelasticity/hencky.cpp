// SPDX-License-Identifier: LGPL-2.1-or-later
// Hencky, Hooke's law for the logarithmic strain H = (ln C)/2: W = mu tr(H^2) + lambda/2 (ln J)^2, tr H = ln J. With
// k = lambda + 2/3 mu it is mu |dev H|^2 + k/2 (ln J)^2, FEBio's "natural neo-Hookean". Infinite at J = 0. For moderate
// strains: the force 2 mu ln(l)/l along a stretch l, with lambda = 0, falls beyond l = 2.7. Source: H. Hencky, "Ueber die
// Form des Elastizitaetsgesetzes bei ideal elastischen Stoffen", Zeitschrift fuer technische Physik 9 (1928) 215-220; L.
// Anand, "On H. Hencky's approximate strain-energy function for moderate deformations", Journal of Applied Mechanics 46
// (1979) 78-82.
#include "components/hyperelasticity/hyperelastic_kernels.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

/// mu sum_i (ln c_i)^2/4 over the eigenvalues c_i of C.
struct Hencky : InLameConstants<PrincipalStretches> {
  static auto volumetric(const auto& J, const auto& p) {
    const auto L = log(J);
    return 0.5 * p.lambda * (L * L);
  }
  template <class T>
  static void addEnergy(const PrincipalStretches::Point<T>& p, const auto& parameters, T& sum) {
    for (int i = 0; i < 3; ++i) sum += T(0.25) * parameters.mu * p.log_c[i] * p.log_c[i];
  }
  template <class T>
  static void addDerivatives(const PrincipalStretches::Point<T>& p, const auto& parameters, SpectralDerivatives<T>& w) {
    for (int i = 0; i < 3; ++i) {
      const T inverse = exp(-p.log_c[i]);
      w.s[i] += parameters.mu * p.log_c[i] * inverse;
      w.normal[i] += parameters.mu * (T(1.) - p.log_c[i]) * inverse * inverse;
      w.shear[i] += parameters.mu * slope(p.log_c[i], p.log_c[(i + 1) % 3]);
    }
  }
  /// (ln(a)/a - ln(b)/b)/(a - b) = e^-2m (cosh d/(sinh(d)/d) - m) with m the mean and d half the difference of ln a and
  /// ln b; (1 - ln a)/a^2 where they meet.
  template <class T>
  static T slope(T log_a, T log_b) {
    const DividedDifference<T> pair(log_a, log_b);
    const T up = exp(pair.delta);
    return exp(T(-2.) * pair.mean) * (T(0.5) * (up + T(1.) / up) * pair.scale - pair.mean);
  }
};

}  // namespace

STROMA_COMPONENT(hencky) {
  HyperelasticLaw law = inLameConstants(lawOf<Hencky>("Hencky", "mu tr(H^2) + lambda/2 (ln J)^2, H = (ln C)/2"));
  law.volume = VolumePart::half_log_squared, law.volume_parameter = 1;
  law.infinite_at_zero = true;
  offerHyperelasticLaw(law);
}
