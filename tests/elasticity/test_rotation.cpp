// SPDX-License-Identifier: LGPL-2.1-or-later
// Rotations against Eigen's singular value decomposition, on doubles and on packs; every shape gives a rotation.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "components/elasticity/rotation_methods.h"
#include "framework/scene/types.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

M3<double> columns(const Mat3& m) {
  return {{m(0, 0), m(1, 0), m(2, 0)}, {m(0, 1), m(1, 1), m(2, 1)}, {m(0, 2), m(1, 2), m(2, 2)}};
}
Mat3 dense(const M3<double>& m) {
  Mat3 r;
  r << m.c0.x, m.c1.x, m.c2.x, m.c0.y, m.c1.y, m.c2.y, m.c0.z, m.c1.z, m.c2.z;
  return r;
}
/// U V^T with the smallest singular value's sign turned where needed: the nearest rotation.
Mat3 nearestRotation(const Mat3& f) {
  const Eigen::JacobiSVD<Mat3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vec3 signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}
Mat3 randomMatrix(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Mat3 m;
  for (int i = 0; i < 9; ++i) m(i / 3, i % 3) = uniform(random);
  return m;
}
void expectRotation(const Mat3& r) {
  EXPECT_LT((r.transpose() * r - Mat3::Identity()).norm(), 2e-14);
  EXPECT_NEAR(r.determinant(), 1, 2e-14);
}

/// check(F, R) for random F and the rotation R that the method finds.
template <class Method, class Check>
void forRandomShapes(unsigned seed, int count, Check&& check) {
  std::mt19937 random(seed);
  for (int i = 0; i < count; ++i) {
    const Mat3 f = randomMatrix(random);
    const Mat3 r = dense(Method::of(columns(f)));
    expectRotation(r);
    check(f, r);
  }
}

TEST(Rotation, SvdIsTheNearestRotationAlsoWhenInverted) {
  int inverted = 0;
  forRandomShapes<rotation::Svd>(3, 20000, [&](const Mat3& f, const Mat3& r) {
    inverted += f.determinant() < 0;
    Eigen::JacobiSVD<Mat3> svd(f);
    const Vec3 s = svd.singularValues();
    const double gap = f.determinant() < 0 ? s[1] - s[2] : s[1] + s[2];  // conditioning of the answer
    EXPECT_LT((r - nearestRotation(f)).norm(), 2e-14 * s[0] / gap) << f;
  });
  EXPECT_GT(inverted, 5000);
}

TEST(Rotation, PolarEqualsSvdUntilInvertedThenFlipsARestAxis) {
  forRandomShapes<rotation::Polar>(4, 5000, [&](const Mat3& f, const Mat3& r) {
    Eigen::JacobiSVD<Mat3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Mat3 q = svd.matrixU() * svd.matrixV().transpose();
    const Mat3 signs = r.transpose() * q;
    if (f.determinant() < 0)
      EXPECT_NEAR(signs.trace(), 1, 1e-9);  // one axis flipped
    else
      EXPECT_NEAR(signs.trace(), 3, 1e-9);
  });
}

TEST(Rotation, QrFrameFollowsTheFirstColumns) {
  forRandomShapes<rotation::Qr>(5, 5000, [&](const Mat3& f, const Mat3& r) {
    EXPECT_LT((r.col(0) - f.col(0).normalized()).norm(), 1e-14);
    EXPECT_LT(std::abs(r.col(2).dot(f.col(1))), 1e-14);
    EXPECT_GT(r.col(1).dot(f.col(1)), 0);
  });
}

TEST(Rotation, FlatCrushedAndExtremeShapesGiveRotations) {
  std::vector<Mat3> shapes{Mat3::Zero(), Mat3::Identity() * 1e-30, Mat3::Identity() * 1e30};
  std::mt19937 random(6);
  for (int i = 0; i < 200; ++i) {
    const Mat3 a = randomMatrix(random), u = nearestRotation(a), v = nearestRotation(randomMatrix(random));
    for (const Vec3& s : {Vec3(1, 1, 0), Vec3(1, 0, 0), Vec3(2, 1e-9, 1e-9), Vec3(1, 1, -1e-15), Vec3(1e5, 1, 1e-5),
                          Vec3(1e8, 1, 1e-12), Vec3(-1, -1, -1)})
      shapes.push_back(u * s.asDiagonal() * v.transpose());
    shapes.push_back(a.col(0) * a.row(1));
  }
  Mat3 two_equal = Mat3::Identity();
  two_equal.col(1) = two_equal.col(0);
  shapes.push_back(two_equal);
  shapes.emplace_back(Mat3::Identity() * 1e60);
  shapes.emplace_back(Vec3(1e60, 1, 1).asDiagonal());
  for (const Mat3& f : shapes) {
    SCOPED_TRACE(f);
    expectRotation(dense(rotation::Svd::of(columns(f))));
    expectRotation(dense(rotation::Polar::of(columns(f))));
    expectRotation(dense(rotation::Qr::of(columns(f))));
  }
}

/// A flat element's rotation is the limit of its neighbours'.
TEST(Rotation, FlatIsTheLimit) {
  std::mt19937 random(8);
  for (int i = 0; i < 200; ++i) {
    const Mat3 u = nearestRotation(randomMatrix(random)), v = nearestRotation(randomMatrix(random));
    const Mat3 flat = u * Vec3(1.3, 0.8, 0).asDiagonal() * v.transpose();
    EXPECT_LT((dense(rotation::Svd::of(columns(flat))) - u * v.transpose()).norm(), 1e-7);
  }
}

template <class Method>
void expectDerivative(unsigned seed, bool inverted) {
  std::mt19937 random(seed);
  int tested = 0;
  while (tested < 300) {
    const Mat3 f = randomMatrix(random) + (inverted ? -1.2 : 1.2) * Mat3::Identity(), d = randomMatrix(random);
    const Eigen::JacobiSVD<Mat3> svd(f);
    if ((f.determinant() < 0) != inverted || svd.singularValues()[1] - svd.singularValues()[2] < 0.3 ||
        svd.singularValues()[2] < 0.3)
      continue;
    const double h = 1e-5;
    const Mat3 difference = (dense(Method::of(columns(f + h * d))) - dense(Method::of(columns(f - h * d)))) / (2 * h);
    if (difference.norm() > 100) continue;  // another axis is flipped between the two
    const M3<double> r = Method::of(columns(f));
    EXPECT_LT((dense(Method::differential(columns(f), r, columns(d))) - difference).norm(),
              1e-7 * (1 + difference.norm()));
    ++tested;
  }
}
TEST(Rotation, DifferentialsAreDerivatives) {
  expectDerivative<rotation::Qr>(1, false);
  expectDerivative<rotation::Polar>(2, false);
  expectDerivative<rotation::Svd>(3, false);
  expectDerivative<rotation::Polar>(4, true);
  expectDerivative<rotation::Svd>(5, true);
}

/// Lanes do not influence each other, whatever the neighbours' shapes.
TEST(Rotation, PacksEqualDoubles) {
  std::mt19937 random(9);
  for (int i = 0; i < 500; ++i) {
    alignas(64) double lane[9][pack_lanes];
    std::vector<Mat3> f;
    for (int l = 0; l < pack_lanes; ++l) {
      f.push_back(randomMatrix(random));
      if (l == 0 && i % 3 == 0) f.back().col(2).setZero();
      for (int k = 0; k < 9; ++k) lane[k][l] = f.back()(k % 3, k / 3);
    }
    const auto load = [&](int k) {
      return V3<Pack>{Pack::load_aligned(lane[k]), Pack::load_aligned(lane[k + 1]), Pack::load_aligned(lane[k + 2])};
    };
    const M3<Pack> r = rotation::Svd::of(M3<Pack>{load(0), load(3), load(6)});
    const Pack* entries[9] = {&r.c0.x, &r.c0.y, &r.c0.z, &r.c1.x, &r.c1.y, &r.c1.z, &r.c2.x, &r.c2.y, &r.c2.z};
    for (int k = 0; k < 9; ++k) entries[k]->store_aligned(lane[k]);
    for (int l = 0; l < pack_lanes; ++l) {
      Mat3 got;
      for (int k = 0; k < 9; ++k) got(k % 3, k / 3) = lane[k][l];
      expectRotation(got);
      const Eigen::JacobiSVD<Mat3> svd(f[l]);
      const Vec3 s = svd.singularValues();
      const double gap = f[l].determinant() < 0 ? s[1] - s[2] : s[1] + s[2];
      EXPECT_LT((got - dense(rotation::Svd::of(columns(f[l])))).norm(), 1e-14 * s[0] / gap);
    }
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
