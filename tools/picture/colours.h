// SPDX-License-Identifier: LGPL-2.1-or-later
// Colour maps that are even to the eye and safe for the colour-blind: those of the live view, and others for print. They and the
// colours of bodies are in tools/drawing/colours.json, which the page of the view reads too.
#pragma once
#include <array>
#include <string>
#include <vector>

namespace stroma::picture {

using Colour = std::array<double, 3>;  ///< red, green, blue, 0 to 1, as a screen takes them (sRGB)

/// Names of the maps.
std::vector<std::string> colourMapNames();

class ColourMap {
 public:
  /// Throws ComponentError with the nearest name.
  explicit ColourMap(const std::string& name);
  Colour at(double t) const;                    ///< t from 0 to 1
  bool isSigned() const { return is_signed_; }  ///< its middle is a value of its own

 private:
  std::vector<Colour> places_;  ///< even from 0 to 1
  bool is_signed_ = false;
};

/// Muted colours that also differ in lightness: that of body `number` without a field.
Colour bodyColour(std::size_t number);

}  // namespace stroma::picture
