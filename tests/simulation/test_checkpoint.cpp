// SPDX-License-Identifier: LGPL-2.1-or-later
// A run that goes on from a checkpoint has the bits of one that never stopped.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "tests/support/scene_fixture.h"
#include "tools/session/session.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

struct Variant {
  std::string scene, text, name;
};

std::string readFile(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The text with another element in place of each `tag`: attributes that only the old one has are dropped.
std::string replaceElement(std::string text, const std::string& tag, const std::string& element) {
  for (auto at = text.find("<" + tag); at != std::string::npos; at = text.find("<" + tag, at + 1)) {
    const auto end = text.find("/>", at);
    std::string name;
    if (const auto given = text.find("name=\"", at); given < end)
      name = text.substr(given, text.find('"', given + 6) + 1 - given);
    text.replace(at, end + 2 - at, "<" + element + " " + name + "/>");
  }
  return text;
}

/// Every example with other integrators and solvers.
std::vector<Variant> variants() {
  const std::pair<const char*, const char*> changes[] = {
      {"EulerImplicitSolver", "BDFOdeSolver order=\"2\""},
      {"EulerImplicitSolver", "NewmarkImplicitSolver"},
      {"EulerImplicitSolver", "TrapezoidalRuleSolver"},
      {"EulerImplicitSolver", "VariationalSymplecticSolver"},
      {"EulerImplicitSolver", "EulerImplicitSolver rayleighStiffness=\"0.01\" newtonIterations=\"3\""},
      {"EulerImplicitSolver", "StaticSolver newton_iterations=\"3\""},
      {"EulerExplicitSolver", "CentralDifferenceSolver"},
      {"CGLinearSolver", "CGLinearSolver iterations=\"15\" warmStart=\"true\" preconditioner=\"block_jacobi\""},
      {"CGLinearSolver", "PCGLinearSolver iterations=\"15\" preconditioner=\"incomplete_cholesky\""},
      {"CGLinearSolver", "PCGLinearSolver iterations=\"15\" preconditioner=\"multigrid\""},
      {"CGLinearSolver", "SparseLDLSolver"}};
  std::vector<Variant> all;
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(STROMA_SOURCE_DIR "/scenes/examples"))
    if (entry.path().extension() == ".xml") files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  for (const std::string& file : files) {
    const std::string text = readFile(file), name = std::filesystem::path(file).filename().string();
    all.push_back({file, text, name});
    for (const auto& [from, to] : changes)
      if (text.find("<" + std::string(from)) != std::string::npos)
        all.push_back({file, replaceElement(text, from, to), name + ", " + to});
    if (text.find("<CGLinearSolver") != std::string::npos) {
      std::string warped = replaceElement(text, "CGLinearSolver", "PCGLinearSolver preconditioner=\"warped\"");
      warped.insert(warped.find("<PCGLinearSolver"), "<SparseLDLSolver/>");
      all.push_back({file, warped, name + ", warped"});
    }
  }
  return all;
}

/// Hashes of the steps up to `steps`, or those until one diverges.
std::vector<std::uint64_t> hashes(Simulation& simulation, long steps) {
  std::vector<std::uint64_t> found;
  while (simulation.steps() < steps && !simulation.step().diverged) found.push_back(simulation.stateHash());
  return found;
}

/// False when the scene, so changed, cannot be loaded.
bool checkRestore(const Variant& variant, std::mt19937& random) {
  SCOPED_TRACE(variant.name);
  Session session;
  const auto load = [&]() -> Simulation& {
    Simulation& simulation = session.loadText(variant.text, variant.scene);
    simulation.dropObservers();
    return simulation;
  };
  std::string bytes;
  std::vector<std::uint64_t> whole;
  const long stop = std::uniform_int_distribution<long>(1, 11)(random), last = stop + 5;
  try {
    Simulation& simulation = load();
    hashes(simulation, stop);
    bytes = Checkpoint{variant.scene, buildIdentity(), simulation.checkpoint()}.bytes();
    whole = hashes(simulation, last);
  } catch (const SceneError&) {
    return false;
  }
  Simulation& restored = load();
  restored.restore(Checkpoint::fromBytes(bytes, "memory").values);
  EXPECT_EQ(hashes(restored, last), whole) << "stopped after step " << stop;
  // and in a simulation that has gone elsewhere
  restored.restore(Checkpoint::fromBytes(bytes, "memory").values);
  EXPECT_EQ(hashes(restored, last), whole) << "restored again after step " << stop;
  return true;
}

// STROMA_RESTORE_RUNS asks for more runs than a test should take.
TEST(Checkpoint, RestoredExamplesHaveTheBitsOfRunsThatNeverStopped) {
  const char* asked = std::getenv("STROMA_RESTORE_RUNS");
  const int wanted = asked ? std::atoi(asked) : 20;
  std::mt19937 random(20);
  std::vector<Variant> all = variants();
  std::shuffle(all.begin(), all.end(), random);
  int done = 0, refused = 0;
  for (std::size_t i = 0; done < wanted && i < 4 * std::size_t(wanted) + all.size(); ++i)
    checkRestore(all[i % all.size()], random) ? ++done : ++refused;
  EXPECT_EQ(done, wanted);
  EXPECT_LT(refused, wanted) << "too few of the variants load";
  RecordProperty("variants", int(all.size()));
  RecordProperty("refused", refused);
}

const std::string falling =
    "<Node name=\"root\" dt=\"0.01\"><BDFOdeSolver order=\"2\" name=\"bdf\"/><CGLinearSolver iterations=\"20\" "
    "tolerance=\"1e-10\"/><MechanicalObject name=\"dofs\" position=\"0 0 0  1 0 0\"/><UniformMass name=\"mass\" "
    "totalMass=\"2\"/><SpringForceField springsIndices1=\"0\" springsIndices2=\"1\" lengths=\"0.5\" "
    "stiffness=\"100\"/></Node>";

TEST(Checkpoint, WhatDoesNotBelongToTheSceneIsRefused) {
  Simulation falls = simulationFromText(falling);
  hashes(falls, 3);
  std::string other = falling;
  other.replace(other.find("BDFOdeSolver order=\"2\""), 22, "NewmarkImplicitSolver ");
  Simulation newmark = simulationFromText(other);
  EXPECT_THROW(newmark.restore(falls.checkpoint()), std::runtime_error);
  // refused as a whole: the run starts at its start
  EXPECT_EQ(newmark.steps(), 0);
  EXPECT_EQ(newmark.stateHash(), simulationFromText(other).stateHash());
}

TEST(Checkpoint, MemoryMatters) {
  Simulation whole = simulationFromText(falling);
  hashes(whole, 5);
  Simulation forgetful = simulationFromText(falling);
  copy(whole.systems()[0]->x, forgetful.systems()[0]->x), copy(whole.systems()[0]->v, forgetful.systems()[0]->v);
  Simulation restored = simulationFromText(falling);
  restored.restore(whole.checkpoint());
  EXPECT_EQ(restored.time(), whole.time());
  whole.step(), forgetful.step(), restored.step();
  EXPECT_EQ(restored.stateHash(), whole.stateHash());
  EXPECT_NE(forgetful.stateHash(), whole.stateHash()) << "BDF's last step does not matter: nothing was tested";
}

// A hierarchy of multigrid is kept, and the matrix that it was made of is not.
TEST(Checkpoint, RelationsBesideAKeptHierarchy) {
  std::string pairs;
  for (int row = 0; row < 25; ++row) pairs += std::to_string(5 * row) + " " + std::to_string(5 * row + 4) + " ";
  const std::string scene =
      "<Node name='root' dt='0.01' gravity='0 0 -9.81'><EulerImplicitSolver/><PCGLinearSolver preconditioner='multigrid' "
      "iterations='30' tolerance='1e-8'/><RegularGridTopology n='5 5 5' min='0 0 0' max='0.1 0.1 0.1'/><MechanicalObject/>"
      "<UniformMass totalMass='1'/><HexahedronFEMForceField youngModulus='1e5' poissonRatio='0.3' method='small'/>"
      "<FixedProjectiveConstraint indices='0 1 2 3'/><LinearRelationProjectiveConstraint indices='" +
      pairs + "' coefficients='-1 1'/></Node>";
  Simulation whole = simulationFromText(scene);
  hashes(whole, 4);
  Simulation restored = simulationFromText(scene);
  restored.restore(whole.checkpoint());
  for (int step = 0; step < 4; ++step) {
    whole.step(), restored.step();
    ASSERT_EQ(restored.stateHash(), whole.stateHash()) << "step " << step;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
