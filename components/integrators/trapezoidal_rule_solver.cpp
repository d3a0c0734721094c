// SPDX-License-Identifier: LGPL-2.1-or-later
// TrapezoidalRuleSolver: the trapezoidal rule, of second order and without numerical damping.
//
//   M (v1 - v0) = h/2 (F(x0, v0) + F(x1, v1)),   x1 = x0 + h/2 (v0 + v1)
//
// An oscillator of angular frequency w has the frequency (2/h) atan(w h/2) and conserves its energy. The same scheme as
// EulerImplicitSolver with trapezoidalScheme; F, the Rayleigh factors and Newton's method are described there. A step too
// large for the fastest motion does not damp it: it then oscillates with a period of two steps.
//
// The equations are nonlinear, and one linear solve gives the rule's order where K is the exact derivative of f. The stiffness
// of the rotated methods (polar, large, svd with tangent="warped") is an approximation: with one solve the rule is of first
// order and gains energy until the run explodes. A second solve with the force and the stiffness at the result of the first
// one restores the order: the energy of polar and svd then decreases slightly, that of large drifts by some per cent in 10,000
// steps. If K is exact and changes within a step, one solve keeps the order, but not the energy in long steps: fast motions
// only have the stiffness at the start of the step, and are not damped. A NeoHookean beam released under its weight exploded
// after 139 steps of a twentieth of its period. Newmark's rule with one solve uses the acceleration of the previous step
// instead of F(x0, v0), and did not, but covered only two thirds of the displacement. With two solves both have an error of 1
// %, and with Newton's method they are the same rule. If forces, mapped masses or constraints rotate rigid bodies, three are
// needed. The required number is chosen automatically, unless newtonIterations is set.
//
// With sleepDistance a body at rest is not computed, exactly until something changes; sleep.h has the rule.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <TrapezoidalRuleSolver newtonIterations="10"/>
//   <CGLinearSolver iterations="50" tolerance="1e-9"/>
//   <MechanicalObject position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include "components/integrators/implicit_integrator.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class TrapezoidalRuleSolver final : public ImplicitIntegrator, public FindsMultipliers {
 public:
  void declare(DataTable& table) override {
    implicit_.declareDamping(table);
    declareSolvers(table);
    implicit_.declareConditions(table);
    sleep_.declare(table);
  }
  void compile(System& system) override { compileStep(system, true); }
  StepReport step(System&, const StepContext& context) override {
    if (sleep_.passesOver(context)) return {};
    ImplicitScheme scheme;
    scheme.weight = scheme.old_weight = scheme.displacement = context.dt / 2;
    scheme.drift = context.dt;
    scheme.time = context.t_end;
    scheme.old_time = context.t;
    return sleep_.judged(implicit_.solve(scheme, context.stop));
  }
  bool keepsEnergy() const override { return true; }
  std::string describe() const override { return described("trapezoidal step"); }
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(trapezoidal_rule_solver) {
  factory.add<stroma::TrapezoidalRuleSolver>("TrapezoidalRuleSolver", "trapezoidal rule: second order, no damping");
}
