// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/stress/targets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "tools/units/units.h"

namespace stroma::stress {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
/// A longer list is a field, not a parameter.
constexpr std::size_t most_values = 24;

/// Metre, kilogram and second are what a quantity is recognised by; angles do not count.
Quantity quantityOf(const std::string& unit, bool bounded) {
  if (unit == "-") return bounded ? Quantity::ratio : Quantity::number;
  const auto found = findUnit(unit);
  if (!found) return Quantity::other;
  const auto [metre, kilogram, second, radian, byte] = found->dimension;
  if (metre == 0 && kilogram == 0 && second == 0) return bounded ? Quantity::ratio : Quantity::number;
  if (kilogram == 1 && second == -2) return Quantity::stiffness;  // Pa, N/m, N, N m, J
  if (kilogram == 1 && second == 0) return Quantity::inertia;
  if (kilogram == 0 && metre == 0) return Quantity::time;
  if (kilogram == 0 && second == 0) return Quantity::length;
  return Quantity::other;
}

/// "[0, 0.5)", ">= 0", "< 1": the range as the manual has it.
void readRange(const std::string& text, Target& target) {
  target.low = -infinity, target.high = infinity;
  if (text.empty()) return;
  if (text[0] == '[' || text[0] == '(') {
    const auto comma = text.find(',');
    target.low = std::stod(text.substr(1, comma - 1)), target.high = std::stod(text.substr(comma + 1));
    target.has_low = target.has_high = true;
    return;
  }
  const double value = std::stod(text.substr(text.find_first_of("-0123456789")));
  (text[0] == '>' ? target.low : target.high) = value;
  (text[0] == '>' ? target.has_low : target.has_high) = true;
}

/// The numbers of an attribute that may be perturbed; empty for all others.
std::vector<double> numbersOf(const Data& data) {
  if (const auto* one = std::get_if<double*>(&data.pointer())) return {**one};
  if (const auto* list = std::get_if<std::vector<double>*>(&data.pointer())) return **list;
  if (const auto* vector = std::get_if<Vec3*>(&data.pointer())) return {(**vector)[0], (**vector)[1], (**vector)[2]};
  return {};
}

/// Whether these are the numbers of the default. Others come from an attribute that the person wrote instead of this one, or
/// from a mesh: to give this one too would be refused.
bool isDefault(const Data& data, const std::vector<double>& values) {
  std::istringstream words(data.defaultText());
  std::vector<double> numbers;
  for (double number = 0; words >> number;) numbers.push_back(number);
  return words.eof() && numbers == values;
}

/// Whether another value would say something: one that a person wrote, or a default with a unit or a range.
bool isOfInterest(const Data& data, const std::vector<double>& values) {
  if (values.empty() || values.size() > most_values || data.isOutput()) return false;
  if (!data.isSet() && (data.isShorthand() || !isDefault(data, values))) return false;
  if (data.unitText().empty() || data.origin() == DataOrigin::linked) return false;
  if (!std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); })) return false;
  if (data.isSet()) return true;
  const bool is_zero = std::all_of(values.begin(), values.end(), [](double value) { return value == 0; });
  return !is_zero && (data.isPhysical() || data.unitText() != "-");
}

Target gravityOf(const Node& root) {
  Target target;
  target.path = "/", target.attribute = "gravity";
  const Vec3 g = root.gravity();
  target.values = {g[0], g[1], g[2]};
  readRange("", target);
  return target;
}

}  // namespace

const char* wordOf(Quantity quantity) {
  static const char* words[] = {"stiffness", "mass and density", "ratio",      "time",
                                "length",    "other quantity",   "pure number"};
  return words[int(quantity)];
}

std::string Target::textOf(std::vector<double> changed) const {
  if (changed == values) return {};
  std::string text;
  for (const double value : changed) {
    if (!std::isfinite(value)) return {};
    text += (text.empty() ? "" : " ") + fmt::format("{}", value);
  }
  return text;
}

std::string Target::scaled(double decades) const {
  std::vector<double> changed = values;
  for (double& value : changed) {
    value *= std::pow(10, decades);
    // an end may not belong to the range: a value inside is the present one, or nearer to the end
    if (value < low) value = has_high ? low + 1e-9 * (high - low) : low;
    if (value > high) value = has_low ? high - 1e-9 * (high - low) : high;
  }
  return textOf(std::move(changed));
}

std::string Target::nearEnd(double decades, bool above) const {
  const double way = (high - low) * std::pow(10, -decades);
  return textOf(std::vector<double>(values.size(), above ? high - way : low + way));
}

std::vector<Target> targetsOf(const Simulation& simulation) {
  std::vector<Target> targets;
  targets.push_back({"/", "dt", Quantity::time, {simulation.dt()}, 0, infinity, true, false});
  if (!simulation.root().gravity().isZero(0)) targets.push_back(gravityOf(simulation.root()));
  std::vector<Component*> components;
  simulation.root().collect(components);
  for (const Component* component : components)
    for (const Data& data : component->data().all()) {
      Target target;
      target.path = component->path(), target.attribute = data.name();
      target.values = numbersOf(data);
      if (!isOfInterest(data, target.values)) continue;
      readRange(data.rangeText(), target);
      target.quantity = quantityOf(data.unitText(), target.isBounded());
      targets.push_back(std::move(target));
    }
  return targets;
}

}  // namespace stroma::stress
