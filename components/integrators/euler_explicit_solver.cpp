// SPDX-License-Identifier: LGPL-2.1-or-later
// EulerExplicitSolver: explicit Euler and its symplectic variant.
//
//   a = M^-1 f(x0, v0)
//   symplectic (the default):  v1 = v0 + h a,  x1 = x0 + h v1
//   otherwise:                 v1 = v0 + h a,  x1 = x0 + h v0
//
// a is projected onto the directions that constraints leave free. Both are of first order. The symplectic variant keeps
// the energy of an undamped body within a bound for ever as long as h w < 2, w the highest angular frequency of the
// mesh (about the speed of sound over the smallest height of an element); beyond that it diverges. The other variant
// gains energy at every step and is there for comparison. A diagonal mass is inverted once; a consistent one is solved
// for with the node's linear solver.
//
// Example:
// <Node name="root" dt="0.001" gravity="0 -9.81 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include "framework/scene/factory.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/newton.h"
#include "framework/simulation/system.h"

namespace stroma {
namespace {

class EulerExplicitSolver final : public Integrator {
 public:
  void declare(DataTable& table) override;
  void compile(System& system) override;
  StepReport step(System& system, const StepContext& context) override;
  std::string describe() const override;

 private:
  bool accelerate(System& system, StepReport& report);

  bool symplectic_ = true;
  Link<LinearSolver> solver_link_{"linear solver"};
  LinearSolver* solver_ = nullptr;    ///< null with a diagonal mass
  std::vector<double> inverse_mass_;  ///< [1/kg], shape (rows)
  Vector acceleration_, right_side_;
};

void EulerExplicitSolver::declare(DataTable& table) {
  table.add("symplectic", symplectic_).help("move the positions with the new velocity: keeps the energy bounded");
  table.addLink("linearSolver", solver_link_)
      .help(
          "solves for the acceleration when the mass is not diagonal; without it, the linear solver of the same node");
  table.addVisualOnly("threadSafeVisitor");
}

void EulerExplicitSolver::compile(System& system) {
  system.refuseRayleighFactors("an explicit step");
  acceleration_.resize(system.allRows());
  if (system.massIsDiagonal()) {
    inverse_mass_ = system.inverseLumpedMass();
    return;
  }
  system.requireMass();
  right_side_.resize(system.allRows());
  solver_ = system.linearSolver();
  if (!solver_)
    throw ComponentError(
        "the mass is not diagonal, so an explicit step needs a linear solver, and " + node().path() + " has none",
        "a linear solver in the same node, or a diagonal mass",
        "use DiagonalMass, or add <CGLinearSolver iterations=\"25\" tolerance=\"1e-9\"/>");
}

/// acceleration_ = projected M^-1 f; false when the solve for it failed.
bool EulerExplicitSolver::accelerate(System& system, StepReport& report) {
  const Rows a{acceleration_.rows().data, system.independentRows()};
  if (solver_) {
    const Rows b{right_side_.rows().data, a.count};
    copy(ConstRows{system.f.rows().data, a.count}, b);
    system.project(b);
    if (!solveOrShift(*solver_, system.matrix({.mass = 1}), b, a, report)) return false;
  } else {
    const double* __restrict f = system.f.rows().data;
    const double* __restrict inverse = inverse_mass_.data();
    double* __restrict out = a.data;
    for (Index i = 0; i < a.count; ++i)
      for (int l = 0; l < row_doubles; ++l) out[row_doubles * i + l] = f[row_doubles * i + l] * inverse[i];
  }
  system.project(a);
  return true;
}

StepReport EulerExplicitSolver::step(System& system, const StepContext& context) {
  system.beginStep(context);
  StepReport report;
  system.computeForce(system.x, system.v, system.f);
  if (!accelerate(system, report)) return report;
  const double h = context.dt, lag = symplectic_ ? 0 : h;
  const double* __restrict a = acceleration_.rows().data;
  double* __restrict v = system.v.rows().data;
  double* __restrict x = system.x.rows().data;
  const std::size_t count = std::size_t(system.independentRows()) * row_doubles;
#pragma omp simd
  for (std::size_t i = 0; i < count; ++i) {
    v[i] += h * a[i];
    x[i] += h * (v[i] - lag * a[i]);
  }
  system.applyMappings();
  return report;
}

std::string EulerExplicitSolver::describe() const {
  return std::string(symplectic_ ? "symplectic" : "explicit") + " Euler step: 1 force evaluation, " +
         (solver_ ? "1 linear solve with the mass" : "the mass inverted once");
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(euler_explicit_solver) {
  factory.add<stroma::EulerExplicitSolver>("EulerExplicitSolver", "explicit or symplectic Euler");
}
