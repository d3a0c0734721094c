// SPDX-License-Identifier: LGPL-2.1-or-later
// Adhesion against its closed forms: the tension by the gap, the force that pulls a block off, what it bears along a surface.
#include <Eigen/Geometry>
#include <cmath>
#include <numeric>

#include "components/contact/contact_terms.h"
#include "framework/mechanics/open_choices.h"
#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// p/kappa of the barrier at r = d/contactDistance.
double pressureOver(double r) { return r < 1 ? 2 * (r - 1) * std::log(r) + (r - 1) * (r - 1) / r : 0; }

/// The root of a function that falls.
template <class Function>
double rootOf(Function&& f, double low, double high) {
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (f(middle) > 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

TEST(Adhesion, TheTensionIsTheSlopeOfTheEnergy) {
  const contact::Adhesion law{.strength = 300, .peak = 0.02, .range = 0.05};
  EXPECT_DOUBLE_EQ(law.at(0.02).slope, 300) << "its largest value";
  EXPECT_DOUBLE_EQ(law.at(0.01).slope, 150);
  EXPECT_NEAR(law.at(0.035).slope, 150, 1e-10);
  EXPECT_EQ(law.at(0).slope, 0);
  EXPECT_EQ(law.at(0.05).slope, 0);
  EXPECT_NEAR(law.at(0).value, -0.5 * 300 * 0.05, 1e-12) << "the work of adhesion: the triangle below the tension";
  for (const double gap : {0.001, 0.0199, 0.0201, 0.03, 0.0499}) {
    const double h = 1e-7;
    EXPECT_NEAR((law.at(gap + h).value - law.at(gap - h).value) / (2 * h), law.at(gap).slope, 1e-3) << gap;
    EXPECT_NEAR((law.at(gap + h).slope - law.at(gap - h).slope) / (2 * h), law.at(gap).curvature,
                1e-3 * std::abs(law.at(gap).curvature));
  }
}

/// Force, energy, derivative and products of bodies, a plane, a sphere and a capsule that push, pull, or both.
TEST(Adhesion, ForceIsTheSlopeOfTheEnergy) {
  int checked = 0;
  for (unsigned seed = 1; seed < 20; ++seed) {
    const Body a = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)), b = boxAbove(seed, 0.03 + 0.15 * (seed % 3));
    FieldUnderTest t(
        contactScene(bodyNode("a", a, "") + bodyNode("b", b, "") +
                     fmt::format(fmt::runtime(between),
                                 "contactDistance=\"0.2\" adhesion=\"2e4\" adhesionDistance=\"0.45\" planes=\"0 0 1 -0.3\" "
                                 "spheres=\"1.42 0.45 0.55 0.2\" capsules=\"-1 0.52 -0.51  2 0.44 -0.55  0.2\"")),
        "BarrierContact");
    if (const Vector f = t.force(); dot(f, f) == 0) continue;
    ++checked;
    const double step = 1e-6;
    expectForceOfEnergy(t, step, seed);
    for (int i = 0; i < 6; ++i) t.force();  // shares stay from then on
    EXPECT_LT(relativeDifference(t.differenceOfForces(step), t.product(t.direction)), 1e-5) << "seed " << seed;
    auto& choices = dynamic_cast<OpenChoices&>(t.field());
    for (const bool definite : {false, true}) {
      ASSERT_TRUE(choices.useDefiniteTangent(definite));
      expectMatrixOfProducts(t);
      if (!definite) expectSymmetricProducts(t);  // what only pulls has no definite part
    }
    EXPECT_LE(dot(t.direction, t.product(t.direction)), 0);
  }
  EXPECT_GT(checked, 15);
}

/// A bar of length H on the ground and a plane on its top that goes up. With the way u of the plane and the stretch s of the bar,
/// E s/H = t(g0 + u - s): so is the force at each step, it is at most adhesion times the area, and it ends where the gap is
/// adhesionDistance.
TEST(Adhesion, APlaneIsPulledOff) {
  constexpr double young = 1e6, height = 0.5, range = 0.01, kappa = 1e5, strength = 2e4, end = 0.03, area = 1, first = 0.9 * range;
  const Body bar = boxOf(Vec3(0, 0, 0), Vec3(1, 1, height), {3, 2, 2});
  std::string all, bottom;
  for (int i = 0; i < 36; ++i) all += fmt::format("{} ", i);
  for (int i = 0; i < 12; ++i) bottom += fmt::format("{} ", i);
  constexpr int steps = 60;
  constexpr double way = 0.045;
  Simulation simulation = simulationFromText(contactScene(
      bodyNode("a", bar,
               fmt::format("<PartialFixedProjectiveConstraint indices=\"{}\" fixedDirections=\"1 1 0\"/><FixedProjectiveConstraint "
                           "indices=\"{}\"/><BarrierContact planes=\"0 0 -1 {}\" contactDistance=\"{}\" stiffness=\"{}\" "
                           "adhesion=\"{}\" adhesionDistance=\"{}\" keyTimes=\"0 {}\" movements=\"0 0 0  0 0 {}\"/>",
                           all, bottom, -height - first, range, kappa, strength, end, steps, way),
               "", young, 0),
      1, Vec3::Zero(), "<StaticSolver relative_residual_tolerance_threshold=\"1e-9\"/>"));
  const auto tension = [&](double gap) {
    const double pull = gap < range ? strength * gap / range : gap < end ? strength * (end - gap) / (end - range) : 0;
    return pull - kappa * pressureOver(gap / range);
  };
  double largest = 0, last_force = 0;
  for (int i = 1; i <= steps; ++i) {
    expectCleanStep(simulation, i);
    if (HasFatalFailure()) return;
    const double u = way * i / steps;
    const double stretch = rootOf([&](double s) { return tension(first + u - s) - young * s / height; }, -0.01, 0.02);
    const double force = numbersOf(simulation, "wrenches")[2];
    EXPECT_NEAR(force, area * young * stretch / height, 2e-3 * strength) << "step " << i;
    largest = std::max(largest, force), last_force = force;
  }
  EXPECT_NEAR(largest, strength * area, 0.03 * strength * area) << "the steps pass the peak by a part of a step";
  EXPECT_LE(largest, strength * area * (1 + 1e-6));
  EXPECT_NEAR(last_force, 0, 1e-6 * strength) << "it has come off";
}

/// A rigid block that hangs below a plane by adhesion: it stays while its weight is less than adhesion times its area, at the gap of
/// the closed form, and falls freely where it is more.
TEST(Adhesion, HoldsABlockUpToItsStrength) {
  constexpr double range = 0.01, kappa = 1e5, g = 9.81, mass = 100, area = 1;
  const Body box = boxOf(Vec3(-.5, -.5, -.1), Vec3(.5, .5, .1), {2, 2, 1});
  for (const double share : {0.95, 1.05}) {
    const double strength = mass * g / (share * area);
    const auto tension = [&](double gap) { return strength * gap / range - kappa * pressureOver(gap / range); };
    const double rest = share < 1 ? rootOf([&](double gap) { return mass * g - tension(gap) * area; }, 0.1 * range, range) : range;
    Simulation simulation = simulationFromText(contactScene(
        fmt::format(
            "<Node name=\"tool\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"0 0 {}  0 0 0 1\"/><UniformMass "
            "totalMass=\"{}\" inertia=\"10 10 10\"/><Node name=\"skin\">{}<MechanicalObject name=\"dofs\"/><RigidMapping/>"
            "</Node></Node><BarrierContact mstate=\"@tool/skin/dofs\" planes=\"0 0 -1 0\" contactDistance=\"{}\" "
            "stiffness=\"{}\" adhesion=\"{}\" adhesionDistance=\"{}\"/>",
            -0.1 - rest, mass, box.mesh(), range, kappa, strength, 1.5 * range),
        0.005, Vec3(0, 0, -g)));
    const State& frame = *simulation.states()[0];
    for (int i = 0; i < 100; ++i) {
      expectCleanStep(simulation, i, false);
      if (HasFatalFailure()) return;
    }
    const double gap = -frame.x()[0].z() - 0.1;
    if (share < 1) {
      EXPECT_NEAR(gap, rest, 1e-3 * range);
      EXPECT_NEAR(numbersOf(simulation, "wrenches")[2], mass * g, 0.01 * mass * g);
      const std::vector<double> pressures = numbersOf(simulation, "pressures"), areas = numbersOf(simulation, "contactAreas");
      const double pull = std::inner_product(pressures.begin(), pressures.end(), areas.begin(), 0.);
      EXPECT_NEAR(pull, -mass * g, 0.01 * mass * g) << "a tension, not a pressure";
    } else {
      EXPECT_GT(gap, 1.5 * range) << "it has come off";
      EXPECT_LT(frame.v()[0].z(), -1) << "and falls";
    }
  }
}

/// A block on the ground under a weight W = m g and a pull along it. Adhesion a presses it on with W + a, so that it rubs up to
/// mu (W + a); adhesionFriction holds it up to mu_a a as long as it sticks, and lets it go then.
TEST(Adhesion, BearsForcesAlongSurfaces) {
  constexpr double range = 0.01, kappa = 1e5, g = 9.81, mass = 100, area = 1, strength = 1000, dt = 0.004, slip = 1e-5;
  constexpr int n = 100;
  const double gap = rootOf([&](double d) { return kappa * pressureOver(d / range) - strength * d / range - mass * g / area; },
                            0.1 * range, range);
  const double pull = area * strength * gap / range;
  const Body box = boxOf(Vec3(-.5, -.5, -.1), Vec3(.5, .5, .1), {2, 2, 1});
  for (const bool glued : {false, true})
    for (const double share : {0.97, 1.05}) {
      SCOPED_TRACE(fmt::format("glued {}, share {}", glued, share));
      const double holds = glued ? 0.4 * pull : 0.3 * (mass * g + pull);
      Simulation simulation = simulationFromText(contactScene(
          fmt::format(
              "<Node name=\"tool\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"0 0 {}  0 0 0 1\"/><UniformMass "
              "totalMass=\"{}\" inertia=\"10 10 10\"/><PartialFixedProjectiveConstraint indices=\"0\" fixedDirections=\"0 1 0 1 1 "
              "1\"/><Node name=\"skin\">{}<MechanicalObject name=\"dofs\"/><RigidMapping/></Node></Node><BarrierContact "
              "mstate=\"@tool/skin/dofs\" planes=\"0 0 1 0\" contactDistance=\"{}\" stiffness=\"{}\" adhesion=\"{}\" {} "
              "slipVelocity=\"{}\" frictionIterations=\"50\"/>",
              0.1 + gap, mass, box.mesh(), range, kappa, strength, glued ? "adhesionFriction=\"0.4\"" : "friction=\"0.3\"", slip),
          dt, Vec3(share * holds / mass, 0, -g), "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-9\"/>"));
      for (int i = 0; i < n; ++i) {
        expectCleanStep(simulation, i, false);
        if (HasFatalFailure()) return;
      }
      const double way = simulation.states()[0]->x()[0].x(), left = glued ? share * holds : (share - 1) * holds;
      if (share < 1) {
        EXPECT_LT(way, slip * n * dt);
      } else {
        EXPECT_NEAR(way, 0.5 * left / mass * n * (n + 1) * dt * dt, 0.02 * 0.5 * left / mass * n * n * dt * dt);
      }
    }
}

TEST(Adhesion, WhatMakesNoSenseIsRefused) {
  const auto with = [](const std::string& attributes) {
    return problemsOf(contactScene(
        bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)), "<BarrierContact contactDistance=\"0.02\" " + attributes + "/>")));
  };
  expectContains(with("adhesionDistance=\"0.1\""), "adhesion is zero");
  expectContains(with("adhesionFriction=\"0.1\""), "adhesion is zero");
  expectContains(with("adhesion=\"10\" adhesionPeak=\"0.01\""), "adhesionPeak is 0.01 m and contactDistance 0.02 m");
  expectContains(with("adhesion=\"10\" adhesionPeak=\"0.03\" adhesionDistance=\"0.03\""), "adhesionDistance is 0.03 m");
  expectContains(with("friction=\"0.3\" staticFriction=\"0.2\""), "staticFriction is 0.2 and friction 0.3");
  EXPECT_EQ(with("adhesion=\"10\" friction=\"0.3\" staticFriction=\"0.4\""), "");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
