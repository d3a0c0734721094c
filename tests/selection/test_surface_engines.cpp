// SPDX-License-Identifier: LGPL-2.1-or-later
// Spirals by the length of their arc, and shells by their volume.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

template <class T>
const T& made(const Scene& scene, const std::string& attribute) {
  return *std::get<T*>(findComponent(*scene.root, "/e")->data().find(attribute)->pointer());
}

/// The way along r = c t from the centre to a point that lies x along the strip is |x| long.
TEST(Spiral, KeepsLengths) {
  const double c = 0.3, lengths[] = {0.05, 1, -4, 20};
  std::string strip;
  for (const double x : lengths) strip += fmt::format("{} 0 {} ", x, 2 * x);
  const Scene scene = sceneFromText(fmt::format("<Node name='root'><Spiral name='e' rest_position='{}' curvature='{}'/></Node>", strip, c));
  const auto& points = made<std::vector<Vec3>>(scene, "position");
  ASSERT_EQ(points.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const double side = lengths[i] < 0 ? -1 : 1, radius = points[i].head<2>().norm(), angle = radius / c;
    EXPECT_EQ(points[i].z(), 2 * lengths[i]);
    EXPECT_NEAR(points[i].x(), side * radius * std::cos(angle), 1e-12 * radius);
    EXPECT_NEAR(points[i].y(), side * radius * std::sin(angle), 1e-12 * radius);
    double length = 0;
    const int pieces = 20000;
    for (int k = 0; k < pieces; ++k) {
      const double t = angle * (k + 0.5) / pieces;
      length += angle / pieces * c * std::sqrt(1 + t * t);
    }
    EXPECT_NEAR(length, std::abs(lengths[i]), 1e-7 * length);
  }
}

/// y goes across the strip: away from the centre on the far side, at right angles to the way.
TEST(Spiral, TurnsTheWidthOfTheStrip) {
  const Scene scene =
      sceneFromText("<Node name='root'><Spiral name='e' rest_position='5 0 0  5 0.1 0  5.001 0 0  0 0.5 0' curvature='0.2'/></Node>");
  const auto& points = made<std::vector<Vec3>>(scene, "position");
  const Vec3 across = points[1] - points[0], along = points[2] - points[0];
  EXPECT_NEAR(across.norm(), 0.1, 1e-14);
  EXPECT_NEAR(across.dot(along) / along.norm(), 0, 1e-4);
  EXPECT_LT((points[3] - 0.5 * Vec3(-0.6, 0.8, 0)).norm(), 1e-15) << "at the centre it leans";
}

TEST(ExtrudeSurface, MakesAClosedShellOfItsVolume) {
  const Scene scene = sceneFromText(
      R"(<Node name="root"><ExtrudeSurface name="e" surfaceVertices="9 9 9  0 0 0  2 0 0  2 3 0  0 3 0" heightFactor="0.5"
      triangles="0 1 2  1 2 3  1 3 4" surfaceTriangles="1 2"/></Node>)");
  const auto& nodes = made<std::vector<Vec3>>(scene, "extrusionVertices");
  const auto& triangles = made<std::vector<Triangle>>(scene, "extrusionTriangles");
  ASSERT_EQ(nodes.size(), 8u);
  ASSERT_EQ(triangles.size(), 2u * 2 + 4 * 2);
  for (std::size_t i = 0; i < 8; i += 2) EXPECT_LT((nodes[i + 1] - nodes[i] - Vec3(0, 0, 0.5)).norm(), 1e-15);
  double volume = 0;
  std::map<Edge, int> sides;
  for (const Triangle& t : triangles) {
    const auto at = [&](std::size_t i) { return nodes[std::size_t(t[i])]; };
    volume += at(0).dot(at(1).cross(at(2))) / 6;
    for (std::size_t i = 0; i < 3; ++i) ++sides[{std::min(t[i], t[(i + 1) % 3]), std::max(t[i], t[(i + 1) % 3])}];
  }
  for (const auto& [side, count] : sides) EXPECT_EQ(count, 2) << side[0] << " " << side[1];
  EXPECT_NEAR(volume, 2 * 3 * 0.5, 1e-14) << "all triangles are turned outward";
  EXPECT_EQ(triangles[0], (Triangle{0, 4, 2})) << "the surface itself is turned round";
  EXPECT_EQ(triangles[1], (Triangle{1, 3, 5}));
}

TEST(ExtrudeSurface, SaysWhatIsWrong) {
  const auto told = [](const std::string& attributes) {
    return problemsOf("<Node name='root'><ExtrudeSurface surfaceVertices='0 0 0  1 0 0  0 1 0' " + attributes + "/></Node>");
  };
  expectContains(told("triangles='0 1 2' surfaceTriangles='1'"), "surfaceTriangles names 1, and there are 1 triangles");
  expectContains(told("triangles='0 1 7' surfaceTriangles='0'"), "triangles names node 7 of 3");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
