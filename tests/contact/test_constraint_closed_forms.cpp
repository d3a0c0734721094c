// SPDX-License-Identifier: LGPL-2.1-or-later
// Contact by forces of constraint against closed forms, in statics and in long implicit steps: a sphere and a cylinder that are
// pressed in (Hertz) and a flat punch; and that deep contact converges to the tolerance that is asked for.
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string statics = "<StaticSolver newton_iterations=\"40\"/>", euler = "<EulerImplicitSolver newtonIterations=\"40\"/>";

/// Nodes of a block in each direction, its top at z = 0: depths are positive.
struct Ticks {
  std::vector<double> x, y, depths;
};

/// A block of hexahedra that is held below and cannot cross its sides x = 0 and y = 0, or all its y; an obstacle goes down by `way`
/// in `steps` steps.
Simulation pressed(const Ticks& ticks, bool is_plane, const std::string& obstacle, double way, int steps,
                   const std::string& integrator, const std::string& field, double friction = 0, double range = 1e-5) {
  std::string positions, cells, left, front, bottom;
  const int n = int(ticks.x.size()), m = int(ticks.y.size()), k_end = int(ticks.depths.size());
  const auto node = [&](int i, int j, int k) { return i + n * (j + m * k); };
  for (int k = 0; k < k_end; ++k)
    for (int j = 0; j < m; ++j)
      for (int i = 0; i < n; ++i) {
        const double z = -ticks.depths[std::size_t(k_end - 1 - k)];
        positions += fmt::format("{} {} {}  ", ticks.x[std::size_t(i)], ticks.y[std::size_t(j)], z);
        if (i == 0) left += fmt::format("{} ", node(i, j, k));
        if (j == 0 || is_plane) front += fmt::format("{} ", node(i, j, k));
        if (k == 0) bottom += fmt::format("{} ", node(i, j, k));
        if (i + 1 < n && j + 1 < m && k + 1 < k_end)
          for (const int up : {k, k + 1})
            cells += fmt::format("{} {} {} {}  ", node(i, j, up), node(i + 1, j, up), node(i + 1, j + 1, up), node(i, j + 1, up));
      }
  return simulationFromText(contactScene(
      fmt::format("<MeshTopology name=\"mesh\" position=\"{}\" hexahedra=\"{}\"/><MechanicalObject name=\"dofs\"/>"
                  "<UniformMass totalMass=\"1e-6\"/>{}<PartialFixedProjectiveConstraint indices=\"{}\" fixedDirections=\"1 0 0\"/>"
                  "<PartialFixedProjectiveConstraint indices=\"{}\" fixedDirections=\"0 1 0\"/>"
                  "<FixedProjectiveConstraint indices=\"{}\"/>"
                  "<ConstraintContact contactDistance=\"{}\" friction=\"{}\" {} keyTimes=\"0 {}\" movements=\"0 0 0  0 0 {}\"/>",
                  positions, cells, field, left, front, bottom, range, friction, obstacle, 10 * steps, -way),
      10, Vec3::Zero(), integrator));
}

const std::string linear = "<HexahedronFEMForceField youngModulus=\"1e4\" poissonRatio=\"0.3\" method=\"small\"/>";

/// All steps hold, and their forces are in balance as far as the integrators ask by default.
void go(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.diverged) << "step " << i << ": " << report.reason;
    ASSERT_TRUE(report.newton_converged) << "step " << i << ": " << report.reason;
    ASSERT_TRUE(report.constraints_converged) << "step " << i << ": " << report.constraint_reason;
    ASSERT_LE(report.newton_residual, 1e-8) << "step " << i;
  }
}

/// alpha_0 of a layer that is bonded to its ground (Dimitriadis, Horkay, Maresca, Kachar and Chadwick 2002).
double layerFactor(double nu) { return -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1 - nu); }

/// Hertz with the factor of a bonded layer; the gap that is kept is a part of the sphere. A quarter. Faces lie around the sphere,
/// so that nodes are farther away by up to h^2/(8 R): the error falls with the cells.
TEST(ConstraintClosedForms, HertzsSphereOnALayer) {
  constexpr double young = 1e4, nu = 0.3, radius = 0.01, range = 1e-4, depth = 2e-4, height = 0.01414;
  const double large = radius + range, a = layerFactor(nu), chi = std::sqrt(large * depth) / height;
  const double hertz = 4. / 3 * young / (1 - nu * nu) * std::sqrt(large) * std::pow(depth, 1.5);
  const double expected = hertz * (1 - 2 * a / M_PI * chi + 4 * a * a / (M_PI * M_PI) * chi * chi);
  const auto error = [&](double h, double growth, const std::string& integrator, int steps) {
    const auto x = graded(h, int(std::lround(0.0021 / h)), growth, 0.016);
    const auto z = graded(h, int(std::lround(0.0015 / h)), growth, height);
    Simulation simulation = pressed({x, x, z}, false, fmt::format("spheres=\"0 0 {} {}\"", radius + 1.001 * range, radius),
                                    depth + 0.001 * range, steps, integrator, linear, 0, range);
    go(simulation, steps);
    return -4 * constraintOutput(simulation, "wrenches").at(2) / expected - 1;
  };
  const double coarse = error(8e-4, 1.8, statics, 2), fine = error(4e-4, 1.6, statics, 1);
  RecordProperty("error of the force, coarse", std::to_string(coarse));
  RecordProperty("error of the force, fine", std::to_string(fine));
  EXPECT_LT(std::abs(fine), 0.6 * std::abs(coarse));
  EXPECT_LT(std::abs(2 * fine - coarse), 0.02) << "what is left for cells without size";
  EXPECT_NEAR(error(8e-4, 1.8, euler, 2), coarse, 1e-4) << "long steps in time";
}

/// Hertz's line contact of a cylinder, half of it in plane strain: p is an ellipse of half width a = sqrt(4 F' R/(pi E*)), whose
/// force lies at a mean square of a^2/4 from the middle.
TEST(ConstraintClosedForms, HertzsCylinder) {
  constexpr double young = 1e4, nu = 0.3, radius = 0.01, range = 1e-5, depth = 2e-4, wide = 5e-4;
  const auto error = [&](double h) {
    const auto x = graded(h, int(std::lround(0.003 / h)), 1.3, 0.04), z = graded(h, int(std::lround(0.002 / h)), 1.3, 0.04);
    Simulation simulation =
        pressed({x, {0, wide}, z}, true, fmt::format("capsules=\"0 -0.1 {0} 0 0.1 {0} {1}\"", radius + 1.001 * range, radius),
                depth + 0.001 * range, 2, statics, linear);
    go(simulation, 2);
    const std::vector<double> forces = constraintOutput(simulation, "contactForces");
    double sum = 0, moment = 0;
    for (std::size_t i = 0; i + 2 < forces.size(); i += 3) {
      const double at = simulation.states().front()->x()[Index(i / 3)].x();
      sum -= forces[i + 2], moment -= forces[i + 2] * at * at;
    }
    const double expected = std::sqrt(4 * (2 * sum / wide) * (radius + range) * (1 - nu * nu) / (M_PI * young));
    return 2 * std::sqrt(moment / sum) / expected - 1;
  };
  const double coarse = error(4e-4), fine = error(2e-4);
  RecordProperty("error of the half width, coarse", std::to_string(coarse));
  RecordProperty("error of the half width, fine", std::to_string(fine));
  EXPECT_LT(std::abs(fine), 0.02);
  EXPECT_LT(std::abs(coarse), 0.05);
}

/// F = 2 E* a D of a half-space; a layer of height H shows one that is pressed by |alpha_0| F/(pi E* H) less. The rim lies in
/// cells, which go down with it: the error falls with their size.
TEST(ConstraintClosedForms, FlatPunch) {
  constexpr double young = 1e4, nu = 0.3, radius = 2e-3, depth = 2e-5, height = 0.02, range = 1e-5;
  const double half_space = 2 * young / (1 - nu * nu) * radius * depth;
  const double expected = half_space / (1 - 2 * std::abs(layerFactor(nu)) * radius / (M_PI * height));
  const auto error = [&](double h) {
    const auto x = graded(h, int(std::lround(1.25 * radius / h)), 1.9, 0.02);
    const auto z = graded(h, int(std::lround(0.6 * radius / h)), 1.9, height);
    Simulation simulation = pressed({x, x, z}, false, fmt::format("cylinders=\"0 0 {} 0 0 {} {}\"", 1.001 * range, radius, radius),
                                    depth + 0.001 * range, 1, statics, linear, 0, range);
    go(simulation, 1);
    return -4 * constraintOutput(simulation, "wrenches").at(2) / expected - 1;
  };
  const double coarse = error(radius / 3), fine = error(radius / 6);
  RecordProperty("error of the force, coarse", std::to_string(coarse));
  RecordProperty("error of the force, fine", std::to_string(fine));
  EXPECT_LT(std::abs(fine), 0.6 * std::abs(coarse));
  EXPECT_LT(std::abs(2 * fine - coarse), 0.03) << "what is left for cells without size";
}

/// A sphere that goes by a third of its radius into cells of half of it, which turn: with large turns and friction, in statics and
/// in time, all steps converge.
TEST(ConstraintClosedForms, ADeepSphereConverges) {
  std::vector<double> x, z;
  for (int i = 0; i <= 4; ++i) x.push_back(0.005 * i), z.push_back(0.005 * i);
  for (const std::string& integrator : {statics, euler})
    for (const char* method : {"small", "large", "polar"})
      for (const double friction : {0.0, 0.3}) {
        SCOPED_TRACE(integrator + method + std::to_string(friction));
        const std::string field =
            fmt::format("<HexahedronFEMForceField youngModulus=\"1e4\" poissonRatio=\"0.45\" method=\"{}\"/>", method);
        Simulation simulation =
            pressed({x, x, z}, false, "spheres=\"0 0 0.0101 0.01\"", 0.003, 6, integrator, field, friction, 1e-4);
        go(simulation, 6);
        if (HasFatalFailure()) return;
        EXPECT_LT(constraintOutput(simulation, "wrenches").at(2), 0);
      }
}

/// A sphere that goes down and aside on cells of a third of its radius, with friction: the balance of forces is as good as it was
/// asked for, whatever gaps and slides may be off by.
TEST(ConstraintClosedForms, TheBalanceKeepsItsTolerance) {
  constexpr double tolerance = 1e-8;
  for (const char* tolerated : {"", "toleratedError=\"1e-12\""}) {
    SCOPED_TRACE(tolerated);
    Simulation simulation = simulationFromText(contactScene(
        fmt::format("<RegularGridTopology n=\"9 9 4\" min=\"-0.03 -0.03 -0.02\" max=\"0.03 0.03 0\"/>"
                    "<MechanicalObject name=\"dofs\"/><UniformMass totalMass=\"1\"/>"
                    "<HexahedronFEMForceField youngModulus=\"1e4\" poissonRatio=\"0.45\" method=\"polar\"/>"
                    "<BoxROI name=\"bottom\" box=\"-1 -1 -0.021 1 1 -0.0199\"/>"
                    "<FixedProjectiveConstraint indices=\"@bottom.indices\"/>"
                    "<ConstraintContact contactDistance=\"1e-3\" friction=\"0.5\" spheres=\"0.001 0.0007 0.02101 0.02\" "
                    "keyTimes=\"0 10\" movements=\"0 0 0  0.01 0 -0.02\" {}/>",
                    tolerated),
        1, Vec3::Zero(),
        fmt::format("<StaticSolver newton_iterations=\"60\" relative_residual_tolerance_threshold=\"{}\"/>", tolerance)));
    for (int step = 0; step < 2; ++step) {
      const StepReport report = simulation.step();
      ASSERT_TRUE(report.newton_converged && report.constraints_converged) << step << report.reason << report.constraint_reason;
      EXPECT_LE(report.newton_residual, tolerance) << "step " << step;
    }
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
