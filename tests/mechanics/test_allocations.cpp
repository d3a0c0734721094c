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

/// A body of a grid of 1,024 cells, and the attribute whose change is measured.
struct Body {
  std::string text;
  std::size_t cells;
  std::string component = "fem", attribute = "youngModulus", value = "9000";
};

/// Bytes allocated by loading it, and then by the change.
std::pair<std::size_t, std::size_t> bytesToLoadAndToChange(const Body& body) {
  const std::size_t start = allocated_bytes;
  Simulation simulation(
      sceneFromText("<Node name=\"root\"><EulerImplicitSolver/><CGLinearSolver iterations=\"20\" tolerance=\"1e-8\"/>"
                    "<RegularGridTopology name=\"grid\" n=\"9 9 17\" min=\"0 0 0\" max=\"0.1 0.1 0.2\"/>"
                    "<Node name=\"body\">" + body.text + "</Node></Node>"));
  simulation.step();
  const std::size_t loaded = allocated_bytes;
  simulation.setAttribute("/body/" + body.component, body.attribute, body.value);
  return {loaded - start, allocated_bytes - loaded};
}

const std::string state_and_mass = "<MechanicalObject/><UniformMass totalMass=\"1\"/>";

/// The grid's cells as tetrahedra.
Body ofTetrahedra(const std::string& field) {
  return {"<TetrahedronSetTopologyContainer name=\"mesh\"/><Hexa2TetraTopologicalMapping input=\"@../grid\" output=\"@mesh\" "
          "swapping=\"true\"/>" + state_and_mass + field, 5120};
}
Body ofHexahedra(const std::string& field) { return {state_and_mass + field, 1024}; }
/// Ten nodes each.
Body ofQuadraticTetrahedra(const std::string& field) {
  return {"<Hexa2TetraTopologicalMapping name=\"mesh\" input=\"@../grid\"/><Linear2QuadraticTopologicalMapping name=\"ten\" "
          "input=\"@mesh\"/><MechanicalObject src=\"@ten\"/><UniformMass totalMass=\"1\"/>" + field, 5120};
}
/// The nodes of a block of n x n x n cells, each cut into two prisms, or with a node in its middle into six pyramids.
Body ofPrismsOrPyramids(bool prisms, const std::string& field) {
  constexpr int n = 8, side = n + 1;
  std::string position, cells;
  const auto add = [&cells](std::initializer_list<int> nodes) {
    for (const int node : nodes) cells += std::to_string(node) + " ";
  };
  for (int i = 0; i < side * side * side; ++i)
    position += std::to_string(i % side) + " " + std::to_string(i / side % side) + " " + std::to_string(i / side / side) + " ";
  int middle = side * side * side;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = (k * side + j) * side + i, b = a + 1, c = b + side, d = a + side, up = side * side;
        if (prisms) {
          add({a, b, c, a + up, b + up, c + up}), add({a, c, d, a + up, c + up, d + up});
          continue;
        }
        position += std::to_string(i + 0.5) + " " + std::to_string(j + 0.5) + " " + std::to_string(k + 0.5) + " ";
        add({a, b, c, d, middle}), add({d + up, c + up, b + up, a + up, middle}), add({a, a + up, b + up, b, middle});
        add({b, b + up, c + up, c, middle}), add({c, c + up, d + up, d, middle}), add({d, d + up, a + up, a, middle});
        ++middle;
      }
  return {"<MeshTopology name=\"cells\" position=\"" + position + "\" " + (prisms ? "prisms" : "pyramids") + "=\"" + cells +
              "\"/><MechanicalObject position=\"@cells.position\"/><UniformMass totalMass=\"1\"/>" + field,
          std::size_t(prisms ? 2 : 6) * n * n * n};
}
/// A rod of beams along x.
Body ofBeams(const std::string& field) {
  constexpr int beams = 1000;
  std::string position, edges;
  for (int i = 0; i <= beams; ++i) position += std::to_string(0.01 * i) + " 0 0 0 0 0 1 ";
  for (int i = 0; i < beams; ++i) edges += std::to_string(i) + " " + std::to_string(i + 1) + " ";
  return {"<MeshTopology edges=\"" + edges + "\"/><MechanicalObject template=\"Rigid3\" position=\"" + position +
              "\"/><UniformMass totalMass=\"1\" inertia=\"1e-4 1e-4 1e-4\"/>" + field,
          beams};
}
Body ofTriangles(const std::string& field) {
  return {"<Node name=\"source\"><RegularGridTopology name=\"flat\" n=\"33 33 1\" min=\"0 0 0\" max=\"0.1 0.1 0\"/></Node>"
          "<TriangleSetTopologyContainer name=\"mesh\"/><Quad2TriangleTopologicalMapping input=\"@source/flat\" output=\"@mesh\"/>" +
              state_and_mass + field, 2048};
}

// Kinds, shapes, fans and the order of the cells stay what they are: some hundred bytes of each.
TEST(LiveEdit, OfYoungsModulusMakesNoElementsAnew) {
  std::vector<Body> bodies;
  for (const char* method : {"method=\"large\"", "method=\"svd\" poissonRatio=\"0.49\"", "method=\"small\"", "method=\"nodal\"",
                             "method=\"green\"", "method=\"svd\" tangent=\"exact\"", "method=\"polar\" polarOf=\"edges\""})
    bodies.push_back(ofTetrahedra("<TetrahedronFEMForceField name=\"fem\" " + std::string(method) + "/>"));
  for (const char* method :
       {"method=\"svd\"", "method=\"svd\" incompatibleModes=\"true\"", "method=\"polar\" poissonRatio=\"0.49\""})
    bodies.push_back(ofHexahedra("<HexahedronFEMForceField name=\"fem\" " + std::string(method) + "/>"));
  bodies.push_back(ofQuadraticTetrahedra("<QuadraticTetrahedronFEMForceField name=\"fem\" topology=\"@ten\"/>"));
  for (const bool prisms : {true, false})
    bodies.push_back(ofPrismsOrPyramids(prisms, "<CorotationalFEMForceField name=\"fem\" method=\"svd\" poissonRatio=\"0.3\"/>"));
  const std::string elastic = "youngModulus=\"5000\" poissonRatio=\"0.3\"";
  for (const char* law : {"materialName=\"NeoHookean\"", "materialName=\"StVenantKirchhoff\"", "materialName=\"MooneyRivlin\" c2=\"300\"",
                          "materialName=\"NeoHookean\" projectedTangent=\"true\"",
                          "materialName=\"NeoHookean\" discretization=\"standard\"",
                          "materialName=\"StableNeoHookean\" viscous=\"true\" ParameterAlpha=\"0.5\" ParameterTau=\"1\""})
    bodies.push_back(ofTetrahedra("<TetrahedronHyperelasticityFEMForceField name=\"fem\" " + elastic + " " + law + "/>"));
  for (const char* poisson : {"0.3", "0.45"})
    bodies.push_back(ofHexahedra("<HexahedronHyperelasticityFEMForceField name=\"fem\" materialName=\"NeoHookean\" youngModulus=\"5000\" "
                                 "poissonRatio=\"" + std::string(poisson) + "\"/>"));
  bodies.push_back(ofQuadraticTetrahedra("<QuadraticTetrahedronHyperelasticityFEMForceField name=\"fem\" topology=\"@ten\" "
                                         "materialName=\"NeoHookean\" " + elastic + "/>"));
  bodies.push_back(ofHexahedra("<NeoHookeanMaterial name=\"law\" " + elastic + "/><HyperelasticityFEMForceField/>"));
  bodies.back().component = "law";
  for (const char* axes : {"beam", "firstEnd"})
    bodies.push_back(ofBeams("<BeamFEMForceField name=\"fem\" radius=\"0.01\" axes=\"" + std::string(axes) + "\" " + elastic + "/>"));
  bodies.push_back(ofTriangles("<TriangularFEMForceField name=\"fem\" thickness=\"0.01\" " + elastic + "/>"));
  for (const Body& body : bodies) {
    SCOPED_TRACE(body.text.substr(body.text.rfind('<', body.text.size() - 3)));
    bytesToLoadAndToChange(body);  // modules are opened once for all tests
    const auto [load, change] = bytesToLoadAndToChange(body);
    EXPECT_GT(load, body.cells * 300) << "bytes of elements are not counted, of which a change makes less than half";
    EXPECT_LT(change, body.cells * 150);
  }
}

}  // namespace
}  // namespace stroma::test
