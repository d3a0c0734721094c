// SPDX-License-Identifier: LGPL-2.1-or-later
// Steps with contact take memory only where there are more pairs than ever before: all memory of the program is counted.
#include "components/contact/path_proofs.h"
#include "tests/contact/contact_scenes.h"
#include "tests/support/counted_allocations.h"

#if defined(STROMA_COUNTS_ALLOCATIONS)
namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Of five steps, after thirty: a sphere is pressed into a block, and drawn along.
long allocationsWith(const std::string& integrator, const std::string& contact, const std::string& way, double dt) {
  Simulation simulation = simulationFromText(fmt::format(
      "<Node name=\"root\" dt=\"{}\" gravity=\"0 0 -9.81\">{}<CGLinearSolver iterations=\"300\" tolerance=\"1e-11\"/>"
      "<RegularGridTopology n=\"6 6 4\" min=\"0 0 0\" max=\"0.1 0.1 0.05\"/><MechanicalObject/><UniformMass "
      "totalMass=\"0.5\"/>"
      "<BoxROI name=\"floor\" box=\"-1 -1 -0.001 1 1 0.001\"/><FixedProjectiveConstraint indices=\"@floor.indices\"/>"
      "<HexahedronFEMForceField youngModulus=\"1e4\" poissonRatio=\"0.4\" method=\"polar\"/>"
      "<{} friction=\"0.3\" spheres=\"0.05 0.05 0.0815 0.03\" keyTimes=\"0 {} 1\" movements=\"0 0 0  0 0 -0.008  {}\" "
      "selfContact=\"0\"/></Node>",
      dt, integrator, contact, 20 * dt, way));
  for (int i = 0; i < 30; ++i) simulation.step();
  const long before = allocations;
  for (int i = 0; i < 5; ++i) {
    const StepReport report = simulation.step();
    EXPECT_FALSE(report.failed()) << report.reason;
    EXPECT_TRUE(report.constraints_converged) << report.constraint_reason;
  }
  return allocations - before;
}

TEST(ContactAllocations, ThereAreNoneInASteadyStep) {
  const std::string barrier = "BarrierContact contactDistance=\"1e-3\" stiffness=\"1e4\"", stays = "0 0 -0.008",
                    drawn = "0.1 0 -0.008",
                    newton = "<EulerImplicitSolver newtonIterations=\"40\" rayleighMass=\"10\"/>";
  EXPECT_EQ(allocationsWith(newton, barrier, stays, 0.01), 0);
  EXPECT_EQ(allocationsWith("<EulerExplicitSolver vdamping=\"10\"/>", barrier, drawn, 5e-4), 0);
  EXPECT_EQ(allocationsWith(newton, "ConstraintContact contactDistance=\"1e-3\"", stays, 0.01), 0);
  EXPECT_LT(allocationsWith(newton, barrier, "0.01 0 -0.008", 0.01), 20)
      << "only where there are more pairs than before";
  EXPECT_GT(allocations, 0) << "the counter counts";
}

/// Rigid boxes on each other: more rows than ways to move, whose forces are searched for from those of the step before.
long allocationsOfBoxes(const std::string& integrator) {
  std::string content, others;
  for (int i = 0; i < 3; ++i) {
    const Body box = boxOf(Vec3::Constant(-0.05), Vec3::Constant(0.05));
    content += fmt::format(
        "<Node name=\"b{}\"><MechanicalObject template=\"Rigid3\" position=\"{} 0 {}  0 0 0 1\"/><UniformMass totalMass=\"1\" "
        "inertia=\"0.0017 0.0017 0.0017\"/><Node name=\"skin\">{}<MechanicalObject name=\"dofs\"/><RigidMapping/></Node></Node>",
        i, 1e-3 * i, 0.051 + 0.1011 * i, box.mesh());
    if (i > 0) others += fmt::format("@b{}/skin/dofs ", i);
  }
  content += fmt::format("<ConstraintContact mstate=\"@b0/skin/dofs\" other=\"{}\" contactDistance=\"1e-3\" friction=\"0.5\" "
                         "planes=\"0 0 1 0\" selfContact=\"0\"/>",
                         others);
  Simulation simulation = simulationFromText(fmt::format("<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 -9.81\">{}<CGLinearSolver "
                                                         "iterations=\"100\" tolerance=\"1e-14\"/>{}</Node>",
                                                         integrator, content));
  for (int i = 0; i < 30; ++i) simulation.step();
  const long before = allocations;
  for (int i = 0; i < 10; ++i) {
    const StepReport report = simulation.step();
    EXPECT_FALSE(report.failed()) << report.reason;
    EXPECT_TRUE(report.constraints_converged) << report.constraint_reason;
  }
  return allocations - before;
}

TEST(ContactAllocations, ThereAreNoneWhereBoxesStand) {
  EXPECT_EQ(allocationsOfBoxes("<EulerImplicitSolver/>"), 0);
  EXPECT_EQ(allocationsOfBoxes("<EulerImplicitSolver newtonIterations=\"20\"/>"), 0);
}

/// The second test of paths, of threads on arcs that come close to each other.
TEST(ContactAllocations, ThereAreNoneForPaths) {
  Simulation simulation = simulationFromText(contactScene(
      "<Node name=\"a\"><MeshTopology name=\"mesh\" position=\"-1 0 0  1 0 0  0 -1 0.1  0 1 0.1\" edges=\"0 1 2 3\"/>"
      "<MechanicalObject name=\"dofs\"/><UniformMass/></Node>"));
  State* state = simulation.states().front();
  std::vector<Topology*> meshes;
  state->node().collect(meshes);
  contact::Surfaces surfaces;
  surfaces.addState(*state, meshes.front()->mesh());
  surfaces.finish();
  contact::PathProofs paths;
  paths.compile(surfaces, true);
  const std::vector<Vec3> x = surfaces.rest;
  std::vector<Vec3> way(4, Vec3::Zero());
  for (std::size_t v = 2; v < 4; ++v) way[v].z() = -0.09;
  const std::vector<double> bend(4, 1e-3);
  paths.startAt(x), paths.allow(x, way, bend, 1);
  const long before = allocations;
  for (int i = 0; i < 3; ++i) paths.startAt(x), paths.allow(x, way, bend, 1), paths.moveTo(x);
  EXPECT_EQ(allocations - before, 0);
  EXPECT_EQ(paths.doubt("/contact", {}), "");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
#endif
