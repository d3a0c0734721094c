// SPDX-License-Identifier: LGPL-2.1-or-later
// Shading of surfaces: corners stay sharp, round things are round; outlines of a cube are those that one sees.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tools/picture/eye.h"
#include "tools/picture/surface.h"

namespace stroma::picture {
namespace {

/// The unit cube, each face in two triangles, from outside.
const Points cube{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
const std::vector<Triangle> faces{{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                                  {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};

TEST(SmoothSurfaces, ACubeKeepsItsFacesFlat) {
  const SmoothSurface surface(faces, cube, 0.9);
  EXPECT_EQ(surface.nodes().size(), 24u);  // each corner three times
  const Points normals = surface.normals(cube);
  for (std::size_t t = 0; t < faces.size(); ++t) {
    Vec3 p[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto node = std::size_t(surface.nodes()[std::size_t(surface.triangles()[t][k])]);
      EXPECT_EQ(Index(node), faces[t][k]);
      p[k] = Vec3(cube[3 * node], cube[3 * node + 1], cube[3 * node + 2]);
    }
    const Vec3 n = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    for (const Index corner : surface.triangles()[t])
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(normals[3 * std::size_t(corner) + std::size_t(k)], n[k], 1e-6);
  }
}

TEST(SmoothSurfaces, WhatIsRoundIsShadedRound) {
  const SmoothSurface surface(faces, cube, 1.6);  // more than a right angle
  EXPECT_EQ(surface.nodes().size(), 8u);
  const Points normals = surface.normals(cube);
  for (std::size_t i = 0; i < 8; ++i) {
    const auto node = std::size_t(surface.nodes()[i]);
    double outwards = 0;
    for (std::size_t k = 0; k < 3; ++k) outwards += normals[3 * i + k] * (cube[3 * node + k] - 0.5);
    EXPECT_GT(outwards, 0.5);
  }
}

TEST(SmoothSurfaces, CreasesAreThoseOfTheRestShape) {
  const SmoothSurface surface(faces, cube, 0.9);
  Points flat = cube;
  for (std::size_t i = 2; i < flat.size(); i += 3) flat[i] = 0;  // pressed flat
  EXPECT_EQ(surface.normals(flat).size(), 3u * 24);
  for (const float part : surface.normals(flat)) EXPECT_TRUE(std::isfinite(part));
}

TEST(Outlines, OfACubeAreItsTwelveEdges) {
  const std::vector<Edge> edges = outline(faces, cube, {1, 1, 1}, 0.9);
  EXPECT_EQ(edges.size(), 12u);  // all are creases
  const std::vector<Edge> smooth = outline(faces, cube, Vec3(3, 2, 1).normalized(), 3.2);
  EXPECT_EQ(std::set<Edge>(smooth.begin(), smooth.end()).size(), 6u);  // the hexagon that one sees from a corner
}

TEST(Outlines, BordersAreSeen) { EXPECT_EQ(outline({{0, 1, 2}}, cube, {0, 0, 1}, 0.9).size(), 3u); }

TEST(Eyes, AreRightHandedAndLookWhereTheySay) {
  for (const bool third : {false, true})
    for (const std::string& name : viewNames()) {
      const Eye eye = eyeOf(name, third);
      EXPECT_NEAR((eye.right.cross(eye.up) - eye.back).norm(), 0, 1e-12) << name;
      EXPECT_NEAR(eye.back.norm(), 1, 1e-12);
    }
  EXPECT_EQ(eyeOf("front", false).back, Vec3(0, 0, 1));
  EXPECT_EQ(eyeOf("front", false).up, Vec3(0, 1, 0));
  EXPECT_EQ(eyeOf("right", false).back, Vec3(1, 0, 0));
  EXPECT_EQ(eyeOf("top", false).back, Vec3(0, 1, 0));
  EXPECT_EQ(eyeOf("front", true).back, Vec3(0, -1, 0));
  EXPECT_EQ(eyeOf("front", true).up, Vec3(0, 0, 1));
  EXPECT_EQ(eyeOf("top", true).back, Vec3(0, 0, 1));
  EXPECT_EQ(eyeOf("left", true).back, Vec3(-1, 0, 0));
  const Vec3 iso = eyeOf("iso", false).back;
  EXPECT_NEAR((iso - Vec3(1, 1, 1).normalized()).norm(), 0, 1e-9);
  EXPECT_NEAR((eyeOf("45,0", false).back - Vec3(1, 0, 1).normalized()).norm(), 0, 1e-12);
}

TEST(Eyes, OfNoNameAreRefusedWithTheNearest) {
  for (const std::string name : {"frnt", "45", "45,100", "1,2,3", ""}) EXPECT_ANY_THROW(eyeOf(name, false)) << name;
}

}  // namespace
}  // namespace stroma::picture
