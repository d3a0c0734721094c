// SPDX-License-Identifier: LGPL-2.1-or-later
// When implicit steps take the exact tangent for speed, and when they go back.
#include <fmt/format.h>

#include "components/integrators/exact_tangent.h"
#include "tests/integrators/bent_bar.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string bar(const std::string& elasticity, const std::string& integrator = "") {
  return bentBar(0.5, 1, R"(newtonIterations="60" newtonTolerance="1e-9" )" + integrator, "<SparseLDLSolver/>",
                 R"(poissonRatio="0.3" )" + elasticity);
}

std::string countOf(const Simulation& simulation) {
  return findComponent(simulation.root(), "/EulerImplicitSolver")->data().find("exactTangentSteps")->print();
}

double largestDifference(Simulation& a, Simulation& b) {
  double largest = 0;
  const Vector &x = a.systems()[0]->x, &y = b.systems()[0]->x;
  for (Index i = 0; i < x.count(); ++i) largest = std::max(largest, (x[i] - y[i]).norm());
  return largest;
}

/// A step that gets on by small factors goes on with the exact tangent, and the next one begins with it; a named tangent stays.
/// With a damping by the stiffness, which is a force, none does: stresses that turn are then added to the tangent.
TEST(ExactTangentOfSteps, ASlowStepGoesOnWithIt) {
  Simulation open = simulationFromText(bar("method='svd'")), named = simulationFromText(bar("method='svd' tangent='warped'"));
  int found = 0, slow = 0;
  for (int step = 0; step < 3; ++step) {
    const StepReport a = open.step(), b = named.step();
    ASSERT_TRUE(a.newton_converged && b.newton_converged) << a.reason << b.reason;
    found += a.newton_iterations, slow += b.newton_iterations;
    EXPECT_LT(largestDifference(open, named), 1e-6) << "step " << step;
    if (step == 0) {
      EXPECT_GT(b.newton_iterations, 14) << "the approximate tangent is good enough: nothing was tested";
      EXPECT_EQ(countOf(open), "1");
      EXPECT_TRUE(open.systems()[0]->forceFields()[0]->traits().exact_tangent);
    }
  }
  EXPECT_LT(found, slow * 2 / 3);
  EXPECT_EQ(countOf(named), "0");

  Simulation damped = simulationFromText(bar("method='svd'", "rayleighStiffness='0.001'")),
             as_named = simulationFromText(bar("method='svd' tangent='warped'", "rayleighStiffness='0.001'"));
  found = slow = 0;
  for (int step = 0; step < 3; ++step) {
    const StepReport a = damped.step(), b = as_named.step();
    ASSERT_TRUE(a.newton_converged && b.newton_converged) << a.reason << b.reason;
    found += a.newton_iterations, slow += b.newton_iterations;
    EXPECT_LT(largestDifference(damped, as_named), 1e-6) << "step " << step;
  }
  EXPECT_LT(found, slow / 2);
  EXPECT_EQ(countOf(damped), "0");
}

/// The bits are the same in a run that is taken up again.
TEST(ExactTangentOfSteps, ACheckpointKnowsIt) {
  Simulation whole = simulationFromText(bar("method='svd'")), later = simulationFromText(bar("method='svd'"));
  whole.step();
  later.restore(whole.checkpoint().readable());
  for (int step = 0; step < 3; ++step) {
    EXPECT_EQ(whole.step().newton_iterations, later.step().newton_iterations);
    EXPECT_EQ(whole.stateHash(), later.stateHash());
  }
}

/// Where a step with it takes more iterations than it is worth, the next one begins without; the second time it stays so.
TEST(ExactTangentOfSteps, WhatIsTooDearIsLeft) {
  Simulation simulation = simulationFromText(bar("method='svd'"));
  System& system = *simulation.systems()[0];
  const auto isExact = [&] { return system.forceFields()[0]->traits().exact_tangent; };
  ExactTangent exact;
  for (const bool is_first : {true, false}) {
    exact.choose(system);
    EXPECT_FALSE(exact.isOn());
    ASSERT_TRUE(exact.mayBeFaster(system));
    ASSERT_TRUE(exact.beginForSpeed(system));
    exact.limitIterations(5);
    exact.endStep(true);
    exact.stepTaken();
    exact.choose(system);
    EXPECT_TRUE(exact.isOn() && isExact()) << "steps begin with what helped";
    EXPECT_FALSE(exact.isTooDear(5));
    ASSERT_TRUE(exact.isTooDear(6));
    exact.letGo();
    exact.endStep(true);
    exact.stepTaken();
    exact.choose(system);
    EXPECT_FALSE(exact.isOn() || isExact());
    EXPECT_EQ(exact.mayBeFaster(system), is_first);
  }
  exact.reset();
  EXPECT_TRUE(exact.mayBeFaster(system));
  ASSERT_TRUE(exact.begin(system));
  EXPECT_FALSE(exact.isTooDear(1000)) << "the other one failed";
  exact.end();
}

/// Beside a pressure whose exact tangent is not symmetric: a solver that takes symmetric ones only, and a solve that is only slow,
/// have that of the corotational field.
TEST(ExactTangentOfSteps, FieldsThatNoSolverTakesLeaveTheOthers) {
  for (const std::string solver : {"CGLinearSolver", "SparseLDLSolver"})
    for (const bool for_speed : {false, true}) {
      Simulation simulation = simulationFromText(
          R"(<Node name="root" gravity="0 0 0"><StaticSolver/><)" + solver + R"(/><MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1"
  tetrahedra="0 1 2 3" triangles="1 2 3"/><MechanicalObject/><UniformMass totalMass="1"/><TetrahedronFEMForceField method="svd"
  youngModulus="1000" poissonRatio="0.3"/><FixedProjectiveConstraint indices="0"/><SurfacePressureForceField triangleIndices="0"
  pressure="1"/></Node>)");
      System& system = *simulation.systems()[0];
      ExactTangent exact;
      ASSERT_TRUE(for_speed ? exact.beginForSpeed(system) : exact.begin(system)) << solver;
      int of_elasticity = 0, of_pressure = 0;
      for (const ForceField* field : system.forceFields())
        (field->data().find("method") ? of_elasticity : of_pressure) += field->traits().exact_tangent;
      EXPECT_EQ(of_elasticity, 1);
      EXPECT_EQ(of_pressure, solver == "SparseLDLSolver" && !for_speed ? 1 : 0) << solver;
      exact.end();
      for (const ForceField* field : system.forceFields()) EXPECT_FALSE(field->traits().exact_tangent);
    }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
