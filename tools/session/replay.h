// SPDX-License-Identifier: LGPL-2.1-or-later
// What was done to a run from outside, done again.
#pragma once
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"

namespace stroma {

/// An event that is replayed was refused: a sentence with its place. The step that it came before was not made.
class ReplayError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// From now on these happen, each before the step that it came before; those of steps already made do not. Ascending in
/// `step`. Simulation::reset() begins them again, with the edits of now. `file`: where they were read, for messages.
/// Throws SceneError with what can be known to be wrong now; Simulation::step() throws ReplayError for the rest.
void replay(Simulation& simulation, std::vector<RunEvent> events, const std::string& file = {});

/// How many of them have happened, or belong to steps that were made before.
std::size_t replayed(const Simulation& simulation);

}  // namespace stroma
