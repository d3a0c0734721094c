// SPDX-License-Identifier: LGPL-2.1-or-later
// Degenerate cases (Erleben 2018) and drops at random: nothing crosses, everything is a number.
#include <Eigen/Geometry>

#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

Vec3 randomPoint(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  return {uniform(random), uniform(random), uniform(random)};
}
Mat3 randomRotation(std::mt19937& random) {
  return Eigen::Quaterniond(Eigen::Vector4d(randomPoint(random).x(), randomPoint(random).y(), randomPoint(random).z(),
                                            randomPoint(random).x())
                                .normalized())
      .toRotationMatrix();
}

/// A thousand pairs of tetrahedra of any shape fly into each other.
TEST(Drops, OfRandomPairsAreClean) {
  std::mt19937 random(1);
  int met = 0, unconverged = 0, steps = 0;
  for (int pair = 0; pair < 1000; ++pair) {
    Body body;
    for (int side = 0; side < 2; ++side) {
      const int first = int(body.points.size());
      Body one{{randomPoint(random), randomPoint(random), randomPoint(random), randomPoint(random)}, {{0, 1, 2, 3}}};
      const Vec3 a = one.points[0];
      if (std::abs((one.points[1] - a).cross(one.points[2] - a).dot(one.points[3] - a)) < 0.2)
        one = boxOf(Vec3(-.5, -.5, -.5), Vec3(.5, .5, .5));
      one.turn(randomRotation(random), Vec3::Zero());
      one.turn(Mat3::Identity(), Vec3(0.3 * side, 0, side == 0 ? 0 : 3.0 - one.lowest(2)));
      if (side == 0) {
        double high = -1e300;
        for (const Vec3& p : one.points) high = std::max(high, p.z());
        one.turn(Mat3::Identity(), Vec3(0, 0, 2.97 - high));
      }
      for (const Vec3& p : one.points) body.points.push_back(p);
      for (auto c : one.cells) {
        for (int& node : c) node += first;
        body.cells.push_back(c);
      }
    }
    std::string velocity = "velocity=\"";
    for (const Vec3& p : body.points) velocity += p.z() >= 2.99 ? "0 0 -5 " : "0 0 0 ";
    Simulation simulation = simulationFromText(contactScene(
        bodyNode("a", body, "<BarrierContact name=\"contact\" contactDistance=\"0.02\"/>", velocity + "\""), 0.01));
    for (int i = 0; i < 8; ++i) {
      const StepReport report = simulation.step();
      ASSERT_FALSE(report.diverged) << "pair " << pair << " step " << i << ": " << report.reason;
      ASSERT_TRUE(report.constraints_converged) << "pair " << pair << " step " << i << ": " << report.constraint_reason;
      unconverged += !report.newton_converged, ++steps;
    }
    met += outputOf(simulation, "smallestGap") > 0;
  }
  RecordProperty("steps that did not converge", std::to_string(unconverged) + " of " + std::to_string(steps));
  EXPECT_GT(met, 100);
}

struct Case {
  const char* name;
  Body falls, stands;
  double start;  ///< height of what falls above the ground of the other
};

std::vector<Case> cases() {
  std::vector<Case> list;
  const Body cube = boxOf(Vec3(-.5, 0, -.5), Vec3(.5, 1, .5)), cliff = boxOf(Vec3(-.5, -.5, -.5), Vec3(.5, .5, .5));
  Body tipped = wedge(true), across = wedge(true);
  for (Vec3& p : across.points) p = Vec3(p.z(), p.y(), p.x());
  Body pit = boxOf(Vec3(-1, -.5, -1), Vec3(1, .5, 1), {2, 1, 2});
  for (Vec3& p : pit.points)
    if (p.x() == 0 && p.z() == 0 && p.y() > 0) p.y() = 0;
  Body groove = boxOf(Vec3(-1, -.5, -1), Vec3(1, .5, 1), {2, 1, 2});
  for (Vec3& p : groove.points)
    if (p.x() == 0 && p.y() > 0) p.y() = 0;
  Body turned = cube;
  turned.turn(Eigen::AngleAxisd(M_PI / 4, Vec3(1, 0, 1).normalized()).toRotationMatrix(), Vec3::Zero());
  turned.turn(Mat3::Identity(), Vec3(0, -turned.lowest(1), 0));
  list.push_back({"spikes", spike(true), spike(), 6 + 1e-4});
  list.push_back({"spike on wedge", spike(true), wedge(), 6 + 1e-4});
  list.push_back({"wedges across", across, wedge(), 6 + 1e-4});
  list.push_back({"wedges along", tipped, wedge(), 6 + 1e-4});
  list.push_back({"spike in a hole", spike(true), pit, 3 + 1e-4});
  list.push_back({"spike in a crack", spike(true), groove, 3 + 1e-4});
  list.push_back({"wedge in a crack", across, groove, 3.5 + 1e-4});
  list.push_back({"cube on a cliff edge", cube, cliff, 0.5 + 1e-4});
  list.push_back({"cube on inner edges", cube, boxOf(Vec3(-1, -.5, -1), Vec3(1, .5, 1), {4, 1, 4}), 0.5 + 1e-4});
  list.push_back({"corner on a face", turned, boxOf(Vec3(-1, -.5, -1), Vec3(1, .5, 1), {2, 1, 2}), 0.5 + 1e-4});
  return list;
}

TEST(Drops, OfErlebensDegenerateCasesAreClean) {
  for (const Case& each : cases())
    for (const double dt : {0.001, 0.025, 0.1}) {
      SCOPED_TRACE(fmt::format("{}, dt {}", each.name, dt));
      Body falls = each.falls;
      falls.turn(Mat3::Identity(), Vec3(0, each.start, 0));
      std::string ground;
      const double low = each.stands.lowest(1);
      for (std::size_t i = 0; i < each.stands.points.size(); ++i)
        if (each.stands.points[i].y() < low + 1e-9) ground += fmt::format("{} ", i);
      Simulation simulation = simulationFromText(
          contactScene(bodyNode("a", falls, "") +
                           bodyNode("b", each.stands, "<FixedProjectiveConstraint indices=\"" + ground + "\"/>") +
                           fmt::format(fmt::runtime(between), "contactDistance=\"1e-3\""),
                       dt, Vec3(0, -9.81, 0)));
      for (int i = 0; i < 20; ++i) {
        expectCleanStep(simulation, i, false);
        if (HasFatalFailure()) return;
      }
    }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
