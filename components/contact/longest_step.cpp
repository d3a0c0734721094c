// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/longest_step.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
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

/// The smallest positive root of s + m[0] t + m[1] t^2 + m[2] t^3 for s < 0 and m >= 0, from below; infinite: none.
double rootFromBelow(double s, const std::array<double, 3>& m) {
  constexpr double parts = 3;  // one for each term
  double low = std::numeric_limits<double>::infinity();
  if (m[0] > 0) low = std::min(low, -s / (parts * m[0]));
  if (m[1] > 0) low = std::min(low, std::sqrt(-s / (parts * m[1])));
  if (m[2] > 0) low = std::min(low, std::cbrt(-s / (parts * m[2])));
  return low;
}

/// How long the volume of the four points, in the next `longest`, keeps the lines of two edges, or the point and the plane of the triangle,
/// apart by more than `least` and `keep` times `room`: with the cross product w of two edges, that distance is volume/|w|. Points that
/// slide along each other while the normal tilts have this alone. `size`: of coordinates, for their rounding.
double volumeFor(PairKind kind, const FourPoints& x, const FourPoints& v, double room, double least, double longest, double size) {
  const bool are_edges = kind == PairKind::edge_edge;
  const std::size_t a = are_edges ? 1 : 2, from_a = are_edges ? 0 : 1, from_b = are_edges ? 2 : 1;
  const Vec3 ea = x[a] - x[from_a], eb = x[3] - x[from_b], r = x[0] - x[from_b];
  const Vec3 va = v[a] - v[from_a], vb = v[3] - v[from_b], vr = v[0] - v[from_b];
  const std::array<Vec3, 3> w{ea.cross(eb), ea.cross(vb) + va.cross(eb), va.cross(vb)};
  std::array<double, 4> volume{w[0].dot(r), w[0].dot(vr) + w[1].dot(r), w[1].dot(vr) + w[2].dot(r), w[2].dot(vr)};
  if (volume[0] < 0)
    for (double& each : volume) each = -each;
  const double largest_a = ea.norm() + longest * va.norm(), largest_b = eb.norm() + longest * vb.norm();
  const double largest_r = r.norm() + longest * vr.norm();
  const double noise = 1e-14 * size * (largest_a * largest_b + (largest_a + largest_b) * largest_r);
  const double goal = least + keep * room, start = volume[0] - goal * w[0].norm() - noise;
  if (!(start > 0)) return 0;
  std::array<double, 3> falls{-volume[1], -volume[2], -volume[3]};
  for (std::size_t i = 0; i < 2; ++i) falls[i] += goal * w[i + 1].norm();
  for (double& each : falls) each = std::max(each, 0.0);
  return rootFromBelow(-start, falls);
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
  constexpr int most_advances = 1000, few_advances = 10;
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
    double free = std::max(everywhere, separatedFor(now, v, first_side, difference / length, room, least));
    if (advance >= few_advances)
      free = std::max(free, volumeFor(kind, now, v, room, least, options.longest - t, size + whole));
    t += free;
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
