// SPDX-License-Identifier: LGPL-2.1-or-later
// EulerImplicitSolver: backward Euler and its trapezoidal variant, linearised once per step or solved by Newton's method.
//
// With h the time step, K = df/dx, C = df/dv, rM and rK the Rayleigh factors (the solver's plus each mass's and force
// field's own) and F(x, v) = f(x, v) + rK K v - rM M v the whole force, a step finds v1 = v0 + dv from
//
//   M dv = h (theta F(x1, v1) + (1 - theta) F(x0, v0)),   x1 = x0 + h (theta v1 + (1 - theta) v0)
//
// with theta = 1 (backward Euler: first order, damps) or, with trapezoidalScheme, theta = 1/2 (second order, damps
// nothing). Linearised at (x0, v0), after Baraff and Witkin 1998:
//
//   [(1 + theta h rM) M - theta h C - theta h (theta h + rK) K] dv = h (f + (theta h + rK) K v0 - rM M v0)
//
// which is SOFA's scheme. Where a K is not the exact derivative of f, trapezoidalScheme makes a second solve: see
// TrapezoidalRuleSolver. dv is projected onto the directions that constraints leave free. With newtonIterations > 1
// the equations themselves are solved, starting from x0: the first Newton iteration is the linear solve above. K in the
// damping rK K v is the one at x1 (and at x0 for the old part), because with that of x0 alone the trapezoidal rule
// would be of first order; its derivative is left out of the tangent. The line search runs on the incremental potential
//
//   1/2 (v - v0) M (v - v0) + U(x(v)) + theta h/2 v (rM M - rK K) v - (1 - theta) h F(x0, v0) v
//
// whenever all forces come from an energy, else on the work of the residual along the step. newtonTolerance is relative to the
// residual at the start of the step, or to the forces including reactions of fixed nodes if these are larger. With
// newtonForcing above 0 iterative linear solves are loose in early iterations (Eisenstat and Walker 1996); the stopping test
// of the step does not change. If convergence with the approximate tangent of a force field is slow, the solve continues with
// the exact one, provided that it is symmetric, rK is 0 and it pays off by the estimated costs. If rK is not 0, tetrahedra
// with method svd include the rotation of stresses from the second iteration on, which makes the tangent exact, except for rK
// K v. If a step with a prescribed motion fails, and newtonIterations is five or more, the motion is first spread by the
// tangent and then divided, as in StaticSolver.
//
// firstOrder moves an overdamped body: (M - theta h K) v = f + J^T l, x1 = x0 + h v; Rayleigh factors are not used. J^T l are
// the forces of Lagrangian constraints with which the conditions hold at x1. With allowMassless nodes may have no mass: M has
// zero rows, and backward Euler moves these nodes to force equilibrium at the end of a step. With the trapezoidal rule they
// would oscillate about it forever. Without stiffness the matrix is singular, and a direct solver reports it. vdamping
// multiplies v by exp(-h vdamping) after the positions have moved; velocityThreshold then stops slow nodes.
//
// With sleepDistance a body at rest is not computed, exactly until something changes; sleep.h has the rule.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver rayleighMass="0.1" newtonIterations="5"/>
//   <CGLinearSolver iterations="50" tolerance="1e-9"/>
//   <MechanicalObject position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include <cmath>

#include "components/integrators/implicit_integrator.h"
#include "components/integrators/velocity_damping.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class EulerImplicitSolver final : public ImplicitIntegrator, public FindsMultipliers {
 public:
  bool respectsStepLimits() const override { return implicit_.iterates() && !first_order_; }
  std::string howToRespectStepLimits() const override {
    return first_order_ ? "firstOrder=\"false\"" : ImplicitIntegrator::howToRespectStepLimits();
  }
  void declare(DataTable& table) override;
  void init() override;
  void compile(System& system) override;
  StepReport step(System& system, const StepContext& context) override;
  bool keepsEnergy() const override { return trapezoidal_ && !first_order_; }
  std::string describe() const override;

 private:
  StepReport firstOrderStep(System& system, const StepContext& context);

  VelocityDamping velocity_damping_;
  bool first_order_ = false, trapezoidal_ = false, by_new_velocity_ = false;
  double theta_ = 1;
  Vector right_side_;
};

void EulerImplicitSolver::declare(DataTable& table) {
  implicit_.declareDamping(table);
  velocity_damping_.declare(table);
  table.add("firstOrder", first_order_).help("overdamped motion: solve for the velocity, not for its change");
  table.add("trapezoidalScheme", trapezoidal_)
      .help("trapezoidal rule (second order, no damping) instead of backward Euler");
  table.add("moveByNewVelocity", by_new_velocity_)
      .help("with trapezoidalScheme: positions move by h times the new velocity, as in SOFA, with first order");
  table.add("allowMassless", implicit_.allows_massless)
      .help("nodes without mass are moved by stiffness alone instead of being an error; not with trapezoidalScheme");
  table.add("ownInMatrix", implicit_.own_in_matrix)
      .help("rayleighStiffness of force fields and rayleighMass of masses are in the matrix only and not in the forces, as in SOFA: "
            "they resist changes of velocity");
  table.add("oneRound", implicit_.one_round)
      .help("forces of Lagrangian constraints have the directions of the motion without them, as in SOFA, and not those of the "
            "end of the step; with one linear solve per step");
  declareSolvers(table);
  implicit_.declareConditions(table);
  sleep_.declare(table);
  for (const char* name : {"solveConstraint", "threadSafeVisitor", "computeResidual"}) table.addVisualOnly(name);
}

void EulerImplicitSolver::init() {
  theta_ = trapezoidal_ ? 0.5 : 1;
  if (trapezoidal_ && implicit_.allows_massless)
    throw ComponentError("nodes without mass would oscillate forever with the trapezoidal rule",
                         "trapezoidalScheme=\"false\", or no allowMassless");
  if (first_order_ && (implicit_.rayleigh_mass != 0 || implicit_.rayleigh_stiffness != 0 || velocity_damping_.rate != 0))
    warn("rayleighMass, rayleighStiffness and vdamping have no effect with firstOrder: there is no inertia to damp",
         "remove them");
}

void EulerImplicitSolver::compile(System& system) {
  implicit_.only_linear = first_order_;
  compileStep(system, trapezoidal_ && !first_order_ && !by_new_velocity_);
  const bool has_conditions = !system.actors().lagrangian_constraints.empty();
  if (has_conditions && implicit_.one_round && !implicit_.solvesOnce())
    warn("oneRound has no effect: with several linear solves in a step forces of constraint have the directions of its end",
         "newtonIterations=\"1\", or no oneRound");
  if (has_conditions && by_new_velocity_ && trapezoidal_ && implicit_.iterates())
    throw ComponentError("moveByNewVelocity is for one linear solve per step where there are Lagrangian constraints, and Newton's "
                         "method is asked for",
                         "newtonIterations=\"1\" or moveByNewVelocity=\"false\"");
  if (!first_order_) return;
  if (implicit_.iterates())
    throw ComponentError("firstOrder is solved by one linear solve per step, and Newton's method is asked for",
                         "newtonIterations=\"1\" with firstOrder");
  right_side_.resize(system.independentRows());
}

StepReport EulerImplicitSolver::step(System& system, const StepContext& context) {
  if (sleep_.passesOver(context)) return {};
  const double h = context.dt;
  ImplicitScheme scheme;
  scheme.weight = scheme.displacement = theta_ * h;
  scheme.old_weight = (1 - theta_) * h;
  scheme.drift = h;
  scheme.time = context.t_end;
  scheme.old_time = context.t;
  // the rule moves x by the mean of both velocities
  if (by_new_velocity_ && trapezoidal_) scheme.moved_after = (1 - theta_) * h;
  StepReport report = first_order_ ? firstOrderStep(system, context) : implicit_.solve(scheme, context.stop);
  if (report.failed()) return report;
  if (!first_order_) velocity_damping_.apply(system, h);
  return sleep_.judged(report);
}

StepReport EulerImplicitSolver::firstOrderStep(System& system, const StepContext& context) {
  const double h = context.dt;
  system.computeForce(system.x, system.v, system.f);
  copy(system.independent(system.f), right_side_);
  system.constraints().project(right_side_);
  implicit_.projectFree(context.t, context.t_end, right_side_);
  StepReport report;
  implicit_.beginConditions(h, 1);
  SystemMatrix& matrix = implicit_.whole(system.matrix().withFactors({.mass = 1, .stiffness = -theta_ * h}));
  const Rows velocity = system.independent(system.v);
  if (!solveOrShift(implicit_.linearSolver(), matrix, right_side_, velocity, {.stop = context.stop}, report, {.result = &system}))
    return report;
  system.constraints().project(velocity);
  system.motion().advance(h, velocity, system.x);
  copy(velocity, right_side_);
  implicit_.meetConditions(matrix, right_side_, context.stop, report);
  return report;
}

std::string EulerImplicitSolver::describe() const {
  if (first_order_) return "first-order implicit step, linearised once: 1 force evaluation, 1 linear solve" + sleep_.describe();
  return described(trapezoidal_ ? "trapezoidal step" : "backward Euler step");
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(euler_implicit_solver) {
  factory.add<stroma::EulerImplicitSolver>("EulerImplicitSolver",
                                           "backward Euler or trapezoidal rule, one linear solve or Newton");
}
