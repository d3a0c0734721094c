// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/beams/rod_shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stroma {

namespace {
constexpr double slack = 1e-10;  ///< of the plug-in, times the length: what counts as a key point
}

double RodStretch::turnPerLength() const {
  return diameter > 0 ? 2 * std::numbers::pi / std::hypot(height, std::numbers::pi * diameter) : 0;
}

Placement RodStretch::at(double s) const {
  if (!(diameter > 0)) return {s * Vec3::UnitX(), Quaternion::Identity()};
  const double round = std::numbers::pi * diameter, theta = turnPerLength() * s, r = diameter / 2;
  const Vec3 place(r * std::sin(theta), height * s / std::hypot(height, round), r * (std::cos(theta) - 1));
  return {place, turnedBy(theta * Vec3::UnitY()) * turnedBy(std::atan(height / round) * Vec3::UnitZ())};
}

void RodShape::setStretches(std::vector<RodStretch> stretches) {
  stretches_ = std::move(stretches);
  starts_.assign(1, {});
  for (std::size_t i = 0; i + 1 < stretches_.size(); ++i) {
    const Placement &start = starts_[i], end = stretches_[i].at(stretches_[i].length);
    starts_.push_back({start.centre + start.turn * end.centre, start.turn * end.turn});
  }
}

std::size_t RodShape::stretchOf(double at) const {
  std::size_t i = 0;
  double end = stretches_[0].length;
  while (i + 1 < stretches_.size() && at > end + slack * length()) end += stretches_[++i].length;
  return i;
}

Placement RodShape::restAt(double at) const {
  const std::size_t i = stretchOf(at);
  double start = 0;
  for (std::size_t k = 0; k < i; ++k) start += stretches_[k].length;
  const Placement local = stretches_[i].at(std::clamp(at - start, 0., stretches_[i].length));
  return {starts_[i].centre + starts_[i].turn * local.centre, starts_[i].turn * local.turn};
}

void RodShape::fill(ChainBeam& beam, double from, double to) const {
  const RodStretch& stretch = stretchAt(to);
  const Placement a = restAt(from), b = restAt(to);
  beam.from = from, beam.to = to, beam.length = to - from;
  beam.section = stretch.section;
  beam.rest_way = a.turn.conjugate() * (b.centre - a.centre);
  beam.rest_turn = rotationVector(a.turn.conjugate() * b.turn);
  if (const double turn = stretch.turnPerLength() * beam.length; turn > 0.95 * std::numbers::pi)
    throw ComponentError(fmt::format("a beam of the rod {}, from {:.4g} to {:.4g}, turns by {:.3g} rad at rest", path(), from, to, turn),
                         "less than half a turn for each beam: a larger number in densityOfBeams (nbEdgesCollis of a RodSpireSection)");
}

}  // namespace stroma
