// SPDX-License-Identifier: LGPL-2.1-or-later
// Positions and velocities that a program writes between two steps.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "framework/simulation/integrator.h"
#include "framework/simulation/simulation.h"
#include "framework/simulation/step_limits.h"

namespace stroma {
namespace {

System& systemOf(const State& state, const Systems& systems) {
  for (const auto& system : systems) {
    const auto& own = system->states();
    if (std::find(own.begin(), own.end(), &state) == own.end()) continue;
    if (state.firstRow() >= system->independentRows())
      throw ComponentError(
          fmt::format("{} cannot be set: its positions follow from another state by a mapping", state.path()),
          "the state that is mapped from");
    if (system->integrator().stateOwner())
      throw ComponentError(fmt::format("{} cannot be set: {} moves it by a matrix that was computed beforehand",
                                       state.path(), system->integrator().path()),
                           "an integrator that makes its matrix in steps");
    return *system;
  }
  throw ComponentError(fmt::format("no integrator moves {}", state.path()));
}

void copyRow(const double* from, Rows to, Index row) {
  std::copy_n(from, row_doubles, to.data + std::size_t(row) * row_doubles);
}

/// A row of positions, or else of velocities, as the engine has it.
void takeRow(const State& state, Index i, bool of_positions, ConstRows given, Rows out) {
  double row[row_doubles];
  std::copy_n(given.data + std::size_t(i) * row_doubles, row_doubles, row);
  const RowKind kind = state.kindOf(i);
  const bool has_four = of_positions && kind == RowKind::turn;
  if (!std::all_of(row, row + (has_four ? 4 : 3), [](double number) { return std::isfinite(number); }))
    throw ComponentError(fmt::format("row {} of what {} is to become is not finite", i, state.path()), "finite numbers");
  if (!has_four) row[3] = 0;
  if (kind == RowKind::value) row[1] = row[2] = 0;
  if (has_four) {
    const double norm2 = row[0] * row[0] + row[1] * row[1] + row[2] * row[2] + row[3] * row[3];
    if (!(std::abs(norm2 - 1) < 1e-6))
      throw ComponentError(fmt::format("the orientation in row {} of {} has the length {:g}", i, state.path(), std::sqrt(norm2)),
                           "a unit quaternion x y z w");
    const double factor = 1 / (std::abs(norm2 - 1) > 1e-12 ? std::sqrt(norm2) : 1);
    for (double& number : row) number *= factor;
  }
  copyRow(row, out, state.firstRow() + i);
}

/// Moves the independent rows of `present` to `wanted` as far as constraints let them; a row that nothing keeps gets the
/// bits that are wanted. `kept[i]` of each row of the state that is kept becomes true.
void moveFreely(const System& system, const State& state, bool of_positions, const Vector& wanted, Vector& present,
                std::vector<bool>& kept) {
  Vector way(system.allRows()), free(system.allRows());
  copy(present, way);
  if (of_positions) {
    system.motion().difference(wanted, way);
  } else {
    xpay(wanted, -1, way);
  }
  copy(way, free);
  system.constraints().project(system.independent(free));
  if (of_positions) {
    system.motion().advance(1, system.independent(free), present);
  } else {
    axpy(1, system.independent(free), system.independent(present));
  }
  for (Index row = 0; row < system.independentRows(); ++row) {
    const bool is_free = Vec3(free[row]) == Vec3(way[row]);
    if (is_free) copyRow(wanted.rows().data + std::size_t(row) * row_doubles, present, row);
    const Index own = row - state.firstRow();
    if (!is_free && own >= 0 && own < state.size()) kept[std::size_t(own)] = true;
  }
}

}  // namespace

Index Simulation::setState(const State& state, ConstRows x, ConstRows v) {
  if (stepping_)
    throw ComponentError(fmt::format("{} cannot be set in the middle of a step", state.path()), "a moment between two steps");
  System& system = systemOf(state, systems_);
  for (const ConstRows& given : {x, v})
    if (given.data && given.count != state.size())
      throw ComponentError(fmt::format("{} rows for {}", given.count, state.path()), fmt::format("{} rows", state.size()));
  Vector wanted_x(system.allRows()), wanted_v(system.allRows());
  copy(system.x, wanted_x), copy(system.v, wanted_v);
  for (Index i = 0; i < state.size(); ++i) {
    if (x.data) takeRow(state, i, true, x, wanted_x);
    if (v.data) takeRow(state, i, false, v, wanted_v);
  }
  Snapshot before(system.allRows());
  before.take(system);
  std::vector<bool> kept(std::size_t(state.size()), false);
  if (x.data) moveFreely(system, state, true, wanted_x, system.x, kept);
  if (v.data) moveFreely(system, state, false, wanted_v, system.v, kept);
  system.applyMappings();
  if (const std::string overlap = overlapIn(system); !overlap.empty()) {
    before.putBack(system);
    throw ComponentError(fmt::format("{} keeps its positions: {}", state.path(), overlap), "places without an overlap");
  }
  system.integrator().reset();
  system.integrator().sceneChanged();
  if (LinearSolver* solver = system.linearSolver()) solver->reset();
  watch_.noteWork();
  const auto same = [&](const RunEvent& event) {
    const auto* change = std::get_if<StateChange>(&event.what);
    return change && event.step == steps() && change->state == state.path();
  };
  if (log_.events().empty() || !same(log_.events().back())) log_.record(steps(), StateChange{state.path()});
  return Index(std::count(kept.begin(), kept.end(), true));
}

}  // namespace stroma
