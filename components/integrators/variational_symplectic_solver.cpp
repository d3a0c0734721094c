// SPDX-License-Identifier: LGPL-2.1-or-later
// VariationalSymplecticSolver: steps that follow from a discrete principle of least action, so that the energy of an
// undamped body stays within a bound of its start for ever.
//
// With F = f + rK K v - rM M v as in EulerImplicitSolver. Implicit (the default), the midpoint rule, of second order:
//
//   M (v_m - v0) = h/2 F(x_m, v_m),   x_m = x0 + h/2 v_m;   x1 = x0 + h v_m,   v1 = 2 v_m - v0
//
// Explicit (explicitIntegration), symplectic Euler, of first order: v1 = v0 + h M^-1 f(x0), x1 = x0 + h v1; it warns of
// a step above its stable one and has no Rayleigh damping.
//
// Source: L. Kharevych et al., "Geometric, variational integrators for computer animation", 2006. Attribute names are
// SOFA's. There newtonError is an absolute length and its default of 0.01 ends most steps after one iteration; here it
// is the residual relative to the forces where the step starts, 1e-8, because what the method keeps it keeps only where
// its equations are solved; steps is the largest number of Newton iterations, 25 where SOFA has 5.
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
#include <algorithm>

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
    implicit_.stepTaken();
  }
  void sceneChanged() override { sleep_.wake(); }
  bool keepsEnergy() const override { return true; }
  std::string describe() const override {
    return (is_explicit_ ? explicit_.describe() : "implicit midpoint step" + implicit_.describe()) + sleep_.describe();
  }
  void reset() override {
    started_ = false;
    implicit_.reset(), sleep_.reset();
  }
  void serialize(Archive& archive) override {
    implicit_.serialize(archive), sleep_.serialize(archive);
    archive.value("started", started_);
    archive.value("potential", potential_);
  }

 private:
  StepReport implicitStep(System& system, const StepContext& context);
  void noteEnergy(System& system);

  bool is_explicit_ = false, computes_hamiltonian_ = true, incremental_ = true, saves_energy_ = false;
  std::string file_;
  double hamiltonian_ = 0;
  ImplicitStep implicit_;
  ExplicitStep explicit_;
  Sleep sleep_;
  std::vector<Vec3> momenta_;  ///< of turning bodies
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
  StepReport report = is_explicit_ ? explicit_.step(system, context) : implicitStep(system, context);
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
    implicit_.bodies().setVelocities(system.x, momenta_, v);
  }
  system.setTime(context.t_end);
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
