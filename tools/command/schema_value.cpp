// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/schema_value.h"

#include <fmt/format.h>

#include <cctype>
#include <cstdlib>

#include "tools/command/component_json.h"
#include "tools/units/units.h"

namespace stroma::command {
namespace {

using Kind = SchemaAlternative::Kind;

// ---- patterns; white space has been made single spaces, and commas separate too ----

constexpr const char* number = "[\\-+]?([0-9]+([.][0-9]*)?|[.][0-9]+)([eE][\\-+]?[0-9]+)?";
constexpr const char* whole = "[\\-+]?[0-9]+";
constexpr const char* rising = "[0-9]+-[0-9]+(-[0-9]+)?";

/// A unit, from every name with its prefixes, as readUnit() takes it; brackets need not match. Made when it is asked for,
/// as no other command needs it.
const std::string& unitPattern() {
  static const std::string all = [] {
    std::string names = "°";
    for (const std::string& name : unitNames()) names += "|" + (name[0] == 'u' ? "[uµμ]" + name.substr(1) : name);
    const std::string name = "%*(" + names + ")%*";
    const std::string power = "((\\^|[*][*])?(-?[0-9]+)|(\\^|[*][*])[(]-?[0-9]+[)]|[²³⁴]|⁻[¹²³])";
    const std::string closed = "( ?[)]" + power + "?)", sign = "( ?[*/·⋅] ?| ?[.]| )", open = "[(] ?(1? ?/ ?)?";
    // two names need something between them, and a power or a bracket is enough
    const std::string between = fmt::format("({0}{1}*{2}?|{1}+{2}?|{2}|{3})({3})*", power, closed, sign, open);
    return fmt::format("(1? ?/ ?)?({0})*{1}({2}{1})*{3}?{4}*", open, name, between, power, closed);
  }();
  return all;
}

/// A number or a fraction.
const std::string& fraction() {
  static const std::string text = fmt::format("{0}( ?/ ?{0})?", number);
  return text;
}

/// Words of a list that hold a comma, which a validator cannot look into further.
std::string withCommas(const std::string& item) {
  return fmt::format(",+({0}(,+{0})*)?,*|{0}(,+{0})+,*|{0},+", "(" + item + ")");
}

/// Exactly `count` of them. All are written out: libxml2 counts wrongly where an item can end in several ways.
std::string exactly(const std::string& item, int count) {
  std::string out = fmt::format("[ ,]*({})", item);
  for (int i = 1; i < count; ++i) out += fmt::format("[ ,]+({})", item);
  return out + "[ ,]*";
}

SchemaAlternative pattern(std::string text) { return {.kind = Kind::pattern, .pattern = std::move(text)}; }

SchemaAlternative listOf(std::vector<SchemaAlternative> items) {
  return {.kind = Kind::list, .items = std::move(items)};
}

SchemaAlternative link() { return pattern("@.*"); }

/// A number with a unit, or a fraction: "10 kPa", "1/20 s", "1/20".
SchemaAlternative quantity() {
  return pattern(fmt::format("[ ,]*({0} ?/ ?{0}|{1} ?{2})[ ,]*", number, fraction(), unitPattern()));
}

/// Numbers with a unit after the last one or after each: how large they are in SI is more than a pattern knows.
SchemaAlternative quantities() {
  return pattern(fmt::format("[ ,]*({0}( ?{1})?[ ,]+)*{0} ?{1}[ ,]*", fraction(), unitPattern()));
}

/// Three numbers, with a unit after each, after the last one, or none.
SchemaAlternative vector() { return pattern(exactly(fmt::format("{0}( ?{1})?", fraction(), unitPattern()), 3)); }

// ---- ranges ----

struct Range {
  std::optional<SchemaBound> min, max;
};

/// From "[0, 0.5)", ">= 0", "> 0", "<= 1" or "< 1"; whole numbers of integers without an exponent.
Range rangeOf(const Data& data, bool is_integer) {
  const auto text = [is_integer](const std::string& value) {
    return is_integer ? fmt::format("{:.0f}", std::strtod(value.c_str(), nullptr)) : value;
  };
  const std::string range = data.rangeText();
  Range out;
  if (range.empty()) return out;
  if (range[0] == '[' || range[0] == '(') {
    const auto comma = range.find(", ");
    out.min = SchemaBound{text(range.substr(1, comma - 1)), range[0] == '['};
    out.max = SchemaBound{text(range.substr(comma + 2, range.size() - comma - 3)), range.back() == ']'};
    return out;
  }
  const bool inclusive = range[1] == '=';
  (range[0] == '>' ? out.min : out.max) = SchemaBound{text(range.substr(inclusive ? 3 : 2)), inclusive};
  return out;
}

/// Letters, digits and . - _ of a text; the rest is left out.
std::string nameFrom(const std::string& text) {
  std::string name;
  for (const char c : text)
    if (std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '_') name += c;
  return name;
}

std::string nameOf(const std::string& kind, const Range& range) {
  std::string name = kind;
  if (range.min) name += (range.min->inclusive ? "_from_" : "_above_") + nameFrom(range.min->value);
  if (range.max) name += (range.max->inclusive ? "_to_" : "_below_") + nameFrom(range.max->value);
  return name;
}

std::string nameOfWords(const std::vector<std::string>& words) {
  std::string name = "one_of";
  for (const std::string& word : words) name += "_" + nameFrom(word);
  return name;
}

/// NaN and INF, which XML Schema has among its numbers, are none here.
SchemaAlternative numeric(Kind kind, const Range& range) {
  return {.kind = kind, .min = range.min, .max = range.max, .pattern = kind == Kind::real ? number : ""};
}

std::vector<SchemaAlternative> numberOrNumbers(const std::string& kind, const Range& range) {
  if (kind == "real") return {numeric(Kind::real, range), quantity()};
  if (kind == "integer") return {numeric(Kind::integer, range)};
  if (kind == "reals" || kind == "vectors")
    return {
        listOf({numeric(Kind::real, range), pattern(withCommas(number)), pattern(fmt::format("{0}/{0},?", number))}),
        quantities()};
  if (kind == "indices") return {listOf({numeric(Kind::integer, range), pattern(withCommas("[0-9]+"))})};
  return {listOf(
      {numeric(Kind::integer, range), pattern(rising), pattern(withCommas(fmt::format("{}|{}", whole, rising)))})};
}

SchemaValue orLink(SchemaValue value) {
  value.alternatives.push_back(link());
  return value;
}

}  // namespace

SchemaValue textValue() { return {"text", {{.kind = Kind::text}}}; }

SchemaValue wordValue(std::string name, std::vector<std::string> words) {
  return {std::move(name), {{.kind = Kind::words, .words = std::move(words)}}};
}

SchemaValue templateValue(const std::vector<std::string>& words) {
  return {"template",
          {listOf({{.kind = Kind::words, .words = words}, pattern("CompressedRowSparseMatrix.*"), pattern(".*,.*")})}};
}

SchemaValue plainValue(const std::string& kind, bool positive) {
  if (kind == "boolean") return {"plain_boolean", {{.kind = Kind::boolean}}};
  if (kind == "gravity") return {"gravity", {vector(), numeric(Kind::real, {}), quantity()}};
  Range range;
  if (positive) range.min = SchemaBound{"0", false};
  return {nameOf("plain_real", range), {numeric(Kind::real, range), quantity()}};
}

SchemaValue valueOf(const Data& data) {
  const std::string kind = kindOf(data);
  if (const LinkBase* target = data.link()) {
    if (target->words.empty()) return textValue();
    return orLink(wordValue(nameOfWords(target->words), target->words));
  }
  if (kind == "text" || kind == "words" || kind == "file") return textValue();
  if (const auto* choice = std::get_if<ChoiceRef>(&data.pointer()))
    return orLink(wordValue(nameOfWords(choice->words), choice->words));
  if (kind == "boolean") return orLink({"boolean", {{.kind = Kind::boolean}}});
  if (kind == "booleans")
    return orLink({"booleans", {listOf({{.kind = Kind::boolean}, pattern(withCommas("true|false|0|1"))})}});
  if (kind == "vector") return orLink({"vector", {vector()}});
  if (kind == "matrix") return orLink({"matrix", {pattern(exactly(fraction(), 16))}});
  if (kind == "integer triple") return orLink({"integer_triple", {pattern(exactly(whole, 3))}});
  Range range = rangeOf(data, kind == "integer" || kind == "integers");
  if (kind == "indices") range.min = SchemaBound{"0", true};
  return orLink({nameOf(kind, range), numberOrNumbers(kind, range)});
}

}  // namespace stroma::command
