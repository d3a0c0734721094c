// SPDX-License-Identifier: LGPL-2.1-or-later
// What holds for every mass of the factory, also of a mesh that has lost cells: products, matrix and diagonal are one symmetric
// positive M; energy 1/2 v.Mv; what moves as a whole has the total mass; weight M g; the same bits with two threads.
#include <fmt/format.h>

#include <cstring>

#include "framework/algebra/parallel.h"
#include "tests/support/manual_examples.h"
#include "tests/support/quadratic_block.h"
#include "tests/support/random_rows.h"
#include "tests/support/scene_text.h"
#include "tools/session/session.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

struct Case {
  std::string name, scene, type = {};  ///< of the mass
  double share = 0;                    ///< of the total mass that is left when the first of the cells goes; 0: it has no cells
};
std::ostream& operator<<(std::ostream& out, const Case& c) { return out << c.name; }

std::string inScene(const std::string& body) {
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"1 -9 2\"><EulerImplicitSolver/><SparseLDLSolver/>" + body + "</Node>";
}
std::string grid(const std::string& mass, const std::string& n = "5 2 2", const std::string& high = "4 1 1") {
  return inScene("<RegularGridTopology name=\"g\" n=\"" + n + "\" min=\"0 0 0\" max=\"" + high +
                 "\"/><MechanicalObject name=\"s\"/>" + mass);
}
std::string tetrahedra(const std::string& mass) {
  return inScene("<MeshTopology name=\"g\" position=\"0 0 0  1 0 0  0 1 0  0 0 1  1 1 1  2 0 1\" tetrahedra=\"0 1 2 3  1 4 2 3  1 5 4 3\"/>"
                 "<MechanicalObject name=\"s\"/>" + mass);
}
std::string quadratic(const std::string& mass) {
  return inScene(QuadraticBlock::raised({{0, 0, 0}, {1, 0.2, 0}, {0, 1, -0.3}, {0.2, 0.1, 1}, {1, 1, 1}}, {{0, 1, 2, 3}, {1, 4, 2, 3}})
                     .topology() + "<MechanicalObject name=\"s\"/>" + mass);
}
std::string frames(const std::string& mass) {
  return inScene("<MechanicalObject name=\"s\" template=\"Rigid3\" position=\"0 0 0  0.1 0.2 0.3 0.9   1 0.5 0  -0.4 0.1 0 0.8\"/>" + mass);
}
std::string numbers(const std::string& mass) {
  return inScene("<MechanicalObject name=\"s\" template=\"Vec1\" position=\"0.3 -1 2\"/>" + mass);
}

std::vector<Case> recipes() {
  const double cells = 3. / 4, points = 16. / 20, volume = 1 - (1. / 6) / (5. / 6);
  return {{"UniformMass", grid("<UniformMass totalMass=\"7\"/>"), {}, points},
          {"UniformMassOfNodes", grid("<UniformMass vertexMass=\"0.4\"/>"), {}, points},
          {"UniformMassOfFrames", frames("<UniformMass totalMass=\"3\" inertia=\"0.1 0.2 0.4\"/>")},
          {"UniformMassOfNumbers", numbers("<UniformMass totalMass=\"3\"/>")},
          {"DiagonalMass", grid("<DiagonalMass massDensity=\"7\"/>"), {}, cells},
          {"DiagonalMassOfTetrahedra", tetrahedra("<DiagonalMass totalMass=\"7\"/>"), {}, volume},
          {"MeshMatrixMass", grid("<MeshMatrixMass massDensity=\"7\"/>"), {}, cells},
          {"MeshMatrixMassLumped", grid("<MeshMatrixMass massDensity=\"7\" lumping=\"true\"/>"), {}, cells},
          {"MeshMatrixMassOfTetrahedra", tetrahedra("<MeshMatrixMass totalMass=\"7\"/>"), {}, volume},
          {"DiagonalMassOfNodes", tetrahedra("<DiagonalMass vertexMass=\"1 2 3 4 5 6\"/>"), {}, 20. / 21},
          {"MeshMatrixMassOfNodes", tetrahedra("<MeshMatrixMass vertexMass=\"1 2 3 4 5 6\"/>"), {}, 20. / 21},
          {"DiagonalMassOfQuadraticCells", quadratic("<DiagonalMass massDensity=\"7\"/>")},
          {"MeshMatrixMassOfQuadraticCells", quadratic("<MeshMatrixMass massDensity=\"7\"/>")},
          {"MeshMatrixMassLumpedOfQuadraticCells", quadratic("<MeshMatrixMass massDensity=\"7\" lumping=\"true\"/>")},
          {"FEMMass", grid("<NodalMassDensity property=\"7\"/><FEMMass/>"), {}, cells},
          // V rho of its cells: 11/12, 3/2 and 5/4
          {"FEMMassOfManyDensities", tetrahedra("<NodalMassDensity property=\"7 6 5 4 3 2\"/><FEMMass/>"), {}, 0.75}};
}

/// The type of the mass in a scene: the first word that ends so.
std::string massOf(const std::string& scene) {
  const auto end = scene.find("Mass ") != std::string::npos ? scene.find("Mass ") + 4 : scene.find("Mass/>") + 4;
  return scene.substr(scene.rfind('<', end) + 1, end - scene.rfind('<', end) - 1);
}

/// The recipes, and what has a scene on its manual page that is enough. No module is opened here: each test is a process.
std::vector<Case> cases() {
  std::vector<Case> all = recipes();
  for (Case& each : all) each.type = massOf(each.scene);
  all.push_back({"AdaptiveBeamMass", "", "AdaptiveBeamMass"});
  return all;
}
std::string sceneOf(const Case& c) { return c.scene.empty() ? exampleIn(modules().manual(c.type)) : c.scene; }
std::vector<Case> carvedCases() {
  std::vector<Case> all = cases();
  std::erase_if(all, [](const Case& c) { return c.share == 0; });
  return all;
}

TEST(Masses, AreAllHere) {
  modules().openAll();
  const std::vector<Case> all = cases();
  for (const ComponentEntry* entry : factory().entries()) {
    if (entry->module.empty() || !dynamic_cast<Mass*>(factory().make(entry->type).get())) continue;
    EXPECT_TRUE(std::any_of(all.begin(), all.end(), [entry](const Case& c) { return c.type == entry->type; }))
        << entry->type << " is registered as a mass, and nothing tests it: write a recipe here";
  }
}

Mass* massIn(const System& system, const std::string& type) {
  for (Mass* mass : system.masses())
    if (mass->type() == type) return mass;
  return nullptr;
}
System& systemWith(const Simulation& simulation, const std::string& type) {
  for (const auto& system : simulation.systems())
    if (massIn(*system, type)) return *system;
  throw std::runtime_error("no system has a " + type);
}

Vector product(const Mass& mass, const Vector& p, double factor = 1) {
  Vector out(p.count());
  mass.addProduct(p, factor, out);
  return out;
}

/// The product, what is set at once, the assembled matrix and its diagonal.
void expectOneMatrix(System& system, Mass& mass) {
  const Vector p = randomRows(system, 3), q = randomRows(system, 4);
  const Vector by_product = product(mass, p, 1.5);
  const double size = norm(by_product);
  ASSERT_GT(size, 0);
  Vector other(system.allRows());
  if (mass.setsProducts(system.allRows())) {
    mass.setProduct(p, 1.5, other);
    EXPECT_LT(farthest(by_product, other), 1e-14 * size);
  }
  BlockPattern pattern(system.allRows());
  mass.addPattern(pattern);
  BlockMatrix matrix(std::move(pattern));
  mass.prepareAssembly(matrix);
  mass.addTo(1.5, matrix);
  matrix.multiply(p, other);
  EXPECT_LT(farthest(by_product, other), 1e-13 * size);
  std::vector<double> blocks(std::size_t(system.allRows()) * 9);
  mass.addDiagonal(1.5, blocks);
  for (Index i = 0; i < system.allRows(); ++i)
    for (std::size_t c = 0; c < 9; ++c)
      EXPECT_NEAR(blocks[std::size_t(i) * 9 + c], matrix.values()[std::size_t(matrix.diagonal()[i]) * 9 + c], 1e-13 * size);
  EXPECT_NEAR(dot(q, product(mass, p)), dot(p, product(mass, q)), 1e-13 * size * norm(q));
  EXPECT_GT(dot(p, product(mass, p)), 0);
  EXPECT_NEAR(mass.kineticEnergy(p), 0.5 * dot(p, product(mass, p)), 1e-14 * dot(p, product(mass, p)));
}

/// e on each row that is a place.
Vector allMovedBy(const System& system, const Mass& mass, const Vec3& e) {
  Vector rows(system.allRows());
  const Index first = mass.state().firstRow();
  for (Index i = 0; i < mass.state().size(); ++i)
    if (mass.state().kindOf(i) == RowKind::place) rows[first + i] = e;
  return rows;
}

/// A whole that moves in one direction, and its weight.
void expectOneTotal(System& system, const Mass& mass) {
  const Data* told = mass.data().find("totalMass");
  const bool is_of_places = mass.state().kindOf(0) == RowKind::place;
  EXPECT_EQ(mass.totalMass() > 0, is_of_places) << "what has no place has none";
  if (is_of_places && told && told->isSet())
    EXPECT_NEAR(mass.totalMass(), **std::get_if<double*>(&told->pointer()), 1e-13 * mass.totalMass());
  const Vec3 e = Vec3(1, 2, -2) / 3, g = mass.node().gravity();
  const Vector moved = allMovedBy(system, mass, e), momentum = product(mass, moved);
  EXPECT_NEAR(dot(moved, momentum), mass.totalMass(), 1e-13 * mass.totalMass());
  double sum = 0;
  for (Index i = 0; i < mass.state().size(); ++i)
    if (mass.state().kindOf(i) == RowKind::place) sum += mass.rowSums()[std::size_t(i)];
  Vector weight(system.allRows());
  mass.addGravity(weight);
  if (mass.type() == "AdaptiveBeamMass") {  // the weight is the matter of the force fields
    EXPECT_EQ(sum, 0);
    EXPECT_EQ(norm(weight), 0);
    system.computeForce(system.x, Vector(system.allRows()), weight);
    EXPECT_NEAR(dot(weight, allMovedBy(system, mass, g)), mass.totalMass() * g.squaredNorm(), 1e-12 * g.squaredNorm());
    return;
  }
  EXPECT_NEAR(sum, mass.totalMass(), 1e-13 * mass.totalMass());
  const Vector pulled = product(mass, allMovedBy(system, mass, g));
  for (Index i = 0; i < system.allRows(); ++i)
    if (system.motion().kindOf(i) == RowKind::place)
      EXPECT_LT((weight[i] - pulled[i]).norm(), 1e-13 * mass.totalMass() * (1 + g.norm())) << "row " << i;
  Vector x(system.allRows());
  copy(system.x, x);
  const Vector d = randomRows(system, 5);
  axpy(1, d, x);
  EXPECT_NEAR(mass.gravityEnergy(x) - mass.gravityEnergy(system.x), -dot(weight, d), 1e-11 * mass.totalMass() * (1 + g.norm()));
}

void expectContract(System& system, Mass& mass) {
  system.computeForce(system.x, system.v, system.f);  // inertia is that of these positions
  expectOneMatrix(system, mass);
  expectOneTotal(system, mass);
}

class MassContract : public testing::TestWithParam<Case> {};
class CarvedMassContract : public testing::TestWithParam<Case> {};

TEST_P(MassContract, IsOneMatrixWithOneTotal) {
  const Simulation simulation = simulationFromText(sceneOf(GetParam()));
  System& system = systemWith(simulation, GetParam().type);
  expectContract(system, *massIn(system, GetParam().type));
}

TEST_P(CarvedMassContract, HoldsOfAMeshThatHasLostACell) {
  const double total = massIn(*simulationFromText(GetParam().scene).systems()[0], GetParam().type)->totalMass();
  std::string scene = GetParam().scene;
  scene.insert(scene.rfind("</Node>"), "<CarvingRegion box=\"0 -9 -9 0.9 9 9\" begin=\"0.01\" end=\"0.01\"/>");
  if (scene.find("tetrahedra=") != std::string::npos) scene.replace(scene.find("0 -9 -9 0.9 9 9"), 15, "0 -9 -9 0.3 9 9");
  Session session;
  session.loadText(scene, "scene.xml");
  session.followMeshChanges();
  ASSERT_EQ(session.run({.steps = 3}).end, RunEnd::done);
  ASSERT_TRUE(session.simulation().hasChangedMeshes());
  System& system = systemWith(session.simulation(), GetParam().type);
  Mass& mass = *massIn(system, GetParam().type);
  EXPECT_NEAR(mass.totalMass(), GetParam().share * total, 1e-13 * total);
  expectContract(system, mass);
}

INSTANTIATE_TEST_SUITE_P(Masses, MassContract, testing::ValuesIn(cases()), [](const auto& values) { return values.param.name; });
INSTANTIATE_TEST_SUITE_P(Masses, CarvedMassContract, testing::ValuesIn(carvedCases()),
                         [](const auto& values) { return values.param.name; });

/// More rows than one thread takes at a time.
TEST(Masses, HaveTheSameBitsWithTwoThreads) {
  for (const char* mass : {"UniformMass totalMass=\"7\"", "DiagonalMass massDensity=\"7\"", "MeshMatrixMass massDensity=\"7\"",
                           "FEMMass"}) {
    const Simulation simulation = simulationFromText(grid("<" + std::string(mass) + "/>", "130 130 1", "2 1 0"));
    System& system = *simulation.systems()[0];
    Mass& tested = *system.masses()[0];
    const Vector p = randomRows(system, 6);
    Vector out[2];
    BlockPattern pattern(system.allRows());
    tested.addPattern(pattern);
    BlockMatrix matrix(std::move(pattern));
    tested.prepareAssembly(matrix);
    std::vector<double> values[2];
    double energies[2] = {};
    for (const int threads : {1, 2}) {
      setThreads(threads);
      out[threads - 1] = product(tested, p, 0.7);
      energies[threads - 1] = tested.kineticEnergy(p);
      std::fill(matrix.values().begin(), matrix.values().end(), 0.);
      tested.addTo(0.7, matrix);
      values[threads - 1] = {matrix.values().begin(), matrix.values().end()};
    }
    setThreads(1);
    EXPECT_EQ(std::memcmp(out[0].rows().data, out[1].rows().data, out[0].rows().doubles() * sizeof(double)), 0) << mass;
    EXPECT_EQ(energies[0], energies[1]) << mass;
    EXPECT_EQ(values[0], values[1]) << mass;
  }
}

/// Each mass of the factory takes frames and keeps the contract, or says that it does not.
TEST(Masses, TakeFramesOrRefuseThem) {
  modules().openAll();
  int taken = 0, refused = 0;
  for (const ComponentEntry* entry : factory().entries()) {
    if (entry->module.empty() || !dynamic_cast<Mass*>(factory().make(entry->type).get())) continue;
    const std::string text = frames("<MeshTopology position=\"0 0 0  1 0.5 0\" edges=\"0 1\"/><" + entry->type + " name=\"tested\"/>");
    const std::string problems = problemsOf(text);
    if (!problems.empty()) {
      expectContains(problems, "/tested");
      expectContains(problems, "expected");
      ++refused;
      continue;
    }
    const Simulation simulation = simulationFromText(text);
    System& system = *simulation.systems()[0];
    expectContract(system, *massIn(system, entry->type));
    ++taken;
  }
  EXPECT_GT(taken, 0);
  EXPECT_GT(refused, 1);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
