// SPDX-License-Identifier: LGPL-2.1-or-later
// The barrier's closed forms, friction, momentum, what is refused, and that nothing crosses.
#include <Eigen/Geometry>

#include "framework/mechanics/open_choices.h"
#include "framework/mechanics/step_limiter.h"
#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"
#include "tests/support/dense_algebra.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string contact(const std::string& attributes) { return fmt::format(fmt::runtime(between), attributes); }

/// Under a pressure p two blocks rest at the gap where p = kappa (2 (r - 1) ln r + (r - 1)^2/r), everywhere.
TEST(BarrierContact, BlocksRestAtTheGapOfTheirPressure) {
  for (const auto& [share, r] : {std::pair(0.01, 0.9434), std::pair(0.1, 0.8285), std::pair(1.0, 0.5324)}) {
    const double range = 0.02, kappa = 1e5;
    const Body low = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 0.5), {3, 3, 2});
    const Body high = boxOf(Vec3(0, 0, 0.5 + 0.9 * range), Vec3(1, 1, 1 + 0.9 * range), {3, 3, 2});
    const std::string upright = "<PartialFixedProjectiveConstraint indices=\"{}\" fixedDirections=\"1 1 {}\"/>";
    std::string all, bottom;
    for (int i = 0; i < 48; ++i) all += fmt::format("{} ", i);
    for (int i = 0; i < 16; ++i) bottom += fmt::format("{} ", i);
    const std::string load = fmt::format("<SurfacePressureForceField pressure=\"{}\" min=\"-1 -1 {}\" max=\"2 2 2\"/>",
                                         -share * kappa, 0.99 + 0.9 * range);
    Simulation simulation = simulationFromText(contactScene(
        bodyNode("a", low, fmt::format(fmt::runtime(upright), all, 0) + fmt::format(fmt::runtime(upright), bottom, 1),
                 "", 1e7, 0) +
            bodyNode("b", high, fmt::format(fmt::runtime(upright), all, 0) + load, "", 1e7, 0) +
            contact(fmt::format("contactDistance=\"{}\" stiffness=\"{}\"", range, kappa)),
        1, Vec3::Zero(), "<StaticSolver/>"));
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.newton_converged) << report.reason;
    const System& system = *simulation.systems()[0];
    const Index a = simulation.states()[0]->firstRow(), b = simulation.states()[1]->firstRow();
    double least = 1e300, most = 0;
    for (Index i = 0; i < 16; ++i) {
      const double gap = (system.x[b + i].z() - system.x[a + 32 + i].z()) / range;
      least = std::min(least, gap), most = std::max(most, gap);
    }
    EXPECT_NEAR(least, r, 1e-4) << "p/kappa " << share;
    EXPECT_NEAR(most, r, 1e-4) << "p/kappa " << share;
    EXPECT_NEAR(outputOf(simulation, "smallestGap") / range, r, 1e-4);
    const std::vector<double> pressures = numbersOf(simulation, "pressures"), areas = numbersOf(simulation, "contactAreas"),
                              gaps = numbersOf(simulation, "gaps"), states = numbersOf(simulation, "contactStates");
    ASSERT_EQ(pressures.size(), 48u);
    double area = 0;
    for (std::size_t i = 0; i < 48; ++i) {
      const bool touches = i >= 32;  // the upper side of the lower one
      EXPECT_NEAR(pressures[i], touches ? share * kappa : 0, 1e-3 * share * kappa) << "node " << i;
      EXPECT_NEAR(gaps[i] / range, touches ? r : 1, 1e-4) << "node " << i;
      EXPECT_EQ(states[i], touches ? 2 : 0) << "without friction what touches slides";
      area += areas[i];
    }
    EXPECT_NEAR(area, 1, 1e-12);
  }
}

/// A block that is held at a gap of r above a plane: with openStiffness, times ln 2 + 1/2, its pressure would be the same at half of
/// the range.
TEST(BarrierContact, SaysWhichStiffnessKeepsAGapOpen) {
  for (const double r : {0.04, 0.3}) {
    std::string all;
    for (int i = 0; i < 27; ++i) all += fmt::format("{} ", i);
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node dt="1" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/><RegularGridTopology n="3 3 3" min="0 0 0" max="1 1 1"/>
        <MechanicalObject/><HexahedronFEMForceField youngModulus="1e6" poissonRatio="0.3"/><FixedProjectiveConstraint indices="{}"/>
        <BarrierContact contactDistance="0.1" stiffness="1e4" planes="0 0 1 {}"/></Node>)", all, -0.1 * r));
    simulation.step();
    EXPECT_NEAR(outputOf(simulation, "smallestGap"), 0.1 * r, 1e-12);
    const double pressure = 1e4 * (2 * (r - 1) * std::log(r) + (r - 1) * (r - 1) / r);
    EXPECT_NEAR(outputOf(simulation, "openStiffness") * (std::log(2.) + 0.5), r < 0.1 ? pressure : 0, 1e-9 * pressure);
  }
}

/// K of the force at x, without its last digits' asymmetry.
Eigen::MatrixXd denseTangent(FieldUnderTest& t) {
  const Index rows = t.x.count();
  Eigen::MatrixXd k(3 * rows, 3 * rows);
  t.force();
  for (Index column = 0; column < 3 * rows; ++column) {
    Vector unit(rows), product(rows);
    unit[column / 3][column % 3] = 1;
    t.field().addStiffnessProduct(unit, 1, product);
    for (Index row = 0; row < 3 * rows; ++row) k(row, column) = product[row / 3][row % 3];
  }
  return 0.5 * (k + k.transpose());
}

/// Force, energy, derivative and products belong together, in reach of faces, edges, vertices, a plane, a sphere and a capsule;
/// and the derivative that is asked to be definite is.
TEST(BarrierContact, ForceIsTheSlopeOfTheEnergy) {
  int checked = 0;
  for (unsigned seed = 1; seed < 30; ++seed) {
    const Body a = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)), b = boxAbove(seed, 0.03);
    FieldUnderTest t(contactScene(bodyNode("a", a, "") + bodyNode("b", b, "") +
                                  contact("contactDistance=\"0.2\" planes=\"0 0 1 -0.1\" spheres=\"1.32 0.45 0.55 0.2\" "
                                          "capsules=\"-1 0.52 -0.31  2 0.44 -0.35  0.2\"")),
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
      expectSymmetricProducts(t);
    }
    const Eigen::VectorXd stiffness = eigenvalues(-denseTangent(t));
    EXPECT_GE(stiffness[0], -1e-9 * stiffness[stiffness.size() - 1]) << "seed " << seed;
  }
  EXPECT_GT(checked, 15);
}

/// Two ridges of length L = 2 cross at right angles, x and z, one above the other. The upper one slides by a along x and tilts by b
/// of its length, so that the gap falls by the square: -2 a b. With s^2 = |w|/|c| = 2/L the definite tangent has |e'|/2 (s a + b/s)^2.
TEST(BarrierContact, ADefiniteTangentKnowsSlidesThatCloseTheGap) {
  Body below = wedge(), above = wedge(true);
  const Mat3 quarter = Eigen::AngleAxisd(EIGEN_PI / 2, Vec3::UnitY()).toRotationMatrix();
  above.turn(quarter, Vec3(0, 6.05, 0));
  FieldUnderTest t(contactScene(bodyNode("a", below, "") + bodyNode("b", above, "") + contact("contactDistance=\"0.1\"")),
                   "BarrierContact");
  std::vector<Index> ends;
  for (Index i = 0; i < t.x.count(); ++i)
    if (std::abs(t.x[i].y() - 3.05) < 1e-9) ends.push_back(i);
  ASSERT_EQ(ends.size(), 2u);
  const double push = t.force()[ends[0]].y() + t.force()[ends[1]].y();
  ASSERT_GT(push, 0);
  for (const bool definite : {false, true}) {
    ASSERT_TRUE(dynamic_cast<OpenChoices&>(t.field()).useDefiniteTangent(definite));
    for (const double a : {1.0, -1.0, 0.3})
      for (const double b : {1.0, -0.5}) {
        Vector way(t.x.count());
        for (const Index end : ends) way[end] = Vec3(a, b * t.x[end].x(), 0);
        const double closes = definite ? 0.5 * (a + b) * (a + b) : 2 * a * b + 0.05 * b * b;
        EXPECT_NEAR(-dot(way, t.product(way)), push * closes, 1e-9 * push) << a << " " << b << (definite ? ", definite" : "");
      }
  }
}

/// The middle of a triangle of side 1 below a sphere. Between what is near, d < 1/s^2 = 1/sqrt(3), and what is far the definite tangent
/// does not jump as the sphere grows: iterates that come to the other side would have another equation.
TEST(BarrierContact, ADefiniteTangentIsTheSameOnBothSidesOfItsLimit) {
  const double height = std::sqrt(0.75), gap = 1e-3, limit = 1 / std::sqrt(3.0);
  const Body body{{{0, 0, 0}, {1, 0, 0}, {0.5, height, 0}, {0.5, height / 3, -1}}, {{0, 1, 2, 3}}};
  const auto stiffnessBelow = [&](double distance) {
    FieldUnderTest t(contactScene(bodyNode("a", body, "") +
                                  fmt::format("<BarrierContact mstate=\"@a/dofs\" topology=\"@a/mesh\" contactDistance=\"0.02\" "
                                              "selfContact=\"0\" spheres=\"0.5 {} {} {}\"/>",
                                              height / 3, distance, distance - gap)),
                     "BarrierContact");
    EXPECT_GT(t.force()[0].norm(), 0);
    EXPECT_TRUE(dynamic_cast<OpenChoices&>(t.field()).useDefiniteTangent(true));
    Vector way(t.x.count());
    way[0] = Vec3(0.1, 0.2, 1), way[1] = Vec3(0.1, 0.2, -1), way[2] = Vec3(0.1, 0.2, 0);  // it slides and tilts
    return -dot(way, t.product(way)) / t.force()[0].norm();
  };
  const double below = stiffnessBelow((1 - 1e-6) * limit), above = stiffnessBelow((1 + 1e-6) * limit);
  EXPECT_GT(below, 0);
  EXPECT_NEAR(above, below, 1e-4 * below);
  EXPECT_GT(stiffnessBelow(2.5 * limit), 1.5 * below) << "far above all of it is kept";
}

/// Two free bodies that collide keep what they have together, to round-off.
TEST(BarrierContact, CollidingBodiesKeepTheirMomentum) {
  Body a = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {2, 2, 2}), b = boxOf(Vec3(0, 0, 0), Vec3(0.8, 0.8, 0.8), {2, 2, 2});
  b.turn(Eigen::AngleAxisd(0.7, Vec3(1, 2, 0.3).normalized()).toRotationMatrix(), Vec3(0.3, 0.2, 0));
  b.turn(Mat3::Identity(), Vec3(0, 0, 1.05 - b.lowest(2)));
  std::string velocity = "velocity=\"";
  for (int i = 0; i < 27; ++i) velocity += "0.2 0 -3 ";
  Simulation simulation = simulationFromText(
      contactScene(bodyNode("a", a, "") + bodyNode("b", b, "", velocity + "\"") + contact("contactDistance=\"0.02\""),
                   0.005, Vec3::Zero(), "<EulerImplicitSolver newtonIterations=\"100\" newtonTolerance=\"1e-12\"/>"));
  System& system = *simulation.systems()[0];
  const Vec3 before = momentumOf(system);
  double touched = 0;
  for (int i = 0; i < 80; ++i) {
    expectCleanStep(simulation, i, false);
    touched = std::max(touched, outputOf(simulation, "smallestGap"));
    ASSERT_LT((momentumOf(system) - before).norm(), 1e-9 * before.norm()) << "step " << i;
  }
  EXPECT_GT(touched, 0) << "they never met";
  EXPECT_GT(system.v[0].norm(), 0.1) << "the first was pushed";
}

/// An integrator's damping is that of the bodies: the steps are those of the same factor at every field but the contact. What the
/// barrier adds as an own factor is damping, and another step.
TEST(BarrierContact, IsNotDampedByTheIntegrator) {
  const Body low = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 0.5), {2, 2, 1}), high = boxOf(Vec3(0.1, 0.1, 0.52), Vec3(0.8, 0.7, 1), {2, 2, 1});
  const auto ends = [&](double of_integrator, double of_bodies, const char* of_contact, const char* integrator) {
    std::string content = bodyNode("a", low, "<FixedProjectiveConstraint indices=\"0 1 2 3\"/>") + bodyNode("b", high, "") +
                          contact(fmt::format("contactDistance=\"0.02\" stiffness=\"1e5\" {}", of_contact));
    const std::string field = "<TetrahedronFEMForceField ";
    for (std::size_t at = 0; (at = content.find(field, at)) != std::string::npos; at += field.size())
      content.insert(at + field.size(), fmt::format("rayleighStiffness=\"{}\" ", of_bodies));
    Simulation simulation = simulationFromText(
        contactScene(content, 0.01, Vec3(0, 0, -9.81),
                     fmt::format("<{} newtonIterations=\"60\" newtonTolerance=\"1e-9\" rayleighStiffness=\"{}\"/>", integrator,
                                 of_integrator)));
    for (int step = 0; step < 12; ++step) {
      expectCleanStep(simulation, step, *of_contact == 0);
      if (::testing::Test::HasFatalFailure()) break;
    }
    const System& system = *simulation.systems()[0];
    Vector x(system.x.count());
    copy(system.x, x);
    return x;
  };
  for (const char* integrator : {"EulerImplicitSolver", "EulerImplicitSolver trapezoidalScheme=\"true\""}) {
    const Vector at_bodies = ends(0, 0.02, "", integrator), at_integrator = ends(0.02, 0, "", integrator);
    const Vector everywhere = ends(0.02, 0, "rayleighStiffness=\"0.02\"", integrator);
    EXPECT_LT(distance(at_bodies, at_integrator), 1e-7) << integrator;
    EXPECT_GT(distance(at_bodies, everywhere), 1e-5) << integrator;
  }
}

/// tan q = 0.5: with mu = 0.505 a block creeps at the share of slipVelocity where the smoothed friction carries it, with 0.49 it
/// slides 1/2 g (sin q - mu cos q) t^2, and with 0.50 it is not accelerated: the velocity that it is let go with stays.
TEST(BarrierContact, SticksAndSlipsWhereCoulombSays) {
  const double c = 1 / std::sqrt(1.25), s = 0.5 * c, dt = 0.004, slip_velocity = 1e-5;
  for (const double mu : {0.505, 0.5, 0.49}) {
    const Body block = boxOf(Vec3(0, 0, 0.00976), Vec3(1, 1, 0.20976));
    const std::string floor = fmt::format(
        "<PartialFixedProjectiveConstraint indices=\"0 1 2 3 4 5 6 7\" fixedDirections=\"1 1 0\" endTime=\"0.198\"/>"
        "<BarrierContact planes=\"0 0 1 0\" contactDistance=\"0.01\" stiffness=\"1e6\" friction=\"{}\" "
        "slipVelocity=\"{}\"/>",
        mu, slip_velocity);
    Simulation simulation =
        simulationFromText(contactScene(bodyNode("a", block, floor, "", 1e10, 0), dt, 9.81 * Vec3(s, 0, -c),
                                        "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-9\"/>"));
    const System& system = *simulation.systems()[0];
    const auto mean = [&](ConstRows rows) {
      double sum = 0;
      for (Index i = 0; i < 8; ++i) sum += rows[i].x() / 8;
      return sum;
    };
    for (int i = 0; i < 50; ++i) expectCleanStep(simulation, i);  // it settles, held against sliding
    const double start = mean(system.x);
    double early = 0;
    for (int i = 0; i < 250; ++i) {
      expectCleanStep(simulation, i);
      if (i == 50) early = mean(system.v);
    }
    const double way = mean(system.x) - start, velocity = mean(system.v);
    RecordProperty(fmt::format("way with mu {}", mu), std::to_string(way));
    if (mu == 0.505) {
      EXPECT_NEAR(velocity, (1 - std::sqrt(1 - 0.5 / mu)) * slip_velocity, 0.01 * slip_velocity);
      EXPECT_LT(way, 2e-5);
    } else if (mu == 0.5) {
      EXPECT_NEAR(velocity, early, 1e-6);
      EXPECT_LT(way, 0.02 * 0.0438717);
    } else {
      EXPECT_NEAR(way, 0.0438717, 0.01 * 0.0438717);
    }
  }
}

/// Forces between two bodies have neither sum nor moment.
TEST(BarrierContact, ForcesBetweenBodiesHaveNoMoment) {
  int checked = 0;
  for (unsigned seed = 1; seed < 60; ++seed) {
    FieldUnderTest t(contactScene(bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)), "") + bodyNode("b", boxAbove(seed, 0.03), "") +
                                  contact("contactDistance=\"0.2\"")),
                     "BarrierContact");
    const Vector f = t.force();
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    double size = 0;
    for (Index i = 0; i < f.count(); ++i) {
      sum += Vec3(f[i]), moment += Vec3(t.x[i]).cross(Vec3(f[i]));
      size += Vec3(f[i]).norm();
    }
    if (size == 0) continue;
    ++checked;
    EXPECT_LT(sum.norm(), 1e-13 * size) << "seed " << seed;
    EXPECT_LT(moment.norm(), 1e-13 * size) << "seed " << seed;
  }
  EXPECT_GT(checked, 5);
}

/// The exact test of a step sees a body that something else has put through another one, and says where.
TEST(BarrierContact, ACrossingIsSeenAndNamed) {
  Simulation simulation = simulationFromText(
      contactScene(bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {2, 2, 2}), "") +
                   bodyNode("b", boxOf(Vec3(0.2, 0.3, 1.2), Vec3(0.8, 0.7, 1.8)), "") + contact("contactDistance=\"0.05\"")));
  StepReport report = simulation.step();
  EXPECT_TRUE(report.constraints_converged) << report.constraint_reason;
  EXPECT_EQ(outputOf(simulation, "crossings"), 0);
  System& system = *simulation.systems()[0];
  const State& b = *simulation.states()[1];
  for (Index i = 0; i < b.size(); ++i) system.x[b.firstRow() + i] -= Vec3(0, 0, 0.4);
  report = simulation.step();
  EXPECT_TRUE(report.diverged || !report.constraints_converged);
  expectContains(report.constraint_reason + report.reason, "through the triangle of node");
  EXPECT_GT(outputOf(simulation, "crossings"), 0);
}

TEST(BarrierContact, RefusesAStartInOverlap) {
  const std::string text =
      problemsOf(contactScene(bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)), "") +
                              bodyNode("b", boxOf(Vec3(0.2, 0.3, 0.9), Vec3(0.8, 0.7, 1.5)), "") + contact("")));
  expectContains(text, "bodies of /contact start in one another");
  expectContains(text, "of /b/dofs");
  expectContains(problemsOf(contactScene(
                     bodyNode("a", boxOf(Vec3(0, 0, -0.1), Vec3(1, 1, 1)), "<BarrierContact planes=\"0 0 1 0\"/>"))),
                 "0.1 m inside a plane");
  expectContains(problemsOf(contactScene(
                     bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)), "<BarrierContact planes=\"0 0 1 0\"/>"))),
                 "node 0 of /a/dofs touches a plane");
  expectContains(problemsOf(contactScene(bodyNode("a", boxOf(Vec3(0, 0, 1), Vec3(1, 1, 2)),
                                                  "<BarrierContact other=\"@dofs\" planes=\"0 0 1 0\"/>"))),
                 "other names /a/dofs, which is mstate itself");
  const Body block = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {2, 2, 2});
  for (const char* inside : {"spheres=\"0.4 0.4 0.6 0.05\"", "capsules=\"0.3 0.4 0.6 0.7 0.4 0.6 0.05\"",
                             "boxes=\"0.3 0.3 0.3 0.6 0.6 0.6\"", "cylinders=\"0.3 0.4 0.6 0.7 0.4 0.6 0.05\""})
    expectContains(problemsOf(contactScene(bodyNode("a", block, fmt::format("<BarrierContact {}/>", inside)))), "is inside of a body");
  EXPECT_EQ(problemsOf(contactScene(bodyNode("a", block, "<BarrierContact spheres=\"0.4 0.4 1.2 0.05\"/>"))), "");
}

TEST(BarrierContact, RefusesWhatCanNeverAct) {
  const auto with = [](const std::string& attributes) {
    return problemsOf(contactScene(bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)), "<BarrierContact " + attributes + "/>")));
  };
  expectContains(with("selfContact=\"0\""), "nothing to be in contact with");
  expectContains(with("keyTimes=\"0 1\" movements=\"0 0 0  0 0 1\""), "move obstacles, and there is none");
  EXPECT_EQ(with("selfContact=\"0\" planes=\"0 0 1 -1\""), "");
}

TEST(BarrierContact, RefusesIntegratorsThatDoNotAsk) {
  const std::string body = bodyNode("a", boxOf(Vec3(0, 0, 0.1), Vec3(1, 1, 1)), "<BarrierContact planes=\"0 0 1 0\"/>");
  const std::string solves_once = "<EulerImplicitSolver newtonIterations=\"1\"/>";
  for (const std::string& integrator : {solves_once, std::string("<VariationalSymplecticSolver/>")})
    expectContains(problemsOf(contactScene(body, 1e-5, Vec3::Zero(), integrator)), "without asking");
  expectContains(problemsOf(contactScene(body, 0.01, Vec3::Zero(), solves_once)), "newtonIterations=\"30\"");
  EXPECT_EQ(problemsOf(contactScene(body, 0.01, Vec3::Zero(), "<EulerImplicitSolver/>")), "");
}

/// An integrator whose solve has failed takes bodies back to where the step began. Obstacles that have come nearer meanwhile
/// are then back as well.
TEST(BarrierContact, ObstaclesGoBackWithTheBodies) {
  FieldUnderTest t(contactScene(bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)),
                                         "<BarrierContact contactDistance=\"0.02\" planes=\"0 0 -1 -1.01\" keyTimes=\"0 1\" "
                                         "movements=\"0 0 0  0 0 -0.1\"/>")),
                   "BarrierContact");
  auto& limiter = dynamic_cast<StepLimiter&>(t.field());
  limiter.stepBegins(t.x, 0, 1);
  const Vector before = t.force();
  Vector away(t.x.count());
  copy(t.x, away);
  for (Index i = 0; i < away.count(); ++i) away[i] -= Vec3(0, 0, 0.05);
  t.forceAt(away);
  ASSERT_TRUE(limiter.updatesLagged(away)) << "the plane is on its way";
  const Vector after = t.force();
  EXPECT_GT(dot(before, before), 0);
  EXPECT_EQ(relativeDifference(before, after), 0);
}

/// An obstacle on its way pushes a body before it, and nothing crosses, however far it goes in a step.
TEST(BarrierContact, MovingObstaclesPush) {
  Simulation simulation = simulationFromText(
      contactScene(bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {2, 2, 2}),
                            "<BarrierContact name=\"contact\" contactDistance=\"0.02\" spheres=\"0.5 0.5 1.35 0.3\" "
                            "boxes=\"-1 -1 -0.5 2 2 -0.05\" keyTimes=\"0 0.2\" movements=\"0 0 0  0 0 -0.2\"/>"),
                   0.02, Vec3(0, 0, -9.81)));
  for (int i = 0; i < 8; ++i) expectCleanStep(simulation, i, false);
  EXPECT_EQ(outputOf(simulation, "crossings"), 0);
}

/// A report of a run without result names what is behind a plane or inside of an obstacle, and by how much.
TEST(BarrierContact, NamesWhatHasNoGap) {
  Simulation simulation = simulationFromText(contactScene(
      bodyNode("a", boxOf(Vec3(0, 0, 0.1), Vec3(1, 1, 1.1)), "") +
      "<BarrierContact mstate=\"@a/dofs\" topology=\"@a/mesh\" contactDistance=\"0.02\" planes=\"0 0 1 0\" spheres=\"3 0.5 0.5 0.25\"/>"));
  const System& system = *simulation.systems()[0];
  const auto worstAt = [&](Index node, const Vec3& place) {
    Vector x(system.allRows());
    copy(system.x, x);
    x[node] = place;
    for (const ForceField* field : system.forceFields())
      if (field->type() == "BarrierContact") return field->worstElement(x);
    return std::string("no such field");
  };
  EXPECT_EQ(worstAt(0, Vec3(0, 0, 0.01)), "") << "near is not bad";
  EXPECT_EQ(worstAt(0, Vec3(0, 0, -0.25)), "node 0 of /a/dofs and a plane: a gap of -0.25 m");
  EXPECT_EQ(worstAt(5, Vec3(2.9, 0.5, 0.5)), "node 5 of /a/dofs and an obstacle: a gap of -0.15 m");
  EXPECT_EQ(worstAt(0, Vec3(0, 0, 0.01)), "") << "it remembers nothing";
}

/// Whoever chooses a solver knows what products take, with and without pairs that touch; a contact of unknown cost would hide it.
TEST(BarrierContact, WhatItsProductsCostIsKnown) {
  const auto costs = [&](double gap, bool has_contact) {
    Simulation simulation = simulationFromText(contactScene(
        bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {4, 4, 4}), "<FixedProjectiveConstraint indices=\"0 1 2 3 4 5\"/>", "", 1e5) +
            bodyNode("b", boxOf(Vec3(0, 0, 1 + gap), Vec3(1, 1, 2 + gap), {4, 4, 4}), "", "", 1e5) +
            (has_contact ? contact("contactDistance=\"0.02\"") : ""),
        0.001, Vec3(0, 0, -9.81)));
    simulation.step();
    const SystemMatrix& matrix = simulation.systems()[0]->matrix();
    return std::pair(matrix.productCost(), matrix.assemblyCost());
  };
  const auto bodies = costs(0.5, false), apart = costs(0.5, true), touching = costs(0.015, true);
  EXPECT_GT(bodies.first, 0);
  EXPECT_NEAR(apart.first, bodies.first, 0.02 * bodies.first);
  EXPECT_NEAR(apart.second, bodies.second, 0.1 * bodies.second);
  EXPECT_GT(touching.first, apart.first);
  EXPECT_GT(touching.second, apart.second);
}

/// What the check of a start has found out is what a run that begins again finds out: the bits and the numbers of queries are the same.
TEST(BarrierContact, BeginsAgainAsItBegan) {
  Simulation simulation = simulationFromText(contactScene(
      bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {2, 2, 2}), "<FixedProjectiveConstraint indices=\"0 1 2 3 4 5 6 7 8\"/>", "", 1e5) +
          bodyNode("b", boxOf(Vec3(0.1, 0.2, 1.01), Vec3(0.9, 0.8, 1.6), {2, 3, 2}), "", "", 1e5) + contact("contactDistance=\"0.02\""),
      0.01, Vec3(0, 0, -9.81)));
  const auto run = [&] {
    std::vector<double> all;
    for (int i = 0; i < 8; ++i) {
      expectCleanStep(simulation, i, false);
      const System& system = *simulation.systems()[0];
      for (Index row = 0; row < system.x.count(); ++row)
        for (int k = 0; k < 3; ++k) all.push_back(system.x[row][k]);
      all.push_back(outputOf(simulation, "queries")), all.push_back(outputOf(simulation, "smallestGap"));
    }
    EXPECT_GT(all.back(), 0) << "they have met";
    return all;
  };
  const std::vector<double> first = run();
  simulation.reset();
  EXPECT_EQ(run(), first);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
