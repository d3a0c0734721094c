// SPDX-License-Identifier: LGPL-2.1-or-later
// The same bits for one and two threads, and for two runs in one process.
#include "framework/algebra/parallel.h"
#include "framework/fem/element_loop.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace {

/// Cells along an edge of the cube: enough for the loop to use its threads.
int cellsFor(const ElasticBody& body) { return body.quadratic ? 9 : body.tetrahedra ? 19 : 20; }
TEST(Determinism, TheMeshesAreLargeEnoughForThreads) {
  for (const ElasticBody& body : elasticBodies()) {
    const Index cubes = Index(std::pow(cellsFor(body), 3));
    // at most two tetrahedra make an element of the loop
    const Index elements = body.quadratic ? 6 * cubes : body.tetrahedra ? 5 * cubes / 2 : cubes;
    EXPECT_GE(elements, parallelElements(body.quadratic ? 10 : body.tetrahedra ? 5 : 8)) << body.name;
  }
}

/// A cube of cells, of tetrahedra or hexahedra, held at its first nodes.
std::string sceneOf(const ElasticBody& body, const std::string& attributes, int cells, const std::string& solver) {
  const std::string hold = "<FixedProjectiveConstraint indices=\"0 1 2 3 4 5 6 7\"/>";
  if (body.quadratic)
    return quadraticScene(attributes, "QuadraticTetrahedronFEMForceField youngModulus=\"1e4\" poissonRatio=\"0.4\"",
                          solver, {cells, cells, cells}, hold);
  if (!body.tetrahedra)
    return hexahedraScene(attributes, body.name == "boxes", solver, {cells + 1, cells + 1, cells + 1}, hold);
  const std::string n = std::to_string(cells + 1);
  return "<Node name=\"root\" dt=\"0.01\"><RegularGridTopology name=\"grid\" n=\"" + n + " " + n + " " + n +
         "\" min=\"0 0 0\" max=\"1 1 1\"/><EulerImplicitSolver/>" + solver +
         "<Node name=\"body\"><TetrahedronSetTopologyContainer name=\"tets\"/>"
         "<Hexa2TetraTopologicalMapping input=\"@../grid\" output=\"@tets\" cutting=\"five\"/>"
         "<MechanicalObject/><DiagonalMass massDensity=\"1000\"/>"
         "<TetrahedronFEMForceField youngModulus=\"1e4\" poissonRatio=\"0.4\" " +
         attributes + "/>" + hold + "</Node></Node>";
}

/// Everything that runs over the elements, at a crumpled shape: energy, force, product, both in one pass.
struct Evaluation {
  double energy;
  std::vector<double> numbers;
  bool operator==(const Evaluation&) const = default;
};
Evaluation evaluate(FieldUnderTest& t, int thread_count) {
  setThreads(thread_count);
  Evaluation result;
  const auto append = [&](ConstRows rows) {
    result.numbers.insert(result.numbers.end(), rows.data, rows.data + rows.doubles());
  };
  append(t.force());
  append(t.product(t.direction));
  result.energy = t.field().traits().conservative ? t.field().energy(t.x) : 0;
  Vector both(t.x.count());
  t.field().addForceAndProduct(t.x, t.v_zero, t.direction, -1e-4, both);
  append(both);
  setThreads(1);
  return result;
}
TEST(Determinism, ElementsWithOneAndTwoThreads) {
  forEachElasticVariant(true, [](const ElasticBody& body, const Variant& variant) {
    FieldUnderTest t(sceneOf(body, variant.attributes, cellsFor(body), "<SparseLDLSolver/>"), body.type);
    t.deform(0.3);
    const Evaluation once = evaluate(t, 1);
    EXPECT_TRUE(once == evaluate(t, 2));
    EXPECT_TRUE(once == evaluate(t, 1));
  });
}

/// Three steps of implicit Euler.
std::uint64_t hashOfSteps(Simulation& simulation, int thread_count) {
  setThreads(thread_count);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(simulation.step().diverged);
  setThreads(1);
  return simulation.stateHash();
}
std::uint64_t hashOfSteps(const std::string& scene, int thread_count) {
  setThreads(thread_count);
  Simulation simulation = simulationFromText(scene);
  return hashOfSteps(simulation, thread_count);
}

TEST(Determinism, OneAndTwoThreadsAndTwoRuns) {
  const std::string cg = "<CGLinearSolver iterations=\"4\" tolerance=\"1e-12\"/>";
  forEachElasticVariant(false, [&](const ElasticBody& body, const Variant& variant) {
    if (variant.b_current) return;  // the test above has them
    const std::string scene = sceneOf(body, variant.attributes, cellsFor(body), cg);
    const std::uint64_t once = hashOfSteps(scene, 1);
    setThreads(2);
    Simulation again = simulationFromText(scene);
    EXPECT_EQ(once, hashOfSteps(again, 2));
    again.reset();
    EXPECT_EQ(once, hashOfSteps(again, 1));
  });
}
TEST(Determinism, StepsWithExactTangentsAndOwnMatrices) {
  const std::string cg = "<CGLinearSolver iterations=\"4\" tolerance=\"1e-12\"/>";
  const int cells = cellsFor(bodyOfTetrahedra());
  for (const char* attributes : {"method=\"svd\" tangent=\"exact\"", "method=\"polar\" assembling=\"true\""}) {
    const std::string scene = sceneOf(bodyOfTetrahedra(), attributes, cells, cg);
    EXPECT_EQ(hashOfSteps(scene, 1), hashOfSteps(scene, 2)) << attributes;
  }
}
TEST(Determinism, MatricesToo) {
  const std::string assembled =
      "<CGLinearSolver template=\"CompressedRowSparseMatrixMat3x3\" preconditioner=\"block_jacobi\" iterations=\"8\" "
      "tolerance=\"1e-12\"/>";
  for (const char* method : {"method=\"large\"", "method=\"polar\" updateStiffnessMatrix=\"true\"",
                             "method=\"polar\" assembling=\"true\""}) {
    const std::string scene = sceneOf(bodyOfTetrahedra(), method, cellsFor(bodyOfTetrahedra()), assembled);
    EXPECT_EQ(hashOfSteps(scene, 1), hashOfSteps(scene, 2)) << method;
  }
  const std::string factored = sceneOf(bodyOfTetrahedra(), "method=\"polar\"", 6, "<SparseLDLSolver/>");
  EXPECT_EQ(hashOfSteps(factored, 1), hashOfSteps(factored, 2));
}

}  // namespace
}  // namespace stroma::test
