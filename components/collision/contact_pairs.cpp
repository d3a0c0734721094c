// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/collision/contact_pairs.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "components/collision/distances.h"
#include "components/collision/path_contacts.h"
#include "framework/collision/pair_distances.h"

namespace stroma::collision {

namespace {

bool isInside(double weight) { return weight > 1e-6 && weight < 1 - 1e-6; }

/// The same of the edges of two parts that begin at corners i and j.
bool closestOfEdges(std::span<const Vec3> x, std::size_t i, std::span<const Vec3> y, std::size_t j, Contact& contact,
                    Vec3& difference) {
  const std::size_t k = (i + 1) % x.size(), l = (j + 1) % y.size();
  const ClosestPoints found = closestPoints(PairKind::edge_edge, {x[i], x[k], y[j], y[l]});
  difference = -found.difference;
  contact.a.weight[i] = found.weights[0], contact.a.weight[k] = found.weights[1];
  contact.b.weight[j] = -found.weights[2], contact.b.weight[l] = -found.weights[3];
  return isInside(contact.a.weight[i]) && isInside(contact.b.weight[j]);
}

bool shareCorner(const Part& p, const Part& q) {
  for (int i = 0; i < p.corners; ++i)
    for (int j = 0; j < q.corners; ++j)
      if (p.node[std::size_t(i)] == q.node[std::size_t(j)]) return true;
  return false;
}

/// Closest points of a point (corner k of p) or a line p and a part q of one, two or three corners; false where they do
/// not lie within.
bool closest(std::span<const Vec3> x, int k, std::span<const Vec3> y, std::array<double, 3>& of_x,
             std::array<double, 3>& of_y, Vec3& difference) {
  of_x = of_y = {0, 0, 0};
  const bool line = k < 0;
  const Vec3 &from = x[line ? 0 : std::size_t(k)], &to = x[line ? 1 : std::size_t(k)];
  if (y.size() == 3) {
    const ClosestPoints found = closestPoints(PairKind::point_triangle, {from, y[0], y[1], y[2]});
    difference = -found.difference;
    of_x[std::size_t(k)] = 1;
    for (std::size_t i = 0; i < 3; ++i) of_y[i] = -found.weights[i + 1];
    return isInside(of_y[0]) && isInside(of_y[1]) && isInside(of_y[2]);
  }
  const ClosestPoints found = closestPoints(PairKind::edge_edge, {from, to, y[0], y[y.size() - 1]});
  difference = -found.difference;
  if (line)
    of_x[0] = found.weights[0], of_x[1] = found.weights[1];
  else
    of_x[std::size_t(k)] = 1;
  if (y.size() == 1) {
    of_y[0] = 1;
    return !line || isInside(of_x[0]);
  }
  of_y[0] = -found.weights[2], of_y[1] = -found.weights[3];
  return isInside(of_y[0]) && (!line || isInside(of_x[0]));
}

/// Corners that take part in a point, as bits.
unsigned supportOf(const std::array<double, 3>& weight) {
  unsigned bits = 0;
  for (std::size_t i = 0; i < 3; ++i)
    if (std::abs(weight[i]) > 1e-6) bits |= 1u << i;
  return bits;
}

/// Whether a point of a triangle is on an edge or in a corner that this triangle stands for.
bool isOnOwned(const Part& triangle, const std::array<double, 3>& weight) {
  const unsigned bits = supportOf(weight);
  for (unsigned i = 0; i < 3; ++i) {
    if (bits == 1u << i) return triangle.owned >> i & 1;
    if (bits == (1u << i | 1u << (i + 1) % 3)) return triangle.owned_edges >> i & 1;
  }
  return false;
}

/// Whether all corners that take part in a point are among those of another point.
bool holdsSupport(const PartPoint& other, const PartPoint& point) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(supportOf(point.weight) >> i & 1)) continue;
    bool found = false;
    for (std::size_t j = 0; j < 3; ++j)
      found = found || ((supportOf(other.weight) >> j & 1) && other.part->node[j] == point.part->node[i]);
    if (!found) return false;
  }
  return true;
}

bool isOneCorner(const PartPoint& point) { return std::has_single_bit(supportOf(point.weight)); }

/// A ball, a point or a corner over an edge or a corner of a triangle.
bool isOnEdge(const Contact& contact) {
  return isOneCorner(contact.a) && contact.b.part->corners == 3 && supportOf(contact.b.weight) != 7;
}

/// Edges and corners of triangles count where what is over them meets nothing that they are a part of, and no line or point there.
void dropHiddenEdges(std::vector<Contact>& contacts) {
  if (std::none_of(contacts.begin(), contacts.end(), isOnEdge)) return;
  std::vector<std::pair<const Part*, std::size_t>> by_part;
  for (std::size_t i = 0; i < contacts.size(); ++i)
    for (const PartPoint* point : {&contacts[i].a, &contacts[i].b})
      if (isOneCorner(*point)) by_part.emplace_back(point->part, i);
  std::sort(by_part.begin(), by_part.end());
  std::vector<char> hidden(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& mine = contacts[i];
    if (!isOnEdge(mine)) continue;
    for (auto at = std::lower_bound(by_part.begin(), by_part.end(), std::pair(mine.a.part, std::size_t(0)));
         at != by_part.end() && at->first == mine.a.part; ++at) {
      const Contact& other = contacts[at->second];
      const bool is_first = other.a.part == mine.a.part;
      const PartPoint &here = is_first ? other.a : other.b, &there = is_first ? other.b : other.a;
      const bool is_same = supportOf(here.weight) == supportOf(mine.a.weight) &&
                           &(is_first ? other.model_b : other.model_a)->state() == &mine.model_b->state();
      const bool is_nearer = !holdsSupport(mine.b, there) || there.part->corners < 3;
      if (at->second != i && is_same && is_nearer && holdsSupport(there, mine.b)) hidden[i] = 1;
    }
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (!hidden[i]) contacts[kept++] = contacts[i];
  contacts.resize(kept, contacts.front());
}

/// Whether what is over a point on the rim of a triangle would fall between it and the next one: the insides of both leave the rim out.
bool isOverRim(std::span<const Vec3> triangle, const Vec3& difference) {
  constexpr double rim = 1e-5;  // of the triangle's size: the next one may be ten times as large
  const Vec3 p = triangle[1] - triangle[0], q = triangle[2] - triangle[0], normal = p.cross(q).normalized();
  const double size = std::max({p.squaredNorm(), q.squaredNorm(), (q - p).squaredNorm()});
  return (difference - normal.dot(difference) * normal).squaredNorm() <= rim * rim * size;
}

}  // namespace

std::size_t ContactSearch::bodyOf(const CollisionModel& model) {
  const State& state = model.state();
  std::size_t body = 0;
  while (body < bodies_.size() && bodies_[body].state != &state) ++body;
  if (body == bodies_.size()) bodies_.push_back({&state});
  std::vector<Index>& rows = bodies_[body].rows;
  for (const Part& part : model.parts())
    for (int i = 0; i < part.corners; ++i) rows.push_back(part.node[std::size_t(i)] * state.rows_per_node);
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return body;
}

std::size_t ContactSearch::surfaceOf(const CollisionModel& model) {
  for (std::size_t i = 0; i < surfaces_.size(); ++i)
    if (surfaces_[i].model == &model) return i;
  surfaces_.push_back({&model, bodyOf(model), std::vector<Box>(model.parts().size()), {}, {}});
  if (method_->hasCones()) surfaces_.back().cones.compile(model, method_->angleCone(), method_->coneFactor());
  model.boxParts(surfaces_.back().boxes);
  surfaces_.back().tree.build(surfaces_.back().boxes);
  return surfaces_.size() - 1;
}

void ContactSearch::compile(const std::vector<ModelPair>& pairs, const Method& method) {
  method_ = &method;
  surfaces_.clear(), bodies_.clear(), pairs_.clear();
  for (const ModelPair& pair : pairs) {
    const std::size_t a = surfaceOf(*pair.a);
    pairs_.push_back({a, surfaceOf(*pair.b)});
  }
}

/// A point and a triangle, or two lines.
bool ContactSearch::meetOnPath(const Surface& a, const Part& p, const Surface& b, const Part& q, double contact,
                               std::vector<Contact>& out) const {
  const PairKind kind = q.corners == 3 ? PairKind::point_triangle : PairKind::edge_edge;
  FourPoints x, way;
  for (int i = 0; i < 4; ++i) {
    const bool is_first = i < p.corners;
    const CollisionModel& model = is_first ? *a.model : *b.model;
    const Index node = is_first ? p.node[std::size_t(i)] : q.node[std::size_t(i - p.corners)];
    x[std::size_t(i)] = model.place(node), way[std::size_t(i)] = model.wayOf(node);
  }
  const double when = firstNear(kind, x, way, contact + method_->pathDeviation());
  if (when > 1) return false;
  for (std::size_t i = 0; i < 4; ++i) x[i] += when * way[i];
  const ClosestPoints found = closestPoints(kind, x);
  Contact on_path{a.model, b.model, {&p, {}}, {&q, {}}, Vec3::UnitX(), contact};
  for (int i = 0; i < 4; ++i) {
    const double weight = found.weights[std::size_t(i)];
    i < p.corners ? on_path.a.weight[std::size_t(i)] = weight : on_path.b.weight[std::size_t(i - p.corners)] = -weight;
  }
  if (const double distance = found.distance(); distance > 0) on_path.normal = -found.difference / distance;
  out.push_back(on_path);
  return true;
}

void ContactSearch::meet(const Surface& a, const Part& p, const Surface& b, const Part& q, double alarm, double contact,
                         std::vector<Contact>& out) const {
  if (p.corners > q.corners) return meet(b, q, a, p, alarm, contact, out);
  if (method_->followsPaths() && meetOnPath(a, p, b, q, contact, out)) return;
  std::array<Vec3, 3> places, others;
  const std::span<const Vec3> x = a.model->corners(p, places), y = b.model->corners(q, others);
  const double radii = p.radius + q.radius;
  const auto keep = [&](const Surface& m, const Surface& o, Contact& found, const Vec3& difference) {
    const double distance = difference.norm();
    if (!(distance < alarm + radii)) return;
    if (!m.cones.hold(*found.a.part, difference) || !o.cones.hold(*found.b.part, -difference)) return;
    if (distance > 1e-10 * (alarm + radii)) found.normal = difference / distance;  // else any, as SOFA does
    out.push_back(found);
  };
  const auto add = [&](const Surface& m, const Part& mine, std::span<const Vec3> from, int k, const Surface& o,
                       const Part& other, std::span<const Vec3> to) {
    Contact found{m.model, o.model, {&mine, {}}, {&other, {}}, Vec3::UnitX(), contact + radii};
    Vec3 difference;
    const bool is_within = closest(from, k, to, found.a.weight, found.b.weight, difference);
    const bool is_edge = !is_within && k >= 0 && other.corners == 3 && isOnOwned(other, found.b.weight);
    const bool takes_edges = method_->trianglesTakeEdges() && m.model->kind() == CollisionModel::Kind::sphere;
    if (is_within || (is_edge && (takes_edges || isOverRim(to, difference)))) keep(m, o, found, difference);
  };
  if (q.corners < 3 || p.corners == 1) {
    add(a, p, x, p.corners == 1 ? 0 : -1, b, q, y);
    return;
  }
  for (int k = 0; k < p.corners; ++k)
    if (p.owned >> k & 1) add(a, p, x, k, b, q, y);
  for (int k = 0; p.corners == 3 && k < 3; ++k)
    if (q.owned >> k & 1) add(b, q, y, k, a, p, x);
  if (!method_->edgesOfTrianglesMeet()) return;
  for (std::size_t i = 0; i < (p.corners == 3 ? 3 : 1); ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      if ((p.corners == 3 && !(p.owned_edges >> i & 1)) || !(q.owned_edges >> j & 1)) continue;
      Contact found{a.model, b.model, {&p, {}}, {&q, {}}, Vec3::UnitX(), contact + radii};
      if (Vec3 difference; closestOfEdges(x, i, y, j, found, difference)) keep(a, b, found, difference);
    }
}

// ---- what need not be looked at ----

Vec3 ContactSearch::Body::place(std::size_t node) const {
  return state->isBound() ? Vec3(state->x()[rows[node]]) : state->position[std::size_t(rows[node])];
}

void ContactSearch::Body::follow() {
  gone = {};
  double sum = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Vec3 way = place(i) - from[i];
    gone.add(way), sum += way.squaredNorm();
  }
  is_known = !from.empty() && std::isfinite(sum);
}

void ContactSearch::Body::startHere() {
  from.resize(rows.size());
  size = 0;
  double sum = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    from[i] = place(i);
    size = std::max(size, from[i].cwiseAbs().maxCoeff()), sum += from[i].squaredNorm();
  }
  is_known = std::isfinite(sum);
}

/// Its distances, and by how much no displacement of one model differs more from any of the other.
void ContactSearch::follow(Pair& pair) const {
  const Surface &s = surfaces_[pair.a], &t = surfaces_[pair.b];
  const Body &a = bodies_[s.body], &b = bodies_[t.body];
  const double skins = s.model->contactDistance() + t.model->contactDistance();
  const double alarm = method_->alarmDistance() + skins, contact = method_->contactDistance() + skins;
  if (method_->followsPaths() || !a.is_known || !b.is_known || alarm != pair.alarm || contact != pair.contact) pair.room = -1;
  pair.alarm = alarm, pair.contact = contact, ++pair.steps;
  if (pair.room < 0) return;
  constexpr double rounding = 4e-12;
  const double most = (a.gone.high - b.gone.low).cwiseMax(b.gone.high - a.gone.low).norm();
  pair.motion = pair.used + most + rounding * (a.size + b.size + most);
}

bool ContactSearch::mayMeet(const CollisionModel& a, const Part& p, const CollisionModel& b, const Part& q, double contact) {
  return &a.state() != &b.state() || !(shareCorner(p, q) || a.restDistance(p, q) < contact);
}

/// Of a pair without a contact: for some steps like the last ones, where that is not far.
void ContactSearch::findRoom(Pair& pair, double in_a_step) const {
  constexpr double steps = 8, farthest = 4;  // of the alarm distance
  const Surface &s = surfaces_[pair.a], &t = surfaces_[pair.b];
  const CollisionModel &a = *s.model, &b = *t.model;
  if (s.tree.empty() || t.tree.empty()) return;
  const Box &p = s.tree.whole(), &q = t.tree.whole();
  const double apart = (p.low - q.high).cwiseMax(q.low - p.high).cwiseMax(Vec3::Zero()).norm();
  const double most = pair.alarm + std::clamp(steps * in_a_step, pair.alarm, farthest * pair.alarm);
  double near = std::max(most, apart);
  if (apart < most && in_a_step < most)
    s.tree.forEachPair(t.tree, most, [&](Index i, Index j) {
      const Part &mine = a.parts()[std::size_t(i)], &other = b.parts()[std::size_t(j)];
      if (!mayMeet(a, mine, b, other, pair.contact)) return;
      std::array<Vec3, 3> x, y;
      near = std::min(near, distanceOf(a.corners(mine, x), b.corners(other, y)) - mine.radius - other.radius);
    });
  pair.room = near - pair.alarm;
}

void ContactSearch::ready(Surface& surface) const {
  if (std::exchange(surface.is_fit, true)) return;
  surface.model->boxParts(surface.boxes);
  const std::vector<Part>& parts = surface.model->parts();
  for (std::size_t i = 0; i < parts.size() && method_->followsPaths(); ++i)
    for (int k = 0; k < parts[i].corners; ++k) {
      const Index node = parts[i].node[std::size_t(k)];
      surface.boxes[i].add(surface.model->place(node) + surface.model->wayOf(node));
    }
  if (const double deviation = method_->pathDeviation(); deviation > 0)  // of both ends of a path
    for (Box& box : surface.boxes) box = box.grownBy(deviation);
  surface.tree.refit(surface.boxes);
}

void ContactSearch::look(Pair& pair, std::vector<Contact>& out) {
  Surface &s = surfaces_[pair.a], &t = surfaces_[pair.b];
  ready(s), ready(t);
  const CollisionModel &a = *s.model, &b = *t.model;
  const std::size_t before = out.size();
  s.tree.forEachPair(t.tree, pair.alarm, [&](Index i, Index j) {
    const Part &p = a.parts()[std::size_t(i)], &q = b.parts()[std::size_t(j)];
    if (mayMeet(a, p, b, q, pair.contact)) meet(s, p, t, q, pair.alarm, pair.contact, out);
  });
  const double in_a_step = pair.room < 0 ? 0 : pair.motion / pair.steps;
  pair.room = -1, pair.used = pair.motion = pair.steps = 0;
  if (out.size() == before && !method_->followsPaths() && bodies_[s.body].is_known && bodies_[t.body].is_known) findRoom(pair, in_a_step);
}

void ContactSearch::find(std::vector<Contact>& out) {
  out.clear();
  for (Body& body : bodies_) body.follow();
  for (Pair& pair : pairs_) follow(pair);
  if (std::all_of(pairs_.begin(), pairs_.end(), hasRoom)) return;
  for (Pair& pair : pairs_) pair.used = pair.motion;
  for (Body& body : bodies_) body.startHere();
  for (Surface& surface : surfaces_) surface.is_fit = false;
  for (Pair& pair : pairs_)
    if (!hasRoom(pair)) look(pair, out);
  dropHiddenEdges(out);
}

}  // namespace stroma::collision
