// SPDX-License-Identifier: LGPL-2.1-or-later
// Linear relations between displacements against closed forms, a merged mesh and Lagrange multipliers.
#include <fmt/format.h>

#include <Eigen/Dense>

#include "tests/constraints/attached_bodies.h"
#include "tests/support/dense_algebra.h"
#include "tests/support/scene_text.h"
#include "tests/support/stored_matrix.h"

namespace stroma::test {
namespace {

std::string relation(const std::string& attributes) {
  return "<LinearRelationProjectiveConstraint " + attributes + "/>";
}

// ---- two bodies as one ----

class RelatedBlocks : public ::testing::TestWithParam<std::array<std::string, 2>> {};

/// u_a - u_b = 0 at nodes (2, j, k) of the first block and (0, j, k) of the second.
TEST_P(RelatedBlocks, MoveAsTheMergedBlock) {
  const auto& [integrator, solver] = GetParam();
  std::string relations;
  for (int jk = 0; jk < 9; ++jk)
    relations +=
        relation(fmt::format("object1='@a/dofs' object2='@b/dofs' indices='{}' coefficients='-2' indices2='{}' "
                             "coefficients2='2'",
                             2 + 3 * jk, 3 * jk));
  expectTheMergedBlock(integrator, solver, relations, 1e-14);
}

INSTANTIATE_TEST_SUITE_P(
    Integrators, RelatedBlocks,
    ::testing::Values(
        std::array<std::string, 2>{"<EulerImplicitSolver/>", "<CGLinearSolver iterations='900' tolerance='1e-13'/>"},
        std::array<std::string, 2>{
            "<EulerImplicitSolver/>",
            "<CGLinearSolver iterations='900' tolerance='1e-13' template='CompressedRowSparseMatrix'/>"},
        std::array<std::string, 2>{"<EulerImplicitSolver/>", "<CGLinearSolver tolerance='1e-13'/>"},
        std::array<std::string, 2>{"<EulerImplicitSolver/>",
                                   "<PCGLinearSolver iterations='900' tolerance='1e-13'/><SSORPreconditioner/>"},
        std::array<std::string, 2>{"<EulerImplicitSolver/>",
                                   "<MinResLinearSolver iterations='900' tolerance='1e-13'/>"},
        std::array<std::string, 2>{"<EulerImplicitSolver/>", "<SparseLDLSolver/>"},
        std::array<std::string, 2>{"<EulerImplicitSolver newtonIterations='20' newtonTolerance='1e-12'/>",
                                   "<SparseLDLSolver/>"},
        std::array<std::string, 2>{"<EulerExplicitSolver/>", "<SparseLDLSolver/>"},
        std::array<std::string, 2>{"<StaticSolver newton_iterations='40'/>", "<SparseLDLSolver/>"}));

// ---- statics against Lagrange multipliers ----

/// A small-strain block with relations whose directions are oblique, some of which repeat others or end at held nodes:
///   [ K  C^T ] [ u      ]   [ f ]
///   [ C   0  ] [ lambda ] = [ 0 ]
TEST(LinearRelation, TheForcesAreThoseOfLagrangeMultipliers) {
  const auto scene = [](const std::string& more) {
    return R"(<Node name="root" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/>
      <RegularGridTopology name="grid" n="3 3 3" min="0 0 0" max="2 2 2"/><MechanicalObject name="dofs"/>
      <UniformMass totalMass="1"/><HexahedronFEMForceField youngModulus="3000" poissonRatio="0.3" method="small"/>
      <ConstantForceField indices="26 8" forces="3 1 -2  -1 2 4"/>)" +
           more + "</Node>";
  };
  const std::string held = "<FixedProjectiveConstraint indices='0 3 6 9 12 15 18 21 24'/>";
  const std::string relations = relation("indices='26 8 20' coefficients='1 2 -3' directions='1 1 0  0 1 2  1 -1 1'") +
                                relation("indices='8 26' coefficients='4 2' directions='0 1 2  1 1 0'") +
                                relation("indices='20 8' coefficients='2 0.5'") +
                                relation("indices='20 8' coefficients='-4 -1'") +  // says nothing new
                                relation("indices='0 17' coefficients='1 1' directions='0 0 1'") +
                                relation("indices='0 3' coefficients='1 5'");  // of held nodes alone
  Simulation simulation = simulationFromText(scene(held + relations));
  Simulation free = simulationFromText(scene("") + "");
  System& system = *simulation.systems().at(0);
  ASSERT_TRUE(simulation.step().newton_converged);

  const int n = 81;
  System& unheld = *free.systems().at(0);
  unheld.computeForce(unheld.x, unheld.v, unheld.f);
  const Eigen::MatrixXd stiffness = StoredMatrix(unheld.matrix().withFactors({.stiffness = -1}).assemble()).dense();
  std::vector<Eigen::RowVectorXd> rows;
  const auto add = [&rows](std::initializer_list<std::pair<int, Vec3>> terms) {
    rows.push_back(Eigen::RowVectorXd::Zero(n));
    for (const auto& [node, c] : terms) rows.back().segment<3>(3 * node) += c.transpose();
  };
  for (int node = 0; node < 27; node += 3)
    for (int axis = 0; axis < 3; ++axis) add({{node, Vec3::Unit(axis)}});
  add({{26, Vec3(1, 1, 0)}, {8, 2 * Vec3(0, 1, 2)}, {20, -3 * Vec3(1, -1, 1)}});
  add({{8, 4 * Vec3(0, 1, 2)}, {26, 2 * Vec3(1, 1, 0)}});
  for (int axis = 0; axis < 3; ++axis) add({{20, 2 * Vec3::Unit(axis)}, {8, 0.5 * Vec3::Unit(axis)}});
  add({{17, Vec3::UnitZ()}});
  const int m = int(rows.size());
  Eigen::MatrixXd kkt = Eigen::MatrixXd::Zero(n + m, n + m);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n + m);
  kkt.topLeftCorner(n, n) = stiffness;
  for (int r = 0; r < m; ++r)
    kkt.row(n + r).head(n) = rows[std::size_t(r)], kkt.col(n + r).head(n) = rows[std::size_t(r)];
  right.segment<3>(3 * 26) = Vec3(3, 1, -2), right.segment<3>(3 * 8) = Vec3(-1, 2, 4);
  const Eigen::VectorXd solution = leastSquares(kkt, right);
  ASSERT_LT((kkt * solution - right).norm(), 1e-9);
  ASSERT_GT(solution.head(n).norm(), 1e-3);
  for (int node = 0; node < 27; ++node)
    EXPECT_LT(
        (system.x[node] - simulation.states()[0]->rest_position[std::size_t(node)] - solution.segment<3>(3 * node))
            .norm(),
        1e-10 * solution.head(n).norm())
        << node;
}

/// Two layers in series under a periodic strain: the mean stress of the cell is that of E = 2 E1 E2 / (E1 + E2). One node more is
/// held, against the turn about x that the relations let through.
TEST(LinearRelation, APeriodicCellOfTwoLayersHasTheHarmonicMeanOfTheirModuli) {
  std::string relations;
  for (int jk = 0; jk < 4; ++jk) relations += fmt::format("{} {}  ", 3 * jk, 2 + 3 * jk);
  const double first = 1000, second = 4000, strain = 1e-3;
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" gravity="0 0 0" dt="1"><StaticSolver/><SparseLDLSolver/>
        <Node name="strain"><MechanicalObject name="dofs" position="0 0 0"/>
          <LinearMovementProjectiveConstraint indices="0" keyTimes="0 1" movements="0 0 0  {} 0 0" outside="hold"/></Node>
        <Node name="cell"><RegularGridTopology name="grid" n="3 2 2" min="0 0 0" max="2 1 1"/><MechanicalObject name="dofs"/>
          <HexahedronFEMForceField name="fem" youngModulus="{} {}" poissonRatio="0" method="small"/>
          <FixedProjectiveConstraint indices="0"/><PartialFixedProjectiveConstraint indices="3" fixedDirections="0 0 1"/>
          <LinearRelationProjectiveConstraint indices="{}" coefficients="-1 1" object2="@../strain/dofs" indices2="0"
                                              coefficients2="-2"/></Node></Node>)",
      strain, first, second, relations));
  ASSERT_TRUE(simulation.step().newton_converged);
  const double modulus = 2 * first * second / (first + second);
  const State& cell = *simulation.states()[1];
  for (int jk = 0; jk < 4; ++jk) {
    const Index left = 3 * jk;
    EXPECT_NEAR(cell.x()[left + 2][0] - cell.x()[left][0], 2 * (1 + strain), 1e-14);
    EXPECT_NEAR(cell.x()[left + 1][0] - cell.x()[left][0], 1 + strain * modulus / first, 1e-14);
  }
}

// ---- dynamics ----

/// m1 and m2 on a line with u1 + 2 u2 = U(t), U = A (1 - cos W t) the place of a third node; a spring k to the ground at
/// the first. With M = 4 m1 + m2:  M u2'' = -4 k u2 + 2 m1 U'' + 2 k U.
struct Lever {
  double m1 = 1, m2 = 3, k = 40, amplitude = 0.2, pulsation = 3;
  std::string scene(const std::string& integrator, double dt) const {
    return fmt::format(
        R"(<Node name="root" dt="{}" gravity="0 0 0">{}<SparseLDLSolver/>
          <MechanicalObject name="dofs" position="0 0 0  5 0 0  9 0 0"/><DiagonalMass vertexMass="{} {} 1"/>
          <RestShapeSpringsForceField indices="0" stiffness="{}"/>
          <OscillatorProjectiveConstraint oscillators="2  {} 0 0  {} 0 0  {} {}"/>
          <LinearRelationProjectiveConstraint indices="0 1 2" coefficients="1 2 -1"/></Node>)",
        dt, integrator, m1, m2, k, 9 + amplitude, amplitude, pulsation, -M_PI / 2);
  }
  double second(double t) const {
    const double mass = 4 * m1 + m2, square = 4 * k / mass, natural = std::sqrt(square);
    const double still = 2 * k * amplitude / mass, swing = (2 * m1 * pulsation * pulsation - 2 * k) * amplitude / mass;
    return still / square * (1 - std::cos(natural * t)) +
           swing / (square - pulsation * pulsation) * (std::cos(pulsation * t) - std::cos(natural * t));
  }
};

using OrderOf = std::pair<std::string, double>;  // an integrator and its order
class MovedRelation : public ::testing::TestWithParam<OrderOf> {};

TEST_P(MovedRelation, HasTheOrderOfTheIntegrator) {
  const auto& [integrator, order] = GetParam();
  const Lever lever;
  const auto error = [&, integrator = integrator](int steps) {
    Simulation simulation = simulationFromText(lever.scene(integrator, 1.0 / steps));
    const System& system = *simulation.systems().at(0);
    double largest = 0;
    for (int i = 0; i < steps; ++i) {
      EXPECT_FALSE(simulation.step().diverged);
      const double t = simulation.time(), moved = lever.amplitude * (1 - std::cos(lever.pulsation * t));
      EXPECT_NEAR(system.x[0][0] + 2 * (system.x[1][0] - 5), moved, 1e-14);
      EXPECT_NEAR(system.v[0][0] + 2 * system.v[1][0],
                  lever.amplitude * lever.pulsation * std::sin(lever.pulsation * t), 1e-13);
      largest = std::max(largest, std::abs(system.x[1][0] - 5 - lever.second(t)));
    }
    return largest;
  };
  const double coarse = error(100), fine = error(200);
  EXPECT_GT(std::log2(coarse / fine), order - 0.15) << coarse << " " << fine;
}

INSTANTIATE_TEST_SUITE_P(
    Integrators, MovedRelation,
    ::testing::Values(OrderOf("<EulerImplicitSolver/>", 1.0), OrderOf("<EulerExplicitSolver/>", 1.0),
                      OrderOf("<CentralDifferenceSolver/>", 2.0), OrderOf("<TrapezoidalRuleSolver/>", 2.0),
                      OrderOf("<NewmarkImplicitSolver/>", 2.0), OrderOf("<BDFOdeSolver order='2'/>", 2.0),
                      OrderOf("<BDFOdeSolver order='2' newtonIterations='5'/>", 2.0),
                      OrderOf("<VariationalSymplecticSolver/>", 2.0), OrderOf("<RungeKutta4Solver/>", 4.0)));

/// Forces of the constraint do no work, whatever the masses: m1 + m2 / 4 on the spring.
TEST(LinearRelation, SharesMomentumByMass) {
  for (const char* integrator : {"<EulerExplicitSolver/>", "<EulerImplicitSolver/>"}) {
    Simulation simulation = simulationFromText(points(
        "0 0 0 5 0 0", "0 0 0 0 0 0", "1 3",
        "<ConstantForceField indices='0' forces='8 4 0'/>" + relation("indices='0 1' coefficients='1 2'"), integrator));
    const System& system = *simulation.systems().at(0);
    simulation.step();
    EXPECT_LT((system.v[0] - 0.1 / (1 + 3. / 4) * Vec3(8, 4, 0)).norm(), 1e-14) << integrator;
    EXPECT_LT((system.v[1] + 0.05 / (1 + 3. / 4) * Vec3(8, 4, 0)).norm(), 1e-14) << integrator;
  }
}

TEST(LinearRelation, AppliesToGroupsAndToNodesThatSlide) {
  for (const char* integrator : {"<EulerExplicitSolver/>", "<EulerImplicitSolver/>"}) {
    Simulation simulation =
        simulationFromText(points("0 0 0 0 0 0 5 0 0", "0 0 0 0 0 0 0 0 0", "1 3 2",
                                  "<ConstantForceField indices='0' forces='8 4 2'/>"
                                  "<AttachProjectiveConstraint indices1='0' indices2='1' twoWay='1'/>"
                                  "<PartialFixedProjectiveConstraint indices='2' fixedDirections='0 1 0'/>" +
                                      relation("indices='1 2' coefficients='1 1'"),
                                  integrator));
    const System& system = *simulation.systems().at(0);
    simulation.step();
    const Vec3 expected = 0.1 / (4 + 2) * Vec3(8, 0, 2);
    for (Index i = 0; i < 2; ++i) EXPECT_LT((system.v[i] - expected).norm(), 1e-14) << integrator;
    EXPECT_LT((system.v[2] + expected).norm(), 1e-14) << integrator;
  }
}

/// A relation of one node holds it, with a preconditioner of diagonal blocks too.
TEST(LinearRelation, OfOneNodeHoldsIt) {
  const std::string solver = "<CGLinearSolver tolerance='1e-13'/>";
  const std::string slides = "<PartialFixedProjectiveConstraint indices='13 22' fixedDirections='1 0 1'/>";
  const std::string related = relation("indices='13 22' coefficients='3' directions='1 0 0'") +
                              relation("indices='13 22' coefficients='-1' directions='1 0 1'");
  Simulation held_nodes =
      simulationFromText(root("<EulerImplicitSolver/>", solver, block("a", 2, 0, held("wall") + slides)));
  Simulation relations =
      simulationFromText(root("<EulerImplicitSolver/>", solver, block("a", 2, 0, held("wall") + related)));
  for (int step = 0; step < 20; ++step) {
    held_nodes.step();
    const StepReport report = relations.step();
    ASSERT_TRUE(report.linear_converged) << report.linear_residual;
  }
  const ConstRows x = held_nodes.states()[0]->x(), y = relations.states()[0]->x();
  for (Index i = 0; i < x.count; ++i) EXPECT_LT((x[i] - y[i]).norm(), 1e-9) << i;
}

TEST(LinearRelation, EndsWithItsTime) {
  for (const char* integrator : {"<EulerExplicitSolver/>", "<EulerImplicitSolver/>"}) {
    Simulation simulation = simulationFromText(points("0 0 0 5 0 0", "0 0 0 0 0 0", "1 3",
                                                      "<ConstantForceField indices='0' forces='8 0 0'/>" +
                                                          relation("indices='0 1' coefficients='1 2' endTime='0.05'"),
                                                      integrator));
    const System& system = *simulation.systems().at(0);
    simulation.step();
    const double together = system.v[1].x();
    EXPECT_LT(together, 0);
    simulation.step();
    EXPECT_NEAR(system.v[1].x(), together, 1e-15);
    EXPECT_NEAR(system.v[0].x(), -2 * together + 0.1 * 8, 1e-14);
  }
}

TEST(LinearRelation, NodesStartWhereItHolds) {
  Simulation simulation =
      simulationFromText(points("0 0 0 5 0 0", "3 0 0 1 0 0", "1 4", relation("indices='0 1' coefficients='1 2'")));
  const System& system = *simulation.systems().at(0);
  // an impulse along (1, 2): v1 + 2 v2 = 5 becomes zero by (1/1 + 4/4) lambda = 5
  EXPECT_LT((system.v[0] - Vec3(0.5, 0, 0)).norm(), 1e-15);
  EXPECT_LT((system.v[1] - Vec3(-0.25, 0, 0)).norm(), 1e-15);
}

/// A hold that comes by a tie and ends with it: the relation's nodes are then free, and have their places in the matrix.
TEST(LinearRelation, OutlivesATieToAHeldNode) {
  const std::string pin =
      "<Node name='c'><MechanicalObject name='pin' position='2 0 0'/><UniformMass totalMass='1'/>"
      "<FixedProjectiveConstraint indices='0'/></Node>";
  const std::string ties =
      "<AttachProjectiveConstraint object1='@c/pin' object2='@a/dofs' indices1='0' indices2='2' twoWay='1' "
      "endTime='0.035'/>" +
      relation("object1='@a/dofs' object2='@b/dofs' indices='2' coefficients='1' indices2='13' coefficients2='-1'");
  std::vector<Vec3> ends;
  for (const char* solver : {"<SparseLDLSolver/>", "<CGLinearSolver tolerance='1e-13'/>"}) {
    Simulation simulation = simulationFromText(
        root("<EulerImplicitSolver/>", solver, block("a", 2, 0, held("wall")) + block("b", 2, 2, "") + pin + ties));
    for (int step = 0; step < 10; ++step) ASSERT_FALSE(simulation.step().diverged);
    const ConstRows a = simulation.states()[0]->x(), b = simulation.states()[1]->x();
    EXPECT_LT((a[2] - Vec3(2, 0, 0) - (b[13] - simulation.states()[1]->rest_position[13])).norm(), 1e-14);
    EXPECT_GT((a[2] - Vec3(2, 0, 0)).norm(), 1e-4) << "it is free again";
    ends.push_back(b[0]);
  }
  EXPECT_LT((ends[0] - ends[1]).norm(), 1e-9);
}

TEST(LinearRelation, HoldsHoweverDifferentItsCoefficientsAre) {
  for (const char* coefficients : {"1e11 1", "1 1e11", "1e80 1e80", "1e-80 1e-80"}) {
    Simulation simulation = simulationFromText(
        points("0 0 0 5 0 0", "0 0 0 0 0 0", "1 3",
               "<FixedProjectiveConstraint indices='0'/><ConstantForceField indices='1' forces='8 4 0'/>" +
                   relation(fmt::format("indices='0 1' coefficients='{}'", coefficients))));
    for (int step = 0; step < 5; ++step) simulation.step();
    EXPECT_LT((simulation.states()[0]->x()[1] - Vec3(5, 0, 0)).norm(), 1e-14) << coefficients;
  }
}

/// The pattern of a mean over many nodes: as many blocks as it has, not their cube.
TEST(LinearRelation, TheMeanOfManyNodesIsAffordable) {
  std::string top;
  for (int i = 0; i < 441; ++i) top += fmt::format("{} ", 882 + i);
  std::string ones(2 * 441, ' ');
  for (int i = 0; i < 441; ++i) ones[std::size_t(2 * i)] = '1';
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="0.01" gravity="0 0 -10"><EulerImplicitSolver/><CGLinearSolver tolerance="1e-10"/>
        <RegularGridTopology name="grid" n="21 21 3" min="0 0 0" max="10 10 1"/><MechanicalObject name="dofs"/>
        <UniformMass totalMass="10"/><HexahedronFEMForceField youngModulus="3000" poissonRatio="0.3" method="large"/>
        <BoxROI name="floor" box="-1 -1 -0.1 11 11 0.1"/><FixedProjectiveConstraint indices="@floor.indices"/>
        <LinearRelationProjectiveConstraint indices="{}" coefficients="{}"/></Node>)",
      top, ones));
  for (int step = 0; step < 3; ++step) ASSERT_TRUE(simulation.step().linear_converged);
  Vec3 mean = Vec3::Zero();
  for (Index i = 882; i < 1323; ++i)
    mean += (simulation.states()[0]->x()[i] - simulation.states()[0]->rest_position[std::size_t(i)]) / 441;
  EXPECT_LT(mean.norm(), 1e-13);
}

// ---- mistakes ----

std::string refusal(const std::string& more) {
  try {
    simulationFromText(points("0 0 0 5 0 0 6 0 0", "0 0 0 0 0 0 0 0 0", "1 3 2", more));
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

TEST(LinearRelation, MistakesAreNamed) {
  const auto expect = [](const std::string& more, const std::string& part) {
    const std::string sentence = refusal(more);
    EXPECT_NE(sentence.find(part), std::string::npos) << sentence;
  };
  expect(relation("indices='0 1 2' coefficients='1 2'"), "a multiple of 2 nodes");
  expect(relation("indices='0 1 2 2' coefficients='1 -1'"), "indices has node 2 twice in one relation");
  expect(relation("indices='0 1' coefficients='1 0'"), "coefficients holds 0");
  expect(relation("indices='0 1' coefficients='1 nan'"), "coefficients");
  expect(relation("indices='0 7' coefficients='1 1'"), "indices");
  expect(relation("indices='0 1' coefficients='1 1' directions='1 0 0  0 0 0'"), "a direction is 0 0 0");
  expect(relation("indices='0 1' coefficients='1 1' directions='1 0 0  0 1 0  0 0 1'"), "directions has 3 values");
  expect(relation("indices='0 1' coefficients='1 1' indices2='2'"), "coefficients2 has 0 numbers");
  expect(relation("indices='0 1' coefficients='1 1' indices2='2' coefficients2='1' directions='1 0 0'"),
         "both or none");
  expect("<RigidConstraint indices='0 1'/>" + relation("indices='0 1' coefficients='1 1'"), "would violate relations");
}

TEST(LinearRelation, HeldNodesThatContradictItStopTheRun) {
  Simulation simulation = simulationFromText(points(
      "0 0 0 5 0 0 6 0 0", "0 0 0 0 0 0 0 0 0", "1 3 2",
      "<FixedProjectiveConstraint indices='0'/><LinearMovementProjectiveConstraint indices='1' keyTimes='0 0.2 1' "
      "movements='0 0 0  0 0 0  0.8 0 0'/>" +
          relation("indices='0 1' coefficients='1 1'")));
  EXPECT_TRUE(simulation.step().reason.empty());
  simulation.step();
  const StepReport report = simulation.step();
  EXPECT_NE(
      (report.reason + report.constraint_reason)
          .find("/LinearRelationProjectiveConstraint: the relation of node 0 of /dofs, node 1 of /dofs cannot be satisfied"),
      std::string::npos)
      << report.reason;
  EXPECT_TRUE(report.diverged || report.unsolved || !report.constraints_converged);
}

}  // namespace
}  // namespace stroma::test
