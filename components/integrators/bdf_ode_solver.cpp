// SPDX-License-Identifier: LGPL-2.1-or-later
// BDFOdeSolver: backward differentiation formulas of order 1 (backward Euler) and 2.
//
// With F = f + rK K v - rM M v as in EulerImplicitSolver, h the step, r its ratio to the step before, and
//
//   order 1:  rho = 0,                w = h
//   order 2:  rho = r^2 / (1 + 2 r),  w = h (1 + r) / (1 + 2 r)
//
//   x1 - x0 = rho (x0 - x_-1) + w v1,   M (v1 - v0) = rho M (v0 - v_-1) + w F(x1, v1)
//
// For equal steps rho = 1/3, w = 2h/3: (3 x1 - 4 x0 + x_-1) / 2 = h v1. Order 2 is A-stable and damps fast motions (slow ones
// by a fraction of order h^3, where backward Euler does so by one of order h). Its first step is a trapezoidal one, of order 2
// as well; firstStep = euler makes it one of order 1, as in SOFA. Where a force field's K is not the exact derivative of its
// force, order 2 makes two linear solves in a step; with one it would be of order 1: see TrapezoidalRuleSolver. The
// differences of the last step are kept, not its state, so that nodes moved from outside between steps keep a finite velocity.
//
// With startFrom = predicted, as in SOFA, forces and K of a single linear solve, and the first iterate of Newton's method, are
// those at x0 + h v0 and v0 instead of x0 and v0. SOFA then leaves a step as it is there where
// |rho M (v0 - v_-1) + w F| <= restBelow, in N s: small bodies do not fall. Here restBelow is 0 unless it is given.
//
// With sleepDistance a body at rest is not computed, exactly until something changes; sleep.h has the rule.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <BDFOdeSolver order="2" newtonSolver="@newton"/>
//   <NewtonRaphsonSolver name="newton"/>
//   <CGLinearSolver iterations="50" tolerance="1e-9"/>
//   <MechanicalObject position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include <fmt/format.h>

#include "components/integrators/implicit_integrator.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class BDFOdeSolver final : public ImplicitIntegrator, public FindsMultipliers {
 public:
  void declare(DataTable& table) override;
  void compile(System& system) override;
  StepReport step(System& system, const StepContext& context) override;
  void stepTaken(const StepContext& context) override;
  bool toleratesLaggedForces() const override { return order_ == 1; }
  std::string describe() const override { return described(fmt::format("BDF step of order {}", order_)); }
  void reset() override {
    last_step_ = 0;
    ImplicitIntegrator::reset();
  }
  void serialize(Archive& archive) override {
    ImplicitIntegrator::serialize(archive);
    archive.value("last_step", last_step_);
    archive.rows("way", way_);
    archive.rows("change", change_);
    archive.list("momentum_changes", momentum_changes_);
  }

 private:
  enum class FirstStep : int { trapezoidal, euler };
  enum class StartFrom : int { state, predicted };
  ImplicitScheme schemeOfOrder2(System& system, double h);
  void predict(System& system, ImplicitScheme& scheme);
  bool rests(System& system, const ImplicitScheme& scheme);

  int order_ = 1;
  FirstStep first_step_ = FirstStep::trapezoidal;
  StartFrom start_from_ = StartFrom::state;
  double rest_below_ = 0;
  Vector way_, change_;                 ///< x0 - x_-1 and v0 - v_-1, shape (independentRows())
  Vector new_way_;                      ///< x1 - x0 of the step just made
  Vector impulse_;                      ///< work space of rests()
  bool rested_ = false;                 ///< the step just made changed no velocity
  std::vector<Vec3> momentum_changes_;  ///< L0 - L_-1 of turning bodies, which is stepped instead of w
  double last_step_ = 0;                ///< their h; 0: there is no step before
};

void BDFOdeSolver::declare(DataTable& table) {
  table.add("order", order_).help("1 (backward Euler) or 2").unit("-").min(1).max(2);
  table.addChoice("firstStep", first_step_, {"trapezoidal", "euler"})
      .help("of order 2, which has no step before: trapezoidal is of order 2; euler is of order 1, as in SOFA");
  table.addChoice("startFrom", start_from_, {"state", "predicted"})
      .help("where a step is linearised, and Newton's method begins: state at its start, or predicted, x + h v, as in SOFA");
  table.add("restBelow", rest_below_)
      .help("with startFrom=\"predicted\": a step that lacks no larger impulse there ends there; 0: not used")
      .unit("N s")
      .min(0);
  implicit_.declareDamping(table);
  declareSolvers(table);
  implicit_.declareConditions(table);
  sleep_.declare(table);
}

void BDFOdeSolver::compile(System& system) {
  compileStep(system, order_ == 2);
  if (order_ == 2)
    for (Vector* vector : {&way_, &change_, &new_way_}) vector->resize(system.independentRows());
  impulse_.resize(system.independentRows());
  if (start_from_ == StartFrom::predicted && implicit_.bodies().anyTurns())
    throw ComponentError("startFrom=\"predicted\" of " + path() + " is not for frames whose inertia turns with them",
                         "startFrom=\"state\", or UniformMass turns=\"false\"", "startFrom=\"state\"");
  if (start_from_ == StartFrom::predicted && implicit_.isLimited())
    throw ComponentError("startFrom=\"predicted\" of " + path() + " moves bodies before it checks for contact",
                         "startFrom=\"state\" with contact that nothing passes", "startFrom=\"state\"");
  if (start_from_ == StartFrom::state && rest_below_ > 0)
    throw ComponentError("restBelow of " + path() + " is of steps that begin where velocities lead", "startFrom=\"predicted\" with it",
                         "startFrom=\"predicted\"");
  momentum_changes_.assign(implicit_.bodies().count(), Vec3::Zero());
}

static ImplicitScheme backwardEuler(double h) {
  ImplicitScheme scheme;
  scheme.weight = scheme.displacement = scheme.drift = h;
  return scheme;
}

ImplicitScheme BDFOdeSolver::schemeOfOrder2(System& system, double h) {
  ImplicitScheme scheme;
  if (last_step_ == 0) {
    if (first_step_ == FirstStep::euler) return backwardEuler(h);
    scheme.weight = scheme.old_weight = scheme.displacement = h / 2;
    scheme.drift = h;
    return scheme;
  }
  const double r = h / last_step_, rho = r * r / (1 + 2 * r), w = h * (1 + r) / (1 + 2 * r);
  scheme.weight = scheme.displacement = w;
  scheme.drift = h;
  scheme.has_history = true;
  copy(change_, implicit_.velocity_predictor);
  scale(rho, implicit_.velocity_predictor);
  copy(way_, implicit_.position_predictor);
  scale(rho, implicit_.position_predictor);
  axpy(w - h, system.independent(system.v), implicit_.position_predictor);
  for (std::size_t b = 0; b < momentum_changes_.size(); ++b)
    implicit_.momentum_predictor[b] = rho * momentum_changes_[b];
  return scheme;
}

/// The step goes on from the positions to which velocities lead.
void BDFOdeSolver::predict(System& system, ImplicitScheme& scheme) {
  system.motion().advance(scheme.drift, system.independent(system.v), system.independent(system.x));
  scheme.drift = 0;
}

/// The step ends where velocities lead, by SOFA's absolute threshold.
bool BDFOdeSolver::rests(System& system, const ImplicitScheme& scheme) {
  if (start_from_ != StartFrom::predicted || rest_below_ == 0) return false;
  const Rows lack = system.independent(impulse_);
  implicit_.wholeForce(scheme.time, lack, false, 1);
  scale(scheme.weight, lack);
  if (scheme.has_history) system.addMassProduct(implicit_.velocity_predictor, 1, lack);
  system.constraints().project(lack);
  return norm(lack) <= rest_below_;
}

StepReport BDFOdeSolver::step(System& system, const StepContext& context) {
  if (sleep_.passesOver(context)) return {};
  const double h = context.dt;
  ImplicitScheme scheme = order_ == 2 ? schemeOfOrder2(system, h) : backwardEuler(h);
  scheme.time = context.t_end;
  scheme.old_time = context.t;
  const ConstRows x = system.independent(system.x);
  if (order_ == 2) copy(x, new_way_);
  StepReport report;
  if (start_from_ == StartFrom::predicted) predict(system, scheme);
  rested_ = rests(system, scheme);
  if (!rested_) report = implicit_.solve(scheme, context.stop);
  if (order_ == 2 && !report.failed()) system.motion().difference(x, new_way_);
  return sleep_.judged(report);
}

void BDFOdeSolver::stepTaken(const StepContext& context) {
  if (sleep_.stepTaken(context.dt)) {
    clear(way_), clear(change_);
    if (order_ == 2) last_step_ = context.dt;
    return;
  }
  implicit_.stepTaken();
  if (order_ == 1) return;
  std::swap(way_, new_way_);
  rested_ ? clear(change_) : copy(implicit_.change(), change_);
  for (std::size_t b = 0; b < momentum_changes_.size(); ++b)
    momentum_changes_[b] = rested_ ? Vec3(Vec3::Zero()) : Vec3(implicit_.endMomenta()[b] - implicit_.startMomenta()[b]);
  last_step_ = context.dt;
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(bdf_ode_solver) {
  factory.add<stroma::BDFOdeSolver>("BDFOdeSolver", "backward differentiation formulas of order 1 and 2");
}
