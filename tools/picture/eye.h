// SPDX-License-Identifier: LGPL-2.1-or-later
// Where a picture is seen from. Projections are parallel: lengths can be compared.
#pragma once
#include <limits>
#include <string>
#include <vector>

#include "framework/scene/types.h"

namespace stroma::picture {

/// Directions in the picture, orthonormal: to the right, up, and towards the one who looks.
struct Eye {
  std::string name;
  Vec3 right, up, back;
};

/// Words for --view.
std::vector<std::string> viewNames();

/// "front", "top", ..., or "AZIMUTH,ELEVATION" in degrees: from the front about the vertical, to the right, and above the
/// horizon. `third_axis_up`: z is up and the front looks along y; else y is up and the front looks against z. Throws
/// ComponentError with the nearest name.
Eye eyeOf(const std::string& view, bool third_axis_up);

/// What of space a picture shows, in the directions of an eye.
struct Extent {
  double low[3] = {1e300, 1e300, 1e300}, high[3] = {-1e300, -1e300, -1e300};  ///< right, up, back [m]
  double unit = 1;  ///< panels whose extents have the same one are drawn at the same scale [m]
  void include(const Eye& eye, const Vec3& p);
  bool isEmpty() const { return low[0] > high[0]; }
  double width() const { return isEmpty() ? 0 : high[0] - low[0]; }
  double height() const { return isEmpty() ? 0 : high[1] - low[1]; }
};

}  // namespace stroma::picture
