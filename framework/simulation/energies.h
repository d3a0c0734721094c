// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <vector>

#include "framework/simulation/system.h"

namespace stroma {

/// The energies of all systems of a scene at x and v [J]. Nodes computed on demand must be up to date: see complete().
struct Energies {
  double kinetic = 0, elastic = 0, gravity = 0, total = 0;
};
inline Energies energiesOf(const std::vector<std::unique_ptr<System>>& systems) {
  Energies sum;
  for (const auto& system : systems) {
    const double kinetic = system->kineticEnergy(), elastic = system->elasticEnergy(system->x), gravity = system->gravityEnergy(system->x);
    sum.kinetic += kinetic;
    sum.elastic += elastic;
    sum.gravity += gravity;
    sum.total += kinetic + (elastic + gravity);
  }
  return sum;
}

}  // namespace stroma
