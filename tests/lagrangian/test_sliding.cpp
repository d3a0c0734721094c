// SPDX-License-Identifier: LGPL-2.1-or-later
// A point on a curve: on it at the end of every step, whatever corners it passes and however the curve moves.
#include <Eigen/Geometry>

#include "tests/lagrangian/lagrangian_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using namespace lagrangian;

/// Of node `bead` to the curve of nodes [0, last].
double distanceToCurve(const Simulation& simulation, Index bead, Index last) {
  double least = 1e300;
  const Vec3 p = at(simulation, bead);
  for (Index i = 0; i < last; ++i) {
    const Vec3 a = at(simulation, i), way = at(simulation, i + 1) - a;
    least = std::min(least, (p - a - std::clamp((p - a).dot(way) / way.squaredNorm(), 0.0, 1.0) * way).norm());
  }
  return least;
}

std::string places(const std::vector<Vec3>& points) {
  std::string text;
  for (const Vec3& p : points) text += fmt::format("{:.17g} {:.17g} {:.17g}  ", p.x(), p.y(), p.z());
  return text;
}

std::string curveOf(std::size_t nodes) {
  std::string text;
  for (std::size_t i = 0; i < nodes; ++i) text += fmt::format("{} ", i);
  return text;
}

/// Fixed nodes and a bead.
std::string beadOn(std::vector<Vec3> curve, const Vec3& bead, const std::string& more = "") {
  const std::size_t n = curve.size();
  curve.push_back(bead);
  return fmt::format("<MechanicalObject name=\"dofs\" position=\"{}\"/><UniformMass vertexMass=\"1\"/>"
                     "<FixedProjectiveConstraint indices=\"{}\"/>{}<SlidingLagrangianConstraint sliding_point=\"{}\" curve=\"{}\"/>",
                     places(curve), curveOf(n), more, n, curveOf(n));
}

std::vector<Vec3> wave(int pieces) {
  std::vector<Vec3> points;
  for (int i = 0; i <= pieces; ++i) {
    const double t = double(i) / pieces;
    points.emplace_back(3 * t, -2 * t + 0.06 * std::sin(20 * t), 0.2 * std::cos(9 * t));
  }
  return points;
}

/// Down a wire whose corners bend towards the bead and away from it, some in a step. All rules.
TEST(Sliding, ABeadIsOnItsCurveAfterEveryStep) {
  for (const char* integrator :
       {"<EulerImplicitSolver/>", "<EulerImplicitSolver newtonIterations=\"30\" newtonTolerance=\"1e-12\"/>", "<BDFOdeSolver order=\"2\"/>",
        "<TrapezoidalRuleSolver/>"})
    for (const double dt : {0.003, 0.02}) {
      SCOPED_TRACE(fmt::format("{} {}", integrator, dt));
      const std::vector<Vec3> wire = wave(60);
      Simulation simulation = simulationFromText(
          sceneOf(beadOn(wire, wire[1] + 0.3 * (wire[2] - wire[1])), dt, "0 -10 0", integrator));
      double lowest = 0;
      for (int i = 0; i < int(2.5 / dt); ++i) {
        run(simulation, 1);
        if (HasFatalFailure()) return;
        ASSERT_LT(distanceToCurve(simulation, 61, 60), 1e-10) << "step " << i;
        lowest = std::min(lowest, at(simulation, 61).y());
      }
      EXPECT_LT(lowest, -1.9) << "it came down";
    }
}

/// Between two slopes it comes to rest at the corner, which bears its weight: a force that is no piece's own.
TEST(Sliding, ABeadRestsInAValley) {
  Simulation simulation = simulationFromText(sceneOf(
      beadOn({{-2, 2, 0}, {-1, 0.8, 0.1}, {0, 0, 0}, {1, 0.5, 0}, {2, 2, 0}}, {-1.5, 1.4, 0.05}), 0.01, "0 -10 0",
      "<EulerImplicitSolver rayleighMass=\"2\"/>"));
  run(simulation, 400);
  EXPECT_LT(at(simulation, 5).norm(), 1e-9);
  const std::vector<double> forces = numbersOf(simulation, "SlidingLagrangianConstraint", "forces");
  ASSERT_EQ(forces.size(), 4u);
  EXPECT_NEAR(std::sqrt(forces[0] * forces[0] + forces[1] * forces[1] + std::pow(forces[2] - forces[3], 2)), g, 1e-6);
}

/// A spring draws it to a point beside the curve: it rests at the nearest place of the curve that is downhill, over several corners,
/// on a piece or at a corner. In one step of statics, and of dynamics with large steps.
TEST(Sliding, ASpringDrawsItToTheNearestPlace) {
  const std::vector<Vec3> curve{{0, 0, 0}, {1, 0, 0}, {2, 0.2, 0}, {3, 0.6, 0}, {4, 0.3, 0}, {5, -0.5, 0}};
  struct Case {
    Vec3 to, rests;
  };
  const Vec3 u = (curve[4] - curve[3]).normalized();
  const Vec3 beside = curve[3] + 0.5 * (curve[4] - curve[3]) + Vec3(0.3 * u.y(), -0.3 * u.x(), 0.2);
  const Case cases[]{{{3, 1.4, 0.3}, curve[3]}, {beside, curve[3] + 0.5 * (curve[4] - curve[3])}, {{7, -1, 1}, curve[5]}};
  for (const Case& wanted : cases)
    for (const std::string integrator : {"<StaticSolver/>", "<EulerImplicitSolver rayleighMass=\"1\"/>"}) {
      SCOPED_TRACE(integrator);
      std::string text = beadOn(curve, {0.5, 0, 0}, "<RestShapeSpringsForceField points=\"6\" stiffness=\"50\"/>");
      std::vector<Vec3> rest = curve;
      rest.push_back(wanted.to);
      text.insert(text.find("\"/>"), "\" rest_position=\"" + places(rest));
      Simulation simulation = simulationFromText(sceneOf(text, 0.5, "0 0 0", integrator));
      run(simulation, integrator[1] == 'S' ? 1 : 60);
      if (HasFatalFailure()) return;
      EXPECT_LT((at(simulation, 6) - wanted.rests).norm(), 1e-7) << at(simulation, 6).transpose();
    }
}

/// A soft curve in flight, with two beads on it that pass its corners: the forces are those of the very point, so that they add
/// neither momentum nor torque.
TEST(Sliding, ACurveInFlightKeepsItsMomentum) {
  std::vector<Vec3> points = wave(12);
  std::string springs, velocity;
  for (int i = 0; i < 12; ++i) springs += fmt::format("{} {} ", i, i + 1);
  points.push_back(points[3] + 0.4 * (points[4] - points[3])), points.push_back(points[9] + 0.7 * (points[10] - points[9]));
  for (int i = 0; i < 13; ++i) velocity += fmt::format("{} {} 0.2 ", 0.1 * i, 0.3 - 0.05 * i);
  velocity += "6 -2 1  -5 4 2";
  for (const char* integrator : {"<EulerImplicitSolver newtonIterations=\"50\" newtonTolerance=\"1e-13\"/>", "<EulerImplicitSolver/>"}) {
    Simulation simulation = simulationFromText(sceneOf(
        fmt::format("<MeshTopology position=\"{0}\" edges=\"{1}\"/><MechanicalObject name=\"dofs\" velocity=\"{2}\"/><UniformMass "
                    "vertexMass=\"0.1\"/><MeshSpringForceField stiffness=\"300\"/>"
                    "<SlidingLagrangianConstraint sliding_point=\"13\" curve=\"{3}\"/><SlidingLagrangianConstraint sliding_point=\"14\" "
                    "curve=\"{3}\"/>",
                    places(points), springs, velocity, curveOf(13)),
        0.01, "0 0 0", integrator));
    const bool is_exact = std::string(integrator).find("newton") != std::string::npos;
    std::vector<Vec3> before(15);
    Vec3 momentum = Vec3::Zero();
    for (Index k = 0; k < 15; ++k) momentum += simulation.states()[0]->v()[k];
    for (int i = 0; i < 60; ++i) {
      for (Index k = 0; k < 15; ++k) before[std::size_t(k)] = simulation.states()[0]->v()[k];
      run(simulation, 1);
      if (HasFatalFailure()) return;
      Vec3 sum = Vec3::Zero(), torque = Vec3::Zero();
      for (Index k = 0; k < 15; ++k) {
        const Vec3 v = simulation.states()[0]->v()[k];
        sum += v, torque += at(simulation, k).cross(v - before[std::size_t(k)]);
      }
      ASSERT_LT((sum - momentum).norm(), 1e-10) << "step " << i;
      if (is_exact) ASSERT_LT(torque.norm(), 1e-8) << "step " << i;
      for (const Index bead : {13, 14}) ASSERT_LT(distanceToCurve(simulation, bead, 12), 1e-10) << "step " << i;
    }
  }
}

/// A curve whose last point is its first has no end.
TEST(Sliding, ABeadGoesRoundARing) {
  constexpr int n = 24;
  std::vector<Vec3> ring;
  std::string curve;
  for (int i = 0; i < n; ++i) ring.emplace_back(std::cos(2 * M_PI * i / n), std::sin(2 * M_PI * i / n), 0), curve += fmt::format("{} ", i);
  std::string text = beadOn(ring, {1, 0.01, 0});
  text.insert(text.rfind(curve) + curve.size(), "0");
  text.insert(text.find("\"/>"), fmt::format("\" velocity=\"{}0 6 0", [] {
                std::string zeros;
                for (int i = 0; i < n; ++i) zeros += "0 0 0  ";
                return zeros;
              }()));
  Simulation simulation = simulationFromText(sceneOf(text, 0.005, "0 0 0"));
  double turned = 0;
  for (int i = 0; i < 800; ++i) {
    const Vec3 before = at(simulation, n);
    run(simulation, 1);
    if (HasFatalFailure()) return;
    const Vec3 now = at(simulation, n);
    turned += std::atan2(before.cross(now).z(), before.dot(now));
    ASSERT_LT(std::abs(now.norm() - 1), 1 - std::cos(M_PI / n) + 1e-9);
  }
  EXPECT_GT(turned, 2 * M_PI) << "it has come round";
}

/// After fifty steps it stands where two pieces cross, and goes on along its own.
TEST(Sliding, AtACrossingAPointStaysOnItsWay) {
  const std::vector<Vec3> eight{{-1, 1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, -1, 0}};
  Simulation simulation = simulationFromText(sceneOf(beadOn(eight, {0.1275, 0.1275, 0}), 0.01, "-1 -1 0"));
  for (int i = 0; i < 120; ++i) {
    run(simulation, 1);
    if (HasFatalFailure()) return;
    ASSERT_LT(std::abs(at(simulation, 4).x() - at(simulation, 4).y()), 1e-10) << "step " << i;
  }
  EXPECT_LT(at(simulation, 4).x(), -0.5);
}

/// Nodes that stand still, and a bead that moves.
std::string movingBeadOn(const std::vector<Vec3>& curve, const Vec3& bead, const Vec3& velocity) {
  std::string text = beadOn(curve, bead), velocities;
  for (std::size_t i = 0; i < curve.size(); ++i) velocities += "0 0 0  ";
  return text.insert(text.find("\"/>"), "\" velocity=\"" + velocities + places({velocity}));
}

/// However fine the wire is, and the last steps leave it at its end. Nothing pulls: x = x0 + v t up to there.
TEST(Sliding, ABeadPassesManyPiecesInAStep) {
  constexpr double piece = 0.01, dt = 0.01, begin = 0.005;
  std::vector<Vec3> wire;
  for (int i = 0; i <= 100; ++i) wire.emplace_back(0.6 * piece * i, 0.8 * piece * i, 0);
  const Vec3 u(0.6, 0.8, 0);
  for (const char* integrator : {"<EulerImplicitSolver/>", "<EulerImplicitSolver newtonIterations=\"30\" newtonTolerance=\"1e-12\"/>"})
    for (const int pieces : {1, 12, 30, 90}) {
      SCOPED_TRACE(fmt::format("{} {}", integrator, pieces));
      Simulation simulation =
          simulationFromText(sceneOf(movingBeadOn(wire, begin * u, pieces * piece / dt * u), dt, "0 0 0", integrator));
      for (int i = 1; i <= 3; ++i) {
        run(simulation, 1);
        if (HasFatalFailure()) return;
        const double way = std::min(1.0, begin + i * pieces * piece);
        EXPECT_LT((at(simulation, 101) - way * u).norm(), 1e-10) << "step " << i << ": " << at(simulation, 101).dot(u);
        if (way == 1) break;
      }
    }
}

/// By twenty pieces and more in a step. Each step ends at the place of the ring that is nearest to that without the ring: with R the
/// radius, the angle turns by atan(v dt / R) and v becomes v cos of it, but for the pieces being straight.
TEST(Sliding, ABeadPassesManyPiecesOfARing) {
  constexpr int n = 360;
  constexpr double dt = 0.01;
  std::vector<Vec3> ring;
  for (int i = 0; i <= n; ++i) ring.emplace_back(std::cos(2 * M_PI * i / n), std::sin(2 * M_PI * i / n), 0);
  for (const double start : {10.0, 25.0, 40.0, 90.0}) {
    SCOPED_TRACE(start);
    Simulation simulation = simulationFromText(sceneOf(movingBeadOn(ring, {1, 1e-3, 0}, {0, start, 0}), dt, "0 0 0"));
    for (int i = 0; i < 5; ++i) {
      const Vec3 from = at(simulation, n + 1), aim = from + dt * Vec3(simulation.states()[0]->v()[n + 1]);
      run(simulation, 1);
      if (HasFatalFailure()) return;
      ASSERT_LT(distanceToCurve(simulation, n + 1, n), 1e-10);
      const Vec3 now = at(simulation, n + 1);
      EXPECT_LT(std::acos(std::min(1.0, now.normalized().dot(aim.normalized()))), 2 * M_PI / n) << "step " << i;
    }
  }
}

/// Two nodes at one place, whatever way the wire has in space.
TEST(Sliding, APieceOfNoLengthIsSteppedOver) {
  for (const Vec3& u : {Vec3(0, -1, 0), Vec3(0, -1, 1), Vec3(1, -1, 0)})
    for (const int doubled : {1, 2}) {
      std::vector<Vec3> wire{Vec3::Zero()};
      for (int i = 0; i <= doubled; ++i) wire.push_back(0.5 * u);
      wire.push_back(1.5 * u);
      Simulation simulation = simulationFromText(sceneOf(beadOn(wire, 0.1 * u), 0.01, "0 -10 0"));
      run(simulation, 150);
      if (HasFatalFailure()) return;
      EXPECT_LT((at(simulation, Index(wire.size())) - 1.5 * u).norm(), 1e-9) << u.transpose();
    }
}

TEST(Sliding, ACurveOfNoLengthIsRefusedWhereItIsWritten) {
  const Vec3 p(1, 2, 3);
  Simulation simulation = simulationFromText(sceneOf(beadOn({p, p, p}, p), 0.01, "0 -10 0"));
  try {
    simulation.step();
    FAIL() << "a curve without a direction leads nothing";
  } catch (const ComponentError& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.find("test.xml:1:"), 0u) << text;
    EXPECT_NE(text.find("all points of its curve are at one place"), std::string::npos) << text;
  }
}

/// Down and up a wire with corners a bead never rises above where it started, by rules that damp.
TEST(Sliding, CornersGiveNoEnergy) {
  const std::vector<Vec3> wire{{0, 0, 0}, {1, -1, 0}, {2, -1, 0}, {3, -0.2, 0}, {4, 1, 0}};
  for (const char* integrator : {"<EulerImplicitSolver/>", "<BDFOdeSolver order=\"2\"/>"})
    for (const double dt : {0.001, 0.004}) {
      SCOPED_TRACE(fmt::format("{} {}", integrator, dt));
      Simulation simulation = simulationFromText(sceneOf(beadOn(wire, {0.2, -0.2, 0}), dt, "0 -10 0", integrator));
      for (int i = 0; i < int(4 / dt); ++i) {
        const Vec3 before = at(simulation, 5);
        run(simulation, 1);
        if (HasFatalFailure()) return;
        const double speed = (at(simulation, 5) - before).norm() / dt;
        ASSERT_LT(speed * speed / 2 + g * std::min(before.y(), at(simulation, 5).y()), -2 + 1e-9) << "step " << i;
      }
    }
}

/// By the trapezoidal rule, which damps nothing, it keeps its speed over them, but for what gravity does within a step.
TEST(Sliding, CornersKeepEnergyByTheTrapezoidalRule) {
  const std::vector<Vec3> wire{{0, 0, 0}, {1, -1, 0}, {2, -1, 0}, {3, -0.2, 0}, {4, 1, 0}};
  for (const char* integrator : {"<TrapezoidalRuleSolver/>", "<TrapezoidalRuleSolver newtonIterations=\"20\"/>"})
    for (const double dt : {0.0005, 0.001, 0.002}) {
      SCOPED_TRACE(fmt::format("{} {}", integrator, dt));
      Simulation simulation = simulationFromText(sceneOf(beadOn(wire, {0.2, -0.2, 0}), dt, "0 -10 0", integrator));
      for (int i = 0; i < int(4 / dt); ++i) {
        run(simulation, 1);
        if (HasFatalFailure()) return;
        const double speed = simulation.states()[0]->v()[5].norm();
        ASSERT_NEAR(speed * speed / 2 + 10 * at(simulation, 5).y(), -2, 40 * dt) << "step " << i;
      }
    }
}

/// What is tied to it goes over them with it: both have one velocity, and the energy of both stays.
TEST(Sliding, CornersTearNoTieByTheTrapezoidalRule) {
  const std::vector<Vec3> wire{{0, 0, 0}, {1, -1, 0}, {2, -1, 0}, {3, -0.2, 0}, {4, 1, 0}};
  for (const char* integrator : {"<TrapezoidalRuleSolver/>", "<TrapezoidalRuleSolver newtonIterations=\"20\"/>"})
    for (const double dt : {0.001, 0.002}) {
      SCOPED_TRACE(fmt::format("{} {}", integrator, dt));
      std::string text = beadOn(wire, {0.2, -0.2, 0}) + "<BilateralLagrangianConstraint first_point=\"5\" second_point=\"6\"/>";
      text.insert(text.find("\"/>"), "0.2 -0.2 0");
      Simulation simulation = simulationFromText(sceneOf(text, dt, "0 -10 0", integrator));
      for (int i = 0; i < int(4 / dt); ++i) {
        run(simulation, 1);
        if (HasFatalFailure()) return;
        const Vec3 v = simulation.states()[0]->v()[5], tied = simulation.states()[0]->v()[6];
        ASSERT_LT((v - tied).norm(), 1e-9) << "step " << i;
        ASSERT_NEAR(v.squaredNorm() + 20 * at(simulation, 5).y(), -4, 80 * dt) << "step " << i;
      }
    }
}

/// A point on a rod swings on below it: both gain no energy, and the rod keeps its length in speed too.
TEST(Sliding, CornersGiveARodNoEnergyByTheTrapezoidalRule) {
  const std::vector<Vec3> wire{{0, 0, 0}, {1, -1, 0}, {2, -1, 0}, {3, -0.2, 0}, {4, 1, 0}};
  for (const double dt : {0.001, 0.002}) {
    SCOPED_TRACE(dt);
    std::string text = beadOn(wire, {0.2, -0.2, 0}) + "<DistanceLagrangianConstraint first_point=\"5\" second_point=\"6\"/>";
    text.insert(text.find("\"/>"), "0.2 -0.5 0");
    Simulation simulation = simulationFromText(sceneOf(text, dt, "0 -10 0", "<TrapezoidalRuleSolver/>"));
    for (int i = 0; i < int(4 / dt); ++i) {
      run(simulation, 1);
      if (HasFatalFailure()) return;
      const Vec3 v = simulation.states()[0]->v()[5], hangs = simulation.states()[0]->v()[6];
      ASSERT_LT(std::abs((at(simulation, 6) - at(simulation, 5)).normalized().dot(hangs - v)), 20 * dt) << "step " << i;
      ASSERT_LT((v.squaredNorm() + hangs.squaredNorm()) / 2 + 10 * (at(simulation, 5).y() + at(simulation, 6).y()), -7 + 80 * dt);
    }
  }
}

/// A cable that is pulled in beside it goes on as fast as it is driven.
TEST(Sliding, CornersStopNothingThatIsDriven) {
  const std::vector<Vec3> wire{{0, 0, 0}, {1, -1, 0}, {2, -1, 0}, {3, -0.2, 0}, {4, 1, 0}};
  std::string text = beadOn(wire, {0.2, -0.2, 0}) + "<CableConstraint indices=\"6\" pullPoint=\"9 9 0\" valueType=\"displacement\" "
                                                    "value=\"5\" maxDispVariation=\"0.001\"/>";
  text.insert(text.find("\"/>"), "9 0 0\" velocity=\"0 0 0  0 0 0  0 0 0  0 0 0  0 0 0  0 0 0  0 1 0");
  Simulation simulation = simulationFromText(sceneOf(text, 0.001, "0 -10 0", "<TrapezoidalRuleSolver/>"));
  for (int i = 0; i < 2000; ++i) {
    run(simulation, 1);
    if (HasFatalFailure()) return;
    ASSERT_NEAR(simulation.states()[0]->v()[6].y(), 1, 1e-6) << "step " << i;
  }
  EXPECT_GT(at(simulation, 5).x(), 1) << "it has passed corners";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
