// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/stable_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "framework/scene/node.h"

namespace stroma {

void fillAtRandom(Rows rows) {
  std::uint64_t seed = 88172645463325252ull;
  for (Index i = 0; i < rows.count; ++i)
    for (int c = 0; c < 3; ++c) {
      seed = seed * 6364136223846793005ull + 1442695040888963407ull;
      rows[i][c] = double(seed >> 11) * 0x1p-53 - 0.5;
    }
}

namespace {

/// "element 12 of /beam/fem": where the strain of the motion p is largest; empty where no force field knows strains.
std::string mostStrained(const System& system, const Vector& p) {
  Vector moved(system.allRows());
  copy(system.x, moved);
  double farthest = 0, apart = 0;
  for (Index i = 0; i < p.count(); ++i) {
    farthest = std::max(farthest, Vec3(p[i]).norm());
    apart = std::max(apart, (Vec3(system.x[i]) - Vec3(system.x[0])).norm());
  }
  if (!(farthest > 0)) return {};
  const double small = 1e-6 * apart / farthest;  // strains by differences
  system.motion().advance(small, p, moved);
  for (const Mapping* mapping : system.actors().mappings) mapping->apply(moved);
  std::string name;
  double largest = 0;
  std::vector<double> before, after;
  for (const ForceField* field : system.forceFields()) {
    const auto fields = field->cellFields();
    if (std::find(fields.begin(), fields.end(), "strain") == fields.end()) continue;
    field->cellField("strain", system.x, before);
    field->cellField("strain", moved, after);
    for (std::size_t cell = 0; 6 * cell < after.size(); ++cell) {
      double square = 0;
      for (std::size_t k = 6 * cell; k < 6 * cell + 6; ++k) square += (after[k] - before[k]) * (after[k] - before[k]);
      if (square > largest) largest = square, name = fmt::format("element {} of {}", cell, field->path());
    }
  }
  return name;
}

/// Power iteration. With a = M^-1 K p, (a.Kp) / (p.Kp) is a Rayleigh quotient: never above the largest eigenvalue.
HighestFrequency byPowerIteration(System& system, Acceleration& acceleration) {
  Vector p(system.independentRows()), force(system.independentRows()), a(system.independentRows());
  StepReport report;
  fillAtRandom(p);
  system.constraints().project(p);
  double square = 0;
  for (int iteration = 0; iteration < 100; ++iteration) {
    system.matrix().withFactors({.stiffness = -1}).multiply(p, force);
    const double energy = dot(p, force);
    if (energy == 0 || !acceleration.solveForMomenta(system.x, force, a, {}, report)) break;
    const double before = square;
    square = std::abs(dot(a, force) / energy);
    if (std::abs(square - before) < 1e-4 * square) break;
    const double size = norm(a);
    if (!(size > 0)) break;
    copy(a, p);
    scale(1 / size, p);
  }
  return {std::sqrt(square), mostStrained(system, p)};
}

}  // namespace

HighestFrequency highestFrequency(System& system, Acceleration& acceleration) {
  const auto counts = system.counts;
  const auto times = system.times;
  system.computeForce(system.x, system.v, system.f);
  HighestFrequency highest = byPowerIteration(system, acceleration);
  clear(system.f);
  system.counts = counts;
  system.times = times;
  return highest;
}

void warnAboveStableStep(Integrator& integrator, System& system, Acceleration& acceleration, const std::string& method,
                         const StabilityLimit& limit) {
  const HighestFrequency highest = highestFrequency(system, acceleration);
  const double dt = system.node().dt();
  if (!(highest.value > 0) || dt * highest.value <= limit.largest_angle) return;
  const double largest = limit.largest_angle / highest.value;
  const std::string origin = fmt::format("the fastest motion has about {:.3g} rad/s{}{}", highest.value,
                                         highest.element.empty() ? "" : ", strongest in ", highest.element);
  integrator.warn(
      limit.grows
          ? fmt::format("with dt = {:g} s {} adds energy to fast motions, more than 1 % per step if they are undamped; up to {:.3g} "
                        "s it stays below that ({})",
                        dt, method, largest, origin)
          : fmt::format("dt = {:g} s is above the estimated stable step of {}, {:.3g} s ({})", dt, method, largest,
                        origin),
      fmt::format("dt=\"{:.2g}\", or an implicit integrator", 0.95 * largest));
}

}  // namespace stroma
