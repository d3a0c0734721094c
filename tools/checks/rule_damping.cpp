// SPDX-License-Identifier: LGPL-2.1-or-later
// Backward Euler multiplies a swing of frequency w by (1 + w^2 h^2)^(-1/2) in each step and turns its phase by
// atan(w h). Rayleigh's quotient of the velocities is the w of the present motion: w^2 = -v K v / v M v.
#include "tools/checks/rule_damping.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "framework/simulation/integrator.h"
#include "tools/units/unit_system.h"

namespace stroma {
namespace {

double valueOf(const Component& component, const char* attribute) {
  const Data* data = component.data().find(attribute);
  const auto* value = data ? std::get_if<double*>(&data->pointer()) : nullptr;
  return value ? **value : 0;
}

bool isBackwardEuler(const Integrator& integrator) {
  const Data* first_order = integrator.data().find("firstOrder");
  return integrator.type() == "EulerImplicitSolver" && !integrator.keepsEnergy() && first_order && first_order->print() == "false";
}

/// By the scene's word.
bool solvesOnce(const Integrator& integrator) {
  const Data* iterations = integrator.data().find("newtonIterations");
  return iterations && iterations->print() == "1";
}

/// Contact, by barriers or by pairs of where the step started: it pushes by where others are, not by the way of the body.
bool isContact(const ForceField* field) {
  const ForceTraits traits = field->traits();
  return traits.undamped || (traits.lagged && !traits.time_dependent);
}

/// 0 where nothing moves, or what moves meets no stiffness.
double frequency(const System& system) {
  Vector product(system.independentRows());
  clear(product);
  system.addStiffnessProduct(system.independent(system.v), {.stiffness = -1}, product);
  const double stored = dot(system.independent(system.v), product), kinetic = system.kineticEnergy();
  return stored > 0 && kinetic > 0 ? std::sqrt(stored / (2 * kinetic)) : 0;
}

/// The sentence, or empty.
std::string dampedSwing(const System& system, double dt, double time, long steps) {
  constexpr double worth_saying = 0.03, largest_turn = 1;  // with fewer than six steps in it there is no swing to be seen
  constexpr double small_share = 0.1;
  const Integrator& integrator = system.integrator();
  if (!isBackwardEuler(integrator) || system.counts.forces == 0 || !movesVisibly(system, dt)) return {};
  const auto& fields = system.forceFields();
  const auto pushes = [](const ForceField* field) { return isContact(field) && field->acts(); };
  if (system.constraints().hasPrescribed() || std::any_of(fields.begin(), fields.end(), pushes)) return {};  // driven: no swing
  const double w = frequency(system), turn = w * dt;
  const bool has_swung = turn * double(steps) > std::numbers::pi;
  if (!(turn > 0 && turn < largest_turn && has_swung)) return {};
  const double loss = 1 - std::pow(1 + turn * turn, -std::numbers::pi / std::atan(turn));
  const double asked_for = valueOf(integrator, "rayleighStiffness") + valueOf(integrator, "rayleighMass") / (w * w);
  if (loss < worth_saying || dt < small_share * asked_for) return {};
  return fmt::format(
      "{} at t = {:.6g} s: the integrator has numerical damping. An oscillation with the current period of {:.3g} s loses {:.0f} % "
      "of its amplitude per period with dt = {:.4g} s. Use a smaller dt to reduce this; NewmarkImplicitSolver or "
      "trapezoidalScheme=\"true\" avoid it{}",
      integrator.path(), time, 2 * std::numbers::pi / w, 100 * loss, dt,
      solvesOnce(integrator) ? ", with newtonIterations=\"2\"" : "");
}

/// Rayleigh's quotient of the way u that a body has gone to where it rests is that of its slowest swing, where a weight has
/// bent it: w^2 = u K u / u M u, and u K u is twice the potential energy that is lost.
double frequencyOfWay(const System& system, ConstRows start) {
  const ConstRows x = system.independent(system.x);
  Vector way(x.count), product(x.count);
  copy(system.independent(start), way);
  system.motion().difference(x, way);
  clear(product);
  system.addMassProduct(way, 1, product);
  const double lost = system.potentialEnergy(start) - system.potentialEnergy(system.x), moved = dot(way, product);
  return lost > 0 && moved > 0 ? std::sqrt(2 * lost / moved) : 0;
}

/// The sentence on steps that no swing is seen in, or empty.
std::string skippedSwings(const System& system, ConstRows start, double dt) {
  constexpr double few = 3;  // periods in a step
  if (!isBackwardEuler(system.integrator()) || system.counts.forces == 0 || system.constraints().hasPrescribed()) return {};
  const auto& fields = system.forceFields();
  if (std::any_of(fields.begin(), fields.end(), isContact)) return {};
  const double periods = frequencyOfWay(system, start) * dt / (2 * std::numbers::pi);
  if (!(periods > few)) return {};
  return fmt::format(
      "{}: a step of {:.4g} s is {:.2g} periods of the slowest oscillation, of {:.3g} s: the result is the rest position, not the "
      "motion. StaticSolver finds it directly; the motion needs dt = {:.1g} s or less",
      system.integrator().path(), dt, periods, dt / periods, dt / periods / 20);
}

}  // namespace

std::vector<std::string> dampedSwings(const Simulation& simulation) {
  std::vector<std::string> sentences;
  if (simulation.steps() == 0) return sentences;
  simulation.complete();
  const UnitSystem units = unitsOf(simulation.scene());
  for (std::size_t i = 0; i < simulation.systems().size(); ++i) {
    const System& system = *simulation.systems()[i];
    const auto say = [&](const std::string& sentence) {
      if (!sentence.empty()) sentences.push_back(units.sentence(sentence));
    };
    say(dampedSwing(system, simulation.dt(), simulation.time(), simulation.steps()));
    say(skippedSwings(system, simulation.snapshots().start(i).x, simulation.dt()));
  }
  return sentences;
}

}  // namespace stroma
