// SPDX-License-Identifier: LGPL-2.1-or-later
// The largest time step for which an explicit method is stable: h w <= angle, w the highest angular frequency.
#pragma once
#include <string>

#include "components/integrators/explicit_step.h"

namespace stroma {

/// An estimate of the highest angular frequency of a system at its initial shape, undamped.
struct HighestFrequency {
  double value = 0;     ///< [rad/s]
  std::string element;  ///< the element that the motion strains most, "element 12 of /beam/fem"; empty: none known
};

/// Numbers between -1/2 and 1/2 without an order that a mesh could share.
void fillAtRandom(Rows rows);

/// By power iteration on M^-1 K, which stays a few per cent below the true one at most of its starts.
HighestFrequency highestFrequency(System& system, Acceleration& acceleration);

/// Warns, with the numbers and the element, when the scene's dt exceeds the limit. `method` is the subject of a
/// sentence.
void warnAboveStableStep(Integrator& integrator, System& system, Acceleration& acceleration, const std::string& method,
                         const StabilityLimit& limit);

}  // namespace stroma
