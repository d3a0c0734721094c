// SPDX-License-Identifier: LGPL-2.1-or-later
// Two simulations in two threads of a process do not touch each other: each has the bits that it has alone.
#include <gtest/gtest.h>

#include <barrier>
#include <string>
#include <thread>
#include <vector>

#include "framework/algebra/parallel.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Conjugate gradients and direct solvers, statics and dynamics, tetrahedra and hexahedra, laws with a register of their
/// own, mappings.
const std::vector<std::string> scenes = {
    "organ",         "organ_static", "organ_hyperelastic", "organ_embedded", "pressure",  "mesh_matrix_mass",
    "partial_fixed", "explicit",     "cantilever_polar",   "breathing",      "vtk_loader"};

std::unique_ptr<Simulation> load(const std::string& name, Factory& own_factory, Modules& own_modules) {
  const std::string file = STROMA_SOURCE_DIR "/scenes/examples/" + name + ".xml";
  auto simulation = std::make_unique<Simulation>(loadScene(file, {}, own_factory, own_modules));
  simulation->dropObservers();
  return simulation;
}

/// The hash after some steps of a scene, with a factory of its own.
std::uint64_t hashOf(const std::string& name) {
  Factory own_factory;
  Modules own_modules(own_factory);
  const auto simulation = load(name, own_factory, own_modules);
  for (int step = 0; step < 5; ++step) EXPECT_FALSE(simulation->step().diverged) << name;
  return simulation->stateHash();
}

/// The hashes of all scenes by two threads, which start each pair of scenes at once: thread 1 the scene `ahead` of that of
/// thread 0.
std::vector<std::uint64_t> hashesOfTwoThreads(std::size_t ahead, std::vector<std::uint64_t>& of_the_other) {
  const std::size_t count = scenes.size();
  std::vector<std::uint64_t> hashes[2] = {std::vector<std::uint64_t>(count), std::vector<std::uint64_t>(count)};
  std::barrier start(2);
  const auto run = [&](std::size_t thread) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t scene = (i + thread * ahead) % count;
      start.arrive_and_wait();
      hashes[thread][scene] = hashOf(scenes[scene]);
    }
  };
  std::thread other(run, 1);
  run(0);
  other.join();
  of_the_other = hashes[1];
  return hashes[0];
}

// The scenes run at once before they run alone: modules are then opened by two threads at once.
TEST(TwoSimulations, InTwoThreadsHaveTheBitsThatEachHasAlone) {
  std::vector<std::vector<std::uint64_t>> together;
  for (const std::size_t ahead : {0u, 1u}) {
    std::vector<std::uint64_t> other;
    together.push_back(hashesOfTwoThreads(ahead, other));
    together.push_back(other);
  }
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const std::uint64_t alone = hashOf(scenes[i]);
    for (const auto& hashes : together) EXPECT_EQ(hashes[i], alone) << scenes[i];
  }
}

TEST(TwoSimulations, TheNumberOfThreadsMayChangeWhileOneRuns) {
  const std::uint64_t alone = hashOf("organ_hyperelastic");
  std::uint64_t hash = 0;
  std::thread other([&hash] { hash = hashOf("organ_hyperelastic"); });
  for (int change = 0; change < 50; ++change) setThreads(1 + change % 3);
  other.join();
  setThreads(1);
  EXPECT_EQ(hash, alone);
}

/// Factors by two threads at once: the orders of the unknowns come from random numbers that the process has once.
TEST(TwoSimulations, DirectSolversOrderTheirUnknownsAsAlone) {
  const std::string text =
      "<Node name='root' dt='0.02' gravity='0 0 -9.81'><EulerImplicitSolver/><SparseLDLSolver/>"
      "<RegularGridTopology name='grid' n='12 7 7' min='0 0 0' max='0.3 0.1 0.1'/><MechanicalObject/>"
      "<DiagonalMass massDensity='1000'/><HexahedronFEMForceField method='polar' youngModulus='2e4' "
      "poissonRatio='0.3'/>"
      "<BoxROI name='held' box='-1 -1 -1 0.001 1 1'/><FixedProjectiveConstraint indices='@held.indices'/></Node>";
  const auto hash = [&text] {
    Factory own_factory;
    Modules own_modules(own_factory);
    Diagnostics diagnostics;
    SceneDescription description;
    description.file = "test.xml";
    description.root = readXml(text, description.file, {}, diagnostics);
    Simulation simulation(instantiate(std::move(description), own_factory, own_modules, std::move(diagnostics)));
    simulation.step();
    return simulation.stateHash();
  };
  const std::uint64_t alone = hash();
  for (int attempt = 0; attempt < 6; ++attempt) {
    std::uint64_t hashes[2];
    std::thread other([&] { hashes[1] = hash(); });
    hashes[0] = hash();
    other.join();
    EXPECT_EQ(hashes[0], alone);
    EXPECT_EQ(hashes[1], alone);
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
