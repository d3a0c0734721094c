// SPDX-License-Identifier: LGPL-2.1-or-later
// In which consistent systems of units the numbers of a body are those of things.
#pragma once
#include <array>
#include <vector>

#include "tools/units/unit_system.h"
#include "tools/units/written_bodies.h"

namespace stroma {

/// In SI: bodies from a cell to a bridge, gels to diamond, foam to osmium, gravity from small moons to a centrifuge.
struct PlausibleRange {
  double low, high, typical;
  bool has(double value) const { return value >= low && value <= high; }
};
constexpr PlausibleRange plausible[] = {{1e-5, 100, 0.1}, {10, 1e12, 1e4}, {10, 25000, 1000}, {0.1, 500, 9.81}};

/// What a number of the scene is in SI.
using Factors = std::array<double, body_quantities.size()>;
Factors factorsOf(const UnitSystem& system);

/// The usual systems, SI first.
const std::vector<UnitSystem>& unitSystems();

/// A value that is unknown is none to judge, and no gravity is plausible.
bool isKnown(const WrittenBody& body, Quantity q);
/// density * gravity * size / modulus, what is not known as usual: about the strain by the body's own weight.
double weightOf(const WrittenBody& body, const Factors& factors);
/// The largest such strain of a body that keeps its shape. A brain out of its liquid has 3, a puddle 30 and more.
constexpr double heaviest = 30;

/// What is wrong with a body.
struct Faults {
  std::vector<Quantity> out;      ///< of their ranges
  std::vector<Quantity> suspect;  ///< at the end of their ranges, and the body is too heavy for its stiffness
  bool too_heavy = false;
  std::size_t count() const { return out.empty() && too_heavy ? 1 : out.size(); }
};
Faults faultsOf(const WrittenBody& body, const Factors& factors);

/// Numbers that are none of things: benchmarks without dimensions have a density of 1, and another 1 or a gravity that
/// no place has.
bool isWithoutDimensions(const WrittenBody& body);

}  // namespace stroma
