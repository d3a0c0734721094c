// SPDX-License-Identifier: LGPL-2.1-or-later
// Each integrator on linear and cubic oscillators, against the closed form of what the scheme itself does and against
// the motion it approximates.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "tests/support/ground_spring.h"
#include "tests/support/scene_fixture.h"

using namespace stroma;
using namespace stroma::test;

namespace STROMA_TEST_FILE {

constexpr double mass = 0.5, stiffness = 8, omega = 4;  // omega^2 = stiffness / mass

/// One node, tied to the origin, starting at x = (1, 0.5, -2), v = (0, 3, 1).
Simulation oscillator(const std::string& integrator, double dt, const std::string& spring = "",
                      const std::string& massive = "") {
  registerGroundSpring(factory());
  return simulationFromText(fmt::format(
      R"(<Node name="root" dt="{}" gravity="0 0 0">
           {}
           <CGLinearSolver iterations="50" tolerance="1e-15"/>
           <MechanicalObject rest_position="0 0 0" position="1 0.5 -2" velocity="0 3 1"/>
           <UniformMass vertexMass="{}" {}/>
           <TestGroundSpring stiffness="{}" {}/>
         </Node>)",
      dt, integrator, mass, massive, stiffness, spring));
}

Vec3 positionOf(Simulation& simulation) { return simulation.systems()[0]->x[0]; }
Vec3 velocityOf(Simulation& simulation) { return simulation.systems()[0]->v[0]; }

Vec3 exactPosition(double t) {
  return std::cos(omega * t) * Vec3(1, 0.5, -2) + std::sin(omega * t) / omega * Vec3(0, 3, 1);
}

/// |x - exact| at t = 1 with n steps.
double errorAt1(const std::string& integrator, int n) {
  Simulation simulation = oscillator(integrator, 1.0 / n);
  for (int i = 0; i < n; ++i) EXPECT_FALSE(simulation.step().diverged);
  return (positionOf(simulation) - exactPosition(1)).norm();
}

double order(const std::string& integrator) { return std::log2(errorAt1(integrator, 200) / errorAt1(integrator, 400)); }

double energyOf(Simulation& simulation) {
  return mass / 2 * velocityOf(simulation).squaredNorm() + stiffness / 2 * positionOf(simulation).squaredNorm();
}

TEST(Oscillator, OrdersInTime) {
  EXPECT_NEAR(order("<EulerImplicitSolver/>"), 1, 0.05);
  EXPECT_NEAR(order("<EulerImplicitSolver newtonIterations='5'/>"), 1, 0.05);
  EXPECT_NEAR(order("<EulerImplicitSolver trapezoidalScheme='true'/>"), 2, 0.05);
  EXPECT_NEAR(order("<EulerImplicitSolver trapezoidalScheme='true' newtonIterations='5'/>"), 2, 0.05);
  EXPECT_NEAR(order("<EulerExplicitSolver/>"), 1, 0.05);
  EXPECT_NEAR(order("<EulerExplicitSolver symplectic='false'/>"), 1, 0.1);
}

// x + i v / omega turns by a factor that the scheme fixes
TEST(Oscillator, BackwardEulerAmplifiesAsItsClosedForm) {
  for (const char* newton : {"1", "4"}) {
    const double dt = 0.05;
    Simulation simulation = oscillator(fmt::format("<EulerImplicitSolver newtonIterations='{}'/>", newton), dt);
    // backward Euler on z' = -i omega z
    const std::complex<double> factor = 1.0 / (1.0 + std::complex<double>(0, 1) * omega * dt);
    std::complex<double> z[3];
    for (int c = 0; c < 3; ++c) z[c] = {positionOf(simulation)[c], velocityOf(simulation)[c] / omega};
    for (int n = 0; n < 100; ++n) {
      simulation.step();
      for (int c = 0; c < 3; ++c) {
        z[c] *= factor;
        ASSERT_NEAR(positionOf(simulation)[c], z[c].real(), 1e-13);
        ASSERT_NEAR(velocityOf(simulation)[c] / omega, z[c].imag(), 1e-13);
      }
    }
  }
}

TEST(Oscillator, TheTrapezoidalRuleTurnsAtItsOwnFrequencyAndDampsNothing) {
  for (const char* newton : {"1", "4"})
    for (const double dt : {0.01, 0.1, 2.0}) {
      Simulation simulation =
          oscillator(fmt::format("<EulerImplicitSolver trapezoidalScheme='true' newtonIterations='{}'/>", newton), dt);
      const double frequency = 2 / dt * std::atan(omega * dt / 2), energy = energyOf(simulation);
      for (int n = 1; n <= 200; ++n) {
        simulation.step();
        const double phase = frequency * n * dt;
        const Vec3 expected = std::cos(phase) * Vec3(1, 0.5, -2) + std::sin(phase) / omega * Vec3(0, 3, 1);
        ASSERT_LT((positionOf(simulation) - expected).norm(), 2e-11);
      }
      EXPECT_NEAR(energyOf(simulation), energy, 1e-11 * energy);
    }
}

TEST(Oscillator, SymplecticEulerKeepsItsModifiedEnergy) {
  const double dt = 0.1;
  Simulation simulation = oscillator("<EulerExplicitSolver/>", dt);
  // m/2 v^2 + k/2 x^2 - dt k/2 x.v does not change at all
  const auto modified = [&] {
    return energyOf(simulation) - dt * stiffness / 2 * positionOf(simulation).dot(velocityOf(simulation));
  };
  const double before = modified();
  for (int n = 0; n < 2000; ++n) simulation.step();
  EXPECT_NEAR(modified(), before, 1e-10 * before);
}

/// What a method keeps of an oscillator drifts by round-off only: 1e5 steps of 1e-16, all in one direction, are 1e-11.
TEST(Oscillator, EnergyDoesNotDriftOver100000Steps) {
  const double dt = 0.05;
  struct Case {
    std::string integrator;
    double modified;    ///< in dt k/2 x.v
    double square = 0;  ///< in (dt w)^2/4 k/2 x.x
  };
  for (const Case& c : {Case{"<EulerExplicitSolver/>", 1},
                        {"<VariationalSymplecticSolver explicitIntegration='true'/>", 1},
                        {"<VariationalSymplecticSolver/>", 0},
                        {"<TrapezoidalRuleSolver/>", 0},
                        {"<NewmarkImplicitSolver/>", 0},
                        {"<CentralDifferenceSolver/>", 1},
                        {"<NewtonCotesSolver degree='1'/>", 0, 1}}) {
    SCOPED_TRACE(c.integrator);
    Simulation simulation = oscillator(c.integrator, dt);
    const auto kept = [&] {
      const Vec3 x = positionOf(simulation);
      return energyOf(simulation) - c.modified * dt * stiffness / 2 * x.dot(velocityOf(simulation)) -
             c.square * std::pow(dt * omega, 2) / 4 * stiffness / 2 * x.squaredNorm();
    };
    simulation.step();  // central differences start with half of one
    const double before = kept();
    for (int n = 0; n < 100000; ++n) simulation.step();
    EXPECT_NEAR(kept(), before, 1e-10 * before);
  }
}

TEST(Oscillator, ExplicitEulerGainsAndBackwardEulerLosesEnergyAtEachStep) {
  const double dt = 0.02, gain = 1 + omega * omega * dt * dt;
  Simulation growing = oscillator("<EulerExplicitSolver symplectic='false'/>", dt);
  Simulation decaying = oscillator("<EulerImplicitSolver/>", dt);
  for (int n = 0; n < 50; ++n) {
    const double up = energyOf(growing), down = energyOf(decaying);
    growing.step();
    decaying.step();
    ASSERT_NEAR(energyOf(growing) / up, gain, 1e-12);
    ASSERT_NEAR(energyOf(decaying) / down, 1 / gain, 1e-12);
  }
}

// m x'' + (rM m + rK k) x' + k x = 0, from the solver's factors or from each component's own
TEST(Oscillator, RayleighDampingDecaysAsItShould) {
  const double rm = 0.6, rk = 0.05, damping = (rm + rk * omega * omega) / 2;
  const double turning = std::sqrt(omega * omega - damping * damping);
  const Vec3 x0(1, 0.5, -2), v0(0, 3, 1);
  const Vec3 exact = std::exp(-damping) * (std::cos(turning) * x0 + std::sin(turning) / turning * (v0 + damping * x0));
  for (const char* newton : {"1", "5"})
    for (const bool own : {false, true}) {
      const std::string factors = fmt::format("rayleighMass='{}' rayleighStiffness='{}'", rm, rk);
      const auto error = [&](int n) {
        Simulation simulation =
            oscillator(fmt::format("<EulerImplicitSolver trapezoidalScheme='true' newtonIterations='{}' {}/>", newton,
                                   own ? "" : factors),
                       1.0 / n, own ? fmt::format("rayleighStiffness='{}'", rk) : "",
                       own ? fmt::format("rayleighMass='{}'", rm) : "");
        for (int i = 0; i < n; ++i) simulation.step();
        return (positionOf(simulation) - exact).norm();
      };
      EXPECT_LT(error(400), 1e-4);
      EXPECT_NEAR(std::log2(error(100) / error(200)), 2, 0.1);
    }
}

TEST(Oscillator, VdampingShrinksTheVelocityAfterTheStep) {
  Simulation plain = oscillator("<EulerImplicitSolver/>", 0.05),
             damped = oscillator("<EulerImplicitSolver vdamping='3'/>", 0.05);
  plain.step();
  damped.step();
  EXPECT_EQ(positionOf(plain), positionOf(damped));
  EXPECT_LT((velocityOf(damped) - std::exp(-0.15) * velocityOf(plain)).norm(), 1e-15);
}

// m v = -k x: x decays by 1 / (1 + dt k/m) per step, by (1 - a) / (1 + a), a = dt k / 2m, with the trapezoidal rule
TEST(Oscillator, FirstOrderDecaysAsItsClosedForm) {
  const double dt = 0.02, rate = stiffness / mass;
  Simulation euler = oscillator("<EulerImplicitSolver firstOrder='true'/>", dt);
  Simulation trapezoid = oscillator("<EulerImplicitSolver firstOrder='true' trapezoidalScheme='true'/>", dt);
  Vec3 a = positionOf(euler), b = a;
  for (int n = 0; n < 30; ++n) {
    euler.step();
    trapezoid.step();
    a /= 1 + dt * rate;
    b *= (1 - dt * rate / 2) / (1 + dt * rate / 2);
    ASSERT_LT((positionOf(euler) - a).norm(), 1e-14);
    ASSERT_LT((positionOf(trapezoid) - b).norm(), 1e-14);
  }
}

/// A node without mass between two springs of 100 N/m and 1 m, the ends of which are 2.1 m apart: it is in the middle at once, and
/// stays there. The node beside it has a mass and falls.
TEST(Oscillator, NodesWithoutMassAreWhereForcesBalance) {
  const auto scene = [](const std::string& integrator) {
    return fmt::format(R"(<Node name="root" dt="0.01" gravity="0 -10 0"><EulerImplicitSolver {}/><SparseLDLSolver/>
        <MechanicalObject position="0 0 0  1 0 0  2.1 0 0  5 0 0"/><UniformMass vertexMass="2" indices="0 2 3"/>
        <SpringForceField spring="0 1 100 0 1  1 2 100 0 1"/><FixedProjectiveConstraint indices="0 2"/></Node>)",
                       integrator);
  };
  for (const char* more : {"", " newtonIterations='20'"}) {
    Simulation simulation = simulationFromText(scene(std::string("allowMassless='true'") + more));
    for (int step = 1; step <= 3; ++step) {
      ASSERT_FALSE(simulation.step().diverged);
      EXPECT_NEAR((simulation.systems()[0]->x[1] - Vec3(1.05, 0, 0)).norm(), 0, 1e-12) << more << step;
      EXPECT_NEAR(simulation.systems()[0]->v[1][0], step == 1 ? 5 : 0, 1e-10) << more << step;
      EXPECT_NEAR(simulation.systems()[0]->x[3][1], -10 * 1e-4 * step * (step + 1) / 2, 1e-14);
    }
  }
  expectContains(problemsOf(scene("")), "node 1 of /MechanicalObject has a mass of 0 kg");
  expectContains(problemsOf(scene("allowMassless='true' trapezoidalScheme='true'")), "would oscillate forever");
}

TEST(CubicOscillator, NewtonSolvesTheStepsEquations) {
  const double dt = 0.1, cubic = 30;
  for (const bool trapezoidal : {false, true}) {
    Simulation simulation = oscillator(
        fmt::format("<EulerImplicitSolver newtonIterations='30' newtonTolerance='1e-13' trapezoidalScheme='{}'/>",
                    trapezoidal),
        dt, fmt::format("cubic='{}'", cubic));
    const auto force = [&](const Vec3& x) { return Vec3(-(stiffness + cubic * x.squaredNorm()) * x); };
    for (int n = 0; n < 40; ++n) {
      const Vec3 x0 = positionOf(simulation), v0 = velocityOf(simulation);
      const StepReport report = simulation.step();
      ASSERT_TRUE(report.newton_converged) << report.reason;
      ASSERT_GE(report.newton_iterations, 2);
      ASSERT_LE(report.newton_iterations, 12);
      const Vec3 x1 = positionOf(simulation), v1 = velocityOf(simulation);
      const double theta = trapezoidal ? 0.5 : 1;
      ASSERT_LT((x1 - x0 - dt * (theta * v1 + (1 - theta) * v0)).norm(), 1e-14);
      ASSERT_LT((mass * (v1 - v0) - dt * (theta * force(x1) + (1 - theta) * force(x0))).norm(), 1e-10);
    }
  }
}

TEST(CubicOscillator, OneNewtonIterationIsTheLinearStep) {
  Simulation linear = oscillator("<EulerImplicitSolver/>", 0.05, "cubic='3'");
  Simulation newton =
      oscillator("<EulerImplicitSolver newtonIterations='2' newtonTolerance='0.9'/>", 0.05, "cubic='3'");
  linear.step();
  EXPECT_EQ(newton.step().newton_iterations, 1);
  EXPECT_LT((positionOf(linear) - positionOf(newton)).norm(), 1e-14);
  EXPECT_LT((velocityOf(linear) - velocityOf(newton)).norm(), 1e-13);
}

TEST(CubicOscillator, ADoubleWellWithHugeStepsStillConverges) {
  Simulation simulation = oscillator("<EulerImplicitSolver newtonIterations='100'/>", 10, "cubic='40'");
  for (int n = 0; n < 20; ++n) {
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.diverged) << report.reason;
    EXPECT_TRUE(report.newton_converged) << report.reason;
  }
  EXPECT_LT(positionOf(simulation).norm(), 1e-3);
}

/// By positions a step goes on with a momentum of its own. What changes the velocity between steps changes it too; one iteration
/// does not know whether it was enough.
TEST(Oscillator, StepsByPositionsHeedVelocitiesThatOthersChange) {
  constexpr double h = 0.05;
  Simulation simulation = oscillator("<VariationalSymplecticSolver byPositions='true' newtonError='1e-12'/>", h);
  const Vec3 kick(0.5, -1, 2);
  Vec3 x(1, 0.5, -2), v(0, 3, 1), p = mass * v;
  for (int n = 0; n < 20; ++n) {
    if (n == 10) simulation.systems().at(0)->v[0] += kick, p += mass * kick;
    const Vec3 r = (2 / h * p - stiffness * x) / (4 / (h * h) * mass + stiffness);
    v = 2 / h * r, p = mass * v - h / 2 * stiffness * (x + r), x += h * v;
    EXPECT_TRUE(simulation.step().newton_converged);
    ASSERT_LT((positionOf(simulation) - x).norm() + (velocityOf(simulation) - v).norm(), 1e-11) << n;
  }
  Simulation hasty = oscillator("<VariationalSymplecticSolver byPositions='true' newtonError='1e-12' steps='1'/>", h);
  EXPECT_FALSE(hasty.step().newton_converged);
}

/// A step by positions would let what hangs on a driven node follow a step late: such scenes keep the midpoint rule.
TEST(Oscillator, NodesThatAreDrivenAreNotSteppedByPositions) {
  registerGroundSpring(factory());
  const auto end = [](const std::string& by_positions) {
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node dt="0.01" gravity="0 0 0"><VariationalSymplecticSolver newtonError="1e-10" byPositions="{}"/><SparseLDLSolver/>
        <MechanicalObject position="0 0 0  1 0 0"/><UniformMass vertexMass="1"/><TestGroundSpring stiffness="0" couple="50"/>
        <LinearMovementProjectiveConstraint indices="0" keyTimes="0 1" movements="0 0 0  1 0 0"/></Node>)", by_positions));
    for (int n = 0; n < 30; ++n) EXPECT_FALSE(simulation.step().failed());
    return Vec3(simulation.systems()[0]->x[1]);
  };
  const Vec3 expected = end("false");
  EXPECT_GT(expected.x(), 1.1);
  EXPECT_EQ((end("true") - expected).norm(), 0);
}

TEST(Oscillator, ATwistThatIsNotConservativeNeedsADirectSolver) {
  registerGroundSpring(factory());
  const char* text = R"(<Node name="root" dt="0.05" gravity="0 0 0">
    <EulerImplicitSolver newtonIterations="{}"/> <{}/>
    <MechanicalObject rest_position="0 0 0" position="1 0 0"/> <UniformMass vertexMass="1"/>
    <TestGroundSpring stiffness="4" twist="0.5"/> </Node>)";
  EXPECT_NE(problemsOf(fmt::format(fmt::runtime(text), 1, "CGLinearSolver")).find("symmetric"), std::string::npos);
  for (const int newton : {1, 5}) {
    Simulation simulation = simulationFromText(fmt::format(fmt::runtime(text), newton, "SparseLDLSolver"));
    // z = x + i y obeys z'' = (-4 + 0.5 i) z; backward Euler's step in z and v
    const std::complex<double> k(-4, 0.5);
    std::complex<double> z(1, 0), v(0, 0);
    for (int n = 0; n < 20; ++n) {
      ASSERT_FALSE(simulation.step().diverged);
      v = (v + 0.05 * k * z) / (1.0 - 0.05 * 0.05 * k);
      z += 0.05 * v;
      ASSERT_NEAR(positionOf(simulation)[0], z.real(), 1e-12);
      ASSERT_NEAR(positionOf(simulation)[1], z.imag(), 1e-12);
    }
  }
}

}  // namespace STROMA_TEST_FILE
