// SPDX-License-Identifier: LGPL-2.1-or-later
// Pairs that are found by trees of boxes, against those of a search through all of them.
#include <Eigen/Geometry>
#include <algorithm>
#include <set>
#include <stdexcept>

#include "framework/scene/archive.h"
#include "tests/contact/candidate_scenery.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using namespace contact;

/// The ball and the capsule of the scenery are 0.05 from the bodies at rest.
TEST(EveryPair, RadiiAreTakenOff) {
  const Scenery scene(1);
  const Surfaces& s = scene.surfaces;
  const auto ofObstacles = [&](double reach) {
    int count = 0;
    for (const auto& [kind, first, second] : pairsNearerThan(reach, s, s.rest)) {
      const bool edges = kind == PairKind::edge_edge;
      const int one = edges ? s.edges[std::size_t(first)][0] : first;
      const int other = edges ? s.edges[std::size_t(second)][0] : s.faces[std::size_t(second)][0];
      count += !s.moves(one) || !s.moves(other);
    }
    return count;
  };
  EXPECT_EQ(ofObstacles(0.0499), 0);
  EXPECT_GT(ofObstacles(0.0501), 0);
}

/// No pair is missing that comes into reach while vertices move no farther than the margin.
TEST(Candidates, AllThatComeIntoReachAreFound) {
  int met = 0;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    Scenery scene(seed);
    Candidates candidates;
    candidates.reach = 0.05;
    candidates.compile(scene.surfaces);
    const double margin = 0.03;
    candidates.find(scene.x, margin);
    std::set<Key> found;
    for (const Candidate& pair : candidates.pairs()) {
      ASSERT_TRUE(found.insert({pair.kind, pair.first, pair.second}).second) << "a pair that comes twice";
    }
    std::vector<Vec3> moved = scene.x;
    for (std::size_t v = 0; v < moved.size(); ++v)
      if (scene.surfaces.moves(int(v)))
        moved[v] += 0.999 * margin * Vec3(scene.number(), scene.number(), scene.number()).normalized();
    ASSERT_TRUE(candidates.covers(moved));
    for (const Key& pair : pairsNearerThan(candidates.reach, scene.surfaces, moved)) {
      ++met;
      ASSERT_TRUE(found.count(pair)) << "seed " << seed << ": " << std::get<1>(pair) << ", " << std::get<2>(pair);
    }
  }
  EXPECT_GT(met, 1000);
}

/// The same for what crosses, of bodies that lie in one another.
TEST(Candidates, AllCrossingsAreFound) {
  int crossed = 0;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    Scenery scene(seed);
    for (std::size_t v = 0; v < scene.x.size(); ++v)
      if (scene.surfaces.bodyOf(int(v)) == 1) scene.x[v].z() -= 0.5;
    Candidates candidates;
    candidates.reach = 0.05;
    candidates.compile(scene.surfaces);
    const std::set<std::pair<int, int>> expected = allCrossings(scene.surfaces, scene.x);
    for (const bool known : {false, true}) {
      if (known) candidates.find(scene.x, 0.01);
      std::set<std::pair<int, int>> found;
      for (const auto& crossing : candidates.crossings(scene.x)) found.insert({crossing.edge, crossing.face});
      ASSERT_EQ(found, expected) << "seed " << seed;
    }
    crossed += int(expected.size());
  }
  EXPECT_GT(crossed, 300);
}

/// The longest step of all is the shortest of the pairs', whether they are known or have to be looked for.
TEST(Candidates, TheLongestStepIsThatOfEveryPair) {
  int shortened = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Scenery scene(seed);
    Candidates candidates;
    candidates.reach = 0.05;
    candidates.compile(scene.surfaces);
    std::vector<Vec3> way(scene.x.size(), Vec3::Zero());
    for (std::size_t v = 0; v < way.size(); ++v)
      if (scene.surfaces.bodyOf(int(v)) == 1)
        way[v] = Vec3(0, 0, -0.4) + 0.05 * Vec3(scene.number(), scene.number(), scene.number());
    const double step = candidates.longestStep(scene.x, way, {});
    shortened += step < 1;
    std::vector<Vec3> there = scene.x;
    for (std::size_t v = 0; v < there.size(); ++v) there[v] += step * way[v];
    if (candidates.crossings(scene.x).empty()) {
      EXPECT_TRUE(candidates.crossings(there).empty()) << seed;
    }
    expectLongestStep(scene.surfaces, scene.x, way, candidates.reach, step);
    candidates.find(scene.x, 0.6);  // all of it is covered
    expectLongestStep(scene.surfaces, scene.x, way, candidates.reach, candidates.longestStep(scene.x, way, {}));
  }
  EXPECT_GT(shortened, 10);
}

/// What comes to an end just before it touches is cut as well, whether pairs are known or have to be looked for.
TEST(Candidates, AStepLeavesAGap) {
  Scenery scene(1);
  Surfaces surfaces;
  surfaces.addState(*scene.simulation.states()[0], topologyOf(*scene.simulation.states()[0])->mesh());
  surfaces.addObstacle({Vec3(-1, -1, 1.5), Vec3(2, -1, 1.5), Vec3(0.5, 3, 1.5)}, {{0, 1, 2}}, 0);
  surfaces.finish();
  Candidates candidates;
  candidates.reach = 0.05;
  candidates.compile(surfaces);
  std::vector<Vec3> way(surfaces.rows.size(), Vec3::Zero());
  for (std::size_t v = 0; v < way.size(); ++v)
    if (surfaces.moves(int(v))) way[v] = Vec3(0, 0, 0.5 - 1e-9);
  for (const bool known : {false, true}) {
    if (known) candidates.find(surfaces.rest, 0.6);
    EXPECT_LT(candidates.longestStep(surfaces.rest, way, {}), 0.95) << known;
  }
}

/// Bodies that turn, swell and drift into one another over many steps, with pairs looked for only where motion has used up what was
/// known: pairs, crossings and the longest step are those of a search through everything, each time.
TEST(Candidates, WhatMotionProvesIsTrue) {
  int met = 0, crossed = 0;
  long tests = 0, everything = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Scenery scene(seed);
    const Surfaces& s = scene.surfaces;
    Candidates candidates;
    candidates.reach = 0.05;
    candidates.compile(s);
    const std::vector<Vec3> begin = scene.x;
    const Vec3 drift(0.02 * scene.number(), 0.02 * scene.number(), -0.02), axis = Vec3(scene.number(), 1, 0).normalized();
    for (int step = 0; step < 40; ++step) {
      std::vector<Vec3> x = begin;
      const Mat3 turn = Eigen::AngleAxisd(0.005 * step, axis).toRotationMatrix();
      for (std::size_t v = 0; v < x.size(); ++v)
        if (s.moves(int(v))) x[v] = (1 + 0.05 * std::sin(0.4 * step)) * (turn * x[v]) + (s.bodyOf(int(v)) == 1 ? step : 0) * drift;
      candidates.stepBegins();
      const long before = candidates.work().tests;
      candidates.findAgain(x, 0.01, 0.3);
      std::set<Key> found;
      for (const Candidate& pair : candidates.pairs()) {
        ASSERT_TRUE(found.insert({pair.kind, pair.first, pair.second}).second) << "a pair that comes twice";
      }
      for (const Key& pair : pairsNearerThan(candidates.reach, s, x)) {
        ++met;
        ASSERT_TRUE(found.count(pair)) << "seed " << seed << ", step " << step;
      }
      Candidates anew;
      anew.reach = candidates.reach;
      anew.compile(s);
      const auto expected = edgesOf(anew.crossings(x));
      everything += anew.work().tests;
      ASSERT_EQ(edgesOf(candidates.crossings(x)), expected) << "seed " << seed << ", step " << step;
      crossed += !expected.empty();
      tests += candidates.work().tests - before;
      if (!expected.empty()) continue;
      std::vector<Vec3> way(x.size(), Vec3::Zero()), there = x;
      for (std::size_t v = 0; v < way.size(); ++v)
        if (s.moves(int(v))) way[v] = 0.15 * Vec3(scene.number(), scene.number(), scene.number());
      const double known = candidates.longestStep(x, way, {});
      for (std::size_t v = 0; v < way.size(); ++v) there[v] += known * way[v];
      ASSERT_TRUE(anew.crossings(there).empty()) << "seed " << seed << ", step " << step;
      if (step % 4 == 0) expectLongestStep(s, x, way, candidates.reach, known);
    }
  }
  EXPECT_GT(met, 1000);
  EXPECT_GT(crossed, 20);
  EXPECT_LT(tests, everything / 2) << "most parts are known not to cross";
}

/// The end of a column that is put into a slab, past the limits of steps: its walls cross the slab, and nothing of the end itself does.
/// The proof of each two parts has to know of corners that belong to others.
TEST(Candidates, WhatIsPutIntoAnotherBodyIsFound) {
  for (const double height : {1.0, 2.0, 4.0}) {
    const Body column = boxOf(Vec3(0.1, 0.1, 0.008), Vec3(1.1, 1.1, height), {4, 4, 2});
    const Simulation simulation = simulationFromText(contactScene(bodyNode("a", column, "")));
    Surfaces surfaces;
    Mesh skin;  // its end first, which then owns the rim
    skin.triangles = topologyOf(*simulation.states()[0])->mesh().boundaryTriangles();
    const auto top = [&](const Triangle& face) {
      double z = 0;
      for (const Index v : face) z = std::max(z, column.points[std::size_t(v)].z());
      return z;
    };
    std::stable_sort(skin.triangles.begin(), skin.triangles.end(),
                     [&](const Triangle& a, const Triangle& b) { return top(a) < top(b); });
    surfaces.addState(*simulation.states()[0], skin);
    std::vector<Vec3> corners;
    for (int k = 0; k < 8; ++k) corners.emplace_back(k & 1 ? 3 : -2, k & 2 ? 3 : -2, k & 4 ? 0 : -1);
    surfaces.addObstacle(corners, {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}}, 0);
    surfaces.finish();
    Candidates known, anew;
    for (Candidates* each : {&known, &anew}) each->reach = 0.01, each->compile(surfaces);
    for (const double depth : {0.009, 0.012, 0.015, 0.02, 0.1}) {
      known.find(surfaces.rest, 0.005);
      ASSERT_TRUE(known.crossings(surfaces.rest).empty());
      std::vector<Vec3> x = surfaces.rest;
      for (std::size_t v = 0; v < x.size(); ++v)
        if (surfaces.moves(int(v)) && x[v].z() < 0.01) x[v].z() -= depth;
      const auto expected = edgesOf(anew.crossings(x));
      EXPECT_FALSE(expected.empty());
      EXPECT_EQ(edgesOf(known.crossings(x)), expected) << "height " << height << ", depth " << depth;
      known.findAgain(x, 0.005, 0.1);
      EXPECT_EQ(edgesOf(known.crossings(x)), expected) << "height " << height << ", depth " << depth;
    }
  }
}

/// What moves along together, or stays far from each other, is looked at once.
TEST(Candidates, MotionAlongTogetherCostsNothing) {
  Scenery scene(3);
  Surfaces surfaces;
  for (const State* state : scene.simulation.states()) surfaces.addState(*state, topologyOf(*state)->mesh());
  surfaces.addObstacle({Vec3(0, 0, -40)}, {{0, 0, 0}}, 0.5);
  surfaces.finish();
  Candidates candidates;
  candidates.reach = 0.02;
  candidates.compile(surfaces);
  std::vector<Vec3> x = surfaces.rest;
  for (std::size_t v = 0; v < x.size(); ++v)
    if (surfaces.bodyOf(int(v)) == 1) x[v] += Vec3(3, 0, 0);
  std::vector<Vec3> way(x.size(), Vec3::Zero());
  for (std::size_t v = 0; v < x.size(); ++v)
    if (surfaces.moves(int(v))) way[v] = Vec3(0.1, 0.2, -0.3) + 1e-5 * Vec3(scene.number(), scene.number(), scene.number());
  expectNothingIsLookedFor(candidates, x, 100, [&](const std::vector<Vec3>&) { return way; });
}

/// Two blocks that swing on their stands, well apart, each of them with itself: in a hundred steps contact looks at next to nothing
/// after the first. Without the proofs of motion each step makes hundreds of queries.
TEST(Candidates, WhereNothingTouchesNothingIsLookedFor) {
  const Body low = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {3, 3, 3}), high = boxOf(Vec3(0, 0, 3), Vec3(1, 1, 4), {3, 3, 3});
  std::string base;
  for (int i = 0; i < 16; ++i) base += fmt::format("{} ", i);
  const std::string held = "<FixedProjectiveConstraint indices=\"" + base + "\"/>";
  Simulation simulation = simulationFromText(
      contactScene(bodyNode("a", low, held) + bodyNode("b", high, held) +
                       fmt::format(fmt::runtime(between), "contactDistance=\"0.02\""),
                   0.01, Vec3(3, 0, -9.81)));
  expectCleanStep(simulation, 0);
  const double first = outputOf(simulation, "queries");
  double moved = 0;
  const System& system = *simulation.systems()[0];
  const Vec3 start = system.x[60];
  for (int i = 1; i < 100; ++i) {
    expectCleanStep(simulation, i);
    moved = std::max(moved, (Vec3(system.x[60]) - start).norm());
  }
  EXPECT_GT(moved, 0.005) << "they do swing";
  EXPECT_GT(first, 0);
  EXPECT_LE(outputOf(simulation, "queries"), first + 100);
}

/// What goes on from a checkpoint knows the same and needs the same; numbers of another scene are refused.
TEST(Candidates, GoOnFromACheckpoint) {
  Scenery scene(2);
  Candidates ours, theirs;
  for (Candidates* each : {&ours, &theirs}) each->reach = 0.05, each->compile(scene.surfaces);
  const auto step = [&](Candidates& candidates, int number) {
    std::vector<Vec3> x = scene.x;
    for (std::size_t v = 0; v < x.size(); ++v)
      if (scene.surfaces.bodyOf(int(v)) == 1) x[v] += number * Vec3(0.004, 0.002, -0.01);
    candidates.stepBegins();
    candidates.findAgain(x, 0.01, 0.1);
    return candidates.crossings(x).size();
  };
  for (int i = 0; i < 7; ++i) step(ours, i);
  Archive written;
  written.enter("it");
  ours.serialize(written);
  Archive read = written.readable();
  read.enter("it");
  theirs.serialize(read);
  const auto keysOf = [](const Candidates& candidates) {
    std::vector<std::tuple<PairKind, int, int, double, bool>> keys;
    for (const Candidate& pair : candidates.pairs()) keys.emplace_back(pair.kind, pair.first, pair.second, pair.distance, pair.pushes);
    return keys;
  };
  EXPECT_FALSE(keysOf(ours).empty());
  EXPECT_FALSE(ours.patternPairs().empty());
  for (int i = 7; i < 20; ++i) {
    ASSERT_EQ(keysOf(theirs), keysOf(ours)) << i;
    ASSERT_EQ(theirs.work().all(), ours.work().all()) << i;
    ASSERT_EQ(theirs.patternPairs(), ours.patternPairs()) << i;
    ASSERT_EQ(step(theirs, i), step(ours, i)) << i;
  }
  auto entries = written.entries();
  for (auto& [name, entry] : entries)
    if (name == "it:pairs") std::fill(entry.bytes.begin(), entry.bytes.begin() + 64, '\x7f');
  Archive other(entries);
  other.enter("it");
  EXPECT_THROW(theirs.serialize(other), std::runtime_error);
}

/// Who asks between steps, and before the first one, changes no bit.
TEST(Candidates, AskingChangesNothing) {
  const auto run = [](bool asks) {
    std::string velocity;
    for (int i = 0; i < 36; ++i) velocity += "0.3 0.2 -1.5 ";
    Body high = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {2, 2, 3});
    high.turn(Eigen::AngleAxisd(0.4, Vec3(1, 2, 0.5).normalized()).toRotationMatrix(), Vec3(0.1, 0.2, 0));
    high.turn(Mat3::Identity(), Vec3(0, 0, 1.1 - high.lowest(2)));
    Simulation simulation = simulationFromText(contactScene(
        bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {3, 3, 3}), "<FixedProjectiveConstraint indices=\"0 1 2 3\"/>", "", 1e5) +
            bodyNode("b", high, "", "velocity=\"" + velocity + "\"", 1e5) +
            fmt::format(fmt::runtime(between), "contactDistance=\"0.02\" friction=\"0.2\""),
        0.01, Vec3(0, 0, -9.81)));
    System& system = *simulation.systems()[0];
    double asked = 0;
    const auto ask = [&] {
      if (!asks) return;
      for (ForceField* field : system.forceFields())
        if (field->type() == "BarrierContact") asked += field->energy(system.x) + outputOf(simulation, "smallestGap");
    };
    ask();
    std::vector<double> all;
    for (int i = 0; i < 25; ++i) {
      expectCleanStep(simulation, i, false);
      ask();
      for (Index row = 0; row < system.x.count(); ++row)
        for (int k = 0; k < 3; ++k) all.push_back(system.x[row][k]);
      all.push_back(outputOf(simulation, "queries"));
    }
    EXPECT_EQ(asked > 0, asks) << "they have met";
    return all;
  };
  EXPECT_EQ(run(true), run(false));
}

/// A body that swings over another one: whatever pushes has a place in the pattern, others come to push far more often than the pattern
/// changes, and it does not become more than twice as large as it has to be.
TEST(Candidates, PatternsLast) {
  int others = 0, renewed = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Scenery scene(seed);
    Candidates candidates;
    candidates.reach = 0.05;
    candidates.compile(scene.surfaces);
    std::set<Key> before, places;
    for (int step = 0; step < 60; ++step) {
      std::vector<Vec3> x = scene.x;
      const double way = std::sin(0.5 * step);
      for (std::size_t v = 0; v < x.size(); ++v)
        if (scene.surfaces.bodyOf(int(v)) == 1) x[v] += Vec3(0.06 * way, 0.04 * way, 0.01 * scene.number());
      candidates.stepBegins();
      const bool is_new = candidates.findAgain(x, 0.01, 0.02);
      std::set<Key> pushing, kept;
      for (const Candidate& pair : candidates.pairs())
        if (pair.pushes) pushing.insert({pair.kind, pair.first, pair.second});
      for (const PairName& pair : candidates.patternPairs()) kept.insert({pair.kind, pair.first, pair.second});
      ASSERT_TRUE(std::includes(kept.begin(), kept.end(), pushing.begin(), pushing.end())) << "seed " << seed << ", step " << step;
      ASSERT_LE(kept.size(), 2 * pushing.size());
      ASSERT_TRUE(is_new || kept == places) << "what has another pattern says so";
      renewed += is_new, others += pushing != before;
      before = pushing, places = kept;
    }
  }
  RecordProperty("renewed", std::to_string(renewed) + " of " + std::to_string(others));
  EXPECT_GT(others, 60);
  EXPECT_LT(renewed, others / 2);
}

/// A matrix keeps its pattern as long as the same pairs may push, however often they are looked for.
TEST(Candidates, ThePatternIsThatOfPairsThatPush) {
  std::string velocity;
  for (int i = 0; i < 8; ++i) velocity += "0 0 -1 ";
  Simulation simulation = simulationFromText(contactScene(
      bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)), "") +
      bodyNode("b", boxOf(Vec3(0, 0, 1.5), Vec3(1, 1, 2.5)), "", "velocity=\"" + velocity + "\"") +
      fmt::format(fmt::runtime(between), "contactDistance=\"0.02\"")));
  const ForceField* field = nullptr;
  for (const ForceField* each : simulation.systems()[0]->forceFields())
    if (each->type() == "BarrierContact") field = each;
  ASSERT_TRUE(field);
  expectCleanStep(simulation, 0);
  const long before = field->patternRevision();
  for (int i = 1; i < 40; ++i) expectCleanStep(simulation, i);
  EXPECT_EQ(field->patternRevision(), before) << "nothing was near";
  for (int i = 40; i < 60; ++i) expectCleanStep(simulation, i, false);
  EXPECT_GT(field->patternRevision(), before) << "they have met";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
