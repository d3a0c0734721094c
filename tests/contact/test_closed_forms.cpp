// SPDX-License-Identifier: LGPL-2.1-or-later
// Contact against closed forms: Hertz's sphere on a layer, the way in which friction stops a block.
#include <cmath>
#include <sstream>

#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::vector<double> numbersOf(Simulation& simulation, const char* name) {
  std::vector<double> values;
  for (const auto& system : simulation.systems())
    for (ForceField* field : system->forceFields())
      if (field->type() == "BarrierContact") {
        std::istringstream text(field->data().find(name)->print());
        for (double value = 0; text >> value;) values.push_back(value);
      }
  return values;
}

/// From 0 in `even` cells of size h, then each larger than the one before, up to about `end`.
std::vector<double> graded(double h, int even, double growth, double end) {
  std::vector<double> x{0};
  for (int i = 0; i < even; ++i) x.push_back(x.back() + h);
  while (x.back() < end) {
    h *= growth;
    const double next = x.back() + h;
    x.push_back(next > 0.85 * end ? end : next);
  }
  return x;
}

/// A rigid sphere of radius R pressed into a layer by D, a quarter of both; the force on it.
double forceOfSphere(double h, double growth) {
  constexpr double radius = 0.01, depth = 2e-4, height = 0.01414, range = 3e-5;
  const std::vector<double> x = graded(h, int(std::lround(0.0021 / h)), growth, 0.016),
                            z = graded(h, int(std::lround(0.0015 / h)), growth, height);
  const int n = int(x.size()), m = int(z.size());
  std::string positions, cells, left, front, bottom;
  const auto node = [&](int i, int j, int k) { return i + n * (j + n * k); };
  for (int k = 0; k < m; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        positions += fmt::format("{} {} {}  ", x[std::size_t(i)], x[std::size_t(j)], z[std::size_t(m - 1 - k)] * -1);
        if (i == 0) left += fmt::format("{} ", node(i, j, k));
        if (j == 0) front += fmt::format("{} ", node(i, j, k));
        if (k == 0) bottom += fmt::format("{} ", node(i, j, k));
        if (i + 1 < n && j + 1 < n && k + 1 < m)
          cells += fmt::format("{} {} {} {} {} {} {} {}  ", node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k),
                               node(i, j + 1, k), node(i, j, k + 1), node(i + 1, j, k + 1), node(i + 1, j + 1, k + 1),
                               node(i, j + 1, k + 1));
      }
  const double start = radius + 1.01 * range, end = radius - depth + 0.95 * range;
  Simulation simulation = simulationFromText(contactScene(
      fmt::format("<MeshTopology name=\"mesh\" position=\"{}\" hexahedra=\"{}\"/><MechanicalObject name=\"dofs\"/>"
                  "<UniformMass totalMass=\"1\"/><HexahedronFEMForceField youngModulus=\"1e4\" poissonRatio=\"0.3\"/>"
                  "<PartialFixedProjectiveConstraint indices=\"{}\" fixedDirections=\"1 0 0\"/>"
                  "<PartialFixedProjectiveConstraint indices=\"{}\" fixedDirections=\"0 1 0\"/>"
                  "<FixedProjectiveConstraint indices=\"{}\"/>"
                  "<BarrierContact contactDistance=\"{}\" stiffness=\"1e5\" selfContact=\"0\" spheres=\"0 0 {} {}\" "
                  "keyTimes=\"0 1\" movements=\"0 0 0  0 0 {}\"/>",
                  positions, cells, left, front, bottom, range, start, radius, end - start),
      1, Vec3::Zero(), "<StaticSolver relative_residual_tolerance_threshold=\"1e-6\"/>"));
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.newton_converged) << report.reason;
  EXPECT_TRUE(report.constraints_converged) << report.constraint_reason;
  return -4 * numbersOf(simulation, "wrenches")[2];
}

/// Hertz, with the factor of a bonded layer (Dimitriadis, Horkay, Maresca, Kachar and Chadwick 2002), sqrt(R D)/H = 0.1.
TEST(ClosedForms, HertzsSphereOnALayer) {
  constexpr double young = 1e4, nu = 0.3, radius = 0.01, depth = 2e-4, height = 0.01414;
  const double hertz = 4. / 3 * young / (1 - nu * nu) * std::sqrt(radius) * std::pow(depth, 1.5);
  const double a = -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1 - nu), chi = std::sqrt(radius * depth) / height;
  const double expected = hertz * (1 - 2 * a / M_PI * chi + 4 * a * a / (M_PI * M_PI) * chi * chi);
  const double coarse = forceOfSphere(6e-4, 1.8) / expected - 1, fine = forceOfSphere(3e-4, 1.6) / expected - 1;
  RecordProperty("error of the force, coarse", std::to_string(coarse));
  RecordProperty("error of the force, fine", std::to_string(fine));
  EXPECT_LT(std::abs(coarse), 0.01);
  EXPECT_LT(std::abs(fine), 0.01);
}

/// v^2 / (2 mu g) in v / (mu g), of a rigid block that is let go at the gap of its weight.
TEST(ClosedForms, FrictionStopsABlock) {
  const Body box = boxOf(Vec3(-.5, -.5, -.1), Vec3(.5, .5, .1));
  const double dt = 1e-3, mass = 100, range = 0.01, kappa = 100 * mass * 9.81;
  Simulation simulation = simulationFromText(contactScene(
      fmt::format("<Node name=\"tool\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"0 0 {}  0 0 0 1\" "
                  "velocity=\"1 0 0  0 0 0\"/><UniformMass totalMass=\"{}\" inertia=\"10 10 10\"/><Node name=\"skin\">{}"
                  "<MechanicalObject name=\"dofs\"/><RigidMapping/></Node></Node>"
                  "<BarrierContact mstate=\"@tool/skin/dofs\" planes=\"0 0 1 0\" contactDistance=\"{}\" stiffness=\"{}\" "
                  "friction=\"0.5\" frictionIterations=\"50\"/>",
                  0.1 + 0.9434 * range, mass, box.mesh(), range, kappa),
      dt, Vec3(0, 0, -9.81)));
  const State& frame = *simulation.states()[0];
  double stopped = 0;
  for (int i = 1; i <= 240; ++i) {
    expectCleanStep(simulation, i, false);
    if (HasFatalFailure()) return;
    if (stopped == 0 && frame.v()[0].x() < 1e-3) stopped = i * dt;
  }
  EXPECT_NEAR(frame.x()[0].x(), 0.101937, 0.01 * 0.101937);
  EXPECT_NEAR(stopped, 0.203874, 2 * dt);
  EXPECT_NEAR(numbersOf(simulation, "wrenches")[2], mass * 9.81, 0.01 * mass * 9.81);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
