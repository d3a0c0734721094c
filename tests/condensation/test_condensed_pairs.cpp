// SPDX-License-Identifier: LGPL-2.1-or-later
// Contact of condensed bodies with each other and with moving meshes, against the same bodies in EulerImplicitSolver, which solves
// with the whole matrix for each condition.
#include <fmt/format.h>

#include <sstream>

#include "tests/condensation/bodies.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string grid(const char* name, const char* n, const char* low, const char* high, const std::string& more) {
  return fmt::format(
      "<Node name=\"{0}\"><Node name=\"source\"><RegularGridTopology name=\"grid\" n=\"{1}\" min=\"{2}\" max=\"{3}\"/></Node>"
      "<TetrahedronSetTopologyContainer name=\"mesh\"/><Hexa2TetraTopologicalMapping input=\"@source/grid\" output=\"@mesh\"/>"
      "<MechanicalObject name=\"dofs\"/><UniformMass totalMass=\"0.5\"/><TetrahedronFEMForceField method=\"small\" youngModulus=\"5000\" "
      "poissonRatio=\"0.35\"/>{4}</Node>",
      name, n, low, high, more);
}
std::string held(const char* box) {
  return fmt::format("<BoxROI name=\"held\" box=\"{}\"/><FixedProjectiveConstraint indices=\"@held.indices\"/>", box);
}

/// A block that hangs over another one and is pushed down on it and aside.
std::string twoBlocks(const std::string& solver, double dt, double friction) {
  return fmt::format("<Node name=\"root\" dt=\"{}\" gravity=\"0 0 0\">{}", dt, solver) +
         grid("a", "4 3 4", "0.015 0.013 0.0605", "0.065 0.048 0.11",
              held("-1 -1 0.109 1 1 1") +
                  "<ConstantForceField indices=\"0 1 2 3 4 5 6 7 8 9 10 11\" totalForce=\"0.4 0.1 -1\"/>") +
         grid("b", "5 5 4", "0 0 0", "0.08 0.06 0.06", held("-1 -1 -1 1 1 0.001")) +
         fmt::format("<ConstraintContact name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" other=\"@b/dofs\" "
                     "contactDistance=\"1e-4\" friction=\"{}\"/></Node>",
                     friction);
}

/// A wedge of triangles that is pressed into a block and drawn along it.
std::string movingMesh(const std::string& solver, double dt, double friction) {
  return fmt::format("<Node name=\"root\" dt=\"{}\" gravity=\"0 0 0\">{}", dt, solver) +
         "<Node name=\"tool\"><MeshTopology name=\"mesh\" position=\"0.03 -0.01 0.09  0.05 -0.01 0.09  0.04 0.021 0.061  0.03 0.05 0.09  "
         "0.05 0.05 0.09\" triangles=\"0 2 1  0 3 2  1 2 4  2 3 4  0 1 3  1 4 3\"/></Node>" +
         grid("b", "6 5 4", "0 0 0", "0.08 0.06 0.06", held("-1 -1 -1 1 1 0.001")) +
         fmt::format("<ConstraintContact name=\"contact\" mstate=\"@b/dofs\" topology=\"@b/mesh\" meshes=\"@/tool/mesh\" "
                     "keyTimes=\"0 {} {}\" movements=\"0 0 0  0 0 -0.004  0.004 0.001 -0.004\" contactDistance=\"5e-4\" "
                     "friction=\"{}\"/></Node>",
                     4 * dt, 10 * dt, friction);
}

Vector pushed(const std::string& text, double& push) {
  Simulation simulation = simulationFromText(text);
  for (int i = 0; i < 8; ++i) {
    const StepReport report = simulation.step();
    EXPECT_FALSE(report.diverged || report.unsolved) << report.reason;
    EXPECT_TRUE(report.constraints_converged) << "step " << i << ": " << report.constraint_reason;
  }
  std::vector<Component*> all;
  simulation.root().collect(all);
  for (const Component* component : all)
    if (component->name() == "contact") {
      std::istringstream text_of(component->data().find("wrenches")->print());
      for (double value; text_of >> value;) push = std::max(push, std::abs(value));
    }
  return displacement(simulation);
}

/// `apart`: of places [m]; 0: none but round-off.
template <class Scene>
void expectWholeBodies(Scene&& scene, const std::vector<double>& steps, double apart = 0) {
  for (const double dt : steps)
    for (const double friction : {0.0, 0.3}) {
      SCOPED_TRACE(fmt::format("dt {} friction {}", dt, friction));
      const char* solver = dt < 1 ? "<CondensedDynamicSolver/>" : "<CondensedStaticSolver/>";
      double push = 0, expected_push = 0;
      const Vector expected = pushed(scene("<EulerImplicitSolver/><SparseLDLSolver/>", dt, friction), expected_push);
      const Vector found = pushed(scene(solver, dt, friction), push);
      if (apart == 0) {
        EXPECT_LT(difference(found, expected), 1e-6);
      }
      for (Index i = 0; i < found.count() && apart > 0; ++i) EXPECT_LT((Vec3(found[i]) - Vec3(expected[i])).norm(), apart) << i;
      EXPECT_GT(expected_push, 0.01) << "they meet";
      EXPECT_NEAR(push, expected_push, (apart > 0 ? 0.005 : 1e-5) * expected_push);
    }
}

/// Edges over flat faces may be nearer than contactDistance by a hundredth of it, in either of the two.
TEST(CondensedPairs, TwoCondensedBodiesAreTheWholeBodies) { expectWholeBodies(twoBlocks, {0.002}, 0.02 * 1e-4); }

TEST(CondensedPairs, AMeshIsPressedIntoACondensedBody) { expectWholeBodies(movingMesh, {0.002, 1e5}); }

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
