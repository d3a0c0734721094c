// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_terms.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace stroma::contact {

namespace {

constexpr double small_range = 0.1, small_share = 0.1;

/// A point against an edge: weights of its ends, difference.
Vec3 toEdge(const Vec3& p, const Vec3& a, const Vec3& b, double& of_b) {
  const Vec3 along = b - a;
  of_b = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - a) - of_b * along;
}

double smoothStep(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3 - 2 * t);
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
    value = slope = curvature = std::numeric_limits<double>::infinity();
    return;
  }
  const double from = r - 1, log = std::log(r);
  value = -range * from * from * log;
  slope = -(2 * from * log + from * from / r);
  curvature = -(2 * log + 4 * from / r - from * from / (r * r)) / range;
}

void BarrierLaw::compile() {
  candidates.reach = range + thickness;
  candidates.compile(surfaces);
  plane_vertex_.assign(surfaces.rows.size(), false);
  for (std::size_t v = 0; v < plane_vertex_.size(); ++v) plane_vertex_[v] = surfaces.moves(int(v));
  vertex_share_.assign(surfaces.rows.size(), 0);
}

void BarrierLaw::look(const std::vector<Vec3>& x) const {
  const auto& pairs = candidates.pairs();
  closest_.resize(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (pairs[i].pushes) closest_[i] = closestPoints(pairs[i].kind, candidates.pointsOf(pairs[i], x));
}

double BarrierLaw::wholeShareOf(int vertex) const {
  double sum = 0;
  const Adjacency& around = surfaces.faces_around;
  for (Index k = around.start[std::size_t(vertex)]; k < around.start[std::size_t(vertex) + 1]; ++k)
    sum += surfaces.area[std::size_t(around.values[std::size_t(k)])] / 3;
  return sum;
}

double BarrierLaw::shareOf(int vertex, const Vec3& towards, const std::vector<Vec3>& x) const {
  double sum = 0;
  const Adjacency& around = surfaces.faces_around;
  const bool closed = surfaces.bodies()[std::size_t(surfaces.bodyOf(vertex))].closed;
  for (Index k = around.start[std::size_t(vertex)]; k < around.start[std::size_t(vertex) + 1]; ++k) {
    const std::size_t f = std::size_t(around.values[std::size_t(k)]);
    const auto& [a, b, c] = surfaces.faces[f];
    const Vec3 n = (x[std::size_t(b)] - x[std::size_t(a)]).cross(x[std::size_t(c)] - x[std::size_t(a)]).normalized();
    const double facing = -n.dot(towards);
    sum += surfaces.area[f] / 3 * (closed ? std::max(0.0, facing) : std::abs(facing));
  }
  return sum;
}

/// How far an edge is a ridge towards a point that lies in direction -`away` from it: its triangles recede on both sides.
double BarrierLaw::ridge(int edge, const Vec3& away, const std::vector<Vec3>& x) const {
  constexpr double width = 0.1;
  const Vec3 &p = x[std::size_t(surfaces.edges[std::size_t(edge)][0])],
             &q = x[std::size_t(surfaces.edges[std::size_t(edge)][1])];
  const Vec3 along = (q - p).normalized();
  double factor = 1;
  for (const int tip : surfaces.edge_tips[std::size_t(edge)]) {
    if (tip < 0) continue;
    Vec3 inwards = x[std::size_t(tip)] - p;
    inwards = (inwards - along.dot(inwards) * along).normalized();
    factor *= smoothStep(inwards.dot(away) / width);
  }
  return factor;
}

void BarrierLaw::weigh(const std::vector<Vec3>& x) const {
  look(x);
  const auto& pairs = candidates.pairs();
  edge_factor_.assign(pairs.size(), 0);
  for (std::size_t i = 0; i < pairs.size();) {
    if (pairs[i].kind == PairKind::edge_edge) {
      const Candidate& pair = pairs[i];
      if (const double d = pair.pushes ? closest_[i].distance() : 0; d > 0) {
        const Vec3 u = closest_[i].difference / d;
        const double squares =
            surfaces.edge_square[std::size_t(pair.first)] * surfaces.edge_square[std::size_t(pair.second)];
        edge_factor_[i] = ridge(pair.first, u, x) * ridge(pair.second, -u, x);
        if (edge_factor_[i] > 0)
          edge_factor_[i] *= parallelFactor(x[std::size_t(pair.v[1])] - x[std::size_t(pair.v[0])],
                                            x[std::size_t(pair.v[3])] - x[std::size_t(pair.v[2])], squares);
      }
      ++i;
      continue;
    }
    const int vertex = pairs[i].first;
    double nearest = std::numeric_limits<double>::infinity();
    Vec3 towards = Vec3::Zero();
    for (; i < pairs.size() && pairs[i].kind == PairKind::point_triangle && pairs[i].first == vertex; ++i)
      if (const double d = pairs[i].pushes ? closest_[i].distance() : 0; d > 0 && d < nearest)
        nearest = d, towards = closest_[i].difference / d;
    vertex_share_[std::size_t(vertex)] =
        surfaces.moves(vertex) && std::isfinite(nearest) ? shareOf(vertex, towards, x) : 0;
  }
  plane_share_.assign(planes.size() * x.size(), std::numeric_limits<double>::quiet_NaN());
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
    if (const int e = surfaces.owned_edges[f][k]; e >= 0 && surfaces.edge_faces[std::size_t(e)][1] >= 0) {
      const std::size_t j = k + 1, l = (k + 1) % 3 + 1;
      std::array<double, 4> c{1, 0, 0, 0};
      double of_l = 0;
      const Vec3 difference = toEdge(p, x[std::size_t(pair.v[j])], x[std::size_t(pair.v[l])], of_l);
      c[j] = of_l - 1, c[l] = -of_l;
      const std::int64_t key = of_l == 0 ? keyOf(pair.v[j], -1) : of_l == 1 ? keyOf(pair.v[l], -1) : edge_keys + e;
      addFeature({key, -1, &pair, c, difference});
    }
    if (const int v = surfaces.owned_vertices[f][k]; v >= 0 && surfaces.inner[std::size_t(v)]) {
      std::array<double, 4> c{1, 0, 0, 0};
      c[k + 1] = -1;
      addFeature({vertex_keys + v, 1, &pair, c, p - x[std::size_t(v)]});
    }
  }
}

void BarrierLaw::addTouch(const Candidate& pair, const std::array<double, 4>& c, const Vec3& difference, double share,
                          double small) const {
  const double distance = difference.norm(), gap = distance - thickness - pair.radius;
  if (!(gap < range)) return;
  const Vec3 n = distance > 0 ? Vec3(difference / distance) : Vec3::Zero();
  if (share != 0) touches_.push_back({pair.v, c, n, gap, share, range});
  if (gap < small_range * range && small > 0) touches_.push_back({pair.v, c, n, gap, small, small_range * range});
}

void BarrierLaw::addVertexTouches(int vertex) const {
  const bool own = surfaces.moves(vertex);
  const double whole = own ? wholeShareOf(vertex) : 0;
  for (const Feature& feature : features_) {
    if (feature.count == 0) continue;
    const bool two = own && surfaces.moves(feature.pair->v[3]);
    const double share = own ? (two ? 0.5 : 1) * vertex_share_[std::size_t(vertex)] : 0;
    const double least = small_share * (own ? whole : surfaces.area[std::size_t(feature.pair->second)]);
    addTouch(*feature.pair, feature.c, feature.difference, feature.count * share, feature.count > 0 ? least : 0);
  }
}

void BarrierLaw::addEdgeTouches(const Candidate& pair, const ClosestPoints& closest, double factor) const {
  double share = std::numeric_limits<double>::infinity();
  for (const int e : {pair.first, pair.second})
    if (surfaces.edge_area[std::size_t(e)] > 0) share = std::min(share, surfaces.edge_area[std::size_t(e)]);
  if (std::isfinite(share)) addTouch(pair, closest.weights, closest.difference, factor * share, small_share * share);
}

void BarrierLaw::addPlaneTouches(const std::vector<Vec3>& x) const {
  for (std::size_t p = 0; p < planes.size(); ++p)
    for (std::size_t v = 0; v < x.size(); ++v) {
      if (!plane_vertex_[v]) continue;
      const double gap = gapToPlane(p, x[v]);
      if (!(gap < range)) continue;
      double& share = plane_share_[p * x.size() + v];
      if (std::isnan(share)) share = shareOf(int(v), planes[p].normal, x);
      const Touch touch{{int(v), -1, -1, -1}, {1, 0, 0, 0}, planes[p].normal, gap, share, range};
      if (share > 0) touches_.push_back(touch);
      if (gap < small_range * range) {
        touches_.push_back(touch);
        touches_.back().share = small_share * wholeShareOf(int(v)), touches_.back().range = small_range * range;
      }
    }
}

const std::vector<Touch>& BarrierLaw::touches(const std::vector<Vec3>& x) const {
  look(x);
  touches_.clear();
  const auto& pairs = candidates.pairs();
  const double far = range + thickness;
  for (std::size_t i = 0; i < pairs.size();) {
    if (pairs[i].kind == PairKind::edge_edge) {
      if (pairs[i].pushes) addEdgeTouches(pairs[i], closest_[i], edge_factor_[i]);
      ++i;
      continue;
    }
    const int vertex = pairs[i].first;
    features_.clear();
    for (; i < pairs.size() && pairs[i].kind == PairKind::point_triangle && pairs[i].first == vertex; ++i)
      if (pairs[i].pushes && closest_[i].distance() < far + pairs[i].radius) addFeaturesOf(pairs[i], closest_[i], x);
    addVertexTouches(vertex);
  }
  addPlaneTouches(x);
  return touches_;
}

double BarrierLaw::longestStep(const std::vector<Vec3>& x, const std::vector<Vec3>& dx, const Vec3& way) const {
  double step = candidates.longestStep(x, dx, thickness);
  for (std::size_t p = 0; p < planes.size(); ++p)
    for (std::size_t v = 0; v < x.size(); ++v)
      if (plane_vertex_[v])
        step = std::min(step, longestStepToPlane(gapToPlane(p, x[v]), planes[p].normal.dot(way - dx[v])));
  return step;
}

// ---- terms ----

void Terms::addForce(Rows f) const {
  for (const Term& t : *this)
    for (std::size_t i = 0; i < 4; ++i)
      if (t.rows[i] >= 0) f[t.rows[i]] += t.c[i] * t.force;
}

void Terms::addProduct(ConstRows dx, double factor, Rows df) const {
  for (const Term& t : *this) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < 4; ++i)
      if (t.rows[i] >= 0) sum += t.c[i] * dx[t.rows[i]];
    const Vec3 product = -factor * (t.m * sum);
    for (std::size_t i = 0; i < 4; ++i)
      if (t.rows[i] >= 0) df[t.rows[i]] += t.c[i] * product;
  }
}

void Terms::addPattern(BlockPattern& pattern) const {
  for (const Term& t : *this) {
    std::array<Index, 4> rows;
    int count = 0;
    for (const Index row : t.rows)
      if (row >= 0) rows[std::size_t(count++)] = row;
    pattern.addClique(rows.data(), count);
  }
}

void Terms::addTo(double factor, BlockMatrix& matrix) const {
  for (const Term& t : *this)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j)
        if (t.rows[i] >= 0 && t.rows[j] >= 0 && t.c[i] * t.c[j] != 0)
          matrix.add(t.rows[i], t.rows[j], -factor * t.c[i] * t.c[j] * t.m);
}

void Terms::addDiagonal(double factor, std::vector<double>& blocks) const {
  for (const Term& t : *this)
    for (std::size_t i = 0; i < 4; ++i) {
      if (t.rows[i] < 0) continue;
      double* block = blocks.data() + std::size_t(t.rows[i]) * 9;
      for (int k = 0; k < 9; ++k) block[k] -= factor * t.c[i] * t.c[i] * t.m(k / 3, k % 3);
    }
}

}  // namespace stroma::contact
