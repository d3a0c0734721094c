// SPDX-License-Identifier: LGPL-2.1-or-later
// Checkpoints of runs whose meshes change. Reference: the run that never stopped, to the bit.
#include <fmt/format.h>

#include "framework/algebra/parallel.h"
#include "tests/session/seen_runs.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string bar(const std::string& solvers, const std::string& content) {
  return "<Node name=\"root\" dt=\"0.004\" gravity=\"1 -9.81 2\">" + solvers +
         "<Node name=\"body\"><RegularGridTopology name=\"grid\" n=\"7 3 3\" min=\"0 0 0\" max=\"0.3 0.1 0.1\"/>" + content +
         "</Node></Node>";
}

/// Goes through the lower half of the bar, and takes two cells before each of the steps 4, 8 and 12.
const std::string knife = "<CarvingRegion name=\"knife\" box=\"0.27 -9 -9 9 0.05 9\" velocity=\"-3.125 0 0\" begin=\"0.012\"/>";
const std::string held = "<BoxROI name=\"end\" box=\"-1 -1 -1 0.001 1 1\"/><FixedProjectiveConstraint indices=\"@end.indices\"/>";
const std::string hexes =
    "<MechanicalObject name=\"dofs\"/><DiagonalMass massDensity=\"1000\"/><HexahedronFEMForceField name=\"fem\" "
    "youngModulus=\"20000\" poissonRatio=\"0.4\"/>" + held;
const std::string implicit = "<EulerImplicitSolver rayleighStiffness=\"0.01\"/><SparseLDLSolver/>";

std::string tetrahedra(const std::string& field) {
  return "<TetrahedronSetTopologyContainer name=\"t\"/><Hexa2TetraTopologicalMapping input=\"@grid\" output=\"@t\"/>"
         "<MechanicalObject name=\"dofs\" topology=\"@t\"/><DiagonalMass massDensity=\"1000\" topology=\"@t\"/>" + held +
         field;
}

/// What people do to the run, before and after cells go.
void act(Simulation& simulation) {
  if (simulation.steps() == 1) {
    simulation.setAttribute("/body/fem", "youngModulus", "16000");
    Input pull;
    pull.state = "/body/dofs", pull.nodes = {3, 20, 62}, pull.force = Vec3(0, 0.5, 0);
    simulation.addInput(pull);
  }
  if (simulation.steps() == 8) simulation.setAttribute("/body/knife", "offset", "-0.02 0 0");
}

std::uint64_t hashAt(Session& session, long step, bool acts = false) {
  session.followMeshChanges();
  const long left = step - session.simulation().steps();
  const RunReport report = session.run({.steps = left, .before_step = [&](Simulation& simulation) {
                                          if (acts) act(simulation);
                                        }});
  EXPECT_EQ(report.end, RunEnd::done) << report.reason;
  return session.simulation().stateHash();
}

/// Resumed at each of some steps in a session of its own, through the bytes of a file.
void expectResumed(const std::string& text, bool acts = false) {
  constexpr long end = 14;
  Session whole;
  whole.loadText(text, "scene.xml");
  const std::uint64_t start = whole.simulation().stateHash();
  std::vector<std::pair<std::string, std::size_t>> stored;
  for (long step = 2; step < end; step += 2) {
    hashAt(whole, step, acts);
    stored.emplace_back(whole.checkpoint().bytes(), std::size_t(whole.simulation().states()[0]->size()));
  }
  const std::uint64_t last = hashAt(whole, end, acts);
  EXPECT_GT(stored[0].second, stored[2].second) << "cells have gone" << text;
  EXPECT_GT(stored[2].second, std::size_t(whole.simulation().states()[0]->size())) << "and more have" << text;
  for (const auto& [bytes, rows] : stored) {
    Session other;
    other.loadText(text, "scene.xml");
    EXPECT_TRUE(other.restore(Checkpoint::fromBytes(bytes, "it"), "it").empty());
    EXPECT_EQ(std::size_t(other.simulation().states()[0]->size()), rows);
    EXPECT_EQ(other.checkpoint().bytes(), bytes) << "nothing is lost" << text;
    EXPECT_EQ(hashAt(other, end, acts), last) << rows << " rows, " << text;
    other.simulation().reset();
    other.simulation().takeEditsBack();
    EXPECT_EQ(other.simulation().stateHash(), start);
    EXPECT_FALSE(other.simulation().hasChangedMeshes());
  }
}

TEST(ChangedCheckpoints, ARunGoesOnWithTheSameBits) {
  const std::string elastic = "<TetrahedronFEMForceField name=\"fem\" youngModulus=\"20000\" poissonRatio=\"0.3\" topology=\"@t\"/>";
  const std::string plastic =
      elastic + "<PlasticStrainForceField youngModulus=\"20000\" poissonRatio=\"0.3\" plasticYieldThreshold=\"0.001\" "
                "plasticMaxThreshold=\"0.2\" plasticCreep=\"0.1\" topology=\"@t\"/>";
  const std::string viscous =
      "<MJEDTetrahedralForceField name=\"fem\" materialName=\"StVenantKirchhoff\" ParameterSet=\"4000 6000\" viscous=\"true\" "
      "ParameterAlpha=\"0.5\" ParameterTau=\"0.05\" topology=\"@t\"/>";
  const std::string of_grid = knife.substr(0, knife.size() - 2) + " topology=\"@grid\"/>";
  expectResumed(bar(implicit, hexes + knife));
  expectResumed(bar("<EulerImplicitSolver/><CGLinearSolver iterations=\"30\" tolerance=\"1e-6\"/>", hexes + knife));
  expectResumed(bar("<BDFOdeSolver order=\"2\"/><SparseLDLSolver/>", hexes + knife));
  expectResumed(bar("<NewmarkImplicitSolver/><SparseLDLSolver/>", tetrahedra(plastic + of_grid)));
  expectResumed(bar("<TrapezoidalRuleSolver/><SparseLDLSolver/>", tetrahedra(viscous + of_grid)));
  expectResumed(bar("<CentralDifferenceSolver/>", tetrahedra(elastic + of_grid)));
}

TEST(ChangedCheckpoints, PointsThatStayAndSurfacesThatFollowGoOn) {
  const std::string stays = knife.substr(0, knife.size() - 2) + " keepsPoints=\"true\"/>";
  Session whole, other;
  const std::string skin =
      "<Node name=\"skin\"><QuadSetTopologyContainer name=\"quads\"/><Hexa2QuadTopologicalMapping input=\"@../grid\" "
      "output=\"@quads\"/><MechanicalObject name=\"dofs\"/><IdentityMapping/></Node>";
  for (const std::string& region : {knife, stays}) {
    const std::string text = bar(implicit, hexes + region + skin);
    whole.loadText(text, "scene.xml"), other.loadText(text, "scene.xml");
    hashAt(whole, 6);
    other.restore(whole.checkpoint(), "it");
    EXPECT_EQ(hashAt(other, 12), hashAt(whole, 12)) << region;
  }
}

TEST(ChangedCheckpoints, WhatWasDoneToTheRunGoesOnToo) {
  expectResumed(bar(implicit, hexes + "<ConstantForceField name=\"c\" indices=\"0 62 5\" totalForce=\"0 3 0\"/>" + knife), true);
  Session whole, other;
  const std::string text = bar(implicit, hexes + knife);
  whole.loadText(text, "scene.xml"), other.loadText(text, "scene.xml");
  hashAt(whole, 9, true);
  other.restore(whole.checkpoint(), "it");
  EXPECT_EQ(other.simulation().edits().size(), whole.simulation().edits().size());
  whole.simulation().reset(), other.simulation().reset();
  EXPECT_EQ(other.simulation().edits().size(), whole.simulation().edits().size());
  EXPECT_EQ(hashAt(other, 9), hashAt(whole, 9)) << "reset() keeps what was set";
}

class OnTwoThreads : public ::testing::Test {
 protected:
  void TearDown() override { setThreads(1); }
};

TEST_F(OnTwoThreads, ARunGoesOnWithTheSameBits) {
  const std::string text = bar(implicit, hexes + knife);
  Session whole, other;
  whole.loadText(text, "scene.xml"), other.loadText(text, "scene.xml");
  hashAt(whole, 5);
  const Checkpoint checkpoint = whole.checkpoint();
  const std::uint64_t last = hashAt(whole, 12);
  setThreads(2);
  other.restore(checkpoint, "it");
  EXPECT_EQ(hashAt(other, 12), last);
  whole.restore(checkpoint, "it");
  EXPECT_EQ(hashAt(whole, 12), last) << "in the run itself, back to more cells";
}

TEST(ChangedCheckpoints, OneSessionGoesToAndFro) {
  Session session;
  session.loadText(bar(implicit, hexes + knife), "scene.xml");
  int told = 0;
  session.followMeshChanges([&told](const NodesNow&) { ++told; });
  const auto run = [&](long step) {
    session.run({.steps = step - session.simulation().steps()});
    return session.simulation().stateHash();
  };
  run(2);
  const Checkpoint first = session.checkpoint();
  const std::uint64_t six = run(6);
  const Checkpoint changed = session.checkpoint();
  const std::uint64_t ten = run(10);
  const int by_steps = told;
  EXPECT_GT(by_steps, 1);
  session.restore(first, "first");
  EXPECT_EQ(told, by_steps + 1) << "who holds on to states is told";
  EXPECT_EQ(session.simulation().states()[0]->size(), 63);
  EXPECT_FALSE(session.simulation().hasChangedMeshes());
  EXPECT_EQ(run(6), six);
  const Simulation* const before = session.simulation().first();
  session.restore(changed, "changed");
  EXPECT_EQ(session.simulation().first(), before);
  EXPECT_EQ(run(10), ten);
}

TEST(ChangedCheckpoints, AnotherSceneIsRefusedAndNothingChanges) {
  Session whole, other;
  whole.loadText(bar(implicit, hexes + knife), "scene.xml");
  hashAt(whole, 6);
  const Checkpoint checkpoint = whole.checkpoint();
  const auto refusal = [&](const std::string& text, const std::vector<Override>& overrides) -> std::string {
    other.loadText(text, "scene.xml", overrides);
    const std::uint64_t before = hashAt(other, 1);
    try {
      other.restore(checkpoint, "it");
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(other.simulation().stateHash(), before);
      EXPECT_EQ(other.simulation().steps(), 1);
      hashAt(other, 8);
      return error.what();
    }
    return "taken";
  };
  const std::string text = bar(implicit, hexes + knife);
  // what the change has written anew is not taken with other values, and what it has left alone is
  expectContains(refusal(text, {Override::parse("/body/grid.n=7 4 3")}), "other components or attributes than when its mesh changed");
  expectContains(refusal(bar(implicit, "<BoxROI name=\"more\" box=\"0 0 0 1 1 1\"/>" + hexes + knife), {}), "the node at scene.xml:1");
  EXPECT_EQ(refusal(text, {Override::parse("/body/fem.poissonRatio=0.45")}), "taken");
  EXPECT_EQ(findComponent(other.simulation().root(), "/body/fem")->data().find("poissonRatio")->print(), "0.45");
}

TEST(ChangedCheckpoints, ARefusedOneLeavesAChangedRunAsItWasAndTells) {
  Session whole, other;
  whole.loadText(bar(implicit, hexes + knife), "scene.xml", {Override::parse("/body/grid.n=7 4 3")});
  hashAt(whole, 6);
  other.loadText(bar(implicit, hexes + knife), "scene.xml");
  const State* drawn = nullptr;
  int told = 0;
  other.followMeshChanges([&](const NodesNow&) { ++told, drawn = other.simulation().states()[0]; });
  other.run({.steps = 6});
  const std::uint64_t before = other.simulation().stateHash();
  const int by_steps = told;
  EXPECT_THROW(other.restore(whole.checkpoint(), "it"), std::runtime_error);
  EXPECT_EQ(told, by_steps + 1) << "who holds on to states must take the new ones";
  EXPECT_EQ(drawn, other.simulation().states()[0]);
  EXPECT_EQ(other.simulation().stateHash(), before);
  EXPECT_EQ(other.simulation().steps(), 6);
  Session same;
  same.loadText(bar(implicit, hexes + knife), "scene.xml");
  const std::uint64_t end = hashAt(same, 12);
  other.run({.steps = 6});
  EXPECT_EQ(other.simulation().stateHash(), end);
}

/// A run of long steps goes on in short ones: times count on from there, as after a live change of dt, and what remembers the run
/// has a step forward.
TEST(ChangedCheckpoints, AnotherTimeStepCountsFromThere) {
  const auto text = [](double dt) {
    return fmt::format("<Node name=\"root\" dt=\"{}\" gravity=\"0 0 -1\"><EulerImplicitSolver/>"
                       "<SparseLDLSolver/>"
                       "<RegularGridTopology n=\"3 3 3\" min=\"0 0 0\" max=\"1 1 1\"/><MechanicalObject name=\"dofs\"/>"
                       "<DiagonalMass massDensity=\"1\"/>"
                       "<HexahedronHyperelasticityFEMForceField materialName=\"NeoHookean\" youngModulus=\"100\" poissonRatio=\"0.3\" "
                       "viscous=\"true\" ParameterAlpha=\"0.5\" ParameterTau=\"0.2\"/>"
                       "<HexahedronPorousForceField fluidFraction=\"0.5\" bulkModulus=\"1\" limitModulus=\"100\" permeability=\"1e-3\" "
                       "drainedIndices=\"0 1 2\"/><FixedProjectiveConstraint indices=\"0 1 2 3\"/></Node>",
                       dt);
  };
  Session whole, other;
  whole.loadText(text(0.1), "whole.xml"), other.loadText(text(0.01), "other.xml");
  for (int i = 0; i < 10; ++i) ASSERT_FALSE(whole.simulation().step().failed());
  const Checkpoint checkpoint = whole.checkpoint();
  other.restore(checkpoint, "it");
  whole.simulation().setAttribute("/", "dt", "0.01");
  for (int i = 1; i <= 5; ++i) {
    ASSERT_FALSE(whole.simulation().step().failed());
    ASSERT_FALSE(other.simulation().step().failed());
    EXPECT_NEAR(other.simulation().time(), 1 + 0.01 * i, 1e-12);
    EXPECT_LT(distance(other.simulation().systems()[0]->x, whole.simulation().systems()[0]->x), 1e-12) << i;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
