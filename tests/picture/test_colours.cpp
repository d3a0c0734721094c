// SPDX-License-Identifier: LGPL-2.1-or-later
// Colour maps are the published ones, and go one way in lightness.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "framework/scene/diagnostics.h"
#include "tools/picture/colours.h"

namespace stroma::picture {
namespace {

int channel(double part) { return int(std::lround(255 * part)); }

/// As its authors have published it: the ends and the middle of each.
TEST(Colours, MapsAreThePublishedOnes) {
  const std::map<std::string, std::array<int, 3>> published{
      {"viridis", {0x440154, 0x21918c, 0xfde725}},
      {"cividis", {0x00224e, 0x7d7c78, 0xfee838}},
      {"inferno", {0x000004, 0xbc3754, 0xfcffa4}}};
  for (const auto& [name, colours] : published)
    for (int place = 0; place < 3; ++place)
      for (int c = 0; c < 3; ++c)
        EXPECT_EQ(channel(ColourMap(name).at(place / 2.)[std::size_t(c)]),
                  (colours[std::size_t(place)] >> (16 - 8 * c)) & 255)
            << name;
  EXPECT_EQ(colourMapNames(), (std::vector<std::string>{"viridis", "cividis", "diverging", "inferno", "warm", "grey"}));
}

/// A digit that slips in any of the 33 places of a map: sums of each channel, the first place once, the second twice and so on.
TEST(Colours, NoDigitOfAMapHasSlipped) {
  const std::map<std::string, std::array<int, 3>> sums{
      {"viridis", {61088, 98628, 53119}}, {"cividis", {94470, 89384, 55830}}, {"diverging", {103436, 76192, 76670}},
      {"inferno", {116587, 72141, 40162}}, {"warm", {121571, 41529, 30243}}, {"grey", {57222, 57222, 57222}}};
  for (const std::string& name : colourMapNames())
    for (std::size_t c = 0; c < 3; ++c) {
      int sum = 0;
      for (int place = 0; place < 33; ++place) sum += (place + 1) * channel(ColourMap(name).at(place / 32.)[c]);
      EXPECT_EQ(sum, sums.at(name)[c]) << name << " " << c;
    }
}

TEST(Colours, NeighbouringBodiesDiffer) {
  for (std::size_t number = 0; number < 8; ++number) EXPECT_NE(bodyColour(number), bodyColour(number + 1));
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
