// SPDX-License-Identifier: LGPL-2.1-or-later
// Mappings whose children are weighted sums of their parents' nodes.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/quadratic_block.h"
#include "tests/support/scene_fixture.h"
#include "tools/plan/plan.h"

namespace stroma::test {
namespace {

/// A body of 3 x 2 x 4 cells, cut or not; `points` follow it by `mapping`, and `more` acts on them.
struct Scene {
  std::string cells = "tetrahedra", points = "0.01 0.02 0.03", mapping = "<BarycentricMapping name=\"mapping\"/>",
              more = {};
  std::string integrator = "<EulerImplicitSolver name=\"integrator\"/><SparseLDLSolver/>", body = {};
  std::string grid = "<RegularGridTopology name=\"grid\" n=\"4 3 5\" min=\"0 0 0\" max=\"0.09 0.06 0.12\"/>";
  std::string text() const {
    const bool cut = cells == "tetrahedra";
    return "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 -9.81\">" + integrator + "<Node name=\"source\">" + grid +
           "</Node><Node name=\"body\">" +
           (cut ? "<TetrahedronSetTopologyContainer name=\"cells\"/><Hexa2TetraTopologicalMapping "
                  "input=\"@../source/grid\" "
                  "output=\"@cells\"/>"
                : "<HexahedronSetTopologyContainer name=\"cells\" src=\"@../source/grid\"/>") +
           "<MechanicalObject name=\"dofs\"/><UniformMass totalMass=\"0.6\"/><" + (cut ? "Tetra" : "Hexa") +
           "hedronFEMForceField name=\"fem\" method=\"small\" youngModulus=\"5000\" poissonRatio=\"0.3\"/>"
           "<FixedProjectiveConstraint indices=\"0 1 2 3 4 5 6 7 8 9 10 11\"/>" +
           body + "<Node name=\"child\"><MechanicalObject name=\"points\" position=\"" + points + "\"/>" + mapping +
           more + "</Node></Node></Node>";
  }
};

std::string list(const std::vector<Vec3>& points) {
  std::string text;
  for (const Vec3& p : points) text += fmt::format("{} {} {}  ", p.x(), p.y(), p.z());
  return text;
}
std::vector<Vec3> scattered(int count, double margin) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> x(-margin, 0.09 + margin), y(-margin, 0.06 + margin),
      z(-margin, 0.12 + margin);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) points.emplace_back(x(random), y(random), z(random));
  return points;
}
/// Nodes of the grid that do not lie in planes.
const std::string distorted =
    "<MeshTopology name=\"grid\" position=\"0 0 0  0.05 0 0.01  0.06 0.06 0  0 0.05 -0.01  0.01 -0.01 0.08  0.06 0 "
    "0.07  "
    "0.07 0.06 0.1  -0.01 0.06 0.08\" hexahedra=\"0 1 2 3 4 5 6 7\"/>";

State& stateOf(const Simulation& simulation, const std::string& path) {
  for (State* state : simulation.states())
    if (state->path() == path) return *state;
  throw std::runtime_error("no state " + path);
}
const Mapping& mappingOf(const Simulation& simulation) {
  const System& system = *simulation.systems().at(0);
  return system.actors().mappings.empty() ? *system.actors().passive_mappings.at(0) : *system.actors().mappings.at(0);
}

/// J v, its blocks and J^T f of one mapping fit together.
void expectConsistent(const std::string& text) {
  Simulation simulation = simulationFromText(text);
  System& system = *simulation.systems().at(0);
  const Mapping& mapping = mappingOf(simulation);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const State &parent = mapping.input(), &child = mapping.output();
  Vector v(system.allRows()), by_blocks(system.allRows()), f(system.allRows());
  for (Index i = 0; i < parent.size(); ++i) v[parent.firstRow() + i] = Vec3(uniform(random), uniform(random), 1);
  mapping.applyJ(v);
  std::vector<JacobianBlock> blocks;
  mapping.addJacobian(blocks);
  for (const JacobianBlock& block : blocks) by_blocks[block.child] += block.block * v[block.parent];
  double power = 0;
  for (Index i = 0; i < child.size(); ++i) {
    EXPECT_LT((v[child.firstRow() + i] - by_blocks[child.firstRow() + i]).norm(), 1e-13);
    f[child.firstRow() + i] = Vec3(uniform(random), uniform(random), uniform(random));
    power += f[child.firstRow() + i].dot(v[child.firstRow() + i]);
  }
  mapping.applyJT(f);
  double pulled = 0;
  for (Index i = 0; i < parent.size(); ++i) pulled += f[parent.firstRow() + i].dot(v[parent.firstRow() + i]);
  EXPECT_NEAR(pulled, power, 1e-12 * std::abs(power) + 1e-13);
}

TEST(Mappings, ForcesAreTheTransposeOfVelocities) {
  for (const char* cells : {"tetrahedra", "hexahedra"})
    expectConsistent(Scene{.cells = cells, .points = list(scattered(40, 0.01))}.text());
  expectConsistent(Scene{.points = "0 0 0.12  0.03 0 0.12", .mapping = "<SubsetMapping/>"}.text());
  expectConsistent(Scene{.points = list(scattered(60, 0)), .mapping = "<IdentityMapping/>"}.text());
}

/// Points inside, on nodes, in faces, and outside.
TEST(Mappings, AffineMapsOfTheBodyMoveEmbeddedPointsExactly) {
  std::vector<Vec3> points = scattered(200, 0.02);
  points.insert(points.end(), {Vec3(0, 0, 0), Vec3(0.03, 0.03, 0.03), Vec3(0.09, 0.06, 0.12), Vec3(0.045, 0, 0.06)});
  Mat3 map;
  map << 1.3, 0.2, -0.4, 0.1, 0.8, 0.3, -0.2, 0.5, 1.1;
  for (const bool is_distorted : {false, true})
    for (const char* cells : {"tetrahedra", "hexahedra"}) {
      Scene scene{.cells = cells, .points = list(points)};
      if (is_distorted) {
        if (scene.cells == "tetrahedra") continue;
        scene.grid = distorted;
        scene.body = "";
      }
      std::string text = scene.text();
      if (is_distorted) {  // it has eight nodes
        const std::string held = "0 1 2 3 4 5 6 7 8 9 10 11";
        text.replace(text.find(held), held.size(), "0");
      }
      Simulation simulation = simulationFromText(text);
      System& system = *simulation.systems().at(0);
      const State &body = stateOf(simulation, "/body/dofs"), &child = stateOf(simulation, "/body/child/points");
      for (Index i = 0; i < child.size(); ++i)
        EXPECT_LT((child.x()[i] - points[i]).norm(), 1e-15) << cells << " where it starts";
      for (Index i = 0; i < body.size(); ++i) body.x()[i] = map * body.rest_position[i] + Vec3(1, 2, 3);
      system.applyMappings();
      for (Index i = 0; i < child.size(); ++i)
        EXPECT_LT((child.x()[i] - (map * points[i] + Vec3(1, 2, 3))).norm(), 1e-13) << cells << i;
    }
}

TEST(Mappings, APointFollowsTheCellThatHoldsIt) {
  Simulation simulation = simulationFromText(Scene{.points = list(scattered(100, 0))}.text());
  std::vector<JacobianBlock> blocks;
  mappingOf(simulation).addJacobian(blocks);
  ASSERT_EQ(blocks.size(), 400u);
  for (std::size_t k = 0; k < blocks.size(); k += 4) {
    double sum = 0;
    for (std::size_t a = k; a < k + 4; ++a) {
      EXPECT_EQ(blocks[a].child, blocks[k].child);
      EXPECT_GE(blocks[a].block(0, 0), -1e-12);
      sum += blocks[a].block(0, 0);
    }
    EXPECT_NEAR(sum, 1, 1e-14);
  }
}

/// Trilinear displacements of a box are those of hexahedra, whose points are then exact.
TEST(Mappings, HexahedraAreTrilinear) {
  const std::vector<Vec3> points = scattered(50, 0);
  Simulation simulation = simulationFromText(Scene{.cells = "hexahedra", .points = list(points)}.text());
  const State &body = stateOf(simulation, "/body/dofs"), &child = stateOf(simulation, "/body/child/points");
  const auto moved = [](const Vec3& p) {
    return Vec3(p + Vec3(p.y() * p.z(), p.x() * p.z(), 3 * p.x() * p.y() * p.z()));
  };
  for (Index i = 0; i < body.size(); ++i) body.x()[i] = moved(body.rest_position[i]);
  simulation.systems().at(0)->applyMappings();
  for (Index i = 0; i < child.size(); ++i) EXPECT_LT((child.x()[i] - moved(points[i])).norm(), 1e-14) << i;
}

/// A force on an embedded point is a force on the corners of its cell, in every solver's matrix too.
/// Points in cells with straight edges follow a quadratic map of the body exactly; those in curved cells every affine one.
TEST(Mappings, QuadraticTetrahedraAreQuadratic) {
  QuadraticBlock block =
      QuadraticBlock::box({2, 2, 2}, [](const Vec3& p) { return Vec3(0.09 * p.x(), 0.06 * p.y(), 0.12 * p.z()); });
  const auto quadratic = [](const Vec3& p) {
    return Vec3(p.x() + 3 * p.y() * p.z(), p.y() - 2 * p.x() * p.x(), p.z() + p.x() * p.y() + 4 * p.z() * p.z());
  };
  Mat3 map;
  map << 1.3, 0.2, -0.4, 0.1, 0.8, 0.3, -0.2, 0.5, 1.1;
  const auto affine = [&map](const Vec3& p) { return Vec3(map * p + Vec3(1, 2, 3)); };
  for (const bool curved : {false, true}) {
    if (curved) block.crumple(0.003);
    std::vector<Vec3> points = scattered(100, 0);
    for (const QuadraticTetrahedron& cell : block.cells) points.push_back(block.position[std::size_t(cell[7])]);
    Simulation simulation = simulationFromText(
        "<Node name=\"root\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/>" + block.topology() +
        "<MechanicalObject name=\"dofs\"/><UniformMass totalMass=\"1\"/><Node name=\"child\"><MechanicalObject "
        "name=\"points\" position=\"" +
        list(points) + "\"/><BarycentricMapping/></Node></Node>");
    System& system = *simulation.systems().at(0);
    const Mapping& mapping = mappingOf(simulation);
    const State& child = mapping.output();
    const auto expectMoved = [&](const auto& by) {
      for (std::size_t n = 0; n < block.position.size(); ++n) system.x[Index(n)] = by(block.position[n]);
      mapping.apply(system.x);
      for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_LT((Vec3(system.x[child.firstRow() + Index(i)]) - by(points[i])).norm(), 1e-12) << i;
    };
    expectMoved(affine);
    if (!curved) expectMoved(quadratic);
  }
}

TEST(Mappings, AForceOnAPointIsAForceOnItsCell) {
  const auto after = [](const Scene& scene) {
    Simulation simulation = simulationFromText(scene.text());
    for (int step = 0; step < 20; ++step) EXPECT_FALSE(simulation.step().diverged);
    std::vector<Vec3> out;
    const State& body = stateOf(simulation, "/body/dofs");
    for (Index i = 0; i < body.size(); ++i) out.push_back(body.x()[i]);
    return out;
  };
  // the middle of the first box, whose corners are nodes 36 37 41 40 48 49 53 52 of the last layer but one
  const std::string force = "totalForce=\"0.3 0.2 0.1\"/>", corners = "36 37 41 40 48 49 53 52";
  for (const std::string solver : {"<SparseLDLSolver/>", "<CGLinearSolver iterations=\"500\" tolerance=\"1e-14\"/>"}) {
    Scene by_point{.cells = "hexahedra", .points = "0.015 0.015 0.105"}, by_nodes = by_point;
    by_point.integrator = by_nodes.integrator = "<EulerImplicitSolver/>" + solver;
    by_point.more = "<ConstantForceField indices=\"0\" " + force;
    by_nodes.body = "<ConstantForceField indices=\"" + corners + "\" " + force;
    const std::vector<Vec3> a = after(by_point), b = after(by_nodes);
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LT((a[i] - b[i]).norm(), 1e-10) << solver << i;
  }
}

bool explains(const Simulation& simulation, const std::string& words) {
  for (const std::string& line : planOf(simulation).lines())
    if (line.find(words) != std::string::npos) return true;
  return false;
}

TEST(Mappings, PointsOnWhichNothingActsCostNothingInAStep) {
  const std::vector<Vec3> points = scattered(30, 0);
  Scene scene{.points = list(points)};
  Simulation passive = simulationFromText(scene.text());
  EXPECT_TRUE(explains(passive, "mapping /body/child/mapping: only after steps in which it is read; nothing acts on its nodes"));
  EXPECT_TRUE(passive.systems().at(0)->actors().mappings.empty());
  scene.more = "<ConstantForceField indices=\"3\" totalForce=\"0 0 0.1\"/>";
  Simulation acting = simulationFromText(scene.text());
  EXPECT_TRUE(explains(acting, "mapping /body/child/mapping: each evaluation"));
  for (Simulation* simulation : {&passive, &acting}) {
    for (int step = 0; step < 5; ++step) EXPECT_FALSE(simulation->step().diverged);
    std::vector<JacobianBlock> blocks;
    mappingOf(*simulation).addJacobian(blocks);
    const System& system = *simulation->systems().at(0);
    Vector expected(system.allRows()), speed(system.allRows());
    for (const JacobianBlock& block : blocks) {
      expected[block.child] += block.block * system.x[block.parent];
      speed[block.child] += block.block * system.v[block.parent];
    }
    const State& child = stateOf(*simulation, "/body/child/points");
    for (Index i = 0; i < child.size(); ++i) {
      EXPECT_LT((child.x()[i] - expected[child.firstRow() + i]).norm(), 1e-15);
      EXPECT_LT((child.v()[i] - speed[child.firstRow() + i]).norm(), 1e-14);
      EXPECT_GT((child.x()[i] - points[i]).norm(), 0);
    }
  }
  // a child of a child: passive as long as the last one is
  scene.more =
      "<Node name=\"grandchild\"><MechanicalObject position=\"" + list(points) + "\"/><IdentityMapping/>{}</Node>";
  const std::string mass = "<UniformMass totalMass=\"0.1\"/>";
  const std::string text = scene.text();
  const auto with = [&](const std::string& what) { return std::string(text).replace(text.find("{}"), 2, what); };
  EXPECT_EQ(simulationFromText(with("")).systems().at(0)->actors().passive_mappings.size(), 2u);
  EXPECT_EQ(simulationFromText(with(mass)).systems().at(0)->actors().mappings.size(), 2u);
}

/// Condensed solvers compute what lies inside when it is asked for: points embedded there ask.
TEST(Mappings, CondensedBodiesCarryPointsThatOnlyFollow) {
  const std::vector<Vec3> points = scattered(30, 0);
  const std::pair<std::string, std::string> solvers[] = {
      {"<StaticSolver newton_iterations=\"5\" relative_residual_tolerance_threshold=\"1e-11\"/><SparseLDLSolver/>",
       "<CondensedStaticSolver/>"},
      {"<CondensedDynamicSolver condensed=\"false\"/>", "<CondensedDynamicSolver interiorMass=\"exact\"/>"}};
  for (const auto& [whole_solver, condensed_solver] : solvers) {
    Scene scene{.points = list(points)};
    scene.grid = "<RegularGridTopology name=\"grid\" n=\"5 4 6\" min=\"0 0 0\" max=\"0.09 0.06 0.12\"/>";
    scene.body = "<ConstantForceField indices=\"119\" totalForce=\"0.02 0.01 -0.01\"/>";
    scene.integrator = whole_solver;
    Simulation whole = simulationFromText(scene.text());
    scene.integrator = condensed_solver;
    Simulation condensed = simulationFromText(scene.text());
    condensed.computeOnDemand(true);
    for (int step = 0; step < 7; ++step) {
      EXPECT_FALSE(whole.step().diverged);
      EXPECT_FALSE(condensed.step().diverged);
    }
    condensed.complete();
    const State &a = stateOf(whole, "/body/child/points"), &b = stateOf(condensed, "/body/child/points");
    double moved = 0;
    for (Index i = 0; i < a.size(); ++i) {
      EXPECT_LT((a.x()[i] - b.x()[i]).norm(), 1e-10) << condensed_solver << i;
      EXPECT_LT((a.v()[i] - b.v()[i]).norm(), 1e-8) << condensed_solver << i;
      moved = std::max(moved, (a.x()[i] - points[i]).norm());
    }
    EXPECT_GT(moved, 1e-5) << condensed_solver;
    scene.more = "<ConstantForceField indices=\"3\" totalForce=\"0 0 0.1\"/>";
    EXPECT_NE(problemsOf(scene.text()).find("takes no forces through mappings"), std::string::npos);
  }
}

TEST(Mappings, SubsetsAreListedRangedOrNearest) {
  const auto parents = [](const std::string& attributes, const std::string& points) {
    Simulation simulation =
        simulationFromText(Scene{.points = points, .mapping = "<SubsetMapping " + attributes + "/>"}.text());
    std::vector<JacobianBlock> blocks;
    mappingOf(simulation).addJacobian(blocks);
    std::vector<Index> rows;
    for (const JacobianBlock& block : blocks) rows.push_back(block.parent);
    return rows;
  };
  using Rows = std::vector<Index>;
  EXPECT_EQ(parents("indices=\"7 3\"", "0 0 0 0 0 0"), (Rows{7, 3}));
  EXPECT_EQ(parents("first=\"5\" last=\"7\"", "0 0 0 0 0 0 0 0 0"), (Rows{5, 6, 7}));
  EXPECT_EQ(parents("", "0.03 0 0  0.09 0.06 0.12"), (Rows{1, 59}));
}

/// Hyperelastic products cost more than those of a matrix. Many of them pay for its assembly where points are embedded, too.
TEST(Mappings, ManyProductsPayForAMatrix) {
  const Scene scene{.points = list(scattered(20, 0)),
                    .more = "<UniformMass name=\"mass\" totalMass=\"0.1\"/>",
                    .body = "<TetrahedronHyperelasticityFEMForceField name=\"law\" materialName=\"StableNeoHookean\" "
                            "youngModulus=\"5000\" poissonRatio=\"0.4\"/>"};
  Simulation simulation = simulationFromText(scene.text());
  simulation.step();
  const SystemMatrix& matrix = simulation.systems()[0]->matrix();
  EXPECT_FALSE(matrix.prefersAssembled(2));
  EXPECT_TRUE(matrix.prefersAssembled(1000));
}

TEST(Mappings, SaysWhatIsWrong) {
  const auto says = [](const Scene& scene, const std::string& sentence) {
    const std::string problems = problemsOf(scene.text());
    EXPECT_NE(problems.find(sentence), std::string::npos) << sentence << " in: " << problems;
  };
  says({.mapping = "<IdentityMapping/>"}, "/body/child/points has 1 nodes and /body/dofs has 60");
  says({.mapping = "<SubsetMapping/>"}, "node 0 of /body/child/points is");
  says({.mapping = "<SubsetMapping/>"}, "ignoreNotFound");
  says({.mapping = "<SubsetMapping first=\"3\" last=\"60\"/>"}, "the range 3 to 60 of the 60 nodes");
  says({.mapping = "<SubsetMapping first=\"3\"/>"}, "one end of the range is missing");
  says({.mapping = "<SubsetMapping indices=\"3 4\"/>"}, "has 1 nodes, and 2 are to be followed");
  says({.mapping = "<SubsetMapping indices=\"3\" first=\"3\" last=\"3\"/>"}, "indices and a range are both given");
  says({.mapping = "<BarycentricMapping input=\"@points\" output=\"@points\"/>"}, "cannot follow itself");
  says({.mapping = "<BarycentricMapping mapForces=\"false\"/>",
        .more = "<ConstantForceField indices=\"0\" totalForce=\"0 0 1\"/>"},
       "mapForces is false");
  says({.mapping = "<BarycentricMapping mapMasses=\"false\"/>", .more = "<UniformMass totalMass=\"1\"/>"},
       "mapMasses is false");
  says({.more = "<FixedProjectiveConstraint indices=\"0\"/>"}, "whose positions are mapped from /body/dofs");
  // far outside: a warning, not an error
  const Simulation far = simulationFromText(Scene{.points = "0.01 0.01 0.01  0.5 0 0"}.text());
  ASSERT_EQ(far.scene().diagnostics.problems().size(), 1u);
  EXPECT_NE(
      far.scene().diagnostics.problems()[0].text().find("1 of 2 points lie outside of the cells, point 1 by 0.41"),
      std::string::npos)
      << far.scene().diagnostics.problems()[0].text();
}

}  // namespace
}  // namespace stroma::test
