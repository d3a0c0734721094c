// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/checks/other_rest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace stroma {
namespace {

/// A load without an energy may act; a body whose own forces have none cannot be compared.
bool canBeCompared(const ForceField& field) {
  const ForceTraits traits = field.traits();
  const bool inner = traits.forces_balance || traits.has_rest_shape;
  return (traits.conservative || !inner) && !traits.time_dependent && !traits.lagged && !traits.decided_outside;
}

/// By more than 90 degrees: what follows a body does another work then than held as it is. A couple that has bent a beam by
/// 109 degrees and more would have done less, held, than the beam has taken.
bool hasTurned(const System& system, ForceField& load, ConstRows rest) {
  Vector now(system.allRows()), at_rest(system.allRows());
  clear(now), clear(at_rest);
  load.addForce(system.mappingChain().positions(rest), system.v, at_rest);
  load.addForce(system.mappingChain().positions(system.x), system.v, now);  // last: what it remembers is of the present
  return dot(now, at_rest) < 0;
}

bool isDriven(const Simulation& simulation, const System& system) {
  if (simulation.watch().isWorkedOn() || system.inputs() || system.integrator().stateOwner()) return true;
  if (!system.actors().position_constraints.empty() || !system.actors().lagrangian_constraints.empty()) return true;
  const auto& constraints = system.constraints().all();
  return std::any_of(constraints.begin(), constraints.end(), [](const auto* one) { return one->prescribesMotion(); });
}

double longest(ConstRows rows) {
  double most = 0;
  for (Index i = 0; i < rows.count; ++i) most = std::max(most, Vec3(rows[i]).norm());
  return most;
}

/// X - x of the independent rows.
void takeWay(const System& system, Rows way) {
  for (const State* state : system.states())
    for (Index i = 0; i < state->size() && state->firstRow() + i < way.count; ++i) {
      const Index row = state->firstRow() + i;
      way[row] = state->rest_position[std::size_t(i)] - Vec3(system.x[row]);
    }
}

/// What each force field has, and gravity last, at x.
std::vector<double> energies(const System& system, ConstRows x) {
  std::vector<double> out;
  const ConstRows all = system.mappingChain().positions(x);
  for (const ForceField* field : system.forceFields())
    out.push_back(field->traits().conservative ? field->energy(all) : 0);
  out.push_back(system.gravityEnergy(x));
  return out;
}

std::string placeOf(const ForceField& field, ConstRows x) {
  const std::string worst = field.worstElement(x);
  return fmt::format("in {}{}{}", field.path(), worst.empty() ? "" : "; the worst is ", worst);
}

double sum(const std::vector<double>& parts) {
  double all = 0;
  for (const double part : parts) all += part;
  return all;
}

}  // namespace

std::string otherRest(const Simulation& simulation, std::size_t index) {
  const System& system = *simulation.systems()[index];
  const auto& fields = system.forceFields();
  if (fields.empty() || simulation.steps() == 0 || system.motion().turns() || isDriven(simulation, system)) return {};
  if (!std::all_of(fields.begin(), fields.end(), [](const auto* field) { return canBeCompared(*field); })) return {};

  Vector way(system.independentRows()), free(system.independentRows()), x(system.independentRows());
  takeWay(system, way);
  const double length = longest(way);
  if (length == 0) return {};
  if (system.integrator().movesInTime() && longest(system.independent(system.v)) * simulation.dt() > 1e-6 * length)
    return {};
  copy(way, free);
  system.constraints().project(free);
  axpy(-1, way, free);
  if (longest(free) > 1e-9 * length) return {};

  const auto at = [&](double s) {
    copy(system.independent(system.x), x);
    axpy(s, way, x);
    return energies(system, x);
  };
  constexpr double share = 1e-4;  // of the way, for the derivative along it
  const std::vector<double> rest = at(1);
  const double slope = (sum(at(share)) - sum(at(-share))) / (2 * share);
  const std::vector<double> now = at(0);  // last: mappings that remember where they were are back in the present
  double sizes = 0, excess = 0;
  std::size_t most = 0;
  for (std::size_t k = 0; k < now.size(); ++k) {
    const double more = now[k] - rest[k];
    sizes += std::abs(more), excess += more;
    if (more > now[most] - rest[most]) most = k;
  }
  const bool has_energy = system.isConservative();
  if (!has_energy) excess += slope;
  if (!(excess > 1e-3 * sizes) || (has_energy && std::abs(slope) > 0.01 * excess)) return {};
  copy(system.independent(system.x), x);
  axpy(1, way, x);
  const auto turned = [&](ForceField* field) { return !field->traits().conservative && hasTurned(system, *field, x); };
  if (std::any_of(fields.begin(), fields.end(), turned)) return {};
  return fmt::format(
      "{} at t = {:.6g} s: at rest with {:.3g} J more than the rest shape under the same loads: the body may have folded, or "
      "snapped to another equilibrium. Most of the energy is {}",
      system.integrator().path(), simulation.time(), excess,
      most == fields.size() ? "the energy of gravity" : placeOf(*fields[most], system.x));
}

}  // namespace stroma
