// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_terms.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace stroma::contact {

namespace {

/// A point against an edge: weights of its ends, difference.
Vec3 toEdge(const Vec3& p, const Vec3& a, const Vec3& b, double& of_b) {
  const Vec3 along = b - a;
  of_b = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - a) - of_b * along;
}

constexpr std::int64_t vertex_keys = 0, edge_keys = std::int64_t(1) << 40, face_keys = std::int64_t(2) << 40;

}  // namespace

Barrier::Barrier(double gap, double range) {
  const double r = gap / range;
  if (!(r < 1)) {
    value = slope = curvature = 0;
    return;
  }
  if (!(r > 0)) {
    value = curvature = std::numeric_limits<double>::infinity();
    slope = -value;
    return;
  }
  const double from = r - 1, log = std::log(r);
  value = -range * from * from * log;
  slope = -(2 * from * log + from * from / r);
  curvature = -(2 * log + 4 * from / r - from * from / (r * r)) / range;
}

Penalty::Penalty(double gap, double range) {
  const double in = 1 - gap / range;
  if (in > 0) value = 0.5 * range * in * in, slope = -in, curvature = 1 / range;
}

Slopes Adhesion::at(double gap) const {
  if (!(strength > 0) || !(gap < range)) return {};
  if (gap < peak)
    return {-0.5 * strength * (range - gap * gap / peak), strength * gap / peak, strength / peak};
  const double left = range - gap, falling = strength / (range - peak);
  return {-0.5 * falling * left * left, falling * left, -falling};
}

void BarrierLaw::compile() {
  candidates.reach = far() + thickness, candidates.thickness = thickness;
  candidates.reach_at_rest = is_penalty ? range + thickness : candidates.reach;
  candidates.compile(surfaces);
  vertex_share_.assign(surfaces.rows.size(), not_weighed);
  plane_share_.assign(planes.size() * surfaces.rows.size(), not_weighed);
  looked_revision_ = -1;
}

void BarrierLaw::look(const std::vector<Vec3>& x) const {
  if (looked_revision_ == candidates.revision() && areSame(x, looked_at_)) return;
  looked_revision_ = -1;
  in_reach_.clear();
  candidates.covers(x);
  if (!candidates.mayPush()) return;  // which costs no more to ask again than to remember
  looked_revision_ = candidates.revision(), looked_at_ = x;
  const auto& pairs = std::as_const(candidates).pairs();
  const double reach = far() + thickness;
  closest_.resize(pairs.size()), in_reach_.assign(pairs.size(), false);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!candidates.mayPush(pairs[i])) continue;
    const FourPoints points = candidates.pointsOf(pairs[i], x);
    if (pairs[i].kind == PairKind::edge_edge && leastOfParallel(points) > reach + pairs[i].radius) continue;
    closest_[i] = closestPoints(pairs[i].kind, points);
    in_reach_[i] = closest_[i].distance() < reach + pairs[i].radius;
  }
}

bool BarrierLaw::isOutOfReach(const std::vector<Vec3>& x) const {
  look(x);
  return planes.empty() && in_reach_.empty();
}

void BarrierLaw::addFeature(Feature feature) const {
  for (Feature& known : features_)
    if (known.key == feature.key) {
      known.count += feature.count;
      return;
    }
  features_.push_back(feature);
}

/// Of a vertex and a triangle: the closest feature of the triangle, and the edges and vertices that belong to it.
void BarrierLaw::addFeaturesOf(const Candidate& pair, const ClosestPoints& closest, const std::vector<Vec3>& x) const {
  const std::size_t f = std::size_t(pair.second);
  const auto keyOf = [&](int a, int b) {
    if (a == b || b < 0) return vertex_keys + a;
    for (const int e : surfaces.face_edges[f])
      if (e >= 0 && surfaces.sameEdge(e, a, b)) return edge_keys + e;
    return face_keys + std::int64_t(f);
  };
  std::array<int, 3> used{-1, -1, -1};
  int count = 0;
  for (std::size_t k = 1; k < 4; ++k)
    if (closest.weights[k] != 0 && std::find(used.begin(), used.begin() + count, pair.v[k]) == used.begin() + count)
      used[std::size_t(count++)] = pair.v[k];
  addFeature({count == 3 ? face_keys + std::int64_t(f) : keyOf(used[0], used[1]), 1, &pair, closest.weights,
              closest.difference});
  const Vec3& p = x[std::size_t(pair.v[0])];
  for (std::size_t k = 0; k < 3; ++k) {
    if (const int e = surfaces.owned_edges[f][k]; e >= 0 && surfaces.edge_surplus[std::size_t(e)] > 0) {
      const std::size_t j = k + 1, l = (k + 1) % 3 + 1;
      std::array<double, 4> c{1, 0, 0, 0};
      double of_l = 0;
      const Vec3 difference = toEdge(p, x[std::size_t(pair.v[j])], x[std::size_t(pair.v[l])], of_l);
      c[j] = of_l - 1, c[l] = -of_l;
      const std::int64_t key = of_l == 0 ? keyOf(pair.v[j], -1) : of_l == 1 ? keyOf(pair.v[l], -1) : edge_keys + e;
      addFeature({key, -surfaces.edge_surplus[std::size_t(e)], &pair, c, difference});
    }
    if (const int v = surfaces.owned_vertices[f][k]; v >= 0 && surfaces.vertex_count[std::size_t(v)] != 0) {
      std::array<double, 4> c{1, 0, 0, 0};
      c[k + 1] = -1;
      addFeature({vertex_keys + v, surfaces.vertex_count[std::size_t(v)], &pair, c, p - x[std::size_t(v)]});
    }
  }
}

void BarrierLaw::addTouch(const Candidate& pair, const std::array<double, 4>& c, const Vec3& difference, double share,
                          double small, bool of_surface) const {
  const double distance = difference.norm(), gap = distance - thickness - pair.radius;
  if (!(gap < (of_surface ? far() : std::max(range, alarm)))) return;
  const Vec3 n = distance > 0 ? Vec3(difference / distance) : Vec3::Zero();
  if (share != 0) touches_.push_back({pair.v, c, n, gap, share, range, of_surface});
  if (gap < small_range * range && small > 0 && !is_penalty)
    touches_.push_back({pair.v, c, n, gap, small, small_range * range});
}

void BarrierLaw::addVertexTouches(int vertex) const {
  const bool own = surfaces.moves(vertex);
  const double whole = surfaces.vertex_area[std::size_t(vertex)];
  const double part = std::isnan(vertex_share_[std::size_t(vertex)]) ? whole : vertex_share_[std::size_t(vertex)];
  for (const Feature& feature : features_) {
    if (feature.count == 0) continue;
    const bool two = own && surfaces.moves(feature.pair->v[3]);
    const double share = own ? (two ? 0.5 : 1) * part : 0;
    const double least = small_share * (own ? whole : surfaces.area[std::size_t(feature.pair->second)]);
    addTouch(*feature.pair, feature.c, feature.difference, feature.count * share, feature.count > 0 ? least : 0, true);
  }
}

void BarrierLaw::addEdgeTouches(const Candidate& pair, const ClosestPoints& closest, double factor) const {
  double share = std::numeric_limits<double>::infinity();
  for (const int e : {pair.first, pair.second})
    if (surfaces.edge_area[std::size_t(e)] > 0) share = std::min(share, surfaces.edge_area[std::size_t(e)]);
  if (std::isfinite(share)) addTouch(pair, closest.weights, closest.difference, factor * share, small_share * share, false);
}

void BarrierLaw::addPlaneTouches(const std::vector<Vec3>& x) const {
  for (std::size_t p = 0; p < planes.size(); ++p)
    for (std::size_t v = 0; v < x.size(); ++v) {
      if (!surfaces.moves(int(v))) continue;
      const double gap = gapToPlane(p, v, x[v]);
      if (!(gap < far())) continue;
      double& share = plane_share_[p * x.size() + v];
      if (std::isnan(share)) share = shareOf(int(v), planes[p].normal, x);
      const Touch touch{{int(v), -1 - int(p), -1, -1}, {1, 0, 0, 0}, planes[p].normal, gap, share, range, true};
      if (share > 0) touches_.push_back(touch);
      if (gap < small_range * range && !is_penalty) {
        touches_.push_back(touch);
        touches_.back().share = small_share * surfaces.vertex_area[v], touches_.back().range = small_range * range;
        touches_.back().of_surface = false;
      }
    }
}

const std::vector<Touch>& BarrierLaw::touches(const std::vector<Vec3>& x) const {
  weigh(x, Which::missing);
  touches_.clear();
  const auto& pairs = std::as_const(candidates).pairs();
  for (std::size_t i = in_reach_.empty() ? pairs.size() : 0; i < pairs.size();) {
    if (pairs[i].kind == PairKind::edge_edge) {
      if (in_reach_[i]) addEdgeTouches(pairs[i], closest_[i], pairs[i].factor);
      ++i;
      continue;
    }
    const int vertex = pairs[i].first;
    features_.clear();
    for (; i < pairs.size() && pairs[i].kind == PairKind::point_triangle && pairs[i].first == vertex; ++i)
      if (in_reach_[i]) addFeaturesOf(pairs[i], closest_[i], x);
    addVertexTouches(vertex);
  }
  addPlaneTouches(x);
  return touches_;
}

double BarrierLaw::energy(const std::vector<Vec3>& x) const {
  double sum = 0;
  for (const Touch& touch : touches(x)) sum += slopesOf(touch).value;
  return sum;
}

double BarrierLaw::longestStep(const std::vector<Vec3>& x, const std::vector<Vec3>& dx, const std::vector<double>& bend,
                               const Vec3& way) const {
  double step = candidates.longestStep(x, dx, bend);
  for (std::size_t p = 0; p < planes.size(); ++p)
    for (std::size_t v = 0; v < x.size(); ++v)
      if (surfaces.moves(int(v))) {
        const double off = bend.empty() ? 0 : bend[v], gap = gapToPlane(p, v, x[v]) - off;
        if (off > 0 && gap <= 0) return 0;
        step = std::min(step, longestStepToPlane(gap, planes[p].normal.dot(way - dx[v])));
      }
  return step;
}

void BarrierLaw::sumForces(const std::vector<Vec3>& x, std::vector<Vec3>& out) const {
  std::fill(out.begin(), out.end(), Vec3::Zero());
  for (const Touch& touch : touches(x)) {
    const Vec3 force = forceOf(touch);
    for (std::size_t i = 0; i < 4; ++i)
      if (touch.v[i] >= 0) out[std::size_t(touch.v[i])] += touch.c[i] * force;
  }
}

void BarrierLaw::addPattern(BlockPattern& pattern) const {
  for (const PairName& pair : candidates.patternPairs()) {
    std::array<Index, 4> rows;
    int count = 0;
    for (const int v : candidates.verticesOf(pair))
      if (const Index row = surfaces.rows[std::size_t(v)]; row >= 0) rows[std::size_t(count++)] = row;
    pattern.addClique(rows.data(), count);
  }
}

double relativeChange(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double change = 0, size = 0;
  for (std::size_t i = 0; i < b.size(); ++i) change += (b[i] - a[i]).squaredNorm(), size += b[i].squaredNorm();
  return change > 0 ? std::sqrt(change / std::max(change, size)) : 0;
}

}  // namespace stroma::contact
