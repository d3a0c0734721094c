// SPDX-License-Identifier: LGPL-2.1-or-later
// CentralDifferenceSolver: central differences in the form with velocities at the middle of steps; damping by the mass
// is implicit.
//
//   M (v+ - v-) / H = f(x0, v-) - rM M (v+ + v-) / 2,   x1 = x0 + h v+
//   so  v+ = ((1 - H rM/2) v- + H M^-1 f) / (1 + H rM/2)
//
// v- and v+ are the velocities at the middle of the last and of this step, H = (h_last + h) / 2 the time between them. The
// first step starts from the velocity at its beginning, with H = h/2: positions are then of second order. With firstStep =
// whole, as in SOFA, it has H = h, as if that velocity were half a step older: first order. The velocity after a step is that
// of its middle, as in SOFA; NewtonCotesSolver (degree 1) has the same positions without damping and velocities at the end of
// steps. Stable while h w < 2, w the highest angular frequency of the body, whatever rM is. Fixed nodes keep their initial
// velocity; with dampsHeld, as in SOFA, rM slows them down too. Above the estimated limit a warning is printed. With
// BarrierContact a step is subdivided where that is stiff; h and h_last are then those of the substeps.
//
// With sleepDistance a body at rest is not computed, exactly until something changes; sleep.h has the rule.
//
// Example:
// <Node name="root" dt="0.001" gravity="0 -9.81 0">
//   <CentralDifferenceSolver rayleighMass="0.1"/>
//   <MechanicalObject position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include "components/integrators/energy_watch.h"
#include "components/integrators/explicit_parts.h"
#include "components/integrators/explicit_step.h"
#include "components/integrators/sleep.h"
#include "components/integrators/stable_step.h"
#include "components/integrators/velocity_damping.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class CentralDifferenceSolver final : public Integrator, public RespectsStepLimits {
 public:
  bool respectsStepLimits() const override { return true; }
  void declare(DataTable& table) override;
  void compile(System& system) override;
  StepReport step(System& system, const StepContext& context) override;
  void stepTaken(const StepContext& context) override {
    energy_.stepTaken(), parts_.stepTaken();
    last_step_ = sleep_.stepTaken(context.dt) || !parts_.areNeeded() ? context.dt : parts_.before(context.dt);
  }
  void sceneChanged() override { sleep_.wake(), energy_.forget(); }
  std::string doubt() const override { return energy_.doubtOfSteps(path(), true); }
  std::string describe() const override {
    return "central differences, velocities at the middle of steps: 1 force evaluation, " + acceleration_.describe() +
           parts_.describe() + sleep_.describe();
  }
  void reset() override {
    last_step_ = 0;
    sleep_.reset(), parts_.reset(), energy_.forget();
  }
  void serialize(Archive& archive) override {
    archive.value("last_step", last_step_), parts_.serialize(archive);
    sleep_.serialize(archive), energy_.serialize(archive);
  }

 private:
  enum class FirstStep : int { half, whole };
  double rayleigh_mass_ = 0;
  FirstStep first_step_ = FirstStep::half;
  bool damps_held_ = false;
  StepReport makePart(System& system, const StepContext& part);
  void turnBodies(System& system, double h, double before);

  Acceleration acceleration_;
  ExplicitParts parts_;
  VelocityDamping velocity_damping_;
  Sleep sleep_;
  EnergyWatch energy_;
  Vector middle_;  ///< x, with the bodies as they are at the middle of a step
  Vector a_;
  std::vector<double> damping_;  ///< rM of each row [1/s], shape (independentRows())
  bool depends_on_time_ = false;
  double last_step_ = 0;  ///< [s]; 0: v is still that of the beginning
};

void CentralDifferenceSolver::declare(DataTable& table) {
  table.add("rayleighMass", rayleigh_mass_).recompiled().help("damping proportional to the mass").unit("1/s").min(0);
  table.addChoice("firstStep", first_step_, {"half", "whole"})
      .help("half: the first velocity is that at the start of the step; whole: that half a step before, as in SOFA");
  table.add("dampsHeld", damps_held_).help("rayleighMass also slows down the velocity of fixed nodes, as in SOFA");
  declareLinearSolver(table, false);
  velocity_damping_.declare(table);
  sleep_.declare(table);
  table.addVisualOnly("threadSafeVisitor");
}

void CentralDifferenceSolver::compile(System& system) {
  const std::string name = "the central difference method";
  depends_on_time_ = false;  // compiled again after an edit
  for (const ForceField* field : system.forceFields()) {
    depends_on_time_ = depends_on_time_ || field->traits().time_dependent;
    if (field->rayleigh_stiffness != 0)
      throw ComponentError(name + " has no damping by the stiffness, and " + field->path() + " has rayleighStiffness",
                           "an implicit integrator, or no such damping", "rayleighStiffness=\"0\"");
  }
  acceleration_.compile(system, name);
  sleep_.compile(system);
  energy_.compile(system, true);
  a_.resize(system.independentRows());
  middle_.resize(acceleration_.bodies().empty() ? 0 : system.allRows());
  damping_.assign(system.independentRows(), rayleigh_mass_);
  std::vector<double> rates(system.independentRows(), 0.0), weights = rates;
  for (const Mass* mass : system.masses()) {
    const Index first = mass->state().firstRow();
    if (first >= system.independentRows() && mass->rayleigh_mass != 0)
      throw ComponentError(mass->path() + " acts on a mapped state, where " + name + " has no rayleighMass",
                           "rayleighMass of the integrator");
    const auto differs = [mass](const Mass* other) {
      return &other->state() == &mass->state() && other->rayleigh_mass != mass->rayleigh_mass &&
             (mass->turns() || other->turns() || !mass->isDiagonal() || !other->isDiagonal());
    };
    if (std::any_of(system.masses().begin(), system.masses().end(), differs))
      throw ComponentError(mass->path() + " damps nodes that another mass, which turns or couples them, damps at another rate",
                           "rayleighMass of the integrator");
    // of several masses of a node the mean of their rates, by mass
    for (Index i = first; i < std::min(first + mass->state().size(), system.independentRows()); ++i) {
      const double own = mass->lumped()[std::size_t(i - first)];
      weights[i] += own;
      if (own > 0) rates[i] += (mass->rayleigh_mass - rates[i]) * (own / weights[i]);
    }
  }
  for (Index i = 0; i < system.independentRows(); ++i) damping_[i] += rates[i];
  parts_.compile(system, acceleration_, name, 2);
  warnAboveStableStep(*this, system, acceleration_, name, {.largest_angle = 2, .grows = false});
}

/// Of bodies whose inertia turns, a step changes the momentum, which is J w at the middle of steps; h- is the last one:
///   J(q+) w+ = J(q-) w- + J(q) a,   q- = exp(-h- w- / 2) q,   q+ = exp(h w+ / 2) q
void CentralDifferenceSolver::turnBodies(System& system, double h, double before) {
  const TurningBodies& bodies = acceleration_.bodies();
  if (bodies.empty()) return;
  copy(system.x, middle_);
  for (std::size_t b = 0; b < bodies.count(); ++b) {
    const Index row = bodies.row(b);
    const Vec3 w = system.v[row];
    Motion::turnBy(-before / 2 * w, middle_.rows().data + std::size_t(row) * row_doubles);
    const Vec3 momentum = bodies.times(b, middle_, w) + bodies.times(b, system.x, a_[row]);
    bodies.put(b, bodies.solve(b, system.x, h / 2 * w, h / 2, w, momentum, w + a_[row]) - w, a_);
  }
}

StepReport CentralDifferenceSolver::step(System& system, const StepContext& context) {
  energy_.stepBegins();
  if (sleep_.passesOver(context)) return {};
  StepReport report = parts_.areNeeded() ? parts_.run(context, [&](const StepContext& part) { return makePart(system, part); })
                                         : makePart(system, context);
  if (report.failed()) return report;
  velocity_damping_.apply(system, context.dt);
  return sleep_.judged(report);
}

StepReport CentralDifferenceSolver::makePart(System& system, const StepContext& context) {
  if (depends_on_time_) system.setTime(context.t);
  StepReport report;
  system.computeForce(system.x, system.v, system.f);
  const bool steps_momenta = !system.hasCurvedInertia();  // of bodies that carry no masses by a mapping
  if (steps_momenta ? !acceleration_.solveForMomenta(system.x, system.independent(system.f), a_, context.stop, report)
                    : !acceleration_.solve(system.x, system.v, system.independent(system.f), a_, context.stop, report))
    return report;
  if (depends_on_time_) system.setTime(context.t_end);
  parts_.setTime(context.t_end);
  const double h = context.dt, last = parts_.areNeeded() ? parts_.before(last_step_) : last_step_;
  const double before = last == 0 && first_step_ == FirstStep::whole ? h : last;
  const double between = (before + h) / 2;
  // a becomes v+ - v-, of which constraints let through what they leave free
  const auto factor = [&](Index row) { return between / (1 + between * damping_[row] / 2); };
  for (Index row = 0; row < system.independentRows(); ++row)
    a_[row] = factor(row) * (damps_held_ ? Vec3(a_[row]) : Vec3(a_[row] - damping_[row] * system.v[row]));
  system.constraints().projectAcceleration(a_);
  for (Index row = 0; damps_held_ && row < system.independentRows(); ++row) a_[row] -= factor(row) * damping_[row] * system.v[row];
  const Rows v = system.independent(system.v);
  if (steps_momenta) turnBodies(system, h, before);
  axpy(1, a_, v);
  system.motion().advance(h, v, system.x);
  return report;
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(central_difference_solver) {
  factory.add<stroma::CentralDifferenceSolver>("CentralDifferenceSolver", "central differences, rayleighMass implicit");
}
