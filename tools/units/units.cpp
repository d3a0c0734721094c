// SPDX-License-Identifier: LGPL-2.1-or-later
// Names of units and the expressions that are made of them.
#include "tools/units/units.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>

#include "framework/scene/diagnostics.h"
#include "framework/scene/text.h"

namespace stroma {
namespace {

constexpr Dimension none{}, length{1}, volume{3}, mass{0, 1}, duration{0, 0, 1}, rate{0, 0, -1}, angle{0, 0, 0, 1},
    force{1, 1, -2}, pressure{-1, 1, -2}, energy{2, 1, -2}, bytes{0, 0, 0, 0, 1};

/// A name, its unit, and the prefixes that are usual before it, the likelier ones first.
struct Symbol {
  std::string_view name;
  Unit unit;
  std::string_view prefixes = {};
};

/// 1 psi is 1 lbf/in^2, 1 mmHg is 13595.1 kg/m^3 * 9.80665 m/s^2 * 1 mm, 1 cmH2O is 1000 kg/m^3 * g * 1 cm.
constexpr Symbol symbols[] = {{"m", {length}, "mcukdn"},
                              {"in", {length, 254, 1, -4}},
                              {"inch", {length, 254, 1, -4}},
                              {"ft", {length, 3048, 1, -4}},
                              {"g", {mass, 1, 1, -3}, "kmun"},
                              {"t", {mass, 1, 1, 3}},
                              {"tonne", {mass, 1, 1, 3}},
                              {"lb", {mass, 45359237, 1, -8}},
                              {"s", {duration}, "mun"},
                              {"min", {duration, 6, 1, 1}},
                              {"h", {duration, 36, 1, 2}},
                              {"Hz", {rate}, "kMGm"},
                              {"rad", {angle}, "m"},
                              {"deg", {angle, 1, 18, -1, 1}},
                              {"degree", {angle, 1, 18, -1, 1}},
                              {"degrees", {angle, 1, 18, -1, 1}},
                              {"N", {force}, "mkMuncp"},
                              {"daN", {force, 1, 1, 1}},
                              {"dyn", {force, 1, 1, -5}},
                              {"kgf", {force, 980665, 1, -5}},
                              {"lbf", {force, 44482216152605, 1, -13}},
                              {"Pa", {pressure}, "kMGhmu"},
                              {"bar", {pressure, 1, 1, 5}, "m"},
                              {"mmHg", {pressure, 133322387415, 1, -9}},
                              {"cmH2O", {pressure, 980665, 1, -4}},
                              {"mmH2O", {pressure, 980665, 1, -5}},
                              {"psi", {pressure, 44482216152605, 64516, -5}},
                              {"atm", {pressure, 101325}},
                              {"J", {energy}, "mkMun"},
                              {"L", {volume, 1, 1, -3}, "mduc"},
                              {"l", {volume, 1, 1, -3}, "mduc"},
                              {"B", {bytes}, "kMG"},
                              {"%", {none, 1, 1, -2}}};

/// What people write for it: too far from the name to be found as the nearest.
constexpr std::pair<std::string_view, std::string_view> spelt_out[] = {
    {"sec", "s"},         {"second", "s"},      {"seconds", "s"},  {"msec", "ms"},       {"minute", "min"},
    {"minutes", "min"},   {"hr", "h"},          {"hour", "h"},     {"hours", "h"},       {"meter", "m"},
    {"meters", "m"},      {"metre", "m"},       {"metres", "m"},   {"millimeter", "mm"}, {"millimetre", "mm"},
    {"centimeter", "cm"}, {"centimetre", "cm"}, {"micron", "um"},  {"newton", "N"},      {"Newton", "N"},
    {"pascal", "Pa"},     {"Pascal", "Pa"},     {"gram", "g"},     {"kilogram", "kg"},   {"ton", "t"},
    {"litre", "L"},       {"liter", "L"},       {"cc", "mL"},      {"radian", "rad"},    {"radians", "rad"},
    {"Nm", "N m"},        {"Ns", "N s"},        {"Pas", "Pa s"},   {"kNm", "kN m"},      {"mNm", "mN m"},
    {"Nmm", "N mm"},      {"mNs", "mN s"},      {"kPas", "kPa s"}, {"mPas", "mPa s"},    {"Torr", "mmHg"},
    {"mmhg", "mmHg"},     {"percent", "%"},     {"dyne", "dyn"}};

/// Of each dimension that attributes have: what it is, and units that are usual for it.
struct Kind {
  std::string_view usual, words, examples;
};
constexpr Kind kinds[] = {{"m", "a length", "m, cm, mm"},
                          {"m^2", "an area", "m^2, cm^2, mm^2"},
                          {"m^3", "a volume", "m^3, mL, mm^3"},
                          {"m^3/s", "a volume per time", "m^3/s, mL/s"},
                          {"kg", "a mass", "kg, g, t"},
                          {"1/kg", "one over a mass", "1/kg, 1/g, 1/t"},
                          {"s/kg", "a way per impulse", "m/(N s), mm/(mN s)"},
                          {"s", "a time", "s, ms, min"},
                          {"1/s", "a rate", "1/s, Hz, 1/min"},
                          {"m/s", "a velocity", "m/s, mm/s"},
                          {"m/s^2", "an acceleration", "m/s^2, mm/s^2"},
                          {"rad", "an angle", "deg, rad"},
                          {"rad/s", "an angular velocity (2 pi times a frequency)", "rad/s, deg/s"},
                          {"N", "a force", "N, mN, dyn"},
                          {"N/m", "a stiffness", "N/m, N/mm, mN/mm"},
                          {"N/m^3", "a force per volume", "N/m^3, N/mm^3"},
                          {"N m^2", "a stiffness against bending or torsion", "N m^2, N mm^2"},
                          {"N s", "an impulse", "N s, mN s"},
                          {"N s/m", "a damping", "N s/m, N s/mm"},
                          {"Pa s", "a damping per length, or a viscosity", "N s/m^2, Pa s"},
                          {"Pa", "a pressure", "Pa, kPa, MPa, mmHg"},
                          {"Pa/s", "a change of pressure", "Pa/s, kPa/s, mmHg/s"},
                          {"kg m^2", "a moment of inertia", "kg m^2, g mm^2"},
                          {"kg/m^3", "a density", "kg/m^3, g/cm^3"},
                          {"kg/m^2", "a mass per area", "kg/m^2, g/cm^2"},
                          {"kg/m", "a mass per length", "kg/m, g/cm"},
                          {"J", "an energy or a torque", "J, N m, mJ"},
                          {"m^2/(Pa s)", "a permeability", "m^4/(N s), m^2/(Pa s), mm^2/(kPa s)"},
                          {"B", "an amount of memory", "MB, GB"}};

int tenOfPrefix(char prefix) {
  constexpr std::string_view names = "pnumcdhkMG";
  constexpr int tens[] = {-12, -9, -6, -3, -2, -1, 2, 3, 6, 9};
  return tens[names.find(prefix)];
}

/// The names that may have been meant: of one dimension when it is given.
std::vector<std::string> namesOf(const Dimension* wanted) {
  std::vector<std::string> names = unitNames();
  if (wanted) std::erase_if(names, [wanted](const std::string& each) { return readUnit(each).dimension != *wanted; });
  return names;
}

[[noreturn]] void refuseName(std::string_view name, const Dimension* wanted) {
  double number = 0;  // what a program prints for what is none
  const auto [end, code] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (code == std::errc() && end == name.data() + name.size())
    throw ComponentError(inQuotes(name) + " is not a finite number", "finite numbers");
  for (const auto& [written, right] : spelt_out)
    if (written == name && (!wanted || readUnit(right).dimension == *wanted))
      throw ComponentError(inQuotes(name) + " is not a unit", "a unit", std::string(right));
  throw ComponentError(inQuotes(name) + " is not a unit", "a unit", nearest(name, namesOf(wanted)));
}

std::optional<Unit> unitNamed(std::string_view name) {
  for (const Symbol& symbol : symbols)
    if (symbol.name == name) return symbol.unit;
  for (const Symbol& symbol : symbols) {
    if (!name.ends_with(symbol.name) || name.size() != symbol.name.size() + 1) continue;
    if (symbol.prefixes.find(name[0]) == std::string_view::npos) continue;
    Unit unit = symbol.unit;
    unit.ten += tenOfPrefix(name[0]);
    return unit;
  }
  return {};
}

[[noreturn]] void refuseSize() { throw ComponentError("the unit has too large powers", "a unit such as m^2/(Pa s)"); }

std::uint64_t product(std::uint64_t a, std::uint64_t b) {
  std::uint64_t out = 0;
  if (__builtin_mul_overflow(a, b, &out) || out >> 62) refuseSize();
  return out;
}

Unit times(const Unit& a, const Unit& b) {
  Unit out;
  for (std::size_t i = 0; i < out.dimension.size(); ++i) {
    out.dimension[i] = a.dimension[i] + b.dimension[i];
    if (std::abs(out.dimension[i]) > 30) refuseSize();
  }
  const std::uint64_t one = std::gcd(a.numerator, b.denominator), other = std::gcd(b.numerator, a.denominator);
  out.numerator = product(a.numerator / one, b.numerator / other);
  out.denominator = product(a.denominator / other, b.denominator / one);
  out.ten = a.ten + b.ten, out.pi = a.pi + b.pi;
  if (std::abs(out.ten) > 200) refuseSize();
  return out;
}

Unit power(const Unit& unit, int exponent) {
  if (std::abs(exponent) > 9) refuseSize();
  Unit base = unit, out;
  if (exponent < 0) {
    std::swap(base.numerator, base.denominator);
    for (int& each : base.dimension) each = -each;
    base.ten = -base.ten, base.pi = -base.pi;
  }
  for (int i = 0; i < std::abs(exponent); ++i) out = times(out, base);
  return out;
}

/// unit := ["1"] ["/"] factor {separator factor}; the separator is a space, * or . for a product, or /.
class UnitReader {
 public:
  explicit UnitReader(std::string_view text, const Dimension* wanted = nullptr) : rest_(text), wanted_(wanted) {}
  std::string_view rest() const { return rest_; }

  Unit read(int depth = 0) {
    constexpr int deepest = 8;
    if (depth > deepest) refuseSize();
    skipSpaces();
    if (depth == 0) start_ = rest_;
    bool divides = startsReciprocal();
    if (divides) rest_.remove_prefix(rest_.find('/') + 1);
    Unit unit = power(factor(depth), divides ? -1 : 1);
    while (separator(divides)) unit = times(unit, power(factor(depth), divides ? -1 : 1));
    return unit;
  }

 private:
  char peek(std::size_t i = 0) const { return i < rest_.size() ? rest_[i] : '\0'; }
  void skipSpaces() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\r\n"), rest_.size())); }
  bool startsReciprocal() const {
    if (peek() == '/') return true;
    return peek() == '1' && rest_.find_first_not_of(" \t\r\n", 1) != rest_.npos &&
           rest_[rest_.find_first_not_of(" \t\r\n", 1)] == '/';
  }
  bool startsFactor() const { return isLetter(peek()) || peek() == '('; }

  /// Nothing of the unit before a name that was just taken, and nothing after it.
  bool isAlone(std::string_view name) const {
    const std::string_view after = trimmed(rest_);
    const bool has_power = !rest_.empty() && std::string_view(" \t\r\n,").find(rest_[0]) == rest_.npos;
    const bool has_factor =
        !after.empty() && (isLetter(after[0]) || std::string_view("*/(").find(after[0]) != after.npos);
    return name.data() == start_.data() && !has_power && !has_factor;
  }

  /// What stands before the next factor, if there is one. After a division only another one is clear.
  bool separator(bool& divides) {
    const std::string_view before = rest_;
    skipSpaces();
    const bool product = peek() == '*' || (peek() == '.' && isLetter(peek(1)));
    const bool division = peek() == '/';
    if (product || division) rest_.remove_prefix(1), skipSpaces();
    if (peek() == '%') refusePercent();
    if (!product && !division && !startsFactor()) return rest_ = before, false;
    if (divides && !division)
      throw ComponentError("the terms after the division are ambiguous",
                           "brackets, as in m^2/(Pa s), or the product first, as in N s/m");
    divides = division;
    return true;
  }

  Unit factor(int depth) {
    skipSpaces();
    Unit unit;
    if (peek() == '(') {
      rest_.remove_prefix(1);
      unit = read(depth + 1);
      skipSpaces();
      if (peek() != ')') throw ComponentError("a bracket of the unit is not closed", ")");
      rest_.remove_prefix(1);
    } else {
      const std::string_view written = name();
      const std::optional<Unit> known = unitNamed(written);
      if (!known) refuseName(written, isAlone(written) ? wanted_ : nullptr);
      unit = *known;
      if (written == "%") return refuseFactorsOfPercent(), unit;
    }
    return power(unit, exponent());
  }

  [[noreturn]] static void refusePercent() {
    throw ComponentError("% is a unit of its own and no factor of one", "a unit without %");
  }
  void refuseFactorsOfPercent() {
    const std::string_view before = rest_;
    skipSpaces();
    if (startsFactor() || peek() == '*' || peek() == '/' || peek() == '^') refusePercent();
    rest_ = before;
  }

  std::string_view name() {
    std::size_t end = peek() == '%' ? 1 : 0;
    while (peek() != '%' && isLetter(peek(end))) ++end;
    if (end > 0 && rest_[end - 1] == 'H' && rest_.substr(end).starts_with("2O")) end += 2;  // cmH2O
    if (end == 0)
      throw ComponentError(rest_.empty() ? "the unit ends too early" : inQuotes(rest_.substr(0, 1)) + " is not a unit",
                           "the name of a unit");
    const std::string_view found = rest_.substr(0, end);
    rest_.remove_prefix(end);
    return found;
  }

  /// "^2", "^-1", "^(-1)", "**2", and without a sign for a power "2" and "-1". 1 when there is none.
  int exponent() {
    std::string_view at = rest_;
    const bool is_signed = at.starts_with("^") || at.starts_with("**");
    if (is_signed) at.remove_prefix(at[0] == '^' ? 1 : 2);
    const bool is_bracketed = is_signed && at.starts_with("(");
    if (is_bracketed) at.remove_prefix(1);
    int value = 1;
    const auto [end, code] = std::from_chars(at.data(), at.data() + at.size(), value);
    if (code != std::errc() && !is_signed) return 1;
    at.remove_prefix(std::size_t(end - at.data()));
    if (code != std::errc() || (is_bracketed && !at.starts_with(")")))
      throw ComponentError("the power of a unit is not a whole number", "a power such as m^2 or s^-1");
    if (is_bracketed) at.remove_prefix(1);
    rest_ = at;
    return value;
  }

  std::string_view rest_, start_;
  const Dimension* wanted_;
};

}  // namespace

Unit readUnitFront(std::string_view& text, const Dimension* wanted) {
  UnitReader reader(text, wanted);
  const Unit unit = reader.read();
  text = reader.rest();
  return unit;
}

Unit readUnit(std::string_view written) {
  const std::string plain = plainUnitText(trimmed(written));
  if (plain == "-") return {};
  UnitReader reader(plain);
  const Unit unit = reader.read();
  if (!trimmed(reader.rest()).empty())
    throw ComponentError(inQuotes(written) + " is not a unit", "a unit such as m^2/(Pa s)");
  return unit;
}

Unit readLengthUnit(std::string_view text) {
  try {
    std::string plain = plainUnitText(trimmed(text));
    std::string_view rest = plain;
    const Unit unit = readUnitFront(rest, &length);
    if (unit.dimension == length && trimmed(rest).empty()) return unit;
  } catch (const ComponentError& error) {
    throw ComponentError(error.what(), describe(length), error.suggestion);
  }
  throw ComponentError(inQuotes(text) + " is no unit of length", describe(length));
}

std::optional<Unit> findUnit(std::string_view text) {
  try {
    return readUnit(text);
  } catch (const ComponentError&) {
    return {};
  }
}

/// The marks that books have and keyboards lack, in ASCII.
std::string plainUnitText(std::string_view text) {
  static constexpr std::pair<std::string_view, std::string_view> marks[] = {{"\xC2\xB5", "u"},
                                                                            {"\xCE\xBC", "u"},
                                                                            {"\xC2\xB0", "deg"},
                                                                            {"\xC2\xB7", "*"},
                                                                            {"\xE2\x8B\x85", "*"},
                                                                            {"\xC2\xB2", "^2"},
                                                                            {"\xC2\xB3", "^3"},
                                                                            {"\xE2\x81\xB4", "^4"},
                                                                            {"\xE2\x81\xBB\xC2\xB9", "^-1"},
                                                                            {"\xE2\x81\xBB\xC2\xB2", "^-2"},
                                                                            {"\xE2\x81\xBB\xC2\xB3", "^-3"}};
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const auto mark = static_cast<unsigned char>(text[0]) < 0x80
                          ? std::end(marks)
                          : std::find_if(std::begin(marks), std::end(marks),
                                         [&text](const auto& each) { return text.starts_with(each.first); });
    out += mark == std::end(marks) ? text.substr(0, 1) : mark->second;
    text.remove_prefix(mark == std::end(marks) ? 1 : mark->first.size());
  }
  return out;
}

std::string describe(const Dimension& dimension) {
  if (dimension == none) return "a number without unit";
  for (const Kind& kind : kinds)
    if (readUnit(kind.usual).dimension == dimension)
      return std::string(kind.words) + ", such as " + std::string(kind.examples);
  static constexpr std::string_view base[] = {"m", "kg", "s", "rad", "B"};
  std::string out;
  for (std::size_t i = 0; i < dimension.size(); ++i)
    if (dimension[i] != 0)
      out += (out.empty() ? "" : " ") + std::string(base[i]) +
             (dimension[i] == 1 ? "" : "^" + std::to_string(dimension[i]));
  return out;
}

double inSI(double value, const Unit& unit) {
  const double up = double(unit.numerator) * (unit.ten > 0 ? std::pow(10., unit.ten) : 1);
  const double down = double(unit.denominator) * (unit.ten < 0 ? std::pow(10., -unit.ten) : 1);
  if (up != 1) value *= up;
  if (down != 1) value /= down;
  return unit.pi == 0 ? value : value * std::pow(std::acos(-1.), unit.pi);
}

const std::vector<std::string>& unitNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Symbol& symbol : symbols) {
      all.emplace_back(symbol.name);
      for (const char prefix : symbol.prefixes) all.push_back(prefix + std::string(symbol.name));
    }
    return all;
  }();
  return names;
}

}  // namespace stroma
