// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mesh/topology.h"

namespace stroma {

Topology* TopologicalMapping::output() const {
  if (auto* linked = dynamic_cast<Topology*>(output_.target())) return linked;
  if (!data().find("tetrahedra")) return nullptr;  // it makes none for a container of tetrahedra beside it
  for (const auto& component : node().components())
    if (auto* beside = dynamic_cast<Topology*>(component.get()); beside && beside != this && beside->mainCells() == "tetrahedra")
      return beside;
  return nullptr;
}

}  // namespace stroma
