// SPDX-License-Identifier: LGPL-2.1-or-later
// What a sweep varies.
#pragma once
#include <string>
#include <vector>

#include "framework/scene/types.h"

namespace stroma::sweep {

/// What the values of an axis mean for the error.
enum class AxisKind {
  mesh,        ///< spacing h [m]: error ~ h^p
  time_step,   ///< dt [s]: error ~ dt^p
  tolerance,   ///< smaller is finer
  iterations,  ///< more is finer
  words,       ///< no order: methods, solvers, other numbers
};

/// One attribute, or several that vary together.
struct Axis {
  std::vector<std::string> attributes;           ///< "/beam/grid.n", shape (attributes)
  std::vector<std::vector<std::string>> values;  ///< shape (values, attributes)
  AxisKind kind = AxisKind::words;
  /// h, dt, tolerance or number of iterations, shape (values); empty for words, infinite where the scene refuses a value.
  std::vector<double> sizes;
  /// Of meshes that are refined unevenly: h is their spacing along it. Else zero: h is that of EndState::spacing().
  Vec3 direction = Vec3::Zero();

  std::size_t size() const { return values.size(); }
  bool isOrdered() const { return kind != AxisKind::words; }
  /// Whether errors are expected to follow a power of the sizes.
  bool hasOrder() const { return kind == AxisKind::mesh || kind == AxisKind::time_step; }
  /// True when value `a` is finer than value `b`. Of words the one listed later counts as finer.
  bool isFiner(std::size_t a, std::size_t b) const;
  std::size_t finest() const;
  /// "grid.n", with the others of a group behind it.
  std::string label() const;
  /// "41 5 5", with the others of a group behind it.
  std::string valueText(std::size_t value) const;
  /// The same with the attributes' names: "grid.n=41 5 5".
  std::string settingText(std::size_t value) const;
};

/// Axes of --vary and --zip. Throws std::invalid_argument with a sentence.
std::vector<Axis> parseAxes(const std::vector<std::string>& vary, const std::vector<std::string>& zip);

/// Recognises attributes by their names: a tolerance, a number of iterations. Meshes and time steps are recognised by what a
/// scene makes of them, see probe.h.
void classify(Axis& axis);

/// The last two parts of a path: "/beam/cells/fem.method" is "fem.method".
std::string shortName(const std::string& attribute);

/// A number that is all of the text.
bool readNumber(const std::string& text, double& number);

}  // namespace stroma::sweep
