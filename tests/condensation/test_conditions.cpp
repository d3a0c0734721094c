// SPDX-License-Identifier: LGPL-2.1-or-later
// Lagrangian constraints and contact on condensed bodies. EulerImplicitSolver has the equations of CondensedDynamicSolver without
// damping, and solves them by other means: a solve with the whole matrix for each condition, and sweeps of Gauss and Seidel. In
// steps of 1e5 s the inertia is gone and it has those of CondensedStaticSolver.
#include <fmt/format.h>

#include <random>

#include "components/condensation/condition_forces.h"
#include "framework/collision/pair_distances.h"
#include "framework/mechanics/state_topology.h"
#include "tests/condensation/bodies.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using Kind = LagrangianRows::Kind;

const std::string whole = "<EulerImplicitSolver/><SparseLDLSolver/>";
const std::string dynamic_solvers[] = {"<CondensedDynamicSolver/>", "<CondensedDynamicSolver condensed=\"false\" solve=\"factor\"/>",
                                       "<CondensedDynamicSolver condensed=\"false\" solve=\"inverse\"/>"};
const std::string static_solvers[] = {"<CondensedStaticSolver/>", "<CondensedStaticSolver condensed=\"false\"/>"};

/// A sphere that is pressed 4 mm into the side of the block and moved along it, in ten steps.
std::string sphere(double dt, double friction) {
  return fmt::format(
      "<ConstraintContact name=\"contact\" spheres=\"0.105 0.033 0.09 0.024\" keyTimes=\"0 {} {}\" movements=\"0 0 0  -0.005 0 0  "
      "-0.005 0.002 0.003\" contactDistance=\"1e-4\" friction=\"{}\"/>",
      5 * dt, 10 * dt, friction);
}

Vector heldAfter(const std::string& scene, int steps) {
  Simulation simulation = simulationFromText(scene);
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.step();
    EXPECT_FALSE(report.diverged || report.unsolved) << report.reason;
    EXPECT_TRUE(report.constraints_converged) << report.constraint_reason;
  }
  return displacement(simulation);
}

/// All solvers against the whole body, and that the conditions matter.
template <class Solvers>
void expectWhole(const Solvers& solvers, Block block, int steps, double tolerance) {
  block.solver = whole;
  const Vector expected = heldAfter(block.text(), steps);
  for (const std::string& solver : solvers) {
    SCOPED_TRACE(solver);
    block.solver = solver;
    EXPECT_LT(difference(heldAfter(block.text(), steps), expected), tolerance);
  }
  block.loads.clear();
  EXPECT_GT(difference(after(block.text(), steps), expected), 1e-3) << "nothing is held";
}

const std::string joints =
    "<FixedLagrangianConstraint indices=\"139\"/><DistanceLagrangianConstraint first_point=\"120 134\" second_point=\"137 121\" "
    "distances=\"0.065 0.068\"/>";
const std::string dragged =
    "<LinearMovementProjectiveConstraint indices=\"136\" keyTimes=\"0 {0} {1}\" movements=\"0 0 0  0.002 0.001 -0.001  0 0 0\"/>"
    "<FixedPlaneProjectiveConstraint indices=\"60 61\" direction=\"0 1 0\"/>";

TEST(CondensedConditions, ADynamicBodyIsTheWholeBody) {
  constexpr double dt = 0.002;
  for (const double friction : {0.0, 0.4}) {
    SCOPED_TRACE(friction);
    expectWhole(dynamic_solvers, {.loads = sphere(dt, friction), .gravity = "0 0 0", .dt = dt}, 10, 1e-7);
  }
  expectWhole(dynamic_solvers, {.loads = joints, .dt = dt}, 10, 1e-7);
}

TEST(CondensedConditions, AStaticBodyIsTheWholeBody) {
  constexpr double dt = 1e5;
  for (const double friction : {0.0, 0.4}) {
    SCOPED_TRACE(friction);
    expectWhole(static_solvers, {.loads = sphere(dt, friction), .gravity = "0 0 0", .dt = dt}, 10, 1e-7);
  }
  expectWhole(static_solvers, {.loads = joints, .dt = dt}, 4, 1e-7);
}

TEST(CondensedConditions, NodesThatAreDraggedAreInTheCompliance) {
  for (const double dt : {0.002, 1e5}) {
    const std::string loads = fmt::format(fmt::runtime(dragged), 5 * dt, 20 * dt) + sphere(dt, 0.3) + joints;
    Block block{.loads = loads, .gravity = "0 0 0", .dt = dt};
    dt < 1 ? expectWhole(dynamic_solvers, block, 8, 1e-7) : expectWhole(static_solvers, block, 8, 1e-7);
  }
}

/// Of the whole surface: distances of all its triangles from the centre, by what finds no pairs.
TEST(CondensedConditions, NothingIsInTheSphere) {
  constexpr double dt = 1;
  const Block block{.solver = "<CondensedStaticSolver/>", .loads = sphere(dt, 0.4), .gravity = "0 0 0", .dt = dt};
  Simulation simulation = simulationFromText(block.text());
  const State& state = *simulation.states().back();
  const auto triangles = topologyOf(state)->mesh().boundaryTriangles();
  double nearest = 1;
  for (int step = 1; step <= 10; ++step) {
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.constraints_converged) << report.constraint_reason;
    const Vec3 moved = step <= 5 ? Vec3(-0.001 * step, 0, 0) : Vec3(-0.005, 0.0004 * (step - 5), 0.0006 * (step - 5));
    const Vec3 centre = Vec3(0.105, 0.033, 0.09) + moved;
    for (const Triangle& t : triangles)
      nearest = std::min(
          nearest, closestPoints(PairKind::point_triangle, {centre, state.x()[t[0]], state.x()[t[1]], state.x()[t[2]]}).distance());
  }
  EXPECT_NEAR(nearest, 0.024 + 1e-4, 1e-9);
}

TEST(CondensedConditions, ARunRepeatsBitForBitAlsoFromACheckpoint) {
  std::string slides = sphere(1, 0.4);
  slides.replace(slides.find("-0.005 0.002 0.003"), 18, "-0.005 0.002 0.040").replace(slides.find("keyTimes=\"0 5 10\""), 17,
                                                                                      "keyTimes=\"0 5 20\"");
  const Block block{.solver = "<CondensedStaticSolver/>", .loads = slides, .gravity = "0 0 0", .dt = 1};
  Simulation simulation = simulationFromText(block.text());
  for (int i = 0; i < 20; ++i) simulation.step();  // slides along several cells
  simulation.reset();
  for (int i = 0; i < 20; ++i) simulation.step();
  EXPECT_EQ(difference(displacement(simulation), heldAfter(block.text(), 20)), 0);
  Simulation whole_run = simulationFromText(block.text()), restored = simulationFromText(block.text());
  for (int i = 0; i < 12; ++i) whole_run.step();
  restored.restore(whole_run.checkpoint());
  for (int i = 12; i < 20; ++i) whole_run.step(), restored.step();
  EXPECT_EQ(difference(displacement(restored), displacement(whole_run)), 0);
}

TEST(CondensedConditions, BarriersAreRefusedWithWhatWorks) {
  for (const std::string solver : {"Static", "Dynamic"}) {
    const Block block{.solver = "<Condensed" + solver + "Solver/>",
                      .loads = "<BarrierContact spheres=\"0.2 0 0 0.01\" selfContact=\"false\"/>"};
    const std::string problems = problemsOf(block.text());
    EXPECT_NE(problems.find("ConstraintContact"), std::string::npos) << problems;
  }
}

TEST(CondensedConditions, OnInsideNodesAreToldWithTheNode) {
  const Block block{.solver = "<CondensedStaticSolver/>", .loads = "<FixedLagrangianConstraint name=\"pin\" indices=\"66\"/>"};
  Simulation simulation = simulationFromText(block.text());
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.diverged);
  for (const char* word : {"/body/pin", "node 66", "surfaceIndices"})
    EXPECT_NE(report.reason.find(word), std::string::npos) << word << " in: " << report.reason;
}

/// Signorini's and Coulomb's conditions themselves, where many contacts hold each other.
TEST(ConditionForces, AreThoseOfSignoriniAndCoulomb) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (const double mu : {0.1, 0.7})
    for (const int contacts : {1, 7, 40}) {
      SCOPED_TRACE(fmt::format("mu {} contacts {}", mu, contacts));
      LagrangianRows rows;
      ConditionForces forces;
      const Eigen::Index n = 3 * contacts;
      Eigen::MatrixXd roots(n, n);
      for (Eigen::Index i = 0; i < n * n; ++i) roots.data()[i] = normal(random);
      forces.w = roots * roots.transpose() / double(n) + 0.2 * Eigen::MatrixXd::Identity(n, n);
      forces.g.resize(n), forces.l.setZero(n), forces.sizes.assign(std::size_t(n), 1);
      for (Eigen::Index i = 0; i < n; ++i) {
        forces.g[i] = i % 3 == 0 ? normal(random) - 0.5 : 0.5 * normal(random);
        rows.begin(i % 3 == 0 ? Kind::push : Kind::rub, forces.g[i], i % 3 == 0 ? 0 : mu);
      }
      const Eigen::VectorXd g = forces.g;
      forces.solve(rows.rows());
      EXPECT_LT(forces.unsettled(), 1e-11);
      const Eigen::VectorXd at = g + forces.w * forces.l;
      int open = 0, sticks = 0, slips = 0;
      for (Eigen::Index i = 0; i < n; i += 3) {
        const double l = forces.l[i];
        const Eigen::Vector2d along = forces.l.segment<2>(i + 1), way = at.segment<2>(i + 1);
        EXPECT_GE(l, 0);
        EXPECT_GE(at[i], -1e-10);
        EXPECT_NEAR(l * at[i], 0, 1e-9);
        EXPECT_LE(along.norm(), mu * l + 1e-9);
        if (l == 0) {
          ++open;
        } else if (way.norm() < 1e-9) {
          ++sticks;
        } else {
          ++slips;
          EXPECT_NEAR(along.norm(), mu * l, 1e-9);
          EXPECT_NEAR(along.dot(way), -along.norm() * way.norm(), 1e-8) << "against the way";
        }
      }
      if (contacts < 40) continue;
      EXPECT_TRUE(open > 0 && slips > 0 && (sticks > 0 || mu < 0.5)) << open << " " << sticks << " " << slips;
    }
}

TEST(ConditionForces, TellNumbersThatAreNone) {
  LagrangianRows rows;
  for (int i = 0; i < 2; ++i) rows.begin(Kind::push, -1);
  ConditionForces forces;
  forces.w.setIdentity(2, 2), forces.g = Eigen::Vector2d(std::nan(""), -1), forces.l.setZero(2), forces.sizes.assign(2, 1);
  forces.solve(rows.rows());
  EXPECT_FALSE(std::isfinite(forces.unsettled()));
}

/// Rows that say the same twice share the force, and a bound is kept.
TEST(ConditionForces, OfEqualRowsAndOfBounds) {
  LagrangianRows rows;
  for (int i = 0; i < 2; ++i) rows.begin(Kind::equal, -1);
  rows.begin(Kind::push, -6, 2);
  ConditionForces forces;
  forces.w = Eigen::Matrix3d{{2, 2, 0}, {2, 2, 0}, {0, 0, 1}};
  forces.g = Eigen::Vector3d(-1, -1, -6), forces.l.setZero(3), forces.sizes.assign(3, 1);
  forces.solve(rows.rows());
  EXPECT_NEAR(forces.l[0] + forces.l[1], 0.5, 1e-12);
  EXPECT_NEAR(forces.l[0], forces.l[1], 1e-12);
  EXPECT_NEAR(forces.l[2], 2, 1e-12) << "no more than its bound";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
