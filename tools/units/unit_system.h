// SPDX-License-Identifier: LGPL-2.1-or-later
// The units that the numbers of a scene are in. Nothing is computed with them: whoever shows a number asks here what to
// write beside it; components ask by framework/scene/written_units.h.
#pragma once
#include <string>
#include <string_view>

#include "framework/scene/load.h"

namespace stroma {

/// Units of length, mass and time, in SI; with them force, pressure and all else are consistent.
struct UnitSystem {
  std::string name;  ///< "mm, t, s"; empty: unknown, or without dimensions
  double length = 1, mass = 1, time = 1;

  bool isKnown() const { return !name.empty(); }
  bool isSI() const { return isKnown() && length == 1 && mass == 1 && time == 1; }
  /// What "Pa" or "N s/m" of SI is here: "kPa", "mN s/mm". Empty when the system is unknown, and of pure numbers.
  std::string unit(std::string_view si_unit) const;
  /// The same behind a number or a title: " kPa", " [kPa]", or nothing.
  std::string behind(std::string_view si_unit) const;
  std::string inBrackets(std::string_view si_unit) const;
  /// A sentence of the engine, which knows no other system than SI: units behind numbers become those of this one. Where
  /// the system is unknown they are left out.
  std::string sentence(const std::string& text) const;
};

/// "mm t s", "mm kPa s", "cm, g, s": three units of which one is a length, one a time, and one a mass, a force or a
/// pressure. Throws ComponentError.
UnitSystem readUnitSystem(std::string_view text);

/// Of a scene: what `units` on the outermost node declares; SI where some value is written with a unit; else the system in
/// which sizes, stiffness, densities and gravity of all bodies are those of things, where there is only one, or SI.
UnitSystem unitsOf(const Scene& scene);

/// True when some attribute of the scene is written with a unit, and so is SI.
bool hasAnyUnit(const NodeDescription& root);

}  // namespace stroma
