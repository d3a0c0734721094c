// SPDX-License-Identifier: LGPL-2.1-or-later
// Linear elasticity against an independent program: CalculiX (ccx), element C3D4, on the same mesh, nodal loads and
// held directions. ccx prints seven digits.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "framework/mesh/topology.h"
#include "tests/validation/scene_run.h"

namespace stroma::test {
namespace {

/// The deck of a simulation that has made a step: mesh, material, held axes, and the load on every node of the rest
/// shape, where linear elements exert none.
void writeDeck(Simulation& simulation, const Mesh& mesh, double young, double poisson, const std::string& path) {
  System& system = *simulation.systems().at(0);
  const State& state = *simulation.states().at(0);
  Vector rest(system.allRows()), still(system.allRows()), load(system.allRows());
  for (Index i = 0; i < state.size(); ++i) rest[i] = state.rest_position[std::size_t(i)];
  system.computeForce(rest, still, load);
  std::ofstream deck(path);
  deck << "*NODE,NSET=ALL\n";
  for (Index i = 0; i < state.size(); ++i)
    deck << fmt::format("{},{:.12e},{:.12e},{:.12e}\n", i + 1, rest[i].x(), rest[i].y(), rest[i].z());
  deck << "*ELEMENT,TYPE=C3D4,ELSET=BODY\n";
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
    auto t = mesh.tetrahedra[e];
    const Vec3 a = rest[t[0]], b = rest[t[1]], c = rest[t[2]], d = rest[t[3]];
    if ((b - a).cross(c - a).dot(d - a) < 0) std::swap(t[2], t[3]);
    deck << fmt::format("{},{},{},{},{}\n", e + 1, t[0] + 1, t[1] + 1, t[2] + 1, t[3] + 1);
  }
  deck << fmt::format("*MATERIAL,NAME=M\n*ELASTIC\n{},{}\n*SOLID SECTION,ELSET=BODY,MATERIAL=M\n*BOUNDARY\n", young,
                      poisson);
  for (const NodeProjector& held : system.projectors())
    for (int c = 0; c < 3; ++c)
      if (held.projector(c, c) == 0) deck << fmt::format("{},{},{}\n", held.row + 1, c + 1, c + 1);
  deck << "*STEP\n*STATIC\n*CLOAD\n";
  for (Index i = 0; i < state.size(); ++i)
    for (int c = 0; c < 3; ++c)
      if (load[i][c] != 0) deck << fmt::format("{},{},{:.12e}\n", i + 1, c + 1, load[i][c]);
  deck << "*NODE PRINT,NSET=ALL\nU\n*END STEP\n";
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

void expectAgreement(Simulation& simulation, const std::string& mesh_path, double young, double poisson) {
  if (std::system("command -v ccx > /dev/null 2>&1") != 0) GTEST_SKIP() << "ccx (CalculiX) is not installed";
  const StepReport report = simulation.step();
  ASSERT_TRUE(!report.diverged && report.newton_converged) << report.reason;
  const Displacements ours = displacements(simulation, report);
  const auto* topology = dynamic_cast<const Topology*>(findComponent(simulation.root(), mesh_path));
  ASSERT_NE(topology, nullptr);
  const std::string folder =
      fmt::format("{}/calculix_{}", STROMA_BINARY_DIR, testing::UnitTest::GetInstance()->current_test_info()->name());
  std::filesystem::create_directories(folder);
  writeDeck(simulation, topology->mesh(), young, poisson, folder + "/deck.inp");
  ASSERT_EQ(std::system(("cd '" + folder + "' && ccx deck > ccx.log 2>&1").c_str()), 0) << folder << "/ccx.log";
  const std::vector<Vec3> theirs = readDisplacements(folder + "/deck.dat", ours.moved.size());
  double largest = 0, apart = 0;
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    ASSERT_TRUE(theirs[i].allFinite()) << "ccx printed nothing for node " << i;
    largest = std::max(largest, theirs[i].norm());
    apart = std::max(apart, (theirs[i] - ours.moved[i]).norm());
  }
  fmt::print("{} nodes, {} tetrahedra: largest displacement {:.6g} m, largest difference {:.1e} of it\n", theirs.size(),
             topology->mesh().tetrahedra.size(), largest, apart / largest);
  EXPECT_GT(largest, 0);
  EXPECT_LT(apart / largest, 1e-6);
}

TEST(CalculiX, BeamHasTheSameDisplacements) {
  Simulation simulation = validationScene("cantilever_distributed",
                                          {"/beam/fem.poissonRatio=0.3", "/grid.n=41 3 3", "/beam/cut.cutting=six"});
  expectAgreement(simulation, "/beam/tetrahedra", 20000, 0.3);
}

TEST(CalculiX, OrganHasTheSameDisplacements) {
  std::vector<Override> overrides{Override::parse("/organ/fem.method=small"),
                                  Override::parse("/organ/fem.tangent=warped")};
  Simulation simulation(
      loadScene(STROMA_SOURCE_DIR "/scenes/examples/organ_static.xml", overrides, factory(), modules()));
  simulation.dropObservers();
  expectAgreement(simulation, "/organ/mesh", 10000, 0.45);
}

}  // namespace
}  // namespace stroma::test
