// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces of constraint in each integrator that finds them: orders against the equation of the pendulum, impulses, momentum.
#include <utility>

#include "tests/lagrangian/lagrangian_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using namespace lagrangian;

const std::vector<std::string> integrators = {"<EulerImplicitSolver {}/>", "<EulerImplicitSolver trapezoidalScheme=\"1\" {}/>",
                                              "<TrapezoidalRuleSolver {}/>", "<BDFOdeSolver {}/>",
                                              "<BDFOdeSolver order=\"2\" {}/>"};

std::string with(const std::string& integrator, const std::string& attributes = "") {
  return fmt::format(fmt::runtime(integrator), attributes);
}

/// A point at the end of a link of 1 m that is held at its other end, at the angle `start` from hanging.
std::string pendulum(const std::string& integrator, double dt, double start, const std::string& velocity = "") {
  return sceneOf(
      fmt::format("<MechanicalObject name=\"dofs\" position=\"0 0 0  {:.17g} {:.17g} 0\" {}/><UniformMass vertexMass=\"2\"/>"
                  "<FixedProjectiveConstraint indices=\"0\"/><DistanceLagrangianConstraint name=\"link\" first_point=\"0\" "
                  "second_point=\"1\"/>",
                  std::sin(start), -std::cos(start), velocity),
      dt, velocity.empty() ? "0 -10 0" : "0 0 0", integrator);
}

/// theta'' = -g sin theta from rest, by steps of 1e-5 s of the rule of Runge and Kutta.
double angleAfter(double t, double theta) {
  double w = 0;
  const double h = 1e-5;
  for (long i = 0; i < std::lround(t / h); ++i) {
    const auto f = [](double a) { return -g * std::sin(a); };
    const double k1 = w, l1 = f(theta), k2 = w + h / 2 * l1, l2 = f(theta + h / 2 * k1), k3 = w + h / 2 * l2,
                 l3 = f(theta + h / 2 * k2), k4 = w + h * l3, l4 = f(theta + h * k3);
    theta += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), w += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
  }
  return theta;
}

TEST(LagrangianIntegrators, APendulumHasTheOrderOfItsIntegrator) {
  constexpr double start = 1, end = 0.8;
  const double exact = angleAfter(end, start);
  for (const std::string& integrator : integrators) {
    SCOPED_TRACE(integrator);
    std::vector<double> errors;
    for (const double dt : {0.01, 0.005, 0.0025}) {
      Simulation simulation = simulationFromText(pendulum(with(integrator), dt, start));
      for (int i = 0; i < std::lround(end / dt); ++i) {
        run(simulation, 1);
        if (HasFatalFailure()) return;
        ASSERT_NEAR(at(simulation, 1).norm(), 1, 1e-10);
      }
      errors.push_back(std::abs(std::atan2(at(simulation, 1).x(), -at(simulation, 1).y()) - exact));
    }
    const bool second = integrator.find("rapezoidal") != std::string::npos || integrator.find("order=") != std::string::npos;
    EXPECT_GT(errors[0], 1e-8) << "something is measured";
    EXPECT_NEAR(std::log2(errors[1] / errors[2]), second ? 2 : 1, 0.25) << errors[0] << " " << errors[1] << " " << errors[2];
    EXPECT_LT(errors[2], second ? 1e-4 : 2e-2);
  }
}

/// Round and round without gravity: the trapezoidal rule keeps the speed to round-off, v^2 m / L is the force.
TEST(LagrangianIntegrators, TheTrapezoidalRuleKeepsTheSpeedOfWhatTurns) {
  for (const char* integrator : {"<TrapezoidalRuleSolver/>", "<EulerImplicitSolver trapezoidalScheme=\"1\"/>"}) {
    Simulation simulation = simulationFromText(pendulum(integrator, 0.001, 0, "velocity=\"0 0 0  3 0 0\""));
    run(simulation, 1000);
    EXPECT_NEAR(simulation.states()[0]->v()[1].norm(), 3, 1e-9);
    EXPECT_NEAR(std::abs(numbersOf(simulation, "DistanceLagrangianConstraint", "forces").at(0)), 2 * 9, 1e-3);
  }
}

/// With what is held by a constraint: the change of momentum is the impulse of gravity and of the force that is read.
TEST(LagrangianIntegrators, MomentumChangesByTheForcesThatAreRead) {
  for (const std::string& integrator : integrators) {
    SCOPED_TRACE(integrator);
    for (const char* newton : {"", "newtonIterations=\"20\" newtonTolerance=\"1e-13\""}) {
      Simulation simulation = simulationFromText(
          sceneOf(chain(5, 5, 1) + "<FixedLagrangianConstraint indices=\"0\"/>", 0.01, "0 -10 0", with(integrator, newton)));
      const auto momentum = [&] {
        Vec3 sum = Vec3::Zero();
        for (Index i = 0; i < 6; ++i) sum += 0.5 * simulation.states()[0]->v()[i];
        return sum;
      };
      Vec3 change = Vec3::Zero();
      for (int i = 0; i < 60; ++i) {
        const Vec3 before = momentum();
        run(simulation, 1);
        if (HasFatalFailure()) return;
        for (Index k = 0; k < 5; ++k) ASSERT_NEAR((at(simulation, k + 1) - at(simulation, k)).norm(), 1, 1e-10);
        ASSERT_LT(at(simulation, 0).norm(), 1e-10);
        const std::vector<double> force = numbersOf(simulation, "FixedLagrangianConstraint", "forces");
        const Vec3 last = std::exchange(change, momentum() - before);
        // BDF of order 2 after its first step, which is trapezoidal: p1 - p0 - (p0 - p_-1)/3 = 2/3 h F
        const bool has_history = integrator.find("order=") != std::string::npos && i > 0;
        const Vec3 impulse = 0.01 * (3 * Vec3(0, -10, 0) + Vec3(force[0], force[1], force[2]));
        const Vec3 expected = has_history ? Vec3(last / 3 + 2. / 3 * impulse) : impulse;
        ASSERT_LT((change - expected).norm(), 1e-10) << "step " << i;
      }
    }
  }
}

/// A force that is given acts with its whole weight, whatever the rule: 10 N on a spring of 100 N/m.
TEST(LagrangianIntegrators, AGivenForceActsWhole) {
  for (const std::string& integrator : integrators)
    for (const char* newton : {"", " newtonIterations=\"10\""}) {
      SCOPED_TRACE(integrator + newton);
      Simulation simulation = simulationFromText(sceneOf(
          "<MechanicalObject position=\"1 0 0\"/><UniformMass totalMass=\"1\"/><RestShapeSpringsForceField stiffness=\"100\"/>"
          "<CableConstraint indices=\"0\" pullPoint=\"-1 0 0\" valueType=\"force\" value=\"10\"/>",
          0.02, "0 0 0", with(integrator, std::string("rayleighMass=\"20\"") + newton)));
      run(simulation, 400);
      EXPECT_NEAR(at(simulation, 0).x(), 0.9, 1e-8);
      EXPECT_NEAR(numbersOf(simulation, "CableConstraint", "force").at(0), 10, 1e-9);
    }
}

/// Positions that move by the whole new velocity, as SOFA's trapezoidal scheme does: conditions hold for these.
TEST(LagrangianIntegrators, ConditionsHoldWherePositionsMoveByTheNewVelocity) {
  Simulation simulation =
      simulationFromText(sceneOf(chain(4, 4, 1) + "<FixedProjectiveConstraint indices=\"0\"/>", 0.01, "0 -10 0",
                                 "<EulerImplicitSolver trapezoidalScheme=\"1\" moveByNewVelocity=\"1\"/>"));
  for (int i = 0; i < 60; ++i) {
    run(simulation, 1);
    if (HasFatalFailure()) return;
    for (Index k = 0; k < 4; ++k) ASSERT_NEAR((at(simulation, k + 1) - at(simulation, k)).norm(), 1, 1e-10) << "step " << i;
  }
  EXPECT_LT(at(simulation, 4).y(), -1);
}

/// A run that goes on from a checkpoint has the bits of one that never stopped, and its forces can be read at once.
TEST(LagrangianIntegrators, ARunGoesOnFromACheckpointBitForBit) {
  for (const std::string& integrator : integrators)
    for (const char* newton : {"", "newtonIterations=\"10\""}) {
      SCOPED_TRACE(integrator + newton);
      const std::string scene =
          sceneOf(chain(6, 5, 1) +
                      "<FixedLagrangianConstraint indices=\"0\"/><CableConstraint indices=\"3 5\" pullPoint=\"2 1 0\" "
                      "value=\"0.3\" maxDispVariation=\"0.01\" minForce=\"0\"/>",
                  0.01, "0 -10 0", with(integrator, newton));
      Simulation whole = simulationFromText(scene);
      run(whole, 7);
      Simulation restored = simulationFromText(scene);
      restored.restore(whole.checkpoint());
      const auto outputs = [](const Simulation& simulation) {
        std::vector<double> values;
        for (const char* name : {"forces", "force", "displacement", "cableLength", "cableInitialLength"})
          for (const double value : numbersOf(simulation, "CableConstraint", name)) values.push_back(value);
        for (const double value : numbersOf(simulation, "DistanceLagrangianConstraint", "forces")) values.push_back(value);
        return values;
      };
      EXPECT_EQ(outputs(restored), outputs(whole));
      for (int i = 0; i < 5; ++i) {
        run(whole, 1), run(restored, 1);
        ASSERT_EQ(restored.stateHash(), whole.stateHash()) << "step " << i;
      }
      EXPECT_EQ(outputs(restored), outputs(whole));
      EXPECT_GT(outputs(whole)[2], 0.1) << "the cable has been pulled";
    }
}

TEST(LagrangianIntegrators, WhoDoesNotFindForcesSaysSo) {
  for (const char* integrator : {"<NewmarkImplicitSolver/>", "<EulerExplicitSolver/>"})
    expectContains(problemsOf(pendulum(integrator, 0.01, 1)), "does not support the constraint /link");
}

/// Statics solve with the matrix of the other forces, which has no inverse where only constraints hold a body.
TEST(LagrangianIntegrators, StaticsSayWhoseForcesDoNotHoldABody) {
  Simulation simulation = simulationFromText(pendulum("<StaticSolver/>", 1, 0));
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.failed());
  for (const char* part : {"node 1", "not held", "forces of constraint alone hold, as those of /link", "AttachProjectiveConstraint"})
    expectContains(report.reason, part);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
