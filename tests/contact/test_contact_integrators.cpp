// SPDX-License-Identifier: LGPL-2.1-or-later
// BarrierContact in every integrator: the motion of masses that meet a plane against an equation that is integrated beside it, what
// rests and what rubs, momentum and energy of bodies that collide, and that nothing passes through anything.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double range = 0.02, g = 9.81;
const std::vector<std::string> implicit_ones{
    "<NewmarkImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-11\"/>",
    "<TrapezoidalRuleSolver newtonIterations=\"60\" newtonTolerance=\"1e-11\"/>",
    "<EulerImplicitSolver trapezoidalScheme=\"true\" newtonIterations=\"60\" newtonTolerance=\"1e-11\"/>",
    "<BDFOdeSolver order=\"2\" newtonIterations=\"60\" newtonTolerance=\"1e-11\"/>"};
const std::vector<std::string> explicit_ones{"<EulerExplicitSolver/>", "<CentralDifferenceSolver/>",
                                             "<NewtonCotesSolver degree=\"1\"/>", "<RungeKutta4Solver/>"};

std::vector<std::string> allOf(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  std::vector<std::string> all = a;
  all.insert(all.end(), b.begin(), b.end());
  return all;
}

/// Three masses of 1 kg at the corners of a triangle, each with a third of its area of 1/2 m^2, `height` above a plane. They know
/// nothing of each other.
constexpr double share = 1.0 / 6;
std::string masses(double height, const Vec3& velocity, double kappa, const std::string& contact) {
  const auto& v = velocity;
  return fmt::format(
      "<Node name=\"a\"><MeshTopology name=\"mesh\" position=\"0 0 {0}  1 0 {0}  0 1 {0}\" triangles=\"0 1 2\"/>"
      "<MechanicalObject name=\"dofs\" velocity=\"{1} {2} {3}  {1} {2} {3}  {1} {2} {3}\"/><UniformMass "
      "totalMass=\"3\"/></Node>"
      "<BarrierContact name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" contactDistance=\"{4}\" "
      "stiffness=\"{5}\" "
      "selfContact=\"0\" planes=\"0 0 1 0\" {6}/>",
      height, v.x(), v.y(), v.z(), range, kappa, contact);
}

double pressureOver(double gap) {  // over kappa
  const double r = gap / range;
  return r < 1 ? 2 * (r - 1) * std::log(r) + (r - 1) * (r - 1) / r : 0;
}

/// A mass that falls on the plane, by small steps.
double heightAfter(double time, double height, double speed, double kappa) {
  const double h = 1e-6;
  double x = height, v = -speed, a = kappa * share * pressureOver(x);
  for (long i = std::lround(time / h); i > 0; --i) {
    v += h / 2 * a, x += h * v;
    a = kappa * share * pressureOver(x);
    v += h / 2 * a;
  }
  return x;
}

double fall(const std::string& integrator, double dt, double time, double height, double speed, double kappa) {
  Simulation simulation =
      simulationFromText(contactScene(masses(height, Vec3(0, 0, -speed), kappa, ""), dt, Vec3::Zero(), integrator));
  for (long i = std::lround(time / dt); i > 0; --i) {
    expectCleanStep(simulation, int(i));
    if (::testing::Test::HasFatalFailure()) break;
    EXPECT_GT(simulation.systems()[0]->x[0].z(), 0);
  }
  return simulation.systems()[0]->x[0].z();
}

/// A rule of second order is one where a barrier turns a motion round, and an explicit one follows a barrier that is far stiffer than
/// its step.
TEST(ContactIntegrators, MassesBounceAsTheirEquationSays) {
  const double height = 0.021, speed = 1, kappa = 1500, time = 0.08, exact = heightAfter(time, height, speed, kappa);
  ASSERT_GT(exact, height) << "they have come back";
  for (const std::string& integrator : allOf(implicit_ones, explicit_ones)) {
    SCOPED_TRACE(integrator);
    const double coarse = std::abs(fall(integrator, 1e-3, time, height, speed, kappa) - exact),
                 fine = std::abs(fall(integrator, 5e-4, time, height, speed, kappa) - exact);
    RecordProperty(integrator.substr(1, 12), fmt::format("{:.3g} {:.3g}", coarse, fine));
    EXPECT_LT(coarse, 0.01 * exact);
    EXPECT_LT(fine, 0.35 * coarse + 1e-6) << coarse;
  }
}

/// Steps as long as the whole contact, and gaps that close to a hundredth: the speed afterwards is that before.
TEST(ContactIntegrators, ExplicitStepsAreDividedWhereABarrierIsStiff) {
  for (const std::string& integrator : explicit_ones)
    for (const double speed : {1.0, 2.5}) {
      SCOPED_TRACE(integrator);
      const double kappa = 250, dt = 0.02;
      Simulation simulation =
          simulationFromText(contactScene(masses(0.05, Vec3(0, 0, -speed), kappa, ""), dt, Vec3::Zero(), integrator));
      for (int i = 0; i < 6; ++i) expectCleanStep(simulation, i);
      EXPECT_NEAR(simulation.systems()[0]->v[0].z(), speed, 0.02 * speed) << speed;
      EXPECT_EQ(outputOf(simulation, "crossings"), 0);
    }
}

/// What rests does so at the gap of its weight: p/kappa = 0.1 at 0.8285.
TEST(ContactIntegrators, MassesRestAtTheGapOfTheirWeight) {
  const double kappa = g / share / 0.1;
  for (const std::string& integrator : allOf(implicit_ones, explicit_ones)) {
    SCOPED_TRACE(integrator);
    Simulation simulation = simulationFromText(
        contactScene(masses(0.8285 * range, Vec3::Zero(), kappa, ""), 0.01, Vec3(0, 0, -g), integrator));
    for (int i = 0; i < 50; ++i) expectCleanStep(simulation, i);
    EXPECT_NEAR(simulation.systems()[0]->x[0].z() / range, 0.8285, 1e-3);
  }
}

/// Masses that slide are stopped after v^2/(2 mu g), and stay.
TEST(ContactIntegrators, FrictionStopsMasses) {
  const double kappa = g / share / 0.001, mu = 0.5, closed_form = 1 / (2 * mu * g);
  for (const std::string& integrator : allOf(implicit_ones, explicit_ones)) {
    SCOPED_TRACE(integrator);
    const double dt = 5e-4;
    Simulation simulation = simulationFromText(contactScene(
        masses(0.98193 * range, Vec3(1, 0, 0), kappa, fmt::format("friction=\"{}\" frictionIterations=\"20\"", mu)), dt,
        Vec3(0, 0, -g), integrator));
    for (int i = 0; i < 500; ++i) expectCleanStep(simulation, i, false);
    const double way = simulation.systems()[0]->x[0].x();
    EXPECT_NEAR(way, closed_form, 0.01 * closed_form);
    for (int i = 0; i < 100; ++i) expectCleanStep(simulation, i, false);
    EXPECT_NEAR(simulation.systems()[0]->x[0].x(), way, 1e-4) << "it stays";
  }
}

/// tan q = 0.5: with mu = 0.505 masses stay where their springs or their creep hold them, with 0.49 they are accelerated. They are let
/// go at once, and begin with the speed with which springs stretch.
TEST(ContactIntegrators, MassesOnASlopeStickAndSlip) {
  const double c = 1 / std::sqrt(1.25), s = 0.5 * c, kappa = g * c / share / 0.001;
  for (const std::string& integrator : allOf({implicit_ones.front(), implicit_ones.back()}, explicit_ones))
    for (const double mu : {0.505, 0.49}) {
      SCOPED_TRACE(integrator);
      const double dt = 1e-3;
      Simulation simulation = simulationFromText(contactScene(
          masses(0.98193 * range, Vec3::Zero(), kappa, fmt::format("friction=\"{}\" frictionIterations=\"20\"", mu)),
          dt, g * Vec3(s, 0, -c), integrator));
      const auto at = [&](int steps) {
        for (int i = 0; i < steps; ++i) expectCleanStep(simulation, i, false);
        return simulation.systems()[0]->x[0].x();
      };
      const double first = at(200), half = at(400), whole = at(400), acceleration = (whole - 2 * half + first) / 0.16;
      RecordProperty(fmt::format("{}_{}", integrator.substr(1, 12), mu),
                     fmt::format("{:.4g} {:.4g} {:.4g}", first, half, whole));
      if (mu == 0.505) {
        EXPECT_LT(whole, 1e-3);
        EXPECT_NEAR(whole, half, 2e-4);
      } else {
        EXPECT_NEAR(acceleration, 2 * 0.0438717, 0.02 * 0.0438717);
      }
    }
}

/// What sticks bears up to the larger coefficient, what slides has the smaller one.
TEST(ContactIntegrators, StaticFrictionInExplicitSteps) {
  const double c = 1 / std::sqrt(1.25), s = 0.5 * c, kappa = g * c / share / 0.001;
  const auto wayWith = [&](double mu_static, double push) {
    Simulation simulation =
        simulationFromText(contactScene(masses(0.98193 * range, Vec3(push, 0, 0), kappa,
                                               fmt::format("friction=\"0.3\" staticFriction=\"{}\"", mu_static)),
                                        1e-3, g * Vec3(s, 0, -c), "<EulerExplicitSolver/>"));
    for (int i = 0; i < 500; ++i) expectCleanStep(simulation, i, false);
    return simulation.systems()[0]->x[0].x();
  };
  const double closed_form = g * (s - 0.3 * c) / 2 * 0.25;
  EXPECT_LT(wayWith(1.2, 0), 1e-3) << "sticks, although it is let go at once";
  EXPECT_NEAR(wayWith(0.49, 0), closed_form, 0.02 * closed_form) << "slides by the smaller one";
  EXPECT_NEAR(wayWith(1.2, 0.5), closed_form + 0.25, 0.02 * (closed_form + 0.25)) << "goes on";
}

/// Two free bodies that collide keep their momentum to the tolerance of their equations, and in explicit steps to round-off and their
/// energy. Nothing crosses.
TEST(ContactIntegrators, CollidingBodiesKeepWhatTheyHave) {
  const auto body = [](const std::string& name, const Body& b, const std::string& state) {
    return fmt::format(
        "<Node name=\"{}\">{}<MechanicalObject name=\"dofs\" {}/><MeshMatrixMass massDensity=\"1000\" "
        "lumping=\"true\"/>"
        "<TetrahedronHyperelasticityFEMForceField materialName=\"StableNeoHookean\" youngModulus=\"1e6\" "
        "poissonRatio=\"0.3\"/></Node>",
        name, b.mesh(), state);
  };
  for (const auto& [integrator, dt, steps] :
       {std::tuple(implicit_ones[0], 0.002, 60), std::tuple(implicit_ones[3], 0.002, 60),
        std::tuple(explicit_ones[0], 4e-4, 300), std::tuple(explicit_ones[1], 4e-4, 300),
        std::tuple(explicit_ones[2], 4e-4, 300)}) {
    SCOPED_TRACE(integrator);
    Body a = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {2, 2, 2}), b = boxOf(Vec3(0, 0, 0), Vec3(0.8, 0.8, 0.8), {2, 2, 2});
    b.turn(Eigen::AngleAxisd(0.7, Vec3(1, 2, 0.3).normalized()).toRotationMatrix(), Vec3(0.3, 0.2, 0));
    b.turn(Mat3::Identity(), Vec3(0, 0, 1.05 - b.lowest(2)));
    std::string velocity = "velocity=\"";
    for (int i = 0; i < 27; ++i) velocity += "0.2 0 -3 ";
    Simulation simulation = simulationFromText(contactScene(body("a", a, "") + body("b", b, velocity + "\"") +
                                                                fmt::format(fmt::runtime(between),
                                                                            "contactDistance=\"0.02\" "
                                                                            "stiffness=\"1e5\" selfContact=\"0\""),
                                                            dt, Vec3::Zero(), integrator));
    System& system = *simulation.systems()[0];
    const auto energy = [&] { return system.kineticEnergy() + system.potentialEnergy(system.x); };
    const Vec3 before = momentumOf(system);
    const double start = energy();
    double touched = 0;
    for (int i = 0; i < steps; ++i) {
      expectCleanStep(simulation, i, false);
      if (HasFatalFailure()) return;
      touched = std::max(touched, outputOf(simulation, "smallestGap"));
      ASSERT_LT((momentumOf(system) - before).norm(), 1e-9 * before.norm()) << "step " << i;
    }
    EXPECT_GT(touched, 0) << "they never met";
    EXPECT_GT(system.v[0].norm(), 0.1) << "the first was pushed";
    EXPECT_EQ(outputOf(simulation, "crossings"), 0);
    RecordProperty(integrator.substr(1, 12), fmt::format("{:.4g}", energy() / start));
    // shares of the surface turn with it, which no energy knows
    EXPECT_LT(energy(), 1.05 * start);
    if (std::find(explicit_ones.begin(), explicit_ones.end(), integrator) != explicit_ones.end()) {
      EXPECT_GT(energy(), 0.97 * start);
    }
  }
}

/// A skin of many nodes on a body of eight, whose mass couples them: what contact asks of parts of steps has the rows of the body.
TEST(ContactIntegrators, APartOfAStepKnowsTheRowsOfTheBody) {
  const double low = 0.9 * range;
  Simulation simulation = simulationFromText(contactScene(
      fmt::format("<Node name=\"body\"><RegularGridTopology n=\"2 2 2\" min=\"0 0 {0}\" max=\"1 1 {1}\"/><MechanicalObject "
                  "name=\"dofs\"/><MeshMatrixMass massDensity=\"1000\"/><HexahedronFEMForceField youngModulus=\"1e6\" "
                  "poissonRatio=\"0\"/><Node name=\"skin\">{2}<MechanicalObject name=\"dofs\"/><BarycentricMapping/></Node></Node>"
                  "<BarrierContact mstate=\"@body/skin/dofs\" planes=\"0 0 1 0\" contactDistance=\"{3}\" stiffness=\"5e4\"/>",
                  low, low + 0.5, boxOf(Vec3(0, 0, low), Vec3(1, 1, low + 0.5), {12, 12, 6}).mesh(), range),
      2e-4, Vec3(0, 0, -g), "<EulerExplicitSolver/>"));
  double least = 1;
  for (int i = 0; i < 300; ++i) {
    expectCleanStep(simulation, i, false);
    for (Index node = 0; node < 8; ++node) least = std::min(least, simulation.systems()[0]->x[node].z());
  }
  EXPECT_GT(least, 0);
  EXPECT_LT(least, low);
}

/// A ball that is driven at 10 m/s into a sheet of 3 mm, in which waves are three times as fast.
TEST(ContactIntegrators, AFastToolDoesNotPassThroughASheet) {
  for (const auto& [integrator, dt] :
       {std::pair("<EulerExplicitSolver/>", 2e-5), std::pair("<CentralDifferenceSolver rayleighMass=\"5\"/>", 2e-5),
        std::pair("<NewmarkImplicitSolver newtonIterations=\"60\"/>", 2e-4),
        std::pair("<BDFOdeSolver order=\"2\" newtonIterations=\"60\"/>", 2e-4)}) {
    SCOPED_TRACE(integrator);
    Simulation simulation = simulationFromText(contactScene(
        "<RegularGridTopology n=\"13 13 2\" min=\"-0.06 -0.06 0\" max=\"0.06 0.06 0.003\"/><MechanicalObject/>"
        "<UniformMass totalMass=\"0.04\"/><HexahedronFEMForceField youngModulus=\"1e6\" poissonRatio=\"0.3\" method=\"polar\"/>"
        "<BoxROI name=\"left\" box=\"-1 -1 -1  -0.059 1 1\"/><BoxROI name=\"right\" box=\"0.059 -1 -1  1 1 1\"/>"
        "<FixedProjectiveConstraint indices=\"@left.indices\"/><FixedProjectiveConstraint indices=\"@right.indices\"/>"
        "<BarrierContact contactDistance=\"2e-3\" selfContact=\"0\" spheres=\"0 0 0.0361 0.03\" keyTimes=\"0 0.0015 1\" "
        "movements=\"0 0 0  0 0 -0.015  0 0 -0.015\"/>",
        dt, Vec3::Zero(), integrator));
    for (int i = 0; i < std::lround(0.002 / dt); ++i) {
      expectCleanStep(simulation, i, false);
      if (HasFatalFailure()) return;
    }
    EXPECT_EQ(outputOf(simulation, "crossings"), 0);
    EXPECT_LT(simulation.systems()[0]->x[84].z(), -0.008) << "the sheet went along";
  }
}

/// A plane that rises carries masses without a jump: explicit steps move both together.
TEST(ContactIntegrators, ObstaclesMoveWithExplicitSteps) {
  for (const std::string& integrator : explicit_ones) {
    SCOPED_TRACE(integrator);
    const double kappa = 5 * g / share;
    Simulation simulation = simulationFromText(
        contactScene(masses(0.9 * range, Vec3::Zero(), kappa, "keyTimes=\"0 1\" movements=\"0 0 0  0 0 1\""), 0.01,
                     Vec3(0, 0, -g), integrator));
    for (int i = 0; i < 50; ++i) {
      expectCleanStep(simulation, i);
      EXPECT_GT(simulation.systems()[0]->x[0].z(), 0.01 * (i + 1));
    }
    EXPECT_LT(simulation.systems()[0]->x[0].z(), 0.5 + 0.1);
  }
}

/// A run that goes on from a checkpoint is the same to the bit, with contact, friction and what is moved.
TEST(ContactIntegrators, GoOnFromACheckpoint) {
  for (const std::string& integrator : allOf({implicit_ones[0], implicit_ones[3]}, explicit_ones)) {
    SCOPED_TRACE(integrator);
    const auto make = [&] {
      return simulationFromText(
          contactScene(masses(0.95 * range, Vec3(0.4, 0, -1), 1000,
                              "friction=\"0.3\" staticFriction=\"0.4\" keyTimes=\"0 10\" movements=\"0 0 0  0 0 1\""),
                       0.004, Vec3(0, 0, -g), integrator));
    };
    Simulation whole = make(), half = make();
    for (int i = 0; i < 40; ++i) whole.step();
    for (int i = 0; i < 7; ++i) half.step();
    Simulation rest = make();
    rest.restore(half.checkpoint());
    for (int i = 7; i < 40; ++i) rest.step();
    for (Index i = 0; i < 3; ++i) EXPECT_EQ(Vec3(rest.systems()[0]->x[i]), Vec3(whole.systems()[0]->x[i])) << i;
  }
}

/// The matrix gets another pattern in the same steps then: what solvers keep, and when they make it anew, depends on that.
TEST(ContactIntegrators, HaveThePatternsOfARunThatNeverStopped) {
  const auto make = [] { return simulationFromText(contactScene(masses(0.95 * range, Vec3(0.4, 0, -1), 1000, "friction=\"0.3\""), 0.004,
                                                                Vec3(0, 0, -g), implicit_ones[0])); };
  const auto patternOf = [](Simulation& simulation) { return simulation.systems()[0]->matrix().key().pattern; };
  Simulation whole = make();
  for (int step = 0; step < 20; ++step) {
    Simulation rest = make();
    if (step > 0) rest.restore(whole.checkpoint());
    const long before = patternOf(whole), before_rest = patternOf(rest);
    whole.step(), rest.step();
    EXPECT_EQ(patternOf(rest) - before_rest, patternOf(whole) - before) << step;
  }
}

/// Steps a thousand times too large, bodies turned inside out: a sentence, or a state without crossings. Never numbers that are none.
TEST(ContactIntegrators, WhatCannotBeFollowedIsSaid) {
  int said = 0;
  for (const std::string& integrator : allOf(implicit_ones, explicit_ones))
    for (const bool inverted : {false, true})
      for (const double dt : {1e-3, 4.0}) {
        SCOPED_TRACE(integrator);
        const Body box = boxOf(Vec3(0, 0, 0.03), Vec3(1, 1, 1.03));
        std::string state = "position=\"";
        for (std::size_t i = 0; i < box.points.size(); ++i) {  // the lower half above the upper one
          const Vec3& p = box.points[i];
          state += fmt::format("{} {} {}  ", p.x(), p.y(), inverted && i < 4 ? 2.03 - p.z() : p.z());
        }
        Simulation simulation = simulationFromText(contactScene(
            fmt::format("<Node name=\"a\">{}<MechanicalObject name=\"dofs\" {}\"/><UniformMass totalMass=\"1000\"/>"
                        "<TetrahedronFEMForceField youngModulus=\"1e6\" poissonRatio=\"0.4\" method=\"svd\"/>"
                        "<BarrierContact contactDistance=\"0.02\" friction=\"0.3\" planes=\"0 0 1 0\" "
                        "selfContact=\"0\"/></Node>",
                        box.mesh(), state),
            dt, Vec3(0, 0, -g), integrator));
        StepReport report;
        for (int i = 0; i < 10 && !report.failed(); ++i) {
          report = simulation.step();
          if (!report.failed()) {
            EXPECT_TRUE(report.constraints_converged) << report.constraint_reason;
          }
        }
        if (report.failed()) {
          ++said;
          EXPECT_FALSE(report.reason.empty());
        }
        const System& system = *simulation.systems()[0];
        EXPECT_TRUE(std::isfinite(dot(system.x, system.x)));
      }
  EXPECT_GT(said, 0);
}

/// A step with more parts than it may have names a dt; where gaps close on and on only a stiffer contact helps.
TEST(ContactIntegrators, AStepThatNeedsTooManyPartsSaysWhatHelps) {
  const auto reasonOf = [](const std::string& content, double dt, double gravity) {
    Simulation simulation =
        simulationFromText(contactScene(content, dt, Vec3(0, 0, -gravity), "<EulerExplicitSolver/>"));
    StepReport report;
    for (int i = 0; i < 5 && !report.failed(); ++i) report = simulation.step();
    return report.diverged ? report.reason : std::string();
  };
  const std::string hit = reasonOf(masses(0.05, Vec3(0, 0, -300), 250, ""), 0.02, 0);
  expectContains(hit, "as /contact needs them; give a larger stiffness");
  const std::string long_step = reasonOf(masses(0.8285 * range, Vec3::Zero(), g / share / 0.1, ""), 20, g);
  expectContains(long_step, "give dt=\"2\" or less");
}

/// What makes one solve, or moves on from where its equations hold, cannot promise anything.
TEST(ContactIntegrators, OthersAreRefused) {
  const std::string body = masses(0.05, Vec3::Zero(), 250, "");
  const auto problems = [&](const std::string& integrator) {
    return problemsOf(contactScene(body, 1e-3, Vec3::Zero(), "<" + integrator + "/>"));
  };
  for (const char* type : {"EulerImplicitSolver", "NewmarkImplicitSolver", "BDFOdeSolver", "TrapezoidalRuleSolver"}) {
    expectContains(problems(std::string(type) + " newtonIterations=\"1\""), "without asking");
    expectContains(problems(std::string(type) + " newtonIterations=\"1\""), "newtonIterations=\"30\"");
  }
  expectContains(problems("EulerImplicitSolver firstOrder=\"true\""), "without asking");
  expectContains(problems("EulerImplicitSolver firstOrder=\"true\""), "firstOrder=\"false\"");
  for (const char* type : {"VariationalSymplecticSolver", "VariationalSymplecticSolver explicitIntegration=\"true\""})
    expectContains(problems(type), "without asking");
}

/// A scene that does not set newtonIterations gets the steps of one that sets 30, in every digit, and `explain` names the contact.
TEST(ContactIntegrators, NewtonsMethodIsChosenForThem) {
  const auto heights = [](const std::string& integrator, std::string& description) {
    Simulation simulation =
        simulationFromText(contactScene(masses(0.021, Vec3(0, 0, -1), 1500, ""), 1e-3, Vec3::Zero(), "<" + integrator + "/>"));
    std::vector<double> found;
    for (int i = 0; i < 60; ++i) {
      expectCleanStep(simulation, i);
      found.push_back(simulation.systems()[0]->x[0].z());
    }
    EXPECT_LT(*std::ranges::min_element(found), 0.9 * range) << "they have touched";
    EXPECT_GT(*std::ranges::min_element(found), 0);
    description = simulation.systems()[0]->integrator().describe();
    return found;
  };
  for (const std::string type : {"EulerImplicitSolver", "EulerImplicitSolver trapezoidalScheme=\"true\"", "NewmarkImplicitSolver",
                                 "TrapezoidalRuleSolver", "BDFOdeSolver"}) {
    SCOPED_TRACE(type);
    std::string chosen, written;
    EXPECT_EQ(heights(type, chosen), heights(type + " newtonIterations=\"30\"", written));
    expectContains(chosen, "up to 30 Newton iterations (chosen because /contact limits how far bodies move)");
    expectContains(written, "up to 30 Newton iterations to");
  }
}

/// Without such a contact a step is still one linear solve, or two.
TEST(ContactIntegrators, OtherContactLeavesOneSolve) {
  const auto description = [](const std::string& method) {
    const Simulation simulation = simulationFromText(contactScene(
        fmt::format("<Node name=\"a\"><MeshTopology name=\"mesh\" position=\"0 0 1  1 0 1  0 1 1\" triangles=\"0 1 2\"/>"
                    "<MechanicalObject name=\"dofs\"/><UniformMass totalMass=\"3\"/></Node>"
                    "<{} mstate=\"@a/dofs\" topology=\"@a/mesh\" planes=\"0 0 1 0\" {}/>",
                    method, method == "PenaltyContact" ? "stiffness=\"100\"" : ""),
        1e-3, Vec3::Zero(), "<EulerImplicitSolver/>"));
    return simulation.systems()[0]->integrator().describe();
  };
  for (const char* method : {"PenaltyContact", "ConstraintContact"}) expectContains(description(method), "linearised once");
}

/// What nothing acts on goes on as it did: Newton's method is to find that before its first linear solve. The barrier is at rest and
/// out of reach, and says only that steps are limited.
TEST(ContactIntegrators, WhatGoesOnEvenlyNeedsNoSolve) {
  const Vec3 velocity(0.3, -0.2, 0.1);
  const Body box = boxOf(Vec3(0, 0, 1), Vec3(1, 1, 2), {2, 2, 2});
  std::string moving = "velocity=\"";
  for (std::size_t i = 0; i < box.points.size(); ++i) moving += fmt::format("{} {} {}  ", velocity.x(), velocity.y(), velocity.z());
  std::vector<std::string> integrators = implicit_ones;
  integrators.push_back("<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-11\"/>");
  for (const std::string& integrator : integrators)
    for (const char* friction : {"", "friction=\"0.3\""}) {
      SCOPED_TRACE(integrator + friction);
      Simulation simulation = simulationFromText(contactScene(
          bodyNode("a", box, "", moving + "\"") +
              fmt::format("<BarrierContact mstate=\"@a/dofs\" topology=\"@a/mesh\" contactDistance=\"{}\" selfContact=\"0\" "
                          "planes=\"0 0 1 0\" {}/>",
                          range, friction),
          0.01, Vec3::Zero(), integrator));
      for (int step = 0; step < 5; ++step) {
        const StepReport report = simulation.step();
        EXPECT_TRUE(report.newton_converged) << report.reason;
        EXPECT_EQ(report.newton_iterations, 0) << "step " << step;
      }
      const Vec3 end = simulation.systems()[0]->x[0] - Vec3(0, 0, 1);
      EXPECT_LT((end - 5 * 0.01 * velocity).norm(), 1e-12);
    }
}

TEST(ContactIntegrators, WhatMovesBeforeItLooksIsRefused) {
  const auto problems = [](const std::string& attributes) {
    const std::string integrator = "<BDFOdeSolver newtonIterations=\"9\" " + attributes + "/>";
    return problemsOf(contactScene(masses(0.1, Vec3::Zero(), 1e4, ""), 0.01, Vec3::Zero(), integrator));
  };
  EXPECT_EQ(problems(""), "");
  expectContains(problems("startFrom=\"predicted\""), "moves bodies before it checks for contact");
  expectContains(problems("restBelow=\"1e-5\""), "is of steps that begin where velocities lead");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
