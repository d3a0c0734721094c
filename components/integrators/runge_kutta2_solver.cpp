// SPDX-License-Identifier: LGPL-2.1-or-later
// RungeKutta2Solver: the explicit midpoint rule, of second order.
//
//   a = M^-1 f,   x_m = x0 + h/2 v0,   v_m = v0 + h/2 a(x0, v0)
//   x1 = x0 + h v_m,   v1 = v0 + h a(x_m, v_m)
//
// An undamped oscillator of angular frequency w grows by (h w)^4 / 8 per step: slow motions of a body hardly, the fastest ones
// quickly. A warning is printed if the fastest motion would grow by more than 1 % per step (h w > 0.53). For undamped bodies
// EulerExplicitSolver or CentralDifferenceSolver are stable at half the cost.
//
// Example:
// <Node name="root" dt="0.001" gravity="0 -9.81 0">
//   <RungeKutta2Solver/>
//   <MechanicalObject position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include "components/integrators/explicit_step.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class RungeKutta2Solver final : public ExplicitIntegrator {
  ExplicitScheme scheme() const override {
    return fromRungeKutta("the second-order Runge-Kutta method", {{}, {0.5}}, {0, 1});
  }
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(runge_kutta2_solver) {
  factory.add<stroma::RungeKutta2Solver>("RungeKutta2Solver", "explicit midpoint rule, second order");
}
