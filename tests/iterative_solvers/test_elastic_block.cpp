// SPDX-License-Identifier: LGPL-2.1-or-later
// The block on which solvers are tested: energies, forces and masses of motions that its elements have exactly.
#include <gtest/gtest.h>

#include "tests/iterative_solvers/block_problem.h"

namespace stroma::test {
namespace {

/// E = 10, nu = 0.3, 3 x 2 x 2 cells of half a metre, held nowhere.
ElasticBlock freeBlock() {
  ElasticBlock block = box(3, 2, 2);
  block.size = 0.5, block.young = 10, block.hold_floor = false;
  return block;
}

/// gradient X of every node.
Eigen::VectorXd linear(const ElasticBlock& block, const Mat3& gradient) {
  Eigen::VectorXd u(3 * block.count());
  for (Index k = 0; k < block.nodes(2); ++k)
    for (Index j = 0; j < block.nodes(1); ++j)
      for (Index i = 0; i < block.nodes(0); ++i)
        u.segment<3>(3 * block.node(i, j, k)) = block.size * (gradient * Vec3(i, j, k));
  return u;
}

TEST(ElasticBlock, HasTheEnergyOfAUniformStrain) {
  Mat3 gradient, turn;
  gradient << 0.1, 0.2, -0.3, 0.05, -0.2, 0.4, 0.15, -0.1, 0.3;
  turn << 0, 0.3, -0.1, -0.3, 0, 0.2, 0.1, -0.2, 0;
  const Mat3 strain = (gradient + gradient.transpose()) / 2;
  const double lambda = 10 * 0.3 / (1.3 * 0.4), mu = 10 / 2.6;
  const double energy = 12 * 0.125 * (lambda * strain.trace() * strain.trace() + 2 * mu * strain.squaredNorm());
  for (const bool mean : {false, true}) {
    ElasticBlock block = freeBlock();
    block.mean = mean;
    const Eigen::MatrixXd k = block.matrix().dense();
    const Eigen::VectorXd u = linear(block, gradient), f = k * u;
    EXPECT_NEAR(u.dot(f), energy, 1e-12 * energy);
    for (const Index inner : {block.node(1, 1, 1), block.node(2, 1, 1)})
      EXPECT_LT(f.segment<3>(3 * inner).norm(), 1e-13);
    EXPECT_LT((k * linear(block, turn)).norm(), 1e-13);
    EXPECT_LT((k - k.transpose()).norm(), 1e-13);
    block.stiffer = [](Vec3 at) { return at.x() < 1 ? 3. : 1.; };
    EXPECT_NEAR(u.dot(block.matrix().dense() * u), energy * 5 / 3, 1e-12 * energy);
  }
}

TEST(ElasticBlock, HasTheMassOfItsDensity) {
  ElasticBlock block = freeBlock();
  block.young = 1e-300, block.density = 7;
  const Eigen::MatrixXd m = block.matrix().dense();
  const Eigen::VectorXd along = Vec3(1, -2, 3).replicate(block.count(), 1);
  EXPECT_NEAR(along.dot(m * along), 7 * 1.5 * 14, 1e-11);
  const Eigen::VectorXd stretched = linear(block, Vec3(1, 0, 0).asDiagonal());  // the integral of x^2 from 0 to 1.5
  EXPECT_NEAR(stretched.dot(m * stretched), 7 * 1.5 * 1.5 * 1.5 / 3, 1e-12);
}

TEST(ElasticBlock, HeldDirectionsAreThoseOfTheIdentity) {
  ElasticBlock floor = freeBlock(), wall = freeBlock(), slide = freeBlock();
  floor.hold_floor = wall.hold_wall = slide.slide_wall = true;
  const Eigen::MatrixXd whole = freeBlock().matrix().dense();
  for (const ElasticBlock& block : {floor, wall, slide}) {
    const auto isHeld = [&](Index row) {
      const Index node = row / 3;
      return block.hold_floor ? node < block.node(0, 0, 1)
                              : node % block.nodes(0) == 0 && (block.hold_wall || row % 3 == 0);
    };
    const Eigen::MatrixXd k = block.matrix().dense();
    for (Index row = 0; row < k.rows(); ++row)
      for (Index column = 0; column < k.cols(); ++column)
        ASSERT_EQ(k(row, column), isHeld(row) || isHeld(column) ? double(row == column) : whole(row, column))
            << row << " " << column;
  }
}

}  // namespace
}  // namespace stroma::test
