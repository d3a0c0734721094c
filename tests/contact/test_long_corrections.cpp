// SPDX-License-Identifier: LGPL-2.1-or-later
// The longest step of a correction that is far longer than the bodies, as a matrix that is nearly singular gives: swept over all of
// it, every pair is near every other.
#include "tests/contact/candidate_scenery.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using namespace contact;

/// How many pairs are asked for the step, with and without pairs that are known, and how many there are.
struct Asked {
  long known = 0, searched = 0, all = 0;
};

std::vector<Vec3> wayOf(Scenery& scene, double length) {
  std::vector<Vec3> way(scene.x.size(), Vec3::Zero());
  for (std::size_t v = 0; v < way.size(); ++v)
    if (scene.surfaces.moves(int(v))) way[v] = length * Vec3(scene.number(), scene.number(), scene.number());
  return way;
}

std::vector<Vec3> movedBy(const Scenery& scene, double step, const std::vector<Vec3>& way) {
  std::vector<Vec3> there = scene.x;
  for (std::size_t v = 0; v < there.size(); ++v) there[v] += step * way[v];
  return there;
}

long asked(Candidates& candidates, const Scenery& scene, const std::vector<Vec3>& way, double& step) {
  const long before = candidates.work().ways;
  step = candidates.longestStep(scene.x, way, {});
  return candidates.work().ways - before;
}

Asked askedOf(Scenery& scene, double length) {
  Candidates anew, knowing;
  for (Candidates* each : {&anew, &knowing}) each->reach = 0.05, each->compile(scene.surfaces);
  knowing.find(scene.x, 0.02);
  const std::vector<Vec3> way = wayOf(scene, length);
  double step = 0, step_anew = 0;
  Asked count;
  count.known = asked(knowing, scene, way, step);
  count.searched = asked(anew, scene, way, step_anew);
  count.all = long(pairsNearerThan(1e3, scene.surfaces, scene.x).size());
  EXPECT_TRUE(anew.crossings(scene.x).empty());
  for (const double each : {step, step_anew}) {
    expectLongestStep(scene.surfaces, scene.x, way, knowing.reach, each);
    EXPECT_TRUE(knowing.crossings(movedBy(scene, each, way)).empty());
  }
  EXPECT_NEAR(step_anew, step, 0.25 * step) << "what a search may leave out is farther apart than a tenth of the reach";
  EXPECT_LT(step, 1 / length);
  return count;
}

/// As far as every pair, each asked alone, lets it go, and few of them are asked for that.
TEST(LongCorrections, FewPairsAreAsked) {
  for (const double length : {3.0, 30.0, 300.0}) {
    Asked sum;
    for (unsigned seed = 1; seed <= 12; ++seed) {
      Scenery scene(seed);
      for (std::size_t v = 0; v < scene.x.size(); ++v)
        if (scene.surfaces.bodyOf(int(v)) == 1)  // above the other, smooth
          scene.x[v] = scene.surfaces.rest[v] + Vec3(0.2, 0.1, 1.06 + 0.02 * scene.number());
      const Asked one = askedOf(scene, length);
      sum.known += one.known, sum.searched += one.searched, sum.all += one.all;
    }
    EXPECT_GT(sum.all, 100000);
    EXPECT_LT(sum.known, 0.1 * double(sum.all)) << length;
    EXPECT_LT(sum.searched, 0.15 * double(sum.all)) << length;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
