// SPDX-License-Identifier: LGPL-2.1-or-later
// Attached nodes: two bodies are the merged body.
#include <fmt/format.h>

#include <Eigen/Dense>

#include "tests/constraints/attached_bodies.h"
#include "tests/support/scene_text.h"
#include "tests/support/stored_matrix.h"

namespace stroma::test {
namespace {

/// Nodes (2, j, k) of the first block and (0, j, k) of the second.
std::string attach(bool two_way = true) {
  std::string first, second;
  for (int jk = 0; jk < 9; ++jk) first += fmt::format("{} ", 2 + 3 * jk), second += fmt::format("{} ", 3 * jk);
  return fmt::format(
      "<AttachProjectiveConstraint object1='@a/dofs' object2='@b/dofs' indices1='{}' indices2='{}' twoWay='{}'/>",
      first, second, two_way ? "true" : "false");
}

class AttachedBlocks : public ::testing::TestWithParam<std::array<std::string, 2>> {};

TEST_P(AttachedBlocks, MoveAsTheMergedBlock) {
  const auto& [integrator, solver] = GetParam();
  expectTheMergedBlock(integrator, solver, attach(), 0);
}

INSTANTIATE_TEST_SUITE_P(
    Integrators, AttachedBlocks,
    ::testing::Values(std::array<std::string, 2>{"<EulerImplicitSolver/>",
                                                 "<CGLinearSolver iterations='400' tolerance='1e-13'/>"},
                      std::array<std::string, 2>{
                          "<EulerImplicitSolver/>",
                          "<CGLinearSolver iterations='400' tolerance='1e-13' template='CompressedRowSparseMatrix'/>"},
                      std::array<std::string, 2>{"<EulerImplicitSolver/>", "<SparseLDLSolver/>"},
                      std::array<std::string, 2>{"<EulerImplicitSolver newtonIterations='20' newtonTolerance='1e-12'/>",
                                                 "<SparseLDLSolver/>"},
                      std::array<std::string, 2>{"<EulerExplicitSolver/>", "<SparseLDLSolver/>"},
                      std::array<std::string, 2>{"<StaticSolver newton_iterations='40'/>", "<SparseLDLSolver/>"}));

/// Two attached nodes of 1 kg and 3 kg at one place, of which 8 N draw the first, and a free one of 2 kg.
Simulation drawnPair(const std::string& integrator, const std::string& attributes = "") {
  return simulationFromText(points("0 0 0 0 0 0 5 5 5", "0 0 0 0 0 0 0 0 0", "1 3 2",
                                   "<ConstantForceField indices='0' forces='8 0 0'/><AttachProjectiveConstraint "
                                   "indices1='0' indices2='1' twoWay='1' " +
                                       attributes + "/>",
                                   integrator));
}

TEST(Attach, MassesAndForcesAddUp) {
  for (const char* integrator : {"<EulerExplicitSolver/>", "<EulerImplicitSolver/>"}) {
    Simulation simulation = drawnPair(integrator);
    simulation.step();
    System& system = *simulation.systems().at(0);
    for (Index i = 0; i < 2; ++i) EXPECT_NEAR(system.v[i].x(), 0.1 * 8 / 4, 1e-14);
    EXPECT_EQ(Vec3(system.v[2]), Vec3::Zero());
  }
}

TEST(Attach, EndsThatLieApartMeetAtTheirCentreOfMass) {
  Simulation simulation =
      simulationFromText(points("0 0 0 4 0 0 0 8 0", "4 0 0 0 4 0 0 0 4", "1 3 4",
                                "<AttachProjectiveConstraint indices1='0 1' indices2='1 2' twoWay='1'/>"));
  System& system = *simulation.systems().at(0);
  for (Index i = 0; i < 3; ++i) {
    EXPECT_LT((system.x[i] - Vec3(1.5, 4, 0)).norm(), 1e-15) << "a chain is one group";
    EXPECT_LT((system.v[i] - Vec3(0.5, 1.5, 2)).norm(), 1e-15) << "momentum is kept";
  }
}

TEST(Attach, EndsMeetWhereOneIsHeldAlongWhatHoldsIt) {
  Simulation simulation = simulationFromText(
      points("0 0 0 4 0 8", "0 0 0 4 0 4", "1 3",
             "<PartialFixedProjectiveConstraint indices='0' fixedDirections='0 0 1'/>"
             "<AttachProjectiveConstraint indices1='0' indices2='1' twoWay='1'/>"));
  System& system = *simulation.systems().at(0);
  const Vec3 n = Vec3(1, 2, 2) / 3;
  Simulation oblique = simulationFromText(
      points("0 0 0 3 0 0", "0 0 0 0 0 0", "1 2",
             "<FixedPlaneProjectiveConstraint indices='1' direction='1 2 2'/>"
             "<AttachProjectiveConstraint indices1='0' indices2='1' twoWay='1'/>"));
  const System& other = *oblique.systems().at(0);
  for (Index i = 0; i < 2; ++i) {
    EXPECT_LT((system.x[i] - Vec3(3, 0, 0)).norm(), 1e-15) << "the centre of mass, but for z";
    EXPECT_LT((other.x[i] - (Vec3(2, 0, 0) + n / 3)).norm(), 1e-14) << "n . x is that of the held end, 1";
  }
}

TEST(Attach, WhatIsHeldOrMovedTakesTheOthersAlong) {
  for (const char* integrator : {"<EulerExplicitSolver/>", "<EulerImplicitSolver/>"}) {
    Simulation simulation = simulationFromText(
        points("0 0 0 0 0 0 4 0 0 4 0 0", "0 0 0 0 0 0 0 0 0 0 0 0", "1 3 2 2",
               "<ConstantForceField indices='0 2' forces='8 4 0'/>"
               "<PartialFixedProjectiveConstraint indices='1' fixedDirections='1 0 0'/>"
               "<LinearMovementProjectiveConstraint indices='3' keyTimes='0 1' movements='0 0 0 0 0 3'/>"
               "<AttachProjectiveConstraint indices1='0 2' indices2='1 3' twoWay='1'/>",
               integrator));
    System& system = *simulation.systems().at(0);
    simulation.step();
    for (Index i = 0; i < 2; ++i) EXPECT_LT((system.v[i] - Vec3(0, 0.1 * 4 / 4, 0)).norm(), 1e-14);
    for (Index i = 2; i < 4; ++i) EXPECT_LT((system.x[i] - Vec3(4, 0, 0.3)).norm(), 1e-14);
  }
}

TEST(Attach, EndsWithItsTime) {
  for (const char* integrator : {"<EulerExplicitSolver/>", "<EulerImplicitSolver/>"}) {
    Simulation simulation = drawnPair(integrator, "endTime='0.05'");
    System& system = *simulation.systems().at(0);
    simulation.step();
    simulation.step();
    EXPECT_NEAR(system.v[0].x(), 0.2 + 0.8, 1e-14) << "alone it has its own mass again";
    EXPECT_NEAR(system.v[1].x(), 0.2, 1e-14);
  }
}

/// P A P + I - P made densely against what products and assembly give.
TEST(Attach, MatrixIsTheProjectedOne) {
  Simulation simulation(
      sceneFromText(R"(<Node name="root" gravity="0 0 0"><TestIntegrator/><TestMesh name="mesh" cells="2 1 1"/>
    <MechanicalObject name="dofs"/><MeshMatrixMass massDensity="5"/><TestSprings/>
    <FixedProjectiveConstraint indices="0"/><TestPlane indices="3"/>
    <AttachProjectiveConstraint indices1="1 4 2" indices2="7 7 3" twoWay="1"/></Node>)"));
  System& system = *simulation.systems()[0];
  for (Index i = 0; i < system.x.count(); ++i) system.x[i] += 0.1 * Vec3(std::sin(i), std::cos(2 * i), std::sin(5 * i));
  Vector f(system.allRows());
  system.computeForce(system.x, system.v, f);
  const Index rows = system.independentRows();
  const auto dense = [&](auto&& apply) {
    Eigen::MatrixXd m(3 * rows, 3 * rows);
    Vector p(rows), out(rows);
    for (Index j = 0; j < 3 * rows; ++j) {
      clear(p);
      p[j / 3][j % 3] = 1;
      clear(out);
      apply(p, out);
      for (Index i = 0; i < 3 * rows; ++i) m(i, j) = out[i / 3][i % 3];
    }
    return m;
  };
  const Eigen::MatrixXd p = dense([&](Vector& in, Vector& out) { copy(in, out), system.constraints().project(out); });
  EXPECT_LT((p * p - p).norm(), 1e-14);
  EXPECT_LT((p - p.transpose()).norm(), 1e-15);
  EXPECT_NEAR(p.trace(), 3 * rows - 3 - 6 - 3 - 1, 1e-12) << "one fixed, a group of three, a pair in a plane";
  SystemMatrix& matrix = system.matrix().withFactors({.mass = 1, .stiffness = -0.01});
  const Eigen::MatrixXd projected = dense([&](Vector& in, Vector& out) {
    Vector free(rows);
    copy(in, free), system.constraints().project(free);
    matrix.multiply(free, out);
  });
  const BlockMatrix& assembled = matrix.assemble();
  const Eigen::MatrixXd full = dense([&](Vector& in, Vector& out) { assembled.multiply(in, out); });
  const Eigen::MatrixXd rest = full - projected;  // acts on what is held alone, in the size of the other numbers
  EXPECT_LT((rest * p).norm() + (p * rest).norm(), 1e-12 * full.norm());
  const Eigen::VectorXd sizes = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(rest + 1e-3 * full.norm() * p).eigenvalues();
  EXPECT_GT(sizes.minCoeff(), 1e-3 * full.diagonal().maxCoeff());
  EXPECT_LT((full - full.transpose()).norm(), 1e-12 * full.norm());
}

TEST(Attach, OneWayFollowsWithoutBeingFelt) {
  const std::string bodies = block("a", 2, 0, held("wall")) + block("b", 2, 2, "");
  const std::string solver = "<SparseLDLSolver/>";
  for (const char* integrator : {"<EulerImplicitSolver/>", "<EulerExplicitSolver/>"}) {
    Simulation both = simulationFromText(root(integrator, solver, bodies + attach(false)));
    Simulation alone = simulationFromText(root(integrator, solver, block("a", 2, 0, held("wall"))));
    System &two = *both.systems().at(0), &one = *alone.systems().at(0);
    for (int step = 0; step < 20; ++step) {
      both.step(), alone.step();
      for (int jk = 0; jk < 9; ++jk) {
        EXPECT_EQ(Vec3(two.x[2 + 3 * jk]), Vec3(two.x[27 + 3 * jk]));
        EXPECT_EQ(Vec3(two.v[2 + 3 * jk]), Vec3(two.v[27 + 3 * jk]));
      }
    }
    for (Index i = 0; i < 27; ++i) EXPECT_LT((two.x[i] - one.x[i]).norm(), 1e-12);
  }
  // statics: the follower's body is in equilibrium with where the leader ends
  Simulation both = simulationFromText(root("<StaticSolver newton_iterations='40'/>", solver, bodies + attach(false)));
  ASSERT_FALSE(both.step().diverged);
  System& two = *both.systems().at(0);
  for (int jk = 0; jk < 9; ++jk) EXPECT_EQ(Vec3(two.x[2 + 3 * jk]), Vec3(two.x[27 + 3 * jk]));
  Vector f(two.allRows());
  two.computeForce(two.x, two.v, f);
  const double loads = std::sqrt(dot(f, f));
  two.constraints().project(f);
  EXPECT_LT(std::sqrt(dot(f, f)), 1e-7 * loads);
}

/// Every second node of the finer surface: what lies between them is free, and the whole too soft.
TEST(Attach, ASurfaceThatIsHeldAtSingleNodesIsSaid) {
  const auto said = [](int fine, int coarse, int most) {
    const auto body = [](const std::string& name, int n, double from) {
      return fmt::format(
          R"(<Node name="{0}"><RegularGridTopology n="{1} {1} {1}" min="{2} 0 0" max="{3} 1 1"/><MechanicalObject name="dofs"/>
          <UniformMass totalMass="1"/><HexahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/></Node>)",
          name, n, from, from + 1);
    };
    std::string first, second;
    const int step = (fine - 1) / (coarse - 1);
    for (int k = 0; k < most; ++k)
      for (int j = 0; j < most; ++j) {
        first += fmt::format("{} ", fine - 1 + fine * step * (j + fine * k));
        second += fmt::format("{} ", coarse * (j + coarse * k));
      }
    return sceneFromText(root("<EulerImplicitSolver/>", "<CGLinearSolver/>",
                              body("a", fine, 0) + body("b", coarse, 1) +
                                  "<AttachProjectiveConstraint object1='@a/dofs' object2='@b/dofs' indices1='" + first +
                                  "' indices2='" + second + "'/>"))
        .diagnostics.text();
  };
  expectContains(said(5, 3, 3), "/a/dofs is attached by single nodes");
  expectContains(said(5, 3, 3), "a BarycentricMapping places in /b/dofs");
  EXPECT_EQ(said(3, 3, 3).find("single nodes"), std::string::npos) << "matching surfaces";
  EXPECT_EQ(said(5, 3, 1).find("single nodes"), std::string::npos) << "a hinge";
}

TEST(Attach, SaysWhatIsWrong) {
  const auto problems = [](const std::string& attributes) {
    return problemsOf(points("0 0 0 1 0 0", "0 0 0 0 0 0", "1 1", "<AttachProjectiveConstraint " + attributes + "/>"));
  };
  expectContains(problems("indices1='0' indices2='0'"), "attached to itself");
  expectContains(problems("indices1='0' indices2='0 1'"), "1 nodes and indices2 2");
  expectContains(problems("indices1='0' indices2='2'"), "/dofs has 2 nodes");
  expectContains(problems("indices1='0'"), "indices2");
  expectContains(problemsOf(points("0 0 0", "0 0 0", "1",
                                   "<Node name='b'><MechanicalObject name='dofs' position='0 0 0'/><UniformMass "
                                   "totalMass='1'/></Node><AttachProjectiveConstraint mstate='@dofs' "
                                   "object1='@b/dofs' indices1='0' indices2='0'/>")),
                 "mstate and object1 name different states");
  expectContains(sceneFromText(points("0 0 0 1 0 0", "0 0 0 0 0 0", "1 1",
                                      "<AttachProjectiveConstraint indices1='0' indices2='1'/>"))
                     .diagnostics.text(),
                 "up to 1 m apart");
}

}  // namespace
}  // namespace stroma::test
