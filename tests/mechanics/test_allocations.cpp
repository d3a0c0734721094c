// SPDX-License-Identifier: LGPL-2.1-or-later
// After the first step a system allocates nothing, and a change of a number little.
#include <cstdlib>
#include <new>

#include "tests/support/scene_text.h"

namespace {
long allocations = 0;
std::size_t allocated_bytes = 0;
}  // namespace

[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  allocated_bytes += size;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace stroma::test {
namespace {

TEST(System, AllocatesNothingAfterTheFirstStep) {
  Simulation simulation(sceneFromText(R"(<Node name="root"><TestIntegrator/><TestMesh name="mesh" cells="3 2 2"/>
    <MechanicalObject name="dofs"/><MeshMatrixMass massDensity="5"/><TestSprings/><TestLinearNet name="net"/>
    <ConstantForceField indices="3" totalForce="1 0 0"/><FixedProjectiveConstraint indices="0 1" endTime="0.03"/>
    <SurfacePressureForceField pressure="3" pulseMode="1" pressureSpeed="40" volumeConservationMode="1"/>
    <TestTurningPlane name="plane" indices="1 5"/></Node>)"));
  System& system = *simulation.systems()[0];
  Vector p(system.independentRows()), out(system.independentRows()), f(system.allRows());
  std::vector<double> blocks;
  const auto step = [&](long index) {
    StepContext context;
    context.index = index, context.dt = 0.01, context.t = 0.01 * double(index), context.t_end = context.t + 0.01;
    system.beginStep(context);
    p[4] = Vec3(1, 2, 3);
    system.computeForceAndProduct(system.x, system.v, p, {.stiffness = -0.1}, f);
    system.matrix().withFactors({.mass = 1, .stiffness = -0.01}).multiply(p, out);
    system.matrix().diagonalBlocks(blocks);
    system.matrix().assemble();
    system.matrix().diagonalBlocks(blocks);
    system.constraints().project(f);
    if (system.kineticEnergy() + system.potentialEnergy(system.x) == 0) std::abort();
    if (!FaultWatch(system).firstFault(system.x).empty()) std::abort();
  };
  step(0);
  const long before = allocations;
  EXPECT_GT(before, 0) << "the counter counts";
  for (long i = 1; i < 8; ++i) step(i);
  EXPECT_EQ(allocations, before);
}

/// Bytes allocated by loading a body with this field, and then by a change of its Young's modulus.
std::pair<std::size_t, std::size_t> bytesToLoadAndToChange(const std::string& body) {
  const std::size_t start = allocated_bytes;
  Simulation simulation(
      sceneFromText("<Node name=\"root\"><EulerImplicitSolver/><CGLinearSolver iterations=\"20\" tolerance=\"1e-8\"/>"
                    "<RegularGridTopology name=\"grid\" n=\"9 9 17\" min=\"0 0 0\" max=\"0.1 0.1 0.2\"/>"
                    "<Node name=\"body\">" + body + "</Node></Node>"));
  simulation.step();
  const std::size_t loaded = allocated_bytes;
  simulation.setAttribute("/body/fem", "youngModulus", "9000");
  return {loaded - start, allocated_bytes - loaded};
}

/// The grid's cells as tetrahedra.
std::string ofTetrahedra(const std::string& field) {
  return "<TetrahedronSetTopologyContainer name=\"mesh\"/><Hexa2TetraTopologicalMapping input=\"@../grid\" output=\"@mesh\" "
         "swapping=\"true\"/><MechanicalObject/><UniformMass totalMass=\"1\"/>" + field;
}

// Kinds, shapes, fans and the order of the elements stay what they are: 1,024 hexahedra or five times as many tetrahedra of some
// hundred bytes each.
TEST(LiveEdit, OfYoungsModulusMakesNoElementsAnew) {
  const std::string of_tetrahedra[] = {"method=\"large\"", "method=\"svd\" poissonRatio=\"0.49\"", "method=\"small\"",
                                       "method=\"polar\" polarOf=\"edges\""};
  std::vector<std::pair<std::string, std::size_t>> bodies;
  for (const std::string& method : of_tetrahedra)
    bodies.emplace_back(ofTetrahedra("<TetrahedronFEMForceField name=\"fem\" " + method + "/>"), 5120);
  bodies.emplace_back("<MechanicalObject/><UniformMass totalMass=\"1\"/><HexahedronFEMForceField name=\"fem\" method=\"svd\"/>", 1024);
  bodies.emplace_back("<Hexa2TetraTopologicalMapping name=\"mesh\" input=\"@../grid\"/><Linear2QuadraticTopologicalMapping name=\"ten\" "
                      "input=\"@mesh\"/><MechanicalObject src=\"@ten\"/><UniformMass totalMass=\"1\"/>"
                      "<QuadraticTetrahedronFEMForceField name=\"fem\" topology=\"@ten\"/>", 5120);
  for (const auto& [body, cells] : bodies) {
    SCOPED_TRACE(body);
    bytesToLoadAndToChange(body);  // modules are opened once for all tests
    const auto [load, change] = bytesToLoadAndToChange(body);
    EXPECT_GT(load, cells * 300) << "bytes of elements are not counted, of which a change makes less than half";
    EXPECT_LT(change, cells * 150);
  }
}

}  // namespace
}  // namespace stroma::test
