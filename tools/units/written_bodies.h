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
constexpr std::array body_quantities = {body_size, body_modulus, body_density, body_gravity};

/// An attribute that holds moduli.
struct Modulus {
  const ForceField* field;
  const Data* data;
};

/// An elastic body in the scene's own numbers: a state with all fields on it. The components live as long as the scene.
struct WrittenBody {
  const State* state;
  std::vector<Modulus> moduli;                       ///< the stiffest first
  const Mass* mass;                                  ///< null: it has none, or none whose volume is known
  const Data* mass_data;                             ///< that gives the mass
  std::array<double, body_quantities.size()> value;  ///< of moduli the largest; 0: unknown, or none
  double softest;                                    ///< of moduli the smallest

  /// Its density then depends on the unit of length.
  bool hasMassWithoutDensity() const { return mass_data && mass_data->name() != "massDensity"; }
};

/// Every body of a scene whose size and moduli are known.
std::vector<WrittenBody> writtenBodies(const Scene& scene);

/// Which quantities of a body are written with a unit, and so are SI.
std::array<bool, body_quantities.size()> quantitiesWithUnit(const Scene& scene, const WrittenBody& body);

/// Where the positions of a state come from: a file (`is_file`: the component has an attribute `unit`), a grid, a list.
const Component& sourceOfLengths(const State& state, bool& is_file);

}  // namespace stroma
