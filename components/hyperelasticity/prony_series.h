// SPDX-License-Identifier: LGPL-2.1-or-later
// Prony series of a stress S: with S_h the instantaneous (elastic) response,
//   S_v = S_h - sum_i gamma_i,   gamma_i(t) = int_0^t alpha_i (1 - exp((t' - t)/tau_i)) dS_h/dt' dt'
// so that tau_i dgamma_i/dt + gamma_i = alpha_i S_h: the modulus is G_0 (1 - sum alpha_i + sum alpha_i exp(-t/tau_i)).
// A step of length h is linear in the stresses at its ends:
//   gamma^n = a S^n + b gamma^{n-1} + c S^{n-1}
// backward (first order):    a = h alpha/(h + tau),  b = tau/(h + tau),  c = 0
// exponential (second):      b = exp(-h/tau),  q = (1 - b) tau/h,  a = alpha (1 - q),  c = alpha (q - b)
// The second is the integral itself for an S_h that changes linearly in the step. Source of the first: S. Marchesseau,
// T. Heimann, S. Chatelin, R. Willinger, H. Delingette, MICCAI 2010, section 3.1; of the second: R. L. Taylor,
// K. S. Pister, G. L. Goudreau, "Thermomechanical analysis of viscoelastic solids", IJNME 2 (1970) 45-59.
#pragma once
#include <vector>

#include "framework/scene/component.h"

namespace stroma {

enum class PronyUpdate : int { backward, exponential };
/// What relaxes: the stress, or the stress without that of the part k U(J) of the energy.
enum class PronyPart : int { all, deviatoric };

/// a, b, c of a step.
struct PronyStep {
  double now, kept, before;
};
/// h [s], 0 or more: with h = 0 nothing has moved on, a = c = 0 and b = 1.
PronyStep pronyStep(PronyUpdate update, double alpha, double tau, double h);

struct PronySeries {
  std::vector<double> alpha, tau;  ///< shape (terms): shares of the instantaneous modulus, relaxation times [s]
  PronyUpdate update = PronyUpdate::backward;
  PronyPart part = PronyPart::all;
  std::size_t terms() const { return alpha.size(); }
};

/// The series as attributes of a component; SOFA's names where it has them.
class PronyAttributes {
 public:
  void declare(DataTable& table);
  /// Throws ComponentError. No terms when the scene wants no viscosity.
  PronySeries read(const Component& component) const;

 private:
  bool viscous_ = false;
  PronySeries series_;
};

}  // namespace stroma
