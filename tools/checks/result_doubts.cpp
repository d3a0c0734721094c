// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/checks/result_doubts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "framework/mechanics/state_positions.h"
#include "framework/mechanics/state_topology.h"
#include "framework/simulation/mesh_changer.h"
#include "framework/simulation/step_guard.h"
#include "tools/checks/folds.h"
#include "tools/checks/other_rest.h"
#include "tools/units/unit_system.h"

namespace stroma {
namespace {

/// How many elements of a force field have no volume left at x, and of how many.
CellCount foldedCount(const ForceField& field, ConstRows x) {
  // what a tissue is never pressed to; where a law has no volume left, a solve ends somewhat before
  constexpr double flat = 1e-4;
  const auto names = field.cellFields();
  if (std::find(names.begin(), names.end(), "J") == names.end()) return {};
  std::vector<double> j;
  field.cellField("J", x, j);
  const auto folded = std::count_if(j.begin(), j.end(), [](double value) { return !(value > flat); });
  return {std::size_t(folded), j.size()};
}

/// The same in words with the worst element, or empty.
std::string foldedElements(const ForceField& field, ConstRows x) {
  const auto [folded, all] = foldedCount(field, x);
  if (folded == 0) return {};
  return fmt::format("{} of {} elements are inverted or flat; the worst is {}", folded, all, field.worstElement(x));
}

/// A sentence for each constraint by which nodes follow others that do not feel it, as long as that takes a force: f, less
/// what the nodes' acceleration since `v_before` takes.
std::vector<std::string> unansweredForces(const System& system, ConstRows v_before, double dt, double time) {
  std::vector<std::string> sentences;
  std::vector<Index> rows;
  for (const ProjectiveConstraint* constraint : system.constraints().all()) {
    rows.clear();
    constraint->addUnansweredRows(rows);
    if (rows.empty()) continue;
    Vector force(system.independentRows());
    copy(system.independent(system.f), force);
    if (system.integrator().movesInTime()) {
      Vector acceleration(system.independentRows());
      copy(system.independent(system.v), acceleration);
      axpy(-1, system.independent(v_before), acceleration);
      scale(1 / dt, acceleration);
      system.addMassProduct(acceleration, -1, force);
    }
    Vec3 sum = Vec3::Zero();
    double sizes = 0;
    for (const Index row : rows)
      if (system.motion().kindOf(row) == RowKind::place) {
        sum += Vec3(force[row]);
        sizes += Vec3(force[row]).norm();
      }
    if (sum.norm() <= 1e-9 * sizes) continue;
    sentences.push_back(fmt::format(
        "{} at t = {:.6g} s: the following nodes pull with ({:.3g} {:.3g} {:.3g}) N, in sum {:.3g} N, which is not transmitted to "
        "the nodes that they follow: this force is missing",
        constraint->path(), time, sum[0], sum[1], sum[2], sum.norm()));
  }
  return sentences;
}

/// Why a force that is a step late and an integrator do not go together, or empty.
std::string laggedForce(const ForceField& field, const Integrator& integrator) {
  if (!field.traits().lagged || integrator.toleratesLaggedForces()) return {};
  return fmt::format(
      "{} lags by one step, and {} hardly damps the motion that this excites: it may oscillate forever. Use a coupling without lag, "
      "or EulerImplicitSolver",
      field.path(), integrator.path());
}

/// Motions much faster than the step keep their velocity but for its sign, for ever or nearly so: a physical viscosity
/// does not damp them either, because rules without damping of their own take it for a change of sign too.
std::string reversals(const Simulation& simulation, std::size_t index) {
  if (!simulation.watch().isReversing(index)) return {};
  return fmt::format(
      "{} at t = {:.6g} s: velocities change sign from step to step, or every other step. dt = {:.6g} s is far above the period of "
      "the fastest motions, which this rule does not damp: the positions are a mean at best. Use a smaller dt, EulerImplicitSolver "
      "or BDFOdeSolver",
      simulation.systems()[index]->integrator().path(), simulation.time(), simulation.dt());
}

/// More than half of the energy that moves about has no source. Bodies that are moved, or met by position constraints,
/// may have got it there.
std::string gainedEnergy(const Simulation& simulation, std::size_t index) {
  const System& system = *simulation.systems()[index];
  if (simulation.watch().isWorkedOn() || !system.integrator().keepsEnergy() || !system.isConservative() ||
      !system.actors().position_constraints.empty())
    return {};
  for (const ForceField* field : system.forceFields())
    if (field->traits().time_dependent) return {};
  for (const ProjectiveConstraint* constraint : system.constraints().all())
    if (constraint->prescribesMotion()) return {};
  const auto& [x, v] = simulation.snapshots().start(index);
  const double kinetic_start = system.kineticEnergy(v), potential_start = system.potentialEnergy(x);
  const double kinetic = system.kineticEnergy(), potential = system.potentialEnergy(system.x);
  const double gained = kinetic + potential - kinetic_start - potential_start;
  const double moved = kinetic + kinetic_start + std::abs(potential - potential_start);
  const double round_off = 1e-9 * (std::abs(potential) + std::abs(potential_start));
  if (!(gained > moved / 2 && gained > round_off)) return {};
  return fmt::format(
      "{} has gained {:.3g} J by t = {:.6g} s without any work done on it, as undamped rules may with large steps. Use a smaller "
      "dt, or EulerImplicitSolver",
      system.integrator().path(), gained, simulation.time());
}

}  // namespace

std::vector<std::string> doubtsOf(const Simulation& simulation) {
  simulation.complete();
  std::vector<std::string> sentences;
  const UnitSystem units = unitsOf(simulation.scene());
  const auto say = [&](const std::string& sentence) {
    if (!sentence.empty()) sentences.push_back(units.sentence(sentence));
  };
  const double time = simulation.time();
  for (std::size_t i = 0; i < simulation.systems().size(); ++i) {
    const System& system = *simulation.systems()[i];
    std::set<const State*> folded_states;
    for (const ForceField* field : system.forceFields()) {
      const std::string where = fmt::format("{} at t = {:.6g} s: ", field->path(), time);
      if (const std::string folded = foldedElements(*field, system.x); !folded.empty())
        say(where + folded), folded_states.insert(&field->state());
      else if (const std::string beyond = field->doubt(system.x); !beyond.empty())
        say(where + beyond);
      if (simulation.steps() > 0 && movesVisibly(system, simulation.dt()))
        say(laggedForce(*field, system.integrator()));
    }
    // what force fields do not look at: springs and shape memory know no volumes, and a point inside a cell not its
    // corners
    for (const State* state : system.states()) {
      if (folded_states.count(state) > 0) continue;
      const std::vector<Vec3> now = positionsOf(*state, system.x);
      if (now == state->rest_position) continue;  // nothing has moved: large scenes start without a look at their cells
      for (const Topology* topology : topologiesOf(*state))
        if (const std::string folds = foldsOf(topology->mesh(), state->rest_position, now); !folds.empty())
          say(fmt::format("{} at t = {:.6g} s: {}", topology->path(), time, folds));
    }
    for (std::string& sentence : grownBodies(system)) say(sentence);
    // mapped nodes are placed after the last look at a step
    if (const std::string fault = FaultWatch(system).firstFault(system.x); !fault.empty())
      say(fmt::format("at t = {:.6g} s: {}", time, fault));
    if (simulation.steps() > 0 && system.counts.forces > 0)
      for (std::string& sentence :
           unansweredForces(system, simulation.snapshots().good(i).v, simulation.dt(), simulation.time()))
        say(sentence);
    say(system.integrator().doubt());
    say(gainedEnergy(simulation, i));
    say(otherRest(simulation, i));
    say(reversals(simulation, i));
  }
  return sentences;
}

std::vector<std::string> refusedFromHere(const Simulation& simulation) {
  std::vector<std::string> sentences;
  if (simulation.steps() == 0) return sentences;
  simulation.complete();
  const UnitSystem units = unitsOf(simulation.scene());
  const double time = simulation.time(), dt = simulation.dt();
  const StepContext next{.index = simulation.steps() + 1, .t = time, .dt = dt, .t_end = time + dt};
  for (Observer* observer : simulation.observers())
    if (auto* guard = dynamic_cast<MeshChanger*>(observer) ? nullptr : dynamic_cast<StepGuard*>(observer))
      if (const std::string why = guard->refusal(next); !why.empty())
        sentences.push_back(
            units.sentence(fmt::format("{} at t = {:.6g} s: another step would be rejected. {}", observer->path(), time, why)));
  return sentences;
}

/// Several force fields and meshes may describe one body: it is as bad as the worst of them says.
CellCount invertedCells(const Simulation& simulation) {
  simulation.complete();
  CellCount sum;
  const auto share = [](const CellCount& count) { return count.all ? double(count.inverted) / double(count.all) : -1; };
  for (const auto& system : simulation.systems())
    for (const State* state : system->states()) {
      CellCount worst;
      const auto look = [&](const CellCount& count) {
        if (share(count) > share(worst)) worst = count;
      };
      for (const ForceField* field : system->forceFields())
        if (&field->state() == state) look(foldedCount(*field, system->x));
      const std::vector<Vec3> now = positionsOf(*state, system->x);
      for (const Topology* topology : topologiesOf(*state)) {
        const auto [inverted, all] = insideOutCells(topology->mesh(), state->rest_position, now);
        look({inverted, all});
      }
      sum.inverted += worst.inverted, sum.all += worst.all;
    }
  return sum;
}

void warnOfLaggedForces(const Simulation& simulation, Diagnostics& diagnostics) {
  for (const auto& system : simulation.systems())
    for (const ForceField* field : system->forceFields())
      if (std::string sentence = laggedForce(*field, system->integrator()); !sentence.empty())
        diagnostics.warning(field->where(), field->path(), std::move(sentence));
}

}  // namespace stroma
