// SPDX-License-Identifier: LGPL-2.1-or-later
// What is proved of parts that turn and stretch, against searches through all pairs.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "tests/contact/candidate_scenery.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using namespace contact;

/// Everything that is nearer than the reach is listed and may push, if the list is said to hold at x; returns whether it is.
bool expectAllInReach(Candidates& candidates, const Surfaces& s, const std::vector<Vec3>& x) {
  if (!candidates.covers(x)) return false;
  std::map<Key, const Candidate*> listed;
  for (const Candidate& pair : candidates.pairs()) listed[{pair.kind, pair.first, pair.second}] = &pair;
  for (const Key& key : pairsNearerThan(candidates.reach, s, x)) {
    const auto pair = listed.find(key);
    const bool is_listed = pair != listed.end();
    EXPECT_TRUE(is_listed) << std::get<1>(key) << ", " << std::get<2>(key);
    if (!is_listed) return true;
    if (pair->second->pushes)
      EXPECT_TRUE(candidates.mayPush() && candidates.mayPush(*pair->second)) << std::get<1>(key) << ", " << std::get<2>(key);
  }
  return true;
}

/// Bodies of a scenery without obstacles.
Surfaces bodiesOf(const Simulation& simulation) {
  Surfaces surfaces;
  for (const State* state : simulation.states()) surfaces.addState(*state, topologyOf(*state)->mesh());
  surfaces.finish();
  return surfaces;
}

/// The box around the displacements of a whole body is that of each of them, however many there are.
TEST(TurningParts, WholeBodiesHaveTheirBoxes) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> number(-1, 1);
  for (std::size_t count = 1; count < 40; ++count) {
    std::vector<Vec3> from(count + 1), x = from;
    Box expected, alone, box;
    for (std::size_t v = 0; v < count; ++v) {
      from[v] = Vec3(number(random), number(random), number(random)), x[v] = Vec3(number(random), number(random), number(random));
      expected.add(Vec3(x[v] - from[v])), alone.add(x[v]);
    }
    EXPECT_TRUE(boxAround(x.data(), from.data(), count, box));
    EXPECT_EQ(box.low, expected.low);
    EXPECT_EQ(box.high, expected.high);
    EXPECT_TRUE(boxAround(x.data(), nullptr, count, box));
    EXPECT_EQ(box.low, alone.low);
    EXPECT_EQ(box.high, alone.high);
    for (const double none : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      x[count / 2].y() = none;
      EXPECT_FALSE(boxAround(x.data(), from.data(), count, box)) << count;
      EXPECT_FALSE(boxAround(x.data(), nullptr, count, box)) << count;
    }
  }
}

/// What a body has left when it turns as one is of where it was searched last: it is not what it has left at the same place when it
/// has been searched elsewhere since, in another shape.
TEST(TurningParts, WhatTurnsAsOneIsMeasuredAnewAfterASearch) {
  constexpr double flat = 0.06, gap = 0.5 * flat, closing = 0.1;  // it has two layers
  Scenery scene(3);
  const Surfaces surfaces = bodiesOf(scene.simulation);
  Candidates candidates;
  candidates.reach = 0.02;
  candidates.compile(surfaces);
  const Mat3 turn = Eigen::AngleAxisd(1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  std::vector<Vec3> whole = surfaces.rest, pressed = whole, turned = whole, way(whole.size(), Vec3::Zero());
  for (std::size_t v = 0; v < whole.size(); ++v) {
    if (surfaces.bodyOf(int(v)) == 1) whole[v] += Vec3(5, 0, 0);
    pressed[v] = turned[v] = whole[v];
    if (surfaces.bodyOf(int(v)) == 1) continue;
    if (whole[v].z() > 0.9) way[v] = turn * Vec3(0, 0, -closing);
    pressed[v].z() *= flat, turned[v] = turn * pressed[v];
  }
  candidates.findAgain(pressed, 0.004, 0.004);
  EXPECT_TRUE(candidates.covers(turned));
  EXPECT_LT(candidates.longestStep(turned, way, {}), gap / closing);
  candidates.findAgain(whole, 0.1, 0.1);
  const double step = candidates.longestStep(turned, way, {});
  EXPECT_LT(step, gap / closing);
  EXPECT_GT(step, 0);
}

/// Bodies that turn together, round and round, are looked at once.
TEST(TurningParts, TurningTogetherCostsNothing) {
  Scenery scene(3);
  const Surfaces surfaces = bodiesOf(scene.simulation);
  Candidates candidates;
  candidates.reach = 0.02;
  candidates.compile(surfaces);
  std::vector<Vec3> x = surfaces.rest;
  for (std::size_t v = 0; v < x.size(); ++v)
    if (surfaces.bodyOf(int(v)) == 1) x[v] += Vec3(1.3, 0, 0);
  const Mat3 turn = Eigen::AngleAxisd(0.05, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  expectNothingIsLookedFor(candidates, x, 200, [&](const std::vector<Vec3>& from) {
    std::vector<Vec3> way(from.size());
    for (std::size_t v = 0; v < from.size(); ++v) way[v] = turn * from[v] - from[v];
    return way;
  });
}

/// A bar that is bent to and fro by more than a right angle and turned besides. Its ends move by many times what its parts
/// are strained by: few of what would have to be looked at in each step is, and pairs, crossings and steps are right.
TEST(TurningParts, BendingTakesLittle) {
  const Simulation simulation = simulationFromText(contactScene(bodyNode("a", boxOf(Vec3(-2, -.1, -.1), Vec3(2, .1, .1), {32, 2, 2}), "")));
  const Surfaces surfaces = bodiesOf(simulation);
  const auto placesAt = [&](int step) {
    const double bend = 0.6 * std::sin(0.1 * step) + 1e-9;
    const Mat3 turn = Eigen::AngleAxisd(0.03 * step, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    std::vector<Vec3> x = surfaces.rest;
    for (Vec3& p : x) {
      const double angle = bend * p.x();
      p = turn * Vec3(std::sin(angle) * (1 / bend - p.y()), (1 - std::cos(angle)) / bend + std::cos(angle) * p.y(), p.z());
    }
    return x;
  };
  Candidates candidates;
  candidates.reach = 0.02;
  candidates.compile(surfaces);
  candidates.findAgain(placesAt(0), 0.01, 0.03);
  EXPECT_TRUE(candidates.crossings(placesAt(0)).empty());
  const long first = candidates.work().all();
  constexpr int steps = 120;
  for (int step = 0; step < steps; ++step) {
    const std::vector<Vec3> x = placesAt(step), next = placesAt(step + 1);
    std::vector<Vec3> way = next;
    for (std::size_t v = 0; v < x.size(); ++v) way[v] -= x[v];
    candidates.stepBegins();
    ASSERT_EQ(candidates.longestStep(x, way, {}), 1) << step;
    candidates.findAgain(next, 0.01, 0.03);
    ASSERT_TRUE(candidates.crossings(next).empty()) << step;
    if (step % 10 != 0) continue;
    ASSERT_TRUE(expectAllInReach(candidates, surfaces, next)) << step;
    ASSERT_TRUE(allCrossings(surfaces, next).empty()) << step;
  }
  const long queries = candidates.work().all() - first;
  RecordProperty("queries", std::to_string(queries));
  RecordProperty("queries of the first search", std::to_string(first));
  EXPECT_LT(queries, steps * first / 10) << "without what parts do as a whole taken off there are forty times as many as that";
}

/// Turns by any angle, stretches, mirrors and crushes bodies, together or each by itself, and shakes what follows from that.
struct RandomMotion {
  Scenery& scene;
  Mat3 gradients[2];
  Vec3 shifts[2];
  double shake;

  explicit RandomMotion(Scenery& s) : scene(s), shake(std::pow(10, -5 + 3.5 * s.number())) {
    const bool together = s.number() > -0.3;
    for (int body = 0; body < 2; ++body) {
      if (body == 1 && together) {
        gradients[1] = gradients[0], shifts[1] = shifts[0];
        continue;
      }
      const Vec3 axis = Vec3(s.number(), s.number(), s.number()).normalized();
      gradients[body] = Eigen::AngleAxisd(3.2 * s.number(), axis).toRotationMatrix();
      const double strain = std::pow(10, -2 + 2 * s.number());
      for (int k = 0; k < 9; ++k) gradients[body](k / 3, k % 3) += strain * s.number();
      if (s.number() > 0.8) gradients[body] *= Mat3(Vec3(1, 1, -s.number()).asDiagonal());
      shifts[body] = 0.3 * Vec3(s.number(), s.number(), s.number());
    }
  }
  std::vector<Vec3> of(const Surfaces& surfaces, const std::vector<Vec3>& x) const {
    std::vector<Vec3> to = x;
    for (std::size_t v = 0; v < x.size(); ++v)
      if (const int body = surfaces.bodyOf(int(v)); surfaces.moves(int(v)))
        to[v] = gradients[body] * x[v] + shifts[body] + shake * Vec3(scene.number(), scene.number(), scene.number());
    return to;
  }
};

/// Whatever moves how: where a list is said to hold it does, crossings are all those there are, and steps are no longer than every
/// pair lets them be. Of turns by more than a radian many are known without a search.
TEST(TurningParts, NoMotionIsMissed) {
  int known = 0, unknown = 0, crossed = 0, turned = 0, shortened = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Scenery scene(seed);
    const Surfaces bodies = bodiesOf(scene.simulation);
    const Surfaces& s = seed % 3 == 0 ? scene.surfaces : bodies;  // with obstacles
    Candidates candidates;
    candidates.reach = 0.03;
    candidates.compile(s);
    std::vector<Vec3> found = s.rest;
    const Mat3 turn = Eigen::AngleAxisd(3 * scene.number(), Vec3(1, scene.number(), 0).normalized()).toRotationMatrix();
    for (std::size_t v = 0; v < found.size(); ++v) {
      if (s.bodyOf(int(v)) == 1) found[v] = turn * (found[v] - Vec3(0.4, 0.4, 0.4)) + Vec3(0.5, 0.5, 1.9);
      if (s.moves(int(v))) found[v] += 0.02 * Vec3(scene.number(), scene.number(), scene.number());
    }
    candidates.find(found, 0.02);
    EXPECT_TRUE(candidates.crossings(found).empty()) << seed;
    for (int round = 0; round < 20; ++round) {
      const RandomMotion motion(scene);
      std::vector<Vec3> x = motion.of(s, found);
      const bool covers = expectAllInReach(candidates, s, x);
      if (HasFailure()) FAIL() << "seed " << seed << ", round " << round;
      ++(covers ? known : unknown);
      turned += covers && (motion.gradients[0] - Mat3::Identity()).norm() > std::sqrt(2.0);
      const auto expected = allCrossings(s, x);
      ASSERT_EQ(edgesOf(candidates.crossings(x)), expected) << "seed " << seed << ", round " << round;
      crossed += !expected.empty();
      if (expected.empty()) {
        const RandomMotion on(scene);
        std::vector<Vec3> way = on.of(s, x);
        const double part = 0.2 * (1 + scene.number());
        for (std::size_t v = 0; v < x.size(); ++v) way[v] = s.moves(int(v)) ? Vec3(part * (way[v] - x[v])) : Vec3(Vec3::Zero());
        const double step = candidates.longestStep(x, way, {});
        expectLongestStep(s, x, way, candidates.reach, step);
        shortened += step < 1;
      }
      if (round % 7 == 6 && expected.empty()) {
        candidates.stepBegins();
        candidates.findAgain(x, 0.01, 0.1), found = x;
        ASSERT_TRUE(expectAllInReach(candidates, s, x));
      }
    }
  }
  EXPECT_GT(known, 20);
  EXPECT_GT(unknown, 20);
  EXPECT_GT(turned, 10);
  EXPECT_GT(crossed, 20);
  EXPECT_GT(shortened, 20);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
