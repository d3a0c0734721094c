// SPDX-License-Identifier: LGPL-2.1-or-later
// EulerImplicitSolver: backward Euler and its trapezoidal variant, linearised once a step or solved by Newton's method.
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
// which is SOFA's scheme. dv is projected onto the directions that constraints leave free. With newtonIterations > 1
// the equations themselves are solved, the damping rK K v with the K of (x0, v0), starting from x0: the first Newton
// iteration is the linear solve above. The line search runs on the incremental potential
//
//   1/2 (v - v0) M (v - v0) + U(x(v)) + theta h/2 v (rM M - rK K) v - (1 - theta) h F(x0, v0) v
//
// whenever all forces come from an energy, else on the work of the residual along the step. newtonTolerance is relative
// to the residual where the step starts, or to the forces with the reactions of held nodes where these are larger.
//
// firstOrder moves an overdamped body: (M - theta h K) v = f, x1 = x0 + h v; Rayleigh factors do not enter.
// vdamping multiplies v by exp(-h vdamping) after the positions have moved.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver rayleighMass="0.1" newtonIterations="5"/>
//   <CGLinearSolver iterations="50" tolerance="1e-9"/>
//   <MechanicalObject position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "framework/scene/factory.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/newton.h"
#include "framework/simulation/system.h"

namespace stroma {
namespace {

/// The factors of one step.
struct Scheme {
  double h = 0, theta = 1, rayleigh_mass = 0, rayleigh_stiffness = 0;
  bool has_rayleigh_mass = false, has_rayleigh_stiffness = false;
  double forceWeight() const { return theta * h; }
  SystemMatrix& matrix(System& system) const {
    MatrixFactors factors;
    factors.mass = 1 + theta * h * rayleigh_mass;
    factors.stiffness = -theta * h * (theta * h + rayleigh_stiffness);
    factors.damping = factors.rayleigh_stiffness = -theta * h;
    factors.rayleigh_mass = theta * h;
    return system.matrix(factors);
  }
};

Rows independent(System& system, Rows all) { return {all.data, system.independentRows()}; }

/// The step as equations in v1, held in System::v and System::x. Vectors are those of the independent rows.
class ImplicitStep final : public NonlinearProblem {
 public:
  void compile(System& system) {
    system_ = &system;
    for (Vector* vector :
         {&x0_, &v0_, &base_, &difference_, &constant_, &work_, &damping_, &base_damping_, &slope_damping_})
      vector->resize(system.independentRows());
  }
  void begin(const Scheme& scheme);
  void residual(Rows out) override;
  SystemMatrix& tangent() override { return scheme_.matrix(*system_); }
  double energy() override;
  void keep() override;
  void move(double step, ConstRows direction) override;
  double displacementPerUnknown() const override { return scheme_.forceWeight(); }
  ConstRows positions() const override { return x(); }
  double travelled() const override;
  double loadScale() const override { return scheme_.forceWeight() * std::sqrt(dot(system_->f, system_->f)); }

 private:
  Rows x() const { return independent(*system_, system_->x); }
  Rows v() const { return independent(*system_, system_->v); }
  void stiffnessDamping(ConstRows velocity, Rows out);
  void placePositions();

  System* system_ = nullptr;
  Scheme scheme_;
  Vector x0_, v0_, base_;  ///< positions and velocities before the step; the velocity that move() starts from
  Vector constant_;        ///< (1 - theta) h F(x0, v0)
  Vector difference_, work_;
  Vector damping_, base_damping_, slope_damping_;  ///< rK K0 times v, base_ and the direction of move()
  bool direction_is_new_ = true;
};

/// out = rK K0 velocity, K0 the stiffness before the step. The force fields then hold K0.
void ImplicitStep::stiffnessDamping(ConstRows velocity, Rows out) {
  system_->computeForceAndProduct(x0_, v0_, velocity, scheme_.rayleigh_stiffness, 1, system_->f, out);
}

/// Starts from the positions before the step, where every energy is finite; directions that are held keep their
/// velocity.
void ImplicitStep::begin(const Scheme& scheme) {
  scheme_ = scheme;
  copy(x(), x0_);
  copy(v(), v0_);
  if (scheme.theta < 1) {
    const double weight = (1 - scheme.theta) * scheme.h;
    if (scheme.has_rayleigh_stiffness) {
      stiffnessDamping(v0_, constant_);
    } else {
      system_->computeForce(x0_, v0_, system_->f);
      clear(constant_);
    }
    axpy(1, independent(*system_, system_->f), constant_);
    scale(weight, constant_);
    if (scheme.has_rayleigh_mass) system_->addRayleighMassProduct(v0_, scheme.rayleigh_mass, -weight, constant_);
  }
  copy(v0_, work_);
  system_->project(work_);
  axpy(-1 / scheme.theta, work_, v());
  placePositions();
  if (scheme.has_rayleigh_stiffness) stiffnessDamping(v(), damping_);
}

void ImplicitStep::placePositions() {
  const double old_part = scheme_.h * (1 - scheme_.theta), new_part = scheme_.h * scheme_.theta;
  const double* __restrict x0 = x0_.rows().data;
  const double* __restrict v0 = v0_.rows().data;
  const double* __restrict v1 = v().data;
  double* __restrict x1 = x().data;
  const std::size_t count = x().doubles();
#pragma omp simd
  for (std::size_t i = 0; i < count; ++i) x1[i] = x0[i] + old_part * v0[i] + new_part * v1[i];
}

void ImplicitStep::keep() {
  copy(v(), base_);
  copy(damping_, base_damping_);
  direction_is_new_ = true;
}

void ImplicitStep::move(double step, ConstRows direction) {
  if (scheme_.has_rayleigh_stiffness) {
    if (direction_is_new_) stiffnessDamping(direction, slope_damping_);
    direction_is_new_ = false;
    copy(base_damping_, damping_);
    axpy(step, slope_damping_, damping_);
  }
  copy(base_, v());
  axpy(step, direction, v());
  placePositions();
}

void ImplicitStep::residual(Rows out) {
  System& s = *system_;
  const double weight = scheme_.forceWeight();
  s.computeForce(x(), v(), s.f);
  copy(independent(s, s.f), out);
  if (scheme_.has_rayleigh_stiffness) axpy(1, damping_, out);
  scale(weight, out);
  if (scheme_.has_rayleigh_mass) s.addRayleighMassProduct(v(), scheme_.rayleigh_mass, -weight, out);
  if (scheme_.theta < 1) axpy(1, constant_, out);
  copy(v(), difference_);
  axpy(-1, v0_, difference_);
  s.addMassProduct(difference_, -1, out);
  s.project(out);
}

double ImplicitStep::energy() {
  System& s = *system_;
  copy(v(), difference_);
  axpy(-1, v0_, difference_);
  clear(work_);
  s.addMassProduct(difference_, 0.5, work_);
  double sum = s.potentialEnergy(s.x) + dot(difference_, work_);
  if (scheme_.theta < 1) sum -= dot(constant_, v());
  if (scheme_.has_rayleigh_stiffness) sum -= 0.5 * scheme_.forceWeight() * dot(damping_, v());
  if (scheme_.has_rayleigh_mass) {
    clear(work_);
    s.addRayleighMassProduct(v(), scheme_.rayleigh_mass, 0.5 * scheme_.forceWeight(), work_);
    sum += dot(v(), work_);
  }
  return sum;
}

double ImplicitStep::travelled() const {
  double sum = 0;
  for (Index i = 0; i < x0_.count(); ++i) sum += (x()[i] - x0_[i]).squaredNorm();
  return std::sqrt(sum);
}

class EulerImplicitSolver final : public Integrator {
 public:
  void declare(DataTable& table) override;
  void init() override;
  void compile(System& system) override;
  StepReport step(System& system, const StepContext& context) override;
  std::string describe() const override;

 private:
  Scheme scheme(double h) const;
  StepReport linearStep(System& system, const Scheme& scheme);
  StepReport firstOrderStep(System& system, const Scheme& scheme);
  StepReport newtonStep(const Scheme& scheme);

  double rayleigh_stiffness_ = 0, rayleigh_mass_ = 0, velocity_damping_ = 0;
  bool first_order_ = false, trapezoidal_ = false;
  int newton_iterations_ = 1;
  double newton_tolerance_ = 1e-8;
  std::vector<double> graph_;
  Link<LinearSolver> solver_link_{"linear solver"};

  LinearSolver* solver_ = nullptr;
  bool has_rayleigh_mass_ = false, has_rayleigh_stiffness_ = false;
  Vector right_side_, change_;
  ImplicitStep problem_;
  Newton newton_;
};

void EulerImplicitSolver::declare(DataTable& table) {
  table.add("rayleighStiffness", rayleigh_stiffness_).help("damping proportional to the stiffness").unit("s").min(0);
  table.add("rayleighMass", rayleigh_mass_).help("damping proportional to the mass").unit("1/s").min(0);
  table.add("vdamping", velocity_damping_)
      .help("decay rate of the velocity, applied after the step")
      .unit("1/s")
      .min(0);
  table.add("firstOrder", first_order_).help("overdamped motion: solve for the velocity, not for its change");
  table.add("trapezoidalScheme", trapezoidal_)
      .help("trapezoidal rule (second order, no damping) instead of backward Euler");
  table.add("newtonIterations", newton_iterations_)
      .help("1: one linear solve a step, as SOFA; more: the step's equations are solved by Newton's method")
      .unit("-")
      .min(1);
  table.add("newtonTolerance", newton_tolerance_)
      .help("residual at which Newton's method ends, relative to the largest one of the simulation")
      .unit("-")
      .min(0, false);
  table.add("residualGraph", graph_).help("residuals of the last step's Newton iterations").unit("N s").output();
  table.addLink("linearSolver", solver_link_).help("the linear solver; without it, the one of the same node");
  for (const char* name : {"solveConstraint", "threadSafeVisitor", "computeResidual"}) table.addVisualOnly(name);
}

void EulerImplicitSolver::init() {
  if (first_order_ && newton_iterations_ > 1)
    throw ComponentError("firstOrder is solved by one linear solve a step, and newtonIterations asks for more",
                         "newtonIterations=\"1\" with firstOrder");
  if (first_order_ && (rayleigh_mass_ != 0 || rayleigh_stiffness_ != 0 || velocity_damping_ != 0))
    warn("rayleighMass, rayleighStiffness and vdamping have no effect with firstOrder: there is no inertia to damp",
         "remove them");
}

void EulerImplicitSolver::compile(System& system) {
  solver_ = system.linearSolver();
  if (!solver_)
    throw ComponentError("an implicit step needs a linear solver, and " + node().path() + " has none",
                         "a linear solver in the same node",
                         "add <CGLinearSolver iterations=\"25\" tolerance=\"1e-5\"/>");
  system.requireMass();
  has_rayleigh_mass_ = rayleigh_mass_ != 0;
  for (const Mass* mass : system.masses()) has_rayleigh_mass_ = has_rayleigh_mass_ || mass->rayleigh_mass != 0;
  has_rayleigh_stiffness_ = rayleigh_stiffness_ != 0;
  bool from_energy = system.isConservative();
  for (const ForceField* field : system.forceFields()) {
    has_rayleigh_stiffness_ = has_rayleigh_stiffness_ || field->rayleigh_stiffness != 0;
    from_energy = from_energy && !field->traits().velocity_dependent;
  }
  for (Vector* vector : {&right_side_, &change_}) vector->resize(system.allRows());
  if (newton_iterations_ == 1) return;
  newton_.settings.iterations = newton_iterations_;
  newton_.settings.relative_residual = newton_tolerance_;
  newton_.settings.use_energy = from_energy;
  newton_.compile(system.independentRows());
  problem_.compile(system);
  graph_.reserve(std::size_t(newton_iterations_) + 2);
}

Scheme EulerImplicitSolver::scheme(double h) const {
  Scheme scheme;
  scheme.h = h;
  scheme.theta = trapezoidal_ ? 0.5 : 1;
  scheme.rayleigh_mass = rayleigh_mass_;
  scheme.rayleigh_stiffness = rayleigh_stiffness_;
  scheme.has_rayleigh_mass = has_rayleigh_mass_;
  scheme.has_rayleigh_stiffness = has_rayleigh_stiffness_;
  return scheme;
}

StepReport EulerImplicitSolver::step(System& system, const StepContext& context) {
  system.beginStep(context);
  const Scheme now = scheme(context.dt);
  StepReport report = first_order_             ? firstOrderStep(system, now)
                      : newton_iterations_ > 1 ? newtonStep(now)
                                               : linearStep(system, now);
  if (report.diverged) return report;
  if (velocity_damping_ != 0 && !first_order_) scale(std::exp(-context.dt * velocity_damping_), system.v);
  system.applyMappings();
  return report;
}

StepReport EulerImplicitSolver::linearStep(System& system, const Scheme& scheme) {
  const double h = scheme.h;
  system.computeForceAndProduct(system.x, system.v, system.v, scheme.theta * h + rayleigh_stiffness_, 1, system.f,
                                right_side_);
  const Rows b = independent(system, right_side_), dv = independent(system, change_);
  {
    const double* __restrict f = system.f.rows().data;
    double* __restrict out = b.data;
#pragma omp simd
    for (std::size_t i = 0; i < b.doubles(); ++i) out[i] = h * (f[i] + out[i]);
  }
  if (has_rayleigh_mass_) system.addRayleighMassProduct(system.v, rayleigh_mass_, -h, b);
  system.project(b);

  StepReport report;
  if (!solveOrShift(*solver_, scheme.matrix(system), b, dv, report)) return report;
  system.project(dv);
  // v1 = v0 + dv and x1 = x0 + h (v1 - (1 - theta) dv) in one pass
  const double lag = 1 - scheme.theta;
  const double* __restrict change = dv.data;
  double* __restrict v = system.v.rows().data;
  double* __restrict x = system.x.rows().data;
#pragma omp simd
  for (std::size_t i = 0; i < dv.doubles(); ++i) {
    v[i] += change[i];
    x[i] += h * (v[i] - lag * change[i]);
  }
  return report;
}

StepReport EulerImplicitSolver::firstOrderStep(System& system, const Scheme& scheme) {
  system.computeForce(system.x, system.v, system.f);
  const Rows b = independent(system, right_side_), velocity = independent(system, change_);
  copy(ConstRows{system.f.rows().data, b.count}, b);
  system.project(b);
  StepReport report;
  SystemMatrix& matrix = system.matrix({.mass = 1, .stiffness = -scheme.theta * scheme.h});
  if (!solveOrShift(*solver_, matrix, b, velocity, report)) return report;
  system.project(velocity);
  copy(velocity, independent(system, system.v));
  axpy(scheme.h, velocity, independent(system, system.x));
  return report;
}

StepReport EulerImplicitSolver::newtonStep(const Scheme& scheme) {
  problem_.begin(scheme);
  StepReport report = newton_.solve(problem_, *solver_);
  graph_.assign(newton_.history().begin(), newton_.history().end());
  return report;
}

std::string EulerImplicitSolver::describe() const {
  std::string text = first_order_   ? "first-order implicit step"
                     : trapezoidal_ ? "trapezoidal step"
                                    : "backward Euler step";
  if (newton_iterations_ == 1) return text + ", linearised once: 1 force evaluation with its product, 1 linear solve";
  return text + fmt::format(", up to {} Newton iterations to a relative residual of {:g}, line search on {}",
                            newton_iterations_, newton_tolerance_,
                            newton_.settings.use_energy ? "the incremental potential" : "the work of the residual");
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(euler_implicit_solver) {
  factory.add<stroma::EulerImplicitSolver>("EulerImplicitSolver",
                                           "backward Euler or trapezoidal rule, one linear solve or Newton");
}
