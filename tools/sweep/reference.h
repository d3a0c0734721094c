// SPDX-License-Identifier: LGPL-2.1-or-later
// --reference that is no run of the sweep: a closed form, or a file.
#pragma once
#include <memory>
#include <optional>
#include <string>

#include "tools/sweep/error_measure.h"

namespace stroma::sweep {

class GivenReference {
 public:
  virtual ~GivenReference() = default;
  /// The points that it comes with; empty when it has a value everywhere.
  virtual CommonPoints points() const { return {}; }
  /// At the points, at the time t [s] of the end.
  virtual Values valuesAt(const CommonPoints& points, double t) const = 0;
  /// Whether it has a value at any time.
  virtual bool dependsOnTime() const { return false; }
  /// The time that it is of [s], where it is known.
  virtual std::optional<double> time() const { return {}; }
  /// Half a sentence: "the formula ...".
  virtual std::string text() const = 0;
};

/// Null for "finest" and "extrapolated". A file is one that there is:
///   *.state, *.state.gz   a recording; its first instant is the rest shape, its last one the end
///   *.csv, *.txt          lines "x y z ux uy uz", or the one or three numbers of a quantity
///   else                  what `stroma run --measure` has written
/// Everything else is a formula of x, y, z (the place at rest, [m]) and t [s]: "ux; uy; uz" for displacements, one or
/// three for a quantity. Throws std::invalid_argument with a sentence.
std::unique_ptr<GivenReference> parseReference(const std::string& text, const ErrorMeasure& measure);

}  // namespace stroma::sweep
