// SPDX-License-Identifier: LGPL-2.1-or-later
// Whether the numbers of a scene can belong together. They need not be SI: each consistent system of units is tried.
#include "framework/simulation/unit_doubts.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "framework/simulation/written_bodies.h"

namespace stroma {
namespace {

// ---- what is plausible ----

/// In SI: bodies from a cell to a room, gels to diamond, foam to osmium, gravity of small moons to that of a centrifuge.
struct Range {
  double low, high, typical;
  bool has(double value) const { return value >= low && value <= high; }
};
constexpr Range ranges[] = {{1e-5, 10, 0.1}, {10, 1e12, 1e4}, {10, 25000, 1000}, {0.1, 500, 9.81}};
/// Of the weight of a body over its stiffness, density * gravity * size / modulus: what it keeps its shape with.
constexpr double heaviest = 30;

/// What a number of the scene is in SI.
using Factors = std::array<double, quantities.size()>;

double weightOf(const WrittenBody& body, const Factors& f) {
  return body.value[body_density] * f[body_density] * body.value[body_gravity] * f[body_gravity] *
         body.value[body_size] * f[body_size] / (body.value[body_modulus] * f[body_modulus]);
}

/// The quantities that are out of their range, and whether the body is too heavy for its stiffness.
struct Faults {
  std::vector<Quantity> out;
  bool too_heavy = false;
  std::size_t count() const { return out.empty() && too_heavy ? 1 : out.size(); }
};

Faults faultsOf(const WrittenBody& body, const Factors& factors) {
  Faults faults;
  for (const Quantity q : quantities) {
    const double value = body.value[q] * factors[q];
    if (q == body_gravity && value == 0) continue;
    const bool good = q == body_modulus ? value >= ranges[q].low && body.softest * factors[q] <= ranges[q].high
                                        : ranges[q].has(value);
    if (!good) faults.out.push_back(q);
  }
  faults.too_heavy = weightOf(body, factors) > heaviest;
  return faults;
}

/// A consistent system of units.
struct UnitSystem {
  const char* name;
  double length, mass, time;

  Factors factors() const {
    return {length, mass / (length * time * time), mass / std::pow(length, 3), length / (time * time)};
  }
};
const UnitSystem systems[] = {
    {"m, kg, s", 1, 1, 1},           {"mm, t, s", 1e-3, 1e3, 1},    {"mm, kg, s", 1e-3, 1, 1},
    {"mm, g, s", 1e-3, 1e-3, 1},     {"cm, g, s", 1e-2, 1e-3, 1},   {"cm, kg, s", 1e-2, 1, 1},
    {"mm, g, ms", 1e-3, 1e-3, 1e-3}, {"mm, kg, ms", 1e-3, 1, 1e-3}, {"um, kg, s", 1e-6, 1, 1}};

std::size_t systemsToTry(bool has_units) { return has_units ? 1 : std::size(systems); }

// ---- what would mend it ----

struct UnitChoice {
  const char* unit;
  double factor;
};
constexpr UnitChoice lengths[] = {{"m", 1}, {"mm", 1e-3}, {"cm", 1e-2}, {"um", 1e-6}},
                     moduli[] = {{"Pa", 1}, {"kPa", 1e3}, {"MPa", 1e6}, {"GPa", 1e9}},
                     densities[] = {{"kg/m^3", 1},
                                    {"g/cm^3", 1e3},
                                    {"g/mm^3", 1e6},
                                    {"kg/mm^3", 1e9},
                                    {"t/mm^3", 1e12}},
                     masses[] = {{"kg", 1}, {"g", 1e-3}, {"t", 1e3}},
                     gravities[] = {{"m/s^2", 1}, {"mm/s^2", 1e-3}, {"cm/s^2", 1e-2}};

/// A unit for each quantity in which the body is plausible.
struct Remedy {
  std::array<UnitChoice, quantities.size()> units;
  double cost = std::numeric_limits<double>::infinity();
  bool isFound() const { return std::isfinite(cost); }
  std::size_t changes() const {
    return std::size_t(std::count_if(units.begin(), units.end(), [](const UnitChoice& u) { return u.factor != 1; }));
  }
};

/// Few changes and usual values: a change is worth two decades.
void consider(const WrittenBody& body, const std::array<UnitChoice, quantities.size()>& units, Remedy& best) {
  Factors factors;
  for (const Quantity q : quantities) factors[q] = units[q].factor;
  if (body.hasMassWithoutDensity()) factors[body_density] /= std::pow(factors[body_size], 3);
  if (faultsOf(body, factors).count() > 0) return;
  Remedy remedy{units, 0};
  for (const Quantity q : quantities) {
    if (remedy.units[q].factor != 1 && body.has_unit[q]) return;
    if (body.value[q] > 0) remedy.cost += std::abs(std::log10(body.value[q] * factors[q] / ranges[q].typical));
  }
  remedy.cost += 2. * double(remedy.changes());
  if (remedy.cost < best.cost) best = remedy;
}

Remedy remedyOf(const WrittenBody& body) {
  Remedy best{};
  const auto look = [&](const auto& density_units) {
    for (const UnitChoice& length : lengths)
      for (const UnitChoice& stiffness : moduli)
        for (const UnitChoice& heaviness : density_units)
          for (const UnitChoice& pull : gravities) consider(body, {length, stiffness, heaviness, pull}, best);
  };
  body.hasMassWithoutDensity() ? look(masses) : look(densities);
  return best;
}

// ---- in words ----

/// "80 mm", "5 kPa": with the unit in which a person would say it.
std::string inWords(Quantity quantity, double si) {
  constexpr UnitChoice any_length[] = {{"m", 1}, {"mm", 1e-3}, {"um", 1e-6}},
                       any_modulus[] = {{"GPa", 1e9}, {"MPa", 1e6}, {"kPa", 1e3}, {"Pa", 1}};
  const auto say = [si](const auto& units) {
    for (const UnitChoice& each : units)
      if (si >= each.factor) return fmt::format("{:.4g} {}", si / each.factor, each.unit);
    return fmt::format("{:.4g} {}", si / std::rbegin(units)->factor, std::rbegin(units)->unit);
  };
  if (quantity == body_size) return say(any_length);
  if (quantity == body_modulus) return say(any_modulus);
  return fmt::format("{:.6g} {}", si, quantity == body_density ? "kg/m^3" : "m/s^2");
}

std::string nameOf(const WrittenBody& body, Quantity quantity) {
  const std::string names[] = {"size", body.modulus->name(), "density", "gravity"};
  return names[quantity];
}

std::string readingOf(const WrittenBody& body, const Factors& factors) {
  std::string text;
  for (const Quantity q : quantities)
    text += fmt::format("{}{} {}", q == body_size ? "" : ", ", nameOf(body, q), inWords(q, body.value[q] * factors[q]));
  return text;
}

std::string faultText(const WrittenBody& body, const Factors& factors) {
  const Faults faults = faultsOf(body, factors);
  std::string text;
  for (const Quantity q : faults.out)
    text += fmt::format("{}{} is outside {} to {}", text.empty() ? "" : ", ", nameOf(body, q),
                        inWords(q, ranges[q].low), inWords(q, ranges[q].high));
  if (!text.empty()) return text;
  return fmt::format("density x gravity x size is {:.2g} times {}: the body would not keep its shape",
                     weightOf(body, factors), nameOf(body, body_modulus));
}

std::string shortened(const std::string& text) { return text.size() > 30 ? "..." : text; }

/// What to write for one quantity, and where.
struct Advice {
  std::string text;
  SourceLocation where;
  std::string path;
};

Advice adviceFor(const WrittenBody& body, Quantity quantity, const char* unit) {
  const auto attribute = [unit](const Component& component, const Data& data) -> Advice {
    return {fmt::format("{}=\"{} {}\" on {} ({})", data.name(), shortened(data.print()), unit, component.path(),
                        component.where().text()),
            component.where(), component.path() + "." + data.name()};
  };
  if (quantity == body_modulus) return attribute(*body.field, *body.modulus);
  if (quantity == body_density) return attribute(*body.mass, *body.mass_data);
  const Node* node = &body.mass->node();
  while (!node->own_gravity && node->parent()) node = node->parent();
  Vec3 pull = node->gravity();
  if (quantity == body_gravity)
    return {fmt::format("gravity=\"{} {}\" on {} ({})", Data("gravity", &pull).print(), unit, node->path(),
                        node->where().text()),
            node->where(), node->path()};
  bool is_file = false;
  const Component& source = sourceOfLengths(*body.state, is_file);
  const std::string at = fmt::format("{} ({})", source.path(), source.where().text());
  return {
      is_file ? fmt::format("unit=\"{}\" on {}", unit, at) : fmt::format("\"{}\" after the lengths of {}", unit, at),
      source.where(), source.path()};
}

/// The system with the fewest faults.
const UnitSystem& nearestSystem(const WrittenBody& body, bool has_units) {
  const UnitSystem* best = &systems[0];
  for (std::size_t i = 1; i < systemsToTry(has_units); ++i)
    if (faultsOf(body, systems[i].factors()).count() < faultsOf(body, best->factors()).count()) best = &systems[i];
  return *best;
}

/// For gravity that is SI in a scene of other units: what it is in those.
std::string gravityIn(const WrittenBody& body, const UnitSystem& system) {
  const Faults faults = faultsOf(body, system.factors());
  if (faults.out != std::vector{body_gravity}) return {};
  constexpr double earth = 9.81;
  Vec3 wanted = body.mass->node().gravity();
  wanted *= earth / (system.factors()[body_gravity] * wanted.norm());
  for (int i = 0; i < 3; ++i) wanted[i] = std::round(wanted[i] * 1e6) / 1e6 + 0.;
  return fmt::format("write gravity=\"{}\" if {} are meant, else ", Data("gravity", &wanted).print(), system.name);
}

void warn(const WrittenBody& body, const Remedy& remedy, bool has_units, Diagnostics& diagnostics) {
  const bool is_si = remedy.changes() <= 1 || has_units;
  const UnitSystem& system = is_si ? systems[0] : nearestSystem(body, has_units);
  std::string units;
  Advice first;
  for (const Quantity q : quantities) {
    if (remedy.units[q].factor == 1) continue;
    Advice advice = adviceFor(body, q, remedy.units[q].unit);
    units += (units.empty() ? "" : ", ") + advice.text;
    if (first.text.empty()) first = std::move(advice);
  }
  std::string suggestion = gravityIn(body, system);
  suggestion += suggestion.empty() ? "write " + units : "with units " + units;
  diagnostics.warning(first.where, first.path,
                      fmt::format("in no consistent system of units do size, stiffness, density and gravity fit "
                                  "together; read in {}: {}, of which {}",
                                  system.name, readingOf(body, system.factors()), faultText(body, system.factors())),
                      suggestion);
}

/// Numbers that are none of things: benchmarks without dimensions have a density of 1.
bool isWithoutDimensions(const WrittenBody& body) { return std::abs(body.value[body_density] - 1) < 1e-6; }

}  // namespace

void warnOfUnits(Scene& scene) {
  const bool has_units = hasAnyUnit(scene.description.root);
  const std::vector<WrittenBody> bodies = writtenBodies(scene);
  const auto allFit = [&bodies](const UnitSystem& system) {
    return std::all_of(bodies.begin(), bodies.end(), [&](const WrittenBody& body) {
      return isWithoutDimensions(body) || faultsOf(body, system.factors()).count() == 0;
    });
  };
  for (std::size_t i = 0; i < systemsToTry(has_units); ++i)
    if (allFit(systems[i])) return;
  for (const WrittenBody& body : bodies) {
    if (isWithoutDimensions(body) || faultsOf(body, systems[0].factors()).count() == 0) continue;
    const Remedy remedy = remedyOf(body);
    if (remedy.isFound() && remedy.changes() > 0) return warn(body, remedy, has_units, scene.diagnostics);
  }
}

}  // namespace stroma
