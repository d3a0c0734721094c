// SPDX-License-Identifier: LGPL-2.1-or-later
// NewtonRaphsonSolver: the settings of Newton's method for the integrator of its node (or those that link to it), and
// how it ended.
//
// With R the residual of a step's equations and d = A^-1 R the Newton correction, A = -dR/du, an iteration makes the step u +=
// s d, where s comes from a line search. It has converged if one of these holds and its threshold is not zero:
//
//   |R| <= relativeInitialStoppingThreshold * the larger of |R_0| and the forces of the step, reactions included
//   |R| <= absoluteResidualStoppingThreshold
//   |R| <= relativeSuccessiveStoppingThreshold * |R| one iteration before
//   |dx| <= relativeEstimateDifferenceThreshold * the displacement of the step
//   |dx| <= absoluteEstimateDifferenceThreshold
//
// dx is the displacement of the whole correction, not of the shortened one. Names are SOFA's. Its defaults are one iteration,
// which is one linear solve without a check, one step of the line search, and 1e-5 for the first three thresholds, one of
// which has a unit and another of which is satisfied by any fast decrease. Here the defaults are 25 iterations, 40 steps, 1e-8
// for the first threshold and none for the others, so that a converged step is one whose forces balance. maxNbIterationsNewton
// = 1 still means one linear solve in a dynamic step.
//
// status is Undefined before the first step, then Converged, DivergedMaxIterations, DivergedLineSearch or
// DivergedLinearSolver. A step that has not converged leaves the best iterate, or with updateStateWhenDiverged="false"
// the state before the step; the run's summary counts such steps.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver newtonSolver="@newton"/>
//   <NewtonRaphsonSolver name="newton" maxNbIterationsNewton="10"/>
//   <CGLinearSolver iterations="50" tolerance="1e-9"/>
//   <MechanicalObject position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include "components/integrators/newton_solver.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class NewtonRaphsonSolver final : public NewtonSolver {
 public:
  void declare(DataTable& table) override;
  NewtonSettings settings() const override;
  void prepare(std::size_t values) override {
    graph_.reserve(values);
    status_.reserve(32);
  }
  void noteResult(const StepReport& report, const Newton& newton) override;
  void reset() override {
    status_ = "Undefined";
    graph_.clear();
  }

 private:
  NewtonSettings settings_;
  std::string status_ = "Undefined";
  std::vector<double> graph_;
  bool warn_line_search_ = true, warn_divergence_ = true;
};

void NewtonRaphsonSolver::declare(DataTable& table) {
  NewtonSettings& s = settings_;
  declareNewton(table, s,
                {.iterations = "maxNbIterationsNewton",
                 .relative_residual = "relativeInitialStoppingThreshold",
                 .absolute_residual = "absoluteResidualStoppingThreshold",
                 .relative_correction = "relativeEstimateDifferenceThreshold",
                 .absolute_correction = "absoluteEstimateDifferenceThreshold",
                 .residual = "|R|",
                 .unit = "N or N s"});
  table.add("relativeSuccessiveStoppingThreshold", s.successive_residual)
      .help("converged when |R| is below this times the one before; 0: not used")
      .unit("-")
      .min(0);
  table.add("maxNbIterationsLineSearch", s.line_search_iterations)
      .help("steps tried along a correction; 0: the whole correction is made untested")
      .unit("-")
      .min(0);
  table.add("lineSearchCoefficient", s.line_search_coefficient)
      .help("a step that is refused is shortened at least by this factor")
      .unit("-")
      .min(0, false)
      .max(1, false);
  table.add("updateStateWhenDiverged", s.keep_unconverged)
      .help("keep the best iterate of a step that has not converged, not the state before the step");
  table.add("warnWhenLineSearchFails", warn_line_search_).help("without effect: the summary counts such steps");
  table.add("warnWhenDiverge", warn_divergence_).help("without effect: the summary counts such steps");
  table.add("status", status_).help("how the last step ended").output();
  table.add("residualGraph", graph_).help("|R| of the last step's iterations").unit("N or N s").output();
}

NewtonSettings NewtonRaphsonSolver::settings() const {
  const NewtonSettings& s = settings_;
  const double largest = std::max(
      {s.relative_residual, s.absolute_residual, s.successive_residual, s.relative_correction, s.absolute_correction});
  if (largest <= 0)
    throw ComponentError("all thresholds of " + path() + " are zero, so no step ever converges",
                         "at least one above zero", "relativeInitialStoppingThreshold=\"1e-8\"");
  return s;
}

void NewtonRaphsonSolver::noteResult(const StepReport& report, const Newton& newton) {
  graph_.assign(newton.history().begin(), newton.history().end());
  const bool at_limit = report.newton_iterations == settings_.iterations;
  status_ = report.newton_converged && !report.diverged ? "Converged"
            : report.diverged                           ? "DivergedLinearSolver"
            : at_limit                                  ? "DivergedMaxIterations"
                                                        : "DivergedLineSearch";
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(newton_raphson_solver) {
  factory.add<stroma::NewtonRaphsonSolver>("NewtonRaphsonSolver", "settings and result of Newton's method");
}
