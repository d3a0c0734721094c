// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "framework/mechanics/drawn_segments.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace {

/// Nodes on the x axis under one spring field, no gravity.
std::string row(const std::string& positions, const std::string& springs, double dt = 1e-3,
                const std::string& integrator = "<EulerExplicitSolver/>", const std::string& more = "") {
  return fmt::format(R"(<Node name="root" dt="{}" gravity="0 0 0">{}<CGLinearSolver iterations="100" tolerance="1e-12"/>
    <MechanicalObject name="dofs" position="{}"/><UniformMass vertexMass="2"/>{}{}</Node>)",
                     dt, integrator, positions, springs, more);
}

/// Two masses m on a spring k swing with w = sqrt(2 k / m); symplectic Euler with step h has 2/h asin(w h / 2).
TEST(SpringForceField, TwoMassesSwingWithTheirPeriod) {
  const double h = 1e-3, w = std::sqrt(2 * 100. / 2), period = std::numbers::pi * h / std::asin(w * h / 2);
  Simulation simulation = simulationFromText(
      row("0 0 0 1.1 0 0", "<SpringForceField springsIndices1='0' springsIndices2='1' lengths='1' damping='0'/>"));
  const State& state = *simulation.states().at(0);
  int crossings = 0;
  double last = 0, first = 0, before = 0.1;
  for (int i = 1; i <= 20000; ++i) {
    simulation.step();
    const double stretch = state.x()[1].x() - state.x()[0].x() - 1;
    if (before > 0 && stretch <= 0) {
      const double t = h * (i - 1 + before / (before - stretch));
      (crossings++ == 0 ? first : last) = t;
    }
    before = stretch;
  }
  ASSERT_GT(crossings, 20);
  EXPECT_NEAR((last - first) / (crossings - 1), period, 1e-6 * period);
  EXPECT_NEAR(state.x()[0].x() + state.x()[1].x(), 1.1, 1e-12);
}

/// Linear damping of the elongation: the amplitude decays with exp(-c t / m) for two equal masses.
TEST(SpringForceField, DampingDecaysAsItsClosedForm) {
  const double h = 1e-4, k = 100, m = 2, c = 1;
  Simulation simulation = simulationFromText(
      row("0 0 0 1.1 0 0", "<SpringForceField springsIndices1='0' springsIndices2='1' lengths='1' damping='1'/>", h));
  const State& state = *simulation.states().at(0);
  for (int i = 0; i < 10000; ++i) simulation.step();
  const double t = simulation.time(), decay = c / m, w = std::sqrt(2 * k / m - decay * decay);
  const double exact = 0.1 * std::exp(-decay * t) * (std::cos(w * t) + decay / w * std::sin(w * t));
  EXPECT_NEAR(state.x()[1].x() - state.x()[0].x() - 1, exact, 0.1 * w * h) << "first order";
}

/// The same damped spring implicitly: one backward Euler step is the solution of a 1-dof equation.
TEST(SpringForceField, ImplicitStepTakesTheDampingIntoItsMatrix) {
  const double h = 0.05, k = 100, m = 2, c = 40;
  Simulation simulation = simulationFromText(
      row("0 0 0 1.1 0 0", "<SpringForceField springsIndices1='0' springsIndices2='1' lengths='1' damping='40'/>", h,
          "<EulerImplicitSolver/>"));
  const State& state = *simulation.states().at(0);
  double stretch = 0.1, speed = 0;
  for (int i = 0; i < 20; ++i) {
    speed = (speed - h * 2 * k / m * stretch) / (1 + 2 * c * h / m + 2 * k * h * h / m);
    stretch += h * speed;
    simulation.step();
    EXPECT_NEAR(state.x()[1].x() - state.x()[0].x() - 1, stretch, 1e-11);
  }
}

Vector forcesOf(Simulation& simulation) {
  System& system = *simulation.systems().at(0);
  Vector f(system.allRows());
  system.computeForce(system.x, system.v, f);
  return f;
}

TEST(SpringForceField, EndsThatMeetMakeNoNumberThatIsNotOne) {
  for (const char* length : {"0", "1"})
    for (const char* distance : {"0", "1e-320", "1e-200"}) {
      Simulation simulation = simulationFromText(
          row(fmt::format("0 0 0 {} 0 0", distance),
              fmt::format("<SpringForceField springsIndices1='0' springsIndices2='1' lengths='{}'/>", length), 0.01,
              "<EulerImplicitSolver/>"));
      const Vector f = forcesOf(simulation);
      EXPECT_TRUE(std::isfinite(dot(f, f)));
      for (int i = 0; i < 5; ++i) ASSERT_FALSE(simulation.step().diverged) << length << " " << distance;
    }
  // ends that cross: thrown at each other through the centre
  Simulation simulation = simulationFromText(
      row("0 0 0 1 0 0", "<SpringForceField springsIndices1='0' springsIndices2='1' lengths='1' stiffness='10'/>", 0.01,
          "<EulerImplicitSolver newtonIterations='10'/>"));
  simulation.systems().at(0)->v[0] = Vec3(30, 0, 0);
  for (int i = 0; i < 300; ++i) ASSERT_FALSE(simulation.step().diverged);
}

TEST(SpringForceField, ListsAndSwitches) {
  const std::string all = "<SpringForceField spring='0 1 100 0 0.5  1 2 50 0 3'/>";
  const std::string lists =
      "<SpringForceField springsIndices1='0 1' springsIndices2='1 2' lengths='0.5 3' stiffness='100 50' damping='0'/>";
  Simulation a = simulationFromText(row("0 0 0 1 0 0 3 0 0", all));
  Simulation b = simulationFromText(row("0 0 0 1 0 0 3 0 0", lists));
  const Vector fa = forcesOf(a), fb = forcesOf(b);
  EXPECT_EQ(Vec3(fa[0]), Vec3(50, 0, 0));
  EXPECT_EQ(Vec3(fa[1]), Vec3(-100, 0, 0));
  EXPECT_EQ(Vec3(fa[2]), Vec3(50, 0, 0));
  for (Index i = 0; i < 3; ++i) EXPECT_EQ(Vec3(fa[i]), Vec3(fb[i]));
}

TEST(SpringForceField, ElongationOnlyAndEnabled) {
  const auto forces = [](const std::string& attributes) {
    Simulation s = simulationFromText(
        row("0 0 0 1 0 0 3 0 0", "<SpringForceField spring='0 1 100 0 0.5  1 2 50 0 3' " + attributes + "/>"));
    const double energy = s.systems().at(0)->elasticEnergy(s.systems().at(0)->x);
    const Vector f = forcesOf(s);
    return std::pair(Vec3(f[2]), energy);
  };
  EXPECT_EQ(forces("elongationOnly='1'").first, Vec3::Zero());
  EXPECT_DOUBLE_EQ(forces("elongationOnly='1'").second, 12.5);
  EXPECT_EQ(forces("enabled='1 0'").first, Vec3::Zero());
  EXPECT_DOUBLE_EQ(forces("").second, 12.5 + 25);
}

TEST(SpringForceField, SaysWhatIsWrong) {
  const auto problems = [](const std::string& attributes) {
    return problemsOf(row("0 0 0 1 0 0 3 0 0", "<SpringForceField " + attributes + "/>"));
  };
  expectContains(problems(""), "there is no spring");
  expectContains(problems("spring='0 1 2 3'"), "five per spring");
  expectContains(problems("spring='0 7 1 1 1'"), "/dofs has 3 nodes");
  expectContains(problems("spring='0 0.5 1 1 1'"), "an index in 0 ... 2");
  expectContains(problems("spring='1 1 1 1 1'"), "joins node 1 to itself");
  expectContains(problems("spring='0 1 -1 1 1'"), "stiffness of -1");
  expectContains(problems("spring='0 1 1 1 1' stiffness='3'"), "both given");
  expectContains(problems("indices1='0 1' indices2='1' lengths='1'"), "2 nodes and springsIndices2 1");
  expectContains(problems("indices1='0 1' indices2='1 2' lengths='1 2 3'"), "lengths has 3 values for 2 springs");
  expectContains(sceneFromText(row("0 0 0 1 0 0", "<SpringForceField indices1='0' indices2='1'/>")).diagnostics.text(),
                 "no lengths");
}

/// A spring between two bodies, by links; its derivatives couple their rows.
TEST(SpringForceField, JoinsTwoBodies) {
  const std::string text = R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver/>
    <CGLinearSolver iterations="100" tolerance="1e-12"/>
    <Node name="a"><MechanicalObject name="dofs" position="0 0 0"/><UniformMass totalMass="2"/></Node>
    <Node name="b"><MechanicalObject name="dofs" position="9 9 9 1.1 0 0"/><UniformMass totalMass="4"/></Node>
    <SpringForceField object1="@a/dofs" object2="@b" springsIndices1="0" springsIndices2="1" lengths="1" damping="0"/>
    </Node>)";
  Simulation simulation = simulationFromText(text);
  ASSERT_EQ(simulation.states().size(), 2u);
  System& system = *simulation.systems().at(0);
  double stretch = 0.1, speed = 0;
  const double h = 0.01, k = 100;
  for (int i = 0; i < 50; ++i) {
    speed = (speed - h * k * stretch) / (1 + k * h * h);  // both masses 2 kg: w^2 = k
    stretch += h * speed;
    ASSERT_FALSE(simulation.step().diverged);
    EXPECT_NEAR(system.x[2].x() - system.x[0].x() - 1, stretch, 1e-11);
  }
  EXPECT_EQ(Vec3(system.x[1]), Vec3(9, 9, 9));
  EXPECT_NE(system.matrix().assemble().slot(0, 2), -1);
}

std::string grid(const std::string& springs) {
  return R"(<Node name="root" gravity="0 0 0"><EulerExplicitSolver/><RegularGridTopology n="3 2 2" min="0 0 0" max="2 1 1"/>
    <MechanicalObject name="dofs"/><UniformMass totalMass="1"/>)" +
         springs + "</Node>";
}

/// Stretched by e along x, a spring with direction n and length L stores k/2 (L sqrt(1 + (2e + e^2) nx^2) - L)^2.
double stretchedEnergy(const std::string& springs) {
  Simulation simulation = simulationFromText(grid(springs));
  System& system = *simulation.systems().at(0);
  EXPECT_EQ(system.elasticEnergy(system.x), 0);
  for (Index i = 0; i < system.x.count(); ++i) system.x[i].x() *= 1.5;
  return system.elasticEnergy(system.x);
}
double one(double dx, double across) {
  return 0.5 * std::pow(std::hypot(1.5 * dx, across) - std::hypot(dx, across), 2);
}

TEST(MeshSpringForceField, CountsEachPairOnce) {
  // 2 cells: 8 edges along x; of 11 faces 8 hold x, with 2 diagonals each; 4 space diagonals per cell
  const double lines = 8 * one(1, 0), quads = 16 * one(1, 1), cubes = 8 * one(1, std::sqrt(2.));
  EXPECT_NEAR(stretchedEnergy("<MeshSpringForceField linesStiffness='1'/>"), lines, 1e-14);
  EXPECT_NEAR(stretchedEnergy("<MeshSpringForceField quadsStiffness='1'/>"), lines + quads, 1e-14);
  EXPECT_NEAR(stretchedEnergy("<MeshSpringForceField cubesStiffness='1'/>"), lines + quads + cubes, 1e-14);
  EXPECT_NEAR(stretchedEnergy("<MeshSpringForceField stiffness='1'/>"), lines + quads + cubes, 1e-14);
  EXPECT_NEAR(stretchedEnergy("<MeshSpringForceField linesStiffness='3' quadsStiffness='1'/>"), 3 * lines + quads,
              1e-13);
  EXPECT_NEAR(stretchedEnergy("<MeshSpringForceField stiffness='1' localRange='0 1'/>"), one(1, 0), 1e-15);
  const std::string off = "linesDamping='0' quadsDamping='0' cubesDamping='0' ";
  EXPECT_NEAR(stretchedEnergy("<RegularGridSpringForceField linesStiffness='2' quadsStiffness='3' cubesStiffness='5' " +
                              off + "/>"),
              2 * lines + 3 * quads + 5 * cubes, 1e-13);
  EXPECT_NEAR(stretchedEnergy("<RegularGridSpringForceField linesStiffness='0' quadsStiffness='0' cubesStiffness='1' " +
                              off + "/>"),
              cubes, 1e-14);
}

TEST(MeshSpringForceField, NoCompression) {
  Simulation simulation = simulationFromText(grid("<MeshSpringForceField linesStiffness='1' noCompression='1'/>"));
  System& system = *simulation.systems().at(0);
  for (Index i = 0; i < system.x.count(); ++i) system.x[i].x() *= 0.5;
  EXPECT_EQ(system.elasticEnergy(system.x), 0);
}

TEST(MeshSpringForceField, SaysWhatIsWrong) {
  expectContains(problemsOf(grid("<MeshSpringForceField/>")), "there is no spring");
  expectContains(problemsOf(grid("<MeshSpringForceField tetrasStiffness='1'/>")), "there is no spring");
  expectContains(problemsOf(row("0 0 0 1 0 0", "<MeshSpringForceField stiffness='1'/>")), "no mesh gives the springs");
}

TEST(RestShapeSprings, PullsToTheRestShapeAndToAnotherBody) {
  Simulation own = simulationFromText(
      row("0 0 0 1 0 0", "<RestShapeSpringsForceField points='1' stiffness='8' activeDirections='1 0 1'/>"));
  System& system = *own.systems().at(0);
  system.x[1] = Vec3(1.5, 2, 0.25);
  const Vector f = forcesOf(own);
  EXPECT_EQ(Vec3(f[0]), Vec3::Zero());
  EXPECT_EQ(Vec3(f[1]), Vec3(-4, 0, -2));
  EXPECT_DOUBLE_EQ(system.elasticEnergy(system.x), 4 * (0.25 + 0.0625));

  Simulation other = simulationFromText(row(
      "0 0 0 1 0 0",
      "<RestShapeSpringsForceField points='1' external_rest_shape='@marks/dofs' external_points='0' stiffness='8'/>",
      0.01, "<EulerExplicitSolver/>",
      "<Node name='marks'><MechanicalObject name='dofs' position='4 0 0' velocity='1 0 0'/><UniformMass "
      "totalMass='1'/></Node>"));
  expectContains(other.scene().diagnostics.text(), "there is no reaction on /marks/dofs");
  EXPECT_EQ(own.scene().diagnostics.text().find("there is no reaction on"), std::string::npos) << "there is no other body";
  System& both = *other.systems().at(0);
  other.step();
  EXPECT_NEAR(both.v[1].x(), 0.01 * 8 * 3 / 2, 1e-14) << "m = 2 kg, 3 m away";
  EXPECT_EQ(both.v[2].x(), 1) << "the other body feels nothing";
  const double x = both.x[1].x(), v = both.v[1].x(), target = both.x[2].x();
  EXPECT_NEAR(target, 4.01, 1e-14);
  other.step();
  EXPECT_NEAR(both.v[1].x(), v + 0.01 * 8 * (target - x) / 2, 1e-13) << "the target has moved";
}

TEST(RestShapeSprings, PullsToTargetsThatMove) {
  Simulation led = simulationFromText(row("0 0 0 1 0 0", "<RestShapeSpringsForceField name='lead' points='1' stiffness='8'/>",
                                          0.01, "<EulerExplicitSolver/>"));
  System& system = *led.systems().at(0);
  led.step();
  EXPECT_EQ(system.v[1].norm(), 0) << "it rests";
  led.setAttribute("/lead", "targets", "1 0 3");
  led.step();
  EXPECT_NEAR(system.v[1].z(), 0.01 * 8 * 3 / 2, 1e-14) << "m = 2 kg, 3 m away";
  EXPECT_THROW(led.setAttribute("/lead", "targets", "1 0"), ComponentError) << "a number is missing";
  led.setAttribute("/lead", "targets", "");
  const double v = system.v[1].z(), x = system.x[1].z();
  led.step();
  EXPECT_NEAR(system.v[1].z(), v - 0.01 * 8 * x / 2, 1e-14) << "back to the rest shape";
}

TEST(RestShapeSprings, SaysWhatIsWrong) {
  const auto problems = [](const std::string& attributes) {
    return problemsOf(row("0 0 0 1 0 0", "<RestShapeSpringsForceField " + attributes + "/>"));
  };
  expectContains(problems("points=''"), "lists no node");
  expectContains(problems("points='0 2'"), "indices in 0 ... 1");
  expectContains(problems("points='0 1' stiffness='1 2 3'"), "3 values for 2 points");
  expectContains(problems("points='0' external_points='0'"), "external_rest_shape is not given");
  expectContains(problems("points='0' pivot_points='0'"), "pivot_points are of rigid bodies");
  expectContains(problems("points='0' targets='1 2'"), "targets has 2 numbers for 1 points");
}

/// SOFA's formula. A strip of two equilateral triangles folded by the angle a: |R| = h sin(a/2) with h their height, so
/// E = lambda/2 h^2 sin^2(a/2), and lambda = 2/3 * 2N/N^4 l^3 mu with N = l h.
TEST(FastTriangularBendingSprings, EnergyOfAFold) {
  const double l = 2, h = std::sqrt(3.), mu = 0.7, n = l * h;
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" gravity="0 0 0"><EulerExplicitSolver/><MechanicalObject position="0 0 0 2 0 0 1 {0} 0 1 -{0} 0"/>
      <MeshTopology position="0 0 0 2 0 0 1 {0} 0 1 -{0} 0" triangles="0 1 2 1 0 3"/><UniformMass totalMass="1"/>
      <FastTriangularBendingSprings bendingStiffness="0.7" method="springs"/></Node>)",
      fmt::format("{:.17g}", h)));
  System& system = *simulation.systems().at(0);
  EXPECT_NEAR(system.elasticEnergy(system.x), 0, 1e-28);
  for (double a : {0.1, 1., 2.}) {
    system.x[3] = Vec3(1, -h * std::cos(a), h * std::sin(a));
    const double r = h * std::sin(a / 2), lambda = 2. / 3 * 2 * n / std::pow(n, 4) * l * l * l * mu;
    EXPECT_NEAR(system.elasticEnergy(system.x), lambda / 2 * r * r, 1e-13);
  }
}

TEST(BendingSprings, JoinTheNodesAcrossInnerEdges) {
  const auto energy = [](const std::string& text, Index node, const Vec3& by) {
    Simulation simulation = simulationFromText(text);
    System& system = *simulation.systems().at(0);
    system.x[node] += by;
    return system.elasticEnergy(system.x);
  };
  const std::string triangles =
      R"(<Node name="root"><EulerExplicitSolver/><MechanicalObject position="0 0 0 1 0 0 0 1 0 1 1 1"/>
    <MeshTopology position="0 0 0 1 0 0 0 1 0 1 1 1" triangles="0 1 2 2 1 3"/><UniformMass totalMass="1"/>
    <TriangularBendingSprings stiffness="2" damping="0"/></Node>)";
  const Vec3 unit = Vec3(1, 1, 1).normalized();
  EXPECT_NEAR(energy(triangles, 3, 0.1 * unit), 0.01, 1e-15) << "one spring, from 0 to 3";
  EXPECT_EQ(energy(triangles, 1, unit), 0);
  const std::string quads =
      R"(<Node name="root"><EulerExplicitSolver/><RegularGridTopology n="3 2 1" min="0 0 0" max="2 1 0"/>
    <MechanicalObject/><UniformMass totalMass="1"/><QuadBendingSprings stiffness="2" damping="0"/></Node>)";
  EXPECT_NEAR(energy(quads, 2, Vec3(0.1, 0, 0)), 0.01, 1e-15) << "from 0 to 2";
  EXPECT_EQ(energy(quads, 1, Vec3(1, 2, 3)), 0) << "the middle nodes have no springs";
  EXPECT_EQ(energy(quads, 4, Vec3(1, 2, 3)), 0);
  expectContains(problemsOf(R"(<Node name="root"><EulerExplicitSolver/><MechanicalObject position="0 0 0 1 0 0 0 1 0"/>
    <MeshTopology position="0 0 0 1 0 0 0 1 0" triangles="0 1 2"/><UniformMass totalMass="1"/><TriangularBendingSprings/></Node>)"),
                 "share an edge");
}

// ---- what is drawn ----

std::vector<DrawnSegments::Segment> segmentsOf(const Simulation& simulation, const char* path) {
  std::vector<DrawnSegments::Segment> segments;
  auto* field = dynamic_cast<DrawnSegments*>(findComponent(simulation.root(), path));
  EXPECT_TRUE(field) << path;
  if (field) field->addSegments(segments);
  return segments;
}

TEST(DrawnSegments, AreTheEnabledSpringsOfOneState) {
  Simulation simulation =
      simulationFromText(row("0 0 0 1 0 0 2 0 0 3 1 0",
                             "<SpringForceField name='springs' springsIndices1='0 3 1' springsIndices2='1 2 3' "
                             "lengths='1' enabled='1 0 1'/>"));
  const State* dofs = simulation.states().at(0);
  using Segments = std::vector<DrawnSegments::Segment>;
  EXPECT_EQ(segmentsOf(simulation, "/springs"), (Segments{{dofs, 0, dofs, 1}, {dofs, 1, dofs, 3}}));
  simulation.setAttribute("/springs", "springsIndices2", "2 2 0");
  EXPECT_EQ(segmentsOf(simulation, "/springs"), (Segments{{dofs, 0, dofs, 2}, {dofs, 1, dofs, 0}}));
}

TEST(DrawnSegments, JoinNodesOfTwoStates) {
  Simulation simulation = simulationFromText(
      "<Node name='root' dt='0.01' gravity='0 0 0'><EulerExplicitSolver/><Node name='a'><MechanicalObject name='dofs' "
      "position='0 0 0 1 0 0'/><UniformMass vertexMass='1'/></Node><Node name='b'><MechanicalObject name='dofs' "
      "position='0 0 1 1 0 1 2 0 1'/><UniformMass vertexMass='1'/><RestShapeSpringsForceField name='follows' "
      "points='2 0' external_rest_shape='@../a/dofs' external_points='0 1'/><RestShapeSpringsForceField name='stays' "
      "points='1'/></Node><SpringForceField name='springs' object1='@b/dofs' object2='@a/dofs' springsIndices1='2 0' "
      "springsIndices2='1 0' lengths='1'/></Node>");
  const State *a = simulation.states().at(0), *b = simulation.states().at(1);
  ASSERT_EQ(a->path(), "/a/dofs");
  using Segments = std::vector<DrawnSegments::Segment>;
  EXPECT_EQ(segmentsOf(simulation, "/springs"), (Segments{{b, 2, a, 1}, {b, 0, a, 0}}));
  EXPECT_EQ(segmentsOf(simulation, "/b/follows"), (Segments{{b, 2, a, 0}, {b, 0, a, 1}}));
  EXPECT_EQ(segmentsOf(simulation, "/b/stays"), Segments{}) << "a place at rest is no node";
}

TEST(DrawnSegments, OfAMeshAreItsPairs) {
  Simulation simulation = simulationFromText(
      "<Node name='root' dt='0.01' gravity='0 0 0'><EulerExplicitSolver/><RegularGridTopology n='3 2 2' min='0 0 0' "
      "max='2 1 1'/><MechanicalObject/><UniformMass totalMass='1'/><RegularGridSpringForceField name='springs' "
      "linesStiffness='500' quadsStiffness='0' quadsDamping='0' cubesStiffness='0' cubesDamping='0'/></Node>");
  const auto segments = segmentsOf(simulation, "/springs");
  EXPECT_EQ(segments.size(), 20u) << "edges of two cubes that share a face";
  for (const auto& each : segments) {
    const Vec3 along = each.first->rest_position[each.first_node] - each.second->rest_position[each.second_node];
    EXPECT_NEAR(along.norm(), 1, 1e-12);
    EXPECT_EQ(each.radius, 0) << "a line";
  }
}

/// 13 springs for a node take less time in a product than is thought of other groups of nodes, and more in an assembly: a solve by
/// multigrid has no matrix for its products, and one of some hundred iterations has.
TEST(MeshSpringForceField, FewProductsDoNotPayForAMatrix) {
  Simulation simulation = simulationFromText(R"(<Node name="root" dt="0.01" gravity="0 -9.81 0"><EulerImplicitSolver/>
    <CGLinearSolver/><RegularGridTopology n="9 9 9" min="0 0 0" max="1 1 1"/><MechanicalObject/><UniformMass totalMass="1"/>
    <MeshSpringForceField hexasStiffness="200" hexasDamping="0"/></Node>)");
  simulation.step();
  SystemMatrix& matrix = simulation.systems().at(0)->matrix();
  EXPECT_FALSE(matrix.prefersAssembled(15));
  EXPECT_TRUE(matrix.prefersAssembled(200));
}

/// Of springs whose damping is in the tangent too: a product for each.
TEST(MeshSpringForceField, DampingCostsAProductOfItsOwn) {
  const auto fieldCost = [](const char* damping) {
    Simulation simulation = simulationFromText(fmt::format(R"(<Node name="root" dt="0.01" gravity="0 -9.81 0"><EulerImplicitSolver/>
      <CGLinearSolver/><RegularGridTopology n="5 5 5" min="0 0 0" max="1 1 1"/><MechanicalObject/><UniformMass totalMass="1"/>
      <MeshSpringForceField hexasStiffness="200" hexasDamping="{}"/></Node>)", damping));
    return simulation.systems().at(0)->matrix().productCost();
  };
  EXPECT_GT(fieldCost("0"), 0);
  EXPECT_DOUBLE_EQ(fieldCost("0.1"), 2 * fieldCost("0"));
}

}  // namespace
}  // namespace stroma::test
