// SPDX-License-Identifier: LGPL-2.1-or-later
// The order in time of every integrator, measured on motions whose solution is known in closed form or integrated
// beside it with steps a hundred times shorter.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>

#include "tests/support/ground_spring.h"
#include "tests/support/scene_fixture.h"

using namespace stroma;
using namespace stroma::test;

namespace STROMA_TEST_FILE {

constexpr double mass = 0.5, stiffness = 8, omega = 4;  // omega^2 = stiffness / mass
const Vec3 x0(1, 0.5, -2), v0(0, 3, 1);

Simulation motion(const std::string& integrator, double dt, const std::string& spring,
                  const Vec3& gravity = {0, 0, 0}) {
  registerGroundSpring(factory());
  return simulationFromText(fmt::format(
      R"(<Node name="root" dt="{}" gravity="{} {} {}">
           {} <CGLinearSolver iterations="50" tolerance="1e-15"/>
           <MechanicalObject rest_position="0 0 0" position="1 0.5 -2" velocity="0 3 1"/>
           <UniformMass vertexMass="{}"/> <TestGroundSpring {}/>
         </Node>)",
      dt, gravity[0], gravity[1], gravity[2], integrator, mass, spring));
}

/// At t = 1 after n steps: of x, and of v / omega where `has_velocity`.
double errorAt1(const std::string& integrator, const std::string& spring, int n, const Vec3& x1, const Vec3& v1,
                bool has_velocity) {
  Simulation simulation = motion(integrator, 1.0 / n, spring);
  for (int i = 0; i < n; ++i) {
    const StepReport report = simulation.step();
    EXPECT_FALSE(report.diverged) << integrator << ": " << report.reason;
    EXPECT_TRUE(report.newton_converged) << integrator << ": " << report.reason;
  }
  const double of_v = has_velocity ? (simulation.systems()[0]->v[0] - v1).norm() / omega : 0;
  return std::hypot((simulation.systems()[0]->x[0] - x1).norm(), of_v);
}

struct Case {
  std::string integrator;
  double order;
  bool has_velocity = true;  ///< v belongs to the end of the step
  int steps = 200;
};

const std::vector<Case> cases{
    {"<EulerImplicitSolver/>", 1},
    {"<EulerImplicitSolver newtonIterations='20'/>", 1},
    {"<EulerImplicitSolver trapezoidalScheme='true'/>", 2},
    {"<TrapezoidalRuleSolver/>", 2},
    {"<TrapezoidalRuleSolver newtonIterations='20'/>", 2},
    {"<NewmarkImplicitSolver/>", 2},
    {"<NewmarkImplicitSolver newtonIterations='20'/>", 2},
    {"<NewmarkImplicitSolver beta='0.16666666666666666'/>", 2},
    {"<NewmarkImplicitSolver gamma='0.7' beta='0.4'/>", 1},
    {"<BDFOdeSolver/>", 1},
    {"<BDFOdeSolver order='2'/>", 2},
    {"<BDFOdeSolver order='2' newtonIterations='20'/>", 2},
    {"<VariationalSymplecticSolver/>", 2},
    {"<EulerExplicitSolver/>", 1},
    {"<EulerExplicitSolver symplectic='false'/>", 1},
    {"<VariationalSymplecticSolver explicitIntegration='true'/>", 1},
    {"<CentralDifferenceSolver/>", 2, false},
    {"<RungeKutta2Solver/>", 2},
    {"<RungeKutta4Solver/>", 4, true, 50},
    {"<NewtonCotesSolver degree='1'/>", 2},
    {"<NewtonCotesSolver degree='2'/>", 4, true, 50},
    {"<NewtonCotesSolver degree='3'/>", 4, true, 50},
    {"<NewtonCotesSolver degree='4'/>", 5, true, 100},
};

void expectOrder(const Case& c, const std::string& spring, const Vec3& x1, const Vec3& v1) {
  const double coarse = errorAt1(c.integrator, spring, c.steps, x1, v1, c.has_velocity);
  const double fine = errorAt1(c.integrator, spring, 2 * c.steps, x1, v1, c.has_velocity);
  EXPECT_NEAR(std::log2(coarse / fine), c.order, 0.15) << c.integrator << ": errors " << coarse << ' ' << fine;
}

/// m x'' = force(t, x, v) by the classical Runge-Kutta method, written out here.
std::pair<Vec3, Vec3> integrate(const std::function<Vec3(double, const Vec3&, const Vec3&)>& force) {
  const int n = 20000;
  const double h = 1.0 / n;
  Vec3 x = x0, v = v0;
  const auto a = [&](double t, const Vec3& y, const Vec3& w) { return Vec3(force(t, y, w) / mass); };
  for (int i = 0; i < n; ++i) {
    const double t = i * h;
    const Vec3 a1 = a(t, x, v), v2 = v + h / 2 * a1, a2 = a(t + h / 2, x + h / 2 * v, v2), v3 = v + h / 2 * a2;
    const Vec3 a3 = a(t + h / 2, x + h / 2 * v2, v3), v4 = v + h * a3, a4 = a(t + h, x + h * v3, v4);
    x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return {x, v};
}

std::string spring(const std::string& more = "") { return fmt::format("stiffness='{}' {}", stiffness, more); }

TEST(Orders, Oscillator) {
  const Vec3 x1 = std::cos(omega) * x0 + std::sin(omega) / omega * v0;
  const Vec3 v1 = std::cos(omega) * v0 - std::sin(omega) * omega * x0;
  for (const Case& c : cases) expectOrder(c, spring(), x1, v1);
}

TEST(Orders, OscillatorWithADamperThatIsAForce) {
  const double b = 1.2, decay = b / (2 * mass), turning = std::sqrt(omega * omega - decay * decay);
  const Vec3 w = (v0 + decay * x0) / turning;
  const Vec3 x1 = std::exp(-decay) * (std::cos(turning) * x0 + std::sin(turning) * w);
  const Vec3 v1 = -decay * x1 + std::exp(-decay) * turning * (std::cos(turning) * w - std::sin(turning) * x0);
  for (Case c : cases) {
    // methods that evaluate the force with the velocity of another time
    if (c.integrator.find("CentralDifference") != std::string::npos) c.order = 1;
    expectOrder(c, spring(fmt::format("damping='{}'", b)), x1, v1);
  }
}

TEST(Orders, NonlinearSpringPushedOverTime) {
  const double cubic = 1.5;
  const Vec3 push(0.5, -1, 2);
  const auto [x1, v1] = integrate([&](double t, const Vec3& x, const Vec3&) {
    return Vec3(-(stiffness + cubic * x.squaredNorm()) * x + std::cos(7 * t) * push);
  });
  for (const Case& c : cases)
    expectOrder(c, spring(fmt::format("cubic='{}' push='0.5 -1 2' push_rate='7'", cubic)), x1, v1);
}

// m y'' = -k (y - u) - c (y' - u'), u = A sin(w t): a spring and a damper whose other end is moved; methods with stages
// see its place and velocity at each
TEST(Orders, SpringWhoseOtherEndIsMoved) {
  const double swing = 0.3, rate = 5;
  const auto [text, expected] = std::tuple(
      R"(<Node name="root" dt="{}" gravity="0 0 0"> {} <CGLinearSolver iterations="50" tolerance="1e-15"/>
           <MechanicalObject position="0 0 0  1 0 0" velocity="{} 0 0  0 0 0"/> <UniformMass vertexMass="{}"/>
           <OscillatorProjectiveConstraint oscillators="0  0 0 0  {} 0 0  {} 0"/>
           <SpringForceField springsIndices1="0" springsIndices2="1" lengths="1" stiffness="{}" damping="{}"/>
         </Node>)",
      [=](double damping) {
        const std::complex<double> i(0, 1), driven = stiffness + i * damping * rate;
        const std::complex<double> moved = swing * driven / (driven - mass * rate * rate);
        const double decay = damping / (2 * mass), turning = std::sqrt(omega * omega - decay * decay);
        const double a = -moved.imag(), b = (-rate * moved.real() + decay * a) / turning;
        const std::complex<double> forced = moved * std::exp(i * rate);
        const double c = std::cos(turning), s = std::sin(turning), e = std::exp(-decay);
        return std::pair(forced.imag() + e * (a * c + b * s),
                         rate * forced.real() + e * (turning * (b * c - a * s) - decay * (a * c + b * s)));
      });
  for (const double damping : {0., 1.2})
    for (Case c : cases) {
      // the damper sees the velocity of the middle of a step, or of what is moved its mean over the step
      for (const char* method : {"CentralDifference", "Newmark", "BDFOdeSolver"})
        if (damping > 0 && c.integrator.find(method) != std::string::npos) c.order = 1;
      const auto [y, speed] = expected(damping);
      const auto errorAfter = [&, text = text, y = y, speed = speed](int n) {
        Simulation simulation = simulationFromText(fmt::format(fmt::runtime(text), 1.0 / n, c.integrator, swing * rate,
                                                               mass, swing, rate, stiffness, damping));
        for (int step = 0; step < n; ++step) EXPECT_FALSE(simulation.step().diverged);
        const System& system = *simulation.systems()[0];
        return std::hypot(system.x[1].x() - 1 - y, c.has_velocity ? (system.v[1].x() - speed) / omega : 0);
      };
      const double coarse = errorAfter(c.steps), fine = errorAfter(2 * c.steps), order = std::log2(coarse / fine);
      std::printf("%-60s damping %.1f: order %.2f, errors %.2e %.2e\n", c.integrator.c_str(), damping, order, coarse,
                  fine);
      EXPECT_NEAR(order, c.order, 0.15) << c.integrator << " damping " << damping << ": errors " << coarse << ' '
                                        << fine;
    }
}

// the moved end turns around at once between two steps: each sees the velocity of its own piece
TEST(Orders, MotionWhoseVelocityJumpsBetweenSteps) {
  const auto placeAfter = [](int n) {
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="{}" gravity="0 0 0"> <RungeKutta4Solver/>
             <MechanicalObject position="0 0 0  1 0 0"/> <UniformMass vertexMass="{}"/>
             <LinearMovementProjectiveConstraint indices="0" keyTimes="0 0.4 1" movements="0 0 0  0.3 0 0  -0.2 0 0"/>
             <SpringForceField springsIndices1="0" springsIndices2="1" lengths="1" stiffness="{}" damping="1.2"/>
           </Node>)",
        1.0 / n, mass, stiffness));
    for (int step = 0; step < n; ++step) EXPECT_FALSE(simulation.step().diverged);
    return simulation.systems()[0]->x[1].x();
  };
  const double exact = placeAfter(2000), coarse = placeAfter(20) - exact, fine = placeAfter(40) - exact;
  EXPECT_NEAR(std::log2(coarse / fine), 4, 0.2) << coarse << ' ' << fine;
}

// a body that turns about a point: m r W^2 = (k + c r^2) r in a plane
TEST(Orders, SpinningBody) {
  const double cubic = 1.5, rate = std::sqrt((stiffness + cubic) / mass);
  const auto errorAfter = [&](const Case& c, int n) {
    registerGroundSpring(factory());
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="{}" gravity="0 0 0"> {} <CGLinearSolver iterations="50" tolerance="1e-15"/>
             <MechanicalObject rest_position="0 0 0" position="1 0 0" velocity="0 {} 0"/> <UniformMass vertexMass="{}"/>
             <TestGroundSpring stiffness="{}" cubic="{}"/> </Node>)",
        1.0 / n, c.integrator, rate, mass, stiffness, cubic));
    for (int i = 0; i < n; ++i) EXPECT_FALSE(simulation.step().diverged);
    return (simulation.systems()[0]->x[0] - Vec3(std::cos(rate), std::sin(rate), 0)).norm();
  };
  for (const Case& c : cases)
    EXPECT_NEAR(std::log2(errorAfter(c, c.steps) / errorAfter(c, 2 * c.steps)), c.order, 0.15) << c.integrator;
}

// x0 + v0 t + g t^2 / 2: exact for methods of second order and for Newmark's, whose acceleration is constant here; the
// others miss by h/2 g t one way or the other
TEST(Orders, FallingBody) {
  const Vec3 g(0, -9.81, 0), exact = x0 + v0 + g / 2;
  const int n = 40;
  for (const Case& c : cases) {
    Simulation simulation = motion(c.integrator, 1.0 / n, "", g);
    for (int i = 0; i < n; ++i) simulation.step();
    const double error = (simulation.systems()[0]->x[0] - exact).norm();
    const bool is_newmark = c.integrator.find("Newmark") != std::string::npos;
    const double expected = c.order > 1 || is_newmark ? 0 : 0.5;
    EXPECT_NEAR(error, expected * 9.81 / n, 1e-10) << c.integrator;
    if (!c.has_velocity) continue;
    EXPECT_LT((simulation.systems()[0]->v[0] - v0 - g).norm(), 1e-12) << c.integrator;
  }
}

// m x'' = f + rK K(x) v - rM m v with the K of each moment: a stiffness held at the start of a step would cost an order
TEST(Orders, RayleighDampingOfANonlinearSpring) {
  const double cubic = 1.5, rm = 0.4, rk = 0.02;
  const auto [x1, v1] = integrate([&](double, const Vec3& x, const Vec3& v) {
    const Vec3 kv = -(stiffness + cubic * x.squaredNorm()) * v - 2 * cubic * x * x.dot(v);
    return Vec3(-(stiffness + cubic * x.squaredNorm()) * x + rk * kv - rm * mass * v);
  });
  const std::string factors = fmt::format("rayleighMass='{}' rayleighStiffness='{}'", rm, rk);
  for (const Case& c : std::vector<Case>{
           {fmt::format("<EulerImplicitSolver newtonIterations='20' {}/>", factors), 1},
           {fmt::format("<TrapezoidalRuleSolver newtonIterations='20' {}/>", factors), 2},
           {fmt::format("<NewmarkImplicitSolver newtonIterations='20' {}/>", factors), 2},
           {fmt::format("<BDFOdeSolver order='2' newtonIterations='20' {}/>", factors), 2},
           {fmt::format("<VariationalSymplecticSolver {}/>", factors), 2},
       })
    expectOrder(c, spring(fmt::format("cubic='{}'", cubic)), x1, v1);
}

TEST(Orders, CentralDifferencesDampByTheMassWithoutLosingTheirOrder) {
  const double rm = 1.3, decay = rm / 2, turning = std::sqrt(omega * omega - decay * decay);
  const Vec3 x1 = std::exp(-decay) * (std::cos(turning) * x0 + std::sin(turning) / turning * (v0 + decay * x0));
  expectOrder({fmt::format("<CentralDifferenceSolver rayleighMass='{}'/>", rm), 2, false}, spring(), x1, {});
}

}  // namespace STROMA_TEST_FILE
