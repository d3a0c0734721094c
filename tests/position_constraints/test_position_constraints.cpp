// SPDX-License-Identifier: LGPL-2.1-or-later
// Volumes kept, planes not penetrated: alone against closed forms, and all kinds of position constraints together.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "framework/algebra/parallel.h"
#include "framework/mechanics/position_constraint.h"
#include "tests/position_constraints/position_scenes.h"
#include "tools/plan/plan.h"

namespace stroma::test {
namespace {

// ---- a correction that fails ----

/// Reports no number.
class LostConstraint final : public PositionConstraint {
 public:
  double correctPositions(const PositionStep&, Rows, Rows) override {
    ++calls;
    return std::numeric_limits<double>::quiet_NaN();
  }
  double correctVelocities(const PositionStep&, ConstRows, Rows) override { return 0; }
  std::string violation() const override { return "nobody knows"; }
  std::string describe() const override { return "is lost"; }
  static inline int calls = 0;
};

TEST(PositionConstraints, WhatIsNotANumberDoesNotHold) {
  factory().add<LostConstraint>("LostConstraint", "reports no number");
  Simulation simulation = simulationFromText(hangingOrgan(implicit_euler, "<LostConstraint name=\"lost\"/>", "0.02"));
  const StepReport report = simulation.step();
  EXPECT_FALSE(report.constraints_converged);
  EXPECT_NE(report.constraint_reason.find("/lost is violated"), std::string::npos) << report.constraint_reason;
  EXPECT_EQ(LostConstraint::calls, 1);
}

// ---- volume ----

void keepsVolumeAndPlane(const std::string& integrator, const std::string& dt, int steps) {
  SCOPED_TRACE(integrator);
  const std::string plane = "<PlaneConstraint normal=\"1 0 0\" d=\"-0.1\"/>";
  Simulation simulation = simulationFromText(hangingOrgan(integrator, "<VolumeConstraint/>" + plane, dt));
  const System& system = *simulation.systems()[0];
  const double volume = volumeOf(system);
  const Vec3 held = system.x[183];
  double worst = 0, depth = 0;
  int touching = 0, sweeps = 0;
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.diverged) << report.reason;
    ASSERT_TRUE(report.constraints_converged) << "step " << i << ": " << report.constraint_reason;
    worst = std::max(worst, std::abs(volumeOf(system) / volume - 1));
    const double reach = lowest(system, Vec3(1, 0, 0)) + 0.1;
    depth = std::max(depth, -reach);
    touching += reach < 1e-9;
    sweeps += report.constraint_sweeps;
  }
  EXPECT_LT(worst, 1e-10);
  EXPECT_LT(depth, 1e-10);
  EXPECT_EQ(system.x[183], held);
  EXPECT_GT(touching, steps / 10);
  EXPECT_LT(sweeps, 30 * steps) << "the constraints agree in a few turns";
}

TEST(VolumeConstraint, TheVolumeIsThatOfTheTetrahedra) {
  const auto simulation = simulationFromText(hangingOrgan("<EulerExplicitSolver/>", "", "0.01"));
  const System& system = *simulation.systems()[0];
  double volume = 0;
  for (const Tetrahedron& t : system.states()[0]->find<Topology>(true)->mesh().tetrahedra) {
    Mat3 edges;
    for (int c = 0; c < 3; ++c) edges.col(c) = Vec3(system.x[t[std::size_t(c + 1)]]) - Vec3(system.x[t[0]]);
    volume += edges.determinant() / 6;
  }
  EXPECT_NEAR(volumeOf(system), volume, 1e-12 * volume);
}

TEST(VolumeConstraint, KeptForAThousandStepsWithFixedNodesAndAPlane) {
  keepsVolumeAndPlane("<EulerExplicitSolver/>", "0.002", 1000);
  keepsVolumeAndPlane(implicit_euler, "0.02", 1000);
}

TEST(VolumeConstraint, KeptWithEveryIntegrator) {
  const std::string cg = "<CGLinearSolver iterations=\"50\" tolerance=\"1e-8\"/>";
  for (const char* integrator : {"<EulerExplicitSolver symplectic=\"false\"/>", "<RungeKutta2Solver/>",
                                 "<RungeKutta4Solver/>", "<NewtonCotesSolver/>", "<CentralDifferenceSolver/>",
                                 "<VariationalSymplecticSolver explicitIntegration=\"true\"/>"})
    keepsVolumeAndPlane(integrator, "0.001", 400);
  for (const char* integrator : {"<NewmarkImplicitSolver/>", "<TrapezoidalRuleSolver/>", "<BDFOdeSolver order=\"2\"/>",
                                 "<VariationalSymplecticSolver/>", "<EulerImplicitSolver newtonIterations=\"5\"/>"})
    keepsVolumeAndPlane(integrator + cg, "0.005", 200);
}

TEST(VolumeConstraint, WithoutItTheVolumeChanges) {
  Simulation simulation = simulationFromText(hangingOrgan(implicit_euler, "", "0.02"));
  const double volume = volumeOf(*simulation.systems()[0]);
  run(simulation, 100);
  EXPECT_GT(std::abs(volumeOf(*simulation.systems()[0]) / volume - 1), 1e-3);
}

TEST(VolumeConstraint, AFreeBodyKeepsItsMomenta) {
  Simulation simulation =
      simulationFromText(hangingOrgan("<EulerExplicitSolver/>", "<VolumeConstraint/>", "0.002", "", "0 0 0"));
  System& system = *simulation.systems()[0];
  for (Index i = 0; i < system.x.count(); ++i)
    system.v[i] = Vec3(0.1, 0.2, -0.1) + Vec3(1, 2, 3).cross(Vec3(system.x[i])) + 0.3 * system.x[i] +
                  0.05 * std::sin(double(i)) * Vec3(0.1, 0, 0.2);
  const Motion start = motionOf(system);
  const double volume = volumeOf(system);
  run(simulation, 2000);
  const Motion end = motionOf(system);
  EXPECT_LT((end.linear - start.linear).norm(), 1e-11 * start.linear.norm());
  EXPECT_LT((end.angular - start.angular).norm(), 1e-11 * start.angular.norm());
  EXPECT_NEAR(volumeOf(system) / volume, 1, 1e-10);
}

/// A regular tetrahedron of equal masses: its corners move along its axes, so it stays regular, and its edges are the
/// cube root of the factor times as long.
TEST(VolumeConstraint, ATetrahedronFollowsThePrescribedVolume) {
  const std::string corners = "1 1 1  1 -1 -1  -1 1 -1  -1 -1 1";
  Simulation simulation = simulationFromText(
      root("<EulerExplicitSolver/><MeshTopology position=\"" + corners +
               "\" triangles=\"0 1 2  0 2 3  0 3 1  1 3 2\"/><MechanicalObject position=\"" + corners +
               "\"/><UniformMass totalMass=\"4\"/>"
               "<VolumeConstraint times=\"0 1 2\" factors=\"1 8 1\" period=\"2\"/>",
           "0.01"));
  System& system = *simulation.systems()[0];
  const auto edge = [&](int i, int j) { return (system.x[i] - system.x[j]).norm(); };
  for (int step = 1; step <= 250; ++step) {
    run(simulation, 1);
    const double t = std::fmod(simulation.time(), 2.), factor = t < 1 ? 1 + 7 * t : 15 - 7 * t;
    const double expected = std::sqrt(8.) * std::cbrt(factor);
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < i; ++j) ASSERT_NEAR(edge(i, j), expected, 1e-11 * expected) << step;
    // dV/dt = sum grad V.v with the rate of this step; V = c r^3, |grad| along r
    if (step % 100 == 0) continue;
    const double rate = t < 1 || t > 1.9999 ? 7 : -7, r = system.x[0].norm(), scale = std::sqrt(3.) / std::cbrt(factor);
    EXPECT_NEAR(r * scale, 3, 1e-9);
    EXPECT_NEAR(system.v[0].dot(system.x[0]) / r, rate * r / (3 * factor), 1e-9 * r) << step;
  }
}

TEST(VolumeConstraint, ASurfaceMustBeClosedAndTurnedOutward) {
  const auto surface = [](const std::string& triangles) {
    const std::string corners = "1 1 1  1 -1 -1  -1 1 -1  -1 -1 1";
    return problemsOf(root("<EulerExplicitSolver/><MeshTopology position=\"" + corners + "\" triangles=\"" + triangles +
                           "\"/><MechanicalObject position=\"" + corners +
                           "\"/><UniformMass totalMass=\"4\"/><VolumeConstraint/>"));
  };
  EXPECT_EQ(surface("0 1 2  0 2 3  0 3 1  1 3 2"), "");
  EXPECT_NE(surface("0 1 2  0 2 3  0 3 1").find("open"), std::string::npos);
  EXPECT_NE(surface("0 1 2  0 2 3  0 3 1  1 2 3").find("badly turned"), std::string::npos);
  EXPECT_NE(surface("0 2 1  0 3 2  0 1 3  1 2 3").find("outward"), std::string::npos);
  EXPECT_NE(problemsOf(root("<EulerExplicitSolver/><MechanicalObject position=\"0 0 0\"/>"
                            "<UniformMass totalMass=\"4\"/><VolumeConstraint/>"))
                .find("no mesh"),
            std::string::npos);
}

TEST(VolumeConstraint, ABodyThatCannotMoveIsSaid) {
  Simulation simulation =
      simulationFromText(hangingOrgan(implicit_euler, "<VolumeConstraint times=\"0 1\" factors=\"1 2\"/>", "0.02",
                                      "<FixedProjectiveConstraint fixAll=\"true\"/>"));
  const StepReport report = simulation.step();
  EXPECT_FALSE(report.diverged);
  EXPECT_FALSE(report.constraints_converged);
  EXPECT_NE(report.constraint_reason.find("no node that may move would change it"), std::string::npos)
      << report.constraint_reason;
  EXPECT_LT(report.constraint_sweeps, 10) << "nothing changes after the first";
}

/// A box of one cell, of which the nodes in `held` are fixed, and whose volume is to be `factor` times as large.
std::string box(double height, const std::string& held, double factor) {
  const std::string h = std::to_string(height);
  const std::string corners = "0 0 0  1 0 0  1 1 0  0 1 0  0 0 " + h + "  1 0 " + h + "  1 1 " + h + "  0 1 " + h;
  return root("<EulerExplicitSolver/><MeshTopology position=\"" + corners +
              "\" hexahedra=\"0 1 2 3 4 5 6 7\"/><MechanicalObject/><UniformMass totalMass=\"1\"/>" +
              (held.empty() ? "" : "<FixedProjectiveConstraint indices=\"" + held + "\"/>") +
              "<VolumeConstraint times=\"0\" factors=\"" + std::to_string(factor) + "\"/>");
}

TEST(VolumeConstraint, AFlatHeldBoxGetsTwiceAsHigh) {
  Simulation simulation = simulationFromText(box(0.02, "0 1 2 3", 2));
  run(simulation, 1);
  const System& system = *simulation.systems()[0];
  // the four upper corners rise alike, and move outward by the share of their sides: h (1 + 2 d) to first order of d =
  // O(h)
  for (Index node = 4; node < 8; ++node) EXPECT_NEAR(system.x[node].z(), 0.04, 0.04 * 2 * 0.04) << node;
}

TEST(VolumeConstraint, WhatOnlyAFarPlaceWouldReachIsSaid) {
  // one free corner of a cube: its gradient is a quarter of three faces, so twice the volume takes a diagonal move by
  // 4 / sqrt(3) > 1 / 2 cube sides; corners of a free cube go 0.9 sqrt(3) / 2 inward for a thousandth of it
  for (const std::string& scene : {box(1, "0 1 2 3 4 5 7", 2), box(1, "", 1e-3)}) {
    Simulation simulation = simulationFromText(scene);
    const System& system = *simulation.systems()[0];
    const StepReport report = simulation.step();
    EXPECT_FALSE(report.constraints_converged);
    EXPECT_NE(report.constraint_reason.find("no displacement by up to half the size"), std::string::npos)
        << report.constraint_reason;
    EXPECT_LT(report.constraint_sweeps, 10) << "nothing changes after the first";
    for (Index node = 0; node < 8; ++node) EXPECT_EQ(system.x[node], system.states()[0]->rest_position[node]) << node;
  }
}

TEST(VolumeConstraint, StaticsHasNoMotionToCorrect) {
  EXPECT_NE(problemsOf(hangingOrgan("<StaticSolver/><SparseLDLSolver/>", "<VolumeConstraint/>", "1")).find("a dynamic integrator"),
            std::string::npos);
}

// ---- planes ----

TEST(PlaneConstraint, APointFallsSlidesAndIsDrawnAway) {
  Simulation simulation = simulationFromText(
      root("<EulerExplicitSolver/><MechanicalObject position=\"0 0 0.5  0 1 0.02\" velocity=\"0.3 0 0  0 0 0\"/>"
           "<UniformMass totalMass=\"2\"/><PlaneConstraint normal=\"0 0 2\" d=\"0\"/>",
           "0.01", "0 0 -9.81"));
  System& system = *simulation.systems()[0];
  bool touched = false;
  for (int i = 0; i < 100; ++i) {
    run(simulation, 1);
    EXPECT_GE(system.x[0].z(), -1e-12);
    EXPECT_NEAR(system.x[0].x(), 0.3 * simulation.time(), 1e-12) << "no friction";
    if (touched) {
      EXPECT_NEAR(system.x[0].z(), 0, 1e-12) << "no bounce";
      EXPECT_EQ(system.v[0].z(), 0);
    }
    touched = touched || system.x[0].z() < 1e-12;
  }
  EXPECT_TRUE(touched);
  system.v[0] = Vec3(0, 0, 1);
  run(simulation, 1);
  EXPECT_NEAR(system.x[0].z(), 0.01 * (1 - 0.0981), 1e-14) << "no sticking";
}

TEST(PlaneConstraint, InAWedgeAPointSlidesAlongTheEdge) {
  Simulation simulation = simulationFromText(
      root("<EulerExplicitSolver/><MechanicalObject position=\"0 0 0.1\"/><UniformMass totalMass=\"1\"/>"
           "<PlaneConstraint normal=\"0.3 1 1  -0.2 -1 1\" d=\"0 0\"/>",
           "0.01", "0 0 -9.81"));
  const System& system = *simulation.systems()[0];
  run(simulation, 1000);
  const Vec3 a = Vec3(0.3, 1, 1).normalized(), b = Vec3(-0.2, -1, 1).normalized(), edge = a.cross(b).normalized();
  const Vec3 x = system.x[0], v = system.v[0];
  EXPECT_NEAR(a.dot(x), 0, 1e-10);
  EXPECT_NEAR(b.dot(x), 0, 1e-10);
  EXPECT_LT((v - edge.dot(v) * edge).norm(), 1e-12 * v.norm());
  // from when both planes are touched it slides with the weight's part along the edge
  const double acceleration = std::abs(9.81 * edge.z());
  EXPECT_NEAR(v.norm(), acceleration * 10, 0.05 * acceleration * 10);
}

TEST(PlaneConstraint, AHeldNodeBehindItIsSaid) {
  expectConflict(simulationFromText(root("<EulerExplicitSolver/><MechanicalObject position=\"0 0 -0.5  0 1 0\"/>"
                                         "<UniformMass totalMass=\"2\"/><FixedProjectiveConstraint indices=\"0\"/>"
                                         "<PlaneConstraint normal=\"0 0 1\" d=\"0\"/>")),
                 "node 0 is 0.5 m behind plane 0 and fixed there");
  expectContains(
      problemsOf(root("<EulerExplicitSolver/><MechanicalObject position=\"0 0 0\"/><UniformMass totalMass=\"1\"/>"
                      "<PlaneConstraint normal=\"0 0 0\" d=\"0\"/>")),
      "length 0");
}

// ---- together ----

TEST(PositionConstraints, AllKindsAgree) {
  const std::string more =
      "<VolumeConstraint/><PlaneConstraint normal=\"1 0 0\" d=\"-0.1\"/>"
      "<RigidConstraint indices=\"21 52 53 69 83 84 101 112 113 130 131 132 141\"/>";
  for (const auto& [integrator, dt] :
       {std::pair<std::string, std::string>{"<EulerExplicitSolver/>", "0.002"}, {implicit_euler, "0.02"}}) {
    Simulation simulation = simulationFromText(hangingOrgan(integrator, more, dt));
    const System& system = *simulation.systems()[0];
    const double volume = volumeOf(system);
    const auto& rest = system.states()[0]->rest_position;
    for (int i = 0; i < 300; ++i) {
      run(simulation, 1);
      ASSERT_NEAR(volumeOf(system) / volume, 1, 1e-10);
      ASSERT_GE(lowest(system, Vec3(1, 0, 0)), -0.1 - 1e-10);
      const int set[]{21, 52, 53, 69, 83, 84, 101, 112, 113, 130, 131, 132, 141};
      for (int a : set) ASSERT_NEAR((system.x[a] - system.x[21]).norm(), (rest[a] - rest[21]).norm(), 1e-11);
    }
  }
}

TEST(PositionConstraints, TiedNodesStayTiedAndTheMomentumStays) {
  // two tetrahedra of kept volume that share a corner; one of them grows
  const std::string a = "0 0 0  1 0 0  0 1 0  0 0 1", b = "0 0 1  1 0 1  0 1 1  0 0 2";
  const auto body = [](const std::string& name, const std::string& corners, const std::string& constraint) {
    return "<Node name=\"" + name + "\"><MeshTopology position=\"" + corners +
           "\" tetrahedra=\"0 1 2 3\"/><MechanicalObject name=\"dofs\"/><UniformMass vertexMass=\"1\"/>" + constraint +
           "</Node>";
  };
  Simulation simulation = simulationFromText(
      root("<EulerExplicitSolver/>" + body("a", a, "<VolumeConstraint times=\"0 1\" factors=\"1 2\"/>") +
           body("b", b, "<VolumeConstraint/>") +
           "<AttachProjectiveConstraint object1=\"@a/dofs\" object2=\"@b/dofs\" indices1=\"3\" indices2=\"0\" "
           "twoWay=\"true\"/>"));
  const System& system = *simulation.systems()[0];
  const auto volume = [&](Index first) {
    const Vec3 p = system.x[first];
    return (system.x[first + 1] - p).cross(Vec3(system.x[first + 2] - p)).dot(system.x[first + 3] - p) / 6;
  };
  for (int i = 0; i < 150; ++i) {
    run(simulation, 1);
    ASSERT_EQ(system.x[3], system.x[4]);
    ASSERT_NEAR(volume(0), (1 + std::min(simulation.time(), 1.)) / 6, 1e-11);
    ASSERT_NEAR(volume(4), 1. / 6, 1e-11);
    Vec3 momentum = Vec3::Zero();
    for (Index row = 0; row < 8; ++row) momentum += system.v[row];
    ASSERT_LT(momentum.norm(), 1e-11);
  }
}

TEST(PositionConstraints, SameBitsForOneAndTwoThreadsAndAfterAReset) {
  const std::string scene =
      hangingOrgan(implicit_euler, "<VolumeConstraint/><PlaneConstraint normal=\"1 0 0\" d=\"-0.1\"/>", "0.02");
  const auto hash = [&scene](int threads) {
    setThreads(threads);
    Simulation simulation = simulationFromText(scene);
    run(simulation, 30);
    const auto first = simulation.stateHash();
    simulation.reset();
    run(simulation, 30);
    setThreads(1);
    EXPECT_EQ(first, simulation.stateHash());
    return first;
  };
  EXPECT_EQ(hash(1), hash(2));
}

TEST(PositionConstraints, ASceneThatNeedsNoneHasNone) {
  Simulation with = simulationFromText(hangingOrgan(implicit_euler, "<VolumeConstraint/>", "0.02"));
  Simulation without = simulationFromText(hangingOrgan(implicit_euler, "", "0.02"));
  const auto says = [](const Simulation& simulation) {
    for (const std::string& line : planOf(*simulation.systems()[0]).lines())
      if (line.find("position constraint") != std::string::npos) return true;
    return false;
  };
  EXPECT_TRUE(says(with));
  EXPECT_FALSE(says(without));
  EXPECT_EQ(without.step().constraint_sweeps, 0);
  EXPECT_GT(with.step().constraint_sweeps, 0);
}

}  // namespace
}  // namespace stroma::test
