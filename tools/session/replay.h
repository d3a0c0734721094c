// SPDX-License-Identifier: LGPL-2.1-or-later
// Replays the recorded events of a run.
#pragma once
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"

namespace stroma {

/// A replayed event was rejected: a message with its location. The step after it was not made.
class ReplayError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Schedules these events, each before its original step; events of steps already made are skipped. Ascending in
/// `step`. Simulation::reset() starts them again, with the present edits. `file`: their source, for messages.
/// Throws SceneError for errors that can be detected now; Simulation::step() throws ReplayError for the rest.
void replay(Simulation& simulation, std::vector<RunEvent> events, const std::string& file = {});

/// The number of events applied, or skipped because their steps had already been made.
std::size_t replayed(const Simulation& simulation);

}  // namespace stroma
