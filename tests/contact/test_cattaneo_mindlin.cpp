// SPDX-License-Identifier: LGPL-2.1-or-later
// Cattaneo 1938 and Mindlin 1949: a rigid cylinder is pressed into a half-space and then moved along it. A strip in the middle
// of the contact sticks, what is outside slips.
#include <cmath>
#include <vector>

#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"
#include "tests/contact/published_meshes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

// SI units. The closed form is of a flat contact, a/R small, in which shear moves nothing across the surface: nu near 1/2.
constexpr double young = 1e4, nu = 0.49, radius = 0.04, depth = 6.4e-5, way = 1.9e-5, mu = 0.3, range = 4e-6, a_about = 1e-3;
constexpr double creep = 2.5e-10;  ///< of what sticks, in a step, at most [m]

/// Plane strain: a slab with its upper side at z = 0, one cell thick. The nodes of the upper side come last.
struct Slab {
  std::vector<double> x;
  double width;
  std::string nodes, cells, bottom;
  int top = 0;  ///< the first node of the upper side

  explicit Slab(double h) : width(h) {
    constexpr double growth = 1.6;
    const std::vector<double> right = gradedUpTo(h, 1.3 * a_about, growth, 120 * a_about),
                              down = gradedUpTo(h, a_about, growth, 100 * a_about);
    for (std::size_t i = right.size() - 1; i > 0; --i) x.push_back(-right[i]);
    x.insert(x.end(), right.begin(), right.end());
    const int n = int(x.size()), m = int(down.size());
    const auto node = [&](int i, int j, int k) { return i + n * (j + 2 * k); };
    for (int k = 0; k < m; ++k)
      for (int j = 0; j < 2; ++j)
        for (int i = 0; i < n; ++i) {
          nodes += fmt::format("{} {} {}  ", x[std::size_t(i)], j * width, -down[std::size_t(m - 1 - k)]);
          if (k == 0) bottom += fmt::format("{} ", node(i, j, k));
          if (i + 1 < n && j == 0 && k + 1 < m)
            cells += fmt::format("{} {} {} {} {} {} {} {}  ", node(i, 0, k), node(i + 1, 0, k), node(i + 1, 1, k),
                                 node(i, 1, k), node(i, 0, k + 1), node(i + 1, 0, k + 1), node(i + 1, 1, k + 1),
                                 node(i, 1, k + 1));
        }
    top = node(0, 0, m - 1);
  }
};

struct Slip {
  double sticking = 0;  ///< half the width of what sticks, as the nodes say [m]
  double c = 0;         ///< as the forces say [m]
  double share = 0;     ///< Q/(mu P)
  double error = 0;     ///< of the slip in the contact, over that at its rim
  int slipping = 0;     ///< nodes of the contact that do not stick
};

/// The slip at a distance x from the middle.
double closedForm(double x, double a, double c, double p0) {
  const double modulus = young / (1 - nu * nu), beyond = std::max(x, c);
  return mu * p0 / (a * modulus) * (beyond * std::sqrt(beyond * beyond - c * c) - c * c * std::acosh(beyond / c));
}

Slip slipOf(double h) {
  const Slab slab(h);
  const double start = radius + 1.01 * range;  // it ends 0.95 contact distances above
  Simulation simulation = simulationFromText(contactScene(
      fmt::format("<MeshTopology name=\"mesh\" position=\"{}\" hexahedra=\"{}\"/><MechanicalObject name=\"dofs\"/>"
                  "<UniformMass totalMass=\"1\"/><HexahedronFEMForceField youngModulus=\"{}\" poissonRatio=\"{}\" "
                  "method=\"small\"/><PartialFixedProjectiveConstraint fixAll=\"true\" fixedDirections=\"0 1 0\"/>"
                  "<FixedProjectiveConstraint indices=\"{}\"/>"
                  "<BarrierContact contactDistance=\"{}\" stiffness=\"2.5e4\" selfContact=\"0\" capsules=\"0 -0.01 {} 0 0.01 {} "
                  "{}\" friction=\"{}\" slipVelocity=\"{}\" frictionIterations=\"50\" keyTimes=\"0 1 2\" "
                  "movements=\"0 0 0  0 0 {}  {} 0 {}\"/>",
                  slab.nodes, slab.cells, young, nu, slab.bottom, range, start, start, radius, mu, creep,
                  -depth - 0.06 * range, way, -depth - 0.06 * range),
      1, Vec3::Zero(), "<StaticSolver relative_residual_tolerance_threshold=\"1e-7\"/>"));
  const State& state = *simulation.states()[0];
  std::vector<double> pressed;
  for (int step = 0; step < 2; ++step) {
    expectCleanStep(simulation, step);
    if (step == 0)
      for (Index i = 0; i < state.size(); ++i) pressed.push_back(state.x()[i].x());
  }
  const std::vector<double> wrench = numbersOf(simulation, "wrenches");
  const double load = -wrench[2] / slab.width, along = wrench[0] / slab.width;
  const double a = std::sqrt(4 * load * radius * (1 - nu * nu) / (M_PI * young)), p0 = 2 * load / (M_PI * a);
  Slip result;
  result.share = along / (mu * load);
  result.c = a * std::sqrt(1 - result.share);
  // what is left of shear across the surface is odd in x, and so are its effects: both sides have the closed form in the mean
  const std::size_t middle = slab.x.size() / 2;
  double sticks[2] = {0, 0};
  for (std::size_t i = 0; middle + i < slab.x.size() && slab.x[middle + i] < a - h; ++i) {
    const double x = slab.x[middle + i];
    double mean = 0;
    for (const int side : {0, 1}) {
      const Index node = slab.top + Index(side == 0 ? middle - i : middle + i);
      const double slip = way - (state.x()[node].x() - pressed[std::size_t(node)]);
      mean += 0.5 * slip;
      if (std::abs(slip) < 2 * creep) sticks[side] = x + 0.5 * h;
      result.slipping += std::abs(slip) >= 2 * creep;
    }
    result.error = std::max(result.error, std::abs(mean - closedForm(x, a, result.c, p0)) / closedForm(a, a, result.c, p0));
  }
  result.sticking = 0.5 * (sticks[0] + sticks[1]);
  return result;
}

/// c/a = (1 - Q/(mu P))^(1/2) to the size of a cell, and the slip beside the strip, whose error falls with that size.
TEST(CattaneoMindlin, TheMiddleOfAPressedCylinderSticks) {
  for (const int cells : {6, 9}) {
    SCOPED_TRACE(fmt::format("{} cells in half of the contact", cells));
    const Slip slip = slipOf(a_about / cells);
    if (HasFatalFailure()) return;
    RecordProperty(fmt::format("{} cells", cells),
                   fmt::format("Q/(mu P) {:.4f}, c of the forces {:.4g}, of the nodes {:.4g}, error of the slip {:.4f}", slip.share,
                               slip.c, slip.sticking, slip.error));
    EXPECT_GT(slip.share, 0.4);
    EXPECT_LT(slip.share, 0.8);
    EXPECT_NEAR(slip.sticking, slip.c, a_about / cells);
    EXPECT_GE(slip.slipping, cells / 2);
    EXPECT_LT(slip.error, 0.1 / cells);
  }
}

/// By penalties: c from Q/(mu P), and from where friction acts: its mean square distance from the middle is (a^2 + c^2)/4. What an edge
/// at the rim of the slab was pushed by is no reason for its ends to rub: a node beside the contact had 1.4 times as much as any other.
TEST(CattaneoMindlin, WhatPenaltiesDoNotPushDoesNotRub) {
  const Slab slab(a_about / 8);
  const double start = radius + 0.9999 * range;
  Simulation simulation = simulationFromText(contactScene(
      fmt::format("<MeshTopology name=\"mesh\" position=\"{}\" hexahedra=\"{}\"/><MechanicalObject name=\"dofs\"/>"
                  "<HexahedronFEMForceField youngModulus=\"{}\" poissonRatio=\"{}\" "
                  "method=\"small\"/><PartialFixedProjectiveConstraint fixAll=\"true\" fixedDirections=\"0 1 0\"/>"
                  "<FixedProjectiveConstraint indices=\"{}\"/>"
                  "<PenaltyContact contactDistance=\"{}\" alarmDistance=\"1e-5\" stiffness=\"2.5e4\" selfContact=\"0\" "
                  "capsules=\"0 -1 {} 0 1 {} {}\" friction=\"{}\" slipVelocity=\"1e-8\" keyTimes=\"0 4 8\" "
                  "movements=\"0 0 0  0 0 {}  {} 0 {}\"/>",
                  slab.nodes, slab.cells, young, nu, slab.bottom, range, start, start, radius, mu, -depth, way, -depth),
      1, Vec3::Zero(), "<StaticSolver relative_residual_tolerance_threshold=\"1e-5\"/>"));
  for (int step = 0; step < 8; ++step) expectCleanStep(simulation, step, false);
  const std::vector<double> normal = numbersOf(simulation, "contactForces", "PenaltyContact"),
                            along = numbersOf(simulation, "frictionForces", "PenaltyContact");
  const State& state = *simulation.states()[0];
  double load = 0, friction = 0, moment = 0, square = 0, most = 0;
  for (Index i = 0; i < state.size(); ++i) {
    const std::size_t k = 3 * std::size_t(i);
    const double x = state.x()[i].x() - way;
    load -= normal[k + 2], friction += along[k], most = std::max(most, -normal[k + 2]);
    moment -= normal[k + 2] * x * x, square += along[k] * x * x;
  }
  for (std::size_t k = 0; k < normal.size(); k += 3)
    EXPECT_LT(std::abs(along[k]), -mu * normal[k + 2] + 0.02 * mu * most) << "node " << k / 3;
  const double a = 2 * std::sqrt(moment / load), c = a * std::sqrt(1 - friction / (mu * load));
  EXPECT_NEAR(a, std::sqrt(4 * load / slab.width * radius * (1 - nu * nu) / (M_PI * young)), 0.02 * a);
  EXPECT_NEAR(std::sqrt(4 * square / friction - a * a), c, 0.05 * c);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
