// SPDX-License-Identifier: LGPL-2.1-or-later
// Two coefficients of friction: what sticks has the larger one, and what slides goes on with the smaller.
#include <Eigen/Geometry>
#include <cmath>

#include "framework/mechanics/step_limiter.h"
#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double dt = 0.004, slip_velocity = 1e-5;

/// A rigid block on a plane with tan q = `slope`, which is let go with `velocity` at the gap of its weight.
Simulation blockOnSlope(const char* contact, double slope, double mu_static, double mu, double velocity) {
  const double c = 1 / std::sqrt(1 + slope * slope), s = slope * c, mass = 100, range = 0.01, kappa = 100 * mass * 9.81 * c;
  const Body box = boxOf(Vec3(-.5, -.5, -.1), Vec3(.5, .5, .1));
  const double rest = std::string(contact) == "PenaltyContact" ? 0.99 : 0.9434;
  return simulationFromText(contactScene(
      fmt::format(
          "<Node name=\"tool\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"0 0 {}  0 0 0 1\" "
          "velocity=\"{} 0 0  0 0 0\"/><UniformMass totalMass=\"{}\" inertia=\"10 10 10\"/><PartialFixedProjectiveConstraint "
          "indices=\"0\" fixedDirections=\"0 1 0 1 1 1\"/><Node name=\"skin\">{}<MechanicalObject name=\"dofs\"/><RigidMapping/>"
          "</Node></Node><{} mstate=\"@tool/skin/dofs\" planes=\"0 0 1 0\" contactDistance=\"{}\" stiffness=\"{}\" "
          "friction=\"{}\" staticFriction=\"{}\" slipVelocity=\"{}\"/>",
          0.1 + rest * range, velocity, mass, box.mesh(), contact, range, kappa, mu, mu_static, slip_velocity),
      dt, 9.81 * Vec3(s, 0, -c), "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-9\"/>"));
}

/// The way and the speed after n steps.
std::pair<double, double> after(Simulation& simulation, int n) {
  for (int i = 0; i < n; ++i) {
    expectCleanStep(simulation, i, false);
    if (::testing::Test::HasFatalFailure()) break;
  }
  const State& frame = *simulation.states()[0];
  return {frame.x()[0].x(), frame.v()[0].x()};
}

/// tan q = 0.5. Below the static coefficient it stays, whatever the other one is; above, it goes 1/2 g (sin q - mu cos q) t^2 with the
/// kinetic one; and what slides goes on although it would stick if it stood.
TEST(StaticFriction, WhatSticksStaysAndWhatSlidesAccelerates) {
  const double c = 1 / std::sqrt(1.25), s = 0.5 * c, a = 9.81 * (s - 0.3 * c);
  constexpr int n = 150;
  const double parabola = 0.5 * a * n * (n + 1) * dt * dt;
  for (const char* contact : {"BarrierContact", "PenaltyContact"}) {
    SCOPED_TRACE(contact);
    Simulation stays = blockOnSlope(contact, 0.5, 0.505, 0.3, 0);
    const auto [creep, creep_speed] = after(stays, n);
    EXPECT_LT(creep, slip_velocity * n * dt * 1.5);
    EXPECT_LT(creep_speed, slip_velocity);
    Simulation slides = blockOnSlope(contact, 0.5, 0.49, 0.3, 0);
    // a penalty knows of a slip when the next step begins
    const double off = std::string(contact) == "PenaltyContact" ? 0.02 : 0.01;
    EXPECT_NEAR(after(slides, n).first, parabola, off * parabola);
    Simulation goes_on = blockOnSlope(contact, 0.5, 0.6, 0.3, 0.1);
    EXPECT_NEAR(after(goes_on, n).first, parabola + 0.1 * n * dt, off * parabola);
  }
}

/// tan q = 0.5. A block that is sent up stops after v^2/(2 g (sin q + mu cos q)) with the kinetic coefficient, and stays there with
/// the static one, though the kinetic one would let it slide back.
TEST(StaticFriction, WhatStopsSticks) {
  const double c = 1 / std::sqrt(1.25), s = 0.5 * c, deceleration = 9.81 * (s + 0.3 * c), way = 0.5 * 0.5 / (2 * deceleration);
  for (const char* contact : {"BarrierContact", "PenaltyContact"}) {
    SCOPED_TRACE(contact);
    Simulation simulation = blockOnSlope(contact, 0.5, 0.6, 0.3, -0.5);
    const auto [end, speed] = after(simulation, int(std::lround(2 * 0.5 / deceleration / dt)));
    EXPECT_NEAR(-end, way, 0.02 * way + 0.5 * dt);
    EXPECT_LT(std::abs(speed), slip_velocity);
  }
}

/// A staticFriction that is not given is friction. One that is written and smaller is refused, and 0 is written like any other.
TEST(StaticFriction, AWrittenZeroIsZero) {
  for (const char* contact : {"BarrierContact", "PenaltyContact"}) {
    const auto load = [&](const std::string& coefficients) {
      const Body box = boxOf(Vec3(0, 0, 0.01), Vec3(1, 1, 1.01));
      FieldUnderTest t(contactScene(bodyNode("a", box, fmt::format("<{} contactDistance=\"0.02\" planes=\"0 0 1 0\" {}/>", contact,
                                                                   coefficients))),
                       contact);
      return t.field().data().find("staticFriction")->print();
    };
    EXPECT_EQ(load("friction=\"0.3\""), "0.3");
    EXPECT_EQ(load("friction=\"0.3\" staticFriction=\"0.4\""), "0.4");
    EXPECT_EQ(load("staticFriction=\"0\""), "0");
    EXPECT_EQ(load(""), "0");
    for (const char* less : {"0", "0.2"}) {
      SCOPED_TRACE(less);
      const std::string problems = problemsIn([&] { load(fmt::format("friction=\"0.3\" staticFriction=\"{}\"", less)); });
      EXPECT_NE(problems.find(fmt::format("staticFriction is {} and friction 0.3", less)), std::string::npos) << problems;
    }
  }
}

/// In a solve the coefficient stays what it was, so that friction has a potential there: its tangent is the derivative of its force.
TEST(StaticFriction, HasOnePotentialInASolve) {
  for (const double slip : {0.4, 1.5, 3.0}) {
    FieldUnderTest t(
        contactScene(bodyNode("a", boxOf(Vec3(0, 0, 0.01), Vec3(1, 1, 1.01)),
                              "<BarrierContact contactDistance=\"0.02\" planes=\"0 0 1 0\" friction=\"0.3\" "
                              "staticFriction=\"0.5\" slipVelocity=\"0.01\" adhesion=\"1e4\" adhesionFriction=\"0.2\"/>")),
        "BarrierContact");
    auto& limiter = dynamic_cast<StepLimiter&>(t.field());
    limiter.stepBegins(t.x, 0, 1);
    limiter.wantStartForces(true, 1);  // nothing is held
    for (Index i = 0; i < t.x.count(); ++i) t.x[i] += slip * 0.01 * Vec3(0.8, 0.6, 0);
    EXPECT_LT(relativeDifference(t.differenceOfForces(1e-8), t.product(t.direction)), 1e-5) << "slip " << slip;
    expectSymmetricProducts(t);
    expectMatrixOfProducts(t);
  }
}

/// Whether what slides has been let go is asked at the next step: a run in explicit steps goes on from a checkpoint to the bit.
TEST(StaticFriction, ExplicitStepsGoOnFromACheckpoint) {
  const auto make = [] {
    return simulationFromText(contactScene(
        "<Node name=\"a\"><MeshTopology name=\"mesh\" position=\"0 0 0.019722  1 0 0.019722  0 1 0.019722\" triangles=\"0 1 2\"/>"
        "<MechanicalObject velocity=\"0.005 0 0  0.005 0 0  0.005 0 0\"/><UniformMass totalMass=\"3\"/><BarrierContact "
        "contactDistance=\"0.02\" stiffness=\"1e5\" selfContact=\"0\" planes=\"0 0 1 0\" friction=\"0.3\" "
        "staticFriction=\"0.6\" slipVelocity=\"0.02\"/></Node>",
        5e-4, Vec3(7, 0, -9.81), "<EulerExplicitSolver/>"));
  };
  Simulation whole = make(), half = make();
  const auto run = [](Simulation& simulation, int n) {
    for (int i = 0; i < n; ++i) ASSERT_FALSE(simulation.step().diverged);
  };
  for (const int first : {2, 6, 8}) {
    run(half, first), run(whole, first);
    Simulation rest = make();
    rest.restore(half.checkpoint());
    for (int i = 0; i < 5; ++i) {
      run(whole, 1), run(rest, 1);
      ASSERT_EQ(Vec3(rest.systems()[0]->v[0]), Vec3(whole.systems()[0]->v[0])) << i << " after " << first;
    }
    run(half, 5);
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
