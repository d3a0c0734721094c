// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_start.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "components/contact/contact_inside.h"
#include "framework/collision/box_tree.h"
#include "framework/collision/pair_distances.h"

namespace stroma::contact {
namespace {

class Apart {
 public:
  Apart(const BarrierLaw& law, const std::vector<StartBody>& bodies, double gap, Index independent, Rows x)
      : law_(law), s_(law.surfaces), bodies_(bodies), gap_(gap), independent_(independent), x_(x),
        asked_(std::size_t(independent), Vec3::Zero()), driven_(asked_), moved_(asked_), times_(asked_.size(), 0),
        is_driven_(asked_.size(), false), start_(asked_.size()) {
    for (Index row = 0; row < independent; ++row) start_[std::size_t(row)] = x[row];
  }
  double run(const std::function<void(Rows)>& project);

 private:
  /// A point of a surface: vertices and their weights.
  struct Place {
    std::array<int, 3> v{-1, -1, -1};
    std::array<double, 3> c{0, 0, 0};
  };
  bool moves(int v) const { return v >= 0 && s_.rows[std::size_t(v)] >= 0 && s_.rows[std::size_t(v)] < independent_; }
  Vec3 at(const Place& place) const;
  bool collect();
  void collectInside();
  void collectFrom(int body, const std::vector<Candidates::Crossing>& crossings);
  void collectEdge(int body, int edge, const std::vector<int>& faces);
  void collectNear();
  void collectPlanes();
  void pushOut(const Place& inside, int body);
  void ask(const Place& first, const Place& second, const Vec3& direction, double way);
  void spread(const std::function<void(Rows)>& project);
  void prepareTrees();

  const BarrierLaw& law_;
  const Surfaces& s_;
  const std::vector<StartBody>& bodies_;
  const double gap_;
  const Index independent_;
  Rows x_;
  std::vector<Vec3> points_;                   ///< of all vertices
  std::vector<Vec3> asked_, driven_, moved_;   ///< of rows: in this round; of those that something was asked of; of all
  std::vector<int> times_;                     ///< something was asked of a row in this round
  std::vector<char> is_driven_;
  std::vector<Vec3> start_;
  std::vector<BoxTree> trees_;                 ///< triangles of each body
};

Vec3 Apart::at(const Place& place) const {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < 3; ++i)
    if (place.v[i] >= 0) sum += place.c[i] * points_[std::size_t(place.v[i])];
  return sum;
}

/// `first` is to go by a part of `way` along `direction`, `second` by the rest the other way.
void Apart::ask(const Place& first, const Place& second, const Vec3& direction, double way) {
  double sum = 0;
  for (const Place* place : {&first, &second})
    for (std::size_t i = 0; i < 3; ++i)
      if (moves(place->v[i])) sum += place->c[i] * place->c[i];
  if (sum == 0) return;
  double sign = 1;
  for (const Place* place : {&first, &second}) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (!moves(place->v[i]) || place->c[i] == 0) continue;
      const std::size_t row = std::size_t(s_.rows[std::size_t(place->v[i])]);
      asked_[row] += sign * place->c[i] * way / sum * direction, ++times_[row];
    }
    sign = -1;
  }
}

void Apart::prepareTrees() {
  const bool is_first = trees_.empty();
  trees_.resize(s_.bodies().size());
  for (std::size_t b = 0; b < trees_.size(); ++b) {
    std::vector<Box> boxes;
    const auto& body = s_.bodies()[b];
    for (int f = body.first_face; f < body.first_face + body.faces; ++f) {
      boxes.emplace_back();
      for (const int v : s_.faces[std::size_t(f)]) boxes.back().add(points_[std::size_t(v)]);
    }
    is_first ? trees_[b].build(std::move(boxes)) : trees_[b].refit(boxes);
  }
}

/// Towards the closest point of the surface of `body`, and a gap beyond.
void Apart::pushOut(const Place& inside, int body) {
  const Vec3 p = at(inside);
  const auto& tree = trees_[std::size_t(body)];
  double nearest = std::numeric_limits<double>::infinity();
  ClosestPoints closest{};
  int face = -1;
  Box around;
  around.add(p);
  for (double reach = law_.range + 1e-3 * (tree.whole().high - tree.whole().low).norm(); face < 0 && std::isfinite(reach); reach *= 2)
    tree.forEachMeeting(around.grownBy(reach), [&](Index i) {
      const int f = s_.bodies()[std::size_t(body)].first_face + int(i);
      const auto& corners = s_.faces[std::size_t(f)];
      const ClosestPoints found = closestPoints(PairKind::point_triangle, {p, points_[std::size_t(corners[0])],
                                                points_[std::size_t(corners[1])], points_[std::size_t(corners[2])]});
      if (found.distance() < nearest && found.distance() <= reach) nearest = found.distance(), closest = found, face = f;
    });
  if (face < 0) return;  // a place that is no number
  Place surface{s_.faces[std::size_t(face)], {-closest.weights[1], -closest.weights[2], -closest.weights[3]}};
  // difference is p - q; a point on the surface goes along the triangle's normal
  Vec3 out = -closest.difference;
  if (!(nearest > 1e-9 * law_.range)) {
    const auto& v = surface.v;
    out = (points_[std::size_t(v[1])] - points_[std::size_t(v[0])]).cross(points_[std::size_t(v[2])] - points_[std::size_t(v[0])]);
  }
  ask(inside, surface, out.normalized(), nearest + gap_);
}

/// What is inside of `body` of the edges that cross its surface, and of vertices that are joined with their ends.
void Apart::collectFrom(int body, const std::vector<Candidates::Crossing>& crossings) {
  std::map<int, std::vector<int>> faces_of_edge;
  for (const auto& crossing : crossings)
    if (s_.bodyOf(s_.faces[std::size_t(crossing.face)][0]) == body &&
        s_.bodyOf(s_.edges[std::size_t(crossing.edge)][0]) != body)
      faces_of_edge[crossing.edge].push_back(crossing.face);
  if (faces_of_edge.empty()) return;
  std::map<int, bool> is_inside;
  std::vector<int> waiting;
  const auto visit = [&](int v) {
    if (is_inside.contains(v)) return;
    if ((is_inside[v] = isInside(points_[std::size_t(v)], s_, points_, body))) waiting.push_back(v);
  };
  for (const auto& [edge, faces] : faces_of_edge)
    for (const int v : s_.edges[std::size_t(edge)]) visit(v);
  for (std::size_t i = 0; i < waiting.size(); ++i)
    for (Index k = s_.faces_around.start[std::size_t(waiting[i])]; k < s_.faces_around.start[std::size_t(waiting[i]) + 1]; ++k)
      for (const int v : s_.faces[std::size_t(s_.faces_around.values[std::size_t(k)])]) visit(v);
  for (const int v : waiting) pushOut({{v, -1, -1}, {1, 0, 0}}, body);
  for (const auto& [edge, faces] : faces_of_edge) {
    const auto& ends = s_.edges[std::size_t(edge)];
    if (!is_inside[ends[0]] && !is_inside[ends[1]]) collectEdge(body, edge, faces);
  }
}

void Apart::collectEdge(int body, int edge, const std::vector<int>& faces) {
  const auto& ends = s_.edges[std::size_t(edge)];
  const Vec3 &a = points_[std::size_t(ends[0])], &b = points_[std::size_t(ends[1])];
  double low = 1, high = 0;
  for (const int face : faces) {
    const auto& v = s_.faces[std::size_t(face)];
    const Vec3& o = points_[std::size_t(v[0])];
    const Vec3 n = (points_[std::size_t(v[1])] - o).cross(points_[std::size_t(v[2])] - o);
    const double from = n.dot(a - o), to = n.dot(b - o);
    if (from == to) continue;
    low = std::min(low, from / (from - to)), high = std::max(high, from / (from - to));
  }
  if (low > high) return;
  const double t = 0.5 * (low + high);
  pushOut({{ends[0], ends[1], -1}, {1 - t, t, 0}}, body);
}

void Apart::collectInside() {
  law_.candidates.forget();
  const auto crossings = law_.candidates.crossings(points_);
  if (crossings.empty()) return;
  prepareTrees();
  for (int body = 0; body < int(s_.bodies().size()); ++body) collectFrom(body, crossings);
}

void Apart::collectNear() {
  law_.candidates.forget();
  law_.candidates.find(points_, 0.5 * law_.range);
  constexpr double enough = 0.99;
  for (const Candidate& pair : law_.candidates.pairs()) {
    if (!pair.pushes) continue;
    const ClosestPoints closest = closestPoints(pair.kind, law_.candidates.pointsOf(pair, points_));
    const double distance = closest.distance(), missing = gap_ + pair.radius + law_.thickness - distance;
    if (!(missing > (1 - enough) * gap_) || distance == 0) continue;
    Place first, second;
    const std::size_t of_first = pair.kind == PairKind::point_triangle ? 1 : 2;
    for (std::size_t i = 0; i < 4; ++i) {
      Place& side = i < of_first ? first : second;
      const std::size_t k = i < of_first ? i : i - of_first;
      side.v[k] = pair.v[i], side.c[k] = i < of_first ? closest.weights[i] : -closest.weights[i];
    }
    ask(first, second, closest.difference / distance, missing);
  }
}

void Apart::collectPlanes() {
  for (std::size_t plane = 0; plane < law_.planes.size(); ++plane)
    for (int v = 0; v < int(points_.size()); ++v)
      if (const double missing = gap_ - law_.gapToPlane(plane, std::size_t(v), points_[std::size_t(v)]); moves(v) && missing > 0.01 * gap_)
        ask({{v, -1, -1}, {1, 0, 0}}, {}, law_.planes[plane].normal, missing);
}

/// False: nothing is in anything or too near.
bool Apart::collect() {
  std::fill(asked_.begin(), asked_.end(), Vec3::Zero()), std::fill(times_.begin(), times_.end(), 0);
  collectPlanes(), collectInside();
  const auto is_asked = [&] { return std::any_of(times_.begin(), times_.end(), [](int n) { return n > 0; }); };
  if (!is_asked()) collectNear();
  return is_asked();
}

void Apart::spread(const std::function<void(Rows)>& project) {
  constexpr int sweeps = 60;
  for (std::size_t row = 0; row < asked_.size(); ++row)
    if (times_[row] > 0) {
      driven_[row] = moved_[row] + asked_[row] / times_[row];
      is_driven_[row] = true, moved_[row] = driven_[row];
    }
  Vector way(independent_);
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    for (const StartBody& body : bodies_) {
      const Index first = body.state->firstRow();
      if (first >= independent_) continue;
      const Adjacency& around = body.mesh->nodesAroundNode();
      for (Index node = 0; node < std::min(body.state->size(), around.size()); ++node) {
        const std::size_t row = std::size_t(first + node);
        const auto begin = around.values.begin() + around.start[std::size_t(node)],
                   end = around.values.begin() + around.start[std::size_t(node) + 1];
        if (is_driven_[row] || begin == end) continue;
        const auto sum = [&](const Vec3& all, Index other) -> Vec3 { return all + moved_[std::size_t(first + other)]; };
        moved_[row] = std::accumulate(begin, end, Vec3(Vec3::Zero()), sum) / double(end - begin);
      }
    }
    for (Index row = 0; row < independent_; ++row) way[row] = moved_[std::size_t(row)];
    project(way);
    for (Index row = 0; row < independent_; ++row) moved_[std::size_t(row)] = way[row];
  }
  for (Index row = 0; row < independent_; ++row) x_[row] = start_[std::size_t(row)] + moved_[std::size_t(row)];
}

double Apart::run(const std::function<void(Rows)>& project) {
  constexpr int most_rounds = 200;
  for (int round = 0; round < most_rounds; ++round) {
    s_.gather(x_, law_.moved, points_);
    if (!collect()) break;
    spread(project);
  }
  law_.candidates.forget();
  double longest = 0;
  for (const Vec3& way : moved_) longest = std::max(longest, way.norm());
  return longest;
}

/// Cells that were not inside out where they are written, and are now.
void refuseInverted(const StartBody& body, ConstRows x) {
  Mesh now = *body.mesh;
  const std::vector<Index> before = now.report().inverted;
  for (Index node = 0; node < std::min(now.nodes(), body.state->size()); ++node)
    now.position[std::size_t(node)] = x[body.state->firstRow() + node];
  for (const Index cell : now.report().inverted)
    if (!std::binary_search(before.begin(), before.end(), cell))
      throw ComponentError(fmt::format("bodies start in one another so deep that pushing them apart turns cell {} of {} inside out",
                                       cell, body.state->path()),
                           "bodies that start in one another by less than a cell, or apart");
}

}  // namespace

double pushApart(const BarrierLaw& law, const std::vector<StartBody>& bodies, double gap, Index independent,
                 const std::function<void(Rows)>& project, Rows x) {
  const double longest = Apart(law, bodies, gap, independent, x).run(project);
  if (longest > 0)
    for (const StartBody& body : bodies)
      if (body.state->firstRow() < independent) refuseInverted(body, x);
  return longest;
}

}  // namespace stroma::contact
