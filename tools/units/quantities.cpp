// SPDX-License-Identifier: LGPL-2.1-or-later
// Numbers with units, as attributes are written.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <numeric>

#include "framework/scene/diagnostics.h"
#include "framework/scene/text.h"
#include "tools/units/units.h"

namespace stroma {
namespace {

using Wide = unsigned __int128;

constexpr std::string_view spaces = " \t\n\r\f\v", separators = " \t\n\r\f\v,";

bool isDigit(char c) { return c >= '0' && c <= '9'; }
char at(std::string_view text, std::size_t i) { return i < text.size() ? text[i] : '\0'; }

std::size_t countDigits(std::string_view text, std::size_t from) {
  std::size_t end = from;
  while (isDigit(at(text, end))) ++end;
  return end - from;
}

/// How long the decimal number at the front is; 0 when there is none.
std::size_t lengthOfNumber(std::string_view text, bool may_have_sign) {
  std::size_t i = may_have_sign && (at(text, 0) == '-' || at(text, 0) == '+') ? 1 : 0;
  const std::size_t whole = countDigits(text, i);
  i += whole;
  const std::size_t fraction = at(text, i) == '.' ? countDigits(text, i + 1) : 0;
  if (at(text, i) == '.' && whole + fraction > 0) i += 1 + fraction;
  if (whole + fraction == 0) return 0;
  if (at(text, i) != 'e' && at(text, i) != 'E') return i;
  const std::size_t sign = at(text, i + 1) == '-' || at(text, i + 1) == '+' ? 1 : 0;
  const std::size_t exponent = countDigits(text, i + 1 + sign);
  return exponent == 0 ? i : i + 1 + sign + exponent;
}

/// What follows the e of a number.
int exponentOf(std::string_view text) {
  constexpr int largest = 100'000;
  if (text.starts_with('+')) text.remove_prefix(1);
  int ten = text.starts_with('-') ? -largest : largest;
  std::from_chars(text.data(), text.data() + text.size(), ten);
  return std::clamp(ten, -largest, largest);
}

/// Digits beyond eighteen do not count.
Decimal decimalOf(std::string_view number) {
  constexpr std::uint64_t full = 100'000'000'000'000'000;
  Decimal out;
  bool is_fraction = false;
  for (std::size_t i = 0; i < number.size(); ++i) {
    const char c = number[i];
    if (c == '-') out.negative = true;
    if (c == '.') is_fraction = true;
    if (isDigit(c) && out.digits < full)
      out.digits = 10 * out.digits + std::uint64_t(c - '0'), out.ten -= is_fraction;
    else if (isDigit(c) && !is_fraction)
      ++out.ten;
    if (c != 'e' && c != 'E') continue;
    out.ten += exponentOf(number.substr(i + 1));
    break;
  }
  return out;
}

/// A number, what divides it, and its unit, as they follow each other in a text.
struct Item {
  std::string_view number, divisor;
  std::optional<Unit> unit;
  std::string_view unit_text;
};

class ItemReader {
 public:
  ItemReader(std::string_view text, const Dimension& wanted) : rest_(text), wanted_(wanted) {}

  /// False at the end, and where no number stands: isBroken() tells. Throws ComponentError of a unit.
  bool next(Item& item) {
    item = {};
    skip(separators);
    if (rest_.empty() || broken_) return false;
    item.number = number(true);
    if (item.number.empty()) return broken_ = true, false;
    readDivisor(item);
    readUnit(item);
    if (!rest_.empty() && separators.find(rest_[0]) == separators.npos) broken_ = true;
    return !broken_;
  }
  bool isBroken() const { return broken_; }

 private:
  void skip(std::string_view what) { rest_.remove_prefix(std::min(rest_.find_first_not_of(what), rest_.size())); }
  std::string_view number(bool may_have_sign) {
    const std::string_view found = rest_.substr(0, lengthOfNumber(rest_, may_have_sign));
    rest_.remove_prefix(found.size());
    return found;
  }

  /// "/20", " / 20".
  void readDivisor(Item& item) {
    const std::string_view before = rest_;
    skip(spaces);
    const bool divides = at(rest_, 0) == '/';
    if (divides) rest_.remove_prefix(1), skip(spaces);
    if (!divides || !(isDigit(at(rest_, 0)) || at(rest_, 0) == '.')) return void(rest_ = before);
    item.divisor = number(false);
    broken_ = item.divisor.empty();
  }

  /// "1/" before a letter begins a unit, and no number.
  static bool startsUnit(std::string_view text) {
    const auto skipOver = [&text](char c) {
      if (at(text, 0) != c) return;
      text.remove_prefix(1);
      text.remove_prefix(std::min(text.find_first_not_of(spaces), text.size()));
    };
    if (const std::string_view after = trimmed(text.substr(std::min<std::size_t>(1, text.size()))); at(after, 0) == '/')
      skipOver('1');
    skipOver('/');
    return isLetter(at(text, 0)) || at(text, 0) == '(' || at(text, 0) == '%';
  }

  void readUnit(Item& item) {
    const std::string_view before = rest_;
    skip(spaces);
    if (!startsUnit(rest_)) return void(rest_ = before);
    const std::string_view start = rest_;
    item.unit = readUnitFront(rest_, &wanted_);
    item.unit_text = start.substr(0, start.size() - rest_.size());
  }

  std::string_view rest_;
  Dimension wanted_;
  bool broken_ = false;
};

/// How the numbers of a text have units.
struct Layout {
  std::size_t numbers = 0, with_unit = 0;
  bool last_has_unit = false, has_fraction = false, is_broken = false;
  std::optional<Unit> last;
  std::string wrong;  ///< a sentence on the first unit that is not of the wanted dimension
};

/// What a unit of another dimension is.
std::string wrongUnit(const Item& item) {
  const std::string unit = inQuotes(item.unit_text), kind = describe(item.unit->dimension);
  if (item.unit->dimension == Dimension{}) return unit + " is the unit of a pure number";
  const auto end = std::min(kind.find(','), kind.find(" ("));
  return end == kind.npos ? unit + " is of another dimension" : unit + " is the unit of " + kind.substr(0, end);
}

Layout layoutOf(std::string_view text, const Dimension& wanted) {
  Layout layout;
  ItemReader reader(text, wanted);
  for (Item item; reader.next(item);) {
    ++layout.numbers;
    layout.has_fraction = layout.has_fraction || !item.divisor.empty();
    layout.last_has_unit = item.unit.has_value(), layout.last = item.unit;
    if (!item.unit) continue;
    ++layout.with_unit;
    if (item.unit->dimension == wanted || !layout.wrong.empty()) continue;
    layout.wrong = wrongUnit(item);
  }
  layout.is_broken = reader.isBroken();
  return layout;
}

/// "1,5 kPa" would be the two numbers 1 kPa and 5 kPa.
void refuseDecimalComma(std::string_view text) {
  const std::size_t comma = text.find(',');
  if (comma == text.npos || comma == 0 || !isDigit(text[comma - 1]) || !isDigit(at(text, comma + 1))) return;
  std::string with_point(trimmed(text)), with_space = with_point;
  with_point[with_point.find(',')] = '.', with_space[with_space.find(',')] = ' ';
  throw ComponentError("a comma separates numbers, and " + inQuotes(trimmed(text)) + " may mean one",
                       inQuotes(with_point) + ", or " + inQuotes(with_space) + " for two numbers");
}

/// None where `text` is to be refused as if there were no units: it has none, or a word that the attribute would not
/// take as one either.
std::optional<Layout> layoutFor(std::string_view text, const std::optional<Unit>& own) {
  const Dimension wanted = own ? own->dimension : Dimension{};
  const std::string expected = own ? describe(wanted) : "numbers without unit";
  Layout layout;
  try {
    layout = layoutOf(text, wanted);
  } catch (ComponentError& error) {
    if (wanted == Dimension{}) return {};
    throw ComponentError(error.what(), error.expected == "a unit" ? expected : error.expected, error.suggestion);
  }
  if (layout.is_broken || (layout.with_unit == 0 && !layout.has_fraction)) return {};
  if (!layout.wrong.empty()) throw ComponentError(layout.wrong, expected);
  if (layout.with_unit > 0 && !own) throw ComponentError("the value has a unit and the attribute has none", expected);
  const bool is_clear =
      layout.with_unit == 0 || layout.with_unit == layout.numbers || (layout.with_unit == 1 && layout.last_has_unit);
  if (!is_clear)
    throw ComponentError("some of the numbers have a unit", "one unit at the end for all numbers, or one after each");
  if (layout.numbers == 2 && layout.with_unit == 1) refuseDecimalComma(text);
  return layout;
}

/// The digits of a / b, with as many behind the point as one rounding to a double can need.
std::string quotientText(Wide a, Wide b) {
  constexpr int enough = 25;
  std::string out;
  for (Wide whole = a / b; whole != 0; whole /= 10) out.insert(out.begin(), char('0' + int(whole % 10)));
  if (out.empty()) out = "0";
  Wide rest = a % b;
  if (rest == 0) return out;
  int significant = a / b == 0 ? 0 : int(out.size());
  out += '.';
  for (; rest != 0 && significant < enough; rest %= b) {
    rest *= 10;
    const int digit = int(rest / b);
    out += char('0' + digit);
    if (significant > 0 || digit > 0) ++significant;
  }
  if (rest != 0) out += '1';  // it lies above: no tie is seen where there is none
  return out;
}

/// None when it does not fit a double; a zero may have any power of ten.
std::optional<double> realOf(const std::string& text, bool is_zero) {
  double value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc() && !is_zero) return {};
  return value;
}

/// number * 10^ten with every digit that is there.
std::optional<double> moved(std::string_view number, int ten) {
  const std::size_t e = std::min(number.find_first_of("eE"), number.size());
  if (e < number.size()) ten += exponentOf(number.substr(e + 1));
  const std::string text(number.substr(number.starts_with('+') ? 1 : 0, e - (number.starts_with('+') ? 1 : 0)));
  return realOf(text + "e" + std::to_string(ten), number.find_first_of("123456789") >= e);
}

/// a * b; false when it is too large to be divided digit by digit.
bool multiply(Wide& a, std::uint64_t b) { return !__builtin_mul_overflow(a, Wide(b), &a) && a >> 124 == 0; }

}  // namespace

std::optional<double> exactQuotient(const Decimal& a, const Decimal& b, const Unit& unit, const Unit& declared) {
  Wide above = a.digits, below = b.digits;
  const std::uint64_t up = std::gcd(unit.numerator, declared.numerator),
                      down = std::gcd(unit.denominator, declared.denominator);
  if (below == 0 || !multiply(above, unit.numerator / up) || !multiply(above, declared.denominator / down) ||
      !multiply(below, unit.denominator / down) || !multiply(below, declared.numerator / up))
    return {};
  const std::string text = quotientText(above, below) + "e" + std::to_string(a.ten - b.ten + unit.ten - declared.ten);
  const std::optional<double> real = realOf(text, above == 0);
  if (!real) return {};
  double value = *real;
  const int pi = unit.pi - declared.pi;
  if (pi != 0) value = double((long double)(value)*std::pow(std::numbers::pi_v<long double>, (long double)(pi)));
  if (!std::isfinite(value)) return {};
  return a.negative != b.negative ? -value : value;
}

namespace {

std::optional<double> valueOf(const Item& item, const Unit& unit, const Unit& declared) {
  const auto isPowerOfTen = [](const Unit& u) { return u.numerator == 1 && u.denominator == 1 && u.pi == 0; };
  if (item.divisor.empty() && isPowerOfTen(unit) && isPowerOfTen(declared))
    return moved(item.number, unit.ten - declared.ten);
  const Decimal divisor = item.divisor.empty() ? Decimal{1, 0, false} : decimalOf(item.divisor);
  return exactQuotient(decimalOf(item.number), divisor, unit, declared);
}

}  // namespace

std::optional<std::string> withoutUnits(std::string_view written, std::string_view declared) {
  constexpr std::string_view either = " or ";
  if (const auto end = declared.find(either); end != declared.npos) {
    try {
      return withoutUnits(written, declared.substr(0, end));
    } catch (const ComponentError& first) {
      try {
        return withoutUnits(written, declared.substr(end + either.size()));
      } catch (const ComponentError& second) {
        throw ComponentError(first.what(), first.expected + ", or " + second.expected, first.suggestion);
      }
    }
  }
  const std::string text = plainUnitText(written);
  const std::optional<Unit> own = findUnit(declared);
  const std::optional<Layout> layout = layoutFor(text, own);
  if (!layout) return {};
  const Unit to = own.value_or(Unit{}), otherwise = layout->last.value_or(to);
  std::string out;
  ItemReader reader(text, to.dimension);
  for (Item item; reader.next(item);) {
    if (!item.divisor.empty() && decimalOf(item.divisor).digits == 0)
      throw ComponentError(inQuotes(trimmed(written)) + " divides by zero", "another number after the /");
    const std::optional<double> value = valueOf(item, item.unit.value_or(otherwise), to);
    if (!value) throw ComponentError(inQuotes(item.number) + " with its unit or divisor does not fit a double");
    out += (out.empty() ? "" : " ") + printReal(*value);
  }
  return out;
}

bool hasUnit(std::string_view text) {
  const std::string plain = plainUnitText(text);
  try {
    ItemReader reader(plain, Dimension{});
    for (Item item; reader.next(item);)
      if (item.unit) return true;
  } catch (const ComponentError&) {
  }
  return false;
}

double metresOf(const std::string& unit) { return unit.empty() ? 1 : inSI(1, readLengthUnit(unit)); }

void makeMetres(std::vector<Vec3>& lengths, const std::string& unit) {
  if (unit.empty()) return;
  const Unit given = readLengthUnit(unit);
  for (Vec3& p : lengths)
    for (int i = 0; i < 3; ++i) p[i] = inSI(p[i], given);
}

}  // namespace stroma
