// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/drawing/recording.h"

#include "framework/mechanics/frames.h"
#include "framework/simulation/simulation.h"
#include "framework/simulation/system.h"

namespace stroma::drawing {

void showInstant(Simulation& simulation, const Recording& recording, std::size_t instant) {
  std::size_t i = 0;
  for (State* state : simulation.states()) {
    const StateFrame& frame = recording[i++][instant];
    for (Index row = 0; row < state->size(); ++row) {
      placeRow(state->kindOf(row), frame.x[std::size_t(row)], state->x(), row);
      if (!frame.v.empty()) state->v()[row] = frame.v[std::size_t(row)];
    }
  }
  if (!recording.empty())  // loads of the instant
    for (const auto& system : simulation.systems()) system->setTime(recording.front()[instant].time);
}

}  // namespace stroma::drawing
