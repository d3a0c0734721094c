// SPDX-License-Identifier: LGPL-2.1-or-later
// Colour maps are those of the live view, read from its page; those of print go one way in lightness.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <regex>
#include <sstream>

#include "framework/scene/diagnostics.h"
#include "tools/picture/colours.h"

namespace stroma::picture {
namespace {

std::string pageColours() {
  std::ifstream file(STROMA_SOURCE_DIR "/tools/view/page/src/colours.js");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The hexadecimal digits of a constant of the page, whatever lines they are written in.
std::string digitsOf(const std::string& constant) {
  const std::string text = pageColours();
  const auto start = text.find("const " + constant + " =");
  std::string digits;
  for (const char c : text.substr(start, text.find(';', start) - start).substr(constant.size() + 8))
    if (std::isxdigit(static_cast<unsigned char>(c))) digits += c;
  return digits;
}

int channel(double part) { return int(std::lround(255 * part)); }

TEST(Colours, MapsAreThoseOfTheLiveView) {
  for (const auto& [name, constant] : {std::pair("viridis", "VIRIDIS"), std::pair("cividis", "CIVIDIS")}) {
    const std::string digits = digitsOf(constant);
    ASSERT_EQ(digits.size(), 33u * 6) << constant;
    const ColourMap map(name);
    for (std::size_t i = 0; i < 33; ++i)
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_EQ(channel(map.at(double(i) / 32)[c]), std::stoi(digits.substr(6 * i + 2 * c, 2), nullptr, 16));
  }
}

TEST(Colours, BodiesHaveThoseOfTheLiveView) {
  const std::string text = pageColours();
  const auto start = text.find("const BODIES = [");
  const std::string list = text.substr(start, text.find(']', start) - start);
  const std::regex six("'([0-9a-f]{6})'");
  std::size_t number = 0;
  for (std::sregex_iterator i(list.begin(), list.end(), six), end; i != end; ++i, ++number)
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_EQ(channel(bodyColour(number)[c]), std::stoi((*i)[1].str().substr(2 * c, 2), nullptr, 16)) << number;
  EXPECT_EQ(number, 8u);
  EXPECT_EQ(bodyColour(8), bodyColour(0));
}

/// Relative luminance.
double lightness(const Colour& colour) {
  const auto linear = [](double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); };
  return 0.2126 * linear(colour[0]) + 0.7152 * linear(colour[1]) + 0.0722 * linear(colour[2]);
}

TEST(Colours, LightnessGoesOneWay) {
  for (const std::string name : {"viridis", "cividis", "inferno", "warm", "grey"}) {
    const ColourMap map(name);
    const double way = lightness(map.at(1)) > lightness(map.at(0)) ? 1 : -1;
    for (int i = 0; i < 32; ++i)
      EXPECT_GE(way * (lightness(map.at((i + 1) / 32.)) - lightness(map.at(i / 32.))), -1e-3) << name << i;
    EXPECT_FALSE(map.isSigned());
  }
  const ColourMap diverging("diverging");
  EXPECT_TRUE(diverging.isSigned());
  for (int i = 0; i < 16; ++i) {
    EXPECT_GT(lightness(diverging.at((i + 1) / 32.)), lightness(diverging.at(i / 32.)));
    EXPECT_NEAR(lightness(diverging.at(i / 32.)), lightness(diverging.at(1 - i / 32.)), 0.03);
  }
}

TEST(Colours, AnUnknownMapIsRefusedWithTheNearestName) {
  try {
    ColourMap("virdis");
    FAIL();
  } catch (const ComponentError& error) {
    EXPECT_EQ(error.suggestion, "viridis");
  }
}

}  // namespace
}  // namespace stroma::picture
