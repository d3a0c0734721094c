// SPDX-License-Identifier: LGPL-2.1-or-later
// Two bodies and obstacles for tests of what is near, and searches through all of their pairs.
#pragma once
#include <Eigen/Geometry>
#include <set>

#include "components/contact/contact_candidates.h"
#include "framework/mechanics/state_topology.h"
#include "tests/contact/contact_scenes.h"
#include "tests/contact/every_pair.h"

namespace stroma::test {

using contact::Candidates;
using contact::Surfaces;

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

inline std::set<std::pair<int, int>> edgesOf(const std::vector<Candidates::Crossing>& crossings) {
  std::set<std::pair<int, int>> edges;
  for (const auto& crossing : crossings) edges.insert({crossing.edge, crossing.face});
  return edges;
}

/// So many steps from x by wayFrom(x), free all the way and without crossings: nothing more is looked for than what is known.
template <class WayFrom>
void expectNothingIsLookedFor(Candidates& candidates, std::vector<Vec3>& x, int steps, WayFrom&& wayFrom) {
  candidates.findAgain(x, 0.01, 0.1);
  EXPECT_TRUE(candidates.crossings(x).empty());
  const auto known = candidates.work().all();
  EXPECT_GT(known, 0);
  for (int step = 0; step < steps; ++step) {
    const std::vector<Vec3> way = wayFrom(x);
    candidates.stepBegins();
    EXPECT_EQ(candidates.longestStep(x, way, {}), 1);
    for (std::size_t v = 0; v < x.size(); ++v) x[v] += way[v];
    candidates.findAgain(x, 0.01, 0.1);
    EXPECT_TRUE(candidates.crossings(x).empty());
  }
  EXPECT_EQ(candidates.work().all(), known);
}

/// A step as long as every pair lets it be, each asked alone: none is brought nearer than a tenth of its distance. A pair may be left
/// out of it that stays farther apart than a tenth of the reach. Beyond that round-off counts alone: 2e-12 of a size of one, of gaps
/// from a ten-thousandth on. What comes straight on is at a tenth after its first advance, and round-off says whether that ends it.
inline void expectLongestStep(const Surfaces& s, const std::vector<Vec3>& x, const std::vector<Vec3>& way, double reach, double step) {
  constexpr double round_off = 1e-6, another = 0.1;
  const StepsOfAll steps = stepsOfAllPairs(s, x, way, reach);
  EXPECT_GE(step, steps.shorter / (1 + another) * (1 - round_off));
  EXPECT_LE(step, steps.longer * (1 + another) * (1 + round_off));
}

}  // namespace stroma::test
