// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/simulation/observer.h"
#include "framework/simulation/simulation.h"
#include "framework/simulation/step_guard.h"

namespace stroma {

/// Removes observers that write files; those that may reject a step stay.
inline void dropReaders(Simulation& simulation) {
  const std::vector<Observer*> all = simulation.observers();
  for (Observer* observer : all)
    if (!dynamic_cast<StepGuard*>(observer)) simulation.removeObserver(*observer);
}

}  // namespace stroma
