// SPDX-License-Identifier: LGPL-2.1-or-later
// What is drawn on a picture besides bodies: text, lines and areas, at the size of the finished picture.
#pragma once
#include <string>

#include "tools/picture/colours.h"
#include "tools/picture/png.h"

namespace stroma::picture {

/// Where of its box a text is placed: 0 left or top, 0.5 the middle, 1 right or bottom.
struct Anchor {
  double x = 0, y = 0;
};

/// How a text looks.
struct Letters {
  double size = 20;  ///< [pixels]
  Colour colour{0.13, 0.14, 0.16};
  bool bold = false;
  bool upwards = false;  ///< turned, from the bottom to the top
};

class Canvas {
 public:
  /// Empty: white, or nothing at all.
  Canvas(int width, int height, bool transparent);

  void fill(int x, int y, int width, int height, const Colour& colour);
  /// The triangle with corners [pixels].
  void fillTriangle(const std::array<double, 6>& corners, const Colour& colour);
  /// An image as it is; what lies beyond the canvas is left out.
  void paste(const Image& image, int x, int y);
  /// A text in UTF-8.
  void text(const std::string& text, double x, double y, Anchor anchor, const Letters& letters);
  const Image& image() const { return image_; }

 private:
  void blend(int x, int y, const Colour& colour, double opacity);
  Image image_;
};

/// Width and height of a text [pixels], as drawn.
std::array<int, 2> sizeOf(const std::string& text, const Letters& letters);

}  // namespace stroma::picture
