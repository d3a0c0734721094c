// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces on few ways to move, against the laws of Signorini and Coulomb themselves.
#include "components/integrators/redundant_forces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace stroma::test {
namespace STROMA_TEST_FILE {

using Kind = LagrangianRows::Kind;

/// A rigid plate of 1 kg on `each` x `each` points of its square, which gravity and a push along x act on for a step.
struct Plate {
  LagrangianRows rows;
  Eigen::MatrixXd w;
  Eigen::VectorXd g, l;
  std::vector<double> sizes, yields, allowed;
  std::vector<std::size_t> live;

  Plate(int each, double mu, double push) {
    const Eigen::Index n = 3 * each * each;
    Eigen::MatrixXd j = Eigen::MatrixXd::Zero(n, 6);
    constexpr double inertia = 1. / 6, height = 0.01;
    for (int a = 0; a < each; ++a)
      for (int b = 0; b < each; ++b) {
        const Eigen::Vector3d arm(a / (each - 1.) - 0.5, b / (each - 1.) - 0.5, -height);
        const Eigen::Vector3d axes[3] = {Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()};
        for (int k = 0; k < 3; ++k)
          j.row(3 * (a * each + b) + k) << axes[k].transpose(), arm.cross(axes[k]).transpose() / std::sqrt(inertia);
      }
    w = j * j.transpose();
    g = j * (Eigen::VectorXd(6) << push, 0, -10, 0, 0, 0).finished();
    l.setZero(n), sizes.assign(std::size_t(n), 1), yields = sizes;
    for (Eigen::Index i = 0; i < n; ++i) {
      rows.begin(i % 3 == 0 ? Kind::push : Kind::rub, g[i], i % 3 == 0 ? 0 : mu);
      live.push_back(std::size_t(i));
    }
  }
  bool find(RedundantForces& forces, const std::vector<LagrangianRows::Row>& of) {
    constexpr double no_limit = std::numeric_limits<double>::infinity();
    return forces.find({of, live, w, g, sizes, yields, allowed, 0, false, false, no_limit}, l, {});
  }
};

TEST(RedundantForces, HoldAPlateOnManyPoints) {
  for (const double push : {2.0, 4.0}) {  // less and more than mu m g
    Plate plate(8, 0.3, push);
    RedundantForces forces;
    ASSERT_TRUE(plate.find(forces, plate.rows.rows()));
    EXPECT_EQ(forces.contradiction(), 0);
    const Eigen::VectorXd r = plate.g + plate.w * plate.l;
    double weight = 0, friction = 0;
    for (Eigen::Index i = 0; i < r.size(); i += 3) {
      EXPECT_GE(plate.l[i], 0);
      EXPECT_NEAR(r[i], 0, 1e-9);
      EXPECT_LE(plate.l.segment<2>(i + 1).norm(), 0.3 * plate.l[i] + 1e-9);
      EXPECT_NEAR(r[i + 1], push > 3 ? push - 3 : 0, 1e-9);
      weight += plate.l[i], friction += plate.l[i + 1];
    }
    EXPECT_NEAR(weight, 10, 1e-8);
    EXPECT_NEAR(friction, -std::min(push, 3.0), 1e-8);
  }
}

/// At rest an even layer carries the weight: its pressure is the same everywhere, whatever W says of the ways of a point.
TEST(RedundantForces, AreThoseOfAnEvenLayer) {
  Plate plate(6, 0.3, 0);
  for (std::size_t i = 0; i < plate.yields.size(); ++i) plate.yields[i] = (i / 3 + i / 18) % 2 == 0 ? 1 : 2;  // 1 over the area
  RedundantForces forces;
  ASSERT_TRUE(plate.find(forces, plate.rows.rows()));
  EXPECT_LE(forces.unsettled(), 1e-11);
  for (Eigen::Index i = 0; i < plate.l.size(); i += 3)
    EXPECT_NEAR(plate.l[i] * plate.yields[std::size_t(i)], 10. / (18 + 9), 1e-4) << i;
}

/// Forces that hold are those of the next step: nothing is searched for.
TEST(RedundantForces, BeginFromThoseBefore) {
  Plate plate(6, 0.3, 2);
  RedundantForces forces;
  ASSERT_TRUE(plate.find(forces, plate.rows.rows()));
  const Eigen::VectorXd before = plate.l;
  forces.steps = forces.rounds = 0;
  ASSERT_TRUE(plate.find(forces, plate.rows.rows()));
  EXPECT_EQ(forces.steps + forces.rounds, 0);
  EXPECT_LE((plate.l - before).cwiseAbs().maxCoeff(), 1e-12);
}

/// Gaps that no motion closes together: their contradiction is told, and what is left of them is not larger.
TEST(RedundantForces, TellWhatContradicts) {
  Plate plate(5, 0, 0);
  LagrangianRows rows;
  for (Eigen::Index i = 0; i < plate.g.size(); ++i) rows.begin(Kind::equal, plate.g[i], 0);
  plate.g[0] += 1e-7;
  RedundantForces forces;
  ASSERT_TRUE(plate.find(forces, rows.rows()));
  EXPECT_GT(forces.contradiction(), 1e-9);
  EXPECT_LT(forces.contradiction(), 4e-7);
  EXPECT_LT((plate.g + plate.w * plate.l).cwiseAbs().maxCoeff(), 2e-7);
}

/// Slides that no motion of the plate makes contradict each other by more than they may be off: not all points can stick. Forces
/// against each other grow to where friction ends, and sweeps find them, row by row and within the cones.
TEST(RedundantForces, OfSweepsAreWithinTheirCones) {
  Plate plate(4, 0.3, 0);
  plate.allowed.assign(plate.sizes.size(), 1e-6);
  for (Eigen::Index i = 0; i < plate.g.size(); ++i)
    if (i % 3 != 0) plate.g[i] += (i * 7 % 11 - 5) * 1e-5;  // no turn of the plate moves points so
  RedundantForces forces;
  ASSERT_TRUE(plate.find(forces, plate.rows.rows()));
  EXPECT_GT(forces.sweeps, 0);
  const Eigen::VectorXd r = plate.g + plate.w * plate.l;
  double weight = 0;
  for (Eigen::Index i = 0; i < r.size(); i += 3) {
    EXPECT_GE(plate.l[i], 0);
    EXPECT_GE(r[i], -1e-6);
    EXPECT_LE(std::min(plate.l[i], r[i]), 1e-6);
    const double rubs = plate.l.segment<2>(i + 1).norm(), most = 0.3 * plate.l[i], slide = r.segment<2>(i + 1).norm();
    EXPECT_LE(rubs, most * (1 + 1e-9));
    if (slide > 1e-6) {
      EXPECT_GT(rubs, 0.999 * most) << i;
    }
    weight += plate.l[i];
  }
  EXPECT_NEAR(weight, 10, 1e-4);
}

/// Where bodies have as many ways to move as there are conditions, the only forces that hold are found.
TEST(RedundantForces, AreTheOnlyOnesOfIndependentRows) {
  Plate plate(2, 0.3, 0);
  plate.w += Eigen::MatrixXd::Identity(12, 12);
  const Eigen::VectorXd only = -plate.w.partialPivLu().solve(plate.g);  // all points push and stick
  for (Eigen::Index i = 0; i < only.size(); i += 3) {
    ASSERT_GT(only[i], 0);
    ASSERT_LT(only.segment<2>(i + 1).norm(), 0.3 * only[i]);
  }
  plate.l.setConstant(3);
  RedundantForces forces;
  EXPECT_TRUE(plate.find(forces, plate.rows.rows()));
  EXPECT_LT((plate.l - only).cwiseAbs().maxCoeff(), 1e-8 * only.maxCoeff());
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
