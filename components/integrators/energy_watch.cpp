// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/energy_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace stroma {
namespace {

/// Steps from one look to the next, after the first ones: a look costs a product with the mass.
constexpr long look_every = 8, looked_at_first = 64;

bool isAlone(const System& system) {
  if (system.inputs() || !system.actors().position_constraints.empty() || !system.actors().lagrangian_constraints.empty())
    return false;
  const auto& constraints = system.constraints().all();
  if (std::any_of(constraints.begin(), constraints.end(), [](const auto* one) { return one->prescribesMotion(); })) return false;
  const auto& fields = system.forceFields();
  return std::all_of(fields.begin(), fields.end(), [](const ForceField* field) {
    const ForceTraits traits = field->traits();
    return (traits.conservative || traits.forces_balance) && !traits.time_dependent && !traits.lagged && !traits.decided_outside;
  });
}

}  // namespace

/// The kinetic energy [J] of a motion by round-off: a billionth of the system's extent per step.
double EnergyWatch::noise() const {
  Vector slow(system_->allRows());
  clear(slow);
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  const auto isPlace = [this](Index row) { return system_->motion().kindOf(row) == RowKind::place; };
  for (Index i = 0; i < system_->independentRows(); ++i)
    if (isPlace(i)) low = low.cwiseMin(Vec3(system_->x[i])), high = high.cwiseMax(Vec3(system_->x[i]));
  const double speed = 1e-9 * (high - low).norm() / system_->node().dt();
  for (Index i = 0; i < system_->independentRows(); ++i)
    if (isPlace(i)) slow[i] = Vec3(speed, 0, 0);
  return system_->kineticEnergy(slow);
}

void EnergyWatch::compile(const System& system, bool wanted) { system_ = wanted && isAlone(system) ? &system : nullptr; }

void EnergyWatch::stepBegins() {
  if (system_ && taken_ == 0) begun_ = energy(), most_kinetic_ = system_->kineticEnergy();
}

void EnergyWatch::stepTaken() {
  if (!system_) return;
  if (taken_ == 0) start_ = begun_;
  if (++taken_ % look_every == 0 || taken_ <= looked_at_first) most_kinetic_ = std::max(most_kinetic_, system_->kineticEnergy());
  if (std::has_single_bit(std::uint64_t(taken_))) early_ = std::exchange(recent_, most_kinetic_);
}

/// Where it is more than round-off, else 0.
double EnergyWatch::gainedSinceStart() const {
  constexpr double round_off = 1e-9;
  const double gained = energy() - start_;
  if (!std::isfinite(gained) || !std::isfinite(most_kinetic_)) return std::numeric_limits<double>::infinity();
  return gained > round_off * std::abs(system_->potentialEnergy(system_->x)) && gained > noise() ? gained : 0;
}

double EnergyWatch::gained(double usual) const {
  if (!system_ || taken_ < 2 * look_every) return 0;
  const double gained = gainedSinceStart();
  return gained > usual * most_kinetic_ ? gained : 0;
}

/// With velocities v of the middle of steps, an oscillator of angular frequency w keeps E - h v k x / 2 [J], and its energy E goes up and
/// down with the ratio (2 + h w) / (2 - h w): 39 at 0.95 of the longest step. What grows beyond that longest step does so without end.
/// It is many times what it was in the first half of the steps.
std::string EnergyWatch::doubtOfSteps(const std::string& path, bool of_middle) const {
  constexpr double usual = 0.5, many = 100;
  constexpr long fewest = 4;
  if (!system_ || taken_ < fewest) return {};
  const double energy = gainedSinceStart();
  if (!std::isfinite(energy)) return fmt::format("the energy of {} is no finite number any more: its steps are too long", path);
  const bool has_grown = energy > usual * most_kinetic_ && energy > many * early_;
  if (energy == 0 || !(has_grown || (!of_middle && gained(usual) > 0))) return {};
  return fmt::format("{} has gained {:.3g} J with no work done on it: its steps are too long for the fastest motion, or its rule gains "
                     "energy at any step. A smaller dt, or an implicit integrator",
                     path, energy);
}

}  // namespace stroma
