// SPDX-License-Identifier: LGPL-2.1-or-later
// Distances of pairs against a search of their minimum, their gradients against differences.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <random>

#include "framework/collision/pair_distances.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

struct Source {
  std::mt19937 random{5};
  std::uniform_real_distribution<double> uniform{-1, 1};
  Vec3 point() { return {uniform(random), uniform(random), uniform(random)}; }
  FourPoints four() { return {point(), point(), point(), point()}; }
};

/// The smallest distance over grids of the closest points' parameters, refined where it is smallest: no less than the
/// smallest there is, and uses nothing of the code under test.
double searched(PairKind kind, const FourPoints& x) {
  double place[4][3];  // numbers, not matrices: tests are compiled without optimisation
  for (int k = 0; k < 4; ++k)
    for (int c = 0; c < 3; ++c) place[k][c] = x[std::size_t(k)][c];
  const double(&p)[4][3] = place;
  const bool edges = kind == PairKind::edge_edge;
  const auto distance = [&](double s, double t) {
    double squared = 0;
    for (int c = 0; c < 3; ++c) {
      const double d = edges ? (1 - s) * p[0][c] + s * p[1][c] - (1 - t) * p[2][c] - t * p[3][c]
                             : p[0][c] - (1 - s) * p[1][c] - s * ((1 - t) * p[2][c] + t * p[3][c]);
      squared += d * d;
    }
    return std::sqrt(squared);
  };
  double best = 1e300, s0 = 0.5, t0 = 0.5;
  for (double width = 0.5; width > 1e-9; width *= 0.5) {
    double s1 = s0, t1 = t0;
    for (int i = -6; i <= 6; ++i)
      for (int j = -6; j <= 6; ++j) {
        const double s = std::clamp(s0 + width * i / 6, 0., 1.), t = std::clamp(t0 + width * j / 6, 0., 1.);
        if (const double d = distance(s, t); d < best) best = d, s1 = s, t1 = t;
      }
    s0 = s1, t0 = t1;
  }
  return best;
}

/// The distance is one of two points of the pair, and no two points that are tried are nearer.
void expectSmallest(PairKind kind, const FourPoints& x, double size) {
  const ClosestPoints closest = closestPoints(kind, x);
  EXPECT_LE(closest.distance(), searched(kind, x) + 1e-9 * size);
  Vec3 sum = Vec3::Zero();
  double total = 0;
  const std::size_t first_side = kind == PairKind::point_triangle ? 1 : 2;
  for (std::size_t k = 0; k < 4; ++k) {
    const double weight = k < first_side ? closest.weights[k] : -closest.weights[k];
    sum += closest.weights[k] * x[k], total += closest.weights[k];
    EXPECT_TRUE(weight >= 0 && weight <= 1) << weight;
  }
  EXPECT_LT((sum - closest.difference).norm(), 1e-11 * size);
  EXPECT_NEAR(total, 0, 1e-13);
}

TEST(Distances, AreTheSmallestThereAre) {
  Source source;
  for (int i = 0; i < 3000; ++i) {
    const FourPoints x = source.four();
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) expectSmallest(kind, x, 1);
  }
}

/// Slivers, parallel edges and points that coincide, at all scales.
TEST(Distances, OfDegeneratePairs) {
  Source source;
  for (const double scale : {1e-30, 1e-6, 1., 1e12, 1e40})
    for (const double flat : {0., 1e-16, 1e-9, 1e-5})
      for (int i = 0; i < 200; ++i) {
        const Vec3 a = source.point(), along = source.point(), off = source.point();
        FourPoints x{a, a + along, a + off + flat * source.point(), a + off + 0.7 * along + flat * source.point()};
        for (Vec3& p : x) p *= scale;
        expectSmallest(PairKind::edge_edge, x, scale);
        x = {a + off, a, a + 0.3 * along + flat * source.point(), a + along};
        for (Vec3& p : x) p *= scale;
        expectSmallest(PairKind::point_triangle, x, scale);
      }
  const Vec3 p(0.1, 0.2, 0.3), q(0.4, 0.2, 0.1);
  EXPECT_DOUBLE_EQ(closestPoints(PairKind::point_triangle, {p, q, q, q}).distance(), (p - q).norm());
  EXPECT_DOUBLE_EQ(closestPoints(PairKind::edge_edge, {p, p, q, q}).distance(), (p - q).norm());
  EXPECT_EQ(closestPoints(PairKind::edge_edge, {p, p, p, p}).distance(), 0);
}

/// Edges that cross at an angle of 1e-8 touch, which 53 bits do not see: their ends are 1e-9 apart.
TEST(Distances, OfNearlyParallelEdgesThatTouch) {
  for (double angle = 1e-3; angle > 1e-12; angle *= 0.1) {
    const FourPoints x{Vec3(-1, 0, 0), Vec3(1, 0, 0), Vec3(-1, -angle, 0), Vec3(1, angle, 0)};
    EXPECT_LT(closestPoints(PairKind::edge_edge, x).distance(), 1e-13);
  }
}

/// grad_i d = c_i n, which forces are made of.
TEST(Distances, HaveTheirDerivatives) {
  Source source;
  for (int i = 0; i < 400; ++i) {
    const FourPoints x = source.four();
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
      const ClosestPoints closest = closestPoints(kind, x);
      const double step = 1e-6;
      for (std::size_t k = 0; k < 12; ++k) {
        FourPoints a = x, b = x;
        a[k / 3][Eigen::Index(k % 3)] += step, b[k / 3][Eigen::Index(k % 3)] -= step;
        const double slope = (closestPoints(kind, a).distance() - closestPoints(kind, b).distance()) / (2 * step);
        EXPECT_NEAR(slope, closest.weights[k / 3] * closest.difference[Eigen::Index(k % 3)] / closest.distance(), 1e-5);
      }
    }
  }
}

TEST(Distances, TheFactorOfParallelEdgesIsSmooth) {
  const Vec3 e(1, 0, 0);
  EXPECT_EQ(parallelFactor(e, e, 1), 0);
  EXPECT_EQ(parallelFactor(e, Vec3(0, 1, 0), 1), 1);
  const double angle = std::asin(std::sqrt(1e-3));
  EXPECT_NEAR(parallelFactor(e, Vec3(std::cos(angle), std::sin(angle), 0), 1), 1, 1e-9);
  EXPECT_NEAR(parallelFactor(e, Vec3(std::cos(angle / 2), std::sin(angle / 2), 0), 1), 0.4375, 1e-2);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
