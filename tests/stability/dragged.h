// SPDX-License-Identifier: LGPL-2.1-or-later
// How far a body that was dragged is from its rest shape.
#pragma once
#include <algorithm>
#include <vector>

#include "tests/support/scene_fixture.h"

namespace stroma::test {

/// The largest distance of a node of the first state from its place at rest [m].
inline double farthestFromRest(const Simulation& simulation) {
  const State& state = *simulation.states().at(0);
  double largest = 0;
  for (Index i = 0; i < state.size(); ++i) largest = std::max(largest, (state.x()[i] - state.rest_position[i]).norm());
  return largest;
}

/// Elements of /organ/fem with J < 0.
inline int invertedElements(Simulation& simulation) {
  const auto* field = dynamic_cast<const ForceField*>(findComponent(simulation.root(), "/organ/fem"));
  std::vector<double> j;
  field->cellField("J", simulation.systems().at(0)->x, j);
  return int(std::count_if(j.begin(), j.end(), [](double value) { return value < 0; }));
}

}  // namespace stroma::test
