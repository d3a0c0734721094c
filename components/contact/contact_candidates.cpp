// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_candidates.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "framework/collision/exact_intersection.h"

namespace stroma::contact {

namespace {
bool has(const std::array<int, 3>& face, int vertex) {
  return face[0] == vertex || face[1] == vertex || face[2] == vertex;
}

/// Boxes around both sides of a pair on their way are farther apart than `distance`: a bound that costs little.
bool areFar(PairKind kind, const FourPoints& x, const FourPoints* dx, double distance) {
  Box sides[2];
  for (std::size_t i = 0; i < 4; ++i) {
    Box& side = sides[i < (kind == PairKind::point_triangle ? 1 : 2) ? 0 : 1];
    side.add(x[i]);
    if (dx) side.add(Vec3(x[i] + (*dx)[i]));
  }
  const Vec3 apart = (sides[1].low - sides[0].high).cwiseMax(sides[0].low - sides[1].high).cwiseMax(Vec3::Zero());
  return apart.squaredNorm() > distance * distance;
}
}  // namespace

void Candidates::compile(const Surfaces& surfaces) {
  surfaces_ = &surfaces;
  trees_.assign(surfaces.bodies().size(), {});
  boxes_.assign(surfaces.bodies().size(), {});
  for (std::size_t b = 0; b < boxes_.size(); ++b) boxes_[b].resize(std::size_t(surfaces.bodies()[b].faces));
  fit(surfaces.rest, nullptr, {});
  for (std::size_t b = 0; b < boxes_.size(); ++b) trees_[b].build(boxes_[b]);
  forget();
}

bool Candidates::mayMeet(int a, int b) const {
  const auto& bodies = surfaces_->bodies();
  if (a == b) return self_contact && bodies[std::size_t(a)].moves;
  return bodies[std::size_t(a)].moves || bodies[std::size_t(b)].moves;
}

void Candidates::fit(const std::vector<Vec3>& x, const std::vector<Vec3>* dx, const std::vector<double>& bend) {
  for (std::size_t b = 0; b < boxes_.size(); ++b) {
    const Surfaces::Body& body = surfaces_->bodies()[b];
    for (int f = 0; f < body.faces; ++f) {
      Box box;
      const std::size_t face = std::size_t(body.first_face + f);
      double more = 0;
      for (const int v : surfaces_->faces[face]) {
        box.add(x[std::size_t(v)]);
        if (dx) box.add(x[std::size_t(v)] + (*dx)[std::size_t(v)]);
        if (!bend.empty()) more = std::max(more, bend[std::size_t(v)]);
      }
      boxes_[b][std::size_t(f)] = box.grownBy(surfaces_->radius[face] + more);
    }
    trees_[b].refit(boxes_[b]);
  }
}

template <class Visit>
void Candidates::forEachNearPair(double margin, Visit&& visit) const {
  const auto& bodies = surfaces_->bodies();
  for (int a = 0; a < int(bodies.size()); ++a)
    for (int b = a; b < int(bodies.size()); ++b)
      if (mayMeet(a, b))
        trees_[std::size_t(a)].forEachPair(trees_[std::size_t(b)], margin, [&](Index f, Index g) {
          visit(bodies[std::size_t(a)].first_face + f, bodies[std::size_t(b)].first_face + g);
        });
}

Candidate Candidates::vertexAndFace(int vertex, int face) const {
  const Surfaces& s = *surfaces_;
  const auto& f = s.faces[std::size_t(face)];
  const double own =
      s.radius[std::size_t(s.faces_around.values[std::size_t(s.faces_around.start[std::size_t(vertex)])])];
  return {PairKind::point_triangle, vertex, face, {vertex, f[0], f[1], f[2]}, own + s.radius[std::size_t(face)]};
}

Candidate Candidates::twoEdges(int a, int b, double radius) const {
  if (a > b) std::swap(a, b);
  const auto &p = surfaces_->edges[std::size_t(a)], &q = surfaces_->edges[std::size_t(b)];
  return {PairKind::edge_edge, a, b, {p[0], p[1], q[0], q[1]}, radius};
}

/// The pairs that two triangles stand for: each vertex and edge belongs to one triangle.
template <class Visit>
void Candidates::pairsOf(int f, int g, Visit&& visit) const {
  const Surfaces& s = *surfaces_;
  for (const auto& [from, to] : {std::array{f, g}, std::array{g, f}})
    for (const int v : s.owned_vertices[std::size_t(from)])
      if (v >= 0 && !has(s.faces[std::size_t(to)], v)) visit(vertexAndFace(v, to));
  const double radius = s.radius[std::size_t(f)] + s.radius[std::size_t(g)];
  for (const int a : s.owned_edges[std::size_t(f)])
    for (const int b : s.owned_edges[std::size_t(g)]) {
      if (a < 0 || b < 0) continue;
      const auto &p = s.edges[std::size_t(a)], &q = s.edges[std::size_t(b)];
      if (p[0] != q[0] && p[0] != q[1] && p[1] != q[0] && p[1] != q[1]) visit(twoEdges(a, b, radius));
    }
}

/// Of one piece, which has a shape of its own.
bool Candidates::isNearAtRest(const Candidate& pair) const {
  const Surfaces& s = *surfaces_;
  return s.pieceOf(pair.v[0]) == s.pieceOf(pair.v[3]) &&
         closestPoints(pair.kind, pointsOf(pair, s.rest)).distance() <= reach;
}

bool Candidates::find(const std::vector<Vec3>& x, double margin) {
  found_at_ = x;
  margin_ = margin;
  std::swap(pairs_, old_pairs_);
  pairs_.clear();
  face_pairs_.clear();
  fit(x, nullptr, {});
  const double near = reach + 2 * margin;
  forEachNearPair(near, [&](int f, int g) {
    face_pairs_.push_back({f, g});
    pairsOf(f, g, [&](Candidate pair) {
      const double far = near + pair.radius;
      const FourPoints points = pointsOf(pair, x);
      if (areFar(pair.kind, points, nullptr, far)) return;
      if (closestPoints(pair.kind, points).difference.squaredNorm() > far * far) return;
      pair.pushes = !isNearAtRest(pair);
      pairs_.push_back(pair);
    });
  });
  std::sort(pairs_.begin(), pairs_.end());
  auto old = old_pairs_.begin();
  for (Candidate& pair : pairs_) {
    while (old != old_pairs_.end() && *old < pair) ++old;
    if (old != old_pairs_.end() && !(pair < *old)) pair.factor = old->factor, pair.tried = old->tried, pair.found = old->found;
  }
  ++revision_;
  return doOthersPush();
}

/// Than before the last find().
bool Candidates::doOthersPush() const {
  const auto next = [](auto at, const std::vector<Candidate>& in) {
    return std::find_if(at, in.end(), [](const Candidate& pair) { return pair.pushes; });
  };
  auto now = next(pairs_.begin(), pairs_), before = next(old_pairs_.begin(), old_pairs_);
  for (; now != pairs_.end() && before != old_pairs_.end(); now = next(now + 1, pairs_), before = next(before + 1, old_pairs_))
    if (*now < *before || *before < *now) return true;
  return now != pairs_.end() || before != old_pairs_.end();
}

bool Candidates::covers(const std::vector<Vec3>& x) const {
  if (found_at_.size() != x.size()) return false;
  for (std::size_t v = 0; v < x.size(); ++v)
    if (!((x[v] - found_at_[v]).squaredNorm() <= margin_ * margin_)) return false;
  return true;
}

bool Candidates::coversWay(const std::vector<Vec3>& x, const std::vector<Vec3>& dx,
                           const std::vector<double>& bend) const {
  if (found_at_.size() != x.size()) return false;
  for (std::size_t v = 0; v < x.size(); ++v) {
    const Vec3 from = x[v] - found_at_[v];
    const double room = margin_ - (bend.empty() ? 0 : bend[v]);
    if (!(from.norm() <= room && (from + dx[v]).norm() <= room)) return false;
  }
  return true;
}

double Candidates::longestStep(const std::vector<Vec3>& x, const std::vector<Vec3>& dx, const std::vector<double>& bend,
                               double thickness) {
  double step = 1;
  const StepOptions options;
  const auto shorten = [&](const Candidate& pair) {
    double apart = pair.pushes ? thickness + pair.radius : 0;
    if (!bend.empty()) {
      const std::size_t first_side = pair.kind == PairKind::point_triangle ? 1 : 2;
      double sides[2] = {0, 0};
      for (std::size_t i = 0; i < 4; ++i) {
        double& side = sides[i < first_side ? 0 : 1];
        side = std::max(side, bend[std::size_t(pair.v[i])]);
      }
      apart += sides[0] + sides[1];
    }
    const FourPoints start = pointsOf(pair, x), way = pointsOf(pair, dx);
    // at least a tenth of the distance remains then
    if (areFar(pair.kind, start, &way, apart + options.left * (start[3] - start[0]).norm())) return;
    step = std::min(step, stroma::longestStep(pair.kind, start, way, {.longest = step, .thickness = apart}));
  };
  if (coversWay(x, dx, bend)) {
    for (const Candidate& pair : pairs_) shorten(pair);
    return step;
  }
  fit(x, &dx, bend);
  forEachNearPair(thickness + options.left * reach, [&](int f, int g) {  // farther apart there is no force yet
    pairsOf(f, g, [&](Candidate pair) {
      pair.pushes = thickness == 0 || !isNearAtRest(pair);
      shorten(pair);
    });
  });
  return step;
}

std::vector<Candidates::Crossing> Candidates::crossings(const std::vector<Vec3>& x) {
  const Surfaces& s = *surfaces_;
  std::vector<Crossing> found;
  const auto test = [&](int from, int to) {
    const auto& face = s.faces[std::size_t(to)];
    const Vec3 &a = x[std::size_t(face[0])], &b = x[std::size_t(face[1])], &c = x[std::size_t(face[2])];
    for (const int e : s.owned_edges[std::size_t(from)]) {
      if (e < 0) continue;
      const auto& ends = s.edges[std::size_t(e)];
      if (has(face, ends[0]) || has(face, ends[1])) continue;
      const Vec3 &p = x[std::size_t(ends[0])], &q = x[std::size_t(ends[1])];
      if (!segmentMeetsTriangle(p, q, a, b, c)) continue;
      const Vec3 normal = (b - a).cross(c - a);
      const double area = normal.norm();
      const auto heightOf = [&](const Vec3& end) { return area > 0 ? std::abs(normal.dot(end - a)) / area : 0; };
      found.push_back({e, to, std::min(heightOf(p), heightOf(q))});
    }
  };
  const auto both = [&](int f, int g) { test(f, g), test(g, f); };
  if (covers(x)) {
    for (const auto& [f, g] : face_pairs_) both(f, g);
  } else {
    fit(x, nullptr, {});
    forEachNearPair(0, both);
  }
  std::sort(found.begin(), found.end(), [](const Crossing& a, const Crossing& b) {
    return a.depth != b.depth ? a.depth > b.depth : a.edge != b.edge ? a.edge < b.edge : a.face < b.face;
  });
  return found;
}

}  // namespace stroma::contact
