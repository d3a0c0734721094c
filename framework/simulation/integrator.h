// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/linear_solver.h"
#include "framework/scene/component.h"
#include "framework/simulation/input.h"
#include "framework/simulation/step.h"

namespace stroma {

class State;
class System;

/// The role of an integrator that moves x and v by a matrix and loads that it has precomputed, and owns the
/// states. These cannot change while the scene runs, but inputs act: it reads System::inputs() in its steps, and
/// Integrator::sceneChanged() tells it of other nodes, stiffnesses or dampings. Its steps begin themselves
/// (System::beginStep()), find what is not finite, and leave x and v as they were when they are given up. They may leave
/// rows behind until complete(), so that a step costs nothing that grows with nodes that nobody reads.
class StateOwner {
 public:
  virtual ~StateOwner() = default;
  /// Brings the rows that steps have left behind up to date.
  virtual void complete(System& system) = 0;
  /// Throws ComponentError when this input cannot act on a state; its own numbers are good.
  virtual void checkInputOn(const State& state, const Input& input) const = 0;
};

/// Moves a System through a step. A node's integrator owns every state of its node and below.
class Integrator : public Component {
 public:
  std::string roleText() const override { return "integrator"; }
  /// The linear solver of the steps: the one that the attribute `linearSolver` names, else the
  /// one in the same node. Null if there is none, and for integrators without the attribute. Several
  /// integrators may share one.
  LinearSolver* linearSolver() const {
    if (!uses_linear_solver_) return nullptr;
    return linear_solver_.target() ? linear_solver_.get() : find<LinearSolver>();
  }
  std::string missingPartner() const override;
  /// Called at load, and again after a change between steps: allocate every vector the steps need; check that the
  /// system has what the method needs.
  virtual void compile(System& system) = 0;
  /// Called after a change of an attribute or of inputs between steps, when compiled and with the state of serialize()
  /// restored: discards conclusions about the scene as it was.
  virtual void sceneChanged() {}
  /// From x and v where the step starts to those at its end, after System::beginStep() unless it is a StateOwner. A step
  /// that fails, here or in another system, is not taken: x and v are then put back, and nothing else is. What
  /// serialize() knows must therefore be such that the same step can be tried again and ends with the same bits; what a
  /// step changes of it belongs into stepTaken().
  virtual StepReport step(System& system, const StepContext& context) = 0;
  /// The steps of all systems succeeded: keeps what later steps need from the one just made.
  virtual void stepTaken(const StepContext& /*context*/) {}
  /// False for statics: a step then has no velocities that a position constraint could correct.
  virtual bool movesInTime() const { return true; }
  /// True for a rule that conserves the energy of a linear body: a gain is then an error that nothing else shows.
  virtual bool keepsEnergy() const { return false; }
  /// False for implicit rules of second order: a force lagging by a step excites motions that they hardly damp.
  virtual bool toleratesLaggedForces() const { return !keepsEnergy(); }
  /// Itself, when it is one; null for integrators that read forces, masses and constraints as they are.
  virtual StateOwner* stateOwner() { return nullptr; }
  const StateOwner* stateOwner() const { return const_cast<Integrator*>(this)->stateOwner(); }
  /// A sentence on why the steps so far may not be a valid result, or empty.
  virtual std::string doubt() const { return {}; }
  /// One line for `explain`: what a step does.
  virtual std::string describe() const = 0;

 protected:
  /// The attribute `linearSolver`, for integrators that solve linear systems. `always`: every step needs it.
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
