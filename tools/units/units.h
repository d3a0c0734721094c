// SPDX-License-Identifier: LGPL-2.1-or-later
// Units that attributes may be written in: youngModulus="10 kPa". Inside, every value is in the unit that its attribute
// declares, which is SI (but for angles in degrees).
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "framework/scene/written_units.h"

namespace stroma {

/// Exponents of metre, kilogram, second, radian and byte. An angle counts: 1 Hz is not 1 rad/s.
using Dimension = std::array<int, 5>;

/// A unit is 10^ten * numerator / denominator * pi^pi of the SI unit of its dimension. All are whole numbers.
struct Unit {
  Dimension dimension{};
  std::uint64_t numerator = 1, denominator = 1;
  int ten = 0, pi = 0;
};

/// Reads a unit: "kPa", "m^2/(Pa s)", "N·s/m", "1/s", "%", or "-" for a pure number. Throws ComponentError with the
/// nearest right name.
Unit readUnit(std::string_view text);

/// The same of a unit at the front of `text`, which then holds what follows. With `wanted`, what is suggested for an
/// unknown name that stands alone is of this dimension.
Unit readUnitFront(std::string_view& text, const Dimension* wanted = nullptr);

/// readUnit() of a length. Throws ComponentError for another dimension too.
Unit readLengthUnit(std::string_view text);

/// Of the names of units, whatever the locale.
constexpr bool isLetter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// `text` with "u" for the micro sign, "^2" for a raised 2 and the like: what readUnitFront() reads.
std::string plainUnitText(std::string_view text);

/// readUnit() without an error.
std::optional<Unit> findUnit(std::string_view text);

/// For messages: "a pressure, such as Pa, kPa, MPa"; for a dimension without a name "m^5 kg".
std::string describe(const Dimension& dimension);

// withoutUnits() is declared in framework/scene/written_units.h. Where the units differ by a power of ten, the point of
// the number moves: "20 ms" has the bits of 0.02. With other units and fractions the first 18 digits of a number count,
// and the result is rounded once; where pi enters, twice.

/// True when the value of an attribute is written with a unit.
bool hasUnit(std::string_view text);

/// `value` of `unit` in SI, rounded as often as it takes a factor.
double inSI(double value, const Unit& unit);

/// A number as it is written: "-9.81e3" is -981 * 10^1.
struct Decimal {
  std::uint64_t digits = 0;
  int ten = 0;
  bool negative = false;
};

/// (a / b) * unit / declared, rounded once (where pi enters, twice); none when it does not fit a double or b is zero.
std::optional<double> exactQuotient(const Decimal& a, const Decimal& b, const Unit& unit, const Unit& declared);

/// Every unit with its usual prefixes: for suggestions and the manual.
const std::vector<std::string>& unitNames();

}  // namespace stroma
