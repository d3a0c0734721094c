// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_candidates.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "framework/collision/exact_intersection.h"

namespace stroma::contact {

namespace {
bool has(const std::array<int, 3>& face, int vertex) {
  return face[0] == vertex || face[1] == vertex || face[2] == vertex;
}
}  // namespace

void Candidates::compile(const Surfaces& surfaces) {
  surfaces_ = &surfaces;
  parts_ = partsOf(surfaces), shared_ = sharedFeatures(surfaces, parts_);
  trees_.assign(parts_.size(), {});
  boxes_.assign(parts_.size(), {});
  is_fit_.assign(parts_.size(), false);
  gone_.assign(parts_.size(), {}), goes_ = gone_;
  turned_.assign(parts_.size(), {}), turns_ = turned_;
  is_turned_.assign(parts_.size(), false), does_turn_ = is_turned_;
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    boxes_[p].resize(parts_[p].faces.size());
    fit(int(p), surfaces.rest, nullptr, {});
    trees_[p].build(boxes_[p]);
  }
  meetings_.clear();
  for (int a = 0; a < int(parts_.size()); ++a)
    for (int b = a; b < int(parts_.size()); ++b)
      if (mayMeet(parts_[std::size_t(a)].body, parts_[std::size_t(b)].body)) meetings_.push_back({.a = a, .b = b});
  group();
  ways_.assign(meetings_.size(), 0);
  looks_.assign(meetings_.size(), false), searched_ = looks_;
  face_pairs_.assign(meetings_.size(), {});
  radii_ = 0;
  for (const double radius : surfaces.radius) radii_ = std::max(radii_, 2 * radius);
  forget();
}

void Candidates::forget() {
  found_at_.clear(), pairs_.clear(), pattern_.clear(), is_followed_ = false;
  for (Meeting& meeting : meetings_) meeting = {.a = meeting.a, .b = meeting.b};
  for (MeetingGroup& each : groups_) each.is_counted = each.is_fine = each.is_free = false;
  for (BodyMeeting& each : body_meetings_) each.is_fine = false;
  are_bodies_counted_ = false;
  ++revision_, step_ = 0, may_push_ = true, work_ = {};
}

bool Candidates::mayMeet(int a, int b) const {
  const auto& bodies = surfaces_->bodies();
  if (surfaces_->areExcluded(a, b)) return false;
  if (a == b) return self_contact && bodies[std::size_t(a)].moves;
  return bodies[std::size_t(a)].moves || bodies[std::size_t(b)].moves;
}

void Candidates::fit(int part, const std::vector<Vec3>& x, const std::vector<Vec3>* dx, const std::vector<double>& bend, double step) {
  const std::vector<int>& faces = parts_[std::size_t(part)].faces;
  std::vector<Box>& boxes = boxes_[std::size_t(part)];
  for (std::size_t f = 0; f < faces.size(); ++f) {
    Box box;
    const std::size_t face = std::size_t(faces[f]);
    double more = 0;
    for (const int v : surfaces_->faces[face]) {
      box.add(x[std::size_t(v)]);
      if (dx) box.add(x[std::size_t(v)] + step * (*dx)[std::size_t(v)]);
      if (!bend.empty()) more = std::max(more, bend[std::size_t(v)]);
    }
    boxes[f] = box.grownBy(surfaces_->radius[face] + more);
  }
}

void Candidates::fitBoth(const Meeting& meeting, const std::vector<Vec3>& x, const std::vector<Vec3>* dx,
                         const std::vector<double>& bend, double step) {
  for (const int part : {meeting.a, meeting.b})
    if (!std::exchange(is_fit_[std::size_t(part)], true))
      fit(part, x, dx, bend, step), trees_[std::size_t(part)].refit(boxes_[std::size_t(part)]);
}

template <class Visit>
void Candidates::forEachNearPair(const Meeting& meeting, double margin, Visit&& visit) const {
  const std::vector<int>&a = parts_[std::size_t(meeting.a)].faces, &b = parts_[std::size_t(meeting.b)].faces;
  trees_[std::size_t(meeting.a)].forEachPair(trees_[std::size_t(meeting.b)], margin,
                                             [&](Index f, Index g) { visit(a[std::size_t(f)], b[std::size_t(g)]); });
}

Candidate Candidates::vertexAndFace(int vertex, int face) const {
  const Surfaces& s = *surfaces_;
  const auto& f = s.faces[std::size_t(face)];
  const double own =
      s.radius[std::size_t(s.faces_around.values[std::size_t(s.faces_around.start[std::size_t(vertex)])])];
  Candidate pair{PairKind::point_triangle, vertex, face, {vertex, f[0], f[1], f[2]}, own + s.radius[std::size_t(face)]};
  pair.is_rounded = pair.radius > 0 && !(s.moves(vertex) && s.moves(f[0]));
  return pair;
}

Candidate Candidates::twoEdges(int a, int b, double radius) const {
  if (a > b) std::swap(a, b);
  const auto &p = surfaces_->edges[std::size_t(a)], &q = surfaces_->edges[std::size_t(b)];
  Candidate pair{PairKind::edge_edge, a, b, {p[0], p[1], q[0], q[1]}, radius};
  pair.is_rounded = radius > 0 && !(surfaces_->moves(p[0]) && surfaces_->moves(q[0]));
  return pair;
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
  if (s.pieceOf(pair.v[0]) != s.pieceOf(pair.v[3])) return false;
  const FourPoints rest = pointsOf(pair, s.rest);
  const double near = (reach_at_rest < 0 ? reach : reach_at_rest) + pair.radius;
  if (areFar(pair.kind, rest, nullptr, near)) return false;
  if (pair.kind == PairKind::edge_edge && leastOfParallel(rest) > near) return false;
  return closestPoints(pair.kind, rest).distance() <= near;
}

bool Candidates::find(const std::vector<Vec3>& x, double margin) {
  forget();
  startFrom(x);
  for (std::size_t m = 0; m < meetings_.size(); ++m) search(int(m), x, margin);
  return takeFound();
}

void Candidates::addFarther(int body_a, int body_b, const std::vector<Vec3>& x, double from, double to, std::deque<Candidate>& out) {
  fitNone();
  for (std::size_t m = 0; m < meetings_.size(); ++m) {
    const int a = parts_[std::size_t(meetings_[m].a)].body, b = parts_[std::size_t(meetings_[m].b)].body;
    if (!(a == body_a && b == body_b) && !(a == body_b && b == body_a)) continue;
    fitBoth(meetings_[m], x, nullptr, {});
    forEachNearPair(meetings_[m], to, [&](int f, int g) {
      pairsOf(f, g, [&](Candidate pair) {
        const FourPoints points = pointsOf(pair, x);
        pair.distance = leastDistance(pair.kind, points) - pair.radius, pair.meeting = int(m);
        if (pair.distance > from && pair.distance <= to) out.push_back(pair);
      });
    });
  }
  fitNone();
}

bool Candidates::findAgain(const std::vector<Vec3>& x, double least_margin, double most_margin) {
  constexpr double steps = 3;  // for which a margin is to last; both sides have it
  if (follow(x)) return false;
  startFrom(x);
  for (std::size_t m = 0; m < meetings_.size(); ++m) {
    const Meeting& meeting = meetings_[m];
    if (meeting.motion <= budgetOf(meeting)) continue;
    const double in_a_step = meeting.near < 0 ? 0 : meeting.motion / double(std::max(1L, step_ - meeting.step));
    const double wanted = std::isfinite(in_a_step) ? steps * in_a_step : 0;
    search(int(m), x, std::max(least_margin, std::min(wanted, most_margin)));
  }
  return takeFound();
}

/// Pairs of two parts for a motion of twice the margin; where boxes around the parts are farther apart, none and for a longer one.
void Candidates::search(int number, const std::vector<Vec3>& x, double margin) {
  Meeting& meeting = meetings_[std::size_t(number)];
  ++work_.searches;
  fitBoth(meeting, x, nullptr, {});
  const Box &a = trees_[std::size_t(meeting.a)].whole(), &b = trees_[std::size_t(meeting.b)].whole();
  const double apart = (a.low - b.high).cwiseMax(b.low - a.high).cwiseMax(Vec3::Zero()).norm();
  const double near = std::max(reach + 2 * margin, apart);
  // at x, where it is known to be free
  meeting.is_free = apart > 0 || (meeting.is_free && meeting.motion < meeting.clear);
  meeting.near = meeting.pushing = near, meeting.clear = near - thickness;
  meeting.used = meeting.motion = 0, meeting.step = step_, meeting.has_faces = true;
  face_pairs_[std::size_t(number)].clear();
  searched_[std::size_t(number)] = true;
  groups_[std::size_t(group_of_[std::size_t(number)])].is_free = false;
  if (apart >= reach + 2 * margin) return;
  forEachNearPair(meeting, near, [&](int f, int g) {
    face_pairs_[std::size_t(number)].push_back({f, g});
    pairsOf(f, g, [&](Candidate pair) {
      const double far = near + pair.radius;
      const FourPoints points = pointsOf(pair, x);
      if (areFar(pair.kind, points, nullptr, far)) return;
      pair.distance = leastDistance(pair.kind, points) - pair.radius;
      if (pair.distance > near) return;
      pair.pushes = !isNearAtRest(pair), pair.meeting = number;
      meeting.clear = std::min(meeting.clear, pair.distance - (pair.pushes ? thickness : 0));
      if (pair.pushes) meeting.pushing = std::min(meeting.pushing, pair.distance);
      found_.push_back(pair);
    });
  });
  // what belongs to triangles of other parts comes last: most of it is farther than the nearest of those
  for (const auto& [f, g] : face_pairs_[std::size_t(number)])
    meeting.clear = leastApart(*surfaces_, f, shared_[std::size_t(f)], g, shared_[std::size_t(g)], x, meeting.clear);
}

/// Pairs that have been found take the place of those of the same parts. True: see needsPattern().
bool Candidates::takeFound() {
  const auto isSearched = [&](const Candidate& pair) { return bool(searched_[std::size_t(pair.meeting)]); };
  if (found_.empty() && std::none_of(pairs_.begin(), pairs_.end(), isSearched)) return false;
  std::sort(found_.begin(), found_.end());
  if (pairs_.empty()) {  // of a first search there are too many to have them twice
    std::swap(pairs_, found_), ++revision_;
    return needsPattern();
  }
  std::swap(pairs_, old_pairs_);
  pairs_.clear();
  auto next = found_.begin();
  for (auto old = old_pairs_.begin(); old != old_pairs_.end(); ++old) {
    for (; next != found_.end() && *next < *old; ++next) pairs_.push_back(*next);
    if (!isSearched(*old)) {
      pairs_.push_back(*old);
    } else if (next != found_.end() && !(*old < *next)) {
      pairs_.push_back(*next++);
      pairs_.back().factor = old->factor, pairs_.back().tried = old->tried, pairs_.back().found = old->found;
    }
  }
  pairs_.insert(pairs_.end(), next, found_.end());
  ++revision_;
  return needsPattern();
}

/// Some push that have no place in the pattern, or it has far too many. Those that had one keep it while it does not become twice as
/// large as what pushes now.
bool Candidates::needsPattern() {
  constexpr std::size_t most = 2;
  pushing_.clear();
  pushing_.reserve(std::size_t(std::ranges::count_if(pairs_, &Candidate::pushes)));
  for (const Candidate& pair : pairs_)
    if (pair.pushes) pushing_.push_back({pair.kind, pair.first, pair.second});
  const std::size_t enough = most * pushing_.size();
  if (pattern_.size() <= enough && std::includes(pattern_.begin(), pattern_.end(), pushing_.begin(), pushing_.end())) return false;
  if (pattern_.empty()) return std::swap(pattern_, pushing_), true;  // of a first search: millions, which need not be there twice
  both_.clear();
  std::set_union(pushing_.begin(), pushing_.end(), pattern_.begin(), pattern_.end(), std::back_inserter(both_));
  std::swap(pattern_, both_.size() <= enough ? both_ : pushing_);
  return true;
}

std::array<int, 4> Candidates::verticesOf(const PairName& pair) const {
  const Candidate whole = pair.kind == PairKind::edge_edge ? twoEdges(pair.first, pair.second, 0) : vertexAndFace(pair.first, pair.second);
  return whole.v;
}

/// Makes `step` as short as the pair lets it be. What lies beyond `step` is not looked at.
void Candidates::shorten(const Candidate& pair, const std::vector<Vec3>& x, const std::vector<Vec3>& dx,
                         const std::vector<double>& bend, double& step) {
  const StepOptions options;
  ++work_.ways;
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
  FourPoints open = way;
  for (Vec3& each : open) each *= step;
  // at least a tenth of the distance remains then
  if (areFar(pair.kind, start, &open, apart + options.left * (start[3] - start[0]).norm())) return;
  step = std::min(step, stroma::longestStep(pair.kind, start, way, {.longest = step, .thickness = apart}));
}

/// Of the part of the way up to `step`: it has `room` for that, and a tenth of it besides.
bool Candidates::hasRoom(std::size_t m, double room, double step) const {
  const StepOptions options;
  return step * ways_[m] <= (1 - options.left) * (room - meetings_[m].motion - roundingOf(m, step));
}

double Candidates::roundingOf(std::size_t m, double step) const {
  return roundOff(step * (goes_[std::size_t(meetings_[m].a)].longest + goes_[std::size_t(meetings_[m].b)].longest));
}

/// Makes ways_ and looks_ those of all meetings: which have no room for the whole way. After restGroups().
bool Candidates::findWays(const std::vector<Vec3>& x, const std::vector<Vec3>& dx, const std::vector<double>& bend, bool knows_any) {
  std::fill(does_turn_.begin(), does_turn_.end(), false);
  bool looks = false;
  for (std::size_t m = 0; m < meetings_.size(); ++m) {
    looks_[m] = false;
    if (groups_[std::size_t(group_of_[m])].rests) continue;
    const Meeting& meeting = meetings_[m];
    const Displacements &a = goes_[std::size_t(meeting.a)], &b = goes_[std::size_t(meeting.b)];
    ways_[m] = a.longest + b.longest;
    if (ways_[m] == 0 || (knows_any && hasRoom(m, meeting.clear, 1))) continue;
    ways_[m] = boundOfDifference(a, b);
    if (ways_[m] == 0 || (knows_any && hasRoom(m, meeting.clear, 1))) continue;
    takeOffTurns(meetings_[m], x), ways_[m] = takeOffTurns(meeting, x, dx, bend, ways_[m]);
    looks_[m] = !knows_any || !hasRoom(m, meeting.clear, 1);
    looks = looks || looks_[m];
  }
  return looks;
}

/// What has room for its way, and a tenth of it besides, is not looked at. Pairs that are known come first: they are the nearest. Of
/// the others only the part of the way counts that these leave, so that a correction as long as the body seldom asks for more.
double Candidates::longestStep(const std::vector<Vec3>& x, const std::vector<Vec3>& dx, const std::vector<double>& bend) {
  const StepOptions options;
  const bool knows_any = found_at_.size() == x.size();
  follow(x);
  if (restBodies(x, dx, bend)) return 1;
  restGroups(x);
  if (!findWays(x, dx, bend, knows_any)) return 1;
  double step = 1;
  const auto open = [&] { return bend.empty() ? step : 1; };  // what bends is as far off on a part of its way
  if (knows_any)
    for (const Candidate& pair : pairs_) {
      const std::size_t m = std::size_t(pair.meeting);
      if (looks_[m] && !hasRoom(m, pair.distance - (pair.pushes ? thickness : 0), open())) shorten(pair, x, dx, bend, step);
    }
  fitNone();
  double fitted = step;
  for (std::size_t m = 0; m < meetings_.size() && step > 0; ++m) {
    if (!looks_[m]) continue;
    const Meeting& meeting = meetings_[m];
    if (knows_any && (hasRoom(m, meeting.clear, open()) ||
                      meeting.motion + open() * ways_[m] + roundingOf(m, open()) <= budgetOf(meeting)))
      continue;
    ++work_.searches;
    if (step < 0.5 * fitted) fitNone(), fitted = step;
    fitBoth(meeting, x, &dx, bend, fitted);
    forEachNearPair(meeting, thickness + options.left * reach, [&](int f, int g) {  // farther apart there is no force yet
      pairsOf(f, g, [&](Candidate pair) {
        pair.pushes = thickness == 0 || !isNearAtRest(pair);
        shorten(pair, x, dx, bend, step);
      });
    });
  }
  return step;
}

void Candidates::testFaces(int from, int to, const std::vector<Vec3>& x, std::vector<Crossing>& found) const {
  const Surfaces& s = *surfaces_;
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
}

/// Two parts of which an exact test has once found nothing that crosses stay without as long as all distances of a vertex and a
/// triangle and of two edges stay above zero: they may not cross without touching first.
std::vector<Candidates::Crossing> Candidates::crossings(const std::vector<Vec3>& x) {
  std::vector<Crossing> found;
  const bool knows_any = found_at_.size() == x.size();
  follow(x);
  if (knows_any && areAllFree()) return found;
  fitNone();
  for (std::size_t m = 0; m < meetings_.size(); ++m) {
    Meeting& meeting = meetings_[m];
    const bool is_fine = knows_any && isFine(int(m)), is_near_known = is_fine || (knows_any && meeting.motion < meeting.clear);
    if (is_near_known && meeting.is_free) continue;
    ++work_.tests;
    const std::size_t before = found.size();
    const auto both = [&](int f, int g) { testFaces(f, g, x, found), testFaces(g, f, x, found); };
    if (knows_any && meeting.has_faces && (is_fine || meeting.motion <= budgetOf(meeting))) {
      for (const auto& [f, g] : face_pairs_[m]) both(f, g);
    } else {
      fitBoth(meeting, x, nullptr, {});
      forEachNearPair(meeting, 0, both);
    }
    meeting.is_free = is_near_known && found.size() == before;
  }
  for (MeetingGroup& each : groups_)
    each.is_free = std::ranges::all_of(each.meetings, [this](int m) { return meetings_[std::size_t(m)].is_free; });
  std::sort(found.begin(), found.end(), [](const Crossing& a, const Crossing& b) {
    return a.depth != b.depth ? a.depth > b.depth : a.edge != b.edge ? a.edge < b.edge : a.face < b.face;
  });
  return found;
}

}  // namespace stroma::contact
