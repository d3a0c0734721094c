// SPDX-License-Identifier: LGPL-2.1-or-later
// Prescribed motion: exact at the end of every step, whatever the integrator.
#include <fmt/format.h>

#include <cmath>
#include <tuple>

#include "tests/support/scene_text.h"

namespace stroma::test {
namespace {

const std::vector<std::string> integrators = {
    "<EulerExplicitSolver/>",
    "<EulerExplicitSolver symplectic='false'/>",
    "<EulerImplicitSolver rayleighStiffness='0.01'/>",
    "<EulerImplicitSolver newtonIterations='10'/>",
    "<EulerImplicitSolver trapezoidalScheme='true' newtonIterations='10'/>",
    "<EulerImplicitSolver firstOrder='true'/>",
    "<TrapezoidalRuleSolver/>",
    "<NewmarkImplicitSolver/>",
    "<NewmarkImplicitSolver gamma='0.7' beta='0.4' newtonIterations='10'/>",
    "<BDFOdeSolver/>",
    "<BDFOdeSolver order='2'/>",
    "<VariationalSymplecticSolver/>",
    "<VariationalSymplecticSolver explicitIntegration='true'/>",
    "<CentralDifferenceSolver/>",
    "<RungeKutta2Solver/>",
    "<RungeKutta4Solver/>",
    "<NewtonCotesSolver degree='3'/>",
    "<StaticSolver/>",
};

/// Three nodes in a row on two springs of rest length 0, so that statics puts the second half-way.
std::string chain(const std::string& integrator, const std::string& constraint, double dt = 0.1) {
  return fmt::format(R"(<Node name="root" dt="{}" gravity="0 0 0">{}<CGLinearSolver iterations="100" tolerance="1e-13"/>
    <MechanicalObject name="dofs" position="0 0 0 1 0 0 2 0 0"/><UniformMass totalMass="3"/>
    <SpringForceField springsIndices1="0 1" springsIndices2="1 2" lengths="0 0" stiffness="20" damping="0"/>
    <FixedProjectiveConstraint name="end" indices="2"/>{}</Node>)",
                     dt, integrator, constraint);
}

std::string implicitChain(const std::string& constraint) { return chain("<EulerImplicitSolver/>", constraint); }

void expectNear(const Vec3& a, const Vec3& b, double tolerance, const std::string& what) {
  EXPECT_LT((a - b).norm(), tolerance) << what << ": " << a.transpose() << " and " << b.transpose();
}

/// Ten steps of the chain with every integrator, and check(integrator, system, t) after each.
template <class Check>
void stepWithAll(const std::string& constraint, Check&& check) {
  for (const std::string& integrator : integrators) {
    SCOPED_TRACE(integrator);
    Simulation simulation = simulationFromText(chain(integrator, constraint));
    for (int i = 1; i <= 10; ++i) {
      ASSERT_FALSE(simulation.step().diverged);
      check(integrator, *simulation.systems().at(0), simulation.time());
    }
  }
}

TEST(LinearMovement, PositionsAndVelocitiesAreExactAtStepEndsOfEveryIntegrator) {
  const auto movement = [](double t) {  // keys at 0, 0.45 (inside a step) and 1 (at a step's end)
    return t < 0.45 ? Vec3(0, t / 0.45, 0) : Vec3((t - 0.45) / 0.55, 1, -2 * (t - 0.45) / 0.55);
  };
  const auto check = [&](const std::string& integrator, const System& system, double t) {
    expectNear(system.x[0], movement(t), 1e-14, fmt::format("x at {}", t));
    const Vec3 slope = t < 0.45 ? Vec3(0, 1 / 0.45, 0) : Vec3(1 / 0.55, 0, -2 / 0.55);
    expectNear(system.v[0], slope, 1e-13, fmt::format("v at {}", t));
    if (integrator == "<StaticSolver/>") expectNear(system.x[1], (system.x[0] + system.x[2]) / 2, 1e-10, "statics");
    if (t > 0.99) {
      EXPECT_EQ(Vec3(system.x[0]), Vec3(1, 1, -2)) << "the last key, to the bit";
    }
    EXPECT_EQ(Vec3(system.x[2]), Vec3(2, 0, 0));
  };
  stepWithAll("<LinearMovementProjectiveConstraint indices='0' keyTimes='0 0.45 1' movements='0 0 0 0 1 0 1 1 -2'/>",
              check);
}

/// Node 0 moves at V from the start: with w^2 = 2 k/m the middle node is at (x_0 + x_2)/2 - V/(2 w) sin w t.
TEST(LinearMovement, TheFreeNeighbourConvergesToTheClosedFormWithEveryIntegrator) {
  const double w = std::sqrt(40.), end = 0.4;
  const Vec3 speed(0.5, 1, -2);
  const auto errorWith = [&](const std::string& integrator, int steps) {
    Simulation simulation = simulationFromText(
        chain(integrator, "<LinearMovementProjectiveConstraint indices='0' keyTimes='0 1' movements='0 0 0 0.5 1 -2'/>",
              end / steps));
    for (int i = 0; i < steps; ++i) EXPECT_FALSE(simulation.step().diverged);
    const System& system = *simulation.systems().at(0);
    const Vec3 exact = (system.x[0] + system.x[2]) / 2 - speed / (2 * w) * std::sin(w * end);
    return (Vec3(system.x[1]) - exact).norm();
  };
  for (const std::string& integrator : integrators) {
    if (integrator == "<StaticSolver/>" || integrator.find("firstOrder") != std::string::npos ||
        integrator.find("rayleigh") != std::string::npos)
      continue;  // no inertia, or damped
    SCOPED_TRACE(integrator);
    const double coarse = errorWith(integrator, 100), fine = errorWith(integrator, 200);
    EXPECT_LT(coarse, 0.05 * speed.norm() / w) << "of the first order at least: w dt is 0.025";
    EXPECT_LT(fine, 0.6 * coarse + 1e-10) << "halving dt";
  }
}

TEST(LinearMovement, FreeOrHeldOutsideTheKeys) {
  const std::string keys = "indices='0' keyTimes='0.2 0.75' movements='0 0 0 0 1 0' ";
  Simulation free = simulationFromText(implicitChain("<LinearMovementProjectiveConstraint " + keys + "/>"));
  System& system = *free.systems().at(0);
  free.step(), free.step();
  const Vec3 start = system.x[0];
  EXPECT_GT(start.x(), 0.1) << "pulled by its spring until then";
  free.step();
  expectNear(system.x[0], start + Vec3(0, 0.1 / 0.55, 0), 1e-14, "relative to where the movement begins");
  for (int i = 3; i < 8; ++i) free.step();
  expectNear(system.x[0], start + Vec3(0, 1, 0), 1e-14, "the step that passes the last key ends there");
  EXPECT_EQ(system.constraints().projectors().size(), 2u);
  free.step();
  EXPECT_EQ(system.constraints().projectors().size(), 1u);
  EXPECT_GT((system.x[0] - start - Vec3(0, 1, 0)).norm(), 1e-3) << "free again";

  Simulation hold =
      simulationFromText(implicitChain("<LinearMovementProjectiveConstraint outside='hold' " + keys + "/>"));
  System& held = *hold.systems().at(0);
  for (int i = 0; i < 12; ++i) {
    hold.step();
    const double t = hold.time();
    expectNear(held.x[0], Vec3(0, std::clamp((t - 0.2) / 0.55, 0., 1.), 0), 1e-14, fmt::format("held at {}", t));
  }
  EXPECT_EQ(Vec3(held.v[0]), Vec3::Zero());
  expectContains(sceneFromText(implicitChain("<LinearMovementProjectiveConstraint " + keys + "/>")).diagnostics.text(),
                 "free before t = 0.2 s and after t = 0.75 s");
}

TEST(LinearMovement, AbsoluteAndPartial) {
  Simulation simulation = simulationFromText(implicitChain(
      "<LinearMovementProjectiveConstraint indices='0' keyTimes='0 1' movements='0 0 0 0 4 0' relativeMovements='0'/>"
      "<PartialLinearMovementProjectiveConstraint indices='1' keyTimes='0 1' movements='9 9 9 9 9 8' "
      "movedDirections='0 0 1'/>"));
  System& system = *simulation.systems().at(0);
  for (int i = 0; i < 5; ++i) simulation.step();
  expectNear(system.x[0], Vec3(0, 2, 0), 1e-14, "absolute");
  EXPECT_NEAR(system.x[1].z(), 8.5, 1e-14) << "an initial movement that is not zero counts, as in SOFA";
  EXPECT_GT(system.x[1].y(), 0.01) << "free to follow its neighbour";
  EXPECT_LT(system.x[1].y(), 1);
}

TEST(LinearMovement, RunsTheSameAfterAReset) {
  Simulation simulation = simulationFromText(
      implicitChain("<LinearMovementProjectiveConstraint indices='0' keyTimes='0.2 1' movements='0 0 0 0 1 0'/>"));
  const auto run = [&simulation] {
    for (int i = 0; i < 12; ++i) simulation.step();
    return simulation.stateHash();
  };
  const auto first = run();
  simulation.reset();
  EXPECT_EQ(run(), first);
}

TEST(LinearVelocity, PositionsAreTheIntegral) {
  stepWithAll("<LinearVelocityProjectiveConstraint indices='0' keyTimes='0 0.45 1' velocities='0 0 0 0 9 0 0 -2 0'/>",
              [](const std::string&, const System& system, double t) {
                const double s = t - 0.45, y = t < 0.45 ? 10 * t * t : 9 * 0.225 + 9 * s - 10 * s * s;
                EXPECT_NEAR(system.x[0].y(), y, 1e-13);
                EXPECT_NEAR(system.v[0].y(), t < 0.45 ? 20 * t : 9 - 20 * s, 1e-13);
              });
  Simulation on =
      simulationFromText(implicitChain("<LinearVelocityProjectiveConstraint indices='0' keyTimes='0 0.5' "
                                       "velocities='0 0 0 0 1 0' coordinates='1' continueAfterEnd='1'/>"));
  System& system = *on.systems().at(0);
  for (int i = 0; i < 10; ++i) on.step();
  EXPECT_NEAR(system.x[0].y(), 0.25 + 0.5, 1e-14);
  EXPECT_GT(std::abs(system.x[0].x()), 0.01) << "x is free";
}

TEST(AffineMovement, GoesStraightToTheImage) {
  Simulation simulation = simulationFromText(implicitChain(
      "<AffineMovementProjectiveConstraint indices='0' meshIndices='0 1' beginConstraintTime='0.2' "
      "endConstraintTime='0.7' "
      "quaternion='0 0 0.7071067811865476 0.7071067811865476' rotation='2 0 0 0 2 0 0 0 2' translation='0 0 1'/>"));
  System& system = *simulation.systems().at(0);
  simulation.step(), simulation.step();
  EXPECT_EQ(Vec3(system.x[0]), Vec3::Zero()) << "held before";
  const Vec3 from = system.x[1];
  EXPECT_EQ(from, Vec3(1, 0, 0)) << "balanced, so free and at rest";
  for (int i = 2; i < 7; ++i) {
    simulation.step();
    const double s = (simulation.time() - 0.2) / 0.5;
    expectNear(system.x[0], s * Vec3(0, 0, 1), 1e-14, "path of 0");
    expectNear(system.x[1], Vec3(1, 0, 0) + s * Vec3(-1, 2, 1), 1e-13,
               "path of 1: rotated by 90 degrees, doubled, moved");
  }
  simulation.step();
  EXPECT_EQ(Vec3(system.x[0]), Vec3(0, 0, 1)) << "held after";
  EXPECT_GT((system.x[1] - Vec3(0, 2, 1)).norm(), 1e-3) << "free after";
}

TEST(FixedPlane, ChoosesAndProjects) {
  Simulation simulation =
      simulationFromText(implicitChain("<FixedPlaneProjectiveConstraint direction='0 3 0' dmin='-0.1' dmax='0.1'/>"));
  System& system = *simulation.systems().at(0);
  ASSERT_EQ(system.constraints().projectors().size(), 3u);
  Vector f(3);
  for (Index i = 0; i < 3; ++i) f[i] = Vec3(1, 2, 3);
  system.constraints().project(f);
  EXPECT_EQ(Vec3(f[0]), Vec3(1, 0, 3));
  EXPECT_EQ(Vec3(f[2]), Vec3::Zero()) << "also fixed";
  const auto problems = [](const std::string& a) {
    return problemsOf(implicitChain("<FixedPlaneProjectiveConstraint " + a + "/>"));
  };
  expectContains(problems("direction='0 1 0' dmin='5' dmax='6'"), "no node of /dofs is between");
  expectContains(problems("direction='0 0 0' indices='1'"), "direction is zero");
  expectContains(problems("direction='0 1 0'"), "which nodes should be fixed");
}

TEST(ProjectTo, ArrivesInTheFirstStepAndStays) {
  for (const std::string& integrator : integrators) {
    SCOPED_TRACE(integrator);
    Simulation simulation =
        simulationFromText(chain(integrator,
                                 "<ProjectToLineProjectiveConstraint indices='1' origin='1 1 0' direction='2 0 2'/>"
                                 "<ProjectToPlaneProjectiveConstraint indices='0' origin='0 0 1' normal='0 0 5'/>"));
    System& system = *simulation.systems().at(0);
    for (int i = 0; i < 5; ++i) {
      ASSERT_FALSE(simulation.step().diverged);
      const Vec3 d = Vec3(1, 0, 1).normalized(), from = system.x[1] - Vec3(1, 1, 0);
      EXPECT_LT((from - d * d.dot(from)).norm(), 1e-14);
      EXPECT_NEAR(system.x[0].z(), 1, 1e-15);
      EXPECT_NEAR(system.v[0].z(), 0, 1e-15);
    }
    if (integrator != "<StaticSolver/>") continue;
    // the energy 10 (|x0 - x1|^2 + |x1 - x2|^2), x0 in z = 1, x1 on the line, x2 = (2, 0, 0), is lowest with x0 above
    // x1
    const double a = system.x[1].x() - 1;  // x1 = (1 + a, 1, a): (a - 1)^2 + (a - 1)^2 + 1 + a^2, so a = 2/3
    EXPECT_NEAR(a, 2. / 3, 1e-7);
  }
  Simulation point =
      simulationFromText(implicitChain("<ProjectToPointProjectiveConstraint indices='0' point='5 6 7'/>"));
  point.step();
  EXPECT_EQ(Vec3(point.systems().at(0)->x[0]), Vec3(5, 6, 7));
}

TEST(ProjectTo, TwoOnOneNodeMeetExactly) {
  // planes that are almost parallel: going from one to the other in turns gains a part in 1e4 each time
  const std::string planes =
      "<ProjectToPlaneProjectiveConstraint indices='0 1' origin='0 1 0' normal='0 1 0'/>"
      "<ProjectToPlaneProjectiveConstraint indices='0' origin='0 1 3' normal='0 1 0.01'/>";
  const std::string line_and_plane =
      "<ProjectToLineProjectiveConstraint indices='0' origin='0 1 0' direction='1 1 0'/>"
      "<ProjectToPlaneProjectiveConstraint indices='0' origin='0 0 1' normal='1 0 1'/>";
  for (const std::string& integrator : integrators) {
    SCOPED_TRACE(integrator);
    Simulation two = simulationFromText(chain(integrator, planes));
    Simulation three = simulationFromText(chain(integrator, line_and_plane));
    for (int i = 0; i < 3; ++i) {
      ASSERT_FALSE(two.step().diverged);
      const Vec3 x = two.systems().at(0)->x[0], v = two.systems().at(0)->v[0];
      EXPECT_NEAR(x.y(), 1, 1e-15);
      EXPECT_NEAR(x.z(), 3, 1e-11) << "round-off over the square of the angle";
      EXPECT_NEAR(v.y(), 0, 1e-12);
      EXPECT_NEAR(v.z(), 0, 1e-10);
      ASSERT_FALSE(three.step().diverged);
      EXPECT_NEAR((three.systems().at(0)->x[0] - Vec3(1, 2, 0)).norm(), 0, 1e-14);
    }
  }
}

TEST(ProjectTo, AMovementAlongOneAxisMeetsAPlane) {
  const std::string both =
      "<PartialLinearMovementProjectiveConstraint indices='0' keyTimes='0 1' movements='0 0 0 4 0 0' "
      "movedDirections='1 0 0'/><ProjectToPlaneProjectiveConstraint indices='0' origin='0 0 0' normal='1 1 0'/>";
  Simulation simulation = simulationFromText(implicitChain(both));
  const Vec3 start = simulation.systems().at(0)->x[0];
  for (int i = 0; i < 5; ++i) ASSERT_FALSE(simulation.step().diverged);
  const Vec3 x = simulation.systems().at(0)->x[0], v = simulation.systems().at(0)->v[0];
  EXPECT_NEAR(x.x(), start.x() + 4 * simulation.time(), 1e-14);
  EXPECT_NEAR(x.y(), -x.x(), 1e-14);
  EXPECT_NEAR(v.x(), 4, 1e-13);
  EXPECT_NEAR(v.y(), -4, 1e-13);
}

TEST(ProjectTo, PlacesWithoutACommonPointAreRefused) {
  const auto problems = [](const std::string& text) { return problemsOf(implicitChain(text)); };
  const std::string parallel = problems(
      "<ProjectToPlaneProjectiveConstraint name='low' indices='0' origin='0 1 0' normal='0 1 0'/>"
      "<ProjectToPlaneProjectiveConstraint name='high' indices='0' origin='0 2 0' normal='0 1 0'/>");
  expectContains(parallel, "node 0 of /dofs cannot be where both /low and /high put it");
  expectContains(parallel, "0.5 m");
  expectContains(parallel, "a point in common");
  expectContains(problems("<ProjectToPointProjectiveConstraint indices='0' point='0 1 0'/>"
                          "<ProjectToLineProjectiveConstraint indices='0' origin='0 2 0' direction='1 0 0'/>"),
                 "cannot be where");

  // that a movement leaves a plane shows when it does
  Simulation leaving = simulationFromText(
      implicitChain("<LinearMovementProjectiveConstraint name='up' indices='0' keyTimes='0 1' movements='0 0 0 0 1 0'/>"
                    "<ProjectToPlaneProjectiveConstraint name='floor' indices='0' origin='0 0 0' normal='0 1 0'/>"));
  const StepReport report = leaving.step();
  EXPECT_TRUE(report.diverged);
  expectContains(report.reason, "cannot be where both /up and /floor put it");
}

/// A face pressed half-way into a block of elements in one static step: the tangent carries the inside along.
TEST(MovingConstraints, StaticsCarriesTheBodyAlong) {
  Simulation simulation =
      simulationFromText(R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver newton_iterations="30"/>
    <SparseLDLSolver/><RegularGridTopology name="grid" n="9 3 3" min="0 0 0" max="8 2 2"/><MechanicalObject name="dofs"/>
    <UniformMass totalMass="1"/>
    <Node name="cells"><TetrahedronSetTopologyContainer name="tets"/>
    <Hexa2TetraTopologicalMapping input="@../grid" output="@tets" cutting="ten"/>
    <TetrahedronFEMForceField mstate="@../dofs" topology="@tets" youngModulus="1000" poissonRatio="0" method="svd" tangent="exact"/></Node>
    <BoxROI name="low" box="-0.1 -0.1 -0.1 0.1 2.1 2.1" position="@dofs.rest_position"/>
    <BoxROI name="high" box="7.9 -0.1 -0.1 8.1 2.1 2.1" position="@dofs.rest_position"/>
    <FixedProjectiveConstraint indices="@low.indices"/>
    <LinearMovementProjectiveConstraint indices="@high.indices" keyTimes="0 1" movements="0 0 0 -4 0 0"/></Node>)");
  System& system = *simulation.systems().at(0);
  const StepReport report = simulation.step();
  ASSERT_FALSE(report.diverged) << report.reason;
  EXPECT_TRUE(report.newton_converged);
  for (Index i = 0; i < system.x.count(); ++i)
    EXPECT_NEAR(system.x[i].x(), simulation.states().at(0)->rest_position[i].x() / 2, 1e-6);
  EXPECT_LE(report.newton_iterations, 2) << "with nu = 0 the tangent's answer is the answer";
}

/// late: where a step starts, however long it is.
TEST(MovingConstraints, LateOnesFollowThePresentStep) {
  const std::vector<std::pair<std::string, double (*)(double)>> movements = {
      {"<LinearMovementProjectiveConstraint late='true' indices='0' keyTimes='0 9' movements='0 0 0 36 0 0'/>",
       [](double t) { return 4 * t; }},
      {"<ParabolicProjectiveConstraint late='true' indices='0' P1='0 0 0' P2='1 0 0' P3='2 0 0' EndTime='4'/>",
       [](double t) { return t / 2; }},
      {"<AffineMovementProjectiveConstraint late='true' indices='0' translation='3 0 0' endConstraintTime='6'/>",
       [](double t) { return t / 2; }},
      {"<PatchTestMovementProjectiveConstraint late='true' indices='0' cornerPoints='0 0 0 2 0 0 2 2 0 0 2 0' "
       "cornerMovements='8 0 0 0 0 0 0 0 0 0 0 0' endConstraintTime='2'/>",
       [](double t) { return 4 * t; }},
      {"<OscillatorProjectiveConstraint late='true' oscillators='0  0 0 0  0.1 0 0  5 0'/>",
       [](double t) { return 0.1 * std::sin(5 * t); }}};
  for (const auto& [text, place] : movements) {
    SCOPED_TRACE(text);
    Simulation simulation = simulationFromText(implicitChain(text));
    for (const std::string dt : {"0.1", "0.2", "0.05"}) {
      simulation.setAttribute("/", "dt", dt);
      for (int i = 0; i < 3; ++i) {
        const double start = simulation.time();
        ASSERT_FALSE(simulation.step().diverged);
        EXPECT_NEAR(simulation.systems().at(0)->x[0].x(), place(start), 1e-13) << dt;
      }
    }
  }
}

/// Late velocities: the place is the sum of h w(t_i), the velocity w(t_i), with steps of any length and across kinks.
TEST(MovingConstraints, LateVelocitiesAreSumsOverTheSteps) {
  Simulation simulation = simulationFromText(implicitChain(
      "<LinearVelocityProjectiveConstraint late='true' indices='0' keyTimes='0 0.33 1 9' velocities='1 0 0 4 0 0 -2 0 0 6 0 0'/>"));
  const auto speed = [](double t) {
    return t < 0.33 ? 1 + 3 * t / 0.33 : t < 1 ? 4 - 6 * (t - 0.33) / 0.67 : -2 + 8 * (t - 1) / 8;
  };
  double place = simulation.systems().at(0)->x[0].x();
  for (const std::string dt : {"0.1", "0.2", "0.05"}) {
    simulation.setAttribute("/", "dt", dt);
    for (int i = 0; i < 4; ++i) {
      const double start = simulation.time();
      place += std::stod(dt) * speed(start);
      ASSERT_FALSE(simulation.step().diverged);
      EXPECT_NEAR(simulation.systems().at(0)->x[0].x(), place, 1e-12) << dt;
      EXPECT_NEAR(simulation.systems().at(0)->v[0].x(), speed(start), 1e-12) << dt;
    }
  }
}

/// velocity="zero" is of the ends of steps; with "still" the neighbours feel nothing within the step either.
TEST(MovingConstraints, NodesOfAPatchWithoutVelocityMoveWithinTheStep) {
  const double h = 0.1, k = 20, speed = 4, felt = 1 + h * (h * h * k * speed) / (1 + 2 * h * h * k);
  const std::vector<std::tuple<std::string, double, double>> all = {{"movement", felt, speed}, {"zero", felt, 0.}, {"still", 1., 0.}};
  for (const auto& [velocity, x, v] : all) {
    SCOPED_TRACE(velocity);
    Simulation simulation = simulationFromText(implicitChain(fmt::format(
        "<PatchTestMovementProjectiveConstraint velocity='{}' indices='0' cornerPoints='0 0 0 2 0 0 2 2 0 0 2 0' "
        "cornerMovements='4 0 0 0 0 0 0 0 0 0 0 0' endConstraintTime='1'/>",
        velocity)));
    ASSERT_FALSE(simulation.step().diverged);
    System& system = *simulation.systems().at(0);
    EXPECT_NEAR(system.x[0].x(), h * speed, 1e-13);
    EXPECT_NEAR(system.v[0].x(), v, 1e-13);
    EXPECT_NEAR(system.x[1].x(), x, 1e-10);
  }
}

TEST(MovingConstraints, SayWhatIsWrong) {
  const auto problems = [](const std::string& text) { return problemsOf(implicitChain(text)); };
  expectContains(problems("<LinearMovementProjectiveConstraint indices='0' keyTimes='0' movements='0 0 0'/>"),
                 "at least 2 times");
  expectContains(problems("<LinearMovementProjectiveConstraint indices='0' keyTimes='0 1' movements='0 0 0'/>"),
                 "movements has 1 values for 2 keyTimes");
  expectContains(
      problems("<LinearMovementProjectiveConstraint indices='0' keyTimes='0 1 1' movements='0 0 0 1 1 1 2 2 2'/>"),
      "keyTimes[2] = 1 is not after keyTimes[1] = 1");
  expectContains(problems("<LinearMovementProjectiveConstraint keyTimes='0 1' movements='0 0 0 1 1 1'/>"),
                 "which nodes should be fixed");
  expectContains(problems("<LinearMovementProjectiveConstraint indices='0' movements='0 0 0 1 1 1'/>"), "keyTimes");
  expectContains(
      problems(
          "<LinearVelocityProjectiveConstraint indices='0' keyTimes='0 1' velocities='0 0 0 1 1 1' coordinates='3'/>"),
      "axis 3");
  expectContains(problems("<LinearVelocityProjectiveConstraint ahead='1 0 0' indices='0' keyTimes='0.5 1' velocities='1 0 0 4 0 0'/>"),
                 "the first key is at 0.5 s");
  expectContains(problems("<AffineMovementProjectiveConstraint indices='0' rotation='1 0 0 1'/>"), "4 numbers");
  expectContains(problems("<AffineMovementProjectiveConstraint indices='0' endConstraintTime='-1'/>"), "is not after");
  expectContains(problems("<ProjectToLineProjectiveConstraint indices='0' direction='0 0 0'/>"), "direction is zero");
  for (const std::string integrator : {"EulerExplicitSolver", "StaticSolver"})
    expectContains(problemsOf(chain("<" + integrator + "/>",
                                    "<ProjectToLineProjectiveConstraint indices='0' direction='1 0 0' inMatrix='false'/>")),
                   integrator + " does not project the right side");
}

}  // namespace
}  // namespace stroma::test
