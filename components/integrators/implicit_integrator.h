// SPDX-License-Identifier: LGPL-2.1-or-later
// Base of integrators with implicit steps, whose bodies may sleep.
#pragma once
#include <fmt/format.h>

#include "components/integrators/implicit_step.h"
#include "components/integrators/sleep.h"

namespace stroma {

/// A rule implements: declare(), which calls declareSolvers(), sleep_.declare() and the declarations of damping and
/// conditions it supports; compile(), which calls compileStep(); step(), which first calls sleep_.passesOver(), then solves with
/// its scheme and returns sleep_.judged() of the report; describe(), from described(). It derives from FindsMultipliers if it
/// supports constraint forces, and overrides keepsEnergy() if its equations conserve energy. A rule with more state overrides
/// reset() and serialize(), which call those below, and stepTaken(), in the same order; a skipped step stores rest.
class ImplicitIntegrator : public Integrator, public AsksRightSides, public RespectsStepLimits {
 public:
  bool respectsStepLimits() const override { return implicit_.iterates(); }
  std::string howToRespectStepLimits() const override { return fmt::format("newtonIterations=\"{}\"", ImplicitStep::enough_with_limits); }
  /// Sleep comes first, because it knows whether the step was skipped. Nothing was solved in that case, and the energies,
  /// tangent and constraint forces that the second call would store belong to an older step.
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
