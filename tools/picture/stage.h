// SPDX-License-Identifier: LGPL-2.1-or-later
// The bodies of a scene as VTK draws them, without a display.
#pragma once
#include <memory>

#include "tools/picture/colours.h"
#include "tools/picture/eye.h"
#include "tools/picture/png.h"
#include "tools/picture/shots.h"

namespace stroma::picture {

class Stage {
 public:
  /// Throws std::runtime_error where nothing can be drawn.
  Stage();
  ~Stage();

  /// What is drawn, and how, in the place of what was before. `range`: of the colours. What is referred to must outlive the drawing.
  void build(const ShotTaker& taker, const PictureRequest& request, const ColourMap& map, const Range& range,
             const Eye& first_eye);
  void show(const Shot& shot);
  /// The shot as it is seen by an eye, at the middle of `extent`. The background is clear.
  Image draw(const Eye& eye, const Extent& extent, double metres_per_pixel, int width, int height);
  /// Grows an extent by what is drawn of some bodies of a shot.
  void include(const Shot& shot, const std::vector<std::size_t>& bodies, const Eye& eye, Extent& extent) const;
  const std::string& renderer() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stroma::picture
