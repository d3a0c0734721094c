// SPDX-License-Identifier: LGPL-2.1-or-later
// What the plan and the summary of a run say of the ways in which linear systems are solved where a scene is silent.
#include <gtest/gtest.h>

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
  EXPECT_TRUE(says(plan.out, "preconditioned by block Jacobi, or by multigrid once that costs less")) << plan.out;
  const Finished run = stroma("run scene.xml -n 3 --no-record");
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_TRUE(says(run.out, "changed its choice in the run: preconditioned by multigrid: block Jacobi took")) << run.out;
}

TEST_F(RunChoices, WhatASceneNamesStays) {
  write("scene.xml", beam("<PCGLinearSolver preconditioner=\"block_jacobi\"/>"));
  EXPECT_FALSE(says(stroma("explain scene.xml").out, "preconditioned by"));
  const Finished run = stroma("run scene.xml -n 3 --no-record");
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_FALSE(says(run.out, "changed its choice")) << run.out;
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
