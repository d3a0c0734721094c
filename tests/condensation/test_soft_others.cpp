// SPDX-License-Identifier: LGPL-2.1-or-later
// Soft bodies beside condensed bodies: their matrices and linear solvers.
#include <fmt/format.h>

#include <algorithm>

#include "framework/algebra/linear_solver.h"
#include "framework/mechanics/state.h"
#include "framework/scene/factory.h"
#include "tests/condensation/bodies.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string uniform = "<UniformMass totalMass=\"0.02\"/>";
const std::string direct = "<SparseLDLSolver/>";
const std::string cells = "<HexahedronFEMForceField method=\"small\" youngModulus=\"5000\" poissonRatio=\"0.35\"/>";
const std::string contact =
    "<ConstraintContact mstate=\"@b/dofs\" topology=\"@b/mesh\" other=\"@s/dofs\" contactDistance=\"2e-4\" friction=\"0.3\"/>";
const std::string tie = "<BilateralLagrangianConstraint object1=\"@b/dofs\" object2=\"@s/dofs\" first_point=\"99\" second_point=\"0\"/>";

std::string block(const std::string& solver) {
  return "<Node name=\"b\">" + solver +
         "<RegularGridTopology name=\"mesh\" n=\"5 5 4\" min=\"0 0 0\" max=\"0.08 0.06 0.06\"/><MechanicalObject name=\"dofs\"/>"
         "<UniformMass totalMass=\"0.3\"/>" +
         cells + "<BoxROI name=\"held\" box=\"-1 -1 -1 1 1 0.001\"/><FixedProjectiveConstraint indices=\"@held.indices\"/></Node>";
}

/// 27 nodes.
std::string soft(const std::string& solver, const std::string& content) {
  return "<Node name=\"s\"><EulerImplicitSolver/>" + solver +
         "<RegularGridTopology name=\"mesh\" n=\"3 3 3\" min=\"0.03 0.02 0.0605\" max=\"0.05 0.04 0.0805\"/>"
         "<MechanicalObject name=\"dofs\"/>" +
         content + "</Node>";
}

std::string scene(const std::string& content, const std::string& solver = "", const std::string& gravity = "0 0 -9.81") {
  return "<Node name=\"root\" dt=\"0.005\" gravity=\"" + gravity + "\">" + solver + content + "</Node>";
}

const State& stateOf(const Simulation& simulation, const std::string& path) {
  const auto states = simulation.states();
  return **std::ranges::find_if(states, [&](const State* state) { return state->path() == path; });
}

void step(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.failed() || report.unsolved) << "step " << i << ": " << report.reason;
  }
}

/// The constraint on a node ends in the step after the checkpoint.
TEST(SoftOthers, ARunContinuesWhereAConstraintEnds) {
  for (const std::string& solver : {direct, std::string("<SparseLDLSolver precision=\"single\"/>"), std::string("<PCGLinearSolver/>"),
                                    std::string("<AutomaticLinearSolver/>")}) {
    SCOPED_TRACE(solver);
    const std::string ends = "<FixedProjectiveConstraint indices=\"26\" endTime=\"0.05\"/>";
    const std::string text = scene(block("<CondensedDynamicSolver/>") + soft(solver, uniform + cells + ends) + contact);
    Simulation whole = simulationFromText(text), at_once = simulationFromText(text), fresh = simulationFromText(text);
    step(whole, 10), step(at_once, 10);
    const auto mark = whole.checkpoint();
    at_once.restore(at_once.checkpoint()), fresh.restore(mark);
    step(whole, 5);
    const std::uint64_t expected = whole.stateHash();
    step(at_once, 5), step(fresh, 5);
    EXPECT_EQ(at_once.stateHash(), expected);
    EXPECT_EQ(fresh.stateHash(), expected);
    whole.restore(mark);
    step(whole, 5);
    EXPECT_EQ(whole.stateHash(), expected);
  }
}

TEST(SoftOthers, ALinearSolverAtItsLimitIsReported) {
  for (const bool rough : {true, false}) {
    const std::string solver = fmt::format("<CGLinearSolver iterations=\"{}\" tolerance=\"1e-12\" threshold=\"1e-30\"/>", rough ? 3 : 500);
    Simulation simulation = simulationFromText(scene(block("<CondensedDynamicSolver/>") + soft(solver, uniform + cells) + tie));
    const StepReport report = simulation.step();
    EXPECT_FALSE(report.failed()) << report.reason;
    EXPECT_EQ(report.linear_at_limit, rough);
    EXPECT_EQ(report.linear_converged, !rough);
    EXPECT_EQ(report.linear_stop, rough ? SolveStop::iteration_limit : SolveStop::converged);
    EXPECT_EQ(report.linear_residual > 1e-12, rough) << report.linear_residual;
    EXPECT_GT(report.linear_iterations, 3) << "of the free motion and of three columns";
  }
}

StopRequest asked;
bool has_stopped = false;

/// Is asked to stop in the solve for the columns.
class StoppingSolver final : public LinearSolver {
 public:
  void declare(DataTable&) override {}
  SolveReport solve(SystemMatrix&, ConstRows, Rows x, const SolveTerms&) override { return clear(x), SolveReport{}; }
  SolveReport solveAll(SystemMatrix&, std::span<const ConstRows> b, std::span<const Rows> x, const SolveTerms& terms) override {
    for (const Rows& each : x) clear(each);
    if (b.size() == 1) return {};
    asked.make();
    has_stopped = terms.stop.isStopAsked();
    return {.stop = has_stopped ? SolveStop::stopped : SolveStop::converged};
  }
  bool needsSymmetric() const override { return false; }
};

TEST(SoftOthers, AStopDuringTheirSolvesIsNoDivergence) {
  factory().add<StoppingSolver>("TestStoppingSolver", "test");
  Simulation simulation =
      simulationFromText(scene(block("<CondensedDynamicSolver/>") + soft("<TestStoppingSolver/>", uniform + cells) + tie));
  const StepReport report = simulation.step(StopToken(asked));
  EXPECT_TRUE(has_stopped);
  EXPECT_TRUE(report.stopped);
  EXPECT_FALSE(report.diverged) << report.reason;
}

/// Without stiffness the mass alone is the matrix.
TEST(SoftOthers, ASparseMassIsNotLumped) {
  for (const std::string lumping : {"false", "true"}) {
    SCOPED_TRACE(lumping);
    const std::string mass = "<MeshMatrixMass totalMass=\"0.02\" lumping=\"" + lumping + "\"/>";
    Simulation found = simulationFromText(scene(block("<CondensedDynamicSolver/>") + soft(direct, mass) + tie));
    Simulation expected = simulationFromText(
        scene(block("") + "<Node name=\"s\">" + soft("", mass).substr(soft("", mass).find("<RegularGrid")) + tie,
              "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-13\"/>" + direct));
    step(found, 10), step(expected, 10);
    const State &there = stateOf(found, "/s/dofs"), &here = stateOf(expected, "/s/dofs");
    for (Index i = 0; i < there.size(); ++i) EXPECT_LT((there.x()[i] - here.x()[i]).norm(), 1e-8) << i;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
