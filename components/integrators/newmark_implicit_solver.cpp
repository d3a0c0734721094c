// SPDX-License-Identifier: LGPL-2.1-or-later
// NewmarkImplicitSolver: Newmark's family of 1959, one linear solve per step or Newton's method.
//
//   M a1 = F(x1, v1),   v1 = v0 + h ((1 - gamma) a0 + gamma a1),   x1 = x0 + h v0 + h^2 ((1/2 - beta) a0 + beta a1)
//
// with F = f + rK K v - rM M v as in EulerImplicitSolver. gamma = 1/2 is of second order, a larger one of first and
// damps; beta >= gamma/2 >= 1/4 is stable for every step. With beta = 1/4, gamma = 1/2 (the defaults) the mean
// acceleration is constant over the step: a linear motion keeps its energy. Solved for v1,
//
//   M (v1 - v0 - (1 - gamma) h a0) = gamma h F(x1, v1),
//   x1 = x0 + h v0 + h^2 (1/2 - beta/gamma) a0 + (beta h / gamma) (v1 - v0)
//
// The first a0 is M^-1 F(x0, v0); later ones are the a1 of the previous step, so that accelerations are continuous. If
// positions or velocities are changed from outside between steps, a0 is still that of the end of the last step. With
// undampedStart the first a0 is M^-1 f(x0, v0), as in SOFA: damping of an initial velocity starts one step later. With a
// contact that limits steps (BarrierContact), each a0 is recomputed as M^-1 F(x0, v0), at the cost of one more solve with the
// mass per step. The contact does not contribute to a0; in each step it has the force h f whose work is the change of its
// energy. Instead of a1 its contribution is f/gamma. vdamping multiplies v by exp(-h vdamping) after the step, and
// velocityThreshold stops slow nodes. An iterative solver begins with v1 = v0, so that a solve that ends early keeps v0; with
// fromZeroAcceleration it begins with a1 = 0, as SOFA's does. Where gamma = 1/2 and a force field's K changes or is not the
// exact derivative of its force, a step makes two linear solves: see TrapezoidalRuleSolver.
//
// With sleepDistance a body at rest is not computed, exactly until something changes; sleep.h has the rule.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <NewmarkImplicitSolver gamma="0.5" beta="0.25"/>
//   <CGLinearSolver iterations="50" tolerance="1e-9"/>
//   <MechanicalObject position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include <fmt/format.h>

#include <cmath>

#include "components/integrators/explicit_step.h"
#include "components/integrators/implicit_integrator.h"
#include "components/integrators/velocity_damping.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class NewmarkImplicitSolver final : public ImplicitIntegrator {
 public:
  void declare(DataTable& table) override;
  void init() override;
  void compile(System& system) override;
  StepReport step(System& system, const StepContext& context) override;
  void stepTaken(const StepContext& context) override;
  bool keepsEnergy() const override { return gamma_ <= 0.5; }  // above it the rule damps
  std::string describe() const override {
    return described(fmt::format("Newmark step, beta {:g}, gamma {:g}", beta_, gamma_));
  }
  void reset() override {
    started_ = false;
    ImplicitIntegrator::reset();
  }
  void serialize(Archive& archive) override {
    ImplicitIntegrator::serialize(archive);
    archive.value("started", started_);
    archive.rows("acceleration", a_);
    archive.list("momentum_rates", rates_);
  }

 private:
  void takeRates(const System& system);

  double gamma_ = 0.5, beta_ = 0.25;
  VelocityDamping velocity_damping_;
  Acceleration acceleration_;
  Vector force_;                         ///< [N], shape (independentRows())
  Vector a_, new_a_;                     ///< a0 and a1 [m/s^2], shape (independentRows())
  bool undamped_start_ = false, from_zero_ = false;
  bool started_ = false;                 ///< a_ is that of the state
  std::vector<Vec3> rates_, new_rates_;  ///< L' of turning bodies, which is stepped instead of w' [N m]
};

void NewmarkImplicitSolver::declare(DataTable& table) {
  table.add("gamma", gamma_)
      .recompiled()
      .help("weight of the new acceleration in the velocity")
      .unit("-")
      .min(0, false)
      .max(1);
  table.add("beta", beta_)
      .recompiled()
      .help("weight of the new acceleration in the position")
      .unit("-")
      .min(0, false)
      .max(0.5);
  implicit_.declareDamping(table);
  table.add("undampedStart", undamped_start_)
      .recompiled()
      .help("the first acceleration is that without rayleighMass and rayleighStiffness, as in SOFA");
  table.add("fromZeroAcceleration", from_zero_)
      .recompiled()
      .help(
          "the linear solve begins with a1 = 0 instead of v1 = v0, which matters to iterative solvers that end early; needs "
          "newtonIterations=\"1\"");
  velocity_damping_.declare(table);
  declareSolvers(table);
  sleep_.declare(table);
}

void NewmarkImplicitSolver::init() {
  if (gamma_ < 0.5)
    warn(fmt::format("gamma = {:g} adds energy at every step", gamma_), "gamma=\"0.5\" or more");
  else if (2 * beta_ < gamma_)
    warn(fmt::format("beta = {:g} is below gamma/2 = {:g}: the step is stable only when it is short enough", beta_,
                     gamma_ / 2),
         fmt::format("beta=\"{:g}\" or more", gamma_ / 2));
}

void NewmarkImplicitSolver::compile(System& system) {
  compileStep(system, gamma_ == 0.5);
  if (from_zero_ && !implicit_.solvesOnce()) throw ComponentError("fromZeroAcceleration is of one linear solve", "newtonIterations=\"1\"");
  acceleration_.compile(system, "the first step of Newmark's method");
  for (Vector* vector : {&force_, &a_, &new_a_}) vector->resize(system.independentRows());
  for (std::vector<Vec3>* list : {&rates_, &new_rates_}) list->assign(implicit_.bodies().count(), Vec3::Zero());
}

/// Of bodies with masses that follow them: these take a part of the torque, and L' = J a + w x J w is what is left.
void NewmarkImplicitSolver::takeRates(const System& system) {
  const TurningBodies& bodies = implicit_.bodies();
  for (std::size_t b = 0; b < rates_.size(); ++b) rates_[b] = bodies.times(b, system.x, a_[bodies.row(b)]);
  clear(force_);
  bodies.addGyroscopic(system.x, system.v, 1, force_);
  for (std::size_t b = 0; b < rates_.size(); ++b) rates_[b] += force_[bodies.row(b)];
}

StepReport NewmarkImplicitSolver::step(System& system, const StepContext& context) {
  if (sleep_.passesOver(context)) return {};
  if (!started_ || implicit_.isLimited()) {
    StepReport first;
    implicit_.wholeForce(context.t, force_, true, gamma_);
    if (undamped_start_ && !started_) copy(system.independent(system.f), force_);  // of which the whole force was made
    for (std::size_t b = 0; b < implicit_.bodies().count(); ++b) rates_[b] = implicit_.bodies().sum(b, force_);
    if (!acceleration_.solve(system.x, system.v, force_, a_, context.stop, first)) return first;
    if (system.hasCurvedInertia()) takeRates(system);
  }
  const double h = context.dt;
  ImplicitScheme scheme;
  scheme.weight = gamma_ * h;
  scheme.displacement = beta_ / gamma_ * h;
  scheme.drift = h;
  scheme.time = context.t_end;
  scheme.old_time = context.t;
  scheme.has_history = true;
  scheme.from_predictor = from_zero_;
  copy(a_, implicit_.velocity_predictor);
  scale((1 - gamma_) * h, implicit_.velocity_predictor);
  copy(a_, implicit_.position_predictor);
  scale(h * h * (0.5 - beta_ / gamma_), implicit_.position_predictor);
  for (std::size_t b = 0; b < rates_.size(); ++b) implicit_.momentum_predictor[b] = (1 - gamma_) * h * rates_[b];
  StepReport report = implicit_.solve(scheme, context.stop);
  if (report.failed()) return report;
  for (std::size_t b = 0; b < rates_.size(); ++b)
    new_rates_[b] =
        (implicit_.endMomenta()[b] - implicit_.startMomenta()[b]) / (gamma_ * h) - (1 - gamma_) / gamma_ * rates_[b];
  copy(a_, new_a_);
  xpay(implicit_.change(), -(1 - gamma_) * h, new_a_);
  scale(1 / (gamma_ * h), new_a_);
  velocity_damping_.apply(system, h);
  return sleep_.judged(report);
}

void NewmarkImplicitSolver::stepTaken(const StepContext& context) {
  if (sleep_.stepTaken(context.dt)) return clear(a_);
  std::swap(a_, new_a_);
  std::swap(rates_, new_rates_);
  started_ = true;
  implicit_.stepTaken();
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(newmark_implicit_solver) {
  factory.add<stroma::NewmarkImplicitSolver>("NewmarkImplicitSolver", "Newmark's method (beta, gamma)");
}
