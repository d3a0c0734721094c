// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/picture/eye.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "framework/scene/diagnostics.h"

namespace stroma::picture {
namespace {

struct Named {
  const char* name;
  double azimuth, elevation;  ///< [degrees]
};
constexpr double of_a_cube = 35.264389682754654;  // arctan(1/sqrt(2)): all edges of a cube look equally long
constexpr std::array<Named, 10> views{{{"oblique", 20, 16},
                                       {"iso", 45, of_a_cube},
                                       {"front", 0, 0},
                                       {"back", 180, 0},
                                       {"left", -90, 0},
                                       {"right", 90, 0},
                                       {"side", 90, 0},
                                       {"top", 0, 90},
                                       {"bottom", 0, -90},
                                       {"default", 20, 16}}};

/// y up, the front looks against z; turned when z is up.
Eye eyeAt(const std::string& name, double azimuth, double elevation, bool third_axis_up) {
  constexpr double degree = 3.14159265358979323846 / 180;
  const double ca = std::cos(azimuth * degree), sa = std::sin(azimuth * degree);
  const double ce = std::cos(elevation * degree), se = std::sin(elevation * degree);
  Eye eye{name, {ca, 0, -sa}, {-sa * se, ce, -ca * se}, {sa * ce, se, ca * ce}};
  if (third_axis_up)
    for (Vec3* v : {&eye.right, &eye.up, &eye.back}) *v = Vec3((*v)[0], -(*v)[2], (*v)[1]);
  for (Vec3* v : {&eye.right, &eye.up, &eye.back})
    for (int k = 0; k < 3; ++k)
      if (std::abs((*v)[k]) < 1e-12) (*v)[k] = 0;
  return eye;
}

}  // namespace

std::vector<std::string> viewNames() {
  std::vector<std::string> names;
  for (const Named& view : views) names.emplace_back(view.name);
  names.pop_back();  // another word for the first
  return names;
}

Eye eyeOf(const std::string& view, bool third_axis_up) {
  const auto found = std::find_if(views.begin(), views.end(), [&](const Named& one) { return one.name == view; });
  if (found != views.end()) return eyeAt(view, found->azimuth, found->elevation, third_axis_up);
  double azimuth = 0, elevation = 0;
  int read = 0;
  if (std::sscanf(view.c_str(), "%lf,%lf%n", &azimuth, &elevation, &read) == 2 && std::size_t(read) == view.size()) {
    if (!(std::abs(azimuth) <= 360 && std::abs(elevation) <= 90))
      throw ComponentError(fmt::format("the view {} is none", view),
                           "an azimuth up to 360 and an elevation up to 90 degrees");
    return eyeAt(fmt::format("{:g}°, {:g}°", azimuth, elevation), azimuth, elevation, third_axis_up);
  }
  throw ComponentError(fmt::format("there is no view '{}'", view),
                       fmt::format("{}, or AZIMUTH,ELEVATION in degrees", fmt::join(viewNames(), ", ")),
                       nearest(view, viewNames()));
}

void Extent::include(const Eye& eye, const Vec3& p) {
  const Vec3* directions[] = {&eye.right, &eye.up, &eye.back};
  for (int k = 0; k < 3; ++k) {
    const double along = directions[k]->dot(p);
    low[k] = std::min(low[k], along), high[k] = std::max(high[k], along);
  }
}

}  // namespace stroma::picture
