// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <set>
#include <stdexcept>

#include "framework/scene/text.h"

namespace stroma::sweep {
namespace {

/// Parts between separators; "\," is a comma that separates nothing.
std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\' && i + 1 < text.size() && text[i + 1] == separator)
      parts.back() += text[++i];
    else if (text[i] == separator)
      parts.emplace_back();
    else
      parts.back() += text[i];
  }
  for (std::string& part : parts) part = std::string(trimmed(part));
  return parts;
}

struct Variation {
  std::string attribute;
  std::vector<std::string> values;
};

Variation parseVariation(const std::string& text, const char* option) {
  const std::string expected = "expected PATH.ATTR=a,b,c, for example /liver/linear.iterations=25,50,100";
  const auto equals = text.find('=');
  if (equals == std::string::npos)
    throw std::invalid_argument(fmt::format("{} {} varies nothing: {}", option, inQuotes(text), expected));
  Variation variation;
  variation.attribute = std::string(trimmed(text.substr(0, equals)));
  variation.values = split(text.substr(equals + 1), ',');
  const bool is_path = variation.attribute.starts_with('/');
  const auto is_type = [](const std::string& value) { return !value.empty() && std::isupper(static_cast<unsigned char>(value[0])); };
  const bool are_types = is_path && std::ranges::all_of(variation.values, is_type);  // components in the place of one
  if (variation.attribute.empty() || (is_path && !are_types && variation.attribute.rfind('.') == std::string::npos))
    throw std::invalid_argument(fmt::format("{} {} names no attribute: {}", option, inQuotes(text), expected));
  if (!is_path && variation.attribute.find('.') != std::string::npos) variation.attribute.insert(0, 1, '/');
  std::set<std::string> seen;
  for (const std::string& value : variation.values) {
    if (value.empty()) throw std::invalid_argument(fmt::format("{} {}: a value is empty", option, inQuotes(text)));
    if (!seen.insert(value).second && std::string(option) == "--vary")
      throw std::invalid_argument(fmt::format("{} {}: the value {} is there twice", option, inQuotes(text), value));
  }
  return variation;
}

Axis axisOf(const std::vector<Variation>& together, const std::string& text) {
  Axis axis;
  for (const Variation& variation : together) {
    if (variation.values.size() != together.front().values.size())
      throw std::invalid_argument(fmt::format(
          "--zip {}: {} has {} values and {} has {}: expected as many of each", inQuotes(text),
          together.front().attribute, together.front().values.size(), variation.attribute, variation.values.size()));
    axis.attributes.push_back(variation.attribute);
    axis.values.resize(variation.values.size());
    for (std::size_t k = 0; k < variation.values.size(); ++k) axis.values[k].push_back(variation.values[k]);
  }
  for (std::size_t k = 1; k < axis.size(); ++k)
    if (std::find(axis.values.begin(), axis.values.begin() + std::ptrdiff_t(k), axis.values[k]) !=
        axis.values.begin() + std::ptrdiff_t(k))
      throw std::invalid_argument(fmt::format("--zip {}: {} is there twice", inQuotes(text), axis.settingText(k)));
  return axis;
}

std::string lowerCase(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

AxisKind kindOf(const std::string& attribute) {
  if (attribute.find('/') != std::string::npos && attribute.find('.') == std::string::npos) return AxisKind::words;  // a component
  const std::string name = lowerCase(attribute.substr(attribute.rfind('.') + 1));
  if (name.find("tolerance") != std::string::npos || name.find("threshold") != std::string::npos)
    return AxisKind::tolerance;
  return name.find("iterations") != std::string::npos ? AxisKind::iterations : AxisKind::words;
}

}  // namespace

bool readNumber(const std::string& text, double& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(number);
}

std::string shortName(const std::string& attribute) {
  const auto slash = attribute.rfind('/');
  return slash == std::string::npos ? attribute : attribute.substr(slash + 1);
}

bool Axis::isFiner(std::size_t a, std::size_t b) const {
  if (!isOrdered()) return a > b;
  return kind == AxisKind::iterations ? sizes[a] > sizes[b] : sizes[a] < sizes[b];
}

std::size_t Axis::finest() const {
  std::size_t best = 0;
  for (std::size_t k = 1; k < size(); ++k)
    if (isFiner(k, best)) best = k;
  return best;
}

std::string Axis::label() const {
  std::string text;
  for (const std::string& attribute : attributes) text += (text.empty() ? "" : ", ") + shortName(attribute);
  return text;
}

std::string Axis::valueText(std::size_t value) const { return fmt::format("{}", fmt::join(values[value], ", ")); }

std::string Axis::settingText(std::size_t value) const {
  std::string text;
  for (std::size_t a = 0; a < attributes.size(); ++a)
    text += (a == 0 ? "" : ", ") + shortName(attributes[a]) + "=" + values[value][a];
  return text;
}

std::vector<Axis> parseAxes(const std::vector<std::string>& vary, const std::vector<std::string>& zip) {
  std::vector<Axis> axes;
  for (const std::string& text : vary) axes.push_back(axisOf({parseVariation(text, "--vary")}, text));
  for (const std::string& text : zip) {
    std::vector<Variation> together;
    for (const std::string& part : split(text, ';')) together.push_back(parseVariation(part, "--zip"));
    if (together.size() < 2)
      throw std::invalid_argument(fmt::format(
          "--zip {} has one attribute: expected several, as \"dt=0.02,0.01; /liver/linear.iterations=50,100\"",
          inQuotes(text)));
    axes.push_back(axisOf(together, text));
  }
  if (axes.empty()) throw std::invalid_argument("nothing varies: expected --vary PATH.ATTR=a,b,c");
  std::set<std::string> seen;
  for (const Axis& axis : axes)
    for (const std::string& attribute : axis.attributes)
      if (!seen.insert(attribute).second)
        throw std::invalid_argument(fmt::format("{} varies twice: give all its values at once", attribute));
  for (Axis& axis : axes) classify(axis);
  return axes;
}

void classify(Axis& axis) {
  for (const AxisKind kind : {AxisKind::tolerance, AxisKind::iterations})
    for (std::size_t a = 0; a < axis.attributes.size(); ++a) {
      if (kindOf(axis.attributes[a]) != kind) continue;
      std::vector<double> sizes(axis.size());
      bool are_numbers = true;
      std::set<double> distinct;
      for (std::size_t k = 0; k < axis.size(); ++k) {
        are_numbers = are_numbers && readNumber(axis.values[k][a], sizes[k]) && sizes[k] > 0;
        distinct.insert(sizes[k]);
      }
      if (!are_numbers || distinct.size() != axis.size()) continue;
      axis.kind = kind;
      axis.sizes = std::move(sizes);
      return;
    }
}

}  // namespace stroma::sweep
