// SPDX-License-Identifier: LGPL-2.1-or-later
// Rotations that eight nodes follow at once, against the rotation that a matrix was made with.
#include <gtest/gtest.h>

#include <cmath>

#include "components/iterative_solvers/node_rotation.h"

namespace stroma {
namespace {

Mat3 turnedAndStretched(const Vec3& axis, double angle) {
  Mat3 stretch;
  stretch << 1.3, 0.1, -0.05, 0.1, 0.8, 0.02, -0.05, 0.02, 1.1;
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix() * stretch;
}

void set(EightRotations& eight, Index k, const Mat3& a) { eight.a.row(k) = Eigen::Map<const Eigen::Array<double, 1, 9>>(a.data()); }

Eigen::Quaterniond turnOf(const EightRotations& eight, Index k) {
  Eigen::Quaterniond q;
  q.coeffs() = eight.q.row(k).transpose().matrix();
  return q;
}

TEST(EightRotations, AreThoseThatTheMatricesWereTurnedBy) {
  EightRotations eight;
  const auto axis = [](Index k) { return Vec3(1, 0.3 * double(k) - 1, 0.2); };
  for (Index k = 0; k < 8; ++k) set(eight, k, turnedAndStretched(axis(k), 0.28 * double(k)));  // up to 2 rad from the start
  // ten turns, as multigrid makes them; then to the end
  for (const double enough : {1e-3, 1e-7}) {
    SCOPED_TRACE(enough);
    eight.follow(enough / 10);
    for (Index k = 0; k < 8; ++k) {
      const Eigen::Quaterniond expected(Eigen::AngleAxisd(0.28 * double(k), axis(k).normalized()));
      EXPECT_LT(turnOf(eight, k).angularDistance(expected), enough) << k;
      EXPECT_NEAR(turnOf(eight, k).norm(), 1, 1e-14);
    }
    for (int i = 0; i < 3; ++i) eight.follow(1e-9);
  }
}

TEST(EightRotations, StayRotationsOfMatricesWithoutRank) {
  EightRotations eight;
  const double nan = std::nan("");
  set(eight, 0, Mat3::Zero());
  set(eight, 1, Vec3(1, 2, 3) * Vec3(0, 1, 0).transpose());
  set(eight, 2, -Mat3::Identity());
  set(eight, 3, 1e-200 * Mat3::Identity());
  set(eight, 4, 1e100 * turnedAndStretched({0, 0, 1}, 1));
  set(eight, 5, turnedAndStretched({0, 0, 1}, 1) * Vec3(1, 1, 0).asDiagonal());
  set(eight, 6, Mat3::Constant(1e-30));
  set(eight, 7, Mat3::Identity());
  eight.follow(1e-4);
  for (Index k = 0; k < 8; ++k) EXPECT_NEAR(turnOf(eight, k).norm(), 1, 1e-14) << k;
  set(eight, 3, Mat3::Constant(nan));
  eight.follow(1e-4);
  for (Index k = 0; k < 8; ++k) EXPECT_NEAR(turnOf(eight, k).norm(), 1, 1e-14) << k;
}

/// A node without a finite matrix starts anew, and those beside it go on.
TEST(EightRotations, WhatIsNotFiniteStartsAnewAlone) {
  EightRotations eight;
  for (Index k = 0; k < 8; ++k) set(eight, k, turnedAndStretched({1, 2, -1}, 0.1 * double(k + 1)));
  for (int i = 0; i < 3; ++i) eight.follow(1e-9);
  set(eight, 3, Mat3::Constant(std::nan("")));
  set(eight, 6, Mat3::Constant(INFINITY));
  eight.follow(1e-9);
  for (Index k = 0; k < 8; ++k) {
    const double angle = k == 3 || k == 6 ? 0 : 0.1 * double(k + 1);
    const Eigen::Quaterniond expected(Eigen::AngleAxisd(angle, Vec3(1, 2, -1).normalized()));
    EXPECT_LT(turnOf(eight, k).angularDistance(expected), 1e-7) << k;
  }
}

}  // namespace
}  // namespace stroma
