// SPDX-License-Identifier: LGPL-2.1-or-later
// Statics against an independent program: CalculiX (ccx) on the same mesh, with the same nodal loads, held directions
// and moved nodes. Its elements C3D4 and C3D8 are the linear tetrahedron and the trilinear hexahedron with 2x2x2 Gauss
// points and nothing else (C3D8R has one point): the single distorted element below is the proof. C3D8I has incompatible modes. Of cells
// that are no parallelepipeds it fails the patch test (by 6 % on MacNeal and Harder's), so that they say nothing about ours.
// With NLGEOM and *ELASTIC its law is Green's strain against the second Piola-Kirchhoff stress, our method green.
// ccx prints seven digits.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "framework/mesh/topology.h"
#include "tests/validation/scene_run.h"

namespace stroma::test {
namespace {

struct Comparison {
  double young = 0, poisson = 0;
  bool large = false;  ///< Green's strain
  bool modes = false;  ///< incompatible modes of hexahedra
};

void writeCells(std::ofstream& deck, const Mesh& mesh, const Vector& rest, bool modes) {
  const auto volume = [&](Index a, Index b, Index c, Index d) {
    return Vec3(rest[b] - rest[a]).cross(Vec3(rest[c] - rest[a])).dot(Vec3(rest[d] - rest[a]));
  };
  std::size_t count = 0;
  if (!mesh.tetrahedra.empty()) deck << "*ELEMENT,TYPE=C3D4,ELSET=BODY\n";
  for (auto t : mesh.tetrahedra) {
    if (volume(t[0], t[1], t[2], t[3]) < 0) std::swap(t[2], t[3]);
    deck << fmt::format("{},{},{},{},{}\n", ++count, t[0] + 1, t[1] + 1, t[2] + 1, t[3] + 1);
  }
  if (!mesh.tetrahedra.empty()) return;
  const auto write = [&](const char* type, const auto& cells) {
    if (!cells.empty()) deck << fmt::format("*ELEMENT,TYPE={},ELSET=BODY\n", type);
    for (const auto& cell : cells) {
      deck << ++count;
      for (const Index node : cell) deck << "," << node + 1;
      deck << "\n";
    }
  };
  write(modes ? "C3D8I" : "C3D8", mesh.hexahedra), write("C3D6", mesh.prisms);
}

/// Forces and stresses in the deck are in this part of N and Pa: ccx takes a residual below 1e-6 for zero.
constexpr double units = 1e6;

/// The deck of a simulation that has made a step: mesh, material, held and moved nodes (where the step has put them),
/// and the load on every node of the rest shape, where elements exert none.
void writeDeck(Simulation& simulation, const Mesh& mesh, const Comparison& what, const std::string& path) {
  System& system = *simulation.systems().at(0);
  const State& state = *simulation.states().at(0);
  Vector rest(system.allRows()), still(system.allRows()), load(system.allRows());
  for (Index i = 0; i < state.size(); ++i) rest[i] = state.rest_position[i];
  system.computeForce(rest, still, load);
  std::ofstream deck(path);
  deck << "*NODE,NSET=ALL\n";
  for (Index i = 0; i < state.size(); ++i)
    deck << fmt::format("{},{:.12e},{:.12e},{:.12e}\n", i + 1, rest[i].x(), rest[i].y(), rest[i].z());
  writeCells(deck, mesh, rest, what.modes);
  deck << fmt::format("*MATERIAL,NAME=M\n*ELASTIC\n{},{}\n*SOLID SECTION,ELSET=BODY,MATERIAL=M\n", what.young * units,
                      what.poisson);
  deck << (what.large ? "*STEP,NLGEOM,INC=1000\n*CONTROLS,PARAMETERS=FIELD\n1e-10,1e-8\n*STATIC\n0.2,1\n"
                      : "*STEP\n*STATIC\n");
  deck << "*BOUNDARY\n";
  for (const NodeProjector& held : system.constraints().projectors())
    for (int c = 0; c < 3; ++c)
      if (held.projector(c, c) == 0)
        deck << fmt::format("{},{},{},{:.12e}\n", held.row + 1, c + 1, c + 1,
                            state.x()[held.row][c] - rest[held.row][c]);
  deck << "*CLOAD\n";
  for (Index i = 0; i < state.size(); ++i)
    for (int c = 0; c < 3; ++c)
      if (load[i][c] != 0) deck << fmt::format("{},{},{:.12e}\n", i + 1, c + 1, load[i][c] * units);
  deck << "*NODE PRINT,NSET=ALL,FREQUENCY=1000\nU\n*END STEP\n";
}

std::vector<Vec3> readDisplacements(const std::string& path, std::size_t count) {
  std::vector<Vec3> out(count, Vec3::Constant(std::nan("")));
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::size_t node = 0;
    Vec3 u;
    if (words >> node >> u.x() >> u.y() >> u.z() && node >= 1 && node <= count) out[node - 1] = u;
  }
  return out;
}

std::string testName() {
  std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

void expectAgreement(Simulation& simulation, const std::string& mesh_path, const Comparison& what) {
  if (std::system("command -v ccx > /dev/null 2>&1") != 0) GTEST_SKIP() << "ccx (CalculiX) is not installed";
  const StepReport report = simulation.step();
  ASSERT_TRUE(!report.diverged && report.newton_converged) << report.reason;
  const Displacements ours = displacements(simulation, report);
  const auto* topology = dynamic_cast<const Topology*>(findComponent(simulation.root(), mesh_path));
  ASSERT_NE(topology, nullptr);
  const std::string folder = fmt::format("{}/calculix_{}", STROMA_BINARY_DIR, testName());
  std::filesystem::create_directories(folder);
  writeDeck(simulation, topology->mesh(), what, folder + "/deck.inp");
  ASSERT_EQ(std::system(("cd '" + folder + "' && ccx deck > ccx.log 2>&1").c_str()), 0) << folder << "/ccx.log";
  const std::vector<Vec3> theirs = readDisplacements(folder + "/deck.dat", ours.moved.size());
  double largest = 0, apart = 0;
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    ASSERT_TRUE(theirs[i].allFinite()) << "ccx printed nothing for node " << i;
    largest = std::max(largest, theirs[i].norm());
    apart = std::max(apart, (theirs[i] - ours.moved[i]).norm());
  }
  fmt::print("{} nodes, {} tetrahedra, {} hexahedra, {} prisms: largest displacement {:.6g} m, largest difference {:.1e} of it\n",
             theirs.size(), topology->mesh().tetrahedra.size(), topology->mesh().hexahedra.size(), topology->mesh().prisms.size(),
             largest, apart / largest);
  EXPECT_GT(largest, 0);
  EXPECT_LT(apart / largest, 1e-6);
}

TEST(CalculiX, BeamHasTheSameDisplacements) {
  Simulation simulation = validationScene("cantilever_distributed",
                                          {"/beam/fem.poissonRatio=0.3", "/grid.n=41 3 3", "/beam/cut.cutting=six"});
  expectAgreement(simulation, "/beam/tetrahedra", {.young = 20000, .poisson = 0.3});
}

TEST(CalculiX, OrganHasTheSameDisplacements) {
  std::vector<Override> overrides{Override::parse("/organ/fem.method=small"),
                                  Override::parse("/organ/fem.tangent=warped")};
  Simulation simulation(
      loadScene(STROMA_SOURCE_DIR "/scenes/examples/organ_static.xml", overrides, factory(), modules()));
  simulation.dropObservers();
  expectAgreement(simulation, "/organ/mesh", {.young = 10000, .poisson = 0.45});
}

/// A beam of prisms, two in the place of each cube. C3D6 has two points.
TEST(CalculiX, BeamOfPrismsHasTheSameDisplacements) {
  const int n[3] = {9, 3, 3};
  std::string position, prisms;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        position += fmt::format("{} {} {} ", 0.05 * i, 0.05 * j, 0.05 * k);
        if (i + 1 == n[0] || j + 1 == n[1] || k + 1 == n[2]) continue;
        const int a = (k * n[1] + j) * n[0] + i, row = n[0], up = n[0] * n[1];
        prisms += fmt::format("{} {} {} {} {} {} ", a, a + 1, a + row + 1, a + up, a + up + 1, a + up + row + 1);
        prisms += fmt::format("{} {} {} {} {} {} ", a, a + row + 1, a + row, a + up, a + up + row + 1, a + up + row);
      }
  Simulation simulation = simulationFromText(fmt::format(R"(<Node name="root" dt="1" gravity="0 -0.02 -0.01">
  <StaticSolver/><SparseLDLSolver/><MeshTopology name="mesh" position="{}" prisms="{}"/><MechanicalObject/>
  <MeshMatrixMass massDensity="1000"/>
  <LinearSmallStrainFEMForceField dilatation="local" reducedIntegration="true" youngModulus="3000" poissonRatio="0.3"/>
  <BoxROI name="clamped" box="-1 -1 -1 0.001 1 1"/><FixedProjectiveConstraint indices="@clamped.indices"/></Node>)",
                                                         position, prisms));
  expectAgreement(simulation, "/mesh", {.young = 3000, .poisson = 0.3});
}

// ---- beam, cube and a single element; both elements, both strains, regular and distorted ----

/// A block of cells; loads and constraints by its name.
struct Specimen {
  std::string name;
  std::array<int, 3> nodes;
  Vec3 size;  ///< [m]
  std::string constraints;
  Vec3 gravity = Vec3::Zero();
};

struct Case {
  Specimen specimen;
  bool tetrahedra, distorted, large;
  double poisson;
  bool modes = false;
  std::string name() const {
    return fmt::format("{}_{}_{}_{}_nu{:g}", specimen.name, tetrahedra ? "tetrahedra" : modes ? "incompatible" : "hexahedra",
                       distorted ? "distorted" : "regular", large ? "green" : "small", 100 * poisson);
  }
};
void PrintTo(const Case& tested, std::ostream* out) { *out << tested.name(); }

/// A cantilever that sinks by half its length when strains are Green's, a cube between plates that are pushed together
/// by 18 % and shifted by 10 %, and one element under its weight.
std::vector<Specimen> specimens() {
  const std::string faces = R"(
    <BoxROI name="below" box="-1 -1 -0.001 1 1 0.001"/><FixedProjectiveConstraint indices="@below.indices"/>
    <BoxROI name="above" box="-1 -1 0.079 1 1 0.081"/>
    <LinearMovementProjectiveConstraint indices="@above.indices" keyTimes="0 1" movements="0 0 0  0.008 0 -0.0146"/>)";
  const std::string clamp = R"(
    <BoxROI name="clamped" box="-0.001 -1 -1 0.001 1 1"/><FixedProjectiveConstraint indices="@clamped.indices"/>)";
  return {
      {"beam", {17, 4, 4}, Vec3(0.4, 0.06, 0.05), clamp, Vec3(0, 0.02, -0.05)},
      {"cube", {6, 6, 6}, Vec3(0.08, 0.08, 0.08), faces},
      {"one", {2, 2, 2}, Vec3(0.1, 0.1, 0.1), "<FixedProjectiveConstraint indices=\"0 1 2\"/>", Vec3(0.8, 0.4, -2)}};
}

std::vector<Case> cases() {
  std::vector<Case> out;
  for (const Specimen& specimen : specimens())
    for (const bool tetrahedra : {true, false})
      for (const bool distorted : {false, true})
        for (const bool large : {false, true})
          for (const double poisson : {0., 0.3, 0.45})
            for (const bool modes : {false, true})
              if (!modes || (!tetrahedra && !large)) out.push_back({specimen, tetrahedra, distorted, large, poisson, modes});
  return out;
}

constexpr double young_modulus = 3000;

/// Positions and hexahedra; distorted: inner nodes (of a single element: all) moved by up to a fifth of an edge.
std::string scene(const Case& tested) {
  const auto& n = tested.specimen.nodes;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-0.2, 0.2);
  std::string position, cells;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        Vec3 p(i, j, k);
        const bool inner = i > 0 && j > 0 && k > 0 && i + 1 < n[0] && j + 1 < n[1] && k + 1 < n[2];
        const Vec3 noise(uniform(random), uniform(random), uniform(random));
        if (tested.modes && tested.distorted) p.y() += 0.3 * p.x();  // parallelepipeds
        else if (tested.distorted && (inner || n[0] == 2)) p += noise;
        for (int c = 0; c < 3; ++c) position += fmt::format("{} ", p[c] * tested.specimen.size[c] / (n[c] - 1));
        if (i + 1 == n[0] || j + 1 == n[1] || k + 1 == n[2]) continue;
        const int first = (k * n[1] + j) * n[0] + i, row = n[0], layer = n[0] * n[1];
        for (int c : {0, 1, row + 1, row, layer, layer + 1, layer + row + 1, layer + row})
          cells += fmt::format("{} ", first + c);
      }
  const std::string body = tested.tetrahedra ? R"(<TetrahedronSetTopologyContainer name="cells"/>
    <Hexa2TetraTopologicalMapping input="@../mesh" output="@cells" cutting="five"/>)"
                                             : R"(<HexahedronSetTopologyContainer name="cells" src="@../mesh"/>)";
  const Vec3& g = tested.specimen.gravity;
  return fmt::format(R"(<Node name="root" dt="1" gravity="{} {} {}">
  <MeshTopology name="mesh" position="{}" hexahedra="{}"/>
  <Node name="body"><StaticSolver newton_iterations="100" relative_residual_tolerance_threshold="1e-10"/><SparseLDLSolver/>
    {}<MechanicalObject/><DiagonalMass massDensity="1000"/>
    <{}FEMForceField method="{}" dilatation="local" tangent="exact" youngModulus="{}" poissonRatio="{}"{}/>{}
  </Node></Node>)",
                     g.x(), g.y(), g.z(), position, cells, body, tested.tetrahedra ? "Tetrahedron" : "Hexahedron",
                     tested.large ? "green" : "small", young_modulus, tested.poisson,
                     tested.modes ? " incompatibleModes=\"true\"" : "", tested.specimen.constraints);
}

class CalculiXBlocks : public testing::TestWithParam<Case> {};

TEST_P(CalculiXBlocks, HaveTheSameDisplacements) {
  Simulation simulation = simulationFromText(scene(GetParam()));
  expectAgreement(simulation, "/body/cells", {young_modulus, GetParam().poisson, GetParam().large, GetParam().modes});
  if (IsSkipped() || GetParam().specimen.name != "cube" || (GetParam().modes && GetParam().distorted)) return;
  const State& state = *simulation.states().at(0);
  const Vec3 corner = state.x()[state.size() - 1];
  EXPECT_LT((corner - Vec3(0.088, 0.08, 0.0654)).norm(), 1e-12) << "the plate is not where it was to go";
}

INSTANTIATE_TEST_SUITE_P(All, CalculiXBlocks, testing::ValuesIn(cases()),
                         [](const auto& tested) { return tested.param.name(); });

}  // namespace
}  // namespace stroma::test
