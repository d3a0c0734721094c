// SPDX-License-Identifier: LGPL-2.1-or-later
// What the plan and the summary of a run say of the ways in which linear systems are solved where a scene is silent.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "tests/integrators/bent_bar.h"
#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A stiff slender beam of 2,989 nodes in long implicit steps: block Jacobi takes hundreds of iterations.
std::string beam(const std::string& solver) {
  return "<Node name=\"root\" dt=\"0.1\" gravity=\"0 -9.81 0\"><EulerImplicitSolver/>" + solver +
         R"(<RegularGridTopology name="grid" n="61 7 7" min="0 0 0" max="0.6 0.06 0.06"/>
  <MechanicalObject/><UniformMass totalMass="2"/>
  <HexahedronFEMForceField method="small" youngModulus="1e8" poissonRatio="0.3"/>
  <BoxROI name="held" box="-1 -1 -1 0.001 1 1"/><FixedProjectiveConstraint indices="@held.indices"/></Node>)";
}
bool says(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

class RunChoices : public CommandTest {};

TEST_F(RunChoices, AChangedPreconditionerIsInThePlanAndInTheSummary) {
  write("scene.xml", beam(""));
  const Finished plan = stroma("explain scene.xml");
  EXPECT_TRUE(says(plan.out, "preconditioned by block Jacobi, or by multigrid or factors once these cost less")) << plan.out;
  const Finished run = stroma("run scene.xml -n 10 --no-record");
  EXPECT_EQ(run.code, 0) << run.err;
  // to which of the others is the model's
  EXPECT_TRUE(says(run.out, "changed its choice in the run: ") && says(run.out, ": block Jacobi took")) << run.out;
}

TEST_F(RunChoices, WhatASceneNamesStays) {
  write("scene.xml", beam("<PCGLinearSolver preconditioner=\"block_jacobi\"/>"));
  EXPECT_FALSE(says(stroma("explain scene.xml").out, "preconditioned by"));
  const Finished run = stroma("run scene.xml -n 10 --no-record");
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_FALSE(says(run.out, "changed its choice")) << run.out;
}

TEST_F(RunChoices, ThreadsAreInThePlanWithTheirReason) {
  write("scene.xml", beam(""));
  const std::string explain = "'" STROMA_COMMAND "' explain scene.xml";
  const auto plan = [&](const std::string& before, const std::string& after = "") {
    return shell("env " + before + " " + explain + after);
  };
  const std::string chosen = plan("-u STROMA_THREADS").out;
  EXPECT_TRUE(says(chosen, "threads: 1, because the system has 2989 independent nodes; a second thread pays from 8000 on\n")) << chosen;
  EXPECT_TRUE(says(plan("STROMA_THREADS=3").out, "threads: 3\n"));
  EXPECT_TRUE(says(plan("STROMA_THREADS=3", " --threads 2").out, "threads: 2\n"));
  for (const char* wrong : {"0", "1025", "two", "2x"}) {
    const Finished run = plan(std::string("STROMA_THREADS=") + wrong);
    EXPECT_EQ(run.code, 2);
    EXPECT_TRUE(says(run.err, std::string("STROMA_THREADS is '") + wrong + "': expected 1 to 1024")) << run.err;
  }
}

/// A bar that bends far takes the exact tangent for speed: the summary names the force field that has it.
TEST_F(RunChoices, AnExactTangentThatWasTakenIsInTheSummaryWithItsForceField) {
  const std::string integrator = R"(newtonIterations="60" newtonTolerance="1e-9")";
  write("scene.xml", bentBar(0.5, 1, integrator, "<SparseLDLSolver/>", R"(poissonRatio="0.3" method="svd" name="fem")"));
  const Finished run = stroma("run scene.xml -n 1 --no-record");
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_TRUE(says(run.out, "with the approximate tangent of /cells/fem and went on with the exact one")) << run.out;
}

/// Nodes that springs hold, and a solver that a scene names, to which a test gives its time.
std::string heldNodes(const std::string& integrator, double seconds) {
  return "<Node name=\"root\" dt=\"0.1\" gravity=\"0 -9.81 0\"><" + integrator +
         "/><SluggishSolver name=\"slow\" seconds=\"" + std::to_string(seconds) +
         R"("/><RegularGridTopology name="grid" n="14 14 14" min="0 0 0" max="1 1 1"/>
  <MechanicalObject/><UniformMass totalMass="1"/><RestShapeSpringsForceField stiffness="100"/></Node>)";
}

/// Multigrid is estimated to solve 2,744 nodes in 0.04 s. The runs wait at the same time.
TEST_F(RunChoices, ANamedSolverThatIsFarFromTheBestIsInTheSummary) {
  const std::pair<const char*, const char*> integrators[] = {{"StaticSolver", "solver"},
                                                             {"EulerImplicitSolver", "preconditioner"}};
  const std::pair<const char*, double> kinds[] = {{"slow", 5.2}, {"quick", 0.5}};
  std::string runs;
  for (const auto& [integrator, chosen] : integrators)
    for (const auto& [kind, seconds] : kinds) {
      const std::string name = kind + std::string(integrator);
      write(name + ".xml", heldNodes(integrator, seconds));
      runs += "{ '" STROMA_COMMAND "' run " + name + ".xml -n 1 --no-record --module '" STROMA_TEST_MODULES
              "/fickle.so' --json=" + name + ".json >" + name + ".out 2>" + name + ".err; echo $? >" + name + ".code; } & ";
    }
  shell("( " + runs + "wait )");
  for (const auto& [integrator, chosen] : integrators) {
    const auto of = [&, name = integrator](const char* kind, const char* what) {
      return readText(folder_ / (kind + std::string(name) + what));
    };
    const std::string sentence = "s went into /slow, about ", rest = " times what multigrid is estimated to take: without "
                                                                    "<SluggishSolver> the run chooses its ";
    EXPECT_EQ(of("slow", ".code"), "0\n") << of("slow", ".err");
    const std::string slow = of("slow", ".out"), quick = of("quick", ".out");
    EXPECT_TRUE(says(slow, sentence)) << slow;
    EXPECT_TRUE(says(slow, rest + chosen + "\n")) << slow;
    EXPECT_EQ(of("quick", ".code"), "0\n") << of("quick", ".err");
    const auto phases = nlohmann::json::parse(of("quick", ".json")).at("phase_seconds");
    const double at_most = phases.at("solve").get<double>() + 2 * phases.at("product").get<double>() +
                           phases.at("assembly").get<double>();
    if (at_most < 4.9) {  // a machine may have had so much else to do
      EXPECT_FALSE(says(quick, sentence)) << at_most << " s are not worth a word: " << quick;
    }
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
