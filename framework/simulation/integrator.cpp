// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/integrator.h"

#include <algorithm>

#include "framework/scene/node.h"
#include "framework/scene/usual_component.h"
#include "framework/simulation/step_watch.h"

namespace stroma {

/// The solver for a scene that names none. An equilibrium is as ill-conditioned as the body is slender or stiff: what solves it
/// best depends on its size. The mass keeps the matrix of a step in time well-conditioned, and its products are cheap.
std::string Integrator::missingPartner() const {
  if (!needs_linear_solver_ || !linear_solver_.path.empty()) return {};
  const auto& components = node().components();
  const bool has_one = std::any_of(components.begin(), components.end(), [](const auto& component) {
    return dynamic_cast<const LinearSolver*>(component.get()) && component->answersLookup();
  });
  if (has_one) return {};
  return usualComponent(movesInTime() ? Part::solver_in_time : Part::solver_that_chooses);
}

StepWatch*& stepWatch() {
  static thread_local StepWatch* watch = nullptr;
  return watch;
}

}  // namespace stroma
