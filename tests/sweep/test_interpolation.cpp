// SPDX-License-Identifier: LGPL-2.1-or-later
// Fields on different meshes at common points.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/sweep/common_points.h"
#include "tools/sweep/error_measure.h"

namespace stroma::sweep {
namespace {

/// The unit cube of n x n x n boxes, sheared and curved so that no cell is a box: hexahedra, or six tetrahedra each.
Body cube(int n, bool tetrahedra) {
  Body body;
  body.path = "/body/dofs";
  const auto node = [n](int i, int j, int k) { return Index((k * (n + 1) + j) * (n + 1) + i); };
  for (int k = 0; k <= n; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const double x = double(i) / n, y = double(j) / n, z = double(k) / n;
        const double bump = 0.3 / n * x * (1 - x) * y * (1 - y) * z * (1 - z) * 16;
        body.rest.emplace_back(x + bump, y - bump, z + 0.5 * bump);
      }
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const Hexahedron c{node(i, j, k),     node(i + 1, j, k),     node(i + 1, j + 1, k),     node(i, j + 1, k),
                           node(i, j, k + 1), node(i + 1, j, k + 1), node(i + 1, j + 1, k + 1), node(i, j + 1, k + 1)};
        if (!tetrahedra) {
          body.hexahedra.push_back(c);
          continue;
        }
        const int cuts[6][2] = {{1, 2}, {2, 3}, {3, 7}, {7, 4}, {4, 5}, {5, 1}};
        for (const auto& cut : cuts)
          body.tetrahedra.push_back({c[0], c[std::size_t(cut[0])], c[std::size_t(cut[1])], c[6]});
      }
  body.x = body.rest;
  body.v.assign(body.rest.size(), Vec3::Zero());
  return body;
}

EndState endOf(Body body) {
  EndState end;
  end.bodies.push_back(std::move(body));
  return end;
}

/// u = A X + b
Vec3 affine(const Vec3& x) { return {0.3 * x.x() - 0.1 * x.y() + 1, 0.2 * x.z() - 2, -0.4 * x.x() + 0.7 * x.z()}; }

void displace(Body& body, Vec3 (*field)(const Vec3&)) {
  for (std::size_t i = 0; i < body.rest.size(); ++i) body.x[i] = body.rest[i] + field(body.rest[i]);
}

TEST(CellFinder, PlacesPointsBackWhereTheyAre) {
  for (const bool tetrahedra : {true, false}) {
    const Body body = cube(3, tetrahedra);
    const CellFinder finder(body);
    for (int i = 0; i < 200; ++i) {
      const Vec3 p = Vec3(0.5, 0.5, 0.5) + 0.49 * Vec3(std::sin(i), std::sin(2.1 * i), std::cos(3.7 * i));
      const Place place = finder.find(p);
      EXPECT_EQ(place.distance, 0) << p.transpose();
      EXPECT_LT((place.of(body.rest) - p).norm(), 1e-12) << p.transpose();
      for (int a = 0; a < place.corners; ++a) EXPECT_GT(place.weights[std::size_t(a)], -1e-9);
    }
  }
}

TEST(CellFinder, ContinuesTheNearestCellOutside) {
  const Body body = cube(2, true);
  const Place place = CellFinder(body).find({0.5, 0.5, 1.25});
  EXPECT_NEAR(place.distance, 0.25, 1e-12);
  EXPECT_LT((place.of(body.rest) - Vec3(0.5, 0.5, 1.25)).norm(), 1e-12);
}

TEST(CellFinder, NoCellIsNearerThanTheOneFound) {
  const Body body = cube(3, true);
  const CellFinder finder(body);
  for (int i = 0; i < 50; ++i) {
    const Vec3 p = Vec3(0.5, 0.5, 0.5) + (0.2 * i - 3) * Vec3(std::sin(i), std::sin(2.1 * i), std::cos(3.7 * i));
    double nearest = std::numeric_limits<double>::infinity();
    for (const Tetrahedron& cell : body.tetrahedra) {
      Body alone = body;
      alone.tetrahedra = {cell};
      nearest = std::min(nearest, CellFinder(alone).find(p).distance);
    }
    EXPECT_NEAR(finder.find(p).distance, nearest, 1e-12) << p.transpose();
  }
}

TEST(CommonPoints, LinearFieldsAreExactBetweenAllMeshes) {
  for (const bool fine_tetrahedra : {true, false})
    for (const bool coarse_tetrahedra : {true, false}) {
      Body fine = cube(4, fine_tetrahedra), coarse = cube(3, coarse_tetrahedra);
      displace(fine, affine), displace(coarse, affine);
      const CommonPoints points(endOf(fine));
      const std::vector<Vec3> u = points.displacements(endOf(coarse));
      ASSERT_EQ(u.size(), points.size());
      for (std::size_t i = 0; i < u.size(); ++i) EXPECT_LT((u[i] - affine(points.places()[i])).norm(), 1e-12);
    }
}

TEST(CommonPoints, WeightsAreVolumes) {
  for (const bool tetrahedra : {true, false}) {
    const Body body = cube(3, tetrahedra);
    double sum = 0;
    const CommonPoints points(endOf(body));
    for (const double weight : points.weights()) sum += weight;
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_NEAR(endOf(body).spacing(), (tetrahedra ? std::sqrt(3) : 1.0) / 3, 0.1);
  }
}

TEST(CommonPoints, BodiesWithoutCellsAreComparedNodeByNode) {
  Body points;
  points.path = "/stones";
  points.rest = {Vec3(0, 0, 0), Vec3(1, 0, 0)};
  points.x = {Vec3(0, 2, 0), Vec3(1, 0, 5)};
  points.v.assign(2, Vec3::Zero());
  const CommonPoints common(endOf(points));
  EXPECT_EQ(common.displacements(endOf(points))[1], Vec3(0, 0, 5));
  Body others = points;
  others.rest.push_back(Vec3(2, 0, 0)), others.x.push_back(Vec3(2, 0, 0)), others.v.push_back(Vec3::Zero());
  EXPECT_THROW(common.displacements(endOf(others)), std::runtime_error);
  others.path = "/other";
  EXPECT_THROW(common.displacements(endOf(others)), std::runtime_error);
}

/// || x ||_L2 over the unit cube is sqrt(1/3).
TEST(ErrorMeasure, NormIsTheIntegral) {
  Body body = cube(4, true);
  displace(body, [](const Vec3& x) { return Vec3(x.x(), 0, 0); });
  const EndState end = endOf(body);
  const CommonPoints points(end);
  const ErrorMeasure l2 = ErrorMeasure::parse("l2"), max = ErrorMeasure::parse("max");
  EXPECT_NEAR(l2.norm(l2.valuesOf(end, {}, points), points), std::sqrt(1.0 / 3), 1e-12);
  EXPECT_GT(max.norm(max.valuesOf(end, {}, points), points), 0.9);
}

TEST(ErrorMeasure, PlacesAreInterpolated) {
  Body body = cube(3, false);
  displace(body, affine);
  const ErrorMeasure place = ErrorMeasure::parse("/body/dofs.displacement:(0.4 0.3 0.77)");
  const Vec3 value = place.valuesOf(endOf(body), {}, {}).at(0);
  EXPECT_LT((value - affine({0.4, 0.3, 0.77})).norm(), 1e-12);
  EXPECT_THROW(ErrorMeasure::parse("/body/dofs.force:(0 0 0)"), std::invalid_argument);
  EXPECT_THROW(ErrorMeasure::parse("/body/dofs.velocity:(0 0)"), std::invalid_argument);
  EXPECT_THROW(ErrorMeasure::parse("L3"), std::invalid_argument);
}

}  // namespace
}  // namespace stroma::sweep
