// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_obstacles.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "framework/mechanics/mass.h"
#include "framework/scene/archive.h"
#include "framework/scene/node.h"

namespace stroma::contact {

void Obstacles::declare(DataTable& table) {
  table.add("planes", planes_).help("planes as obstacles: normal and offset, four numbers each");
  table.add("spheres", spheres_).help("spheres: centre and radius, four numbers each").unit("m");
  table.add("capsules", capsules_).help("capsules: two centres and a radius, seven numbers each").unit("m");
  table.add("cylinders", cylinders_)
      .help("cylinders with flat ends, as prisms of 64 sides: two centres and a radius, seven numbers each")
      .unit("m");
  table.add("boxes", boxes_).help("boxes along the axes: two corners, six numbers each").unit("m");
  table.addLink("meshes", meshes_).help("topologies: the boundary of their volume cells, or their triangles and quads");
  table.add("keyTimes", times_).help("times of movements, ascending").unit("s");
  table.add("movements", movements_).help("displacement of all obstacles at keyTimes, linear between them").unit("m");
  table.add("offset", offset_)
      .help("displacement of all obstacles besides, as of a tool in a hand. What changes it while the scene runs leads them there, "
            "within a step or in several")
      .unit("m")
      .atOnce();
}

void Obstacles::init(bool bodies_meet, const std::string& expected) {
  const bool none = planes_.empty() && spheres_.empty() && capsules_.empty() && cylinders_.empty() && boxes_.empty() &&
                    meshes_.all().empty();
  if (none && !bodies_meet)
    throw ComponentError("there is nothing to be in contact with: no obstacle and no other body", expected);
  if (none && !movements_.empty())
    throw ComponentError("movements move obstacles, and there is none", "planes, spheres, capsules, cylinders, boxes or meshes");
  check();
  start_offset_ = offset_;
  path_.assign(times_, movements_, "keyTimes", "movements");
  if (!times_.empty() || !movements_.empty()) path_.check();
}

/// Before anything is compiled: what is wrong is then told of the component that has it.
void Obstacles::check() const {
  const auto each = [](const std::vector<double>& numbers, std::size_t count, const char* name, auto&& look) {
    if (numbers.size() % count != 0)
      throw ComponentError(fmt::format("{} has {} numbers", name, numbers.size()), fmt::format("{} for each", count));
    for (std::size_t i = 0; i < numbers.size(); i += count) look(numbers.data() + i);
  };
  const auto radius = [](double r) {
    if (!(r > 0)) throw ComponentError(fmt::format("an obstacle has a radius of {:g}", r), "a length above zero");
  };
  const auto length = [](const double* p) { return std::hypot(p[0] - p[3], p[1] - p[4], p[2] - p[5]); };
  each(planes_, 4, "planes", [](const double* p) {
    if (!(std::hypot(p[0], p[1], p[2]) > 0)) throw ComponentError("a plane has no normal", "a vector that is not zero");
  });
  each(spheres_, 4, "spheres", [&](const double* p) { radius(p[3]); });
  each(capsules_, 7, "capsules", [&](const double* p) { radius(p[6]); });
  each(cylinders_, 7, "cylinders", [&](const double* p) {
    radius(p[6]);
    if (!(length(p) > 0)) throw ComponentError("a cylinder has two centres at one place", "a length above zero");
  });
  each(boxes_, 6, "boxes", [](const double*) {});
}

namespace {
/// A prism whose sides touch the cylinder from within by half of what its corners stand out.
void addCylinder(BarrierLaw& law, const Vec3& from, const Vec3& to, double radius) {
  constexpr int sides = 64;
  const Vec3 axis = to - from;
  const Vec3 across = axis.unitOrthogonal(), upwards = axis.normalized().cross(across);
  const double corner = 2 * radius / (1 + std::cos(M_PI / sides));
  std::vector<Vec3> points{from, to};
  std::vector<std::array<int, 3>> faces;
  for (int k = 0; k < sides; ++k) {
    const double angle = 2 * M_PI * k / sides;
    const Vec3 out = corner * (std::cos(angle) * across + std::sin(angle) * upwards);
    points.push_back(from + out), points.push_back(to + out);
    const int a = 2 + 2 * k, b = 2 + 2 * ((k + 1) % sides);
    faces.insert(faces.end(), {{0, b, a}, {1, a + 1, b + 1}, {a, b, a + 1}, {b, b + 1, a + 1}});
  }
  law.surfaces.addObstacle(points, faces, 0);
}
}  // namespace

void Obstacles::addTo(BarrierLaw& law) const {
  const auto each = [](const std::vector<double>& numbers, std::size_t count, auto&& add) {
    for (std::size_t i = 0; i < numbers.size(); i += count) add(numbers.data() + i);
  };
  const auto point = [](const double* p) { return Vec3(p[0], p[1], p[2]); };
  law.planes.clear();
  each(planes_, 4, [&](const double* p) {
    const double length = point(p).norm();
    law.planes.push_back({point(p) / length, p[3] / length});
  });
  each(spheres_, 4, [&](const double* p) {
    law.surfaces.addObstacle({point(p)}, {{0, 0, 0}}, p[3]);
  });
  each(capsules_, 7, [&](const double* p) {
    law.surfaces.addObstacle({point(p), point(p + 3)}, {{0, 0, 1}}, p[6]);
  });
  each(cylinders_, 7, [&](const double* p) { addCylinder(law, point(p), point(p + 3), p[6]); });
  each(boxes_, 6, [&](const double* p) {
    std::vector<Vec3> corners;
    for (int k = 0; k < 8; ++k) corners.emplace_back(p[k & 1 ? 3 : 0], p[k & 2 ? 4 : 1], p[k & 4 ? 5 : 2]);
    law.surfaces.addObstacle(corners,
                             {{0, 2, 1},
                              {1, 2, 3},
                              {4, 5, 6},
                              {5, 7, 6},
                              {0, 1, 4},
                              {1, 5, 4},
                              {2, 6, 3},
                              {3, 6, 7},
                              {0, 4, 2},
                              {2, 4, 6},
                              {1, 3, 5},
                              {3, 7, 5}},
                             0);
  });
  for (const Topology* mesh : meshes_.all()) {
    const std::size_t before = law.surfaces.faces.size();
    law.surfaces.addObstacle(mesh->mesh(), mesh->mesh().position);
    if (law.surfaces.faces.size() == before)
      throw ComponentError(fmt::format("{} has no triangle, quad or volume cell", mesh->path()), "a surface");
  }
}

void serializePlace(Archive& archive, const std::string& name, Vec3& place) {
  for (int k = 0; k < 3; ++k) archive.value(name + '_' + char('x' + k), place[k]);
}

void addShapes(const BarrierLaw& law, std::vector<DrawnObstacles::Shape>& shapes) {
  for (const Plane& plane : law.planes) shapes.push_back({{plane.offset * plane.normal}, {}, 0, plane.normal});
  const Surfaces& s = law.surfaces;
  for (const Surfaces::Body& body : s.bodies()) {
    if (body.moves || body.faces == 0) continue;
    DrawnObstacles::Shape shape;
    const auto first = s.rest.begin() + body.first_vertex;
    shape.points.assign(first, first + body.vertices);
    if (body.vertices <= 2) shape.radius = s.radius[std::size_t(body.first_face)];
    for (int f = body.first_face; shape.radius == 0 && f < body.first_face + body.faces; ++f) {
      const auto& [a, b, c] = s.faces[std::size_t(f)];
      shape.triangles.push_back({a - body.first_vertex, b - body.first_vertex, c - body.first_vertex});
    }
    shapes.push_back(std::move(shape));
  }
}

namespace {
/// That surfaces of bodies enclose at rest, or their area times the range.
double volumeOf(const BarrierLaw& law) {
  const Surfaces& s = law.surfaces;
  double sum = 0;
  for (const Surfaces::Body& body : s.bodies()) {
    if (!body.moves) continue;
    const Vec3 origin = s.rest[std::size_t(body.first_vertex)];
    double area = 0, volume = 0;
    for (int f = body.first_face; f < body.first_face + body.faces; ++f) {
      const auto at = [&](std::size_t k) { return Vec3(s.rest[std::size_t(s.faces[std::size_t(f)][k])] - origin); };
      area += s.area[std::size_t(f)], volume += at(0).dot(at(1).cross(at(2))) / 6;
    }
    sum += std::max(std::abs(volume), law.range * area);
  }
  return sum;
}
}  // namespace

double fastestLead(const BarrierLaw& law, const std::vector<State*>& bodies) {
  std::vector<Mass*> masses;
  bodies.front()->node().root().collect(masses);
  double own = 0, all = 0;
  for (const Mass* mass : masses) {
    all += mass->totalMass();
    if (std::find(bodies.begin(), bodies.end(), &mass->state()) != bodies.end()) own += mass->totalMass();
  }
  const double mass = own > 0 ? own : all;  // of what carries mapped surfaces
  return mass > 0 ? 0.1 * std::sqrt(law.stiffness * volumeOf(law) / mass) : std::numeric_limits<double>::infinity();
}

std::string describe(const Candidates::Crossing& crossing, const Surfaces& surfaces,
                     const std::function<std::string(int)>& name) {
  const auto& ends = surfaces.edges[std::size_t(crossing.edge)];
  const auto& corners = surfaces.faces[std::size_t(crossing.face)];
  const std::string how = crossing.depth > 0 ? fmt::format("goes {:.3g} m through", crossing.depth) : "touches";
  return fmt::format("the edge from {} to {} {} the triangle of {}, {} and {}", name(ends[0]), name(ends[1]), how, name(corners[0]),
                     name(corners[1]), name(corners[2]));
}

std::string describeWorst(const BarrierLaw& law, const std::vector<Vec3>& x, const std::function<std::string(int)>& name) {
  const Touch* worst = nullptr;
  for (const Touch& touch : law.touches(x))
    if ((!(touch.gap > 0) || !law.forceOf(touch).allFinite()) && !(worst && touch.gap >= worst->gap)) worst = &touch;
  if (!worst) return {};
  const auto at = [&](auto which) { return worst->v[std::size_t(which - worst->c.begin())]; };
  int one = at(std::max_element(worst->c.begin(), worst->c.end())), other = at(std::min_element(worst->c.begin(), worst->c.end()));
  if (!law.surfaces.moves(one)) std::swap(one, other);
  return fmt::format("{} and {}: a gap of {:.4g} m", name(one), worst->v[1] < 0 ? "a plane" : name(other), worst->gap);
}

void refuseOverlap(const std::string& path, const BarrierLaw& law, const std::vector<Vec3>& x,
                   const std::function<std::string(int)>& name, double margin) {
  std::string found;
  law.candidates.find(x, margin > 0 ? margin : law.range);  // the exact test is then a proof for what has been found
  const auto crossings = law.candidates.crossings(x);
  for (std::size_t i = 0; i < std::min<std::size_t>(3, crossings.size()); ++i)
    found += (found.empty() ? "" : "; ") + describe(crossings[i], law.surfaces, name);
  if (!found.empty())
    throw ComponentError(fmt::format("bodies of {} start in one another, in {} places: {}", path, crossings.size(), found),
                         "a start in which surfaces do not cross");
  double deepest = 0;
  int pairs = 0;
  const auto look = [&](double gap, int vertex, const char* what) {
    if (gap > 0) return;
    if (++pairs == 1 || gap < deepest)
      deepest = gap, found = gap < 0 ? fmt::format("{} is {:.3g} m inside {}", name(vertex), -gap, what)
                                     : fmt::format("{} touches {}", name(vertex), what);
  };
  for (const Candidate& pair : law.candidates.pairs())
    if (pair.pushes && pair.distance <= law.thickness)  // a lower bound
      look(closestPoints(pair.kind, law.candidates.pointsOf(pair, x)).distance() - pair.radius - law.thickness,
           law.surfaces.moves(pair.v[0]) ? pair.v[0] : pair.v[3],
           pair.radius > 0 ? law.surfaces.moves(pair.v[3]) && law.surfaces.moves(pair.v[0]) ? "another body" : "an obstacle"
                           : "the thickness of another surface");
  for (std::size_t p = 0; p < law.planes.size(); ++p)
    for (std::size_t v = 0; v < x.size(); ++v)
      if (law.surfaces.moves(int(v))) look(law.gapToPlane(p, v, x[v]), int(v), "a plane");
  if (pairs > 0)
    throw ComponentError(fmt::format("bodies of {} start in one another, in {} pairs; the deepest: {}", path, pairs, found),
                         "a start with gaps everywhere");
}

}  // namespace stroma::contact
