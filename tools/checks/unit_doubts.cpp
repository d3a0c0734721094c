// SPDX-License-Identifier: LGPL-2.1-or-later
// Whether the numbers of a scene can belong together. They need not be SI: each consistent system of units is tried.
#include "tools/checks/unit_doubts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "framework/scene/text.h"
#include "tools/units/plausible_units.h"

namespace stroma {
namespace {

bool has(const std::vector<Quantity>& list, Quantity q) { return std::find(list.begin(), list.end(), q) != list.end(); }

const UnitSystem& si() { return unitSystems().front(); }

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
  std::array<UnitChoice, body_quantities.size()> units;
  double cost = std::numeric_limits<double>::infinity();
  bool isFound() const { return std::isfinite(cost) && changes() > 0; }
  std::size_t changes() const {
    return std::size_t(std::count_if(units.begin(), units.end(), [](const UnitChoice& u) { return u.factor != 1; }));
  }
};

/// Which quantities may be other than they are read: what has a unit is meant so, and what is plausible is left alone
/// when the weight is all that is wrong.
std::array<bool, body_quantities.size()> changeable(const Scene& scene, const WrittenBody& body) {
  const auto has_unit = quantitiesWithUnit(scene, body);
  const Faults faults = faultsOf(body, factorsOf(si()));
  std::array<bool, body_quantities.size()> may{};
  for (const Quantity q : body_quantities)
    may[q] = !has_unit[q] && isKnown(body, q) && (!faults.out.empty() || has(faults.suspect, q));
  return may;
}

/// Few changes and usual values: a change is worth two decades.
void consider(const WrittenBody& body, const std::array<bool, body_quantities.size()>& may,
              const std::array<UnitChoice, body_quantities.size()>& units, Remedy& best) {
  Factors factors;
  for (const Quantity q : body_quantities) {
    factors[q] = units[q].factor;
    if (units[q].factor != 1 && !may[q]) return;
  }
  if (body.hasMassWithoutDensity()) factors[body_density] /= std::pow(factors[body_size], 3);
  if (faultsOf(body, factors).count() > 0) return;
  Remedy remedy{units, 0};
  for (const Quantity q : body_quantities)
    if (body.value[q] > 0) remedy.cost += std::abs(std::log10(body.value[q] * factors[q] / plausible[q].typical));
  remedy.cost += 2. * double(remedy.changes());
  if (remedy.cost < best.cost) best = remedy;
}

Remedy remedyOf(const Scene& scene, const WrittenBody& body) {
  const auto may = changeable(scene, body);
  Remedy best{};
  const auto look = [&](const auto& density_units) {
    for (const UnitChoice& length : lengths)
      for (const UnitChoice& stiffness : moduli)
        for (const UnitChoice& heaviness : density_units)
          for (const UnitChoice& pull : gravities) consider(body, may, {length, stiffness, heaviness, pull}, best);
  };
  body.hasMassWithoutDensity() ? look(masses) : look(densities);
  return best;
}

// ---- in words ----

/// "80 mm", "5 kPa": with the unit in which a person would say it.
std::string inWords(Quantity quantity, double value) {
  constexpr UnitChoice any_length[] = {{"m", 1}, {"mm", 1e-3}, {"um", 1e-6}},
                       any_modulus[] = {{"GPa", 1e9}, {"MPa", 1e6}, {"kPa", 1e3}, {"Pa", 1}};
  const auto say = [value](const auto& units) {
    for (const UnitChoice& each : units)
      if (value >= each.factor) return fmt::format("{:.4g} {}", value / each.factor, each.unit);
    return fmt::format("{:.4g} {}", value / std::rbegin(units)->factor, std::rbegin(units)->unit);
  };
  if (quantity == body_size) return say(any_length);
  if (quantity == body_modulus) return say(any_modulus);
  return fmt::format("{:.6g} {}", value, quantity == body_density ? "kg/m^3" : "m/s^2");
}

std::string nameOf(const WrittenBody& body, Quantity quantity) {
  const std::string names[] = {"size", body.moduli[0].data->name(), "density", "gravity"};
  return names[quantity];
}

std::string readingOf(const WrittenBody& body, const Factors& factors) {
  std::string text;
  for (const Quantity q : body_quantities)
    if (isKnown(body, q) || (q == body_gravity && body.mass))
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", nameOf(body, q), inWords(q, body.value[q] * factors[q]));
  return text;
}

std::string faultText(const WrittenBody& body, const Factors& factors) {
  const Faults faults = faultsOf(body, factors);
  assert(faults.count() > 0);
  std::string text;
  for (const Quantity q : faults.out)
    text += fmt::format("{}{} is outside {} to {}", text.empty() ? "" : ", ", nameOf(body, q),
                        inWords(q, plausible[q].low), inWords(q, plausible[q].high));
  if (!text.empty()) return text;
  const bool is_known = isKnown(body, body_density) && isKnown(body, body_gravity);
  return fmt::format("density x gravity x size is {}{:.3g} times {}: the body is too heavy for its stiffness",
                     is_known ? "" : "for tissue on earth ", weightOf(body, factors), nameOf(body, body_modulus));
}

std::string shortened(const std::string& text) { return text.size() > 30 ? "..." : text; }

/// What to write for one quantity, and where.
struct Advice {
  std::string text;
  SourceLocation where;
  std::string path;
};

/// The numbers of an attribute in another unit, as they are written.
std::string inOtherUnit(const Data& data, double factor) {
  const auto print = [factor](double value) { return fmt::format("{:.12g}", value * factor); };
  if (const auto* real = std::get_if<double*>(&data.pointer())) return print(**real);
  std::string text;
  if (const auto* list = std::get_if<std::vector<double>*>(&data.pointer()))
    for (const double value : **list) text += (text.empty() ? "" : " ") + print(value);
  return text;
}

/// `unit` follows the number; it may be empty, when the number is multiplied by `factor`.
Advice adviceFor(const WrittenBody& body, Quantity quantity, const std::string& unit, double factor = 1) {
  const auto valued = [&](const std::string& number) { return shortened(number) + (unit.empty() ? "" : " " + unit); };
  const auto attribute = [&](const Component& component, const Data& data) -> Advice {
    return {
        fmt::format("{}=\"{}\" on {} ({})", data.name(), valued(factor == 1 ? data.print() : inOtherUnit(data, factor)),
                    component.path(), component.where().text()),
        component.where(), component.path() + "." + data.name()};
  };
  if (quantity == body_modulus) {
    Advice advice = attribute(*body.moduli[0].field, *body.moduli[0].data);
    for (const Modulus& other : body.moduli)
      if (other.data != body.moduli[0].data && other.data->isSet())
        advice.text += ", " + attribute(*other.field, *other.data).text;
    return advice;
  }
  if (quantity == body_density) return attribute(*body.mass, *body.mass_data);
  if (quantity == body_gravity) {
    const Node* node = body.mass ? &body.mass->node() : &body.state->node();
    while (!node->own_gravity && node->parent()) node = node->parent();
    Vec3 pull = node->gravity() * factor;
    for (int i = 0; i < 3 && factor != 1; ++i) pull[i] = std::round(pull[i] * 1e6) / 1e6 + 0.;
    return {fmt::format("gravity=\"{}\" on {} ({})", valued(Data("gravity", &pull).print()), node->path(),
                        node->where().text()),
            node->where(), node->path()};
  }
  bool is_file = false;
  const Component& source = sourceOfLengths(*body.state, is_file);
  const std::string at = fmt::format("{} ({})", source.path(), source.where().text());
  std::string text =
      is_file ? fmt::format("unit=\"{}\" on {}", unit, at) : fmt::format("\"{}\" after the lengths of {}", unit, at);
  if (unit.empty()) text = fmt::format("the lengths of {} times {:g}", at, factor);
  return {text, source.where(), source.path()};
}

/// The units of a remedy in words; the place is that of the first.
Advice adviceOf(const WrittenBody& body, const Remedy& remedy) {
  Advice all;
  for (const Quantity q : body_quantities) {
    if (remedy.units[q].factor == 1) continue;
    Advice advice = adviceFor(body, q, remedy.units[q].unit);
    if (all.text.empty()) {
      all = std::move(advice);
    } else {
      all.text += ", " + advice.text;
    }
  }
  return all;
}

/// When one quantity is out of a system that is not SI: what it is in its units, if it was written in a usual unit.
Advice adviceWithin(const UnitSystem& system, const WrittenBody& body) {
  const Factors factors = factorsOf(system);
  const Faults faults = faultsOf(body, factors);
  if (faults.out.size() != 1) return {};
  const Quantity q = faults.out[0];
  double best = std::numeric_limits<double>::infinity(), ratio = 0;
  const auto look = [&](const auto& units) {
    for (const UnitChoice& unit : units) {
      Factors other = factors;
      other[q] = unit.factor;
      if (q == body_density && body.hasMassWithoutDensity()) other[q] /= std::pow(system.length, 3);
      const double distance = std::abs(std::log10(body.value[q] * other[q] / plausible[q].typical));
      if (faultsOf(body, other).count() == 0 && distance < best) best = distance, ratio = other[q] / factors[q];
    }
  };
  if (q == body_size) look(lengths);
  if (q == body_modulus) look(moduli);
  if (q == body_density) body.hasMassWithoutDensity() ? look(masses) : look(densities);
  if (q == body_gravity) look(gravities);
  return ratio > 0 ? adviceFor(body, q, "", ratio) : Advice{};
}

// ---- which system is meant, and which body is off in it ----

struct Doubt {
  const UnitSystem* system;
  const SourceLocation* declared = nullptr;  ///< of the attribute that says so
  std::vector<const WrittenBody*> bodies{};  ///< with faults in it
  std::size_t faults = 0;
};

Doubt doubtIn(const UnitSystem& system, const std::vector<WrittenBody>& bodies) {
  Doubt doubt{&system};
  for (const WrittenBody& body : bodies)
    if (const std::size_t count = faultsOf(body, factorsOf(system)).count(); count > 0)
      doubt.bodies.push_back(&body), doubt.faults += count;
  return doubt;
}

/// In the system with the fewest bodies that are off, and of those the fewest faults.
Doubt leastDoubt(const std::vector<WrittenBody>& bodies) {
  Doubt least = doubtIn(si(), bodies);
  for (const UnitSystem& system : unitSystems()) {
    Doubt doubt = doubtIn(system, bodies);
    const bool is_less = doubt.bodies.size() < least.bodies.size() ||
                         (doubt.bodies.size() == least.bodies.size() && doubt.faults < least.faults);
    if (is_less) least = std::move(doubt);
  }
  return least;
}

/// The only system in which no body is off, as `units` names it; or empty.
std::string fittingSystem(const std::vector<WrittenBody>& bodies) {
  std::string found;
  for (const UnitSystem& system : unitSystems()) {
    if (!doubtIn(system, bodies).bodies.empty()) continue;
    if (!found.empty()) return {};
    found = system.name;
    std::erase(found, ',');
  }
  return found;
}

/// Values with a unit are refused beside declared units: other numbers, or other units.
Advice adviceOnDeclared(const Doubt& doubt, const std::vector<WrittenBody>& bodies) {
  Advice within = adviceWithin(*doubt.system, *doubt.bodies[0]);
  const std::string fitting = fittingSystem(bodies);
  const std::string units = fitting.empty() ? "" : fmt::format("units=\"{}\" ({})", fitting, doubt.declared->text());
  if (within.text.empty()) return units.empty() ? Advice{} : Advice{"write " + units, *doubt.declared, "/.units"};
  within.text = fmt::format("write {}{}", within.text, units.empty() ? "" : ", or " + units);
  return within;
}

/// What to write, for the reader of a warning; empty when nothing is sure.
Advice adviceOn(const Doubt& doubt, bool all_are_off, const Remedy& in_units) {
  const WrittenBody& body = *doubt.bodies[0];
  Advice units = in_units.isFound() && (doubt.system == &si() || all_are_off) ? adviceOf(body, in_units) : Advice{};
  if (doubt.system == &si()) {
    if (!units.text.empty()) units.text = "write " + units.text;
    return units;
  }
  Advice within = adviceWithin(*doubt.system, body);
  if (within.text.empty()) {
    if (!units.text.empty()) units.text = "with units write " + units.text;
    return units;
  }
  within.text = fmt::format("write {} if {} are meant", within.text, doubt.system->name);
  if (units.text.empty()) return within;
  units.text = within.text + ", else with units " + units.text;
  return units;
}

void warn(const Doubt& doubt, bool has_units, const Advice& advice, Diagnostics& diagnostics) {
  const WrittenBody& body = *doubt.bodies[0];
  const Factors factors = factorsOf(*doubt.system);
  const char* what = body.mass                     ? "size, stiffness, density and gravity"
                     : isKnown(body, body_gravity) ? "size, stiffness and gravity"
                                                   : "size and stiffness";
  const std::string head = has_units || doubt.declared
                               ? fmt::format("{} do not fit together", what)
                               : fmt::format("in no consistent system of units do {} fit together", what);
  const Component& fallback = *body.moduli[0].field;
  const bool is_placed = !advice.text.empty();
  diagnostics.warning(is_placed ? advice.where : fallback.where(), is_placed ? advice.path : fallback.path(),
                      fmt::format("{}; read in {}: {}, of which {}", head, doubt.system->name, readingOf(body, factors),
                                  faultText(body, factors)),
                      advice.text);
}

}  // namespace

void warnOfUnits(const Scene& scene, Diagnostics& diagnostics) {
  std::vector<WrittenBody> bodies = writtenBodies(scene);
  const AttributeDescription* units = scene.description.root.find("units");
  if (!units && doubtIn(si(), bodies).bodies.empty()) return;
  const bool has_units = hasAnyUnit(scene.description.root);
  if (!has_units) std::erase_if(bodies, isWithoutDimensions);
  const UnitSystem declared = units ? unitsOf(scene) : UnitSystem{};
  if (declared.isKnown() && !declared.isSI()) {
    Doubt doubt = doubtIn(declared, bodies);
    doubt.declared = &units->where;
    if (!doubt.bodies.empty()) warn(doubt, has_units, adviceOnDeclared(doubt, bodies), diagnostics);
    return;
  }
  Doubt doubt = has_units || declared.isSI() ? doubtIn(si(), bodies) : leastDoubt(bodies);
  if (doubt.bodies.empty()) return;
  const bool all_are_off = doubt.bodies.size() == bodies.size();
  const Remedy in_units = remedyOf(scene, *doubt.bodies[0]);
  // One unit makes the whole scene SI: simpler than another system.
  if (!units && all_are_off && in_units.isFound() && in_units.changes() == 1) doubt = doubtIn(si(), bodies);
  warn(doubt, has_units || declared.isSI(), adviceOn(doubt, all_are_off, in_units), diagnostics);
}

}  // namespace stroma
