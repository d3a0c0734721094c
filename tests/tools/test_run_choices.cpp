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

/// Hundreds of iterations per step, which factors would save.
TEST_F(RunChoices, ANamedSolverThatIsFarFromTheBestIsInTheSummary) {
  write("scene.xml", beam("<CGLinearSolver name=\"cg\"/>"));
  const Finished run = stroma("run scene.xml -n 60 --no-record --json=end.json");
  EXPECT_EQ(run.code, 0) << run.err;
  const auto end = nlohmann::json::parse(readText(folder_ / "end.json"));
  EXPECT_TRUE(says(run.out, "s went into /cg, estimated at ")) << run.out;
  EXPECT_TRUE(says(run.out, " times what factors would take: without <CGLinearSolver> the run chooses the preconditioner\n")) << run.out;
  ASSERT_EQ(end.at("advice").size(), 1u);
  EXPECT_TRUE(says(run.out, end.at("advice")[0].get<std::string>())) << run.out;
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
