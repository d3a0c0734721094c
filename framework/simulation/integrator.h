// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/linear_solver.h"
#include "framework/scene/component.h"
#include "framework/simulation/input.h"
#include "framework/simulation/step.h"

namespace stroma {

class State;
class System;

/// The role of an integrator that moves x and v by a precomputed matrix and precomputed loads. Its bodies cannot change in a
/// run, but inputs act: it reads System::inputs() in its steps, and Integrator::sceneChanged() reports new nodes,
/// stiffnesses and dampings. Its steps call System::beginStep() themselves, detect non-finite values, and leave x and v
/// unchanged if they fail. They may defer rows until complete(), so that the cost of a step does not grow with nodes
/// that nobody reads.
class StateOwner {
 public:
  virtual ~StateOwner() = default;
  /// Brings deferred rows up to date.
  virtual void complete(System& system) = 0;
  /// Throws ComponentError if this input, whose numbers are valid, cannot act on a state.
  virtual void checkInputOn(const State& state, const Input& input) const = 0;
};

/// Moves a System through a step. The integrator of a node owns every state in its node and below.
class Integrator : public Component {
 public:
  std::string roleText() const override { return "integrator"; }
  /// The linear solver of the steps: the one named by the attribute `linearSolver`, otherwise the one in the same node. Null
  /// if there is none, and for integrators without the attribute. Several integrators may share
  /// one.
  LinearSolver* linearSolver() const {
    if (!uses_linear_solver_) return nullptr;
    return linear_solver_.target() ? linear_solver_.get() : find<LinearSolver>();
  }
  std::string missingPartner() const override;
  /// Called at load, and again after a change between steps: allocate every vector the steps need, and check that the
  /// system has what the method needs.
  virtual void compile(System& system) = 0;
  /// Called after a change of an attribute or of inputs between steps, after compilation and restoring of serialize():
  /// anything derived from the scene must be derived again.
  virtual void sceneChanged() {}
  /// Moves x and v from the start of a step to its end, after System::beginStep() unless it is a StateOwner. If a step fails,
  /// here or in another system, it is rejected: x and v are restored, and nothing else is. The data of serialize() must
  /// therefore allow the same step to be tried again with the same bits; changes of that data by a step belong in
  /// stepTaken().
  virtual StepReport step(System& system, const StepContext& context) = 0;
  /// The steps of all systems succeeded: stores whatever later steps need from this one.
  virtual void stepTaken(const StepContext& /*context*/) {}
  /// False for statics: a step then has no velocities that a position constraint could correct.
  virtual bool movesInTime() const { return true; }
  /// True for a rule that conserves the energy of a linear body: a gain is then an error that nothing else shows.
  virtual bool keepsEnergy() const { return false; }
  /// False for second-order implicit rules: a force that lags by a step excites motions that they hardly damp.
  virtual bool toleratesLaggedForces() const { return !keepsEnergy(); }
  /// Itself if it has this role; null for integrators that use forces, masses and constraints directly.
  virtual StateOwner* stateOwner() { return nullptr; }
  const StateOwner* stateOwner() const { return const_cast<Integrator*>(this)->stateOwner(); }
  /// A sentence on why the result of the steps so far may be invalid, or empty.
  virtual std::string doubt() const { return {}; }
  /// One line for `explain`: what a step does.
  virtual std::string describe() const = 0;

 protected:
  /// Declares `linearSolver`, for integrators that solve linear systems. `always`: every step needs one.
  void declareLinearSolver(DataTable& table, bool always = true) {
    uses_linear_solver_ = true;
    needs_linear_solver_ = always;
    table.addLink("linearSolver", linear_solver_)
        .help("the linear solver; without it, the one of the same node, else one that is made with its defaults");
  }

 private:
  bool uses_linear_solver_ = false, needs_linear_solver_ = false;
  Link<LinearSolver> linear_solver_{"linear solver"};
};

}  // namespace stroma
