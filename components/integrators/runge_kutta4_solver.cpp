// SPDX-License-Identifier: LGPL-2.1-or-later
// RungeKutta4Solver: the classical Runge-Kutta method, of fourth order.
//
//   a = M^-1 f;   (x, v)' = (v, a(t, x, v)) at t, twice at t + h/2 and at t + h, weighted 1/6, 1/3, 1/3, 1/6
//
// Stable for an undamped oscillator of angular frequency w while h w < 2 sqrt(2), of which it takes a share of
// (h w)^6 / 144 of the amplitude per step. Four force evaluations per step: it pays where accuracy matters. Forces
// that depend on time, and nodes with a prescribed motion, are taken at the time of each evaluation: the order stays 4. A
// motion whose velocity jumps keeps it where the jumps lie between steps. With a mass that is not diagonal, free nodes do
// not feel the inertia of the acceleration of moved ones.
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
