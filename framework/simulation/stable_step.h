// SPDX-License-Identifier: LGPL-2.1-or-later
// The largest time step for which an explicit method is stable: h w <= angle, w the highest angular frequency.
#pragma once
#include <string>

#include "framework/simulation/explicit_step.h"

namespace stroma {

/// An estimate of the highest angular frequency of a system at its initial shape, undamped.
struct HighestFrequency {
  double value = 0;       ///< [rad/s]
  std::string element;    ///< the element that it comes from, or empty: then it is one of the whole system
  std::string strongest;  ///< of a motion of the whole system: the element that it strains most, or empty
};

/// From the elements when every force field with a stiffness offers ForceField::stiffestElement() and the mass is
/// diagonal: then no smaller than the true one, by the theorem of B. Irons and M. Treharne 1971 (the eigenvalues of an
/// assembly lie within those of its elements) for nodal masses shared out in proportion to the stiffness of the
/// elements. Else by power iteration on M^-1 K, which stays a few per cent below the true one at most of its starts.
HighestFrequency highestFrequency(System& system, Acceleration& acceleration);

/// Warns, with the numbers and the element, when the scene's dt exceeds the limit. `method` is the subject of a
/// sentence.
void warnAboveStableStep(Integrator& integrator, System& system, Acceleration& acceleration, const std::string& method,
                         const StabilityLimit& limit);

}  // namespace stroma
