// SPDX-License-Identifier: LGPL-2.1-or-later
// The numbers of a scene that have units, as they were written.
#pragma once
#include <array>
#include <vector>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/mass.h"
#include "framework/scene/load.h"

namespace stroma {

/// What a body has that a unit could be wrong of.
enum Quantity : std::size_t { body_size, body_modulus, body_density, body_gravity };
constexpr std::array quantities = {body_size, body_modulus, body_density, body_gravity};

/// An elastic body with a mass and a volume, in the scene's own numbers. The components live as long as the scene.
struct WrittenBody {
  const State* state;
  const ForceField* field;
  const Data* modulus;  ///< the first attribute of the field that is one
  const Mass* mass;
  const Data* mass_data;                         ///< that gives the mass
  std::array<double, quantities.size()> value;   ///< of moduli the largest
  double softest;                                ///< of moduli the smallest
  std::array<bool, quantities.size()> has_unit;  ///< written so: it is SI

  /// Its density then depends on the unit of length.
  bool hasMassWithoutDensity() const { return mass_data->name() != "massDensity"; }
};

/// Every body of a scene whose four quantities are known.
std::vector<WrittenBody> writtenBodies(const Scene& scene);

/// True when some attribute of the scene is written with a unit.
bool hasAnyUnit(const NodeDescription& root);

/// Where the positions of a state come from: a file (`is_file`: the component has an attribute `unit`), a grid, a list.
const Component& sourceOfLengths(const State& state, bool& is_file);

}  // namespace stroma
