// SPDX-License-Identifier: LGPL-2.1-or-later
// Rigid bodies whose inertia is not the same about all axes, by every integrator: Euler's equations without torque against
// an integration of their own, heavy tops and pendulums against closed forms, and momentum.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "framework/mechanics/frames.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const Vec3 moments(1, 2, 3);  // [kg m^2]

/// q' = w q / 2 with J w = L: the angular momentum without torque, by fourth-order steps of 1e-4 s. In numbers x, y, z, w: tests are
/// compiled without optimisation.
Quaternion withoutTorque(const Quaternion& start, const Vec3& momentum, double time) {
  using Four = std::array<double, 4>;
  const double *l = momentum.data(), *inertia = moments.data();
  const auto rate = [&](const Four& q) {
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                            {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                            {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    double spin[3] = {0, 0, 0};  // in space
    for (int axis = 0; axis < 3; ++axis) {
      const double own = (r[0][axis] * l[0] + r[1][axis] * l[1] + r[2][axis] * l[2]) / inertia[axis];
      for (int c = 0; c < 3; ++c) spin[c] += r[c][axis] * own;
    }
    return Four{(spin[0] * w + spin[1] * z - spin[2] * y) / 2, (spin[1] * w + spin[2] * x - spin[0] * z) / 2,
                (spin[2] * w + spin[0] * y - spin[1] * x) / 2, -(spin[0] * x + spin[1] * y + spin[2] * z) / 2};
  };
  const auto moved = [](const Four& from, double h, const Four& by) {
    return Four{from[0] + h * by[0], from[1] + h * by[1], from[2] + h * by[2], from[3] + h * by[3]};
  };
  const int steps = int(std::lround(time / 1e-4));
  const double h = time / steps;
  Four q{start.x(), start.y(), start.z(), start.w()};
  for (int i = 0; i < steps; ++i) {
    const Four a = rate(q), b = rate(moved(q, h / 2, a)), c = rate(moved(q, h / 2, b)), d = rate(moved(q, h, c));
    double square = 0;
    for (std::size_t k = 0; k < 4; ++k) q[k] += h / 6 * (a[k] + 2 * b[k] + 2 * c[k] + d[k]), square += q[k] * q[k];
    for (double& number : q) number /= std::sqrt(square);
  }
  return Quaternion(q[3], q[0], q[1], q[2]);
}

/// A body that spins about its middle axis, nearly, and tumbles (Dzhanibekov).
std::string top(const std::string& integrator, double dt) {
  return fmt::format(R"(<Node name="root" dt="{}" gravity="0 0 0">{}<CGLinearSolver iterations="50" tolerance="1e-14"/>
    <MechanicalObject name="dofs" template="Rigid3" position="1 2 3  0.5 0.1 -0.3 0.806" velocity="0.3 0 0  0.4 3 -0.5"/>
    <UniformMass totalMass="2" inertia="1 2 3"/></Node>)",
                     dt, integrator);
}

struct TopRun {
  double angle = 0, momentum = 0, energy = 0;  ///< from the reference; relative changes
};

TopRun run(const std::string& integrator, double dt, double time) {
  Simulation simulation = simulationFromText(top(integrator, dt));
  System& system = *simulation.systems()[0];
  const auto inertia = [&] {
    const Mat3 r = orientationIn(system.x, 1).toRotationMatrix();
    return Mat3(r * moments.asDiagonal() * r.transpose());
  };
  const Quaternion start = orientationIn(system.x, 1);
  const Vec3 momentum = inertia() * system.v[1];
  const double energy = system.kineticEnergy();
  const int steps = int(std::lround(time / dt));
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.step();
    if (report.diverged) throw std::runtime_error(report.reason);
  }
  TopRun result;
  result.angle = orientationIn(system.x, 1).angularDistance(withoutTorque(start, momentum, time));
  result.momentum = (inertia() * system.v[1] - momentum).norm() / momentum.norm();
  result.energy = std::abs(system.kineticEnergy() / energy - 1);
  return result;
}

/// How well the angular momentum is kept. That of central differences is of the middle of steps, and is not seen.
enum class Momentum { to_round_off, to_order, unseen };

struct Method {
  const char* name;
  const char* integrator;
  double order;
  Momentum momentum;
};
std::ostream& operator<<(std::ostream& out, const Method& method) { return out << method.name; }

class AsymmetricTop : public testing::TestWithParam<Method> {};

TEST_P(AsymmetricTop, TumblesWithTheOrderOfItsMethod) {
  const Method& method = GetParam();
  const double dt = method.order == 1 ? 0.001 : 0.01;
  const TopRun coarse = run(method.integrator, dt, 4), fine = run(method.integrator, dt / 2, 4);
  const double order = std::log2(coarse.angle / fine.angle);
  RecordProperty("angle", fmt::format("{:.3g}", fine.angle));
  RecordProperty("order", fmt::format("{:.3f}", order));
  EXPECT_NEAR(order, method.order, 0.2) << coarse.angle << " " << fine.angle;
  EXPECT_LT(fine.angle, 0.1);
  if (method.momentum == Momentum::to_order) EXPECT_NEAR(std::log2(coarse.momentum / fine.momentum), method.order, 0.5);
  if (method.momentum == Momentum::to_round_off) EXPECT_LT(fine.momentum, 1e-12);
  RecordProperty("energy", fmt::format("{:.3g} {:.3g}", coarse.energy, fine.energy));
  // of central differences the energy is of velocities between places; to round-off there is no order
  constexpr double round_off = 1e-11;
  if (method.momentum != Momentum::unseen && fine.energy > round_off)
    EXPECT_GT(std::log2(coarse.energy / fine.energy), method.order - 0.3) << coarse.energy << " " << fine.energy;
}

INSTANTIATE_TEST_SUITE_P(
    Integrators, AsymmetricTop,
    testing::Values(
        Method{"Euler", "<EulerImplicitSolver/>", 1, Momentum::to_round_off},
        Method{"EulerNewton", "<EulerImplicitSolver newtonIterations='30'/>", 1, Momentum::to_round_off},
        Method{"Trapezoidal", "<EulerImplicitSolver trapezoidalScheme='true'/>", 2, Momentum::to_round_off},
        Method{"TrapezoidalNewton", "<TrapezoidalRuleSolver newtonIterations='30'/>", 2, Momentum::to_round_off},
        Method{"TrapezoidalTwice", "<TrapezoidalRuleSolver newtonIterations='2'/>", 2, Momentum::to_round_off},
        Method{"Newmark", "<NewmarkImplicitSolver/>", 2, Momentum::to_round_off},
        Method{"NewmarkNewton", "<NewmarkImplicitSolver newtonIterations='30'/>", 2, Momentum::to_round_off},
        Method{"NewmarkThrice", "<NewmarkImplicitSolver newtonIterations='3'/>", 2, Momentum::to_round_off},
        Method{"BDF2", "<BDFOdeSolver order='2'/>", 2, Momentum::to_round_off},
        Method{"BDF2Twice", "<BDFOdeSolver order='2' newtonIterations='2'/>", 2, Momentum::to_round_off},
        Method{"Midpoint", "<VariationalSymplecticSolver/>", 2, Momentum::to_round_off},
        Method{"SymplecticEuler", "<EulerExplicitSolver/>", 1, Momentum::to_round_off},
        Method{"CentralDifferences", "<CentralDifferenceSolver/>", 2, Momentum::unseen},
        Method{"RungeKutta2", "<RungeKutta2Solver/>", 2, Momentum::to_order},
        Method{"RungeKutta4", "<RungeKutta4Solver/>", 4, Momentum::to_order},
        Method{"Verlet", "<NewtonCotesSolver degree='1'/>", 2, Momentum::to_order}),
    [](const auto& values) { return std::string(values.param.name); });

/// A light rotor on a spring swings as it does alone, whatever forces act on other bodies.
TEST(TurningBodies, HeavyLoadsElsewhereLeaveALightRotorAsItIs) {
  const auto orientation = [](const std::string& more) {
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="0.01" gravity="0 0 0"><TrapezoidalRuleSolver newtonIterations="30"/><SparseLDLSolver/>
        <Node name="rotor"><MechanicalObject template="Rigid3" position="1 2 3  0.5 0.1 -0.3 0.806"
          rest_position="1 2 3  0 0 0 1" velocity="0 0 0  4 3 -5"/><UniformMass totalMass="1e-3" inertia="1e-6 2e-6 3e-6"/>
        <RestShapeSpringsForceField stiffness="1" angularStiffness="1e-3"/></Node>{}</Node>)", more));
    for (int i = 0; i < 50; ++i) EXPECT_TRUE(simulation.step().newton_converged);
    return orientationIn(simulation.systems()[0]->x, 1);
  };
  const Quaternion alone = orientation("");
  const Quaternion beside = orientation(R"(<Node name="weight"><MechanicalObject position="1 0 0" rest_position="0 0 0"/>
    <UniformMass totalMass="1e6"/><RestShapeSpringsForceField stiffness="1e8"/></Node>)");
  EXPECT_LT(beside.angularDistance(alone), 1e-6);
}

/// Without turning inertia and w x J w, as SOFA computes, the spin does not change: the body does not tumble.
TEST(TurningBodies, InFixedAxesTheSpinStays) {
  std::string text = top("<EulerImplicitSolver/>", 0.01);
  text.replace(text.find("inertia="), 0, "turns=\"false\" ");
  Simulation simulation = simulationFromText(text);
  for (int i = 0; i < 100; ++i) ASSERT_FALSE(simulation.step().diverged);
  EXPECT_LT((simulation.systems()[0]->v[1] - Vec3(0.4, 3, -0.5)).norm(), 1e-12);
}

/// A symmetric top on a fixed tip, its weight at `l` on its axis, started in regular precession:
///   m g l = J3 w3 W - J1 W^2 cos(theta),  w3 the spin about the axis, W the rate of precession, theta the nutation.
std::string heavyTop(const std::string& integrator, double dt, const Vec3& spin, const Quaternion& q) {
  return fmt::format(R"(<Node name="root" dt="{}" gravity="0 0 0">{}<SparseLDLSolver/>
    <MechanicalObject name="dofs" template="Rigid3" position="0 0 0  {} {} {} {}" velocity="0 0 0  {} {} {}"/>
    <UniformMass totalMass="1" inertia="0.2 0.2 0.1"/><FixedTranslationProjectiveConstraint indices="0"/>
    <Node name="weight"><MechanicalObject name="point" position="0 0 0.5"/><RigidMapping/>
    <ConstantForceField forces="0 0 -4"/></Node></Node>)",
                     dt, integrator, q.x(), q.y(), q.z(), q.w(), spin.x(), spin.y(), spin.z());
}

class HeavyTop : public testing::TestWithParam<const char*> {};

TEST_P(HeavyTop, PrecessesRegularly) {
  const double theta = 0.6, rate = 2, j1 = 0.2, j3 = 0.1, moment = 4 * 0.5;
  const double w3 = (moment + j1 * rate * rate * std::cos(theta)) / (j3 * rate);
  const Quaternion q(Eigen::AngleAxisd(theta, Vec3::UnitY()));
  const Vec3 axis = q * Vec3::UnitZ();
  // the whole angular velocity: W about z, and what is missing to w3 about the axis
  const Vec3 spin = rate * Vec3::UnitZ() + (w3 - rate * std::cos(theta)) * axis;
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    const double dt = 0.004 / (1 << k);
    Simulation simulation = simulationFromText(heavyTop(GetParam(), dt, spin, q));
    for (int i = 0; i < 250 * (1 << k); ++i) ASSERT_FALSE(simulation.step().diverged);
    const Vec3 now = orientationIn(simulation.systems()[0]->x, 1) * Vec3::UnitZ();
    const Vec3 exact = Eigen::AngleAxisd(rate * 1.0, Vec3::UnitZ()) * axis;
    errors[k] = (now - exact).norm();
  }
  EXPECT_GT(errors[0] / errors[1], 3.4) << "second order: " << errors[0];
  EXPECT_LT(errors[1], 2e-3);
}

INSTANTIATE_TEST_SUITE_P(Integrators, HeavyTop,
                         testing::Values("<TrapezoidalRuleSolver newtonIterations='20'/>",
                                         "<VariationalSymplecticSolver/>", "<RungeKutta4Solver/>",
                                         "<RungeKutta2Solver/>"),
                         [](const auto& values) { return fmt::format("Case{}", values.index); });

/// Frames are turned many at once, small turns without trigonometry.
TEST(TurningBodies, EachOfManyFramesTurnsByItsVelocity) {
  const double sizes[] = {0, 1e-300, 1e-9, 0.01, 0.24, 0.2449, 0.245, 0.3, 1, 3, 4, 7};
  const Vec3 axis = Vec3(1, -2, 0.5).normalized();
  const Quaternion start(Eigen::AngleAxisd(0.7, Vec3(0.3, 0.2, -1).normalized()));
  constexpr int frames = 77;
  std::string places, velocities;
  for (int i = 0; i < frames; ++i) {
    const Vec3 w = sizes[i % 12] * axis;
    places += fmt::format("{} 0 0  {:.17g} {:.17g} {:.17g} {:.17g}  ", i, start.x(), start.y(), start.z(), start.w());
    velocities += fmt::format("0 0 0  {:.17g} {:.17g} {:.17g}  ", w.x(), w.y(), w.z());
  }
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="1" gravity="0 0 0"><EulerExplicitSolver/><MechanicalObject template="Rigid3" position="{}"
      velocity="{}"/><UniformMass totalMass="2" inertia="1 1 1"/></Node>)",
      places, velocities));
  const System& system = *simulation.systems()[0];
  const Quaternion first = orientationIn(system.x, 1);
  for (int step = 1; step <= 3; ++step) {
    ASSERT_FALSE(simulation.step().diverged);
    for (int i = 0; i < frames; ++i) {
      const Quaternion now = orientationIn(system.x, 2 * i + 1);
      const Quaternion expected = Quaternion(Eigen::AngleAxisd(step * sizes[i % 12], axis)) * first;
      EXPECT_LT((now * expected.conjugate()).vec().norm(), 3e-15) << step << " of " << sizes[i % 12];
      EXPECT_NEAR(now.norm(), 1, 4e-16);
      EXPECT_GT(now.dot(expected), 0) << "of q and -q the one that the motion leads to";
      if (i % 12 == 0) EXPECT_EQ(now.coeffs(), first.coeffs()) << "it stands still";
    }
  }
}

/// A physical pendulum: the quarter of its period is K(sin(a/2)) sqrt(J/(m g l)).
TEST(TurningBodies, APendulumHasItsPeriod) {
  const double amplitude = 2.0, inertia = 0.3, moment = 4 * 0.5;
  double a = 1, b = std::cos(amplitude / 2);  // arithmetic-geometric mean
  for (int i = 0; i < 8; ++i) std::tie(a, b) = std::pair((a + b) / 2, std::sqrt(a * b));
  const double quarter = std::numbers::pi / (2 * a) * std::sqrt(inertia / moment);
  Simulation simulation =
      simulationFromText(fmt::format(R"(<Node name="root" dt="{}" gravity="0 0 0">
    <TrapezoidalRuleSolver newtonIterations="20"/><SparseLDLSolver/>
    <MechanicalObject name="dofs" template="Rigid3" position="0 0 0  {} 0 0 {}"/>
    <UniformMass totalMass="1" inertia="0.3 0.2 0.15"/><FixedTranslationProjectiveConstraint indices="0"/>
    <Node name="weight"><MechanicalObject position="0 0 -0.5"/><RigidMapping/><ConstantForceField forces="0 0 -4"/></Node>
    </Node>)",
                                     quarter / 400, std::sin(amplitude / 2), std::cos(amplitude / 2)));
  for (int i = 0; i < 400; ++i) ASSERT_FALSE(simulation.step().diverged);
  const Vec3 hangs = orientationIn(simulation.systems()[0]->x, 1) * Vec3(0, 0, -1);
  EXPECT_NEAR(std::atan2(hangs.y(), -hangs.z()), 0, 3e-4);
}

struct Momenta {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();  ///< about the origin
};
Momenta momentaOf(System& system) {
  Momenta sum;
  Vector p(system.allRows());
  system.kineticEnergy();  // inertia at the present orientations
  system.addMassProduct(system.v, 1, p);
  for (Index row = 0; row < system.independentRows(); ++row) {
    if (system.motion().kindOf(row) == RowKind::turn) {
      sum.angular += p[row];
      continue;
    }
    sum.linear += p[row];
    sum.angular += Vec3(system.x[row]).cross(Vec3(p[row]));
  }
  return sum;
}

/// Two bodies, and particles between them, on springs that end on points of the bodies.
class JoinedBodies : public testing::TestWithParam<const char*> {};

TEST_P(JoinedBodies, KeepTheirMomentumToRoundOff) {
  Simulation simulation = simulationFromText(fmt::format(R"(<Node name="root" dt="0.005" gravity="0 0 0">{}
    <CGLinearSolver iterations="400" tolerance="1e-15"/>
    <Node name="bodies"><MechanicalObject name="dofs" template="Rigid3" position="0 0 0  0.1 0.2 0 0.97   2 0 0  0 0 0.3 0.95"
      velocity="0.1 0.2 0  1 -2 0.5   0 -0.2 0.4  0 1 3"/><UniformMass totalMass="3" inertia="0.1 0.2 0.25"/>
    <Node name="points"><MechanicalObject name="dofs" position="0.3 0 0  0.3 0.3 0  -0.3 0 0  -0.3 0.3 0.1"/>
      <RigidMapping rigidIndexPerPoint="0 0 1 1"/></Node></Node>
    <Node name="soft"><MechanicalObject name="dofs" position="0.8 0.1 0  1.2 -0.1 0.1"/><UniformMass totalMass="0.5"/>
      <SpringForceField springsIndices1="0" springsIndices2="1" lengths="0.4" stiffness="50"/>
      <SpringForceField object1="@dofs" object2="@../bodies/points/dofs" springsIndices1="0 0 0 1 1 1"
        springsIndices2="0 1 2 1 2 3" lengths="0.4" stiffness="80"/></Node></Node>)",
                                                         GetParam()));
  System& system = *simulation.systems()[0];
  const Momenta start = momentaOf(system);
  for (int i = 0; i < 200; ++i) {
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.diverged) << report.reason;
  }
  const Momenta end = momentaOf(system);
  EXPECT_LT((end.linear - start.linear).norm(), 1e-12 * start.linear.norm());
  EXPECT_LT((end.angular - start.angular).norm(), 2e-12 * start.angular.norm());
  EXPECT_GT((system.v[1] - Vec3(1, -2, 0.5)).norm(), 0.1) << "the springs act";
}

INSTANTIATE_TEST_SUITE_P(Integrators, JoinedBodies,
                         testing::Values("<EulerExplicitSolver/>",
                                         "<VariationalSymplecticSolver newtonError='1e-14' steps='60'/>"),
                         [](const auto& values) { return fmt::format("Case{}", values.index); });

/// A beam of tetrahedra of 3 x 1 x 1 cells whose ends are parts of two free bodies. Rotations are polar factors, so that the elements
/// have no resultant torque.
std::string beamBetweenBodies(const std::string& integrator, double dt) {
  std::string nodes, ends[2], inner, pairs, tetrahedra;
  int held[2] = {0, 0}, free = 0;
  for (int node = 0; node < 16; ++node) {
    const int i = node % 4;
    const std::string place = fmt::format("{} {} {}  ", 0.1 * i, 0.1 * (node / 4 % 2), 0.1 * (node / 8));
    nodes += place;
    const std::size_t end = i == 3 ? 1 : 0;
    if (i == 0 || i == 3) {
      ends[end] += place;
      pairs += fmt::format("{} {}  ", end, held[end]++);
    } else {
      inner += place;
      pairs += fmt::format("2 {}  ", free++);
    }
  }
  constexpr int step[3] = {1, 4, 8}, orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
  for (int cell = 0; cell < 3; ++cell)
    for (int k = 0; k < 6; ++k) {
      const int second = cell + step[orders[k][0]], third = second + step[orders[k][1]];
      tetrahedra += fmt::format("{} {} {} {}  ", cell, k < 3 ? second : third, k < 3 ? third : second, cell + 13);
    }
  const auto body = [&](const char* name, const char* place, const char* velocity, const std::string& points) {
    return fmt::format(R"(<Node name="{}"><MechanicalObject name="dofs" template="Rigid3" position="{}" velocity="{}"/>
      <UniformMass totalMass="1.5" inertia="0.01 0.02 0.025"/><Node name="end"><MechanicalObject name="dofs" position="{}"/>
      <RigidMapping globalToLocalCoords="true"/></Node></Node>)", name, place, velocity, points);
  };
  return fmt::format(R"(<Node name="root" dt="{}" gravity="0 0 0">{}<SparseLDLSolver/>{}{}
    <Node name="inner"><MechanicalObject name="dofs" position="{}"/><UniformMass vertexMass="0.05"/></Node>
    <Node name="beam"><MeshTopology position="{}" tetrahedra="{}"/><MechanicalObject name="dofs" position="{}"/>
    <SubsetMultiMapping input="@../first/end/dofs @../second/end/dofs @../inner/dofs" indexPairs="{}"/>
    <TetrahedronFEMForceField method="polar" youngModulus="2e4" poissonRatio="0.3"/></Node></Node>)",
                     dt, integrator, body("first", "-0.2 0 0.05  0.1 0.2 0 0.97", "0.1 0.2 0  1 -2 0.5", ends[0]),
                     body("second", "0.5 0.1 0  0 0 0.3 0.95", "0 -0.2 0.4  0 1 3", ends[1]), inner, nodes, tetrahedra, nodes, pairs);
}

struct MomentumChange {
  double linear = 0, angular = 0;  ///< relative
};
MomentumChange changeOver(const std::string& integrator, double dt, double time) {
  Simulation simulation = simulationFromText(beamBetweenBodies(integrator, dt));
  System& system = *simulation.systems()[0];
  const Momenta start = momentaOf(system);
  for (int i = 0; i < std::lround(time / dt); ++i) {
    const StepReport report = simulation.step();
    if (report.diverged) throw std::runtime_error(report.reason);
  }
  const Momenta end = momentaOf(system);
  EXPECT_GT((system.v[1] - Vec3(1, -2, 0.5)).norm(), 0.5) << "the beam acts on the first body";
  EXPECT_GT((system.v[3] - Vec3(0, 1, 3)).norm(), 0.5) << "and on the second one";
  return {(end.linear - start.linear).norm() / start.linear.norm(), (end.angular - start.angular).norm() / start.angular.norm()};
}

TEST(SoftBeamBetweenBodies, KeepsBothMomentaToRoundOff) {
  for (const auto& [integrator, dt] : {std::pair("<EulerExplicitSolver/>", 0.001),
                                       std::pair("<VariationalSymplecticSolver newtonError='1e-14' steps='60'/>", 0.005)}) {
    const MomentumChange change = changeOver(integrator, dt, 0.3);
    EXPECT_LT(change.linear, 1e-12) << integrator;
    EXPECT_LT(change.angular, 1e-12) << integrator;
  }
}

/// Backward Euler adds h^2 sum of v x f per step to the angular momentum: it is kept to first order, the linear one to round-off.
TEST(SoftBeamBetweenBodies, KeepsItsAngularMomentumToFirstOrderByBackwardEuler) {
  const std::string euler = "<EulerImplicitSolver newtonIterations='40' newtonTolerance='1e-13'/>";
  const MomentumChange coarse = changeOver(euler, 0.0005, 0.1), fine = changeOver(euler, 0.00025, 0.1);
  EXPECT_LT(coarse.linear, 1e-12);
  EXPECT_LT(fine.linear, 1e-12);
  EXPECT_NEAR(std::log2(coarse.angular / fine.angular), 1, 0.2) << coarse.angular << " " << fine.angular;
  EXPECT_LT(fine.angular, 0.01);
}

/// Two rods of 1 m and 1 kg on hinges, let go level, by their two angles from the horizontal:
///   4/3 a'' + c b'' + s b'^2 + 3/2 g cos a = 0,   c a'' + 1/3 b'' - s a'^2 + 1/2 g cos b = 0
/// with c = cos(a - b)/2 and s = sin(a - b)/2.
Eigen::Vector4d doublePendulum(double time) {
  const auto rate = [](const Eigen::Vector4d& y) {
    const double c = std::cos(y[0] - y[1]) / 2, s = std::sin(y[0] - y[1]) / 2, g = 9.81;
    const double r = -s * y[3] * y[3] - 1.5 * g * std::cos(y[0]), q = s * y[2] * y[2] - 0.5 * g * std::cos(y[1]);
    const double det = 4. / 9 - c * c;
    return Eigen::Vector4d(y[2], y[3], (r / 3 - c * q) / det, (4. / 3 * q - c * r) / det);
  };
  Eigen::Vector4d y = Eigen::Vector4d::Zero();
  const int steps = 20000;
  const double h = time / steps;
  for (int i = 0; i < steps; ++i) {
    const Eigen::Vector4d a = rate(y), b = rate(y + h / 2 * a), c = rate(y + h / 2 * b), d = rate(y + h * c);
    y += h / 6 * (a + 2 * b + 2 * c + d);
  }
  return y;
}

std::string articulatedRods(const std::string& integrator, double dt) {
  return fmt::format(R"(<Node name="root" gravity="0 -9.81 0" dt="{}">{}<SparseLDLSolver/>
    <MechanicalObject name="angles" template="Vec1" position="0 0"/>
    <Node name="rods"><MechanicalObject name="frames" template="Rigid3" position="0 0 0  0 0 0 1   0.5 0 0  0 0 0 1   1.5 0 0  0 0 0 1"/>
    <UniformMass indices="1 2" vertexMass="1" inertia="0.001 {:.17g} {:.17g}"/>
    <ArticulatedSystemMapping input1="@../angles" output="@frames"/><ArticulatedHierarchyContainer/>
    <Node name="a"><ArticulationCenter parentIndex="0" childIndex="1" posOnChild="-0.5 0 0"/>
      <Articulation rotation="true" rotationAxis="0 0 1" articulationIndex="0"/></Node>
    <Node name="b"><ArticulationCenter parentIndex="1" childIndex="2" posOnParent="0.5 0 0" posOnChild="-0.5 0 0"/>
      <Articulation rotation="true" rotationAxis="0 0 1" articulationIndex="1"/></Node></Node></Node>)",
                     dt, integrator, 1. / 12, 1. / 12);
}

TEST(TurningBodies, ADoublePendulumSwingsAsItsEquationsSay) {
  const Eigen::Vector4d exact = doublePendulum(1);
  for (const auto& [integrator, order] : {std::pair("<RungeKutta4Solver/>", 4.), std::pair("<RungeKutta2Solver/>", 2.),
                                          std::pair("<VariationalSymplecticSolver newtonError='1e-12'/>", 2.),
                                          std::pair("<EulerImplicitSolver newtonIterations='20'/>", 1.)}) {
    double error[2];
    for (int k = 0; k < 2; ++k) {
      const double dt = (order == 1 ? 0.0005 : 0.01) / (1 << k);
      Simulation simulation = simulationFromText(articulatedRods(integrator, dt));
      for (int i = 0; i < std::lround(1 / dt); ++i) {
        const StepReport report = simulation.step();
        ASSERT_FALSE(report.diverged) << report.reason;
      }
      const System& system = *simulation.systems()[0];
      error[k] = std::hypot(system.x[0][0] - exact[0], system.x[0][0] + system.x[1][0] - exact[1]);
    }
    EXPECT_NEAR(std::log2(error[0] / error[1]), order, 0.3) << integrator;
    EXPECT_LT(error[1], 0.02) << integrator;
  }
}

TEST(TurningBodies, ARestartAndACheckpointGoOnToTheBit) {
  for (const char* integrator :
       {"<NewmarkImplicitSolver/>", "<BDFOdeSolver order='2'/>", "<CentralDifferenceSolver/>"}) {
    Simulation simulation = simulationFromText(top(integrator, 0.01));
    for (int i = 0; i < 5; ++i) simulation.step();
    const Archive middle = simulation.checkpoint();
    for (int i = 0; i < 5; ++i) simulation.step();
    const auto end = simulation.stateHash();
    simulation.restore(middle.readable());
    for (int i = 0; i < 5; ++i) simulation.step();
    EXPECT_EQ(simulation.stateHash(), end) << integrator;
    simulation.reset();
    for (int i = 0; i < 10; ++i) simulation.step();
    EXPECT_EQ(simulation.stateHash(), end) << integrator;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
