// SPDX-License-Identifier: LGPL-2.1-or-later
// VariationalSymplecticSolver: steps derived from a discrete principle of least action, so that the energy of an undamped body
// stays within a bound of its initial value.
//
// With F = f + rK K v - rM M v as in EulerImplicitSolver. Implicit (the default), the midpoint rule, of second order:
//
//   M (v_m - v0) = h/2 F(x_m, v_m),   x_m = x0 + h/2 v_m;   x1 = x0 + h v_m,   v1 = 2 v_m - v0
//
// Explicit (explicitIntegration), symplectic Euler, of first order: v1 = v0 + h M^-1 f(x0), x1 = x0 + h v1; it warns of
// a step above its stable one and has no Rayleigh damping.
//
// With byPositions, as in SOFA, a step starts with the momentum p at the end of the previous one, at first M v0, and ends its
// iterations when r = x_m - x0 changes by less than newtonError of |x0|, or of itself if that is 0. Velocities are those of
// the midpoint:
//
//   ((4/h^2 + 4 rM/h) M - (1 + 4 rK/h) K) r' = f(x0 + r) - K r + 2/h p,   v1 = 2 r/h,   x1 = x0 + h v1,   p1 = M v1 + h/2 f(x0 + r)
//
// Forces use the v of the previous step, without a derivative in the matrix. A change of v between steps changes p by M times
// as much. Prescribed nodes have the rule above. hamiltonianEnergy then has the midpoint's velocity and the end's U.
//
// Source: L. Kharevych et al., "Geometric, variational integrators for computer animation", 2006. Attribute names are SOFA's.
// There newtonError is an absolute length and its default of 0.01 ends most steps after one iteration; here it is the residual
// relative to the forces where the step starts, 1e-8, because the conservation properties only hold if its equations are
// solved; steps is the largest number of Newton iterations, 25 where SOFA has 5.
//
// hamiltonianEnergy is kinetic energy + U after a step (computeHamiltonian). U is followed by the work of the forces at
// the midpoints, U += -f(x_m).(x1 - x0), from the potential energy of the start (useIncrementalPotentialEnergy, also
// for forces without a potential), or is the potential energy of gravity and force fields. Energies go to a file by
// EnergyMonitor.
//
// With sleepDistance a body at rest is not computed, exactly until something changes; sleep.h has the rule.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <VariationalSymplecticSolver newtonError="1e-10" steps="20"/>
//   <CGLinearSolver iterations="50" tolerance="1e-12"/>
//   <MechanicalObject position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "components/integrators/explicit_step.h"
#include "components/integrators/implicit_step.h"
#include "components/integrators/sleep.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class VariationalSymplecticSolver final : public Integrator {
 public:
  VariationalSymplecticSolver() { implicit_.newton_settings.iterations = 25; }
  void declare(DataTable& table) override;
  void init() override;
  void compile(System& system) override;
  StepReport step(System& system, const StepContext& context) override;
  void stepTaken(const StepContext& context) override {
    if (sleep_.stepTaken(context.dt)) return;
    potential_ = new_potential_;
    started_ = true;
    if (goes_by_positions_) {
      copy(new_momentum_, momentum_);
      copy(new_velocity_, left_velocity_);
      has_momentum_ = true;
    }
    implicit_.stepTaken();
  }
  void sceneChanged() override { sleep_.wake(); }
  bool keepsEnergy() const override { return !goes_by_positions_ || is_explicit_; }
  std::string describe() const override {
    if (goes_by_positions_ && !is_explicit_)
      return "implicit midpoint step of momenta, up to " + std::to_string(implicit_.newton_settings.iterations) + " linear solves" +
             sleep_.describe();
    return (is_explicit_ ? explicit_.describe() : "implicit midpoint step" + implicit_.describe()) + sleep_.describe();
  }
  void reset() override {
    started_ = has_momentum_ = false;
    implicit_.reset(), sleep_.reset();
  }
  void serialize(Archive& archive) override {
    implicit_.serialize(archive), sleep_.serialize(archive);
    archive.value("started", started_);
    archive.value("potential", potential_);
    if (!goes_by_positions_) return;
    archive.value("has_momentum", has_momentum_);
    archive.rows("momentum", momentum_);
    archive.rows("left_velocity", left_velocity_);
  }

 private:
  StepReport implicitStep(System& system, const StepContext& context);
  StepReport momentumStep(System& system, const StepContext& context);
  StepReport shareMomenta(System& system, const StepContext& context, StepReport report);
  void noteEnergy(System& system);

  bool is_explicit_ = false, computes_hamiltonian_ = true, incremental_ = true, saves_energy_ = false;
  std::string file_;
  double hamiltonian_ = 0;
  ImplicitStep implicit_;
  ExplicitStep explicit_;
  Sleep sleep_;
  bool by_positions_ = false, goes_by_positions_ = false;  ///< as it is asked for, and as it is
  Vector momentum_, new_momentum_;  ///< p and p1 [kg m/s], shape (independentRows()); only goes_by_positions_
  Vector left_velocity_, new_velocity_;  ///< v that the last step, and this one, ended with
  Vector way_, new_way_, load_;     ///< r, r', what makes r'
  bool has_momentum_ = false;
  std::vector<Vec3> momenta_;  ///< of turning bodies
  Acceleration acceleration_;
  Vector lack_, shared_;       ///< L1 - J1 v1 and what it changes v1 by, where masses follow turning bodies
  Vector start_;               ///< x before the step, shape (independentRows())
  double potential_ = 0;       ///< U [J]
  double new_potential_ = 0;   ///< after the step just made
  bool started_ = false;       ///< potential_ is that of the state
};

void VariationalSymplecticSolver::declare(DataTable& table) {
  table.add("newtonError", implicit_.newton_settings.relative_residual)
      .help("residual at which Newton's method ends, relative to the forces where the step starts")
      .unit("-")
      .min(0, false);
  table.add("steps", implicit_.newton_settings.iterations).help("largest number of Newton iterations").unit("-").min(1);
  implicit_.declareDamping(table);
  table.add("byPositions", by_positions_)
      .help("newtonError is the change of positions relative to their size, and damping is in the matrix only, as in SOFA");
  table.add("explicitIntegration", is_explicit_).help("symplectic Euler instead of the implicit midpoint rule");
  table.add("computeHamiltonian", computes_hamiltonian_).help("compute hamiltonianEnergy after each step");
  table.add("hamiltonianEnergy", hamiltonian_).help("kinetic and potential energy after the step").unit("J").output();
  table.add("useIncrementalPotentialEnergy", incremental_)
      .help("follow the potential energy by the work of the forces, instead of asking the force fields for it");
  table.add("saveEnergyInFile", saves_energy_).help("not available: EnergyMonitor writes energies");
  table.add("file", file_).help("see saveEnergyInFile");
  declareLinearSolver(table);
  implicit_.declareNewtonSolver(table);
  sleep_.declare(table);
  table.addVisualOnly("threadSafeVisitor");
}

void VariationalSymplecticSolver::init() {
  if (saves_energy_)
    throw ComponentError("an integrator writes no files", "saveEnergyInFile=\"false\" and an EnergyMonitor",
                         "add <EnergyMonitor filename=\"energy.txt\"/>");
  if (is_explicit_ && (implicit_.rayleigh_mass != 0 || implicit_.rayleigh_stiffness != 0))
    throw ComponentError("the explicit variant has no damping", "no rayleighMass and no rayleighStiffness",
                         "explicitIntegration=\"false\"");
}

void VariationalSymplecticSolver::compile(System& system) {
  start_.resize(system.independentRows());
  sleep_.compile(system);
  if (computes_hamiltonian_ && incremental_) system.requestForce();
  if (!is_explicit_) {
    implicit_.compile(*this, system);
    goes_by_positions_ = by_positions_;
    if (by_positions_ && (implicit_.hasConditions() || implicit_.bodies().anyTurns()))
      throw ComponentError("byPositions is not for constraints by forces, and not for frames whose inertia turns",
                           "byPositions=\"false\"", "byPositions=\"false\"");
    for (const ProjectiveConstraint* constraint : system.constraints().all())
      if (goes_by_positions_ && constraint->prescribesMotion()) {
        warn(fmt::format("byPositions is not for nodes whose motion is prescribed, as {} does: the midpoint rule has their velocities",
                         constraint->path()),
             "byPositions=\"false\"");
        goes_by_positions_ = false;
      }
    if (goes_by_positions_)
      for (Vector* vector : {&momentum_, &new_momentum_, &left_velocity_, &new_velocity_, &way_, &new_way_, &load_})
        vector->resize(system.independentRows());
    if (system.hasCurvedInertia() && !implicit_.bodies().empty()) {
      acceleration_.compile(system, "the midpoint rule of turning bodies");
      for (Vector* vector : {&lack_, &shared_}) vector->resize(system.independentRows());
    }
    return momenta_.assign(implicit_.bodies().count(), Vec3::Zero());
  }
  explicit_.scheme = fromRungeKutta("symplectic Euler", {{}}, {1});
  explicit_.scheme.x = {1};
  explicit_.compile(*this, system);
}

StepReport VariationalSymplecticSolver::step(System& system, const StepContext& context) {
  if (sleep_.passesOver(context)) {
    if (computes_hamiltonian_) hamiltonian_ = potential_;
    return {};
  }
  new_potential_ = potential_;
  if (computes_hamiltonian_ && incremental_ && !started_) new_potential_ = system.potentialEnergy(system.x);
  copy(system.independent(system.x), start_);
  StepReport report = is_explicit_   ? explicit_.step(system, context)
                      : goes_by_positions_ ? momentumStep(system, context)
                                      : implicitStep(system, context);
  if (!report.failed() && computes_hamiltonian_) noteEnergy(system);
  return sleep_.judged(report);
}

StepReport VariationalSymplecticSolver::implicitStep(System& system, const StepContext& context) {
  const double h = context.dt;
  ImplicitScheme scheme;
  scheme.weight = scheme.displacement = scheme.drift = h / 2;
  scheme.time = (context.t + context.t_end) / 2;
  StepReport report = implicit_.solve(scheme, context.stop);
  if (report.failed()) return report;
  const Rows v = system.independent(system.v);
  system.motion().advance(h / 2, v, system.x);
  axpy(1, implicit_.change(), v);
  if (!implicit_.bodies().empty()) {  // L1 = 2 L_m - L0
    for (std::size_t b = 0; b < momenta_.size(); ++b)
      momenta_[b] = 2 * implicit_.endMomenta()[b] - implicit_.startMomenta()[b];
    if (system.hasCurvedInertia()) return shareMomenta(system, context, report);
    implicit_.bodies().setVelocities(system.x, momenta_, v);
  }
  system.setTime(context.t_end);
  return report;
}

/// Masses that follow turning bodies take a part of what J changes by in the step: (J + M) dv = L1 - J1 v1.
StepReport VariationalSymplecticSolver::shareMomenta(System& system, const StepContext& context, StepReport report) {
  const TurningBodies& bodies = implicit_.bodies();
  const Rows v = system.independent(system.v);
  clear(lack_), clear(shared_);
  for (std::size_t b = 0; b < momenta_.size(); ++b)
    lack_[bodies.row(b)] = momenta_[b] - bodies.times(b, system.x, v[bodies.row(b)]);
  if (acceleration_.solveForMomenta(system.x, lack_, shared_, context.stop, report)) axpy(1, shared_, v);
  system.setTime(context.t_end);
  return report;
}

/// From start_, the positions of the step's start.
StepReport VariationalSymplecticSolver::momentumStep(System& system, const StepContext& context) {
  const NewtonSettings& settings = implicit_.newton_settings;
  const double h = context.dt, size = norm(start_);
  const Rows x = system.independent(system.x), v = system.independent(system.v);
  const auto place = [&](double share, ConstRows way) {
    copy(start_, x);
    system.motion().advance(share, way, x);
  };
  if (!has_momentum_) clear(momentum_), clear(left_velocity_);
  copy(v, way_);
  axpy(-1, left_velocity_, way_);
  if (largest(way_) > 0) {  // somebody has changed it
    system.addMassProduct(way_, 1, momentum_);
    copy(v, left_velocity_);
  }
  has_momentum_ = true;
  MatrixFactors factors;
  factors.mass = 4 / (h * h) + 4 * implicit_.rayleigh_mass / h;
  factors.stiffness = -1 - 4 * implicit_.rayleigh_stiffness / h;
  system.setTime(context.t_end);
  clear(way_);
  StepReport report;
  double change = 0;
  for (int i = 0; i < settings.iterations && (i == 0 || change > settings.relative_residual); ++i) {
    system.computeForce(system.x, system.v, system.f);
    copy(system.independent(system.f), load_);
    axpy(2 / h, momentum_, load_);
    system.addStiffnessProduct(way_, {.stiffness = -1}, load_);
    system.constraints().project(load_);
    SystemMatrix& matrix = implicit_.whole(system.matrix().withFactors(factors));
    if (!solveOrShift(implicit_.linearSolver(), matrix, load_, new_way_, {.stop = context.stop}, report, {.result = &system}))
      return report;
    system.constraints().project(new_way_);
    change = distance(new_way_, way_) / (size > 0 ? size : std::max(norm(new_way_), std::numeric_limits<double>::min()));
    copy(new_way_, way_);
    place(1, way_);
    ++report.newton_iterations;
  }
  report.newton_residual = change;
  report.newton_converged = change <= settings.relative_residual;
  if (!report.newton_converged)
    report.reason = fmt::format("positions still change by {:.2g} of themselves after {} iterations", change, settings.iterations);
  copy(way_, v);
  scale(2 / h, v);
  copy(v, new_velocity_);
  system.computeForce(system.x, system.v, system.f);
  copy(system.independent(system.f), new_momentum_);
  system.constraints().project(new_momentum_);
  scale(h / 2, new_momentum_);
  system.addMassProduct(v, 1, new_momentum_);
  place(2, way_);
  return report;
}

/// System::f holds the forces of the step's midpoint (explicit: of its start).
void VariationalSymplecticSolver::noteEnergy(System& system) {
  if (incremental_) {
    system.motion().difference(system.independent(system.x), start_);
    for (Index i = 0; i < system.independentRows(); ++i) new_potential_ -= system.f[i].dot(start_[i]);
  } else {
    new_potential_ = system.potentialEnergy(system.x);
  }
  hamiltonian_ = system.kineticEnergy() + new_potential_;
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(variational_symplectic_solver) {
  factory.add<stroma::VariationalSymplecticSolver>("VariationalSymplecticSolver",
                                                   "implicit midpoint rule or symplectic Euler, energies");
}
