// SPDX-License-Identifier: LGPL-2.1-or-later
// Contact against closed forms: Hertz's sphere and a flat punch on a layer, the way in which friction stops a block.
#include <cmath>

#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A quarter of a layer on a rigid ground, with cells of size h near the middle of its upper side, which is at z = 0. SI units.
struct Layer {
  double h, even_across, even_down, growth, extent, height;
};

/// The force on a frictionless rigid obstacle that is moved down by `way`. `more`: a node with its mesh.
double forceOn(const std::string& obstacle, double way, double range, double stiffness, const Layer& layer,
               const std::string& more = "") {
  const std::vector<double> x = graded(layer.h, int(std::lround(layer.even_across / layer.h)), layer.growth, layer.extent),
                            z = graded(layer.h, int(std::lround(layer.even_down / layer.h)), layer.growth, layer.height);
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
  Simulation simulation = simulationFromText(contactScene(
      fmt::format("<MeshTopology name=\"mesh\" position=\"{}\" hexahedra=\"{}\"/><MechanicalObject name=\"dofs\"/>"
                  "<UniformMass totalMass=\"1\"/><HexahedronFEMForceField youngModulus=\"1e4\" poissonRatio=\"0.3\"/>"
                  "<PartialFixedProjectiveConstraint indices=\"{}\" fixedDirections=\"1 0 0\"/>"
                  "<PartialFixedProjectiveConstraint indices=\"{}\" fixedDirections=\"0 1 0\"/>"
                  "<FixedProjectiveConstraint indices=\"{}\"/>"
                  "<BarrierContact contactDistance=\"{}\" stiffness=\"{}\" selfContact=\"0\" {} keyTimes=\"0 1\" "
                  "movements=\"0 0 0  0 0 {}\"/>",
                  positions, cells, left, front, bottom, range, stiffness, obstacle, -way) +
          more,
      1, Vec3::Zero(), "<StaticSolver relative_residual_tolerance_threshold=\"1e-6\"/>"));
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.newton_converged) << report.reason;
  EXPECT_TRUE(report.constraints_converged) << report.constraint_reason;
  return -4 * numbersOf(simulation, "wrenches")[2];
}

/// alpha_0 of a layer that is bonded to its ground (Dimitriadis, Horkay, Maresca, Kachar and Chadwick 2002).
double layerFactor(double nu) { return -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1 - nu); }

/// A rigid sphere of radius R pressed into a layer by D.
double forceOfSphere(double h, double growth) {
  constexpr double radius = 0.01, depth = 2e-4, range = 3e-5;
  // it starts 1.01 and ends 0.95 contact distances above
  return forceOn(fmt::format("spheres=\"0 0 {} {}\"", radius + 1.01 * range, radius), depth + 0.06 * range, range, 1e5,
                 {h, 0.0021, 0.0015, growth, 0.016, 0.01414});
}

/// Hertz, with the factor of a bonded layer, sqrt(R D)/H = 0.1.
TEST(ClosedForms, HertzsSphereOnALayer) {
  constexpr double young = 1e4, nu = 0.3, radius = 0.01, depth = 2e-4, height = 0.01414;
  const double hertz = 4. / 3 * young / (1 - nu * nu) * std::sqrt(radius) * std::pow(depth, 1.5);
  const double a = layerFactor(nu), chi = std::sqrt(radius * depth) / height;
  const double expected = hertz * (1 - 2 * a / M_PI * chi + 4 * a * a / (M_PI * M_PI) * chi * chi);
  const double coarse = forceOfSphere(6e-4, 1.8) / expected - 1, fine = forceOfSphere(3e-4, 1.6) / expected - 1;
  RecordProperty("error of the force, coarse", std::to_string(coarse));
  RecordProperty("error of the force, fine", std::to_string(fine));
  EXPECT_LT(std::abs(coarse), 0.01);
  EXPECT_LT(std::abs(fine), 0.01);
}

/// A flat punch of radius a, F = 2 E* a D on a half-space. The layer of height H shows a half-space pressed by
/// |alpha_0| F/(pi E* H) less than D, so F is larger by 1/(1 - 2 |alpha_0| a/(pi H)), a/H = 0.1. What is in contact are the
/// nodes below the punch: a is such that as many squares of h^2 are its area, and the circle passes between nodes. The
/// error then falls with h.
TEST(ClosedForms, FlatPunch) {
  constexpr double young = 1e4, nu = 0.3, radius = 2e-3, depth = 2e-5, height = 0.02, range = 2e-5;
  const double half_space = 2 * young / (1 - nu * nu) * radius * depth;
  const double expected = half_space / (1 - 2 * std::abs(layerFactor(nu)) * radius / (M_PI * height));
  const auto error = [&](double nodes) {  // in a full circle
    const double h = radius / std::sqrt(nodes / M_PI);
    const std::string punch = fmt::format("cylinders=\"0 0 {} 0 0 {} {}\"", 1.01 * range, radius, radius);
    // pressures are 1e-5 to 1e-4 of the stiffness, which rest at 0.998 to 0.994 contact distances
    return forceOn(punch, depth + 0.014 * range, range, 1e7, {h, 1.15 * radius, 0.6 * radius, 1.9, 0.02, height}) / expected - 1;
  };
  const double coarse = error(69), fine = error(137);
  RecordProperty("error of the force, coarse", std::to_string(coarse));
  RecordProperty("error of the force, fine", std::to_string(fine));
  EXPECT_LT(std::abs(fine), 0.02);
  EXPECT_LT(std::abs(coarse), 0.03);
  const double h = std::sqrt(1 / 69.), smaller = std::sqrt(1 / 137.);  // of the cells, over the radius
  EXPECT_LT(std::abs((h * fine - smaller * coarse) / (h - smaller)), 0.015) << "what is left for cells without size";
}

/// The force on a punch of radius 1 whose rim lies on nodes, over that of a half-space, 2 E* a D. The body is a sector of 5 degrees with
/// one cell around, free to slide on its two sides; cells are as small as h at the rim and grow by a fifth each. SI units.
double sectorPunch(double h) {
  constexpr double angle = 5 * M_PI / 180, growth = 1.2, far = 60, axis = 1e-3, depth = 0.01, range = depth / 4, young = 1e4, nu = 0.3;
  std::vector<double> r;
  const auto grow = [&](double total) {
    std::vector<double> all{0};
    for (double step = h; all.back() < total; step *= growth) all.push_back(all.back() + step);
    const double end = all.back();
    for (double& each : all) each *= total / end;
    return all;
  };
  const std::vector<double> inwards = grow(1 - axis), z = grow(far);
  for (std::size_t i = inwards.size(); i-- > 0;) r.push_back(1 - inwards[i]);
  for (std::size_t i = 1; i < z.size(); ++i) r.push_back(1 + z[i]);
  const int n = int(r.size()), m = int(z.size());
  std::string positions, cells, right, left, bottom;
  const auto node = [&](int i, int side, int k) { return side + 2 * (i + n * k); };
  for (int k = 0; k < m; ++k)
    for (int i = 0; i < n; ++i)
      for (int side = 0; side < 2; ++side) {
        const double y = (side == 0 ? -1 : 1) * r[std::size_t(i)] * std::sin(angle / 2);
        positions += fmt::format("{} {} {}  ", r[std::size_t(i)] * std::cos(angle / 2), y, -z[std::size_t(m - 1 - k)]);
        (k == 0 ? bottom : side == 0 ? right : left) += fmt::format("{} ", node(i, side, k));
        if (side == 0 && i + 1 < n && k + 1 < m)
          cells += fmt::format("{} {} {} {} {} {} {} {}  ", node(i, 0, k), node(i + 1, 0, k), node(i + 1, 1, k), node(i, 1, k),
                               node(i, 0, k + 1), node(i + 1, 0, k + 1), node(i + 1, 1, k + 1), node(i, 1, k + 1));
      }
  const double s = std::sin(angle / 2), c = std::cos(angle / 2);
  Simulation simulation = simulationFromText(contactScene(
      fmt::format("<MeshTopology name=\"mesh\" position=\"{}\" hexahedra=\"{}\"/><MechanicalObject name=\"dofs\"/>"
                  "<UniformMass totalMass=\"1\"/><HexahedronFEMForceField youngModulus=\"{}\" poissonRatio=\"{}\"/>"
                  "<FixedPlaneProjectiveConstraint indices=\"{}\" direction=\"{} {} 0\"/>"
                  "<FixedPlaneProjectiveConstraint indices=\"{}\" direction=\"{} {} 0\"/>"
                  "<FixedProjectiveConstraint indices=\"{}\"/>"
                  "<BarrierContact contactDistance=\"{}\" stiffness=\"{}\" selfContact=\"0\" boxes=\"-1 -9 {} {} 9 3\" "
                  "keyTimes=\"0 1\" movements=\"0 0 0  0 0 {}\"/>",
                  positions, cells, young, nu, right, -s, -c, left, -s, c, bottom, range, 1e3 * young, 1.01 * range,
                  c * (1 + 1e-9), -(depth + 0.014 * range)),
      1, Vec3::Zero(), "<StaticSolver relative_residual_tolerance_threshold=\"1e-6\"/>"));
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.newton_converged) << report.reason;
  const double force = -2 * M_PI / angle * numbersOf(simulation, "wrenches")[2];
  return force / (2 * young / (1 - nu * nu) * depth) * (1 - 2 * std::abs(layerFactor(nu)) / (M_PI * far));
}

/// The pressure at the rim is infinite, so that the error falls with the cells there alone.
TEST(ClosedForms, APunchConvergesWithTheCellsAtItsRim) {
  const double coarse = sectorPunch(1. / 16) - 1, fine = sectorPunch(1. / 32) - 1, finest = sectorPunch(1. / 64) - 1;
  RecordProperty("error of the force, 1/16, 1/32 and 1/64 of the radius", fmt::format("{:.4f} {:.4f} {:.4f}", coarse, fine, finest));
  EXPECT_LT(std::abs(coarse), 0.02);
  EXPECT_LT(std::abs(fine), 0.6 * std::abs(coarse));
  EXPECT_LT(std::abs(finest), 0.6 * std::abs(fine));
}

/// A cone of half angle q, F = (2/pi) E* tan q D^2 with a = (2/pi) D tan q on a half-space (Love 1939, Sneddon 1965). The layer shows a
/// half-space pressed by |alpha_0| F/(pi E* H) more than D. It is blunt: the closed form leaves out how places below it move inwards.
TEST(ClosedForms, Cone) {
  constexpr double young = 1e4, nu = 0.3, angle = 84 * M_PI / 180, depth = 1.16e-4, height = 0.02, range = 1e-5;
  const double reduced = young / (1 - nu * nu), a = 2 / M_PI * depth * std::tan(angle);
  double expected = 0;
  for (int i = 0; i < 100; ++i) {
    const double shown = depth + std::abs(layerFactor(nu)) * expected / (M_PI * reduced * height);
    expected = 2 / M_PI * reduced * std::tan(angle) * shown * shown;
  }
  constexpr int sides = 96;
  constexpr double high = 2e-4, first = 1.01 * range;
  std::string points = fmt::format("0 0 {} ", first), triangles;
  for (int k = 0; k < sides; ++k) {
    const double t = 2 * M_PI * k / sides, r = high * std::tan(angle);
    points += fmt::format("{} {} {} ", r * std::cos(t), r * std::sin(t), first + high);
    triangles += fmt::format("0 {} {}  {} {} {} ", 1 + (k + 1) % sides, 1 + k, sides + 1, 1 + k, 1 + (k + 1) % sides);
  }
  points += fmt::format("0 0 {}", first + high);
  const std::string cone =
      fmt::format("<Node name=\"cone\"><MeshTopology name=\"mesh\" position=\"{}\" triangles=\"{}\"/></Node>", points, triangles);
  // pressures are a thousandth of the stiffness, which rest at 0.98 contact distances
  const Layer layer{a / 3, 1.4 * a, 1.2 * a, 1.7, 0.02, height};
  const double error = forceOn("meshes=\"@cone/mesh\"", depth + 0.03 * range, range, 1e6, layer, cone) / expected - 1;
  RecordProperty("error of the force", std::to_string(error));
  EXPECT_LT(std::abs(error), 0.015);
}

/// A sphere that is larger than the cells it is pressed into has its centre far away. What turns below it closes gaps by far more than
/// their width, which a definite tangent must know. The force grows to that of a hard sphere, by the share of the gap that is left.
TEST(ClosedForms, AHardBarrierAroundALargeSphereFindsItsBalance) {
  const double range = 1e-4, way = 3e-4;
  std::vector<double> forces;
  for (const double stiffness : {1e5, 1e6, 1e7}) {
    Simulation simulation = simulationFromText(contactScene(
        fmt::format("<RegularGridTopology n=\"7 7 3\" min=\"0 0 -0.003\" max=\"0.0045 0.0045 0\"/><MechanicalObject name=\"dofs\"/>"
                    "<HexahedronFEMForceField youngModulus=\"1e4\" poissonRatio=\"0.45\" method=\"small\"/>"
                    "<BoxROI name=\"low\" box=\"-1 -1 -1 1 1 -0.0029\"/><FixedProjectiveConstraint indices=\"@low.indices\"/>"
                    "<BoxROI name=\"left\" box=\"-1 -1 -1 1e-5 1 1\"/><BoxROI name=\"front\" box=\"-1 -1 -1 1 1e-5 1\"/>"
                    "<PartialFixedProjectiveConstraint indices=\"@left.indices\" fixedDirections=\"1 0 0\"/>"
                    "<PartialFixedProjectiveConstraint indices=\"@front.indices\" fixedDirections=\"0 1 0\"/>"
                    "<BarrierContact spheres=\"0 0 {} 0.005\" contactDistance=\"{}\" stiffness=\"{}\" keyTimes=\"0 2 9\" "
                    "movements=\"0 0 0  0 0 {}  0 0 {}\"/>",
                    0.005 + 1.001 * range, range, stiffness, -way, -way),
        1, Vec3::Zero(), "<StaticSolver relative_residual_tolerance_threshold=\"1e-6\"/>"));
    for (int i = 0; i < 2; ++i) {
      const StepReport report = simulation.step();
      ASSERT_TRUE(!report.diverged && report.newton_converged) << stiffness << " Pa, step " << i << ": " << report.reason;
    }
    forces.push_back(-numbersOf(simulation, "wrenches")[2]);
  }
  EXPECT_GT(forces[1], forces[0]);
  EXPECT_GT(forces[2], forces[1]);
  EXPECT_LT(forces[1], 1.03 * forces[0]);
  EXPECT_LT(forces[2], 1.01 * forces[1]);
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
