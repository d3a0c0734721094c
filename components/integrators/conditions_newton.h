// SPDX-License-Identifier: LGPL-2.1-or-later
// Newton's method for force balance together with the conditions of Lagrangian constraints,
//
//   R(u) + J(x)^T p = 0,   g(x(u)) = 0 (or the inequalities of contact and friction)
//
// With q = J^T p and A = -dR/du at the previous iterate, an iteration solves A d = R + q, sets u += d, and applies the correction of
// multipliers.h with the same A and J^T, which updates q. No iteration moves farther than the first one. Once the conditions hold,
// |R + q| must decrease, or u and q move only a fraction of the way. If it has not converged after four iterations, because A lacks part
// of the geometric stiffness of stresses and constraint forces, it continues with Anderson acceleration (mixing.h). If the closest point
// is on an edge, iterates may alternate between its sides for ever. The method therefore also ends, as not converged and with its
// residual, if |R + q| has not halved its minimum in twelve iterations while the direction alternates and the steps are shorter than
// the tolerance of all conditions (LagrangianConstraint::tolerance()). At its iteration limit it keeps the result of the last
// correction.
//
// A body that is orders of magnitude lighter than others can be out of balance while the total |R + q| is small (light_bodies.h). Once
// such a body is found, |R + q| above means the root of |R + q|^2 + s^2 sum (|R_b + q_b| / S_b)^2, with the scale s of the whole system.
#pragma once
#include <string>

#include "components/integrators/multipliers.h"
#include "components/integrators/newton.h"

namespace stroma {

class ConditionsNewton {
 public:
  /// R of `problem` includes the constraint forces, which are added to `load`, shape (rows). The unknowns of `problem` are additive.
  void compile(System& system, NonlinearProblem& problem, Multipliers& multipliers, Rows load);
  /// Starts at the problem's current iterate, after Multipliers::begin(). `report`: of the step so far.
  /// Settings and history are those of `newton`.
  StepReport solve(Newton& newton, LinearSolver& solver, StopToken stop, StepReport report);

  /// An iterate of the last solve() had elements without an energy, turned inside out, and was drawn back.
  bool wasCrushed() const { return was_crushed_; }

 private:
  bool iterate(Newton& newton, LinearSolver& solver, double& now, StopToken stop, StepReport& report);
  void noteOscillation(double now);
  void goWhereFinite(double& now);
  void goShare(double share);
  void goMixed(double& now);
  double residual();
  double size() const;
  std::string tellLeft(const NewtonSettings& settings) const;
  bool isLittle(const NewtonSettings& settings, double residual) const;
  bool isAllLittle(const NewtonSettings& settings);  ///< including each light body
  bool isBalanced(const NewtonSettings& settings, double residual, StepReport& report);
  bool areBodiesBalanced(const NewtonSettings& settings);

  NonlinearProblem* problem_ = nullptr;
  Multipliers* multipliers_ = nullptr;
  Rows load_{};
  Vector residual_, direction_, last_;  ///< R + q, a correction and the iterate before it
  Vector way_;                          ///< displacement by the last correction
  Vector unmixed_, unmixed_forces_;     ///< the iterate before mixing, and its constraint forces
  double scale_ = 0;    ///< the largest of |R| and loadScale() at the start of the step and of |q| so far
  double longest_ = 0;  ///< displacement by the first iteration [m]; 0: there was none
  double moved_ = 0;    ///< displacement by the last iteration [m]
  bool holds_ = false;  ///< the conditions hold with the present forces
  bool was_crushed_ = false;
  bool swings_ = false;  ///< iterates alternate within the tolerance
  double least_ = 0;     ///< the last |R + q| that was half of all before it, with the conditions satisfied
  int least_at_ = 0;     ///< its iteration
  int iterations_ = 0;
  const State* left_ = nullptr;  ///< the light body that was last out of balance while the whole system was not
  Mixing mixing_;
};

}  // namespace stroma
