// SPDX-License-Identifier: LGPL-2.1-or-later
// Shared by explicit integrators: accelerations from forces, and steps as linear combinations of them.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "components/integrators/energy_watch.h"
#include "components/integrators/orientations.h"
#include "components/integrators/sleep.h"
#include "components/integrators/turning_bodies.h"
#include "components/integrators/velocity_damping.h"
#include "framework/algebra/linear_solver.h"
#include "framework/mechanics/step_limiter.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/system.h"

namespace stroma {

/// a = M^-1 f in the free directions: a diagonal M is inverted once, otherwise the linear solver of the node is
/// used.
class Acceleration {
 public:
  /// `method` is the subject of messages. Throws ComponentError if a mass or a required linear solver is
  /// missing.
  void compile(System& system, const std::string& method);
  /// f [N] at (x, v), shape (all rows), a [m/s^2], shape (independentRows()). Returns false if the solve failed: the report
  /// says why. For rotating bodies, J w' = torque - w x J w.
  bool solve(ConstRows x, ConstRows v, ConstRows f, Rows a, StopToken stop, StepReport& report);
  /// Without w x J w: for integrators that step the momentum of bodies().
  bool solveForMomenta(ConstRows x, ConstRows f, Rows a, StopToken stop, StepReport& report);
  const TurningBodies& bodies() const { return bodies_; }
  bool isDiagonal() const { return solver_ == nullptr; }
  std::string describe() const;

 private:
  System* system_ = nullptr;
  TurningBodies bodies_;
  Vector force_;                                       ///< minus w x J w, with rotating bodies
  LinearSolver* solver_ = nullptr;                     ///< null with a diagonal mass
  const std::vector<double>* inverse_mass_ = nullptr;  ///< owned by the system, which updates it with constraints
  Vector right_side_;                                  ///< of the solve
};

/// An explicit method for x'' = a(t, x, x') that evaluates a at stages i, with loads and prescribed motion at t + time_i h:
///   x_i = x0 + time_i h v0 + h^2 sum_j x_ij a_j,   v_i = v0 + h sum_j v_ij a_j   (j < i)
///   x1  = x0 + h v0 + h^2 sum_j x_j a_j,           v1  = v0 + h sum_j v_j a_j
struct ExplicitScheme {
  struct Stage {
    double time = 0;           ///< in steps
    std::vector<double> x, v;  ///< x_ij and v_ij, shape (i)
  };
  std::string name;           ///< as the subject of messages
  std::vector<Stage> stages;  ///< the first is the start of the step
  std::vector<double> x, v;   ///< x_j and v_j, shape (stages)
};

/// The stability of an explicit method for an undamped oscillator of angular frequency w.
struct StabilityLimit {
  double largest_angle = 2;  ///< stable for h w up to this value
  bool grows = false;        ///< unstable for any h w; at largest_angle by 1 % per step
};
/// From the eigenvalues of the 2 x 2 matrix of a step of the oscillator.
StabilityLimit stabilityLimit(const ExplicitScheme& scheme);

/// A Runge-Kutta method for first-order equations, `a` its coefficients row by row (below the diagonal), `b` its
/// weights, as a scheme: x_ij = (A A)_ij and x_j = (b A)_j.
ExplicitScheme fromRungeKutta(std::string name, const std::vector<std::vector<double>>& a,
                              const std::vector<double>& b);

class ExplicitParts;

class ExplicitStep {
 public:
  ExplicitScheme scheme;

  ExplicitStep();
  ~ExplicitStep();
  /// Allocates; warns if the time step is too large for the highest frequency of the elements. Fields that limit steps cause
  /// substeps (explicit_parts.h), if the integrator supports them.
  void compile(Integrator& integrator, System& system);
  StepReport step(System& system, const StepContext& context);
  std::string describe() const;
  void stepTaken();
  void reset();
  void serialize(Archive& archive);

 private:
  StepReport makePart(System& system, const StepContext& whole, const StepContext& part);
  void placeStage(System& system, const StepContext& whole, const StepContext& part, const ExplicitScheme::Stage& stage);
  /// Bodies with mapped masses change their velocity together with these, not only their momentum.
  bool stepsMomenta(const System& system) const { return scheme.stages.size() == 1 && !system.hasCurvedInertia(); }
  void finish(System& system, double h, double between);
  void noteRates(const System& system, std::size_t stage);
  void setTurns(const System& system, double h, const std::vector<double>& weights, Rows x) const;

  Acceleration acceleration_;
  std::unique_ptr<ExplicitParts> parts_;
  std::vector<Vector> accelerations_;  ///< a_j, each of shape (independentRows())
  Vector stage_x_, stage_v_;           ///< shape (allRows())
  Orientations orientations_;
  /// Orientations are stepped by their rotation vectors r from the start of the step, r' = dexp^-1(r) w (Munthe-Kaas 1998):
  /// r' at each stage, shape (stages, rotating rows); empty for one-stage schemes.
  std::vector<std::vector<Vec3>> rates_;
  std::vector<Vec3> momenta_;  ///< of rotating bodies, in one-stage schemes, which step them
  bool depends_on_time_ = false;
};

/// An integrator given by a scheme; a component supplies the scheme and its attributes. Bodies at rest may sleep (sleep.h).
class ExplicitIntegrator : public Integrator, public RespectsStepLimits {
 public:
  bool respectsStepLimits() const final { return true; }
  void declare(DataTable& table) override;  ///< linearSolver, and those of VelocityDamping and Sleep
  void compile(System& system) final;
  StepReport step(System& system, const StepContext& context) final;
  void stepTaken(const StepContext& context) final {
    energy_.stepTaken();
    if (!sleep_.stepTaken(context.dt)) explicit_.stepTaken();
  }
  void sceneChanged() final { sleep_.wake(), energy_.forget(); }
  void reset() final { sleep_.reset(), explicit_.reset(), energy_.forget(); }
  void serialize(Archive& archive) final { sleep_.serialize(archive), explicit_.serialize(archive), energy_.serialize(archive); }
  std::string doubt() const final { return energy_.doubtOfSteps(path(), explicit_.scheme.stages.size() == 1); }
  std::string describe() const final { return explicit_.describe() + sleep_.describe(); }

 protected:
  /// With its name; called once, after init().
  virtual ExplicitScheme scheme() const = 0;

 private:
  ExplicitStep explicit_;
  VelocityDamping velocity_damping_;
  Sleep sleep_;
  EnergyWatch energy_;
};

}  // namespace stroma
