// SPDX-License-Identifier: LGPL-2.1-or-later
// If Newton's method fails with an approximate tangent (rotations fixed in the derivative), it may converge with the exact
// derivative of the force: the solve is then repeated with it. If that helped, later steps of the run start with it,
// because they would fail in the same way and pay for that each time.
#pragma once
#include <algorithm>

#include "framework/algebra/linear_solver.h"
#include "framework/mechanics/open_choices.h"
#include "framework/scene/archive.h"
#include "framework/simulation/system.h"

namespace stroma {

/// Switches the force fields of a system from their approximate tangent to the exact one, for the rest of a solve. The
/// force is unchanged. Takes effect with the next force evaluation.
class ExactTangent {
 public:
  /// Returns false and changes nothing if no field has another tangent, or if the linear solver does not support the exact one.
  bool begin(System& system) { return begin(system, system.linearSolver()->needsSymmetric()); }
  /// The same for a solve that converges slowly, if the exact tangent is symmetric, so that the same linear solver
  /// works.
  bool beginForSpeed(System& system) {
    if (begin(system, true)) return true;
    is_slow_too_ = true;
    return false;
  }
  bool mayBeFaster(const System& system) const {
    const auto& fields = system.forceFields();
    return !isOn() && !is_slow_too_ &&
           std::any_of(fields.begin(), fields.end(), [](const ForceField* field) { return !field->traits().exact_tangent; });
  }
  /// It did not help.
  void noteSlow() { is_slow_too_ = true; }
  /// It was enabled for speed, and only pays up to this number of iterations of a solve.
  void limitIterations(double most) { most_iterations_ = most; }
  /// The last solve of the step, which started with it, took this many iterations. If they cost more than with the approximate
  /// tangent, the next step starts with that one; after the second time, this is permanent.
  bool isTooDear(int iterations) const { return isOn() && most_iterations_ > 0 && iterations > most_iterations_; }
  void letGo() {
    helped_ = false;
    is_slow_too_ = is_slow_too_ || was_let_go_;
    was_let_go_ = true;
    end();
  }
  void end() {
    if (!system_) return;
    for (ForceField* field : system_->forceFields()) switchOf(field, false);
    system_ = nullptr;
    most_iterations_ = 0;
  }
  bool isOn() const { return system_ != nullptr; }

  // ---- state of a run ----
  /// Selects the tangent at the start of a step.
  void choose(System& system) {
    helped_ = kept_;
    if (kept_)
      begin(system), most_iterations_ = kept_most_;
    else
      end();
  }
  /// Reports whether the step ended in equilibrium, and selects the tangent for the next step. Returns true if it changed:
  /// derivatives are still those of the last force.
  bool endStep(bool converged) {
    helped_ = isOn() && converged;
    if (!isOn() || helped_) return false;
    end();
    return true;
  }
  /// The step is taken: Integrator::stepTaken().
  void stepTaken() { kept_ = helped_, kept_most_ = most_iterations_; }
  void reset() {
    end();
    kept_ = helped_ = is_slow_too_ = was_let_go_ = false;
    kept_most_ = 0;
  }
  void serialize(Archive& archive) {
    archive.value("exact_tangent", kept_);
    archive.value("exact_tangent_no_faster", is_slow_too_);
    archive.value("exact_tangent_let_go", was_let_go_);
    archive.value("exact_tangent_iterations", kept_most_);
  }

 private:
  /// `symmetric`: fields whose exact tangent is not keep their own.
  bool begin(System& system, bool symmetric) {
    if (system_) return false;
    bool changed = false;
    for (ForceField* field : system.forceFields()) {
      if (field->traits().exact_tangent || !switchOf(field, true)) continue;
      const bool is_taken = !symmetric || field->traits().symmetric;
      if (!is_taken) switchOf(field, false);
      changed = changed || is_taken;
    }
    if (!changed) return false;
    system_ = &system;
    if (!symmetric || system.matrix().symmetric()) return true;
    end();
    return false;
  }
  static bool switchOf(ForceField* field, bool exact) {
    auto* open = dynamic_cast<OpenChoices*>(field);
    return open && open->useExactTangent(exact);
  }
  System* system_ = nullptr;
  bool helped_ = false;  ///< in the last step
  bool kept_ = false;    ///< steps start with it
  bool is_slow_too_ = false;  ///< it is not symmetric, or did not help when the approximate one was slow
  bool was_let_go_ = false;   ///< it was too expensive once
  double most_iterations_ = 0, kept_most_ = 0;  ///< see limitIterations(); 0: it is on because the other one failed
};

/// Whether the matrix of a system is the derivative of its forces, and symmetric.
inline bool hasExactTangents(const System& system) {
  const auto& fields = system.forceFields();
  return std::all_of(fields.begin(), fields.end(), [](const ForceField* field) {
    const auto traits = field->traits();
    return traits.exact_tangent && traits.symmetric;
  });
}

/// Estimated cost of an iteration of a linear solve with the present tangents [ns], with products of elements or of an
/// assembled matrix, whichever is cheaper. Only used in ratios.
inline double costOfIteration(const System& system) {
  constexpr double vectors = 32, assembled = 41, usual_products = 50;  // per row
  double product = 0, assembly = 0;
  for (const ForceField* field : system.forceFields()) {
    const ForceField::Cost cost = field->cost();
    product += cost.product, assembly += cost.assembly;
  }
  const double rows = double(system.independentRows());
  return std::min(product, assembled * rows + assembly / usual_products) + vectors * rows;
}

inline void declareExactTangentSteps(DataTable& table, int& steps) {
  table.add("exactTangentSteps", steps)
      .help(
          "how many steps so far failed, or got on slowly, with an approximate tangent of a force field and went on with the "
          "exact one, with which the steps after them begin")
      .unit("-")
      .output();
}

/// Switches all fields of a system that have a stiffness without unstable directions.
inline bool useDefiniteTangents(System& system, bool definite) {
  bool changed = false;
  for (ForceField* field : system.forceFields())
    if (auto* open = dynamic_cast<OpenChoices*>(field); open && open->useDefiniteTangent(definite)) changed = true;
  return changed;
}

/// Adds the work of another solve of the same step.
inline void addCounts(const StepReport& from, StepReport& to) {
  to.newton_iterations += from.newton_iterations;
  to.linear_iterations += from.linear_iterations;
  to.factorisations += from.factorisations;
  to.solve_seconds += from.solve_seconds;
}

/// The tangent of a porous field assumes that fluid stays in each element, while its force includes flow.
inline bool hasUndrainedTangent(const ForceField& field) {
  const Data* const coupling = field.data().find("coupling");
  const Data* const tangent = field.data().find("tangent");
  return coupling && tangent && coupling->print() == "implicit" && tangent->print() == "undrained";
}

/// A hint for the user if Newton's method converges slowly, or not at all, with an approximate tangent; or empty.
inline std::string exactTangentHint(const System& system, const StepReport& report) {
  for (const ForceField* field : system.forceFields())
    if (hasUndrainedTangent(*field))
      return "; the tangent of " + field->path() + " keeps the fluid in each element: tangent=\"coupled\" lets it flow";
  for (const ForceField* field : system.forceFields())
    if (field->traits().has_stiffness && !field->traits().exact_tangent && field->data().find("tangent") && !field->data().find("coupling"))
      return "; the tangent of " + field->path() +
             " is an approximation: tangent=\"exact\" may converge, with SparseLDLSolver where it is not symmetric";
  if (report.linear_stop == SolveStop::not_definite)
    return "; the stiffness has directions that are unstable, as beyond buckling or under a torque that does not turn with its frame: "
           "EigenSparseLU solves with them";
  return {};
}

}  // namespace stroma
