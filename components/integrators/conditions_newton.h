// SPDX-License-Identifier: LGPL-2.1-or-later
// Newton's method for the balance of forces and the conditions of Lagrangian constraints at once,
//
//   R(u) + J(x)^T p = 0,   g(x(u)) = 0 (or the inequalities of what pushes and rubs)
//
// With q = J^T p of the iterate before and A = -dR/du there, an iteration is A d = R + q, u += d, and the correction of
// multipliers.h with the same A and J^T, from which q comes anew. No iteration goes further than the first one; and where the
// conditions hold already, |R + q| must fall, or u and q go a share of their way. What is not there after four iterations,
// because A lacks a part of the turning of stresses and of forces of constraint, goes on with iterates mixed (mixing.h). Where the
// closest point is on an edge, iterates may go to and fro between its sides for ever. Where |R + q| has not become half of its
// least for twelve iterations, the way turns, and it is shorter than what all conditions tolerate
// (LagrangianConstraint::tolerance()), the method ends and says with which residual: it has not converged. At its limit it leaves
// what the last correction found.
//
// A body that is decades lighter than others is out of balance where the |R + q| of all is little (light_bodies.h). From where one is
// found, |R + q| is the root of |R + q|^2 + s^2 sum (|R_b + q_b| / S_b)^2, with the scale s of all, in all that is said here.
#pragma once
#include <string>

#include "components/integrators/multipliers.h"
#include "components/integrators/newton.h"

namespace stroma {

class ConditionsNewton {
 public:
  /// R of `problem` has the forces that are carried, which are added to `load`, shape (rows). The unknowns of `problem` add up.
  void compile(System& system, NonlinearProblem& problem, Multipliers& multipliers, Rows load);
  /// From the problem's current iterate, after Multipliers::begin(). `report`: of what has been done before in the step.
  /// Settings and history are those of `newton`.
  StepReport solve(Newton& newton, LinearSolver& solver, StopToken stop, StepReport report);

  /// An iterate of the last solve() had elements without an energy, turned inside out, and was drawn back.
  bool wasCrushed() const { return was_crushed_; }

 private:
  bool iterate(Newton& newton, LinearSolver& solver, double& now, StopToken stop, StepReport& report);
  void noteSwing(double now);
  void goWhereFinite(double& now);
  void goShare(double share);
  void goMixed(double& now);
  double residual();
  double size() const;
  std::string tellLeft(const NewtonSettings& settings) const;
  bool isLittle(const NewtonSettings& settings, double residual) const;
  bool isAllLittle(const NewtonSettings& settings);  ///< and of each light body
  bool isBalanced(const NewtonSettings& settings, double residual, StepReport& report);
  bool areBodiesBalanced(const NewtonSettings& settings);

  NonlinearProblem* problem_ = nullptr;
  Multipliers* multipliers_ = nullptr;
  Rows load_{};
  Vector residual_, direction_, last_;  ///< R + q, a correction and the iterate before it
  Vector way_;                          ///< of the last correction
  Vector unmixed_, unmixed_forces_;     ///< the iterate before it was mixed, and what it carried
  double scale_ = 0;    ///< the largest of |R| and loadScale() where the step starts and of |q| so far
  double longest_ = 0;  ///< way of the first iteration [m]; 0: there was none
  double moved_ = 0;    ///< way of the last iteration [m]
  bool holds_ = false;  ///< the conditions do, with the forces that are carried
  bool was_crushed_ = false;
  bool swings_ = false;  ///< by less than what is tolerated
  double least_ = 0;     ///< |R + q| of those that were half of all before them, with the conditions
  int least_at_ = 0;     ///< its iteration
  int iterations_ = 0;
  const State* left_ = nullptr;  ///< out of balance by itself where all together were not, the last time
  Mixing mixing_;
};

}  // namespace stroma
