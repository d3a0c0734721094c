// SPDX-License-Identifier: LGPL-2.1-or-later
// A beam between two frames as a spring of the twist (rho, psi) that leads from one to the other along a helix (frame_pair_field.h
// has p and psi, beam_fem_force_field.cpp the energy of a straight beam):
//
//   rho = dexp^-1(psi) p,   s = k_rho (rho - rho_0),   couple = k_psi (psi - psi_0),   E = 1/2 (s.(rho - rho_0) + couple.(psi - psi_0))
//   dE/dp = dexp^-T(psi) s, and dE/dpsi is the couple and the change of rho with psi,
//   s.drho/dpsi = -1/2 p x s + c ((psi.s) p + (psi.p) s - 2 (p.s) psi) + 2 c' ((psi.p)(psi.s) - |psi|^2 (p.s)) psi
#pragma once
#include "components/beams/relative_motion.h"

namespace stroma {

/// Fills n and k of the wrench with the derivatives. s and the couple as they follow from rho and psi.
template <class T, class Wrench>
void setTwistWrench(const Triple<T>& p, const Triple<T>& psi, const T& c, const T& slope, const T& square, const Triple<T>& s,
                    const Triple<T>& couple, Wrench& wrench) {
  const T along_p = dot(psi, p), along_s = dot(psi, s), work = dot(p, s);
  wrench.n = inverseTimes(psi, c, s, 1);
  wrench.k = couple + T(-0.5) * cross(p, s) + c * (along_s * p + along_p * s - (T(2) * work) * psi) +
             (slope * (along_p * along_s - square * work)) * psi;
}

}  // namespace stroma
