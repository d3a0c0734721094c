// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces with which conditions hold, against the laws of Signorini and Coulomb themselves.
#include "framework/mechanics/condition_forces.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>

namespace stroma::test {
namespace STROMA_TEST_FILE {

using Kind = LagrangianRows::Kind;

/// Signorini's and Coulomb's conditions themselves, where many contacts hold each other.
TEST(ConditionForces, AreThoseOfSignoriniAndCoulomb) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (const double mu : {0.1, 0.7})
    for (const int contacts : {1, 7, 40}) {
      SCOPED_TRACE(fmt::format("mu {} contacts {}", mu, contacts));
      LagrangianRows rows;
      ConditionForces forces;
      const Eigen::Index n = 3 * contacts;
      Eigen::MatrixXd roots(n, n);
      for (Eigen::Index i = 0; i < n * n; ++i) roots.data()[i] = normal(random);
      forces.w = roots * roots.transpose() / double(n) + 0.2 * Eigen::MatrixXd::Identity(n, n);
      forces.g.resize(n), forces.l.setZero(n), forces.sizes.assign(std::size_t(n), 1);
      for (Eigen::Index i = 0; i < n; ++i) {
        forces.g[i] = i % 3 == 0 ? normal(random) - 0.5 : 0.5 * normal(random);
        rows.begin(i % 3 == 0 ? Kind::push : Kind::rub, forces.g[i], i % 3 == 0 ? 0 : mu);
      }
      const Eigen::VectorXd g = forces.g;
      forces.solve(rows.rows());
      EXPECT_LT(forces.unsettled(), 1e-11);
      const Eigen::VectorXd at = g + forces.w * forces.l;
      int open = 0, sticks = 0, slips = 0;
      for (Eigen::Index i = 0; i < n; i += 3) {
        const double l = forces.l[i];
        const Eigen::Vector2d along = forces.l.segment<2>(i + 1), way = at.segment<2>(i + 1);
        EXPECT_GE(l, 0);
        EXPECT_GE(at[i], -1e-10);
        EXPECT_NEAR(l * at[i], 0, 1e-9);
        EXPECT_LE(along.norm(), mu * l + 1e-9);
        if (l == 0) {
          ++open;
        } else if (way.norm() < 1e-9) {
          ++sticks;
        } else {
          ++slips;
          EXPECT_NEAR(along.norm(), mu * l, 1e-9);
          EXPECT_NEAR(along.dot(way), -along.norm() * way.norm(), 1e-8) << "against the way";
        }
      }
      if (contacts < 40) continue;
      EXPECT_TRUE(open > 0 && slips > 0 && (sticks > 0 || mu < 0.5)) << open << " " << sticks << " " << slips;
    }
}

/// What is off of the laws of Signorini and Coulomb, of the largest condition without forces: groups of `per` rows.
double offTheLaws(const ConditionForces& forces, const Eigen::VectorXd& g, const Eigen::MatrixXd& w, double mu, Eigen::Index per) {
  const Eigen::VectorXd at = g + w * forces.l;
  double off = 0, size = 0;
  for (Eigen::Index i = 0; i < g.size(); i += per) {
    const double l = forces.l[i] * w(i, i);  // a length
    size = std::max(size, -g[i]);
    off = std::max({off, -at[i], -l, std::min(at[i], l)});
    if (per == 1) continue;
    const Eigen::Vector2d along = forces.l.segment<2>(i + 1), way = at.segment<2>(i + 1);
    const double bound = mu * forces.l[i], turned = along.dot(way) + bound * way.norm();  // 0: against the way with all it can
    const double can = bound * w(i + 1, i + 1);  // the length that friction can move; round-off of it may have any direction
    off = std::max({off, along.norm() * w(i + 1, i + 1) - can, bound > 0 ? std::min(turned / bound, can) : 0});
  }
  return size > 0 ? off / size : off;
}

/// Contacts on fewer ways to move than conditions; some say what others say, or nearly.
class DependentRows {
 public:
  explicit DependentRows(unsigned seed) : random_(seed) {}
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  /// 2 up to most + 1 contacts of `per` rows.
  void next(Eigen::Index per, unsigned most, double mu, ConditionForces& forces, LagrangianRows& rows) {
    const Eigen::Index n = per * (2 + Eigen::Index(random_() % most));
    const Eigen::Index rank = std::max<Eigen::Index>(2, Eigen::Index(double(n) * between(0.2, 0.9)));
    Eigen::MatrixXd roots = noise(n, rank);
    for (Eigen::Index i = per; i < n; i += per)
      if (random_() % 4 == 0) {
        const Eigen::Index other = per * Eigen::Index(random_() % std::uint64_t(i / per));
        const double apart = random_() % 2 == 0 ? 0 : std::pow(10, between(-6, -4));
        roots.middleRows(i, per) = roots.middleRows(other, per) + apart * noise(per, rank);
      }
    forces.w = roots * roots.transpose(), forces.g = roots * noise(rank, 1), forces.l.setZero(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      if (i % per == 0 && random_() % 3 == 0) forces.g[i] += std::abs(normal_(random_));
      forces.sizes.push_back(roots.row(i).norm());
      rows.begin(i % per == 0 ? Kind::push : Kind::rub, forces.g[i], i % per == 0 ? 0 : mu);
    }
  }

 private:
  Eigen::MatrixXd noise(Eigen::Index rows, Eigen::Index columns) {
    return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal_(random_); });
  }
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

void expectForcesOfDependentRows(unsigned seed) {
  constexpr double mu = 0.3;
  DependentRows problems(seed);
  double pushed = 0;
  for (int trial = 0; trial < 600; ++trial) {
    SCOPED_TRACE(trial);
    const Eigen::Index per = trial % 2 == 0 ? 1 : 3;
    ConditionForces forces;
    LagrangianRows rows;
    problems.next(per, 14, mu, forces, rows);
    const Eigen::VectorXd g = forces.g;
    const Eigen::MatrixXd w = forces.w;
    forces.solve(rows.rows());
    EXPECT_LT(forces.unsettled(), 1e-9);
    EXPECT_LT(offTheLaws(forces, g, w, mu, per), 1e-8);
    pushed += forces.l.cwiseAbs().maxCoeff() > 0;
  }
  EXPECT_GT(pushed, 400);
}

/// Fewer ways to move than conditions; some say what others say, or nearly: forces are many, and where things come to is one. The
/// second seed has 14 contacts with 9 ways to move that an interior-point method finds only where slides are fixed.
TEST(ConditionForces, OfRowsThatSayNearlyTheSame) {
  for (const unsigned seed : {3u, 8u}) {
    SCOPED_TRACE(seed);
    expectForcesOfDependentRows(seed);
  }
}

/// Much friction on few ways to move, as of a grip that presses a soft body: an interior-point method that takes |r_t| as it was a
/// round ago leaves some of these off by a hundredth, after three times as many rounds.
TEST(ConditionForces, OfMuchFrictionOnFewWaysToMove) {
  long rounds = 0, steps = 0;
  for (const unsigned seed : {3u, 6u, 8u}) {
    DependentRows problems(seed);
    for (int trial = 0; trial < 40; ++trial) {
      SCOPED_TRACE(fmt::format("seed {} trial {}", seed, trial));
      ConditionForces forces;
      LagrangianRows rows;
      const double mu = problems.between(0.1, 1.2);
      problems.next(3, 60, mu, forces, rows);
      const Eigen::VectorXd g = forces.g;
      const Eigen::MatrixXd w = forces.w;
      forces.solve(rows.rows());
      EXPECT_LT(forces.unsettled(), 1e-6);
      EXPECT_LT(offTheLaws(forces, g, w, mu, 3), 1e-4);
      EXPECT_EQ(forces.searches, 1);
      rounds += forces.rounds, steps += forces.steps;
    }
  }
  EXPECT_LT(rounds, 3500);
  EXPECT_LT(steps, 9000);
}

/// Rows that contradict each other by a little have no forces: that is found once, and in the next rounds of a step not again.
TEST(ConditionForces, AreSearchedForOnceWhereRowsContradictEachOther) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  const auto noise = [&](Eigen::Index rows, Eigen::Index columns) {
    return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); }).eval();
  };
  const Eigen::MatrixXd roots = noise(30, 12).rowwise().normalized();
  LagrangianRows rows;
  ConditionForces forces;
  forces.w = roots * roots.transpose(), forces.l.setZero(30), forces.sizes.assign(30, 1);
  forces.g.resize(30);
  for (Eigen::Index i = 0; i < 30; ++i) {
    forces.g[i] = roots.row(i).sum() + 1e-7 * normal(random);
    rows.begin(Kind::equal, forces.g[i]);
  }
  forces.solve(rows.rows());
  const long rounds = forces.rounds;
  const double off = forces.unsettled();
  EXPECT_GT(rounds, 0);
  EXPECT_TRUE(off > 1e-9 && off < 1e-6) << off;
  forces.solve(rows.rows());
  EXPECT_EQ(forces.rounds, rounds);
  EXPECT_LT(forces.unsettled(), 2 * off);
  forces.contradiction = 0, forces.solve(rows.rows());
  EXPECT_GT(forces.rounds, rounds) << "of another step";
}

/// What is off by a thousandth of what may be is not searched for again, and what is off by more is.
TEST(ConditionForces, AreNotSearchedForWhereLittleIsOff) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  int met = 0;
  for (int trial = 0; trial < 300 && met < 5; ++trial) {
    const Eigen::Index n = 30, rank = 12;
    const auto noise = [&](Eigen::Index rows, Eigen::Index columns) {
      return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); }).eval();
    };
    const Eigen::MatrixXd roots = noise(n, rank).rowwise().normalized();
    const Eigen::VectorXd g = roots * noise(rank, 1);
    double size = 0;
    for (Eigen::Index i = 0; i < n; i += 3) size = std::max(size, -g[i]);
    const auto offWhere = [&](double may_be) {
      LagrangianRows rows;
      ConditionForces forces;
      forces.w = roots * roots.transpose(), forces.g = g, forces.l.setZero(n), forces.sizes.assign(std::size_t(n), 1);
      for (Eigen::Index i = 0; i < n; ++i) rows.begin(i % 3 == 0 ? Kind::push : Kind::rub, g[i], i % 3 == 0 ? 0 : 0.3);
      forces.solve(rows.rows(), {}, std::vector<double>(std::size_t(n), may_be));
      return forces.unsettled();
    };
    const double off = offWhere(1e30);
    if (!(off > 1e-4 && off < 1)) continue;
    ++met;
    EXPECT_EQ(offWhere(2e3 * off * size), off);
    EXPECT_LT(offWhere(1e2 * off * size), 0.2 * off);
  }
  EXPECT_EQ(met, 5) << "Newton's method alone finds them all";
}

/// Rows that say the same many times cost seconds: a wish to stop ends that with what there is.
TEST(ConditionForces, HeedAStop) {
  StopRequest request;
  request.make();
  for (const bool stops : {true, false}) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    const Eigen::MatrixXd roots = Eigen::MatrixXd::NullaryExpr(60, 20, [&] { return normal(random); });
    LagrangianRows rows;
    ConditionForces forces;
    forces.w = roots * roots.transpose(), forces.g = roots * Eigen::VectorXd::NullaryExpr(20, [&] { return normal(random); });
    forces.l.setZero(60), forces.sizes.assign(60, 1);
    for (Eigen::Index i = 0; i < 60; ++i) rows.begin(Kind::push, forces.g[i]);
    forces.solve(rows.rows(), stops ? StopToken(request) : StopToken());
    EXPECT_EQ(forces.unsettled() < 1e-9, !stops) << forces.unsettled();
    EXPECT_TRUE(forces.l.allFinite());
  }
}

TEST(ConditionForces, TellNumbersThatAreNone) {
  LagrangianRows rows;
  for (int i = 0; i < 2; ++i) rows.begin(Kind::push, -1);
  ConditionForces forces;
  forces.w.setIdentity(2, 2), forces.g = Eigen::Vector2d(std::nan(""), -1), forces.l.setZero(2), forces.sizes.assign(2, 1);
  forces.solve(rows.rows());
  EXPECT_FALSE(std::isfinite(forces.unsettled()));
}

/// Rows that say the same twice share the force, and a bound is kept.
TEST(ConditionForces, OfEqualRowsAndOfBounds) {
  LagrangianRows rows;
  for (int i = 0; i < 2; ++i) rows.begin(Kind::equal, -1);
  rows.begin(Kind::push, -6, 2);
  ConditionForces forces;
  forces.w = Eigen::Matrix3d{{2, 2, 0}, {2, 2, 0}, {0, 0, 1}};
  forces.g = Eigen::Vector3d(-1, -1, -6), forces.l.setZero(3), forces.sizes.assign(3, 1);
  forces.solve(rows.rows());
  EXPECT_NEAR(forces.l[0] + forces.l[1], 0.5, 1e-12);
  EXPECT_NEAR(forces.l[0], forces.l[1], 1e-12);
  EXPECT_NEAR(forces.l[2], 2, 1e-12) << "no more than its bound";
}

/// Where a body buckles, W is not positive: what is equal holds all the same, and a contact that cannot is told.
TEST(ConditionForces, OfNegativeCompliance) {
  LagrangianRows rows, after;
  for (int i = 0; i < 2; ++i) rows.begin(Kind::equal, 1);
  rows.begin(Kind::push, -2);
  ConditionForces forces;
  forces.w = Eigen::Vector3d(1, -1, -1).asDiagonal(), forces.g = Eigen::Vector3d(1, 1, -2), forces.l.setZero(3);
  forces.sizes.assign(3, 1);
  forces.solve(rows.rows());
  EXPECT_LT((forces.l - Eigen::Vector3d(-1, 1, 0)).norm(), 1e-12);
  for (int i = 0; i < 2; ++i) after.begin(Kind::equal, 0);
  after.begin(Kind::push, -2);
  EXPECT_EQ(forces.worst(after.rows()).row, 2u);
  EXPECT_NEAR(forces.worst(after.rows()).off, 2, 1e-12);
  after.clear();
  after.begin(Kind::equal, 0), after.begin(Kind::equal, 0.5), after.begin(Kind::push, 0);
  EXPECT_EQ(forces.worst(after.rows()).row, 1u);
  EXPECT_NEAR(forces.worst(after.rows()).off, 0.5, 1e-12);
}

/// What is told of where rows have come to: a slide against Coulomb's law, a contact that pushes at a distance.
TEST(ConditionForces, SayWhatIsFarthestFromItsLaw) {
  // one contact with mu = 0.5 on a body of W = 1 that falls by 2 and slides by (3, 0): l = (2, -1, 0), and (2, 0) of the slide is left
  const auto solved = [](LagrangianRows& rows) {
    rows.begin(Kind::push, -2), rows.add(0, Vec3(0, 0, 1));
    rows.begin(Kind::rub, 3, 0.5), rows.add(0, Vec3(1, 0, 0));
    rows.begin(Kind::rub, 0, 0.5), rows.add(0, Vec3(0, 1, 0));
    ConditionForces forces;
    forces.w.setIdentity(3, 3), forces.g = Eigen::Vector3d(-2, 3, 0), forces.l.setZero(3), forces.sizes.assign(3, 1);
    forces.solve(rows.rows());
    return forces;
  };
  const auto worstAt = [&](double gap, double x, double y) {
    LagrangianRows before, after;
    ConditionForces forces = solved(before);
    EXPECT_LT((forces.l - Eigen::Vector3d(2, -1, 0)).norm(), 1e-12);
    after.begin(Kind::push, gap), after.begin(Kind::rub, x, 0.5), after.begin(Kind::rub, y, 0.5);
    return forces.worst(after.rows());
  };
  EXPECT_LT(worstAt(0, 2, 0).off, 1e-12) << "where the forces put it";
  EXPECT_LT(worstAt(0, 0.1, 0).off, 1e-12) << "slower, and friction is against it all the same";
  const auto across = worstAt(0, 2, 0.3);
  EXPECT_TRUE(across.rubs);
  EXPECT_EQ(across.row, 1u);
  EXPECT_GT(across.off, 0.05) << "friction of another direction";
  EXPECT_TRUE(worstAt(0, -0.4, 0).rubs) << "friction along the slide";
  EXPECT_NEAR(worstAt(0, -0.4, 0).off, 0.4, 1e-12);
  EXPECT_NEAR(worstAt(-0.2, 2, 0).off, 0.2, 1e-12);
  EXPECT_FALSE(worstAt(-0.2, 2, 0).rubs);
  EXPECT_NEAR(worstAt(0.3, 2, 0).off, 0.3, 1e-12) << "it pushes at a distance";
  EXPECT_TRUE(std::isnan(worstAt(std::nan(""), 2, 0).off));
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
