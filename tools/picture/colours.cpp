// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/picture/colours.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "framework/scene/diagnostics.h"

namespace stroma::picture {
namespace {

struct Table {
  const char* name;
  std::string_view places;  ///< 33 of them, six hexadecimal digits each
};

// viridis (Smith, van der Walt), cividis (Nunez, Anderton, Renslow) and inferno (Smith, van der Walt); blue over a light grey to
// red, even in lightness on both sides; light yellow to dark red (Brewer); greys. A test holds the first three against the page.
constexpr std::array<Table, 6> tables{{
    {"viridis",
     "440154470d6048186a482374472d7b4537814240863e49893b528b375b8d33638d2f6b8e2c728e297a8e26828e23898e21918c1f988b1fa08"
     "8"
     "22a78528ae8032b67a3fbc734ec36b5ec96270cf5784d44b98d83eaddc30c2df23d8e219ece51bfde725"},
    {"cividis",
     "00224e00285b002e6a0533711a386f273e6e32436d3b496c434e6c4b546c535a6d5a5f6e61656f686a716f70737676767d7c788482798c887"
     "8"
     "938e789b9476a39a74aba072b4a76fbcae6cc4b468cdbb63d5c25edec958e7d150f0d846f9e03afee838"},
    {"diverging",
     "1b4f9c2959a23663a7436dac4f76b25c80b7698abc7593c1829dc68fa7ca9cb1cfa9bad4b6c4d8c3ceddd1d8e1dee2e6ececeae8dfdce5d3c"
     "e"
     "e1c6c1dcbab3d8ada6d3a198ce958bc9887ec47c71be7064b86358b2564bac493ea53b319f2c24981914"},
    {"inferno",
     "0000040403120b0724150b37210c4a2f0a5b3d09654a0c6b57106e64156e71196e7d1e6d8a226a972766a32c61b0315bbc3754c73e4cd2464"
     "4"
     "db503be45a31eb6628f1731df68013f98e09fb9d07fcac11fbbc21f9cb35f5db4cf2ea69f3f68afcffa4"},
    {"warm",
     "ffffccfffac1fff6b6fff1abffeda0ffe895fee38bfede80fed976fecf6bfec561febb56feb24cfea848fd9f44fd9640fd8c3cfd7c37fc6c3"
     "3"
     "fc5d2efc4d2af54026ef3323e9261fe2191cd9131fcf0c21c50624bb0026ac00269d00268d0026800026"},
    {"grey",
     "e6e6e6e0e0e0dadadad4d4d4cececec8c8c8c2c2c2bcbcbcb6b6b6b0b0b0aaaaaaa4a4a49e9e9e9898989292928c8c8c8686868080807a7a7"
     "a"
     "7474746e6e6e6868686262625c5c5c5656565050504a4a4a4444443e3e3e3838383232322c2c2c262626"},
}};

Colour fromHexadecimal(std::string_view six) {
  Colour colour;
  for (std::size_t c = 0; c < 3; ++c) colour[c] = std::stoi(std::string(six.substr(2 * c, 2)), nullptr, 16) / 255.;
  return colour;
}

}  // namespace

std::vector<std::string> colourMapNames() {
  std::vector<std::string> names;
  for (const Table& table : tables) names.emplace_back(table.name);
  return names;
}

ColourMap::ColourMap(const std::string& name) {
  const auto found = std::find_if(tables.begin(), tables.end(), [&](const Table& table) { return table.name == name; });
  if (found == tables.end())
    throw ComponentError(fmt::format("there is no colour map '{}'", name),
                         fmt::format("{}", fmt::join(colourMapNames(), ", ")), nearest(name, colourMapNames()));
  for (std::size_t i = 0; i + 6 <= found->places.size(); i += 6)
    places_.push_back(fromHexadecimal(found->places.substr(i, 6)));
  is_signed_ = name == "diverging";
}

Colour ColourMap::at(double t) const {
  const double place = std::clamp(t, 0., 1.) * double(places_.size() - 1);
  const auto i = std::min(places_.size() - 2, std::size_t(place));
  Colour colour;
  for (std::size_t c = 0; c < 3; ++c)
    colour[c] = places_[i][c] + (places_[i + 1][c] - places_[i][c]) * (place - double(i));
  return colour;
}

Colour bodyColour(std::size_t number) {
  // tissue, then bone, vessel, cartilage and others
  static constexpr std::array<std::string_view, 8> colours{"c98276", "d9cfb4", "7f96b8", "9db48f",
                                                           "b99ac0", "d3a865", "76aaa8", "a98a74"};
  return fromHexadecimal(colours[number % colours.size()]);
}

}  // namespace stroma::picture
