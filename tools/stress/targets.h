// SPDX-License-Identifier: LGPL-2.1-or-later
// The numbers of a scene that may be other ones, found by what attributes declare: type, unit, range and role. No component
// and no attribute is known by its name, so that those of modules outside the tree are found as well.
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"

namespace stroma::stress {

/// What a number is to a body, by its unit.
enum class Quantity {
  stiffness,  ///< a pressure, a force per length, a torque per angle
  inertia,    ///< a mass, a density
  ratio,      ///< a pure number with a largest value, such as Poisson's ratio
  time,       ///< the step, a relaxation, a damping factor
  length,     ///< a distance, an area
  other,      ///< any other quantity with a unit
  number      ///< a pure number: a tolerance, an exponent
};
const char* wordOf(Quantity quantity);

/// An attribute that holds numbers.
struct Target {
  std::string path, attribute;  ///< as an override names them
  Quantity quantity = Quantity::other;
  std::vector<double> values;
  double low = 0, high = 0;  ///< of its range; may be infinite
  bool has_low = false, has_high = false;

  std::string name() const { return path + "." + attribute; }
  /// All values times 10^decades, kept within the range. Empty when that changes nothing.
  std::string scaled(double decades) const;
  /// A share 10^-decades of the range away from its end, above or below. Empty as above.
  std::string nearEnd(double decades, bool above) const;
  bool isBounded() const { return has_low && has_high; }

 private:
  std::string textOf(std::vector<double> changed) const;
};

/// In document order; the root's dt first.
std::vector<Target> targetsOf(const Simulation& simulation);

}  // namespace stroma::stress
