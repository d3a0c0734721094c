// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/collision/listed_parts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace stroma::collision {

namespace {

using Weights = std::array<double, 3>;
using Kind = CollisionModel::Kind;
constexpr double inside = 1e-6;

Weights corner(std::size_t i) {
  Weights weights{};
  weights[i] = 1;
  return weights;
}

/// Which corners and edges of a triangle stand for those of its mesh, as bits; no corner of quads does in SOFA.
struct Stands {
  unsigned corners, edges;
};
Stands standsOf(const Part& part) { return part.of_quad ? Stands{0, 0} : Stands{part.owned, part.owned_edges}; }

struct InPlane {
  double b, c;         ///< weights of the second and third corner of the closest point in the plane
  double ab, ac, bc;   ///< where the closest points of the lines through the edges are, from 0 to 1
};

InPlane inPlane(const std::array<Vec3, 3>& x, const Vec3& q) {
  const Vec3 ab = x[1] - x[0], ac = x[2] - x[0], aq = q - x[0];
  const double bb = ab.dot(ab), cc = ac.dot(ac), bc = ab.dot(ac), qb = aq.dot(ab), qc = aq.dot(ac);
  const double det = bb * cc - bc * bc;
  return {(qb * cc - qc * bc) / det, (qc * bb - qb * bc) / det, qb / bb, qc / cc, (qc - qb + bb - bc) / (bb + cc - 2 * bc)};
}

std::optional<Weights> withinTriangle(const std::array<Vec3, 3>& x, const Vec3& q) {
  const InPlane at = inPlane(x, q);
  if (!(at.b >= inside && at.c >= inside && at.b + at.c <= 1 - inside)) return {};
  return Weights{1 - at.b - at.c, at.b, at.c};
}

/// Of NewProximityIntersection: also on the edges and corners that the triangle stands for.
std::optional<Weights> onTriangle(const std::array<Vec3, 3>& x, const Vec3& q, Stands stands, bool of_sphere) {
  const double e = of_sphere ? inside : std::numeric_limits<double>::epsilon();
  const InPlane at = inPlane(x, q);
  if (at.b >= e && at.c >= e && at.b + at.c <= 1 - e) return Weights{1 - at.b - at.c, at.b, at.c};
  const auto takes = [](unsigned bits, int i) { return (bits >> i & 1) != 0; };
  const auto onEdge = [](std::size_t from, std::size_t to, double share) {
    Weights weights{};
    weights[from] = 1 - share, weights[to] = share;
    return weights;
  };
  const bool past_a = of_sphere || at.ab >= e, past_a_too = of_sphere || at.ac >= e;
  if (at.ab < e && at.ac < (of_sphere ? 0.1 * e : e)) return takes(stands.corners, 0) ? std::optional(corner(0)) : std::nullopt;
  if (at.ab < 1 - e && past_a && at.c < e) return takes(stands.edges, 0) ? std::optional(onEdge(0, 1, at.ab)) : std::nullopt;
  if (at.ac < 1 - e && past_a_too && at.b < e)
    return takes(stands.edges, of_sphere ? 0 : 2) ? std::optional(onEdge(0, 2, at.ac)) : std::nullopt;
  if (at.bc < e) return takes(stands.corners, 1) ? std::optional(corner(1)) : std::nullopt;
  if (at.bc > 1 - e) return takes(stands.corners, 2) ? std::optional(corner(2)) : std::nullopt;
  return takes(stands.edges, of_sphere ? 2 : 1) ? std::optional(onEdge(1, 2, at.bc)) : std::nullopt;
}

enum class Ends { taken, dropped };

std::optional<Weights> onLine(const Vec3& from, const Vec3& to, const Vec3& q, Ends ends) {
  const Vec3 along = to - from;
  double share = (q - from).dot(along) / along.dot(along);
  if (ends == Ends::dropped && !(share >= inside && share <= 1 - inside)) return {};
  share = std::clamp(share, 0.0, 1.0);
  return Weights{1 - share, share, 0};
}

/// Shares along both lines.
std::optional<std::array<double, 2>> betweenLines(const Vec3& p1, const Vec3& p2, const Vec3& q1, const Vec3& q2, double parallel,
                                                  double rim) {
  const Vec3 ab = p2 - p1, cd = q2 - q1, ac = q1 - p1;
  const double a = ab.dot(ab), c = cd.dot(cd), m = -cd.dot(ab), r = ab.dot(ac), s = -cd.dot(ac), det = a * c - m * m;
  if (!(det < -parallel || det > parallel)) return std::array{0.5, 0.5};
  const double alpha = (r * c - s * m) / det, beta = (s * a - r * m) / det;
  if (alpha < rim || alpha > 1 - rim || beta < rim || beta > 1 - rim) return {};
  return std::array{alpha, beta};
}

Weights onEdgeOf(std::size_t edge, double share) {
  Weights weights{};
  weights[edge] = 1 - share, weights[(edge + 1) % 3] = share;
  return weights;
}

constexpr double new_parallel = 1e-12;

}  // namespace

int placeInPair(Kind kind) {
  switch (kind) {
    case Kind::triangle: return 0;
    case Kind::line: return 1;
    case Kind::sphere: return 2;
    case Kind::point: break;
  }
  return 3;
}

PartLister::PartLister(const Method& method, const CollisionModel& first, const CollisionModel& second, const NormalCones& of_first,
                       const NormalCones& of_second)
    : method_(method), first_(first), second_(second), cones_of_first_(of_first), cones_of_second_(of_second) {
  const double skins = first.contactDistance() + second.contactDistance();
  alarm_ = method.alarmDistance() + skins, contact_ = method.contactDistance() + skins;
}

void PartLister::add(const Parts& parts, const Weights& of_p, const Weights& of_q, long number, std::vector<Listed>& out) const {
  Vec3 way = Vec3::Zero();
  for (std::size_t i = 0; i < 3; ++i) way += of_q[i] * parts.y[i] - of_p[i] * parts.x[i];
  const double radii = parts.p.radius + parts.q.radius, alarm = alarm_ + radii, distance = way.norm();
  if (!(distance < alarm)) return;
  if (!cones_of_first_.hold(parts.p, way) || !cones_of_second_.hold(parts.q, -way)) return;
  const Vec3 normal = distance > 1e-15 ? Vec3(way / distance) : Vec3::UnitX();
  out.push_back({{&first_, &second_, {&parts.p, of_p}, {&parts.q, of_q}, normal, contact_ + radii},
                 distance - contact_ - radii,
                 number});
}

/// Corners of the triangle on the line, ends of the line on the triangle, then edges.
void PartLister::meetTriangleAndLine(const Parts& parts, Index j, std::vector<Listed>& out) const {
  const Stands stands = standsOf(parts.p);
  for (std::size_t k = 0; k < 3; ++k)
    if (stands.corners >> k & 1) add(parts, corner(k), *onLine(parts.y[0], parts.y[1], parts.x[k], Ends::taken), j, out);
  for (std::size_t k = 0; k < 2; ++k)
    if (const auto at = onTriangle(parts.x, parts.y[k], stands, false)) add(parts, *at, corner(k), j, out);
  for (std::size_t k = 0; k < 3 && method_.edgesOfTrianglesMeet(); ++k)
    if (stands.edges >> k & 1)
      if (const auto at = betweenLines(parts.x[k], parts.x[(k + 1) % 3], parts.y[0], parts.y[1], new_parallel, inside))
        add(parts, onEdgeOf(k, (*at)[0]), {1 - (*at)[1], (*at)[1], 0}, j, out);
}

void PartLister::meetTriangles(const Parts& parts, Index i, Index j, std::vector<Listed>& out) const {
  if (&first_ == &second_)  // neighbours
    for (int k = 0; k < 9; ++k)
      if (parts.p.node[std::size_t(k / 3)] == parts.q.node[std::size_t(k % 3)]) return;
  const Stands of_p = standsOf(parts.p), of_q = standsOf(parts.q);
  const long number = 3L * i, other = 3L * long(first_.parts().size()) + 12L * j;
  for (std::size_t k = 0; k < 3; ++k)
    if (k == 0 || (of_p.corners >> k & 1))  // SOFA looks at the first corner of each triangle
      if (const auto at = onTriangle(parts.y, parts.x[k], of_q, false)) add(parts, corner(k), *at, number + long(k), out);
  for (std::size_t k = 0; k < 3; ++k)
    if (of_q.corners >> k & 1)
      if (const auto at = onTriangle(parts.x, parts.y[k], of_p, false)) add(parts, *at, corner(k), other + long(k), out);
  for (std::size_t k = 0; k < 9 && method_.edgesOfTrianglesMeet(); ++k) {
    const std::size_t e = k / 3, f = k % 3;
    if (!(of_p.edges >> e & 1) || !(of_q.edges >> f & 1)) continue;
    if (const auto at = betweenLines(parts.x[e], parts.x[(e + 1) % 3], parts.y[f], parts.y[(f + 1) % 3], new_parallel, inside))
      add(parts, onEdgeOf(e, (*at)[0]), onEdgeOf(f, (*at)[1]), other + 3 + long(k), out);
  }
}

void PartLister::meet(Index i, Index j, std::vector<Listed>& out) const {
  const Part &p = first_.parts()[std::size_t(i)], &q = second_.parts()[std::size_t(j)];
  Parts parts{p, q, {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()}, {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()}};
  first_.corners(p, parts.x), second_.corners(q, parts.y);
  using Rule = Method::Rule;
  const bool is_new = method_.rule == Rule::proximity_and_triangles, is_min = method_.rule == Rule::proximity;
  const bool of_sphere = second_.kind() == Kind::sphere;
  const long of_larger = first_.parts().size() > second_.parts().size() ? i : j;
  if (p.corners == 3 && q.corners == 3) return meetTriangles(parts, i, j, out);
  if (p.corners == 3 && q.corners == 2) return meetTriangleAndLine(parts, j, out);
  if (p.corners == 3) {
    const auto at = is_new ? onTriangle(parts.x, parts.y[0], standsOf(p), of_sphere) : withinTriangle(parts.x, parts.y[0]);
    if (at) add(parts, *at, corner(0), j, out);
    return;
  }
  if (p.corners == 2 && q.corners == 2) {
    const bool is_lmd = !is_new && !is_min;
    const auto at = betweenLines(parts.x[0], parts.x[1], parts.y[0], parts.y[1], is_new ? new_parallel : is_min ? 1e-15 : 1e-30,
                                 is_lmd ? 1e-15 : inside);
    if (at) add(parts, {1 - (*at)[0], (*at)[0], 0}, {1 - (*at)[1], (*at)[1], 0}, of_larger, out);
    return;
  }
  if (p.corners == 2) {
    const bool turns = is_min && of_sphere;
    const Ends ends = is_new || (is_min && !of_sphere) ? Ends::taken : Ends::dropped;
    const auto at = onLine(parts.x[turns ? 1 : 0], parts.x[turns ? 0 : 1], parts.y[0], ends);
    if (at) add(parts, *at, corner(0), j, out);
    return;
  }
  const bool numbers_spheres = is_min && first_.kind() == Kind::sphere && second_.kind() == Kind::point;
  add(parts, corner(0), corner(0), numbers_spheres ? i : of_larger, out);
}

}  // namespace stroma::collision
