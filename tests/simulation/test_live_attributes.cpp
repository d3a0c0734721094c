// SPDX-License-Identifier: LGPL-2.1-or-later
// Attributes that change while a scene runs: each change does what its declaration promises, or is refused.
#include <gtest/gtest.h>

#include "tests/support/scene_fixture.h"
#include "tools/session/session.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

struct Beam {
  std::string integrator = "<EulerImplicitSolver/>", solver = "<SparseLDLSolver/>", method = "large", young = "5000",
              dt = "0.01", gravity = "0 -9.81 0", box = "-1 -1 -0.001 1 1 0.001";
  std::string text() const {
    return "<Node name=\"root\" dt=\"" + dt + "\" gravity=\"" + gravity + "\">" + integrator + solver +
           "<RegularGridTopology name=\"grid\" n=\"3 3 5\" min=\"0 0 0\" max=\"0.1 0.1 0.3\"/><MechanicalObject "
           "name=\"dofs\"/><UniformMass name=\"mass\" totalMass=\"1\"/><HexahedronFEMForceField name=\"fem\" "
           "youngModulus=\"" +
           young + "\" poissonRatio=\"0.3\" method=\"" + method + "\"/><BoxROI name=\"roi\" box=\"" + box +
           "\"/><FixedProjectiveConstraint name=\"fixed\" indices=\"@roi.indices\"/></Node>";
  }
};

void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) ASSERT_FALSE(simulation.step().diverged);
}

/// A run that changes `attribute` after five steps, and one of a scene that has the new value from the start, from the
/// same positions and velocities.
void expectSame(const std::string& before, const std::string& after, const std::string& path,
                const std::string& attribute, const std::string& value) {
  Simulation changed = simulationFromText(before);
  run(changed, 5);
  Simulation same = simulationFromText(before);
  run(same, 5);
  changed.setAttribute(path, attribute, value);
  Simulation fresh = simulationFromText(after);
  copy(changed.systems()[0]->x, fresh.systems()[0]->x), copy(changed.systems()[0]->v, fresh.systems()[0]->v);
  run(changed, 5), run(fresh, 5), run(same, 5);
  EXPECT_EQ(changed.stateHash(), fresh.stateHash()) << path << "." << attribute;
  EXPECT_NE(changed.stateHash(), same.stateHash()) << path << "." << attribute << " changes nothing";
}

const std::pair<const char*, const char*> solving[] = {
    {"<EulerImplicitSolver/>", "<SparseLDLSolver/>"},
    {"<EulerImplicitSolver/>", "<CGLinearSolver iterations=\"30\" tolerance=\"1e-8\"/>"},
    {"<EulerImplicitSolver/>",
     "<CGLinearSolver iterations=\"30\" tolerance=\"1e-8\" template=\"CompressedRowSparseMatrix\"/>"},
    {"<StaticSolver/>", "<SparseLDLSolver/>"},
    {"<RungeKutta4Solver/>", ""}};

TEST(LiveAttributes, YoungModulusRebuildsKernelsMatricesAndFactors) {
  for (const auto& [integrator, solver] : solving)
    for (const std::string method : {"small", "large"}) {
      SCOPED_TRACE(std::string(integrator) + solver + method);
      Beam beam;
      beam.integrator = integrator, beam.solver = solver, beam.method = method;
      if (beam.solver.empty()) beam.dt = "0.001";
      Beam stiffer = beam;
      stiffer.young = "9000";
      expectSame(beam.text(), stiffer.text(), "/fem", "youngModulus", "9000");
    }
}

TEST(LiveAttributes, GravityIsComputedAnew) {
  for (const auto& [integrator, solver] : solving) {
    SCOPED_TRACE(std::string(integrator) + solver);
    Beam beam;
    beam.integrator = integrator, beam.solver = solver;
    if (beam.solver.empty()) beam.dt = "0.001";
    Beam turned = beam;
    turned.gravity = "3 0 0";
    expectSame(beam.text(), turned.text(), "/", "gravity", "3 0 0");
    turned.gravity = "0 0 0";
    expectSame(beam.text(), turned.text(), "/", "gravity", "0 0 0");
  }
}

TEST(LiveAttributes, TheTimeStepChangesAndTimeGoesOn) {
  Beam beam, shorter;
  shorter.dt = "0.004";
  expectSame(beam.text(), shorter.text(), "/", "dt", "0.004");
  Simulation simulation = simulationFromText(beam.text());
  run(simulation, 5);
  simulation.setAttribute("/", "dt", "0.004");
  run(simulation, 3);
  EXPECT_EQ(simulation.time(), 5 * 0.01 + 3 * 0.004);
  EXPECT_EQ(simulation.steps(), 8);
}

TEST(LiveAttributes, WhatStepsReadThemselvesLeavesFactorsAlone) {
  Beam beam;
  beam.solver =
      "<PCGLinearSolver name=\"pcg\" iterations=\"200\" tolerance=\"1e-8\" preconditioner=\"@warp\"/>"
      "<PrecomputedWarpPreconditioner name=\"warp\"/><SparseLDLSolver name=\"factors\"/>";
  Simulation simulation = simulationFromText(beam.text());
  run(simulation, 2);
  for (const auto& [path, attribute, text] :
       {std::tuple{"/pcg", "tolerance", "1e-6"}, std::tuple{"/", "gravity", "0 3 0"}, std::tuple{"/", "dt", "0.004"}}) {
    simulation.setAttribute(path, attribute, text);
    run(simulation, 2);
    EXPECT_EQ(findComponent(simulation.root(), "/factors")->data().find("factorisations")->print(), "1") << attribute;
  }
  simulation.setAttribute("/fem", "youngModulus", "9000");
  run(simulation, 2);
  EXPECT_EQ(findComponent(simulation.root(), "/factors")->data().find("factorisations")->print(), "2");
}

/// Bodies that share nothing: b with these attributes of its integrator.
std::string twoBeams(const std::string& of_b = {}) {
  const std::string inside =
      "<RegularGridTopology n='3 3 5' min='0 0 0' max='0.1 0.1 0.3'/><MechanicalObject name='dofs'/>"
      "<UniformMass totalMass='1'/><HexahedronFEMForceField name='fem' youngModulus='5000' poissonRatio='0.3' "
      "method='large'/><FixedProjectiveConstraint indices='0 1 2 3 4 5 6 7 8'/></Node>";
  const std::string solvers =
      "<PCGLinearSolver name='pcg' iterations='200' tolerance='1e-8' preconditioner='@warp'/>"
      "<PrecomputedWarpPreconditioner name='warp'/><SparseLDLSolver name='factors'/>"
      "<NewtonRaphsonSolver name='newton' maxNbIterationsNewton='3'/>";
  return "<Node name='root' dt='0.01' gravity='0 -9.81 0'><Node name='a'><EulerImplicitSolver name='euler'/>" +
         solvers + inside + "<Node name='b'><EulerImplicitSolver name='euler' " + of_b + "/>" + solvers + inside +
         "</Node>";
}

TEST(LiveAttributes, AnEditOfOneBodyLeavesOthersAlone) {
  Simulation changed = simulationFromText(twoBeams()), same = simulationFromText(twoBeams());
  run(changed, 5), run(same, 5);
  for (const auto& [path, attribute, text] :
       {std::tuple{"/a/fem", "youngModulus", "9000"}, std::tuple{"/a", "gravity", "0 3 0"},
        std::tuple{"/a/euler", "rayleighMass", "0.1"}}) {
    changed.setAttribute(path, attribute, text);
    run(changed, 5), run(same, 5);
    const System &a = *changed.systems()[0], &b = *changed.systems()[1];
    EXPECT_GT(distance(a.x, same.systems()[0]->x), 1e-6) << attribute;
    EXPECT_EQ(distance(b.x, same.systems()[1]->x), 0) << attribute;
    EXPECT_EQ(distance(b.v, same.systems()[1]->v), 0) << attribute;
    EXPECT_EQ(findComponent(changed.root(), "/b/factors")->data().find("factorisations")->print(), "1") << attribute;
  }
}

TEST(LiveAttributes, AnEditReachesBodiesThatLinkToWhatItChanges) {
  const std::string text = twoBeams("rayleighMass='@../a/euler.rayleighMass'");
  Simulation changed = simulationFromText(text), same = simulationFromText(text);
  run(changed, 3), run(same, 3);
  changed.setAttribute("/a/euler", "rayleighMass", "0.5");
  run(changed, 3), run(same, 3);
  EXPECT_GT(distance(changed.systems()[1]->x, same.systems()[1]->x), 1e-6);
}

TEST(LiveAttributes, ARegionIsSelectedAnewForAllThatTakeItsNodes) {
  Beam beam, more;
  more.box = "-1 -1 -0.001 1 1 0.08";
  Simulation changed = simulationFromText(beam.text());
  run(changed, 5);
  changed.setAttribute("/roi", "box", more.box);
  Simulation fresh = simulationFromText(more.text());
  copy(changed.systems()[0]->x, fresh.systems()[0]->x), copy(changed.systems()[0]->v, fresh.systems()[0]->v);
  const Index newly_held = 9 + 4;
  const Vec3 place = changed.systems()[0]->x[newly_held];
  run(changed, 5), run(fresh, 5);
  EXPECT_EQ(changed.stateHash(), fresh.stateHash());
  EXPECT_EQ(Vec3(changed.systems()[0]->x[newly_held]), place) << "what is newly held stops where it is";
  // and free again
  changed.setAttribute("/roi", "box", beam.box);
  run(changed, 2);
  EXPECT_NE(Vec3(changed.systems()[0]->x[newly_held]), place);
}

TEST(LiveAttributes, ANodeHeldInPartBecomesHeldInAllAndFreeAgain) {
  for (const std::string solver : {"<SparseLDLSolver/>", "<CGLinearSolver iterations=\"60\" tolerance=\"1e-10\"/>"}) {
    SCOPED_TRACE(solver);
    constexpr Index node = 40;  // in the middle of the free end
    std::string text = Beam{.solver = solver, .gravity = "2 -9.81 1"}.text();
    text.insert(text.rfind("</Node>"),
                "<PartialFixedProjectiveConstraint indices=\"40\" fixedDirections=\"1 0 0\"/>"
                "<FixedProjectiveConstraint name=\"more\" indices=\"0\"/>");
    Simulation simulation = simulationFromText(text);
    System& system = *simulation.systems()[0];
    const Vec3 start = system.x[node];
    run(simulation, 5);
    const Vec3 before = system.x[node];
    EXPECT_EQ(before.x(), start.x());
    EXPECT_NE(before.y(), start.y());
    simulation.setAttribute("/more", "indices", "0 40");
    EXPECT_EQ(Vec3(system.v[node]), Vec3(Vec3::Zero()));
    run(simulation, 5);
    EXPECT_EQ(Vec3(system.x[node]), before);
    simulation.setAttribute("/more", "indices", "0");
    run(simulation, 5);
    EXPECT_EQ(system.x[node].x(), before.x());
    EXPECT_NE(system.x[node].y(), before.y());
    EXPECT_NE(system.x[node].z(), before.z());
  }
}

TEST(LiveAttributes, ARegionThatMovesTheEndsOfSpringsChangesThePatternOfTheMatrix) {
  for (const std::string solver :
       {"<SparseLDLSolver/>", "<EigenSimplicialLDLT/>",
        "<CGLinearSolver iterations=\"30\" tolerance=\"1e-8\" template=\"CompressedRowSparseMatrix\"/>"}) {
    SCOPED_TRACE(solver);
    const auto scene = [&solver](const std::string& box) {
      std::string text = Beam{.solver = solver}.text();
      return text.insert(text.rfind("</Node>"), "<BoxROI name=\"near\" box=\"" + box +
                                                    "\"/><BoxROI name=\"far\" box=\"-1 -1 0.29 1 1 0.31\"/>"
                                                    "<SpringForceField springsIndices1=\"@near.indices\" "
                                                    "springsIndices2=\"@far.indices\" lengths=\"0.1\"/>");
    };
    const std::string before = "-1 -1 0.14 1 1 0.16", after = "-1 -1 0.07 1 1 0.08";
    expectSame(scene(before), scene(after), "/near", "box", after);
  }
}

TEST(LiveAttributes, APressureChanges) {
  const auto scene = [](const std::string& pressure) {
    std::string text = Beam().text();
    return text.insert(text.rfind("</Node>"), "<SurfacePressureForceField name=\"load\" pressure=\"" + pressure +
                                                  "\" min=\"-1 -1 0.29\" max=\"1 1 0.31\"/>");
  };
  expectSame(scene("10"), scene("40"), "/load", "pressure", "40");
}

TEST(LiveAttributes, AMovementOfOtherNodesBeginsWhereTheyAre) {
  const auto scene = [](const std::string& nodes) {
    std::string text = Beam().text();
    return text.insert(text.rfind("</Node>"), "<LinearMovementProjectiveConstraint name=\"hand\" indices=\"" + nodes +
                                                  "\" keyTimes=\"0 1\" movements=\"0 0 0  0.1 0 0\"/>");
  };
  Simulation simulation = simulationFromText(scene("40 44"));
  run(simulation, 5);
  const Vec3 before = simulation.systems()[0]->x[36];
  simulation.setAttribute("/hand", "indices", "36 38");
  run(simulation, 1);
  EXPECT_LT((Vec3(simulation.systems()[0]->x[36]) - before).norm(), 0.01) << "a body length away from where it was";
}

TEST(LiveAttributes, MemoryOfIntegratorsSurvivesAChange) {
  Beam beam;
  beam.integrator = "<BDFOdeSolver name=\"bdf\" order=\"2\"/>";
  Simulation changed = simulationFromText(beam.text()), same = simulationFromText(beam.text());
  run(changed, 5), run(same, 5);
  changed.setAttribute("/fem", "youngModulus", "5000");  // as it was
  run(changed, 5), run(same, 5);
  EXPECT_EQ(changed.stateHash(), same.stateHash());
}

TEST(LiveAttributes, ACheckpointHoldsTheChangesToo) {
  Beam beam;
  Simulation changed = simulationFromText(beam.text());
  run(changed, 3);
  const Archive before = changed.checkpoint();
  changed.setAttribute("/fem", "youngModulus", "9000");
  changed.setAttribute("/", "dt", "0.004");
  run(changed, 3);
  const Archive after = changed.checkpoint();
  run(changed, 3);
  Simulation restored = simulationFromText(beam.text());
  restored.restore(after);
  run(restored, 3);
  EXPECT_EQ(restored.stateHash(), changed.stateHash());
  EXPECT_EQ(restored.time(), changed.time());
  restored.restore(before);  // changes made since are taken back
  EXPECT_EQ(restored.dt(), 0.01);
  Simulation never = simulationFromText(beam.text());
  run(never, 6), run(restored, 3);
  EXPECT_EQ(restored.stateHash(), never.stateHash());
}

std::string refusal(Simulation& simulation, const std::string& path, const std::string& attribute,
                    const std::string& text) {
  try {
    simulation.setAttribute(path, attribute, text);
  } catch (const ComponentError& error) {
    return std::string(error.what()) + "|" + error.expected + "|" + error.suggestion;
  }
  return "nothing was refused";
}

TEST(LiveAttributes, WhatCannotChangeIsRefusedWithASentence) {
  Simulation simulation = simulationFromText(Beam().text()), same = simulationFromText(Beam().text());
  run(simulation, 3), run(same, 3);
  const std::tuple<const char*, const char*, const char*, const char*> cases[] = {
      {"/fem", "method", "small", "load the scene again with the new value"},
      {"/grid", "n", "3 3 6", "load the scene again"},
      {"/dofs", "position", "0 0 0", "load the scene again"},
      {"/roi", "indices", "1", "is computed by the component"},
      {"/fem", "youngModulos", "9000", "youngModulus"},
      {"/fme", "youngModulus", "9000", "/fem"},
      {"/fem", "youngModulus", "soft", "youngModulus"},
      {"/fem", "poissonRatio", "0.5", "range"},
      {"/fem", "youngModulus", "1000 2000", "has 2 values"},
      {"/fem", "youngModulus", "@roi.box", "link"},
      {"/", "dt", "0", "range"},
      {"/", "time", "0", "gravity or dt"},
      {"/roi", "box", "5 5 5 6 6 6", "the selection is empty"}};
  for (const auto& [path, attribute, text, sentence] : cases)
    EXPECT_NE(refusal(simulation, path, attribute, text).find(sentence), std::string::npos)
        << path << "." << attribute << "=" << text << ": " << refusal(simulation, path, attribute, text);
  run(simulation, 5), run(same, 5);
  EXPECT_EQ(simulation.stateHash(), same.stateHash()) << "a refused change left something behind";
}

TEST(LiveAttributes, WhatWasComputedBeforehandFollowsNoChange) {
  Beam beam;
  beam.integrator = "<CondensedStaticSolver name=\"condensed\"/>", beam.solver = "", beam.method = "small";
  Simulation simulation = simulationFromText(beam.text());
  run(simulation, 1);
  for (const auto& [path, attribute, text] :
       {std::tuple{"/fem", "youngModulus", "9000"}, std::tuple{"/", "gravity", "0 0 0"}})
    EXPECT_NE(refusal(simulation, path, attribute, text).find("has computed its matrix and loads beforehand"),
              std::string::npos);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
