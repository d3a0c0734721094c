// SPDX-License-Identifier: LGPL-2.1-or-later
// The System: layout, forces, constraints and what it says.
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "tests/support/scene_text.h"
#include "tools/checks/result_doubts.h"
#include "tools/plan/plan.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr const char* line = "0 0 0  1 0.1 0  2 0 0.2  3 0.1 0.1";

/// Two bodies, and between them in the file a state mapped from the second.
const std::string two_bodies = fmt::format(R"(
  <Node name="root" gravity="0 -10 0"><TestIntegrator name="integrator"/>
    <Node name="a"><MechanicalObject name="dofs" position="5 0 0 6 0 0" velocity="0 0 1 0 0 1"/>
      <UniformMass name="mass" totalMass="4"/></Node>
    <Node name="mapped"><MechanicalObject name="dofs" size="3"/>
      <TestMean name="mean" input="@/b/dofs" output="@/mapped/dofs"/></Node>
    <Node name="b" gravity="1 0 0"><MechanicalObject name="dofs" position="{}"/>
      <UniformMass name="mass" totalMass="8"/><TestSprings name="springs"/></Node>
  </Node>)",
                                           line);

TEST(SystemLayout, IndependentStatesComeFirstAndMappedOnesFollow) {
  Simulation simulation(sceneFromText(two_bodies));
  System& system = *simulation.systems()[0];
  ASSERT_EQ(system.states().size(), 3u);
  EXPECT_EQ(system.states()[0]->path(), "/a/dofs");
  EXPECT_EQ(system.states()[1]->path(), "/b/dofs");
  EXPECT_EQ(system.states()[2]->path(), "/mapped/dofs");
  EXPECT_EQ(system.independentRows(), 6);
  EXPECT_EQ(system.allRows(), 9);
  EXPECT_EQ(system.states()[2]->firstRow(), 6);
  EXPECT_EQ(Vec3(system.x[1]), Vec3(6, 0, 0));
  EXPECT_EQ(Vec3(system.v[1]), Vec3(0, 0, 1));
  EXPECT_EQ(Vec3(system.states()[1]->x()[3]), Vec3(3, 0.1, 0.1));
  EXPECT_LT((Vec3(system.x[6]) - Vec3(0.5, 0.05, 0)).norm(), 1e-15) << "mapped positions are in place from the start";
  EXPECT_EQ(system.actors().describeRow(4), "node 2 of /b/dofs");
}

TEST(SystemForces, GravityIsTheNodesOwnAndComputedOnce) {
  Simulation simulation(sceneFromText(two_bodies));
  System& system = *simulation.systems()[0];
  for (int i = 0; i < 3; ++i) system.computeForce(system.x, system.v, system.f);
  EXPECT_EQ(system.counts.gravity, 1);
  EXPECT_EQ(system.counts.forces, 3);
  EXPECT_EQ(Vec3(system.f[0]), Vec3(0, -20, 0));
  for (Index i = 2; i < 6; ++i) EXPECT_LT((Vec3(system.f[i]) - Vec3(2, 0, 0)).norm(), 1e-12) << "springs at rest";
  EXPECT_NEAR(system.gravityEnergy(system.x), -8 * 1.5, 1e-12);
  EXPECT_NEAR(system.kineticEnergy(), 2, 1e-15);
}

/// A bent state whose forces differ from node to node, so that nothing is tested on zeros.
void deform(System& system) {
  for (Index i = 0; i < system.independentRows(); ++i)
    system.x[i] += 0.2 * Vec3(std::sin(3 * i), std::cos(2 * i), std::sin(i));
  system.applyMappings();
}

Vector direction(Index rows) {
  Vector p(rows);
  for (Index i = 0; i < rows; ++i) p[i] = Vec3(std::sin(2 + i), std::cos(5 * i), std::sin(1 + 4 * i));
  return p;
}

class Mapped : public testing::TestWithParam<double> {};

/// Springs on the parent and on a state that is mapped from it, straight or bent.
std::string mappedScene(double bend) {
  return fmt::format(R"(<Node name="root" gravity="0 -10 3"><TestIntegrator/>
    <MechanicalObject name="dofs" position="{}"/><UniformMass totalMass="4"/><TestSprings stiffness="50"/>
    <Node name="child"><MechanicalObject name="dofs" size="3" rest_position="0 0 0 1 0 0 1 1 0"/><UniformMass totalMass="3"/>
      <TestSprings name="springs" stiffness="200"/>
      <TestMean input="@/dofs" output="@/child/dofs" bend="{}"/></Node></Node>)",
                     line, bend);
}

TEST_P(Mapped, ForceIsMinusTheGradientOfTheEnergy) {
  Simulation simulation(sceneFromText(mappedScene(GetParam())));
  System& system = *simulation.systems()[0];
  deform(system);
  system.computeForce(system.x, system.v, system.f);
  Vector x(system.allRows());
  copy(system.x, x);
  const double h = 1e-6;
  double size = 0;
  for (Index i = 0; i < system.independentRows(); ++i)
    for (int c = 0; c < 3; ++c) {
      x[i][c] = system.x[i][c] + h;
      const double plus = system.potentialEnergy(x);
      x[i][c] = system.x[i][c] - h;
      const double minus = system.potentialEnergy(x);
      x[i][c] = system.x[i][c];
      EXPECT_NEAR((minus - plus) / (2 * h), system.f[i][c], 1e-6);
      size = std::max(size, std::abs(system.f[i][c]));
    }
  EXPECT_GT(size, 10);
}

TEST_P(Mapped, ProductIsTheDerivativeOfTheForce) {
  Simulation simulation(sceneFromText(mappedScene(GetParam())));
  System& system = *simulation.systems()[0];
  deform(system);
  const Vector p = direction(system.allRows());
  Vector plus(system.allRows()), minus(system.allRows()), x(system.allRows()), product(system.independentRows());
  const double h = 1e-6;
  copy(system.x, x), axpy(h, p, x), system.computeForce(x, system.v, plus);
  copy(system.x, x), axpy(-h, p, x), system.computeForce(x, system.v, minus);
  system.computeForce(system.x, system.v, system.f);
  system.matrix().withFactors({.mass = 0, .stiffness = 2}).multiply(system.independent(p), product);
  Vector difference(system.independentRows());
  for (Index i = 0; i < system.independentRows(); ++i) difference[i] = (plus[i] - minus[i]) / h;
  EXPECT_GT(std::sqrt(dot(product, product)), 100);
  EXPECT_LT(distance(product, difference), 1e-6 * std::sqrt(dot(product, product)));

  // in one pass, and with the force alone in System::f where somebody asks for it
  axpy(1, system.independent(system.f), product);
  const double size = std::sqrt(dot(product, product));
  Vector both(system.allRows()), before(system.allRows());
  copy(system.f, before);
  system.computeForceAndProduct(system.x, system.v, p, {.stiffness = 2}, both);
  EXPECT_LT(distance(system.independent(both), product), 1e-12 * size);
  clear(system.f);
  system.requestForce();
  system.computeForceAndProduct(system.x, system.v, p, {.stiffness = 2}, both);
  EXPECT_LT(distance(system.independent(both), product), 1e-12 * size);
  EXPECT_LT(distance(before, system.f), 1e-12);
}

TEST_P(Mapped, MassOfTheChildReachesTheParent) {
  Simulation simulation(sceneFromText(mappedScene(GetParam())));
  System& system = *simulation.systems()[0];
  deform(system);
  const Vector p = direction(system.allRows());
  Vector out(system.independentRows());
  system.addMassProduct(p, 1, out);
  // p^T J^T M J p = v^T M v of the child, plus the parent's
  copy(p, system.v);
  system.applyMappings();
  double expected = 0;
  for (Index i = 0; i < system.allRows(); ++i) expected += system.v[i].squaredNorm();
  EXPECT_NEAR(dot(system.independent(p), out), expected, 1e-12);
  EXPECT_NEAR(2 * system.kineticEnergy(), expected, 1e-12);
  EXPECT_FALSE(system.actors().massIsDiagonal());
}

TEST_P(Mapped, MatrixIsTheProductsMatrix) {
  Simulation simulation(sceneFromText(mappedScene(GetParam())));
  System& system = *simulation.systems()[0];
  for (int turn = 0; turn < 2; ++turn) {  // at two shapes: the Jacobian of the bent one changes
    for (Index i = 0; i < system.independentRows(); ++i) system.x[i] += 0.05 * Vec3(i % 2, i % 3, 1 - i % 2);
    system.computeForce(system.x, system.v, system.f);
    const BlockMatrix& matrix = system.matrix().withFactors({.mass = 1, .stiffness = -1}).assemble();
    Vector p(system.independentRows()), by_matrix(system.independentRows()), by_product(system.independentRows());
    for (Index i = 0; i < system.independentRows(); ++i) p[i] = Vec3(std::sin(i), std::cos(3 * i), std::sin(2 + i));
    system.constraints().project(p);
    matrix.multiply(p, by_matrix);
    system.matrix().multiply(p, by_product);
    double size = std::sqrt(dot(by_product, by_product));
    axpy(-1, by_product, by_matrix);
    EXPECT_GT(size, 1);
    EXPECT_LT(std::sqrt(dot(by_matrix, by_matrix)), 1e-13 * size);
  }
}

INSTANTIATE_TEST_SUITE_P(Mappings, Mapped, testing::Values(0.0, 0.7),
                         [](const auto& bend) { return bend.index == 0 ? "Linear" : "Bent"; });

TEST(SystemErrors, NameWhatIsWrong) {
  const auto inRoot = [](const std::string& content) {
    return "<Node name='root'><TestIntegrator name='i'/>" + content + "</Node>";
  };
  expectContains(problemsOf(inRoot("")), "no mechanical state in / or below");
  const std::string state = "<MechanicalObject name='dofs' position='0 0 0 1 0 0'/>";
  expectContains(
      problemsOf(inRoot(state + "<UniformMass name='m' totalMass='1'/><UniformMass name='n' totalMass='1'/>")),
      "/dofs has two masses: /m and /n");
  expectContains(problemsOf(inRoot(state + "<TestUnsymmetric name='curl'/><TestSolver name='solver'/>")),
                 "/solver solves symmetric systems only, and the derivative of /curl is not symmetric");
  expectContains(problemsOf(inRoot(state + "<TestSolver name='one'/><TestSolver name='two'/>")), "two");
  expectContains(
      problemsOf("<Node name='root'><MechanicalObject name='far' position='0 0 0'/><Node name='b'><TestIntegrator/>" +
                 state + "<TestSprings name='s' mstate='@/far'/></Node></Node>"),
      "/far: /b/s acts on this state, but no integrator moves it");
  expectContains(problemsOf(inRoot(state + R"(<Node name="c"><MechanicalObject name="dofs" size="1"/>
    <FixedProjectiveConstraint name="hold" indices="0"/><TestMean name="mean" input="@/dofs" output="@/c/dofs"/></Node>)")),
                 "/c/hold constrains nodes of /c/dofs, whose positions are mapped from /dofs by /c/mean");
}

TEST(SystemErrors, MassIsRequiredWhereNodesCanMove) {
  const auto compiled = [](const std::string& content) {
    return std::make_unique<Simulation>(sceneFromText(
        "<Node name='root'><TestIntegrator/><MechanicalObject name='dofs' position='0 0 0 1 0 0 2 0 0'/>" + content +
        "</Node>"));
  };
  const auto problem = [&](const std::string& content) -> std::string {
    const auto simulation = compiled(content);
    try {
      simulation->systems()[0]->constraints().inverseLumpedMass();
    } catch (const ComponentError& error) {
      return error.what();
    }
    return {};
  };
  expectContains(problem(""), "/dofs has no mass");
  expectContains(problem("<UniformMass totalMass='1' indices='0 2'/>"), "node 1 of /dofs has a mass of 0 kg");
  EXPECT_EQ(problem("<UniformMass totalMass='1' indices='0 2'/><FixedProjectiveConstraint indices='1'/>"), "");
  expectContains(
      problem("<UniformMass totalMass='1' indices='0 2'/><FixedProjectiveConstraint indices='1' endTime='5'/>"),
      "node 1 of /dofs");
  const auto simulation = compiled(
      "<UniformMass totalMass='6'/><FixedProjectiveConstraint indices='1'/>"
      "<FixedProjectiveConstraint indices='0' endTime='5'/>");
  EXPECT_EQ(simulation->systems()[0]->constraints().inverseLumpedMass(), (std::vector<double>{0.5, 0, 0.5}));
}

TEST(SystemReports, TheFirstNumberThatIsNotFinite) {
  Simulation simulation(sceneFromText(two_bodies));
  System& system = *simulation.systems()[0];
  EXPECT_EQ(FaultWatch(system).firstFault(system.x), "");
  system.v[3][2] = std::numeric_limits<double>::infinity();
  expectContains(FaultWatch(system).firstFault(system.x),
                 "node 1 of /b/dofs has a velocity that is not finite (0 0 inf)");
  system.x[4][0] = std::nan("");
  expectContains(FaultWatch(system).firstFault(system.x), "node 2 of /b/dofs has a position that is not finite");
  expectContains(FaultWatch(system).firstFault(system.x), "/b/springs acts on it, its worst element: spring 0 of 5");
}

TEST(SystemReports, MappedNodesThatNothingActsOnAreLookedAtWhenTheyHaveBeenPlaced) {
  std::string scene = two_bodies;
  scene.replace(scene.find("<TestMean "), 10, "<TestMean bend='1e307' ");
  Simulation simulation(sceneFromText(scene));
  System& system = *simulation.systems()[0];
  FaultWatch watch(system);
  EXPECT_EQ(watch.firstFault(system.x), "");
  system.x[7][1] = std::nan("");
  EXPECT_EQ(watch.firstFault(system.x), "") << "left behind, and not read";
  Vector before(system.x.count());
  copy(system.x, before);
  for (Index row = 2; row < 6; ++row) system.x[row].y() = 100;  // and what follows it is beyond all numbers
  simulation.complete();
  for (int again = 0; again < 2; ++again)
    expectContains(watch.firstFault(before), "node 0 of /mapped/dofs has a position that is not finite (inf 100 ");
  const std::vector<std::string> doubts = doubtsOf(simulation);  // of a run that ends here
  ASSERT_EQ(doubts.size(), 1u);
  expectContains(doubts[0], "at t = 0: node 0 of /mapped/dofs has a position that is not finite");
}

TEST(SystemReports, ThePlan) {
  Simulation simulation(sceneFromText(two_bodies));
  std::string text;
  for (const std::string& plan : planOf(*simulation.systems()[0]).lines()) text += plan + "\n";
  expectContains(text, "9 nodes in one vector, 6 of them independent");
  expectContains(text, "computed once");
  expectContains(text, "/b/springs");
  expectContains(text, "mapping /mapped/mean");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
