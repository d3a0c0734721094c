// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/run_watch.h"

#include <algorithm>
#include <cmath>

#include "framework/mechanics/state_positions.h"

namespace stroma {
namespace {

/// Steps from one look at reversed velocities to the next: a look costs six dot products.
constexpr long look_every = 8;

}  // namespace

void RunWatch::compile(const Systems& systems) { reversals_.resize(systems.size()); }

void RunWatch::reset() {
  reversals_.assign(reversals_.size(), {});
  worked_on_ = false;
}

void RunWatch::look(std::size_t index, const System& system, const Snapshot& before, const StepContext& context) {
  if (context.index % look_every > 1) return;
  const Vector &now = system.v, &then = before.v;
  const bool turned =
      dot(now, then) < -0.5 * std::sqrt(dot(now, now) * dot(then, then)) && movesVisibly(system, context.dt);
  Reversals& reversals = reversals_[index];
  if (context.index % look_every == 0) {
    reversals.turned = turned;
    return;
  }
  reversals.in_a_row = turned || reversals.turned ? reversals.in_a_row + 1 : 0;
}

void RunWatch::serialize(std::size_t index, Archive& archive) {
  archive.value("turned", reversals_[index].turned);
  archive.value("in_a_row", reversals_[index].in_a_row);
}

bool movesVisibly(const System& system, double dt) {
  constexpr double visible = 1e-7;
  double size = 0;
  for (const State* state : system.states()) size = std::max(size, restSize(*state));
  return std::sqrt(dot(system.v, system.v) / std::max<Index>(1, system.allRows())) * dt > visible * size;
}

}  // namespace stroma
