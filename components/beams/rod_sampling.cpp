// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/beams/rod_sampling.h"

#include <algorithm>
#include <cmath>

namespace stroma {

RodNodes sampleRods(const std::vector<PushedRod>& rods, double threshold) {
  RodNodes nodes;
  nodes.at.push_back(0);
  for (const PushedRod& rod : rods)
    for (const double point : rod.shape->keyPoints())
      if (rod.handle() + point > 0) nodes.at.push_back(rod.handle() + point);
  double divided = 0;
  for (const PushedRod& rod : rods)
    for (std::size_t i = 0; i < rod.shape->stretches().size(); ++i) {
      const RodStretch& stretch = rod.shape->stretches()[i];
      const double end = rod.handle() + rod.shape->keyPoints()[i + 1];
      if (end <= divided || stretch.beams == 0) continue;
      const double spacing = stretch.length / stretch.beams;
      for (int k = 1; k <= int(std::floor((end - divided) / spacing)); ++k) nodes.at.push_back(end - k * spacing);
      divided = end;
    }
  std::sort(nodes.at.begin(), nodes.at.end());
  nodes.at.erase(std::unique(nodes.at.begin(), nodes.at.end(), [threshold](double a, double b) { return b - a < threshold; }),
                 nodes.at.end());
  nodes.rods.resize(nodes.at.size());
  for (std::size_t n = 0; n < nodes.at.size(); ++n)
    for (std::size_t i = 0; i < rods.size(); ++i)
      if (rods[i].isAt(nodes.at[n], threshold)) nodes.rods[n].push_back(int(i));
  return nodes;
}

std::vector<double> formerPlaces(const RodNodes& now, double moved) {
  std::vector<double> former = now.at;
  std::size_t first = former.size();
  while (first > 1 && now.rods[first - 1].size() < 2) --first;  // of those that came along
  const double start = now.at[first - 1], end = now.at.back() - moved;
  std::size_t next = first;  // the first that was out before
  while (next < former.size() && now.at[next] - moved <= start) ++next;
  for (std::size_t n = next; n < former.size(); ++n) former[n] = now.at[n] - moved;
  // those that were not share what is before it
  const double upTo = next < former.size() ? former[next] : std::max(end, start);
  for (std::size_t n = first; n < next; ++n) former[n] = start + (upTo - start) * double(n - first + 1) / double(next - first + 1);
  return former;
}

namespace {

/// Turned the shortest way so that its x is along a unit vector.
Quaternion aligned(const Quaternion& q, const Vec3& x) {
  const Vec3 now = q.conjugate() * x;
  const double cosine = now.x();
  if (cosine > 1 - 1e-10) return q;
  const Vec3 axis = cosine < -1 + 1e-12 ? Vec3(Vec3::UnitZ()) : Vec3(Vec3(0, -now.z(), now.y()).normalized());
  return q * turnedBy(std::acos(std::clamp(cosine, -1., 1.)) * axis);
}

}  // namespace

Placement between(const Placement& a, const Placement& b, double length, double s) {
  const Vec3 start = length / 3 * (a.turn * Vec3::UnitX()), end = length / 3 * (b.turn * Vec3::UnitX());
  const Vec3 p1 = a.centre + start, p2 = b.centre - end, chord = b.centre - a.centre;
  const double r = 1 - s;
  // pushed together so far that the curve folds: the straight line
  if (start.dot(p2 - p1) < 0 && chord.norm() < 0.4 * length) return {r * a.centre + s * b.centre, a.turn.slerp(s, b.turn)};
  const Vec3 tangent = r * r * start + 2 * s * r * (p2 - p1) + s * s * end;
  const Vec3 place = r * r * r * a.centre + 3 * s * r * r * p1 + 3 * s * s * r * p2 + s * s * s * b.centre;
  if (!(tangent.norm() > 0)) return {place, a.turn.slerp(s, b.turn)};
  const Vec3 x = tangent.normalized();
  return {place, aligned(aligned(a.turn, x).slerp(s, aligned(b.turn, x)), x).normalized()};
}

}  // namespace stroma
