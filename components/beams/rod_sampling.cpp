// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/beams/rod_sampling.h"

#include <algorithm>
#include <cmath>

namespace stroma {

namespace {

/// Tips that are out, from the last one back, each apart from the one before and from the opening.
std::vector<double> tipsOf(const std::vector<PushedRod>& rods, double threshold) {
  std::vector<double> tips, kept;
  for (const PushedRod& rod : rods) tips.push_back(rod.tip);
  std::sort(tips.rbegin(), tips.rend());
  for (const double tip : tips)
    if (tip >= threshold && (kept.empty() || kept.back() - tip >= threshold)) kept.push_back(tip);
  return kept;
}

/// Sorted, without what is nearer to the one before than the threshold: the opening, which is 0, and tips stay.
void keepApart(std::vector<double>& at, const std::vector<double>& tips, double threshold) {
  const auto isBesideTip = [&](double place) {
    return std::any_of(tips.begin(), tips.end(), [&](double tip) { return std::abs(tip - place) < threshold; });
  };
  std::erase_if(at, [&](double place) { return place > 0 && isBesideTip(place); });
  at.insert(at.end(), tips.begin(), tips.end());
  std::sort(at.begin(), at.end());
  at.erase(std::unique(at.begin(), at.end(), [threshold](double a, double b) { return b - a < threshold; }), at.end());
}

/// A helix may lie where another rod says how beams are divided: none of its own may turn by half a turn at rest.
void divideBends(std::vector<double>& at, const std::vector<PushedRod>& rods, double threshold) {
  constexpr double most = 2.5;  // [rad]
  std::vector<double> more;
  for (std::size_t n = 0; n + 1 < at.size(); ++n) {
    double turn = 0;
    for (const PushedRod& rod : rods)
      if (rod.isAt(at[n], threshold) && rod.isAt(at[n + 1], threshold))
        turn = std::max(turn, rod.shape->stretchAt(at[n + 1] - rod.handle()).turnPerLength() * (at[n + 1] - at[n]));
    const int parts = int(std::ceil(turn / most - 1e-9));
    for (int k = 1; k < parts; ++k) more.push_back(at[n] + (at[n + 1] - at[n]) * k / parts);
  }
  at.insert(at.end(), more.begin(), more.end());
  std::sort(at.begin(), at.end());
}

/// Of rigid stretches as far as rods are out, and beside them.
void addRigid(const RodSampling& sampling, double end, std::vector<double>& at) {
  for (std::size_t i = 0; i < sampling.rigid.size(); ++i) {
    const double place = sampling.rigid[i], beside = place + (i % 2 == 0 ? -sampling.step : sampling.step);
    if (place >= end) return;
    at.push_back(place);
    if (beside > 0 && beside < end) at.push_back(beside);
  }
}
bool isRigid(const RodSampling& sampling, double at) {
  for (std::size_t i = 0; i + 1 < sampling.rigid.size(); i += 2)
    if (at > sampling.rigid[i] - sampling.threshold && at < sampling.rigid[i + 1] + sampling.threshold) return true;
  return false;
}

}  // namespace

RodNodes sampleRods(const std::vector<PushedRod>& rods, const RodSampling& sampling) {
  const double threshold = sampling.threshold;
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
  const std::vector<double> tips = tipsOf(rods, threshold);
  if (!tips.empty()) addRigid(sampling, tips.front(), nodes.at);
  keepApart(nodes.at, tips, threshold);
  divideBends(nodes.at, rods, threshold);
  nodes.rods.resize(nodes.at.size());
  for (std::size_t n = 0; n < nodes.at.size(); ++n)
    for (std::size_t i = 0; i < rods.size(); ++i)
      if (rods[i].isAt(nodes.at[n], threshold)) nodes.rods[n].push_back(int(i));
  for (const double at : nodes.at) nodes.is_held.push_back(isRigid(sampling, at));
  return nodes;
}

namespace {

void look(const std::vector<PushedRod>& rods, const RodSampling& sampling, MostNodes& most) {
  const std::size_t nodes = sampleRods(rods, sampling).at.size();
  if (nodes <= most.nodes) return;
  most.nodes = nodes, most.tips.clear();
  for (const PushedRod& rod : rods) most.tips.push_back(rod.tip);
}

}  // namespace

MostNodes mostNodesOnWay(std::vector<PushedRod> rods, std::size_t moving, const RodSampling& sampling) {
  constexpr int places = 200;
  MostNodes most;
  const double start = rods[moving].tip, goal = rods[moving].shape->length();
  for (int i = 0; i <= places; ++i) {
    rods[moving].tip = start + (goal - start) * i / places;
    look(rods, sampling, most);
  }
  return most;
}

MostNodes mostNodesAnywhere(std::vector<PushedRod> rods, const RodSampling& sampling) {
  constexpr int places = 12;
  MostNodes most;
  std::vector<int> at(rods.size(), 0);
  for (std::size_t i = 0; i < at.size();) {
    for (std::size_t k = 0; k < at.size(); ++k) rods[k].tip = rods[k].shape->length() * at[k] / places;
    look(rods, sampling, most);
    for (i = 0; i < at.size() && ++at[i] > places; ++i) at[i] = 0;
  }
  return most;
}

std::vector<double> formerPlaces(const RodNodes& now, double moved) {
  std::vector<double> former = now.at;
  std::size_t first = former.size();
  while (first > 1 && now.rods[first - 1].size() < 2 && !now.is_held[first - 1]) --first;  // of those that came along
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
