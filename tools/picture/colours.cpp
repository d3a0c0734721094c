// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/picture/colours.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "framework/scene/diagnostics.h"
#include "tools/platform/text_file.h"

STROMA_TEXT_FILE(stroma_colours, STROMA_COLOURS)

namespace stroma::picture {
namespace {

const nlohmann::json& description() {
  static const auto all = nlohmann::json::parse(stroma_colours());
  return all;
}

/// Colours of six hexadecimal digits, with a space between two.
std::vector<Colour> fromHexadecimal(const std::string& text) {
  std::vector<Colour> colours;
  for (std::size_t at = 0; at < text.size(); at += 7) {
    Colour& colour = colours.emplace_back();
    for (std::size_t c = 0; c < 3; ++c) colour[c] = std::stoi(text.substr(at + 2 * c, 2), nullptr, 16) / 255.;
  }
  return colours;
}

}  // namespace

std::vector<std::string> colourMapNames() {
  std::vector<std::string> names;
  for (const auto& map : description().at("maps")) names.push_back(map.at("name"));
  return names;
}

ColourMap::ColourMap(const std::string& name) {
  const auto& maps = description().at("maps");
  const auto found = std::find_if(maps.begin(), maps.end(), [&](const auto& map) { return map.at("name") == name; });
  if (found == maps.end())
    throw ComponentError(fmt::format("there is no colour map '{}'", name),
                         fmt::format("{}", fmt::join(colourMapNames(), ", ")), nearest(name, colourMapNames()));
  for (const std::string row : found->at("places"))
    for (const Colour& colour : fromHexadecimal(row)) places_.push_back(colour);
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
  static const std::vector<Colour> colours = fromHexadecimal(description().at("bodies"));
  return colours[number % colours.size()];
}

}  // namespace stroma::picture
