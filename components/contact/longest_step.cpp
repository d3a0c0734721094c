// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/longest_step.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stroma {
namespace {

constexpr double keep = 0.1;  // of a distance, in an advance

/// How long the direction of `difference` keeps the sides apart by more than `least`, from x on with velocities v.
double separatedFor(const FourPoints& x, const FourPoints& v, std::size_t first_side, const Vec3& n, double room,
                    double least) {
  double time = std::numeric_limits<double>::infinity();
  const double goal = least + keep * room;
  for (std::size_t i = 0; i < first_side; ++i)
    for (std::size_t j = first_side; j < 4; ++j) {
      const double gap = n.dot(x[i] - x[j]), rate = n.dot(v[i] - v[j]);
      if (gap <= goal) return 0;
      if (rate < 0) time = std::min(time, (goal - gap) / rate);
    }
  return time;
}

}  // namespace

double longestStep(PairKind kind, const FourPoints& x, const FourPoints& dx, const StepOptions& options) {
  const std::size_t first_side = kind == PairKind::point_triangle ? 1 : 2;
  FourPoints start, v, now;
  double largest = 0, places = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    start[i] = x[i] - x[0], v[i] = dx[i] - dx[0];
    places = std::max(places, x[i].cwiseAbs().maxCoeff() + dx[i].cwiseAbs().maxCoeff() * options.longest);
    largest = std::max({largest, start[i].cwiseAbs().maxCoeff(), v[i].cwiseAbs().maxCoeff() * options.longest});
    if (!start[i].allFinite() || !v[i].allFinite()) return 0;
  }
  // by a power of two, so that no square leaves the range of doubles
  const double unit = largest > 0 ? std::ldexp(1, std::clamp(-std::ilogb(largest), -1000, 1000)) : 1;
  const Vec3 mean = 0.25 * unit * (v[1] + v[2] + v[3]);
  double size = 0, speeds[2] = {0, 0};
  for (std::size_t i = 0; i < 4; ++i) {
    start[i] *= unit;
    v[i] = unit * v[i] - mean;
    size = std::max(size, start[i].norm());
    double& speed = speeds[i < first_side ? 0 : 1];
    speed = std::max(speed, v[i].norm());
  }
  const double speed = speeds[0] + speeds[1], whole = speed * options.longest;
  // of distances, and of the places where points will be: those are far larger than a small pair far from the origin
  const double noise = std::max(2e-12 * (size + whole), 1e-15 * unit * places), least = unit * options.thickness + noise;
  if (!(speed > 0)) return closestPoints(kind, start).distance() > noise ? options.longest : 0;
  double t = 0, stop = 0;
  constexpr int most_advances = 1000;
  for (int advance = 0; advance < most_advances; ++advance) {
    for (std::size_t i = 0; i < 4; ++i) now[i] = start[i] + t * v[i];
    const Vec3 difference = closestPoints(kind, now).difference;
    const double length = difference.norm(), room = length - least;
    if (advance == 0) {
      if (!(room > 0)) return 0;
      stop = options.left * room;
    } else if (!(room > stop)) {
      return t;
    }
    const double everywhere = (1 - keep) * room / speed;
    t += std::max(everywhere, separatedFor(now, v, first_side, difference / length, room, least));
    if (t >= options.longest) return options.longest;
  }
  return t;
}

double longestStepToPlane(double gap, double closing, const StepOptions& options) {
  const double room = gap - options.thickness;
  if (closing <= 0) return options.longest;
  if (!(room > 0)) return 0;
  const double time = (1 - options.left) * room / closing;
  return std::min(options.longest, time);
}

}  // namespace stroma
