// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces from outside: closed forms, nothing left behind, and runs that repeat themselves.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/simulation/matrix_of_system.h"
#include "tests/simulation/refused_input.h"
#include "tests/support/scene_fixture.h"
#include "tools/session/replay.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string beamScene(const std::string& solver, const std::string& integrator = "<EulerImplicitSolver/>") {
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -9.81 0\">" + integrator + solver +
         "<RegularGridTopology n=\"3 3 5\" min=\"0 0 0\" max=\"0.1 0.1 0.3\"/><MechanicalObject name=\"dofs\"/>"
         "<UniformMass totalMass=\"1\"/><HexahedronFEMForceField name=\"fem\" youngModulus=\"5000\" "
         "poissonRatio=\"0.3\" method=\"polar\"/><BoxROI name=\"roi\" box=\"-1 -1 -0.001 1 1 0.001\"/>"
         "<FixedProjectiveConstraint indices=\"@roi.indices\"/></Node>";
}

constexpr const char* direct = "<SparseLDLSolver/>";
constexpr const char* iterative = "<CGLinearSolver iterations=\"200\" tolerance=\"1e-12\"/>";

Input pull(std::vector<Index> nodes, const Vec3& by, double stiffness, double damping = 0) {
  Input input;
  input.state = "/dofs";
  input.nodes = std::move(nodes);
  input.targets.assign(input.nodes.size(), by);
  input.stiffness = stiffness, input.damping = damping;
  return input;
}

void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) ASSERT_FALSE(simulation.step().diverged);
}

TEST(Inputs, APulledNodeRestsWhereTheSpringsInSeriesPutIt) {
  const std::tuple<std::string, const char*, int> ways[] = {
      {std::string("<EulerImplicitSolver/>") + iterative, "0.1", 400},
      {std::string("<EulerImplicitSolver/>") + direct, "0.1", 400},
      {std::string("<EulerImplicitSolver newtonIterations=\"5\"/>") + direct, "0.1", 400},
      {std::string("<StaticSolver/>") + direct, "0.1", 1},
      {"<EulerExplicitSolver/>", "0.005", 4000}};
  for (const auto& [integrator, dt, steps] : ways) {
    SCOPED_TRACE(integrator);
    Simulation simulation = simulationFromText(springScene(integrator, dt));
    run(simulation, 1);
    const long number = simulation.addInput(pull({0}, {1, 0, 0}, 300, 5));
    run(simulation, steps);
    EXPECT_NEAR(simulation.systems()[0]->x[0].x(), 300. / 400, 1e-6);
    Input force;
    force.state = "/dofs", force.nodes = {0}, force.force = {0, 20, 0}, force.damping = 5;
    simulation.changeInput(number, force);
    run(simulation, steps);
    EXPECT_LT((Vec3(simulation.systems()[0]->x[0]) - Vec3(0, 0.2, 0)).norm(), 1e-6);
  }
}

TEST(Inputs, StiffnessIsPartOfTheMatrixWhateverSolvesIt) {
  const auto moved = [](const char* solver) {
    Simulation simulation = simulationFromText(beamScene(solver));
    run(simulation, 3);
    const long number = simulation.addInput(pull({40, 44}, {0.1, 0.2, 0.3}, 500, 1));
    run(simulation, 5);
    simulation.changeInput(number, pull({40, 44}, {0.1, 0.2, 0.35}, 800, 1));
    run(simulation, 5);
    Vector x(simulation.systems()[0]->allRows());
    copy(simulation.systems()[0]->x, x);
    return x;
  };
  const Vector exact = moved(direct), approximate = moved(iterative);
  EXPECT_LT(distance(exact, approximate), 1e-9);
  EXPECT_GT(std::abs(exact[44].y()), 0.05) << "nothing was pulled";
}

/// Diagonal blocks come from the fields until there is a matrix that holds them.
TEST(Inputs, DiagonalMatrixAndProductsAreOfOneStiffness) {
  Simulation simulation = simulationFromText(beamScene(iterative));
  run(simulation, 1);
  simulation.addInput(pull({20, 24}, {0.1, 0.2, 0.3}, 5e4));
  run(simulation, 1);
  const std::vector<double> diagonal = expectOneMatrix(*simulation.systems()[0], {.mass = 1, .stiffness = -1}, 5e4);
  EXPECT_GT(diagonal[9 * 20], 5e4) << "the input is in it";
}

TEST(Inputs, OnesThatWentBeforeAStepLeaveNothingBehind) {
  for (const char* solver : {direct, iterative})
    for (const char* integrator : {"<EulerImplicitSolver/>", "<BDFOdeSolver order=\"2\"/>", "<StaticSolver/>"}) {
      SCOPED_TRACE(std::string(solver) + integrator);
      Simulation touched = simulationFromText(beamScene(solver, integrator));
      Simulation never = simulationFromText(beamScene(solver, integrator));
      run(touched, 3), run(never, 3);
      const std::size_t fields = touched.systems()[0]->forceFields().size();
      const long number = touched.addInput(pull({40}, {0.1, 0.2, 0.3}, 500, 2));
      EXPECT_EQ(touched.systems()[0]->forceFields().size(), fields + 1);
      touched.removeInput(number);
      EXPECT_EQ(touched.systems()[0]->forceFields().size(), fields) << "steps without inputs pay for none";
      run(touched, 5), run(never, 5);
      EXPECT_EQ(touched.stateHash(), never.stateHash());
    }
}

TEST(Inputs, ARecordedHandIsReplayedBitForBitAndACheckpointHoldsIt) {
  for (const char* solver : {direct, iterative}) {
    SCOPED_TRACE(solver);
    Simulation played = simulationFromText(beamScene(solver));
    run(played, 2);
    const long number = played.addInput(pull({40}, {0.1, 0.15, 0.3}, 500, 2));
    run(played, 3);
    played.changeInput(number, pull({40}, {0.15, 0.15, 0.3}, 500, 2));
    const Archive in_hand = played.checkpoint();
    run(played, 3);
    played.removeInput(number);
    run(played, 3);
    Simulation replayed = simulationFromText(beamScene(solver));
    replay(replayed, played.events());
    run(replayed, 11);
    EXPECT_EQ(replayed.stateHash(), played.stateHash());
    Simulation restored = simulationFromText(beamScene(solver));
    restored.restore(in_hand);
    run(restored, 3);
    restored.removeInput(number);
    run(restored, 3);
    EXPECT_EQ(restored.stateHash(), played.stateHash());
    Simulation untouched = simulationFromText(beamScene(solver));
    run(untouched, 11);
    EXPECT_NE(untouched.stateHash(), played.stateHash());
  }
}

TEST(Inputs, WhatCannotActIsRefusedWithASentence) {
  Simulation simulation = simulationFromText(beamScene(direct)), same = simulationFromText(beamScene(direct));
  Input elsewhere = pull({0}, {0, 0, 0}, 1), no_target = pull({0}, {0, 0, 0}, 1);
  elsewhere.state = "/dof";
  no_target.targets.clear();
  EXPECT_NE(refusal(simulation, elsewhere).find("/dofs"), std::string::npos);
  EXPECT_NE(refusal(simulation, pull({45}, {0, 0, 0}, 1)).find("nodes 0 to 44"), std::string::npos);
  EXPECT_NE(refusal(simulation, pull({}, {0, 0, 0}, 1)).find("names no node"), std::string::npos);
  EXPECT_NE(refusal(simulation, pull({1}, {0, 0, 0}, -1)).find("negative"), std::string::npos);
  EXPECT_NE(refusal(simulation, pull({1}, {0, NAN, 0}, 1)).find("not finite"), std::string::npos);
  EXPECT_NE(refusal(simulation, no_target).find("no targets"), std::string::npos);
  EXPECT_THROW(simulation.removeInput(7), ComponentError);
  run(simulation, 3), run(same, 3);
  EXPECT_EQ(simulation.stateHash(), same.stateHash()) << "a refused input left something behind";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
