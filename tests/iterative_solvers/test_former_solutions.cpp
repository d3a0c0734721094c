// SPDX-License-Identifier: LGPL-2.1-or-later
// Solves that begin from the solutions before them: where they begin, what that saves, and that runs repeat to the bit.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "components/iterative_solvers/former_solutions.h"
#include "framework/algebra/parallel.h"
#include "tests/iterative_solvers/block_problem.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace {

constexpr int most = cg::FormerSolutions::most;

/// Four random solutions of a matrix, known to `former`.
struct Past {
  StoredMatrix matrix = randomMatrix(200, 3, 1, 7);
  std::vector<Vector> solutions;
  cg::FormerSolutions former;
  cg::Directions work;
  Vector x = Vector(200);

  Past() {
    work.resize(200);
    for (int k = 0; k < most; ++k) solutions.push_back(randomVector(200, unsigned(20 + k)));
    for (int k = 0; k < 2; ++k) former.solved(randomVector(200, unsigned(10 + k)));  // the first ones are passed over
    for (const Vector& solution : solutions) former.solved(solution);
  }
  double begin(ConstRows b) {
    clear(x), matrix.products = 0;
    return former.begin([&](ConstRows p, Rows out) { matrix.multiply(p, out); }, b, norm(b), work, x);
  }
};

TEST(FormerSolutions, FindsWhatIsACombinationOfThem) {
  Past past;
  for (double& value : past.matrix.values.values()) value *= 3;  // another matrix than theirs
  Vector expected(200), b(200);
  for (int k = 0; k < most; ++k) axpy(k - 1.5, past.solutions[std::size_t(k)], expected);
  past.matrix.multiply(expected, b);
  EXPECT_LE(past.begin(b), 1e-10);
  EXPECT_LE(distance(past.x, expected), 1e-10 * norm(expected));
  Vector rest = Vector(200);
  past.matrix.multiply(past.x, rest);
  xpay(b, -1, rest);
  EXPECT_LE(distance(past.work.r, rest), 1e-12 * norm(b));
}

/// Against the minimum by dense algebra.
TEST(FormerSolutions, BeginsNearestInEnergy) {
  Past past;
  Vector b(200);
  past.matrix.multiply(past.solutions[2], b);
  axpy(0.2, randomVector(200, 99), b);
  const Eigen::MatrixXd a = past.matrix.dense();
  Eigen::MatrixXd s(600, most);
  for (int k = 0; k < most; ++k) s.col(k) = dense(past.solutions[std::size_t(k)]);
  const Eigen::VectorXd nearest = s * (s.transpose() * a * s).ldlt().solve(s.transpose() * dense(b));
  const double left = past.begin(b);
  EXPECT_LE((dense(past.x) - nearest).norm(), 1e-10 * nearest.norm());
  EXPECT_NEAR(left, (dense(b) - a * nearest).norm() / norm(b), 1e-10);
  EXPECT_EQ(past.matrix.products, most + 1);
}

TEST(FormerSolutions, WaitsWhereNothingIsGained) {
  Past past;
  const Vector b = randomVector(200, 99);
  EXPECT_EQ(past.begin(b), 1);
  EXPECT_EQ(norm(past.x), 0);
  EXPECT_EQ(past.matrix.products, most + 1);
  for (int pause : {most, 2 * most}) {
    for (int solve = 0; solve < pause; ++solve) {
      EXPECT_EQ(past.begin(b), 1);
      EXPECT_EQ(past.matrix.products, 0) << solve << " of " << pause;
    }
    past.begin(b);
    EXPECT_EQ(past.matrix.products, most + 1);
  }
}

TEST(FormerSolutions, LeavesAMatrixThatIsNotDefinite) {
  Past past;
  for (double& value : past.matrix.values.values()) value *= -1;
  EXPECT_EQ(past.begin(randomVector(200, 99)), 1);
  EXPECT_EQ(norm(past.x), 0);
}

/// Loads that swing with two frequencies.
struct Swing {
  ElasticBlock block = box(16, 16, 16);
  StoredMatrix matrix = matrixOf(block);
  Vector x;

  SolveReport step(SolverInScene& solver, int k) {
    Vector b = weight(block);
    for (Index row = 0; row < b.count(); ++row)
      b[row] = Vec3(std::sin(0.3 * k) * b[row].x(), std::cos(1.1 * k) * b[row].x(), (1 + std::sin(0.3 * k)) * b[row].z());
    x = Vector(b.count());
    const SolveReport report = solver.solve(matrix, b, x);
    EXPECT_EQ(report.stop, SolveStop::converged);
    Vector rest(b.count());
    matrix.values.multiply(x, rest);
    EXPECT_LE(distance(b, rest), 1.2e-3 * norm(b)) << k;
    return report;
  }
};

TEST(FormerSolutions, SaveMostIterationsOfASwing) {
  Swing swing;
  SolverInScene solver("<AutomaticLinearSolver tolerance='1e-3'/>");
  const int usual = swing.step(solver, 0).iterations;
  int few = 0;
  for (int k = 1; k < 12; ++k) few = swing.step(solver, k).iterations;
  EXPECT_LE(2 * few, usual);
}

TEST(FormerSolutions, RepeatToTheBitTakenUpAgainAndTakenBack) {
  Swing swing;
  SolverInScene first("<AutomaticLinearSolver tolerance='1e-3'/>"), second("<AutomaticLinearSolver tolerance='1e-3'/>");
  const auto isSame = [&](const Vector& a) { return std::memcmp(a.rows().data, swing.x.rows().data, a.rows().doubles() * 8) == 0; };
  for (int k = 0; k < 8; ++k) swing.step(first, k);
  handOver(first, second, swing.matrix);
  first.solver->keepFor(swing.matrix);
  std::vector<Vector> found;
  for (int k = 8; k < 11; ++k) swing.step(first, k), found.push_back(std::move(swing.x));
  first.solver->takeBackFor(swing.matrix);
  for (int k = 8; k < 11; ++k) {
    swing.step(first, k);
    EXPECT_TRUE(isSame(found[std::size_t(k - 8)])) << k << " taken back";
  }
  for (int k = 8; k < 11; ++k) {
    setThreads(k - 7), swing.step(second, k), setThreads(1);
    EXPECT_TRUE(isSame(found[std::size_t(k - 8)])) << k << " taken up again, on " << k - 7 << " threads";
  }
}

/// A cube that falls on a wall, held at one face; from 0.1 s on the other face is led sideways.
Simulation ledCube(const std::string& integrator, const std::string& solver, const std::string& method) {
  return simulationFromText(fmt::format(
      "<Node gravity='0 -9.81 0' dt='0.01'>{}{}"
      "<RegularGridTopology n='9 9 9' min='0 0 0' max='0.1 0.1 0.1'/><MechanicalObject name='dofs'/>"
      "<UniformMass totalMass='1'/>"
      "<BoxROI name='wall' box='-0.001 -0.001 -0.001  0.001 0.101 0.101' position='@dofs.rest_position'/>"
      "<BoxROI name='far' box='0.099 -0.001 -0.001  0.101 0.101 0.101' position='@dofs.rest_position'/>"
      "<FixedProjectiveConstraint indices='@wall.indices'/>"
      "<LinearMovementProjectiveConstraint indices='@far.indices' keyTimes='0.1 0.15 0.3' movements='0 0 0  0 0.002 0  0 0.002 0' "
      "outside='free'/>"
      "<HexahedronFEMForceField youngModulus='30000' poissonRatio='0.3' method='{}'/></Node>",
      integrator, solver, method));
}

/// What begins to be held while a scene runs still moves in former solutions and in a hierarchy that is kept.
TEST(FormerSolutions, StepsInWhichNodesBeginToBeHeldAreThoseOfADirectSolver) {
  const std::string linear = "<EulerImplicitSolver/>", newton = "<EulerImplicitSolver newtonIterations='20' newtonTolerance='1e-9'/>";
  for (const std::string& integrator : {linear, newton})
    for (const std::string method : {"polar", "green"})
      for (const std::string solver : {"<AutomaticLinearSolver tolerance='1e-10'/>",
                                       "<PCGLinearSolver preconditioner='multigrid' tolerance='1e-10' iterations='400'/>"}) {
        SCOPED_TRACE(integrator + solver + method);
        Simulation direct = ledCube(integrator, "<SparseLDLSolver/>", method), iterated = ledCube(integrator, solver, method);
        for (int step = 0; step < 14; ++step) {
          direct.step();
          const StepReport report = iterated.step();
          EXPECT_TRUE(report.linear_converged);
          const ConstRows expected = direct.systems().at(0)->v, found = iterated.systems().at(0)->v;
          double most = 0, apart = 0;
          for (Index i = 0; i < expected.count; ++i) {
            most = std::max(most, Vec3(expected[i]).norm());
            apart = std::max(apart, (Vec3(expected[i]) - Vec3(found[i])).norm());
          }
          ASSERT_LE(apart, 1e-6 * most) << "step " << step;
        }
      }
}

/// The choice between conjugate gradients and factors is made by prices, which a run that goes on knows as the whole run does.
TEST(AutomaticLinearSolver, ARunThatGoesOnChoosesAsTheWholeRun) {
  const std::string text =
      R"(<Node name="root" dt="0.02" gravity="0 0 -9.81"><EulerImplicitSolver newtonIterations="10"/>
      <RegularGridTopology n="40 4 4" min="0 0 0" max="1 0.08 0.08"/><MechanicalObject/><UniformMass totalMass="1"/>
      <HexahedronFEMForceField youngModulus="1e5" poissonRatio="0.45" method="svd"/>
      <BoxROI name="end" box="-1e-3 -1 -1 1e-3 2 2"/><FixedProjectiveConstraint indices="@end.indices"/></Node>)";
  Simulation whole = simulationFromText(text), resumed = simulationFromText(text);
  ASSERT_FALSE(whole.step().failed());
  resumed.restore(whole.checkpoint().readable());
  for (int step = 0; step < 3; ++step) {
    whole.step(), resumed.step();
    EXPECT_EQ(whole.stateHash(), resumed.stateHash()) << step;
  }
}

}  // namespace
}  // namespace stroma::test
