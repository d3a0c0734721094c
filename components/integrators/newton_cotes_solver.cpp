// SPDX-License-Identifier: LGPL-2.1-or-later
// NewtonCotesSolver: velocities and positions by closed Newton-Cotes quadrature of the accelerations over a step.
//
//   v1 = v0 + h sum_i w_i a(t_i),   t_i = t0 + i h / n,   i = 0 .. n
//
// with the weights of the closed formula on n + 1 points: degree n = 1, the trapezoid (1/2 1/2); 2, Simpson's
// (1/6 4/6 1/6); 3, Simpson's 3/8 (1/8 3/8 3/8 1/8); 4, Boole's (7/90 32/90 12/90 32/90 7/90). The accelerations at the
// points need positions and velocities there, each found explicitly from the points before:
//
//   1  x1 = x0 + h v0 + h^2/2 a0, then a1 and v1: velocity Verlet; order 2, symplectic, stable for h w <= 2
//   2  the classical Runge-Kutta method; order 4, h w <= 2.82        3  Kutta's 3/8 rule; order 4, h w <= 2.82
//   4  Butcher's method of order 5 with Boole's weights; two evaluations at one of the points, grows slowly undamped
//
// Loads that depend on time and nodes with a prescribed motion are taken at the time of each point, so that the order
// holds with them.
//
// Source: M. Nesme et al., "Physically realistic interactive simulation for biological soft tissues", 2005, section 4, says of
// Phymul that forces are integrated "between time t to time t+dt by a discrete integration scheme for the equation of motion
// (e.g. Newton-Cotes)", and that "the number of iterations depends on the integration scheme". It does not give the formulas.
// This component takes an iteration to be an evaluation of the forces within the step. The other interpretation, formulas over
// the last n steps, has parasitic solutions that do not decay (Milne's method is weakly unstable) and is not provided.
//
// Example:
// <Node name="root" dt="0.001" gravity="0 -9.81 0">
//   <NewtonCotesSolver degree="2"/>
//   <MechanicalObject position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include <fmt/format.h>

#include "components/integrators/explicit_step.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

ExplicitScheme velocityVerlet() {
  ExplicitScheme scheme;
  scheme.stages = {{0, {}, {}}, {1, {0.5}, {1}}};
  scheme.x = {0.5, 0};
  scheme.v = {0.5, 0.5};
  return scheme;
}

ExplicitScheme schemeOf(int degree) {
  if (degree == 1) return velocityVerlet();
  if (degree == 2) return fromRungeKutta({}, {{}, {0.5}, {0, 0.5}, {0, 0, 1}}, {1. / 6, 1. / 3, 1. / 3, 1. / 6});
  if (degree == 3) return fromRungeKutta({}, {{}, {1. / 3}, {-1. / 3, 1}, {1, -1, 1}}, {0.125, 0.375, 0.375, 0.125});
  return fromRungeKutta({},
                        {{},
                         {0.25},
                         {0.125, 0.125},
                         {0, -0.5, 1},
                         {3. / 16, 0, 0, 9. / 16},
                         {-3. / 7, 2. / 7, 12. / 7, -12. / 7, 8. / 7}},
                        {7. / 90, 0, 32. / 90, 12. / 90, 32. / 90, 7. / 90});
}

class NewtonCotesSolver final : public ExplicitIntegrator {
 public:
  void declare(DataTable& table) override {
    ExplicitIntegrator::declare(table);
    table.add("degree", degree_)
        .help("1: trapezoid, 2: Simpson's rule, 3: the 3/8 rule, 4: Boole's rule")
        .unit("-")
        .min(1)
        .max(4);
  }

 private:
  ExplicitScheme scheme() const override {
    ExplicitScheme scheme = schemeOf(degree_);
    scheme.name = fmt::format("the Newton-Cotes method of degree {}", degree_);
    return scheme;
  }
  int degree_ = 1;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(newton_cotes_solver) {
  factory.add<stroma::NewtonCotesSolver>("NewtonCotesSolver", "closed Newton-Cotes quadrature of the accelerations");
}
