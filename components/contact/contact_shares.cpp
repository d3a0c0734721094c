// SPDX-License-Identifier: LGPL-2.1-or-later
// The shares of vertices in their surfaces, and the sharpness of ridges: quantities fixed during a solve (contact_terms.h).
//
// A vertex has one share for all of its contacts, so that the energy of a solve has no jumps when it moves from one triangle
// to the next. It is the mean of the parts A(u_k) that face each of these features, which have directions u_k, pressures p_k
// and counts c_k:
//   A = sum c_k p_k A(u_k) / sum c_k p_k
// For a vertex pressed from two sides, using only the nearest one would jump as the two alternate.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "components/contact/contact_terms.h"

namespace stroma::contact {
namespace {

double smoothStep(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// Edges that push each other bend their surfaces until they are ridges no more: a factor a leads to a smaller one b, with a slope
/// far below -1 where it is about to vanish. The next one is that for which the line through the last two (a, b) has a = b.
double nextFactor(const Candidate& pair, double found) {
  if (pair.factor == pair.tried) return found;  // what has stayed has no slope
  const double slope = (found - pair.found) / (pair.factor - pair.tried);
  return pair.factor + (slope < 0 ? 1 / (1 - slope) : 1) * (found - pair.factor);
}

}  // namespace

/// In parts of the stiffness, by the gap alone: also where something pushes by another law, or pulls. It has no bound as the gap closes.
double BarrierLaw::pressureAt(double gap) const {
  constexpr double least = 1e-3;  // of the reach
  return -Barrier(std::max(gap, least * far()), far()).slope;
}

double BarrierLaw::shareOf(int vertex, const Vec3& towards, const std::vector<Vec3>& x) const {
  double sum = 0;
  const Adjacency& around = surfaces.faces_around;
  const bool closed = surfaces.isOneSided(vertex);
  for (Index k = around.start[std::size_t(vertex)]; k < around.start[std::size_t(vertex) + 1]; ++k) {
    const std::size_t f = std::size_t(around.values[std::size_t(k)]);
    const auto& [a, b, c] = surfaces.faces[f];
    const double of_corner = surfaces.corner_area[f][vertex == a ? 0 : vertex == b ? 1 : 2];
    if (a == b) {  // what is no triangle turns its width to what it meets
      sum += a == c ? of_corner : of_corner * (x[std::size_t(c)] - x[std::size_t(a)]).normalized().cross(towards).norm();
      continue;
    }
    const Vec3 n = (x[std::size_t(b)] - x[std::size_t(a)]).cross(x[std::size_t(c)] - x[std::size_t(a)]).normalized();
    const double facing = -n.dot(towards);
    sum += of_corner * (closed ? std::max(0.0, facing) : std::abs(facing));
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

double BarrierLaw::factorOf(const Candidate& pair, const ClosestPoints& closest, const std::vector<Vec3>& x) const {
  const double d = closest.distance();
  if (!(d > 0)) return 0;
  const Vec3 u = closest.difference / d;
  const double ridges = ridge(pair.first, u, x) * ridge(pair.second, -u, x);
  if (ridges == 0) return 0;
  const double squares = surfaces.edge_square[std::size_t(pair.first)] * surfaces.edge_square[std::size_t(pair.second)];
  return ridges * parallelFactor(x[std::size_t(pair.v[1])] - x[std::size_t(pair.v[0])],
                                 x[std::size_t(pair.v[3])] - x[std::size_t(pair.v[2])], squares);
}

void BarrierLaw::weigh(const std::vector<Vec3>& x) const {
  weighPlanes(x);
  weigh(x, Which::all);
}

void BarrierLaw::weighAgain(const std::vector<Vec3>& x) const {
  weighPlanes(x);
  weigh(x, Which::all_again);
}

double BarrierLaw::changeByWeighing(const std::vector<Vec3>& x, std::vector<Vec3>& before, std::vector<Vec3>& after) const {
  sumForces(x, before);
  weighAgain(x);
  sumForces(x, after);
  return relativeChange(before, after);
}

void BarrierLaw::copyShares(Shares& out) const {
  out.planes = plane_share_, out.is_weighed = is_weighed_, out.revision = candidates.revision();
  out.edges.clear(), out.edges.reserve(std::as_const(candidates).pairs().size());
  out.vertices.reserve(vertex_share_.size());
  if (!is_weighed_) return;  // the others are none
  out.vertices = vertex_share_;
  for (const Candidate& pair : std::as_const(candidates).pairs()) out.edges.push_back(pair.factor);
}

bool BarrierLaw::putBack(const Shares& shares) const {
  if (shares.revision != candidates.revision()) return false;
  plane_share_ = shares.planes;
  if (!is_weighed_ && !shares.is_weighed) return true;
  if (shares.is_weighed)
    vertex_share_ = shares.vertices;
  else
    std::fill(vertex_share_.begin(), vertex_share_.end(), not_weighed);
  auto& pairs = candidates.pairs();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    pairs[i].factor = shares.is_weighed ? shares.edges[i] : not_weighed;
    pairs[i].tried = pairs[i].found = not_weighed;
  }
  is_weighed_ = shares.is_weighed;
  return true;
}

void BarrierLaw::weighPlanes(const std::vector<Vec3>& x) const {
  std::fill(plane_share_.begin(), plane_share_.end(), not_weighed);
  for (std::size_t p = 0; p < planes.size(); ++p)
    for (std::size_t v = 0; v < x.size(); ++v)
      if (surfaces.moves(int(v)) && gapToPlane(p, v, x[v]) < far())
        plane_share_[p * x.size() + v] = shareOf(int(v), planes[p].normal, x);
}

void BarrierLaw::weigh(const std::vector<Vec3>& x, Which which) const {
  const bool all = which != Which::missing;
  look(x);
  auto& pairs = candidates.pairs();
  if (all && is_weighed_) {
    std::fill(vertex_share_.begin(), vertex_share_.end(), not_weighed);
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (in_reach_.empty() || !in_reach_[i]) pairs[i].factor = not_weighed;
    is_weighed_ = false;
  }
  if (in_reach_.empty()) return;
  is_weighed_ = true;
  for (std::size_t i = 0; i < pairs.size();) {
    if (pairs[i].kind == PairKind::edge_edge) {
      Candidate& pair = pairs[i];
      const bool is_known = !std::isnan(pair.factor);
      if (in_reach_[i] && (all || !is_known)) {
        const double found = factorOf(pair, closest_[i], x);
        const bool again = is_known && which == Which::all_again;
        const double next = again ? nextFactor(pair, found) : found;
        pair.tried = again ? pair.factor : not_weighed, pair.found = again ? found : not_weighed;
        pair.factor = next;
      }
      ++i;
      continue;
    }
    const std::size_t first = i;
    while (i < pairs.size() && pairs[i].kind == PairKind::point_triangle && pairs[i].first == pairs[first].first) ++i;
    double& share = vertex_share_[std::size_t(pairs[first].first)];
    if (std::isnan(share)) share = meanShare(first, i, x);
  }
}

/// Of the vertex of the pairs from `first` to `end`. Not known where none of them is in reach. Of one feature it is A to the last bit.
double BarrierLaw::meanShare(std::size_t first, std::size_t end, const std::vector<Vec3>& x) const {
  const auto& pairs = std::as_const(candidates).pairs();
  const int vertex = pairs[first].first;
  features_.clear();
  for (std::size_t i = first; i < end; ++i)
    if (in_reach_[i] && closest_[i].distance() > 0) addFeaturesOf(pairs[i], closest_[i], x);
  if (features_.empty()) return not_weighed;
  if (!surfaces.moves(vertex)) return 0;
  std::ranges::sort(features_, {}, [](const Feature& feature) { return feature.difference.squaredNorm(); });
  double least = std::numeric_limits<double>::infinity(), most = -least, nearest = 0, weights = 0, more = 0;
  for (const Feature& feature : features_) {
    const double d = feature.difference.norm();
    const double weight = feature.count == 0 || !(d > 0) ? 0 : feature.count * pressureAt(d - thickness - feature.pair->radius);
    if (weight == 0) continue;
    const double part = shareOf(vertex, feature.difference / d, x);
    if (most < 0) nearest = part;
    least = std::min(least, part), most = std::max(most, part);
    weights += weight, more += weight * (part - nearest);
  }
  if (most < 0) return not_weighed;
  return weights != 0 ? std::clamp(nearest + more / weights, least, most) : nearest;
}

}  // namespace stroma::contact
