// SPDX-License-Identifier: LGPL-2.1-or-later
// Pairs that are found by trees of boxes, against those of a search through all of them.
#include <Eigen/Geometry>
#include <algorithm>
#include <set>
#include <tuple>

#include "components/contact/contact_candidates.h"
#include "framework/collision/exact_intersection.h"
#include "framework/mechanics/state_topology.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using namespace contact;

/// Two boxes with a body's number of cells each, a sphere and a capsule.
struct Scenery {
  Simulation simulation;
  Surfaces surfaces;
  std::vector<Vec3> x;
  std::mt19937 random;

  explicit Scenery(unsigned seed)
      : simulation(simulationFromText(contactScene(bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {3, 2, 2}), "") +
                                                   bodyNode("b", boxOf(Vec3(0, 0, 0), Vec3(0.8, 0.8, 0.8), {2, 3, 2}), "")))),
        random(seed) {
    for (const State* state : simulation.states()) surfaces.addState(*state, topologyOf(*state)->mesh());
    surfaces.addObstacle({Vec3(0.5, 0.5, -0.3)}, {{0, 0, 0}}, 0.25);
    surfaces.addObstacle({Vec3(-0.5, -0.2, 0.5), Vec3(1.5, -0.2, 0.6)}, {{0, 0, 1}}, 0.15);
    surfaces.finish();
    x = surfaces.rest;
    const Mat3 turn = Eigen::AngleAxisd(3 * number(), Vec3(number(), number(), number()).normalized()).toRotationMatrix();
    for (std::size_t v = 0; v < x.size(); ++v) {
      if (surfaces.bodyOf(int(v)) == 1) x[v] = turn * x[v] + Vec3(0.2, 0.2, 1.2 + 0.3 * number());
      if (surfaces.bodyOf(int(v)) < 2) x[v] += 0.02 * Vec3(number(), number(), number());
    }
  }
  double number() { return std::uniform_real_distribution<double>(-1, 1)(random); }
};

using Key = std::tuple<PairKind, int, int>;

/// visit(kind, first, second, its points) of every pair of two sides that share no vertex; obstacles do not meet each other.
template <class Visit>
void forEachPair(const Surfaces& s, Visit&& visit) {
  const auto meet = [&](int a, int b) { return s.moves(a) || s.moves(b); };
  for (std::size_t v = 0; v < s.rows.size(); ++v)
    for (std::size_t f = 0; f < s.faces.size(); ++f) {
      const auto& [a, b, c] = s.faces[f];
      if (meet(int(v), a) && int(v) != a && int(v) != b && int(v) != c)
        visit(PairKind::point_triangle, int(v), int(f), std::array{int(v), a, b, c});
    }
  for (std::size_t e = 0; e < s.edges.size(); ++e)
    for (std::size_t g = e + 1; g < s.edges.size(); ++g) {
      const auto& [a, b] = s.edges[e];
      const auto& [c, d] = s.edges[g];
      if (meet(a, c) && a != c && a != d && b != c && b != d)
        visit(PairKind::edge_edge, int(e), int(g), std::array{a, b, c, d});
    }
}

FourPoints at(const std::array<int, 4>& v, const std::vector<Vec3>& x) {
  return {x[std::size_t(v[0])], x[std::size_t(v[1])], x[std::size_t(v[2])], x[std::size_t(v[3])]};
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
    const auto radiusAt = [&](int vertex) {
      for (std::size_t f = 0; f < scene.surfaces.faces.size(); ++f)
        for (const int v : scene.surfaces.faces[f])
          if (v == vertex) return scene.surfaces.radius[f];
      return 0.0;
    };
    forEachPair(scene.surfaces, [&](PairKind kind, int first, int second, const std::array<int, 4>& v) {
      const double radii = radiusAt(v[0]) + radiusAt(v[3]);
      if (closestPoints(kind, at(v, moved)).distance() - radii >= candidates.reach) return;
      ++met;
      ASSERT_TRUE(found.count({kind, first, second})) << "seed " << seed << ": " << first << ", " << second;
    });
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
    std::set<std::pair<int, int>> expected;
    const Surfaces& s = scene.surfaces;
    for (std::size_t e = 0; e < s.edges.size(); ++e)
      for (std::size_t f = 0; f < s.faces.size(); ++f) {
        const auto& [p, q] = s.edges[e];
        const auto& [a, b, c] = s.faces[f];
        if ((!s.moves(p) && !s.moves(a)) || p == a || p == b || p == c || q == a || q == b || q == c) continue;
        const auto place = [&](int v) { return scene.x[std::size_t(v)]; };
        if (segmentMeetsTriangle(place(p), place(q), place(a), place(b), place(c))) expected.insert({int(e), int(f)});
      }
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
    const double step = candidates.longestStep(scene.x, way, {}, 0);
    shortened += step < 1;
    std::vector<Vec3> there = scene.x;
    for (std::size_t v = 0; v < there.size(); ++v) there[v] += step * way[v];
    if (candidates.crossings(scene.x).empty()) {
      EXPECT_TRUE(candidates.crossings(there).empty()) << seed;
    }
    candidates.find(scene.x, 0.6);  // all of it is covered
    const double known = candidates.longestStep(scene.x, way, {}, 0);
    EXPECT_NEAR(known, step, 0.15 * step) << "seed " << seed << ": pairs end at a tenth of their distance, in any order";
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
    EXPECT_LT(candidates.longestStep(surfaces.rest, way, {}, 0), 0.95) << known;
  }
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
