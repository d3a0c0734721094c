// SPDX-License-Identifier: LGPL-2.1-or-later
// Porous bodies whose assembled matrix keeps the fluid in each element: forces of Lagrangian constraints on them, and steps of one solve.
#include "tests/hyperelasticity/porous_bodies.h"
#include "tests/support/scene_fixture.h"
#include "tools/checks/result_doubts.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A column of more than 500 nodes under a pressure, one node of its top held.
std::string heldColumn(const std::string& integrator, const std::string& solver, const std::string& hold) {
  Column column;
  column.kind = &porousKinds()[1], column.limit = 7e4, column.dt = 0.01, column.cells = 11, column.across = 7;
  column.load = 0.01;  // strains of 1e-5: one linear solve is enough
  std::string text = column.scene();
  const auto put = [&](const std::string& from, const std::string& to) { text.replace(text.find(from), from.size(), to); };
  put("<StaticSolver newton_iterations=\"200\" relative_residual_tolerance_threshold=\"1e-7\"/><SparseLDLSolver/>", integrator + solver);
  put("totalMass=\"1\"", "totalMass=\"1e-6\"");
  const std::string end = "</Node></Node>";
  return text.replace(text.rfind(end), end.size(), hold + end);
}

TEST(PorousConditions, ForcesAreThoseOfTheWholeMatrix) {
  constexpr int last = 12 * 49 - 1, below = 48;  // corners of the top and of the base, one above the other
  const std::string fixed = "<FixedProjectiveConstraint indices=\"" + std::to_string(last) + "\"/>";
  const std::string kept = "<DistanceLagrangianConstraint first_point=\"" + std::to_string(below) + "\" second_point=\"" +
                           std::to_string(last) + "\"/>";
  for (const std::string iterations : {"1", "20"}) {
    const std::string integrator = "<EulerImplicitSolver newtonIterations=\"" + iterations + "\"/>";
    const auto places = [&](const std::string& solver, const std::string& hold) {
      Simulation s = simulationFromText(heldColumn(integrator, solver, hold));
      const System& system = *s.systems()[0];
      EXPECT_GT(system.allRows(), 500);
      for (int n = 0; n < 2; ++n) {
        const StepReport report = s.step();
        EXPECT_TRUE(!report.failed() && report.newton_converged && report.constraints_converged)
            << report.reason << report.constraint_reason;
        EXPECT_LE(report.newton_iterations, 4) << solver << hold;
      }
      std::vector<double> z;
      for (Index i = 0; i < system.allRows(); ++i) z.push_back(system.x[i].z());
      return z;
    };
    const std::vector<double> reference = places("<SparseLDLSolver/>", fixed);
    const double settlement = 1 - *std::min_element(reference.end() - 49, reference.end());
    EXPECT_GT(settlement, 1e-6);
    EXPECT_EQ(reference.back(), 1);
    for (const std::string solver : {"<SparseLDLSolver/>", "<CGLinearSolver iterations=\"5000\" tolerance=\"1e-12\"/>"}) {
      const std::vector<double> found = places(solver, kept);
      double off = 0;
      for (std::size_t i = 0; i < found.size(); ++i) off = std::max(off, std::abs(found[i] - reference[i]));
      EXPECT_LT(off, 1e-4 * settlement) << iterations << " iterations, " << solver;
    }
  }
}

/// Terzaghi's column after a tenth of its time, under a load for which one solve is enough: with the fluid kept in each element the
/// steps lag behind the series, and that is doubted.
TEST(PorousSteps, OneSolveWithAnUndrainedTangentLagsAndIsDoubted) {
  constexpr double time = 0.1, dt = 0.01;
  struct Case {
    const char *tangent, *integrator;
    double limit;
    bool is_doubted;
  };
  for (const Case& each :
       {Case{"undrained", "<EulerImplicitSolver newtonIterations=\"1\"/>", 7e4, true},
        Case{"coupled", "<EulerImplicitSolver newtonIterations=\"1\"/>", 7e4, false},
        Case{"undrained", "<EulerImplicitSolver newtonIterations=\"2000\" newtonTolerance=\"1e-5\"/>", 2200, false}}) {
    SCOPED_TRACE(std::string(each.tangent) + each.integrator);
    const Column column{
        .limit = each.limit, .load = 0.01, .coupling = std::string("implicit\" tangent=\"") + each.tangent, .dt = dt};
    std::string text = column.scene();
    const auto put = [&](const std::string& from, const std::string& to) { text.replace(text.find(from), from.size(), to); };
    put("<StaticSolver newton_iterations=\"200\" relative_residual_tolerance_threshold=\"1e-7\"/>", each.integrator);
    put("totalMass=\"1\"", "totalMass=\"1e-6\"");
    Simulation simulation = simulationFromText(text);
    for (int i = 0; i < std::lround(time / dt); ++i) ASSERT_FALSE(simulation.step().failed());
    const double first = column.load / column.undrained(), last = column.load / column.drained();
    const double degree = (Column::settlement(simulation) - first) / (last - first), exact = consolidation(time);
    EXPECT_EQ(degree < 0.9 * exact, each.is_doubted) << degree << " of " << exact;
    std::string all;
    for (const std::string& sentence : doubtsOf(simulation)) all += sentence + "\n";
    EXPECT_EQ(all.find("keeps the fluid in each element") != all.npos, each.is_doubted) << all;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
