// SPDX-License-Identifier: LGPL-2.1-or-later
// A twisted ring, a rotor on soft springs and a viscous cube that is driven to and fro, as a user writes them, against closed forms.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double pi = std::numbers::pi;

void step(Simulation& simulation) {
  const StepReport report = simulation.step();
  ASSERT_TRUE(!report.failed() && !report.unsolved) << report.reason;
}

/// A straight rod is bent to a ring, twisted by one turn and joined; how far it has left its plane after a while, of 1e-3 at the start.
double outOfPlane(double ratio) {
  constexpr int count = 48;
  constexpr double length = 2 * pi / count;  // of a beam; the ring has a radius of 1
  std::string places, straight, edges;
  for (int i = 0; i <= count; ++i) {
    const double angle = 2 * pi * i / count, z = 1e-3 * (std::sin(2 * angle) + std::cos(3 * angle));
    const Eigen::Quaterniond turn = Eigen::AngleAxisd(angle + pi / 2, Vec3::UnitZ()) * Eigen::AngleAxisd(angle, Vec3::UnitX());
    places += fmt::format("{:.15g} {:.15g} {:.15g} ", std::cos(angle), std::sin(angle), z);
    places += fmt::format("{:.15g} {:.15g} {:.15g} {:.15g} ", turn.x(), turn.y(), turn.z(), turn.w());
    straight += fmt::format("{:.15g} 0 0 0 0 0 1 ", length * i);
    if (i < count) edges += fmt::format("{} {} ", i, i + 1);
  }
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver rayleighMass="1" newtonIterations="20"/><SparseLDLSolver/>
  <MeshTopology edges="{}"/><MechanicalObject template="Rigid3" position="{}" rest_position="{}"/>
  <UniformMass totalMass="1" inertia="1e-5 1e-5 1e-5"/><BeamFEMForceField youngModulus="1e8" poissonRatio="{}" radius="0.02"/>
  <AttachProjectiveConstraint indices1="0" indices2="{}"/></Node>)",
      edges, places, straight, ratio, count));
  for (int i = 0; i < 200; ++i) step(simulation);
  double low = 0, high = 0;
  for (int i = 0; i <= count; ++i) {
    const double z = simulation.systems()[0]->x[2 * i].z();
    low = std::min(low, z), high = std::max(high, z);
  }
  return high - low;
}

/// Michell 1889, Zajac 1962: it stays a circle up to sqrt(3) E I / (G J) turns, which is sqrt(3) (1 + nu) of a round section.
TEST(TextbookRods, ATwistedRingBuckles) {
  EXPECT_LT(outOfPlane(-0.4), 1e-3);   // 1.04 turns
  EXPECT_GT(outOfPlane(-0.45), 0.05);  // 0.95 turns
}

/// A rotor with the spin W on springs of k against tilting whirls by w = a +- sqrt(a^2 + k/I), a = I_p W/2I: once with its spin, once
/// against it. Begun in one of both.
TEST(TextbookRods, ARotorOnSoftSpringsWhirls) {
  constexpr double inertia = 0.01, polar = 0.016, spin = 200, k = 50, tilt = 1e-3, dt = 2e-4;
  const double a = polar * spin / (2 * inertia), root = std::sqrt(a * a + k / inertia);
  for (const double w : {a + root, a - root}) {
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="{}" gravity="0 0 0"><VariationalSymplecticSolver/><SparseLDLSolver/>
  <MechanicalObject template="Rigid3" position="0 0 0 0 0 {:.15g} {:.15g}" rest_position="0 0 0 0 0 0 1" velocity="0 0 0 {} {:.15g} 0"/>
  <UniformMass totalMass="1" inertia="{} {} {}"/><RestShapeSpringsForceField points="0" stiffness="1000" angularStiffness="0"/>
  <Node name="axis"><MechanicalObject name="p" position="0.1 0 0  -0.1 0 0"/><RigidMapping/>
  <RestShapeSpringsForceField points="0 1" stiffness="{}"/></Node></Node>)",
        dt, std::sin(tilt / 2), std::cos(tilt / 2), spin, (spin - w) * tilt, polar, inertia, inertia, k / 0.02));
    double first = 0, last = 0, before = 0;
    int crossings = 0;
    for (int i = 1; crossings < (w > 0 ? 6 : 3); ++i) {
      step(simulation);
      ASSERT_LT(i, 8000);
      const auto& p = dynamic_cast<const State&>(*findComponent(simulation.root(), "/axis/p"));
      const double y = p.x()[0].y();
      if (before < 0 && y >= 0) {
        last = dt * (i - y / (y - before));
        if (crossings++ == 0) first = last;
      }
      before = y;
    }
    EXPECT_NEAR(2 * pi * (crossings - 1) / (last - first), std::abs(w), 2e-3 * std::abs(w));
  }
}

/// One Prony term: G' = E (1 - s + s q^2/(1 + q^2)), G''/G' of s q/(1 + q^2) over the same, q = w tau. Small strains, 100 steps a period.
TEST(TextbookRods, AViscousCubeLosesWhatItsLawSays) {
  constexpr double modulus = 1e4, ratio = 0.3, share = 0.5, tau = 0.1, strain = 1e-4;
  constexpr int steps = 100, periods = 5;
  for (const double w : {2., 10., 50.}) {
    const double dt = 2 * pi / w / steps, q = w * tau;
    std::string times, ways;
    for (int i = 0; i <= steps * periods; ++i)
      times += fmt::format("{:.15g} ", i * dt), ways += fmt::format("{:.15g} 0 0 ", strain * std::sin(w * i * dt));
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="{:.17g}" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/>
  <RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject/><HexahedronHyperelasticityFEMForceField
  materialName="StVenantKirchhoff" ParameterSet="{:.15g} {:.15g}" viscous="true" ParameterAlpha="{}" ParameterTau="{}"
  viscousUpdate="exponential"/>
  <PartialLinearMovementProjectiveConstraint indices="1 3 5 7" movedDirections="1 0 0" keyTimes="{}" movements="{}"/>
  <PartialFixedProjectiveConstraint indices="0 2 4 6" fixedDirections="1 0 0"/>
  <PartialFixedProjectiveConstraint indices="0 1 4 5" fixedDirections="0 1 0"/>
  <PartialFixedProjectiveConstraint indices="0 1 2 3" fixedDirections="0 0 1"/></Node>)",
        dt, modulus / (2 * (1 + ratio)), modulus * ratio / ((1 + ratio) * (1 - 2 * ratio)), share, tau, times, ways));
    double in_phase = 0, ahead = 0;
    for (int i = 1; i <= steps * periods; ++i) {
      step(simulation);
      if (i <= steps * (periods - 1)) continue;
      double pull = 0;
      for (const Index node : {1, 3, 5, 7}) pull -= simulation.systems()[0]->f[node].x();
      in_phase += 2 * pull * std::sin(w * i * dt) / steps, ahead += 2 * pull * std::cos(w * i * dt) / steps;
    }
    const double storage = 1 - share + share * q * q / (1 + q * q), loss = share * q / (1 + q * q);
    EXPECT_NEAR(in_phase / strain / (modulus * storage), 1, 2e-3) << w;
    EXPECT_NEAR(ahead / in_phase / (loss / storage), 1, 4e-3) << w;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
