// SPDX-License-Identifier: LGPL-2.1-or-later
// A thick half-sphere is pressed into a softer block and turned about its axis, with friction (Sauer and De Lorenzis 2015): a
// contact that sticks first and slips from its rim inwards.
#include "framework/simulation/simulation.h"
#include "tests/contact/published_meshes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double range = 0.02, per_step = 4 * M_PI / 180;
constexpr int pressing = 10, turning = 10;

/// Nodes of the upper side go down by 1, with the gap at which the sphere rests, and then around the z axis.
std::string handOf(const HexahedralMesh& mesh, double top) {
  constexpr double depth = 1 + 0.65 * range;
  std::string hand;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3& p = mesh.points[i];
    if (p.z() < top - 1e-9) continue;
    std::string times = fmt::format("0 {}", pressing), movements = fmt::format("0 0 0  0 0 {}", -depth);
    for (int k = 1; k <= turning; ++k) {
      const double c = std::cos(k * per_step), s = std::sin(k * per_step);
      times += fmt::format(" {}", pressing + k);
      movements += fmt::format("  {} {} {}", c * p.x() - s * p.y() - p.x(), s * p.x() + c * p.y() - p.y(), -depth);
    }
    hand += fmt::format(
        "<LinearMovementProjectiveConstraint outside=\"hold\" indices=\"{}\" keyTimes=\"{}\" movements=\"{}\"/>", i, times, movements);
  }
  return hand;
}

/// A block of 2 x 2 x 2 with E = 1 and a half-sphere with radii 2/3 and 1 and E = 5, nu = 0.3. The radii are those of the mesh that
/// solids4foam has published with its results. It is pressed without friction, and turned with mu = 0.5.
std::string twistScene(double mu) {
  const std::vector<double> across = evenly(-1, 1, 6);
  const HexahedralMesh block = brickOf(across, across, evenly(0, 2, 6));
  HexahedralMesh sphere = halfOfSphere(2.0 / 3, 1, 6, 2);
  for (Vec3& p : sphere.points) p.z() += 3 + range;
  const std::string bottom = block.where([](const Vec3& p) { return p.z() < 1e-9; });
  return contactScene(
      neoHookeanNode("block", block, 1, 0.3, fmt::format("<FixedProjectiveConstraint indices=\"{}\"/>", bottom)) +
          neoHookeanNode("sphere", sphere, 5, 0.3, handOf(sphere, 3 + range)) +
          fmt::format("<BarrierContact name=\"contact\" mstate=\"@sphere/dofs\" topology=\"@sphere/mesh\" other=\"@block/dofs\" "
                      "contactDistance=\"{}\" friction=\"{}\" slipVelocity=\"1e-3\" frictionIterations=\"20\" selfContact=\"0\"/>",
                      range, mu),
      1, Vec3::Zero(), "<StaticSolver relative_residual_tolerance_threshold=\"1e-4\"/>");
}

/// Cells of a third are too stiff: the force is 4 % above that of Sauer and De Lorenzis, 1.230 at the start and 1.245 after 40
/// degrees. Finer ones come to 1 % (docs/contact.md). With a wall of a half instead of a third it would be 13 % above.
TEST(PublishedBenchmarks, HemisphereTwisted) {
  Simulation pressed = simulationFromText(twistScene(0)), simulation = simulationFromText(twistScene(0.5));
  for (int step = 1; step <= pressing; ++step) {
    expectCleanStep(pressed, step);
    if (HasFatalFailure()) return;
  }
  const double force = wrenchesOf(pressed, "contact")[2];
  simulation.restore(pressed.checkpoint());
  std::vector<double> torques;  // after 20 and 40 degrees
  for (int step = 1; step <= turning; ++step) {
    expectCleanStep(simulation, pressing + step);
    if (HasFatalFailure()) return;
    if (step == 5 || step == 10) torques.push_back(-wrenchesOf(simulation, "contact")[5]);
  }
  const double turned = wrenchesOf(simulation, "contact")[2];
  RecordProperty("force at 0 and 40 degrees", fmt::format("{:.4f} {:.4f}", force, turned));
  RecordProperty("torque at 20 and 40 degrees", fmt::format("{:.4f} {:.4f}", torques[0], torques[1]));
  expectWithin(force, 1.230, 1.045 * 1.230, "pressed");
  expectWithin(turned, 1.245, 1.045 * 1.245, "turned by 40 degrees");
  // Sauer and De Lorenzis 2015, and FEBio (Zimmerman and Ateshian 2018), with the 1 % that 432 cells are off
  expectWithin(torques[0], 0.99 * 0.144, 1.01 * 0.146, "20 degrees");
  expectWithin(torques[1], 0.99 * 0.267, 1.01 * 0.273, "40 degrees");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
