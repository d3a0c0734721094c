// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/units/units.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <numbers>
#include <random>

#include "framework/scene/data.h"
#include "framework/scene/gravity.h"

namespace stroma {
namespace STROMA_TEST_FILE {

template <class T>
T parsed(const std::string& text, const std::string& unit) {
  T value{};
  Data data("value", &value);
  const auto problem = data.unit(unit).parse(text, DataOrigin::written);
  EXPECT_FALSE(problem) << text << " [" << unit << "]: " << problem->text();
  return value;
}

template <class T>
Problem refused(const std::string& text, const std::string& unit) {
  T value{};
  if constexpr (std::is_same_v<T, Vec3>) value.setZero();
  const T before = value;
  Data data("value", &value);
  const auto problem = data.unit(unit).parse(text, DataOrigin::written);
  EXPECT_TRUE(problem) << "accepted: " << text << " [" << unit << "]";
  EXPECT_EQ(value, before);
  EXPECT_FALSE(data.isSet());
  return problem.value_or(Problem{});
}

std::uint64_t bits(double value) { return std::bit_cast<std::uint64_t>(value); }

TEST(Units, HaveTheBitsOfTheNumberInSI) {
  struct Case {
    const char *text, *unit;
    double value;
  };
  const Case cases[] = {
      {"20 ms", "s", 0.02},
      {"10 kPa", "Pa", 10000},
      {"1.06 g/cm^3", "kg/m^3", 1060},
      {"-9810 mm/s^2", "m/s^2", -9.81},
      {"1e-9 t/mm^3", "kg/m^3", 1000},
      {"1.06e-6kg/mm^3", "kg/m^3", 1060},
      {"12 mmHg", "Pa", 1599.86864898},
      {"10 cmH2O", "Pa", 980.665},
      {"1 psi", "Pa", 6894.75729316836133672},
      {"0.3 bar", "Pa", 30000},
      {"10 N/mm", "N/m", 10000},
      {"3 mN mm^-1", "N/m", 3},
      {"5 dyn/cm", "N/m", 0.005},
      {"1e-3 m^2/(Pa s)", "m^4/(N s)", 1e-3},
      {"2 mm^4/(N s)", "m^4/(N s)", 2e-12},
      {"7 mm2/kPa/s", "m^4/(N s)", 7e-9},
      {"30 %", "-", 0.3},
      {"30%", "-", 0.3},
      {"2 mm/m", "-", 0.002},
      {"90 deg", "degree", 90},
      {"90°", "degree", 90},
      {"3 min", "s", 180},
      {"1.5 h", "s", 5400},
      {"6 1/min", "1/s", 0.1},
      {"6 /min", "1/s", 0.1},
      {"60/min", "1/s", 1},
      {"1/20", "s", 0.05},
      {"1/20 s", "s", 0.05},
      {"-1/3", "-", -1. / 3},
      {"1/3 ms", "s", 1. / 3000},
      {"0.5/1e3 km", "m", 0.5},
      {"2 mL", "m^3", 2e-6},
      {"2 cm³", "m^3", 2e-6},
      {"5 µm", "m", 5e-6},
      {"5 μm", "m", 5e-6},
      {"3 N·s/m", "N s/m", 3},
      {"3 N.s/m", "N s/m", 3},
      {"3 kPa s", "N s/m^2", 3000},
      {"1 in", "m", 0.0254},
      {"4 mJ", "N m", 0.004},
      {"500 MB", "GB", 0.5},
      {"+1.5e+1 mm", "m", 0.015},
      {"-0 mm", "m", -0.0},
      {"123456789012345678 nm", "m", 123456789.012345678},
      {"0.000000000000000123 km", "m", 1.23e-13},
      {"1e300 km", "m", 1e303},
      {"0e999 km", "m", 0},
      {"0/7 min", "s", 0},
      {"1/ 100 s", "s", 0.01},
      {"1 / 100 s", "s", 0.01},
      {"1 /100", "s", 0.01},
      {"10 / s", "1/s", 10},
      {"6 1 / min", "1/s", 0.1},
      {"2 daN", "N", 20},
      {"3 cN", "N", 0.03},
      {"4 pN", "N", 4e-12},
      {"10 kPa mm/m", "Pa", 10},
      {"1655381971801263308800 MPa", "Pa", 1655381971801263308800e6},
  };
  for (const auto& [text, unit, value] : cases)
    EXPECT_EQ(bits(parsed<double>(text, unit)), bits(value)) << text << " gives " << parsed<double>(text, unit);
  EXPECT_EQ(parsed<double>("180 deg", "rad"), std::numbers::pi);
  EXPECT_EQ(parsed<double>("1 rad", "degree"), 180 / std::numbers::pi);
  EXPECT_EQ(parsed<double>("90 deg/s", "rad/s"), std::numbers::pi / 2);
}

/// A unit of ten's powers moves the point of the text; the double is then the nearest, as it is for a plain number.
TEST(Units, MoveTheDecimalPointOfAnyNumber) {
  struct Shift {
    const char *unit, *declared;
    int ten;
  };
  const Shift shifts[] = {{"mm", "m", -3},         {"um", "m", -6},          {"kPa", "Pa", 3},        {"GPa", "Pa", 9},
                          {"g/cm^3", "kg/m^3", 3}, {"t/mm^3", "kg/m^3", 12}, {"mm/s^2", "m/s^2", -3}, {"ms", "s", -3},
                          {"dyn/cm^2", "Pa", -1},  {"N/mm", "N/m", 3},       {"mm^3", "m^3", -9},     {"MPa", "Pa", 6}};
  std::mt19937_64 random(3);
  for (int i = 0; i < 100000; ++i) {
    const Shift& shift = shifts[random() % std::size(shifts)];
    const double value = std::ldexp(double(random() % (1ull << (1 + random() % 53))), int(random() % 60) - 30);
    const std::string number = Data("x", const_cast<double*>(&value)).print();
    const auto e = number.find('e');
    const int exponent = e == number.npos ? 0 : std::stoi(number.substr(e + 1));
    const std::string moved = number.substr(0, e) + "e" + std::to_string(exponent + shift.ten);
    ASSERT_EQ(bits(parsed<double>(number + " " + shift.unit, shift.declared)), bits(parsed<double>(moved, "")))
        << number << " " << shift.unit;
  }
}

TEST(Units, FractionsAreRoundedOnce) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 100000; ++i) {
    const auto a = random() % 1'000'000'000, b = 1 + random() % 1'000'000;
    const std::string text = std::to_string(a) + "/" + std::to_string(b);
    ASSERT_EQ(bits(parsed<double>(text, "s")), bits(double(a) / double(b))) << text;
    ASSERT_EQ(bits(parsed<double>(text + " ms", "s")), bits(double(a) / double(b * 1000))) << text;
    ASSERT_EQ(bits(parsed<double>(text + " min", "s")), bits(double(a * 60) / double(b))) << text;
  }
}

TEST(Units, OneAtTheEndServesAllNumbersOrEachHasItsOwn) {
  using List = std::vector<double>;
  EXPECT_EQ(parsed<List>("0 0 0 10 10 10 mm", "m"), (List{0, 0, 0, 0.01, 0.01, 0.01}));
  EXPECT_EQ(parsed<List>("1 mm 2 cm, 3 m", "m"), (List{0.001, 0.02, 3}));
  EXPECT_EQ(parsed<List>("1mm,2mm", "m"), (List{0.001, 0.002}));
  EXPECT_EQ(parsed<List>("1/4 1/2 s", "s"), (List{0.25, 0.5}));
  EXPECT_EQ(parsed<List>("1 2 3 1/min", "1/s"), (List{1. / 60, 2. / 60, 3. / 60}));
  EXPECT_EQ(parsed<List>("1 2 N s/mm", "N s/m"), (List{1000, 2000}));
  EXPECT_EQ(parsed<Vec3>("0 -9810 0 mm/s^2", "m/s^2"), Vec3(0, -9.81, 0));
  EXPECT_EQ(parsed<std::vector<Vec3>>("0 0 1  0 2 0 cm", "m"), (std::vector<Vec3>{{0, 0, 0.01}, {0, 0.02, 0}}));
  EXPECT_TRUE(parsed<List>("", "m").empty());
  for (const char* text : {"1 mm 2 3", "1 2 mm 3", "1 mm 2 mm 3", "1 2 mm 3 mm"})
    EXPECT_NE(refused<List>(text, "m").expected.find("one unit at the end for all numbers"), std::string::npos) << text;
  EXPECT_NE(refused<double>("1 2 mm", "m").message.find("more than one number"), std::string::npos);
  EXPECT_NE(refused<Vec3>("1 2 mm", "m").message.find("2 numbers instead of 3"), std::string::npos);
}

TEST(Units, AWrongOneIsRefusedWithWhatWasExpected) {
  const Problem length = refused<double>("10 mm", "Pa");
  EXPECT_EQ(length.message, "'mm' is the unit of a length");
  EXPECT_EQ(length.expected, "a pressure, such as Pa, kPa, MPa, mmHg");
  EXPECT_EQ(refused<double>("2 Hz", "rad/s").message, "'Hz' is the unit of a rate");
  EXPECT_EQ(refused<double>("0.45 kPa", "-").expected, "a number without unit");
  EXPECT_EQ(refused<double>("0.45 kPa", "").expected, "numbers without unit");
  EXPECT_EQ(refused<double>("45 %", "").expected, "numbers without unit");
  EXPECT_EQ(refused<double>("45 deg", "-").message, "'deg' is the unit of an angle");
  EXPECT_EQ(refused<double>("3 kg m", "Pa").message, "'kg m' is of another dimension");
  EXPECT_EQ(refused<double>("3 m s", "Pa").message, "'m s' is of another dimension");
  EXPECT_EQ(refused<double>("3 %", "Pa").message, "'%' is the unit of a pure number");
  refused<int>("3 mm", "m");
}

TEST(Units, DivisionByZeroSaysSo) {
  for (const char* text : {"1/0 s", "1/0", "1/ 0.0 ms"})
    EXPECT_NE(refused<double>(text, "s").message.find("divides by zero"), std::string::npos) << text;
}

TEST(Units, PercentStandsAlone) {
  using List = std::vector<double>;
  EXPECT_EQ(parsed<List>("10% 20 %", "-"), (List{0.1, 0.2}));
  EXPECT_EQ(parsed<List>("10 20 %", "-"), (List{0.1, 0.2}));
  for (const char* text : {"10 MPa%", "10 MPa %", "10 % MPa", "10 %*MPa", "10 MPa*%"})
    EXPECT_NE(refused<double>(text, "Pa").message.find("% is a unit of its own"), std::string::npos) << text;
}

TEST(Units, ADecimalCommaIsRefusedWithThePoint) {
  EXPECT_NE(refused<double>("1,5 kPa", "Pa").expected.find("'1.5 kPa'"), std::string::npos);
  EXPECT_NE(refused<std::vector<double>>("1,5 kPa", "Pa").expected.find("'1.5 kPa', or '1 5 kPa'"), std::string::npos);
  EXPECT_EQ(refused<double>("1,5", "Pa").suggestion, "write 1.5");
  EXPECT_EQ(parsed<std::vector<double>>("1, 5 kPa", "Pa"), (std::vector<double>{1000, 5000}));
  EXPECT_EQ(parsed<std::vector<double>>("1,2,5 kPa", "Pa"), (std::vector<double>{1000, 2000, 5000}));
}

TEST(Units, AnAttributeMayHaveOneOfTwo) {
  EXPECT_EQ(parsed<double>("3 mN", "N or N s"), 0.003);
  EXPECT_EQ(parsed<double>("3 mN s", "N or N s"), 0.003);
  EXPECT_EQ(refused<double>("3 mm", "N or N s").expected,
            "a force, such as N, mN, dyn, or an impulse, such as N s, mN s");
  EXPECT_EQ(refused<double>("3 mn s", "N or N s").suggestion, "mN");
}

TEST(Units, AnUnknownOneIsRefusedWithTheNearest) {
  const auto suggestion = [](const char* text, const char* unit) { return refused<double>(text, unit).suggestion; };
  EXPECT_EQ(suggestion("10 kpa", "Pa"), "kPa");
  EXPECT_EQ(suggestion("10 Mpa", "Pa"), "MPa");
  EXPECT_EQ(suggestion("10 mmhg", "Pa"), "mmHg");
  EXPECT_EQ(suggestion("20 msec", "s"), "ms");
  EXPECT_EQ(suggestion("20 seconds", "s"), "s");
  EXPECT_EQ(suggestion("1 Kg/m^3", "kg/m^3"), "kg");
  EXPECT_EQ(suggestion("3 metre", "m"), "m");
  EXPECT_EQ(suggestion("1 Nm", "N m"), "N m");
  EXPECT_EQ(suggestion("1 Ns", "N s"), "N s");
  EXPECT_EQ(suggestion("1 Pas", "N s/m^2"), "Pa s");
  EXPECT_EQ(refused<Vec3>("1 0 0 Nm", "N m").suggestion, "N m");
  for (const char* force : {"1 Nm", "1 nm3", "1 kn"}) {
    const std::string found = suggestion(force, "N");
    EXPECT_TRUE(found.empty() || readUnit(found).dimension == readUnit("N").dimension) << force << " " << found;
  }
  EXPECT_EQ(suggestion("1 kn", "N"), "kN");
  EXPECT_EQ(suggestion("1 Ms", "s"), "ms");
  EXPECT_EQ(suggestion("1 PA, 2 Pa", "Pa"), "Pa");
  EXPECT_EQ(refused<double>("10 kpa", "Pa").expected, "a pressure, such as Pa, kPa, MPa, mmHg");
  EXPECT_EQ(refused<double>("10 kpa", "Pa").message, "'kpa' is not a unit");
  for (const char* number : {"nan", "inf", "-nan", "NaN"})
    EXPECT_NE(refused<std::vector<Vec3>>(std::string("0 0 ") + number, "m").message.find("is not a"),
              std::string::npos);
  EXPECT_EQ(refused<std::vector<Vec3>>("0 0 nan", "m").message, "'nan' is not a finite number");
  EXPECT_EQ(refused<std::vector<Vec3>>("1 mm 0 inf", "m").message, "'inf' is not a finite number");
}

TEST(Units, JunkKeepsItsOwnSentence) {
  EXPECT_NE(refused<double>("abc", "Pa").message.find("not a real number"), std::string::npos);
  EXPECT_NE(refused<double>("", "Pa").message.find("empty"), std::string::npos);
  EXPECT_NE(refused<double>("1.0x", "-").message.find("not a real number"), std::string::npos);
  for (const char* text :
       {"1.2.3 mm", "1 mm @",   "mm",     "mm 3",   "1 m^",         "1 m^x",   "1 (m",
        "1 m)",     "1 m//s",   "1 m^99", "1 /",    "1/0",          "1/0 m",   "1/ m",
        "1e999 mm", "1e308 km", "nan mm", "-inf m", "0x10 m",       "1 m^9^9", "1 ((((((((((m))))))))))",
        "1 m -",    "--1 m",    "1..2 m", "1e m m", "1 psi^9 psi^9"})
    refused<double>(text, "m");
  EXPECT_NE(refused<double>("3 kg/m s", "Pa").expected.find("brackets"), std::string::npos);
}

TEST(Units, NamesHaveOneMeaning) {
  for (const std::string& name : unitNames()) {
    const auto unit = findUnit(name);
    ASSERT_TRUE(unit) << name;
    EXPECT_EQ(std::count(unitNames().begin(), unitNames().end(), name), 1) << name;
    EXPECT_NE(describe(unit->dimension).find(unit->dimension == Dimension{} ? "number" : "such as"), std::string::npos)
        << name;
  }
  EXPECT_EQ(parsed<double>("1 min", "s"), 60) << "no milli-inch";
  EXPECT_EQ(parsed<double>("1 h", "s"), 3600);
  EXPECT_FALSE(findUnit("Mm"));
}

TEST(Units, FactorsOfFiles) {
  EXPECT_EQ(inSI(80, readUnit("mm")), 0.08);
  EXPECT_EQ(inSI(12.5, readUnit("cm")), 0.125);
  EXPECT_EQ(inSI(1, readUnit("in")), 0.0254);
  EXPECT_EQ(inSI(7, readUnit("m")), 7);
}

TEST(Units, LengthsOfFilesAreLengths) {
  EXPECT_EQ(inSI(5, readLengthUnit(" µm ")), 5e-6);
  for (const auto& [text, suggestion] :
       {std::pair{"kg", ""}, {"millimetre", "mm"}, {"MM", "mm"}, {"", ""}, {"mm mm", ""}})
    try {
      readLengthUnit(text);
      ADD_FAILURE() << text;
    } catch (const ComponentError& error) {
      EXPECT_EQ(error.expected, "a length, such as m, cm, mm") << text;
      EXPECT_EQ(error.suggestion, suggestion) << text;
    }
}

TEST(Units, ATextWithOneIsTold) {
  EXPECT_TRUE(hasUnit("1 2 3 mm"));
  EXPECT_TRUE(hasUnit("1 mm 2"));
  EXPECT_FALSE(hasUnit("1 2 3"));
  EXPECT_FALSE(hasUnit("1/20"));
  EXPECT_FALSE(hasUnit("1e3 liver"));
  EXPECT_FALSE(hasUnit("organ"));
}

TEST(Gravity, OneNumberActsAlongY) {
  Vec3 gravity = Vec3::Zero();
  std::string note;
  EXPECT_FALSE(readGravity("-9810 mm/s^2", gravity, note));
  EXPECT_EQ(gravity, Vec3(0, -9.81, 0));
  EXPECT_NE(note.find("along y: 0 -9.81 0 m/s^2"), std::string::npos) << note;
  note.clear();
  EXPECT_FALSE(readGravity("0 0 -9.81", gravity, note));
  EXPECT_EQ(gravity, Vec3(0, 0, -9.81));
  EXPECT_TRUE(note.empty());
  EXPECT_FALSE(readGravity("0", gravity, note));
  EXPECT_EQ(gravity, Vec3(0, 0, 0));
  EXPECT_TRUE(note.empty()) << "nothing acts: no direction to tell";
  gravity = Vec3(1, 2, 3);
  for (const char* text : {"9.81 m/s^2", "+9.81", "981 cm/s^2"}) {
    const auto upwards = readGravity(text, gravity, note);
    ASSERT_TRUE(upwards) << text;
    EXPECT_NE(upwards->message.find("upwards"), std::string::npos) << text;
    EXPECT_EQ(upwards->suggestion, "write -" + std::string(text + (text[0] == '+' ? 1 : 0)));
    EXPECT_EQ(gravity, Vec3(1, 2, 3)) << text;
  }
  EXPECT_FALSE(readGravity("0 9.81 0", gravity, note)) << "three numbers may point anywhere";
  const auto two = readGravity("0 -9.81", gravity, note);
  ASSERT_TRUE(two);
  EXPECT_NE(two->message.find("2 numbers instead of 3"), std::string::npos);
  const auto wrong = readGravity("0 -9.81 0 m/s", gravity, note);
  ASSERT_TRUE(wrong);
  EXPECT_NE(wrong->expected.find("an acceleration, such as m/s^2"), std::string::npos);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma
