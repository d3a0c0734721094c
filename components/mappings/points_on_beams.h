// SPDX-License-Identifier: LGPL-2.1-or-later
// Points on and about the cubic curve of a beam between two frames a and b, at the part s of its length L:
//
//   x = w_a (c_a + q_a p_a) + w_b (c_b + q_b p_b)
//   w_a = (1-s)^3 + 3 s (1-s)^2,   p_a = s (1-s)^2/w_a L e_x + (0, y, z),   w_b = 1 - w_a,   p_b = -s^2 (1-s)/w_b L e_x + (0, y, z)
#pragma once
#include "components/mappings/frame_mapping.h"

namespace stroma {

class PointsOnBeams : public FrameMapping {
 protected:
  /// A beam between frames of input(), with its axes in these.
  struct Beam {
    Index a = 0, b = 0;
    double length = 0;
    Quaternion axes_a = Quaternion::Identity(), axes_b = Quaternion::Identity();
  };
  static std::vector<Carried> onCurve(const Beam& beam, double s, const Vec3& offset) {
    const double r = 1 - s, of_a = r * r * r + 3 * s * r * r, of_b = s * s * s + 3 * s * s * r;
    const auto local = [&](double lever, double weight) {
      return Vec3((weight > 0 ? lever * beam.length / weight : 0.) * Vec3::UnitX() + offset);
    };
    return {{beam.a, of_a, beam.axes_a * local(s * r * r, of_a)}, {beam.b, of_b, beam.axes_b * local(-s * s * r, of_b)}};
  }
  /// The same with all other frames, which carry nothing: the blocks of a mapping stay the same.
  std::vector<Carried> amongAll(const std::vector<Carried>& by) const {
    std::vector<Carried> all;
    for (Index frame = 0; frame < input().nodes(); ++frame) all.push_back({frame, 0, Vec3::Zero()});
    for (const Carried& each : by) all[std::size_t(each.frame)] = each;
    return all;
  }
};

}  // namespace stroma
