// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/units/plausible_units.h"

#include <algorithm>
#include <cmath>

namespace stroma {
namespace {

/// No organ is larger than this [m], and what is built so large bears its weight: it has far less than this strain.
constexpr double large_size = 10, heaviest_large = 1;
/// Only loose gels and cells are softer [Pa], and they are small: a body that is too heavy too has a wrong modulus.
constexpr double soft_modulus = 100;

/// A thousandth of the earth's gravity is a small load; but its own digits in a smaller unit of length were taken for those
/// of the unit.
constexpr double smallest_load = 0.01;
constexpr PlausibleRange digits_of_earths{9.5, 10.5, 9.81};

bool isPlausible(const WrittenBody& body, Quantity q, double factor) {
  const double value = body.value[q] * factor;
  if (q == body_modulus) return value >= plausible[q].low && body.softest * factor <= plausible[q].high;
  return plausible[q].has(value) ||
         (q == body_gravity && value >= smallest_load && value < plausible[q].low &&
          (factor == 1 || !digits_of_earths.has(body.value[q])));
}

/// What is not known is as usual.
double usualIfUnknown(const WrittenBody& body, const Factors& f, Quantity q) {
  return isKnown(body, q) ? body.value[q] * f[q] : plausible[q].typical;
}

}  // namespace

Factors factorsOf(const UnitSystem& s) {
  return {s.length, s.mass / (s.length * s.time * s.time), s.mass / std::pow(s.length, 3),
          s.length / (s.time * s.time)};
}

const std::vector<UnitSystem>& unitSystems() {
  static const std::vector<UnitSystem> systems{
      {"m, kg, s", 1, 1, 1},           {"mm, t, s", 1e-3, 1e3, 1},    {"mm, kg, s", 1e-3, 1, 1},
      {"mm, g, s", 1e-3, 1e-3, 1},     {"cm, g, s", 1e-2, 1e-3, 1},   {"cm, kg, s", 1e-2, 1, 1},
      {"mm, g, ms", 1e-3, 1e-3, 1e-3}, {"mm, kg, ms", 1e-3, 1, 1e-3}, {"um, kg, s", 1e-6, 1, 1}};
  return systems;
}

bool isKnown(const WrittenBody& body, Quantity q) { return q == body_modulus || body.value[q] > 0; }

double weightOf(const WrittenBody& body, const Factors& f) {
  double weight = body.value[body_size] * f[body_size] / (body.value[body_modulus] * f[body_modulus]);
  for (const Quantity q : {body_density, body_gravity}) weight *= usualIfUnknown(body, f, q);
  return weight;
}

Faults faultsOf(const WrittenBody& body, const Factors& factors) {
  Faults faults;
  for (const Quantity q : body_quantities)
    if (isKnown(body, q) && !isPlausible(body, q, factors[q])) faults.out.push_back(q);
  const double weight = weightOf(body, factors);
  const bool bears_weight = isKnown(body, body_density) && isKnown(body, body_gravity);
  const bool too_large = body.value[body_size] * factors[body_size] > large_size && weight > heaviest_large;
  faults.too_heavy = too_large || (bears_weight && weight > heaviest);
  if (too_large) faults.suspect.push_back(body_size);
  if (faults.too_heavy && body.value[body_modulus] * factors[body_modulus] < soft_modulus)
    faults.suspect.push_back(body_modulus);
  return faults;
}

bool isWithoutDimensions(const WrittenBody& body) {
  const auto isOne = [&body](Quantity q) { return std::abs(body.value[q] - 1) < 1e-6; };
  return isOne(body_density) &&
         (isOne(body_gravity) || isOne(body_modulus) || body.value[body_gravity] < plausible[body_gravity].low);
}

}  // namespace stroma
