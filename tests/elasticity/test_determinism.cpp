// SPDX-License-Identifier: LGPL-2.1-or-later
// The same bits for one and two threads, and for two runs in one process.
#include "framework/algebra/parallel.h"
#include "tests/elasticity/field_under_test.h"

namespace stroma::test {
namespace {

/// 45,000 tetrahedra or 36,000 hexahedra: enough for the loop to use its threads.
std::uint64_t hashOfSteps(const ElasticBody& body, const std::string& attributes, int thread_count, int cells,
                          const std::string& solver) {
  setThreads(thread_count);
  const std::string n = std::to_string(cells + 1);
  const std::string field =
      "<" + body.type + " youngModulus=\"1e4\" poissonRatio=\"0.4\" " + attributes +
      "/><BoxROI name=\"held\" box=\"-1 -0.001 -1 2 0.001 2\"/><FixedProjectiveConstraint indices=\"@held.indices\"/>";
  const std::string grid =
      "<RegularGridTopology name=\"grid\" n=\"" + n + " " + n + " " + n + "\" min=\"0 0 0\" max=\"1 1 1\"/>";
  const std::string start = "<Node name=\"root\" dt=\"0.01\">" + grid + "<EulerImplicitSolver/>" + solver;
  Simulation simulation = simulationFromText(
      body.tetrahedra ? start +
                            "<Node name=\"body\"><TetrahedronSetTopologyContainer name=\"tets\"/>"
                            "<Hexa2TetraTopologicalMapping input=\"@../grid\" output=\"@tets\" cutting=\"five\"/>"
                            "<MechanicalObject/><DiagonalMass massDensity=\"1000\"/>" +
                            field + "</Node></Node>"
                      : start + "<MechanicalObject/><UniformMass totalMass=\"1000\"/>" + field + "</Node>");
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(simulation.step().diverged);
  setThreads(1);
  return simulation.stateHash();
}
int cellsFor(const ElasticBody& body) { return body.tetrahedra ? 21 : 33; }

TEST(Determinism, OneAndTwoThreadsAndTwoRuns) {
  const std::string cg = "<CGLinearSolver iterations=\"8\" tolerance=\"1e-12\"/>";
  forEachElasticVariant(false, [&](const ElasticBody& body, const Variant& variant) {
    if (body.name == "hexahedra") return;  // the same scene as boxes
    const std::uint64_t once = hashOfSteps(body, variant.attributes, 1, cellsFor(body), cg);
    EXPECT_EQ(once, hashOfSteps(body, variant.attributes, 2, cellsFor(body), cg));
    EXPECT_EQ(once, hashOfSteps(body, variant.attributes, 1, cellsFor(body), cg));
  });
}
TEST(Determinism, ExactTangentsAndOwnMatrices) {
  const std::string cg = "<CGLinearSolver iterations=\"4\" tolerance=\"1e-12\"/>";
  for (const char* attributes : {"method=\"svd\" tangent=\"exact\"", "method=\"polar\" assembling=\"true\""})
    EXPECT_EQ(hashOfSteps(bodyOfTetrahedra(), attributes, 1, 21, cg),
              hashOfSteps(bodyOfTetrahedra(), attributes, 2, 21, cg))
        << attributes;
}
TEST(Determinism, MatricesToo) {
  const std::string assembled =
      "<CGLinearSolver template=\"CompressedRowSparseMatrixMat3x3\" preconditioner=\"block_jacobi\" iterations=\"8\" "
      "tolerance=\"1e-12\"/>";
  for (const char* method : {"method=\"large\"", "method=\"polar\" updateStiffnessMatrix=\"true\""}) {
    const std::uint64_t once = hashOfSteps(bodyOfTetrahedra(), method, 1, 21, assembled);
    EXPECT_EQ(once, hashOfSteps(bodyOfTetrahedra(), method, 2, 21, assembled)) << method;
  }
  EXPECT_EQ(hashOfSteps(bodyOfTetrahedra(), "method=\"polar\"", 1, 6, "<SparseLDLSolver/>"),
            hashOfSteps(bodyOfTetrahedra(), "method=\"polar\"", 2, 6, "<SparseLDLSolver/>"));
}

}  // namespace
}  // namespace stroma::test
