// SPDX-License-Identifier: LGPL-2.1-or-later
// Names of units in a consistent system. Each unit of a text of SI is renamed by itself: "N s/m" of mm, t, s is "N s/mm".
// Those with a name of their own (Pa, N, J, W) become it with the prefix of their power of ten, dyn where it is one
// and else what they are made of.
#include "tools/units/unit_system.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "framework/scene/gravity.h"
#include "framework/scene/text.h"
#include "tools/units/plausible_units.h"
#include "tools/units/units.h"

namespace stroma {
namespace {

constexpr std::array<std::pair<int, const char*>, 9> named_powers{
    {{-12, "p"}, {-9, "n"}, {-6, "u"}, {-3, "m"}, {0, ""}, {3, "k"}, {6, "M"}, {9, "G"}, {12, "T"}}};

/// Exponents of length, mass and time.
double sizeOf(const UnitSystem& system, const Dimension& d) {
  return std::pow(system.length, d[0]) * std::pow(system.mass, d[1]) * std::pow(system.time, d[2]);
}

bool isClose(double a, double b) { return std::abs(a - b) <= 1e-9 * std::abs(b); }

std::array<std::string, 3> baseNames(const UnitSystem& system) {
  std::array<std::string, 3> names;
  Words words(system.name);
  for (std::string& name : names) name = words.next();
  return names;
}

/// One word of a unit: "Pa", "m".
std::string renamed(const UnitSystem& system, const std::string& word) {
  const auto base = baseNames(system);
  if (word == "m") return base[0];
  if (word == "kg") return base[1];
  if (word == "s") return base[2];
  const std::optional<Unit> unit = findUnit(word);
  if (!unit) return word;
  const double size = sizeOf(system, unit->dimension);
  if (word == "N" && isClose(size, 1e-5)) return "dyn";
  for (const auto& [ten, prefix] : named_powers)
    if (isClose(size, std::pow(10., ten))) return prefix + word;
  if (unit->dimension == Dimension{-1, 1, -2}) return fmt::format("{}/({} {}^2)", base[1], base[0], base[2]);
  return isClose(size, 1) ? word : fmt::format("{:.3g} {}", size, word);
}

/// What one unit of a pressure, force or mass is as a mass.
double massOf(const Unit& unit, double length, double time) {
  const double value = inSI(1, unit);
  if (unit.dimension == Dimension{0, 1}) return value;
  if (unit.dimension == Dimension{1, 1, -2}) return value * time * time / length;
  if (unit.dimension == Dimension{-1, 1, -2}) return value * length * time * time;
  return 0;
}

Problem refusal(std::string message, std::string expected, std::string suggestion = {}) {
  Problem problem;
  problem.message = std::move(message), problem.expected = std::move(expected);
  problem.suggestion = std::move(suggestion);
  return problem;
}

std::string massName(double mass) {
  constexpr std::array<std::pair<double, const char*>, 5> usual{
      {{1, "kg"}, {1e-3, "g"}, {1e3, "t"}, {1e-6, "mg"}, {1e-9, "ug"}}};
  for (const auto& [size, name] : usual)
    if (isClose(mass, size)) return name;
  return {};
}

}  // namespace

std::string UnitSystem::unit(std::string_view si_unit) const {
  if (!isKnown() || si_unit == "-") return {};
  if (isSI()) return std::string(si_unit);
  std::string text, word;
  const auto finish = [&] {
    if (!word.empty()) text += renamed(*this, word);
    word.clear();
  };
  for (const char c : si_unit) {
    if (isLetter(c)) {
      word += c;
      continue;
    }
    finish();
    text += c;
  }
  finish();
  return text;
}

std::string UnitSystem::behind(std::string_view si_unit) const {
  const std::string text = unit(si_unit);
  return text.empty() ? text : " " + text;
}

std::string UnitSystem::inBrackets(std::string_view si_unit) const {
  const std::string text = unit(si_unit);
  return text.empty() ? text : " [" + text + "]";
}

std::string UnitSystem::sentence(const std::string& text) const {
  if (isSI()) return text;
  // longer ones first
  constexpr std::array<std::string_view, 17> units{"N s/m", "kg/m^3", "m/s^2", "N m", "N s", "N/m",
                                                   "Pa s",  "Pa/s",   "m^3",   "m^2", "m/s", "Pa",
                                                   "kg",    "N",      "J",     "m",   "s"};
  const auto isEnd = [](char c) { return c != '^' && c != '/' && c != '*' && !isLetter(c) && !(c >= '0' && c <= '9'); };
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const bool behind =
        i >= 2 && text[i - 1] == ' ' && (text[i - 2] == ')' || (text[i - 2] >= '0' && text[i - 2] <= '9'));
    const std::string_view rest = std::string_view(text).substr(i);
    const auto found = std::ranges::find_if(units, [&](std::string_view each) {
      return behind && rest.starts_with(each) && (rest.size() == each.size() || isEnd(rest[each.size()]));
    });
    if (found == units.end()) {
      out += text[i++];
      continue;
    }
    if (isKnown())
      out += unit(*found);
    else
      out.pop_back();  // the blank before it
    i += found->size();
  }
  return out;
}

UnitSystem readUnitSystem(std::string_view text) {
  if (trimmed(text) == "SI") text = "m kg s";
  const std::string expected =
      "a length, a mass and a time, as \"mm t s\", or a pressure for the mass, as \"mm kPa s\", or SI";
  UnitSystem system;
  std::string length, middle, time;
  std::optional<Unit> held;
  Words words(text);
  int count = 0;
  for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++count) {
    const Unit unit = readUnit(word);
    if (unit.dimension == Dimension{1}) {
      length = word, system.length = inSI(1, unit);
    } else if (unit.dimension == Dimension{0, 0, 1}) {
      time = word, system.time = inSI(1, unit);
    } else if (massOf(unit, 1, 1) > 0) {
      middle = word, held = unit;
    } else {
      throw ComponentError(inQuotes(word) + " does not fix a system of units", expected);
    }
  }
  if (count != 3 || length.empty() || time.empty() || !held)
    throw ComponentError(inQuotes(text) + " is no system of units", expected);
  system.mass = massOf(*held, system.length, system.time);
  const std::string mass = massName(system.mass);
  if (mass.empty())
    throw ComponentError(fmt::format("{} belongs to a mass of {:.3g} kg, which has no name", middle, system.mass),
                         expected);
  system.name = fmt::format("{}, {}, {}", length, mass, time);
  return system;
}

std::optional<Problem> problemOfUnits(std::string_view text, const NodeDescription& root, bool is_outermost) {
  try {
    const UnitSystem system = readUnitSystem(text);
    if (!is_outermost) return refusal("a child node has no units of its own", "units on the outermost Node only");
    if (!system.isSI() && hasAnyUnit(root))
      return refusal("some values are written with a unit, and so are SI among numbers in " + system.name,
                     "numbers without units, or no attribute units");
    return {};
  } catch (const ComponentError& error) {
    return refusal(error.what(), error.expected, error.suggestion);
  }
}

DefaultGravity defaultGravity(std::string_view units) {
  const UnitSystem system = readUnitSystem(units);
  if (system.isSI()) return {};
  return {9.81 / (system.length / (system.time * system.time)), system.unit("m/s^2")};  // rounded once in the usual systems
}

UnitSystem unitsOf(const Scene& scene) {
  const UnitSystem& si = unitSystems().front();
  if (const AttributeDescription* declared = scene.description.root.find("units"))
    return readUnitSystem(declared->value);
  if (hasAnyUnit(scene.description.root)) return si;
  const std::vector<WrittenBody> bodies = writtenBodies(scene);
  if (bodies.empty() || std::ranges::any_of(bodies, isWithoutDimensions)) return {};
  const auto isPlausible = [&](const UnitSystem& system) {
    return std::ranges::all_of(bodies,
                               [&](const WrittenBody& body) { return faultsOf(body, factorsOf(system)).count() == 0; });
  };
  // whose usual weight would crush it may be one in millimetres and kilopascals, without a mass
  const auto bearsItsUsualWeight = [&](const WrittenBody& body) { return weightOf(body, factorsOf(si)) <= heaviest; };
  if (isPlausible(si) && std::ranges::all_of(bodies, bearsItsUsualWeight)) return si;
  // numbers that happen to be plausible in one other system alone are no sign of it: a usual scene without units, gravity 9.81 and
  // any mass, would be one in centimetres with a hundredth of the earth's gravity
  const auto hasEarthsGravity = [&](const UnitSystem& system) {
    constexpr double least = 9.7, most = 9.9;
    return std::ranges::any_of(bodies, [&](const WrittenBody& body) {
      const double gravity = body.value[body_gravity] * factorsOf(system)[body_gravity];
      return gravity >= least && gravity <= most;
    });
  };
  const UnitSystem* found = nullptr;
  for (const UnitSystem& system : unitSystems()) {
    if (!isPlausible(system)) continue;
    if (found || system.isSI()) return {};
    found = &system;
  }
  return found && hasEarthsGravity(*found) ? *found : UnitSystem{};
}

std::string unitInBrackets(const Scene& scene, std::string_view si_unit) { return unitsOf(scene).inBrackets(si_unit); }

}  // namespace stroma
