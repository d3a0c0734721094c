// SPDX-License-Identifier: LGPL-2.1-or-later
// A thick half-sphere is pressed into a softer block and turned about its axis, with friction (Sauer and De Lorenzis 2015): a
// contact that sticks first and slips from its rim inwards.
#include <map>

#include "framework/simulation/simulation.h"
#include "tests/contact/published_meshes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double range = 0.02;
constexpr int pressing = 10;
/// Angles at the ends of steps [degrees]: short ones while the contact sticks.
std::vector<double> angles() {
  std::vector<double> list;
  for (double angle = 4; angle <= 80; angle += 4) list.push_back(angle);
  for (double angle = 90; angle <= 180; angle += 10) list.push_back(angle);
  return list;
}

/// Nodes of the upper side go down by 1, and by what closes of the gap: half of it, as the mean pressure is about that of kappa. Then they
/// go around the z axis.
std::string handOf(const HexahedralMesh& mesh, double top) {
  constexpr double depth = 1 + 0.5 * range;
  const std::vector<double> turned = angles();
  std::string hand;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3& p = mesh.points[i];
    if (p.z() < top - 1e-9) continue;
    std::string times = fmt::format("0 {}", pressing), movements = fmt::format("0 0 0  0 0 {}", -depth);
    for (std::size_t k = 0; k < turned.size(); ++k) {
      const double c = std::cos(turned[k] * M_PI / 180), s = std::sin(turned[k] * M_PI / 180);
      times += fmt::format(" {}", pressing + 1 + int(k));
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

/// Cells of a third are too stiff: forces are 3 % above those of Sauer and De Lorenzis, and once contact slides the torque varies by some
/// per cent where nodes pass each other. docs/contact.md has the refinement. With a wall of a half instead of a third the force would be
/// 13 % above.
TEST(PublishedBenchmarks, HemisphereTwisted) {
  Simulation pressed = simulationFromText(twistScene(0)), simulation = simulationFromText(twistScene(0.5));
  for (int step = 1; step <= pressing; ++step) {
    expectCleanStep(pressed, step);
    if (HasFatalFailure()) return;
  }
  std::map<double, std::array<double, 2>> at{{0, {wrenchesOf(pressed, "contact")[2], 0}}};  // force and torque by the angle
  simulation.restore(pressed.checkpoint());
  for (const double angle : angles()) {
    SCOPED_TRACE(angle);
    expectCleanStep(simulation, int(angle));
    if (HasFatalFailure()) return;
    const std::vector<double> wrench = wrenchesOf(simulation, "contact");
    at[angle] = {wrench[2], -wrench[5]};
  }
  for (const double angle : {0, 20, 40, 80, 120, 180})
    RecordProperty(fmt::format("at_{}", angle), fmt::format("force {:.4f}, torque {:.4f}", at[angle][0], at[angle][1]));
  // force: Sauer and De Lorenzis 2015
  for (const auto& [angle, force] : {std::pair(0, 1.230), {40, 1.245}, {80, 1.273}, {120, 1.282}, {180, 1.289}})
    expectWithin(at[angle][0], force, 1.04 * force, fmt::format("force at {} degrees", angle));
  // torque: theirs, and FEBio's (Zimmerman and Ateshian 2018)
  expectWithin(at[20][1], 0.98 * 0.144, 0.146, "20 degrees");
  expectWithin(at[40][1], 0.267, 0.273, "40 degrees");
  for (const auto& [angle, least, most] : {std::tuple(80, 0.395, 0.395), {120, 0.403, 0.410}, {180, 0.401, 0.405}})
    expectWithin(at[angle][1], 0.95 * least, 1.05 * most, fmt::format("torque at {} degrees", angle));
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
