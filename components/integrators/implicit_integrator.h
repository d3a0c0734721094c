// SPDX-License-Identifier: LGPL-2.1-or-later
// What integrators have in common that make one implicit step at a time of a body that may fall asleep.
#pragma once
#include "components/integrators/implicit_step.h"
#include "components/integrators/sleep.h"

namespace stroma {

/// What a rule adds: declare(), in which it calls declareSolvers(), sleep_.declare() and what it has of damping and of
/// conditions; compile(), which calls compileStep(); step(), which asks sleep_.passesOver() first, solves with its scheme and
/// returns sleep_.judged() of the report; describe(), from described(). FindsMultipliers where it takes forces of constraints;
/// keepsEnergy() where its equations do. A rule that remembers more overrides reset() and serialize(), which call those below,
/// and stepTaken(), in the same order, with what it remembers of a step that was passed over: rest.
class ImplicitIntegrator : public Integrator, public AsksRightSides, public HeedsStepLimits {
 public:
  bool heedsStepLimits() const override { return implicit_.iterates(); }
  std::string howToHeedStepLimits() const override { return "newtonIterations=\"30\""; }
  /// Sleep is asked first, as it alone knows whether the step was passed over: then nothing was solved, and the last solve's
  /// energies, tangent and forces of constraints, which the second call takes over, are those of an older step.
  void stepTaken(const StepContext& context) override {
    if (!sleep_.stepTaken(context.dt)) implicit_.stepTaken();
  }
  void sceneChanged() override {
    sleep_.wake();
    implicit_.sceneChanged();
  }
  std::string doubt() const override { return implicit_.doubt(path()); }
  void reset() override {
    implicit_.reset();
    sleep_.reset();
  }
  void serialize(Archive& archive) override {
    implicit_.serialize(archive);
    sleep_.serialize(archive);
  }

 protected:
  void declareSolvers(DataTable& table) {
    implicit_.declareNewton(table);
    declareLinearSolver(table);
    implicit_.declareNewtonSolver(table);
  }
  void compileStep(System& system, bool second_order) {
    implicit_.second_order = second_order;
    implicit_.compile(*this, system);
    sleep_.compile(system);
  }
  std::string described(const std::string& rule) const { return rule + implicit_.describe() + sleep_.describe(); }

  ImplicitStep implicit_;
  Sleep sleep_;
};

}  // namespace stroma
