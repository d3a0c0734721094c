// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/kept_gaps.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace stroma::contact {

double boundOfRelativeMotion(PairKind kind, const FourPoints& ways) {
  const std::size_t first_side = kind == PairKind::point_triangle ? 1 : 2;
  double square = 0;
  for (std::size_t i = 0; i < first_side; ++i)
    for (std::size_t j = first_side; j < 4; ++j) square = std::max(square, (ways[i] - ways[j]).squaredNorm());
  return std::sqrt(square);
}

namespace {

constexpr double touching = 1e-3;  // of the gap to keep: what is nearer has been in contact, and will hardly be anywhere else

bool isOfParallelEdges(const Candidate& pair, const FourPoints& p) {
  constexpr double least = 1e-3;
  if (pair.kind != PairKind::edge_edge) return false;
  const Vec3 a = p[1] - p[0], b = p[3] - p[2];
  return a.cross(b).squaredNorm() <= least * a.squaredNorm() * b.squaredNorm();
}

/// How high [m] the bend of an edge is, which its triangles make: infinity for a ridge, or where it has not got two of them.
double heightOfBend(const Surfaces& s, int edge, const std::vector<Vec3>& x) {
  constexpr double of_ridge = 1e-3, rounding = 1e-7;  // rad
  constexpr double high = std::numeric_limits<double>::infinity();
  const auto& [p, q] = s.edges[std::size_t(edge)];
  const auto& [first, second] = s.edge_tips[std::size_t(edge)];
  if (first < 0 || second < 0 || s.edge_surplus[std::size_t(edge)] > 1) return high;
  const Vec3 along = x[std::size_t(q)] - x[std::size_t(p)];
  const Vec3 a = along.cross(x[std::size_t(first)] - x[std::size_t(p)]);
  const Vec3 b = (x[std::size_t(second)] - x[std::size_t(p)]).cross(along);
  const double product = a.norm() * b.norm();
  if (!(a.dot(b) > 0) || !(product > 0)) return high;
  const double angle = a.cross(b).norm() / product;
  return angle > of_ridge ? high : angle > rounding ? angle * along.norm() / 4 : 0;
}

/// How far the gap may be below zero before its condition comes: not at all where it is of a vertex or of ridges, by what is
/// tolerated where the vertices around nearly keep it, by any length over a flat surface.
double allowance(const KeptGap& gap, const BarrierLaw& law, const std::vector<Vec3>& x, double tolerated) {
  constexpr double low = 0.01;  // of the gap to keep
  if (gap.passing() < 4) return 0;
  const double bend = std::min(heightOfBend(law.surfaces, gap.pair->first, x), heightOfBend(law.surfaces, gap.pair->second, x));
  if (bend <= tolerated) return std::numeric_limits<double>::infinity();
  return bend <= low * law.range ? tolerated : 0;
}

}  // namespace

PathCheck checkPath(const BarrierLaw& law, const Candidate& pair, double start, const FourPoints& places, const FourPoints& ways,
                    double slack) {
  constexpr double part = 0.02, most = 0.1;
  const double moved = boundOfRelativeMotion(pair.kind, ways);
  start -= slack;
  if (start > 0 && moved < certainly_free * start) return {moved, 1};
  const double left = start > 0 ? std::min(most, part * law.range / start) : most;
  const double touching = pair.radius + (pair.pushes ? law.thickness : 0) + slack;
  return {moved, longestStep(pair.kind, places, ways, {.thickness = touching, .left = left})};
}

void KeptGap::place(const BarrierLaw& law, const std::vector<Vec3>& x) {
  if (!pair) {
    c[0] = 1;
    n = law.planes[plane].normal;
    start = law.gapToPlane(plane, std::size_t(v[0]), x[std::size_t(v[0])]);
  } else if (const FourPoints points = law.candidates.pointsOf(*pair, x); is_aligned) {
    const Vec3 along = points[1] - points[0], from = points[0] - points[2];
    const Vec3 beside = from - along * (along.dot(from) / along.squaredNorm());
    n = beside.norm() > 0 ? Vec3(beside.normalized()) : along.unitOrthogonal();
    start = leastOfParallel(points) - pair->radius - (pair->pushes ? law.thickness : 0);
    has_across = false;
  } else {
    const ClosestPoints closest = closestPoints(pair->kind, points);
    const double apart = closest.distance();
    c = closest.weights;
    if (apart > 0) n = closest.difference / apart;
    start = apart - pair->radius - (pair->pushes ? law.thickness : 0);
  }
  gap = start - law.range;
  across = tangent = n.unitOrthogonal();
}

bool KeptGap::staysFar(const BarrierLaw& law, double most) const {
  constexpr double rounding = 0.01;  // of the gap to keep
  return !has_closed && most < certainly_free * start && start - most > (1 + rounding) * law.range;
}

bool KeptGap::isFar(const BarrierLaw& law) const {
  constexpr double rounding = 0.01;  // of the gap to keep
  return pair && !has_closed && free == 1 && (is_aligned || start - moved > (1 + rounding) * law.range);
}

void KeptGap::look(const BarrierLaw& law, const std::vector<Vec3>& from, const std::vector<Vec3>& x, bool refresh) {
  if (!pair) {
    gap = law.gapToPlane(plane, std::size_t(v[0]), x[std::size_t(v[0])]) - law.range;
  } else {
    FourPoints points = law.candidates.pointsOf(*pair, x);
    double apart = 0;
    if (refresh) {
      for (std::size_t k = 0; k < 4 && free < 1; ++k) {
        const Vec3& place = from[std::size_t(v[k])];
        points[k] = place + free * (points[k] - place);
      }
      const ClosestPoints closest = closestPoints(pair->kind, points);
      apart = closest.distance();
      if (apart > 0) c = closest.weights, n = closest.difference / apart;
    }
    if (!refresh || free < 1) {
      apart = 0;
      for (std::size_t k = 1; k < 4; ++k) apart += c[k] * n.dot(x[std::size_t(v[k])] - x[std::size_t(v[0])]);
    }
    gap = apart - pair->radius - law.thickness - law.range;
  }
  turnTangent();
}

void KeptGap::turnTangent() {
  tangent = across - n * n.dot(across);
  const double length = tangent.norm();
  tangent = length > 0 ? Vec3(tangent / length) : n.unitOrthogonal();
}

/// Of d = min over y of |sum c_i(y) x_i| the second derivative has -d s s, s = T (T^T T)^-1 n . sum c_i,y dx_i with the ways T along
/// which the closest points may go; what it has besides is smaller by the size of a cell over d.
KeptGap::Turns KeptGap::turns(const BarrierLaw& law, const std::vector<Vec3>& x) const {
  constexpr double least = 0.1, none = 1e-9;  // of a cell; a weight
  Turns turns;
  if (!pair || free < 1) return turns;
  std::array<Vec3, 2> ways;
  const auto advanceRemainingMotion = [&](std::size_t from, std::size_t to) {
    if (turns.count == 2 || !(std::abs(c[from]) > none) || !(std::abs(c[to]) > none)) return;
    if (!law.surfaces.moves(v[from]) && !law.surfaces.moves(v[to])) return;  // an obstacle does not turn
    ways[std::size_t(turns.count)] = x[std::size_t(v[to])] - x[std::size_t(v[from])];
    turns.of[std::size_t(turns.count)][from] = -1, turns.of[std::size_t(turns.count)][to] = 1;
    ++turns.count;
  };
  if (pair->kind == PairKind::point_triangle)
    advanceRemainingMotion(1, 2), advanceRemainingMotion(1, 3), advanceRemainingMotion(2, 3);
  else
    advanceRemainingMotion(0, 1), advanceRemainingMotion(2, 3);
  for (int k = 0; k < turns.count; ++k)
    if (!(apart(law) > least * ways[std::size_t(k)].norm()) || !(ways[std::size_t(k)].norm() > 0)) turns.count = 0;
  if (turns.count == 0) return turns;
  const double length = ways[0].norm();
  for (double& of : turns.of[0]) of /= length;
  if (turns.count == 1) return turns;
  const Vec3 first = ways[0] / length;
  const double along = first.dot(ways[1]), across = (ways[1] - along * first).norm();
  if (!(across > none * length)) {
    turns.count = 1;
    return turns;
  }
  for (std::size_t i = 0; i < 4; ++i) turns.of[1][i] = (turns.of[1][i] - along * turns.of[0][i]) / across;
  return turns;
}

void KeptGaps::compile(const BarrierLaw& law, double tolerated, const std::vector<char>& rigid) {
  tolerated_ = tolerated;
  flush_.compile(law.surfaces, rigid), rigid_ = rigid;
  bodies_.clear();
  for (const Surfaces::Body& body : law.surfaces.bodies()) {
    bodies_.emplace_back();
    bodies_.back().vertices.resize(std::size_t(body.vertices));
    std::iota(bodies_.back().vertices.begin(), bodies_.back().vertices.end(), body.first_vertex);
  }
  moved_.resize(bodies_.size());
}

bool KeptGaps::begin(const BarrierLaw& law, const std::vector<Vec3>& x, double way, const std::vector<double>& ways) {
  copyPlaces(x, start_);
  moved_at_start_ = law.moved, way_ = way, unproved_ = 0, not_free_ = nullptr, keeps_directions_ = false;
  findPairs(law, x, ways);
  all_.clear(), watched_.clear(), watched_vertices_.clear(), flush_.begin();
  touches_.clear(), unexpected_.clear(), next_spare_ = 0, has_spares_ = false;
  if (!law.candidates.pairs().empty()) return true;
  addPlanes(law, x);
  next_spare_ = all_.size();
  return false;
}

void KeptGaps::addPairs(const BarrierLaw& law, const ExpectedMotion& ways) {
  for (const Candidate& pair : law.candidates.pairs()) add(pair, law, ways);
  evaluateFlush(law, start_);
  for (KeptGap& gap : all_) gap.flush_at_start = gap.flush;
  addPlanes(law, start_);
  addSpareConditions();
}

void KeptGaps::addPlanes(const BarrierLaw& law, const std::vector<Vec3>& x) {
  for (std::size_t p = 0; p < law.planes.size(); ++p)
    for (int v = 0; v < int(x.size()); ++v)
      if (law.surfaces.moves(v) && law.gapToPlane(p, std::size_t(v), x[std::size_t(v)]) < law.range + 2 * way_) {
        all_.push_back({.plane = p, .v = {v, -1, -1, -1}});
        all_.back().place(law, x);
        all_.back().has_closed = all_.back().gap < touching * law.range;
      }
}

/// Where the step starts.
void KeptGaps::makeGap(const Candidate& pair, bool is_rigid, const BarrierLaw& law, KeptGap& gap) const {
  gap = {.pair = &pair, .v = pair.v, .is_rigid = is_rigid};
  const FourPoints points = law.candidates.pointsOf(pair, start_);
  gap.is_parallel = gap.is_parallel_at_start = isOfParallelEdges(pair, points);
  gap.is_aligned = gap.is_aligned_at_start = gap.is_parallel && leastOfParallel(points) >= 0;
  gap.place(law, start_);
}

/// Most pairs are only watched, and need no more than their distance.
void KeptGaps::add(const Candidate& pair, const BarrierLaw& law, const ExpectedMotion& ways) {
  const double start = pair.distance - (pair.pushes ? law.thickness : 0);
  const bool is_rigid = isRigidAt(law, pair.v[0]) && isRigidAt(law, pair.v[3]);
  const auto against = [&pair, &law](const std::vector<Vec3>& all) {
    return contact::boundOfRelativeMotion(pair.kind, law.candidates.pointsOf(pair, all));
  };
  const bool comes = pair.pushes && start - law.range <= 2 * std::max(against(ways.last), against(ways.straight)) + ways.other;
  const auto watchAlone = [&] {
    watch(pair, law);
    if (!is_rigid) watched_vertices_.insert(watched_vertices_.end(), pair.v.begin(), pair.v.end());
  };
  if (!comes) return watchAlone();
  KeptGap gap;
  makeGap(pair, is_rigid, law, gap);
  const bool may_be_flush = flush_.add(gap, law, start_);
  if (!may_be_flush && gap.is_parallel && !is_rigid) return watchAlone();
  gap.has_closed = !gap.is_parallel && gap.gap < touching * law.range && allowance(gap, law, start_, tolerated_) == 0;
  all_.push_back(gap);
}

/// Rigid bodies may turn edges out of parallel in a step: these then have a condition.
void KeptGaps::evaluateParallel(KeptGap& gap, const BarrierLaw& law, const std::vector<Vec3>& x) {
  if (!gap.is_parallel_at_start || !gap.is_rigid || gap.has_closed) return;
  gap.is_parallel = isOfParallelEdges(*gap.pair, law.candidates.pointsOf(*gap.pair, x));
  gap.is_aligned = gap.is_parallel && gap.is_aligned_at_start;
  if (!gap.is_parallel) findAcross(gap, law);
}

void KeptGaps::findAcross(KeptGap& gap, const BarrierLaw& law) {
  if (std::exchange(gap.has_across, true)) return;
  KeptGap there = gap;
  there.is_aligned = false, there.place(law, start_), gap.across = there.across;
}

void KeptGaps::look(const BarrierLaw& law, const std::vector<Vec3>& x) {
  if (start_.size() != x.size()) return;  // between a restored state and its first step
  unproved_ = beyond(law, x);
  findFirstTouches(law, x);
  bool are_kept = true;
  makeConditions(law, x);
  for (KeptGap& gap : all_) {
    if (gap.is_spare) continue;
    gap.is_trusted = isTrusted(gap, law, x);
    evaluateParallel(gap, law, x);
    gap.is_lower_bound = gap.isFar(law);
    if (gap.is_lower_bound)
      gap.gap = gap.start - gap.moved - law.range;
    else
      gap.look(law, start_, x, gap.is_trusted);
  }
  evaluateFlush(law, x);
  for (KeptGap& gap : all_) {
    if (gap.flush == KeptGap::Flush::no && !gap.is_parallel)
      gap.has_closed = gap.has_closed || (gap.is_trusted && gap.gap < 0 && allowance(gap, law, x, tolerated_) == 0);
    are_kept = are_kept && !(gap.has_closed && gap.gap < -tolerated_);
  }
  for (KeptGap& gap : all_) {  // over faces that are nearly flat only what is left when the others hold
    const bool is_alone = gap.is_trusted && gap.flush == KeptGap::Flush::no && !gap.is_parallel;
    const bool is_left = are_kept && !gap.has_closed && gap.gap < -tolerated_ && is_alone;
    gap.is_active = gap.has_closed = gap.has_closed || (is_left && gap.gap < -allowance(gap, law, x, tolerated_));
  }
  ignoreDuplicates();
  if (keeps_directions_) restoreDirections(law, x);
}

void KeptGaps::evaluateFlush(const BarrierLaw& law, const std::vector<Vec3>& x) {
  constexpr double together = 0.01, rounding = 1e-3;  // of the gap to keep
  flush_.look(all_, x, together * law.range);
  for (KeptGap& gap : all_) {
    if (gap.flush == KeptGap::Flush::corner) {
      double apart = 0;
      for (std::size_t k = 1; k < 4; ++k) apart += gap.c[k] * gap.n.dot(x[std::size_t(gap.v[k])] - x[std::size_t(gap.v[0])]);
      gap.gap = gap.upright * apart - gap.pair->radius - law.thickness - law.range, gap.is_lower_bound = false;
      findAcross(gap, law);
      gap.turnTangent();
      gap.has_closed = gap.has_closed || gap.gap < rounding * law.range;
    } else if (gap.flush == KeptGap::Flush::beside) {
      gap.has_closed = false;
    }
  }
}

/// What is far is only looked at where its bound is the smallest. Nearly parallel edges have a vertex that is as near to a face.
double KeptGaps::smallest(const BarrierLaw& law, const std::vector<Vec3>& x) {
  double least = std::numeric_limits<double>::infinity();
  for (const KeptGap& gap : all_)
    if (!gap.is_lower_bound && !gap.is_spare && !(keeps_directions_ && gap.pair && gap.is_active)) least = std::min(least, gap.gap);
  for (const KeptGap& gap : all_)
    if (keeps_directions_ && gap.pair && gap.is_active && !gap.is_aligned) {
      KeptGap there = gap;
      there.look(law, start_, x, true), least = std::min(least, there.gap);
    }
  for (KeptGap& gap : all_)
    if (gap.is_lower_bound && !gap.is_spare && !gap.is_aligned && gap.gap < least)
      gap.look(law, start_, x, true), least = std::min(least, gap.gap);
  if (!std::isfinite(least) && !all_.empty()) least = std::ranges::min(all_, {}, &KeptGap::gap).gap;
  return least;
}

void KeptGaps::ignoreDuplicates() {
  constexpr double none = 1e-9;  // a weight
  keys_.clear();
  for (std::size_t i = 0; i < all_.size(); ++i) {
    const KeptGap& gap = all_[i];
    if (!gap.pair || !gap.is_active) continue;
    std::array<int, 4> key{-1, -1, -1, -1};
    for (std::size_t k = 0; k < 4; ++k)
      if (std::abs(gap.c[k]) > none) key[k] = gap.v[k];
    std::sort(key.begin(), key.end());
    keys_.push_back({key, keeps_directions_ && !kept_[i].is_any, i});
  }
  std::sort(keys_.begin(), keys_.end());
  for (std::size_t k = 1; k < keys_.size(); ++k)
    if (keys_[k].vertices == keys_[k - 1].vertices) all_[keys_[k].gap].is_active = false;
}

/// The way of the two places past each other in the step.
Vec3 KeptGaps::slide(const KeptGap& gap, const BarrierLaw& law, const std::vector<Vec3>& x) const {
  if (!gap.pair) {
    const std::size_t v = std::size_t(gap.v[0]);
    return (x[v] - law.moved) - (start_[v] - moved_at_start_);
  }
  Vec3 way = Vec3::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t v = std::size_t(gap.v[k]);
    way += gap.c[k] * (x[v] - start_[v]);
  }
  return way;
}

}  // namespace stroma::contact
