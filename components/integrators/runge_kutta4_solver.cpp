// SPDX-License-Identifier: LGPL-2.1-or-later
// RungeKutta4Solver: the classical Runge-Kutta method, of fourth order.
//
//   a = M^-1 f;   (x, v)' = (v, a(t, x, v)) at t, twice at t + h/2 and at t + h, weighted 1/6, 1/3, 1/3, 1/6
//
// Stable for an undamped oscillator of angular frequency w while h w < 2 sqrt(2), whose amplitude it reduces by the fraction
// (h w)^6 / 144 per step. Four force evaluations per step pay off where accuracy matters. Time-dependent forces and prescribed
// motions are evaluated at the time of each stage: the order remains 4, also with jumps of the velocity between steps. With a
// non-diagonal mass, the inertia of accelerated prescribed nodes does not act on free nodes.
//
// Example:
// <Node name="root" dt="0.001" gravity="0 -9.81 0">
//   <RungeKutta4Solver/>
//   <MechanicalObject position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include "components/integrators/explicit_step.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class RungeKutta4Solver final : public ExplicitIntegrator {
  ExplicitScheme scheme() const override {
    return fromRungeKutta("the fourth-order Runge-Kutta method", {{}, {0.5}, {0, 0.5}, {0, 0, 1}},
                          {1. / 6, 1. / 3, 1. / 3, 1. / 6});
  }
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(runge_kutta4_solver) {
  factory.add<stroma::RungeKutta4Solver>("RungeKutta4Solver", "classical Runge-Kutta method, fourth order");
}
