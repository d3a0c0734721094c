// SPDX-License-Identifier: LGPL-2.1-or-later
// Steps that are first made as if there were no Lagrangian constraints: one that finds no balance is no answer, and one that something
// is thrown out of leaves the next steps their forces of constraint.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/support/ground_spring.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Throws once, away from where it rests.
class Fuse final : public GroundSpring {
 public:
  void addForce(ConstRows x, ConstRows v, Rows f) override {
    if (!blown && std::abs(x[state().firstRow() + 1].x()) > 1e-9) throw blown = true, std::runtime_error("the fuse has blown");
    GroundSpring::addForce(x, v, f);
  }
  bool blown = false;
};

const bool registered = (registerGroundSpring(factory()), factory().add<Fuse>("TestFuse", "throws once"), true);

/// A force on a point with a spring to where it starts, which must not go farther than `stop` from a fixed point.
std::string pulled(const std::string& integrator, const std::string& spring, double force, double stop) {
  return fmt::format(
      R"(<Node name="root" dt="100" gravity="0 0 0">{}<SparseLDLSolver/><MechanicalObject position="-1 0 0 0 0 0"/>
           <UniformMass totalMass="1"/><FixedProjectiveConstraint indices="0"/><{}/>
           <ConstantForceField indices="1" forces="{} 0 0"/>
           <Node name="way"><MeshTopology edges="0 1"/><MechanicalObject template="Vec1"/><DistanceMapping/>
             <StopperLagrangianConstraint index="0" min="-0.5" max="{}"/></Node></Node>)",
      integrator, spring, force, stop);
}

const std::string integrators[] = {"<StaticSolver/>", "<EulerImplicitSolver newtonIterations=\"60\"/>"};

/// 1 N/m less 1 N/m^3 bear up to 0.385 N at 0.577 m.
TEST(FreeTries, WhatFindsNoBalanceIsTriedWithForcesOfConstraint) {
  for (const std::string& integrator : integrators) {
    SCOPED_TRACE(integrator);
    Simulation simulation = simulationFromText(pulled(integrator, "TestGroundSpring stiffness=\"1\" cubic=\"-1\"", 0.5, 0.57));
    const StepReport report = simulation.step();
    EXPECT_TRUE(report.newton_converged && report.constraints_converged) << report.reason << report.constraint_reason;
    EXPECT_NEAR(simulation.systems()[0]->x[1].x(), 0.57, 1e-9);
  }
}

TEST(FreeTries, OneThatThrowsLeavesTheNextItsForces) {
  for (const std::string& integrator : integrators) {
    SCOPED_TRACE(integrator);
    Simulation simulation = simulationFromText(pulled(integrator, "TestFuse stiffness=\"1\"", 0.5, 0.3));
    EXPECT_ANY_THROW(simulation.step());
    const StepReport report = simulation.step();
    EXPECT_TRUE(report.newton_converged && report.constraints_converged) << report.reason << report.constraint_reason;
    EXPECT_NEAR(simulation.systems()[0]->x[1].x(), 0.3, 1e-9);
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
