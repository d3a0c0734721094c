// SPDX-License-Identifier: LGPL-2.1-or-later
// Obstacles as triangles: what is round gets some hundred of them, and a plane is a square as large as the scene.
#include <Eigen/Geometry>
#include <cmath>

#include "tools/drawing/body.h"

namespace stroma::drawing {
namespace {

using Shape = DrawnObstacles::Shape;

Triangle moved(const Triangle& t, Index by) { return {t[0] + by, t[1] + by, t[2] + by}; }

/// Around a place, or the way between two: rings across the axis from one end to the other.
void addRound(const Shape& shape, Obstacle& obstacle) {
  constexpr int around = 32, rings = 8;  // of half a sphere
  const Vec3 &from = shape.points.front(), &to = shape.points.back();
  const Vec3 axis = (to - from).norm() > 0 ? Vec3((to - from).normalized()) : Vec3(0, 0, 1);
  const Vec3 right = axis.unitOrthogonal(), up = axis.cross(right);
  const Index first = Index(obstacle.points.size());
  int ring = 0;
  const auto add = [&](const Vec3& centre, double angle) {
    for (int k = 0; k < around; ++k) {
      const double turn = 2 * M_PI * k / around;
      obstacle.points.push_back(centre + shape.radius * (std::sin(angle) * axis +
                                                         std::cos(angle) * (std::cos(turn) * right + std::sin(turn) * up)));
    }
    for (int k = 0; ring > 0 && k < around; ++k) {
      const Index a = first + (ring - 1) * around + k, b = first + (ring - 1) * around + (k + 1) % around;
      obstacle.triangles.push_back({a, b, a + around}), obstacle.triangles.push_back({b, b + around, a + around});
    }
    ++ring;
  };
  for (int r = 0; r <= rings; ++r) add(from, 0.5 * M_PI * (double(r) / rings - 1));
  for (int r = shape.points.size() > 1 ? 0 : 1; r <= rings; ++r) add(to, 0.5 * M_PI * r / rings);
}

struct Around {
  Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);
  void add(const Vec3& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
};

void addPlane(const Shape& shape, const Around& scene, Obstacle& obstacle) {
  const Vec3 middle = 0.5 * (scene.low + scene.high), normal = shape.normal.normalized();
  const Vec3 centre = middle - normal.dot(middle - shape.points.front()) * normal;
  const double half = 0.75 * (scene.high - scene.low).norm();
  const Vec3 right = half * normal.unitOrthogonal(), up = normal.cross(right);
  const Index first = Index(obstacle.points.size());
  for (const Vec3& corner : {Vec3(-right - up), Vec3(right - up), Vec3(right + up), Vec3(-right + up)})
    obstacle.points.push_back(centre + corner);
  obstacle.triangles.push_back(moved({0, 1, 2}, first)), obstacle.triangles.push_back(moved({0, 2, 3}, first));
}

}  // namespace

void addObstacles(const Simulation& simulation, Drawing& drawing) {
  std::vector<DrawnObstacles*> all;
  simulation.root().collect(all);
  for (const DrawnObstacles* drawn : all) {
    std::vector<Shape> shapes;
    drawn->addShapes(shapes);
    if (shapes.empty()) continue;
    Obstacle obstacle{dynamic_cast<const Component*>(drawn), drawn, {}, {}, 0};
    Around scene;
    for (const Body& body : drawing.bodies)
      for (const Index row : body.node) scene.add(body.state->rest_position[std::size_t(row)]);
    for (const Shape& shape : shapes) {
      if (!shape.normal.isZero(0)) continue;
      const Index first = Index(obstacle.points.size());
      if (shape.triangles.empty()) {
        addRound(shape, obstacle);
      } else {
        obstacle.points.insert(obstacle.points.end(), shape.points.begin(), shape.points.end());
        for (const Triangle& triangle : shape.triangles) obstacle.triangles.push_back(moved(triangle, first));
      }
    }
    obstacle.solid = obstacle.triangles.size();
    for (const Vec3& p : obstacle.points) scene.add(p);
    for (const Shape& shape : shapes)
      if (!shape.normal.isZero(0)) addPlane(shape, scene, obstacle);
    drawing.obstacles.push_back(std::move(obstacle));
  }
}

}  // namespace stroma::drawing
